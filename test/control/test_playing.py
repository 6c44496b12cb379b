"""Playing a protocol: its parts and instants, what is refused before it starts, and what ends it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tcp_muscle_ros.control.playing import LONGEST_HOLD, Allowed, Cold, Supervisor, instants, parts, refuse_beyond
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording.protocol import Protocol, Ramp, Segment

MUSCLE = Parameters.named('karami_tadesse_2017')


def protocol(*segments, rate=10.0, kind='current'):
    return Protocol(rate, kind, tuple(segments))


def segment(duration, value, load=None):
    return Segment(duration, Ramp(value, value), None if load is None else Ramp(load, load))


steps = st.builds(
    segment, st.floats(0.05, 3.0), st.floats(0.0, 0.27), st.one_of(st.none(), st.sampled_from([0.1, 0.3, 0.9]))
)


@given(st.lists(steps, min_size=1, max_size=6), st.sampled_from([0.7, 3.0, 20.0, 100.0]), st.booleans())
def test_parts_hold_every_tick_once_and_no_command_stays_unrepeated(segments, rate, by_person):
    made = protocol(*segments, rate=rate)
    if made.duration * rate < 1.0:
        return
    sampled = made.sampled()
    if by_person and np.any(np.diff(np.flatnonzero(np.diff(sampled.load))) == 1):
        with pytest.raises(BadInput, match='gradually'):
            parts(made, by_person)
        return
    found = parts(made, by_person)
    assert np.array_equal(np.concatenate([part.drive[:-1] for part in found]), sampled.drive[:-1])
    assert np.isclose(sum(part.time[-1] for part in found), sampled.time[-1])
    for part in found:
        assert part.time[0] == 0.0
        assert not by_person or np.ptp(part.load) == 0.0
        when, what, load = instants(part)
        assert len(when) == len(what) == len(load)
        assert np.all(np.diff(np.append(when, part.time[-1])) <= LONGEST_HOLD + 1e-9)
        assert np.all(np.diff(when) > 0.0)
        for time, drive in zip(part.time[:-1], part.drive[:-1], strict=True):
            assert what[np.argmin(np.abs(when - time))] == drive


def test_a_load_that_a_person_hangs_begins_a_part_and_one_that_the_rig_changes_does_not():
    made = protocol(segment(1.0, 0.1, 0.3), segment(1.0, 0.2, 0.6), segment(1.0, 0.0, 0.601))
    assert [part.load[0] for part in parts(made, by_person=True)] == [0.3, 0.6]
    (one,) = parts(made, by_person=False)
    assert set(one.load) == {0.3, 0.6, 0.601}


@pytest.mark.parametrize(('rate', 'lasts'), [(20.0, 60.0), (100.0, 20.0), (2.0, 60.0)])
def test_a_ramp_that_hardly_changes_from_tick_to_tick_is_for_no_person_either(rate, lasts):
    gradual = (segment(5.0, 0.1, 0.3), Segment(lasts, Ramp(0.1, 0.1), Ramp(0.3, 0.6)))
    with pytest.raises(BadInput, match='gradually from 5 s on'):
        parts(protocol(*gradual, rate=rate), by_person=True)
    (one,) = parts(protocol(*gradual, rate=rate), by_person=False)
    assert one.load[-1] == pytest.approx(0.6, rel=0.01)


def test_a_ramp_of_the_load_is_for_no_person():
    with pytest.raises(BadInput, match='gradually from 0'):
        parts(protocol(Segment(2.0, Ramp(0.1, 0.1), Ramp(0.1, 0.9))), by_person=True)


WIDE = Allowed(current=0.27, temperature=373.15)


@pytest.mark.parametrize(
    ('made', 'allowed', 'said'),
    [
        (protocol(segment(5.0, 0.3)), WIDE, '0.3 A, above the limit of 0.27 A of the rig'),
        (protocol(segment(5.0, 3.0), kind='power'), WIDE, 'A, above the limit of 0.27 A'),
        (protocol(segment(99.0, 0.27)), replace(WIDE, temperature=330.0), 'the model predicts'),
        (protocol(segment(5.0, 0.1, 0.9)), replace(WIDE, loads=(0.3, 0.588)), 'a load of 0.588399 N|a load of 0.9 N'),
        (protocol(segment(5.0, 0.1)), replace(WIDE, duration=4.0), 'lasts 5 s, but the longest run is 4 s'),
        (replace(protocol(segment(5.0, 0.1)), end='blocked'), replace(WIDE, held_end=False), 'cannot hold the end'),
        (protocol(segment(5.0, -0.1)), WIDE, 'only heated'),
    ],
)
def test_what_a_rig_or_a_driver_forbids_is_refused_before_anything_flows(made, allowed, said):
    with pytest.raises(BadInput, match=said):
        refuse_beyond(made, MUSCLE, allowed)


def test_what_is_allowed_is_foreseen():
    assert 300.0 < refuse_beyond(protocol(segment(5.0, 0.2)), MUSCLE, WIDE) < 373.15


def test_cold_is_near_the_ambient_or_no_change_any_more():
    noise = np.random.default_rng(0).normal(0.0, 0.3, 4000)
    for ambient, settles in ((296.0, 296.3), (296.0, 303.0)):
        cold, reached = Cold(ambient), None
        for k, now in enumerate(np.arange(0.0, 200.0, 0.05)):
            cold.measure(settles + 40.0 * np.exp(-now / 8.0) + noise[k], now)
            if cold.reached(now):
                reached = now
                break
        assert reached is not None
        assert 40.0 * np.exp(-reached / 8.0) < 1.5  # K: what is left of the heat


@given(
    st.lists(st.floats(0.01, 3.0), min_size=30, max_size=60),
    st.floats(0.01, 0.3),
    st.lists(st.integers(0, 1), min_size=60),
)
def test_a_measurement_that_goes_silent_ends_the_run_and_one_that_comes_does_not(gaps, usual, which):
    watch, now = Supervisor(400.0), 0.0
    for _ in range(4):
        now += usual
        watch.hear('temperature', now)
        watch.hear('force', now)
    watch.begin()
    last = {'temperature': now, 'force': now}
    for gap, one in zip(gaps, which, strict=False):
        now += gap
        silent = max(now - then for then in last.values())
        problem = watch.look(now)
        if silent > max(1.0, 5.0 * usual) + 1e-9:
            assert problem
        if problem:
            assert silent > max(1.0, 5.0 * usual) - 1e-9
            break
        name = ('temperature', 'force')[one]
        watch.hear(name, now)
        last[name] = now


def test_while_nobody_listened_no_gap_was_a_usual_one_and_nothing_fell_silent():
    watch = Supervisor(400.0)
    for now in (0.0, 0.1, 0.2):
        watch.hear('temperature', now)
    watch.listen_anew(60.0)
    for now in (60.0, 60.1):
        watch.hear('temperature', now)
    watch.begin()
    assert not watch.look(61.0)
    assert watch.look(61.2) == 'no temperature for 1.0 s'


@pytest.mark.parametrize('value', [400.0, 500.0, float('nan'), float('inf')])
def test_heat_ends_the_run_for_good(value):
    watch = Supervisor(400.0)
    watch.temperature(399.9)
    assert not watch.look(0.0)
    watch.temperature(value)
    watch.temperature(300.0)
    assert 'the limit' in watch.look(0.0)
    assert watch.overheated == np.isfinite(value), 'less current cools no thermometer that is broken'


def test_what_gets_hot_after_the_run_has_ended_is_not_why_it_did():
    watch = Supervisor(400.0)
    watch.end('disabled')
    watch.temperature(500.0)
    assert watch.look(0.0) == 'disabled' and not watch.overheated

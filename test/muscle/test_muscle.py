"""One muscle that steps and a whole recording at once: the same numbers every time, and mistakes refused."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import ENDS, KINDS, ZERO_CELSIUS, Muscle, Parameters, Reading, simulate
from tcp_muscle_ros.muscle import muscle as module
from tcp_muscle_ros.muscle.free_basis import basis

A = Parameters.named('karami_tadesse_2017')
NAN, INF = float('nan'), float('inf')
NOTHING = basis('free_stroke', 0.0, 2.0, 'force', 2).on(A, [-0.2, -0.2])  # shortens by more than there is
OPTIONS = {'load': {}, 'blocked': {'end': 'blocked'}, 'spring': {'end': 'spring', 'spring_rate': 60.0}}

rng = np.random.default_rng(20170102)
TIME = np.cumsum(rng.uniform(0.005, 0.2, 400))
CURRENT = rng.uniform(0.0, 0.4, TIME.size)
LOAD = rng.uniform(0.2, 1.0, TIME.size)
AMBIENT = ZERO_CELSIUS + rng.uniform(15.0, 30.0, TIME.size)


def stepped(end='load'):
    """The recording above, tick by tick as a node does it: first the past period, then the new input."""
    muscle = Muscle(A, load=LOAD[0], ambient=AMBIENT[0], **OPTIONS[end])
    readings = [muscle.reading(CURRENT[0])]
    for k in range(1, TIME.size):
        muscle.step(TIME[k] - TIME[k - 1], CURRENT[k - 1], load=LOAD[k - 1], ambient=AMBIENT[k - 1])
        readings.append(muscle.reading(CURRENT[k], load=LOAD[k], ambient=AMBIENT[k]))
    return readings


def simulated(end='load'):
    return simulate(A, TIME, CURRENT, load=LOAD, ambient=AMBIENT, **OPTIONS[end])


@pytest.mark.parametrize('end', ENDS)
def test_one_that_takes_the_place_of_another_moves_on_as_that_did(end):
    """As where a parameter is changed on the way: where it was before counts for nothing but its speed."""
    first = Muscle(A, load=0.5, **OPTIONS[end])
    for _ in range(500):
        speed = first.step(0.01, 0.25).velocity
    second = Muscle(A.replace(k0=1.1 * A['k0']), load=0.5, **OPTIONS[end])
    second.state[:] = first.state
    second.go_on_from(first)
    assert second.reading(0.25).velocity == speed
    assert second.step(0.01, 0.25).velocity == pytest.approx(speed, rel=0.1)


# --- one model -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize('end', ENDS)
def test_a_recording_is_its_ticks_bit_for_bit(end):
    readings, outputs = stepped(end), simulated(end)
    for name in set(Reading._fields) - {'velocity'}:
        column = np.array([getattr(reading, name) for reading in readings])
        np.testing.assert_array_equal(getattr(outputs, name), column, err_msg=name)


@pytest.mark.parametrize('end', ENDS)
def test_twice_the_same_is_the_same(end):
    first, second = simulated(end), simulated(end)
    for name in Reading._fields:
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    assert (first.heated, first.lost) == (second.heated, second.lost)


@pytest.mark.parametrize('effects', [(), ('hysteresis', 'creep', 'inertia', 'thermocouple_lag', 'airflow')])
@pytest.mark.parametrize('end', ENDS)
def test_a_recording_in_pieces_is_the_whole_bit_for_bit(end, effects, monkeypatch):
    muscle = A.with_effects(*effects)
    whole = simulate(muscle, TIME, CURRENT, load=LOAD, ambient=AMBIENT, **OPTIONS[end])
    monkeypatch.setattr(module, '_PIECE', 37)
    parts = simulate(
        muscle, TIME, CURRENT, load=LOAD, ambient=AMBIENT, only=('displacement', 'temperature', 'slack'), **OPTIONS[end]
    )
    for name in ('displacement', 'temperature', 'slack', 'heated', 'lost'):
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name), err_msg=name)
    assert parts.force.size == 0


@given(st.integers(1, TIME.size - 1))
def test_what_is_shown_does_not_depend_on_what_comes_later(count):
    part = simulate(A, TIME[:count], CURRENT[:count], load=LOAD[:count], ambient=AMBIENT[:count])
    np.testing.assert_array_equal(part.displacement, simulated().displacement[:count])


def test_a_reading_takes_no_time_and_leaves_no_trace():
    read, unread = Muscle(A, load=0.5), Muscle(A, load=0.5)
    for _ in range(20):
        for drive, kind in ((0.5, 'current'), (3.0, 'voltage'), (9.0, 'power')):
            assert read.reading(drive, kind, load=0.9).temperature == read.reading(load=0.5).temperature
        assert read.step(0.1, 0.27) == unread.step(0.1, 0.27)


def test_two_muscles_share_nothing():
    one, other = Muscle(A, load=0.5), Muscle(A, load=0.5)
    before = other.reading()
    one.step(25.0, 0.27, load=1.0, ambient=300.0)
    assert other.reading() == before


def test_the_input_at_k_holds_until_k_plus_one():
    outputs = simulate(A, [0.0, 1.0, 2.0], [0.27, 0.0, 0.0])
    assert outputs.current.tolist() == [0.27, 0.0, 0.0]
    assert outputs.temperature[0] == A['T0']
    assert outputs.temperature[1] == Muscle(A).step(1.0, 0.27).temperature
    assert outputs.temperature[2] < outputs.temperature[1]


def test_reset_is_a_new_muscle():
    used = Muscle(A, load=0.5)
    used.step(25.0, 0.27)
    used.reset()
    assert used.reading() == Muscle(A, load=0.5).reading()
    used.reset(350.0)
    assert used.reading() == Muscle(A, load=0.5, temperature=350.0).reading()
    assert used.step(1.0, 0.1) == Muscle(A, load=0.5, temperature=350.0).step(1.0, 0.1)


def test_it_starts_at_the_ambient_unless_told():
    assert Muscle(A, ambient=290.0).reading().temperature == 290.0
    assert Muscle(A, ambient=290.0, temperature=310.0).reading().temperature == 310.0
    assert simulate(A, [0.0], 0.0, ambient=290.0).temperature[0] == 290.0


def test_velocity_is_the_slope_of_displacement():
    muscle = Muscle(A, load=0.5)
    assert muscle.reading(0.27).velocity == 0.0
    shown = [muscle.step(0.5, 0.27) for _ in range(5)]
    for before, now in pairwise(shown):
        assert now.velocity == pytest.approx((now.displacement - before.displacement) / 0.5, rel=1e-9)
    assert muscle.reading(0.0).velocity == shown[-1].velocity > 0.0
    outputs = simulate(A, np.arange(6) * 0.5, 0.27, load=0.5)
    assert outputs.velocity[0] == 0.0
    assert outputs.velocity[1:] == pytest.approx([reading.velocity for reading in shown], rel=1e-9)


def test_a_drive_beyond_all_bounds_is_flagged_not_raised():
    for kind in KINDS:
        for drive in (1e3, 1e308):
            assert not Muscle(A, load=0.5).step(1.0, drive, kind).in_domain
    outputs = simulate(A, [0.0, 1.0, 2.0], [0.0, 1e308, 0.0])
    assert outputs.in_domain.tolist() == [True, True, False]


# --- mistakes --------------------------------------------------------------------------------------------------------


def refused(call):
    """The message of the BadInput that ``call`` raises; one line."""
    with pytest.raises(BadInput) as caught:
        call()
    message = str(caught.value)
    assert message and '\n' not in message
    return message


@pytest.mark.parametrize('value', [NAN, INF, -INF])
@pytest.mark.parametrize('argument', ['dt', 'drive', 'load', 'ambient'])
def test_a_step_refuses_what_is_not_finite_and_goes_on(argument, value):
    muscle, untouched = Muscle(A, load=0.5), Muscle(A, load=0.5)
    good = {'dt': 0.01, 'drive': 0.2, 'load': 0.5, 'ambient': 296.15}
    assert 'finite' in refused(lambda: muscle.step(**{**good, argument: value}))
    assert muscle.step(**good) == untouched.step(**good)


@pytest.mark.parametrize('value', [NAN, INF, -1.0])
@pytest.mark.parametrize('option', ['load', 'held_length', 'spring_rest_length', 'ambient', 'temperature'])
def test_a_muscle_refuses_options_that_no_bench_has(option, value):
    assert option in refused(lambda: Muscle(A, **{option: value}))


@pytest.mark.parametrize('value', [NAN, INF])
@pytest.mark.parametrize('argument', ['time', 'drive', 'load', 'ambient'])
def test_a_recording_names_the_column_that_is_not_finite(argument, value):
    columns = {'time': [0.0, 1.0, 2.0], 'drive': [0.1] * 3, 'load': [0.5] * 3, 'ambient': [296.15] * 3}
    columns[argument] = [*columns[argument][:2], value]
    message = refused(lambda: simulate(A, **columns))
    assert argument in message and 'finite' in message
    assert argument == 'time' or 'entry 2' in message


@pytest.mark.parametrize(
    ('call', 'words'),
    [
        (lambda: Muscle(A, end='blokced'), "unknown end 'blokced'; did you mean 'blocked'?"),
        (
            lambda: Muscle(A, end='spring'),
            'spring_rate_n_per_m is 0.0: a muscle held by a spring needs a rate above 0 N/m',
        ),
        (lambda: Muscle(A, end='spring', spring_rate=9.0, held_length=0.1, spring_rest_length=0.2), 'leaves no room'),
        (lambda: Muscle(NOTHING, end='blocked', load=0.3), 'no muscle has these parameters'),
        (lambda: Muscle(A).step(0.01, 0.1, 'curent'), "unknown input 'curent'; did you mean 'current'?"),
        (lambda: Muscle(A).step(0.0, 0.1), 'dt = 0.0 s: expected a finite number above 0'),
        (lambda: Muscle(A).step(-0.1, 0.1), 'dt = -0.1 s'),
        (lambda: Muscle(A).step(0.01, -1.0, 'power'), 'power = -1.0 W: expected a finite number, 0 or more'),
        (lambda: Muscle(A).step(0.01, 0.1, load=-0.1), 'load = -0.1 N'),
        (lambda: simulate(A, [0.0, 1.0, 1.0], 0.1), 'time: expected one finite, increasing column'),
        (lambda: simulate(A, [], 0.1), 'time: expected'),
        (lambda: simulate(A, [[0.0, 1.0]], 0.1), 'time: expected'),
        (lambda: simulate(A, [0.0, 1.0], [0.1] * 3), 'drive: expected a number or 2 entries'),
        (lambda: simulate(A, [0.0, 1.0], 0.1, load=[0.5]), 'load: expected a number or 2 entries'),
        (lambda: simulate(A, [0.0, 1.0], 0.1, load=[0.5, -0.5]), 'load = -0.5 N'),
        (lambda: simulate(A, [0.0, 1.0], [0.1, -0.1], kind='power'), 'power = -0.1 W'),
        (lambda: simulate(A, [0.0, 1.0], 0.1, kind='volts'), "unknown input 'volts'; did you mean 'voltage'?"),
    ],
)
def test_a_mistake_is_named_in_one_line(call, words):
    assert words in refused(call)


def test_a_blocked_muscle_that_creeps_begins_with_the_force_at_which_it_stays():
    muscle = Muscle(Parameters({'creep.J': 0.4}, ('creep',)), end='blocked', load=0.4)
    assert muscle.advance(0.0).force == pytest.approx(0.4, rel=1e-9)
    assert muscle.advance(600.0).force == pytest.approx(0.4, rel=1e-9)

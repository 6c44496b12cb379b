"""A room that the muscle's own thermometer read before the drive came on stays near to that in a replay."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TIME, TRUE, experiment
from report.diagnoses import match

from tcp_muscle_ros.diagnosis.answer.improved import with_replay
from tcp_muscle_ros.diagnosis.answer.replaying import as_given, own_of, replay
from tcp_muscle_ros.diagnosis.observation.resting import room_read
from tcp_muscle_ros.recording.recording import Channel, Recording

CHANNELS = ('temperature', 'resistance', 'displacement')
RESTED = np.where((TIME > 20.0) & (np.mod(TIME - 20.0, 70.0) < 25.0), 0.27, 0.0)
ROOM = NOMINAL['T0'] - 1.5  # K; stated is T0
OTHER = TRUE.replace(R0=1.15 * TRUE['R0'])  # its resistance would be right in a room that is 35 K colder


def rested(channels=CHANNELS, ambient=ROOM, drive=RESTED):
    return experiment(channels, drive=drive, ambient=np.full(TIME.size, ambient))


def test_the_resistance_of_another_muscle_does_not_draw_the_room_from_what_the_thermometer_read():
    run = rested()
    own = own_of(run, OTHER)
    assert own.ambient == pytest.approx(ROOM, abs=3.1)
    assert own.start == pytest.approx(ROOM, abs=3.1)
    temperature = replay(run, OTHER, own=own)['temperature'].rmse
    assert temperature < 3.5 + replay(run, OTHER, own=as_given(run, OTHER))['temperature'].rmse
    assert 'below what was read or stated' in own.warning


def test_the_room_of_the_right_muscle_is_found_and_nothing_is_said():
    own = own_of(rested(), TRUE)
    assert own.ambient == pytest.approx(ROOM, abs=0.1)
    assert own.warning == ''


def test_without_a_thermometer_the_room_may_go_and_it_is_said():
    own = own_of(rested(('resistance', 'displacement')), OTHER)
    assert own.strayed < -10.0
    assert f'{-own.strayed:.1f} K below' in own.warning


def test_the_room_is_read_only_where_the_muscle_rested_and_was_cold():
    run = rested()
    assert room_read(run, TRUE, 3.0) == pytest.approx(ROOM, abs=0.1)
    off = TRUE.with_effects('temperature_offset').replace({'temperature_offset.o': 2.0})
    assert room_read(run, off, 3.0) == pytest.approx(ROOM - 2.0, abs=0.1)  # the thermometer is known to be off
    at_once = rested(drive=np.where(np.mod(TIME, 70.0) < 25.0, 0.27, 0.0))
    assert room_read(at_once, TRUE, 3.0) is None
    assert room_read(rested(('resistance',)), TRUE, 3.0) is None
    seen = run.observed['temperature']
    warm = replace(seen, value=seen.value + 20.0 * np.exp(-seen.time / 7.0))
    assert room_read(replace(run, observed={**run.observed, 'temperature': warm}), TRUE, 3.0) is None


@pytest.mark.parametrize(('seen', 'said'), [(CHANNELS, False), (CHANNELS[1:], True)])
def test_a_diagnosis_says_where_the_nominal_errors_are_those_of_a_room_far_from_what_was_stated(seen, said):
    run = rested(seen)
    shown = {'current': run.imposed.drive, **{name: o.value for name, o in run.observed.items()}}
    channels = {name: Channel(name, TIME, value, name) for name, value in shown.items()}
    nominal = replace(match()[0], nominal=OTHER, calibrated=TRUE, improved=TRUE)
    found = with_replay(nominal, [Recording('csv', channels, 0, {'load_n': 0.588})], {})
    assert any(note.startswith('the nominal errors: the room was fitted') for note in found.notes) is said

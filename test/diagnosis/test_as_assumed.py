"""What the recordings do not tell of an effect's shape is handed on as assumed."""

from dataclasses import replace

import pytest
from diagnosis.made import NOMINAL, TRUE, experiment

from tcp_muscle_ros.diagnosis.answer.handed_on import handed_on
from tcp_muscle_ros.diagnosis.answer.replaying import own_of, replay
from tcp_muscle_ros.diagnosis.fitting.as_assumed import as_assumed
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise
from tcp_muscle_ros.diagnosis.search.candidates import screen
from tcp_muscle_ros.diagnosis.search.refitting import rivals_for
from tcp_muscle_ros.diagnosis.search.selection import select

CHANNELS = ('temperature', 'resistance', 'displacement')


def found(effect, values, *loads):
    """What is selected from recordings under these loads (N) of a muscle with an effect, and the muscle."""
    muscle = TRUE.replace(values).with_effects(effect)
    runs = [experiment(CHANNELS, 0.25 - 0.01 * k, load, k, muscle=muscle) for k, load in enumerate(loads)]
    fitted = in_turn(calibrate(runs, NOMINAL).fit)
    (rival,) = rivals_for(fitted, screen(fitted, [effect])[0], None)
    final = settle_noise(rival.fit)[0]
    return replace(select(final, []), calibrated=fitted), muscle


def test_a_power_that_two_loads_do_not_tell_is_as_assumed_and_foretells_a_third():
    chosen, muscle = found('load_stroke', {'load_stroke.b': 1.0}, 0.3, 0.588)
    assert chosen.best.muscle['load_stroke.n'] != 1.0
    handed = handed_on(chosen)[0]
    assert handed['load_stroke.n'] == 1.0
    further = experiment(CHANNELS, 0.25, 1.1, 9, muscle=muscle)
    assert replay(further, handed, own=own_of(further, handed))['displacement'].rmse < 1e-4


def test_a_time_that_the_recordings_tell_stays_as_found():
    chosen, muscle = found('creep', {'creep.J': 0.3, 'creep.tau50': 45.0}, 0.3, 0.588)
    assert as_assumed(chosen.best).muscle['creep.tau50'] == pytest.approx(muscle['creep.tau50'], rel=0.15)

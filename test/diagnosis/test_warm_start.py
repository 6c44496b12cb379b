"""A recording that begins while the muscle is warm, where no thermometer says so."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TRUE, experiment

from tcp_muscle_ros.diagnosis.answer.notes import on_warm_start
from tcp_muscle_ros.diagnosis.answer.replaying import own_of, replay
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.model.unknown import START
from tcp_muscle_ros.muscle import simulate

CHANNELS = ('resistance', 'displacement')
BEGINS = 20.0  # s, in the middle of the first heating


def begun_late(channels=CHANNELS):
    """A recording of which the beginning is missing, and the temperature (K) with which it begins."""
    run = experiment(channels)
    imposed, kept = run.imposed, run.imposed.time >= BEGINS
    true = simulate(TRUE, imposed.time, imposed.drive, load=0.588)
    late = {
        name: getattr(imposed, name)[kept] - (BEGINS if name == 'time' else 0.0)
        for name in ('time', 'drive', 'load', 'ambient')
    }
    observed = {name: replace(shown.only(kept), time=shown.time[kept] - BEGINS) for name, shown in run.observed.items()}
    return replace(run, imposed=replace(imposed, **late), observed=observed), float(true.temperature[kept][0])


def test_the_muscle_is_calibrated_as_one_that_was_in_use_and_a_note_says_so():
    run, begins = begun_late()
    fitted = calibrate([run], NOMINAL).fit
    assert max(fitted.mean_square.values()) < 1.2
    assert NOMINAL['T0'] + 20.0 < fitted.values[START, 0] < begins + 20.0  # how hot, only a material tells here
    assert fitted.values['C', None] / fitted.values['hA', None] == pytest.approx(0.15 / 0.0225, rel=0.02)
    (note,) = on_warm_start(fitted)
    assert note.startswith('recording 1 begins while the muscle is warm, at ')


def test_a_replay_begins_where_the_muscle_did():
    run, begins = begun_late()
    own = own_of(run, TRUE)
    assert own.start == pytest.approx(begins, abs=1.0)
    assert replay(run, TRUE, own=own)['displacement'].rmse < 6e-5


def test_what_began_cold_is_held_to_its_room_and_a_thermometer_needs_no_guess():
    cold = calibrate([experiment(CHANNELS)], NOMINAL).fit
    (start,) = [u for u in cold.problem.unknowns if u.name == START]
    assert start.spread == 1.0
    assert on_warm_start(cold) == ()
    run, begins = begun_late(('temperature', *CHANNELS))
    seen = calibrate([run], NOMINAL).fit
    assert seen.values[START, 0] == pytest.approx(begins, abs=1.0)
    assert on_warm_start(seen) == ()


def test_one_of_two_that_was_in_use_is_told_from_the_one_that_rested():
    run, _ = begun_late()
    fitted = calibrate([experiment(CHANNELS, seed=1), run], NOMINAL).fit
    spreads = [u.spread for u in fitted.problem.unknowns if u.name == START]
    assert spreads[0] == 1.0 < spreads[1]
    assert np.all(np.array(list(fitted.mean_square.values())) < 1.2)

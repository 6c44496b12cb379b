"""A draught that comes and goes is told by its course, which all channels see; a supply that hunts is no draught."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TIME, TRUE, experiment

from tcp_muscle_ros.diagnosis.diagnose import diagnose
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise
from tcp_muscle_ros.diagnosis.search.shared import shared_misfit
from tcp_muscle_ros.diagnosis.search.unsteady import unsteady
from tcp_muscle_ros.muscle import simulate

LOADS = (0.4, 0.8)
NOISE = {'temperature': 0.2, 'resistance': 0.02, 'displacement': 5e-5}


def coming_and_going(seed):
    """1 at rest, up to twice as much while it blows: on and off at irregular instants."""
    rng = np.random.default_rng(seed)
    edges = np.cumsum(rng.exponential(9.0, 60))
    return 1.0 + np.where(np.searchsorted(edges, TIME) % 2 == 1, rng.uniform(0.4, 0.9), 0.0)


def recorded(shown):
    made = []
    for seed, load in enumerate(LOADS):
        one, rng = experiment(list(NOISE), seed=seed, load=load), np.random.default_rng(50 + seed)
        out = shown(one, load, coming_and_going(seed))
        observed = {
            name: replace(o, value=getattr(out, name) + NOISE[name] * rng.standard_normal(TIME.size))
            for name, o in one.observed.items()
        }
        made.append(replace(one, observed=observed))
    return made


def calibrated(made):
    return settle_noise(calibrate(made, NOMINAL).fit)[0]


def in_a_draught(made, load, factor):
    """Loses ``factor`` times the heat: as in a room so much colder, which it is in turn."""
    room = made.imposed.ambient
    for _ in range(12):
        out = simulate(TRUE, TIME, made.imposed.drive, kind='current', load=load, ambient=room)
        room = made.imposed.ambient - (factor - 1.0) * (out.fibre_temperature - made.imposed.ambient)
    return out


def from_a_supply_that_hunts(made, load, factor):
    return simulate(TRUE, TIME, made.imposed.drive * np.sqrt(1.5 / factor), kind='current', load=load)


def test_a_draught_that_comes_and_goes_is_found_by_its_course():
    found = diagnose(recorded(in_a_draught), NOMINAL)
    assert [f.effect for f in found.findings] == ['airflow']
    assert found.unexplained is None
    assert any('came and went' in note for note in found.notes)
    assert found.improved['hA'] == pytest.approx(TRUE['hA'] * 1.3, rel=0.15)  # it blows half of the time


def test_a_supply_that_hunts_is_no_draught():
    fitted = calibrated(recorded(from_a_supply_that_hunts))
    assert shared_misfit(fitted) is not None  # several channels see it
    assert unsteady(fitted) is None


def test_a_muscle_in_still_air_has_none():
    made = [experiment(list(NOISE), seed=3 + k, load=load) for k, load in enumerate(LOADS)]
    assert unsteady(calibrated(made)) is None

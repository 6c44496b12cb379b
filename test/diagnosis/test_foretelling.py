"""What each recording has for itself, and traces of physics: which of them is named beside what foretells."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TRUE, experiment, shown_with

from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise
from tcp_muscle_ros.diagnosis.search import company
from tcp_muscle_ros.diagnosis.search.candidates import screen
from tcp_muscle_ros.diagnosis.search.company import foretelling, least_of_all
from tcp_muscle_ros.diagnosis.search.refitting import rivals_for
from tcp_muscle_ros.diagnosis.search.rivals import Rival, begins, own, penalised, sound
from tcp_muscle_ros.diagnosis.search.selection import select

CHANNELS = ('temperature', 'resistance', 'displacement')


def recorded(muscle, *loads):
    """Three recordings, under one load (N) each."""
    return [
        experiment(CHANNELS, current, load, k, muscle=muscle)
        for k, (current, load) in enumerate(zip((0.27, 0.24, 0.25), loads, strict=True))
    ]


def calibrated(runs):
    """Their fit without any effect."""
    return settle_noise(in_turn(calibrate(runs, NOMINAL).fit))[0]


def drifted(run, seed):
    """By one that drifts by chance: 2 mm to and fro within it."""
    slope, bend = np.random.default_rng(seed).normal(size=2)
    return shown_with(run, lambda since: 1e-3 * (slope * since / since[-1] + bend * (since / since[-1]) ** 2))


def warmed(run, size):
    """By one that warms up: so much (m) within minutes."""
    return shown_with(run, lambda since: size * (1.0 - np.exp(-since / 60.0)))


@pytest.mark.parametrize('flows', [True, False])
def test_a_law_that_foretells_new_recordings_goes_before_what_each_has_for_itself(flows):
    """A flow is foretold, chance is not: three runs, each with a course of its own."""
    muscle = TRUE.replace({'viscous_flow.m': 4e-6}).with_effects('viscous_flow') if flows else TRUE
    runs = recorded(muscle, 0.3, 0.588, 0.98)
    runs = runs if flows else [drifted(run, k) for k, run in enumerate(runs)]
    bare = calibrated(runs)
    ranked, _ = screen(bare, ['viscous_flow', 'displacement_drift'])
    law, chance = sorted(rivals_for(bare, ranked, None, also=['viscous_flow']), key=own)
    assert own(chance)
    assert foretelling(bare, chance, [law, chance]) is (law if flows else chance)
    assert foretelling(bare, law, [law, chance]) is law
    usual = law.policy.of_all
    assert (least_of_all(law), least_of_all(chance)) == (usual, 2.0 * usual)


def test_a_sensor_that_warms_up_alike_each_time_keeps_its_name(monkeypatch):
    """A first cycle in every recording foretells such a drift as well, but no better than the drift itself."""
    made = zip(recorded(TRUE, 0.3, 0.588, 0.98), (1.0e-3, 1.4e-3, 0.9e-3), strict=True)
    bare = calibrated([warmed(run, size) for run, size in made])
    ranked, _ = screen(bare, ['first_cycle', 'displacement_drift'])
    law, drift = sorted(rivals_for(bare, ranked, None, also=['first_cycle']), key=own)
    assert (law.effect, own(drift)) == ('first_cycle', True)
    assert foretelling(bare, drift, [law, drift]) is drift
    monkeypatch.setattr(company, 'one_for_all', lambda *_: None)
    assert foretelling(bare, drift, [law, drift]) is law


def test_a_trace_that_foretells_is_named():
    """The flow is a trace beside what is usual, and plain beside the noise."""
    muscle = TRUE.replace({'viscous_flow.m': 1.7e-7, 'viscous_flow.law': 2.0}).with_effects('viscous_flow')
    bare = calibrated(recorded(muscle, 1.2, 1.4, 1.1))
    found = select(bare, ['viscous_flow', 'displacement_drift'])
    assert [c.effect for c in found.chosen] == ['viscous_flow']
    itself = Rival('viscous_flow', found.final, penalised(found.final))
    assert sound(itself)
    assert not begins(itself)
    # Nor is other physics named in its place that it plainly beats; what explains nearly the same is.
    ranked, _ = screen(bare, ['viscous_flow', 'creep'])
    trace, other = sorted(rivals_for(bare, ranked, None), key=lambda r: r.effect, reverse=True)
    assert foretelling(bare, replace(other, score=trace.score + 200.0), [trace, other]) is trace
    near = replace(other, score=trace.score + 10.0)
    assert foretelling(bare, near, [trace, near]) is near

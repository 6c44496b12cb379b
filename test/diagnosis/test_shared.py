"""What several channels see at once is no noise; what each has for itself may be."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TIME, experiment

from tcp_muscle_ros.diagnosis.answer.notes import on_shared
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.search.remaining import _stage, wandering
from tcp_muscle_ros.diagnosis.search.selection import select
from tcp_muscle_ros.diagnosis.search.shared import shared_misfit

CHANNELS = ['temperature', 'resistance', 'displacement']


def wander(seed, size=1.0):
    """Slow and irregular, as turbulence is: correlated over some seconds."""
    rng, values = np.random.default_rng(seed), np.zeros(TIME.size)
    for k in range(1, TIME.size):
        values[k] = 0.97 * values[k - 1] + np.sqrt(1.0 - 0.97**2) * rng.standard_normal()
    return size * values


def with_added(made, added):
    """The recording with something on top of what its channels show."""
    observed = {name: replace(o, value=o.value + added.get(name, 0.0)) for name, o in made.observed.items()}
    return replace(made, observed=observed)


@pytest.fixture(scope='module')
def recordings():
    return [experiment(CHANNELS, seed=k, load=load) for k, load in enumerate((0.4, 0.6, 0.8))]


def left_by(recordings):
    return shared_misfit(calibrate(recordings, NOMINAL).fit)


def test_clean_recordings_share_nothing(recordings):
    assert left_by(recordings) is None


@pytest.fixture(scope='module')
def draughty(recordings):
    """The calibrated fit of recordings in which something moves all channels together."""
    warmer = [wander(k) for k in range(3)]  # K
    together = [
        with_added(made, {'temperature': w, 'resistance': 0.04 * w, 'displacement': 3e-4 * w})
        for made, w in zip(recordings, warmer, strict=True)
    ]
    return calibrate(together, NOMINAL).fit


def test_what_moves_temperature_and_stroke_together_is_no_noise(draughty):
    found = shared_misfit(draughty)
    assert found is not None
    assert abs(found.correlation) > 0.9


def test_it_is_said_only_where_it_is_what_is_unexplained(draughty):
    """What an unlisted effect does goes together in several channels too, and a state of the muscle drives it."""
    selection = replace(select(draughty, ()), final=draughty)
    found = wandering(selection)
    assert found.stage == 'thermal'
    assert any('are correlated' in note for note in on_shared(selection, found))
    assert on_shared(selection, None) == ()
    assert on_shared(selection, replace(found, driver='temperature')) == ()


@pytest.mark.parametrize(('kelvin', 'stage'), [(1.0, 'thermal'), (0.0, 'mechanical')])
def test_a_stroke_that_is_missed_together_with_the_temperature_is_missed_for_its_heat(recordings, kelvin, stage):
    """A millimetre a kelvin stands out of its noise far more than the kelvin does."""
    added = [(kelvin * w, 1e-3 * w) for w in (wander(k) for k in range(3))]
    runs = [
        with_added(made, {'temperature': warmer, 'displacement': stroke})
        for made, (warmer, stroke) in zip(recordings, added, strict=True)
    ]
    assert _stage(calibrate(runs, NOMINAL).fit, ('displacement',)) == stage


def test_slow_noise_of_each_sensor_by_itself_is_its_own(recordings):
    alone = [
        with_added(
            made,
            {
                'temperature': wander(10 + k),
                'resistance': wander(20 + k, 0.04),
                'displacement': wander(30 + k, 3e-4),
            },
        )
        for k, made in enumerate(recordings)
    ]
    assert left_by(alone) is None

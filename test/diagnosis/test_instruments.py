"""How large noise may be: what is larger than single readings and an instrument's wander is misfit."""

import numpy as np
import pytest

from tcp_muscle_ros.diagnosis.fitting.generic import Drivers, structure
from tcp_muscle_ros.diagnosis.model.tcp_muscle import TCP_MUSCLE
from tcp_muscle_ros.diagnosis.noise.instruments import largest_noise
from tcp_muscle_ros.recording.recording import OUTPUTS
from tcp_muscle_ros.settings.policy import shipped

STROKE = TCP_MUSCLE.channels['displacement']
CAPPED = {'channel': STROKE, 'most_of_single': shipped().single_readings}


def test_every_output_has_an_instrument_with_its_source():
    assert set(TCP_MUSCLE.channels) == set(OUTPUTS)
    assert all(row.wander > 0.0 and row.source for row in (*TCP_MUSCLE.channels.values(), TCP_MUSCLE.surroundings))


def test_an_instrument_that_is_better_in_single_readings_wanders_less():
    assert largest_noise(STROKE, 1e-6, 1.5) == pytest.approx(5e-6)
    assert largest_noise(STROKE, 5e-5, 1.5) == pytest.approx(np.hypot(7.5e-5, 4e-5))


def test_a_swing_that_no_driver_tells_is_misfit_and_not_noise():
    """A ripple of 1 mm in a stroke that is read to 0.05 mm: fifteen times the noise was once taken for it."""
    rng, time = np.random.default_rng(1), np.arange(0.0, 400.0, 0.4)
    flat, single = np.ones(time.size), 5e-5
    seen = Drivers(300.0 + 0.1 * time, flat, flat, time, time, flat, 1e-4 * time, flat)
    ripple = 1e-3 * np.sin(2.0 * np.pi * time / 3.7)
    found = structure([ripple + single * rng.standard_normal(time.size)], [time], [seen], single, **CAPPED)
    assert found.noise.sigma < 2.0 * single
    quiet = structure([single * rng.standard_normal(time.size)], [time], [seen], single, **CAPPED)
    assert quiet.noise.sigma == pytest.approx(single, rel=0.1)

"""The misfit without a name: what is structure and what is noise, whatever the catalogue holds."""

import numpy as np
import pytest

from tcp_muscle_ros.diagnosis.fitting.generic import Drivers, structure
from tcp_muscle_ros.diagnosis.model.tcp_muscle import TCP_MUSCLE
from tcp_muscle_ros.settings.policy import shipped

NOISE = 5e-5  # m
PERIOD = 70.0  # s

CAPPED = {'channel': TCP_MUSCLE.channels['displacement'], 'most_of_single': shipped().single_readings}


def cycles(seconds=350.0, samples=1000):
    """Five cycles of heating and cooling as a muscle shows them, one recording."""
    time = np.linspace(0.0, seconds, samples)
    phase = time % PERIOD
    heating = (phase < 25.0).astype(float)
    rise = np.where(heating == 1.0, -np.expm1(-phase / 9.0), np.exp(-(phase - 25.0) / 9.0))
    temperature = 296.0 + 55.0 * rise
    return time, Drivers(
        level=temperature,
        rate=np.gradient(temperature, time),
        heating=heating,
        since_switch=np.where(heating == 1.0, phase, phase - 25.0),
        elapsed=time,
        load=np.full(time.size, 0.6),
        place=-0.03 * rise,
        drive=0.27 * heating,
    )


@pytest.mark.parametrize('seed', range(3))
def test_a_stroke_that_shrinks_from_cycle_to_cycle_is_no_noise(seed):
    time, drivers = cycles()
    noise = NOISE * np.random.default_rng(seed).standard_normal(time.size)
    worn = -0.02 * drivers.place * (time / time[-1])  # 0.6 mm of 30 at the end
    found = structure([worn + noise], [time], [drivers], NOISE, **CAPPED)
    assert found.significant
    assert found.noise.sigma == pytest.approx(NOISE, rel=0.1)


@pytest.mark.parametrize('seed', range(3))
def test_noise_alone_is_no_structure(seed):
    time, drivers = cycles()
    noise = NOISE * np.random.default_rng(seed).standard_normal(time.size)
    found = structure([noise], [time], [drivers], NOISE, **CAPPED)
    assert not found.significant
    assert found.noise.sigma == pytest.approx(NOISE, rel=0.1)

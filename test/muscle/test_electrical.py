"""The electrical stage: resistance with temperature, and what each kind of source drives."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from muscle.reference import CURRENTS

from tcp_muscle_ros.muscle import ZERO_CELSIUS, Muscle, Parameters, resistance

A = Parameters.named('karami_tadesse_2017')


def test_resistance_at_the_reference_and_at_80_degc():
    assert resistance(A, 23.0 + ZERO_CELSIUS) == 14.0
    assert resistance(A, 80.0 + ZERO_CELSIUS) == pytest.approx(14.0 * 1.171, rel=1e-15)


# The audit's resistances belong to the third peak, its temperatures to the first; the two differ by up to 0.03 K.
@pytest.mark.parametrize(
    ('current', 'first', 'third', 'volt'),
    [
        (0.18, 14.985, 14.985, 2.70),
        (0.21, 15.370, 15.371, 3.23),
        (0.24, 15.836, 15.837, 3.80),
        (0.27, 16.394, 16.395, 4.43),
    ],
)
def test_resistance_and_voltage_at_the_peaks(current, first, third, volt):
    muscle = Muscle(A)
    peaks = []
    for _ in range(3):
        peaks.append(muscle.step(25.0, current))
        muscle.step(45.0, 0.0)
    assert round(peaks[0].resistance, 3) == first
    assert round(peaks[2].resistance, 3) == third
    assert round(peaks[0].voltage, 2) == volt


def test_cold_power_of_the_four_currents():
    cold = [Muscle(A).reading(current).power for current in CURRENTS]
    assert [round(power, 3) for power in cold] == [0.454, 0.617, 0.806, 1.021]


@given(st.floats(0.01, 1.0), st.floats(-20.0, 150.0))
def test_three_sources_describe_one_instant(current, celsius):
    muscle = Muscle(A, temperature=celsius + ZERO_CELSIUS)
    by_current = muscle.reading(current)
    assert by_current.voltage == pytest.approx(current * by_current.resistance, rel=1e-15)
    assert by_current.power == pytest.approx(by_current.voltage * current, rel=1e-14)
    for kind in ('voltage', 'power'):
        other = muscle.reading(getattr(by_current, kind), kind)
        assert other == pytest.approx(by_current, rel=1e-12)


@pytest.mark.parametrize('kind', ['current', 'voltage'])
def test_a_reversed_source_heats_alike_and_shows_its_sign(kind):
    forward, backward = Muscle(A), Muscle(A)
    shown, mirrored = forward.step(5.0, 0.2, kind), backward.step(5.0, -0.2, kind)
    assert mirrored.temperature == shown.temperature
    assert mirrored.power == shown.power > 0.0
    assert (mirrored.current, mirrored.voltage) == (-shown.current, -shown.voltage)


def test_only_a_current_source_runs_away():
    """2 A, its cold power, and its cold voltage."""
    hour = np.arange(0.0, 3600.0, 1.0)
    muscle = Muscle(A)
    assert muscle.step(30.0, 2.0).temperature > 1e5
    by_power = Muscle(A).step(3600.0, 56.0, 'power')
    assert by_power.temperature == pytest.approx(A['T0'] + 56.0 / A['hA'], rel=1e-9)
    steady = Muscle(A)
    for _ in hour:
        by_voltage = steady.step(1.0, 28.0, 'voltage')
    assert by_voltage.power == pytest.approx(A['hA'] * (by_voltage.temperature - A['T0']), rel=1e-9)
    assert by_voltage.temperature < by_power.temperature

"""What the model says without time, against the model in time and against the same formulas written out."""

from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from muscle.reference import SET_A

from tcp_muscle_ros.muscle import (
    ZERO_CELSIUS,
    Muscle,
    Parameters,
    critical_current,
    length,
    length_at,
    resistance,
    shortening,
    steady_current,
    steady_temperature,
    stiffness,
    temperature_for_length,
)

A = Parameters.named('karami_tadesse_2017')


@pytest.mark.parametrize(
    ('name', 'ampere'),
    [('karami_tadesse_2017', 0.678), ('karami_tadesse_2017_set_b', 0.598), ('karami_tadesse_2017_as_printed', 1.890)],
)
def test_runaway_criterion(name, ampere):
    assert round(critical_current(Parameters.named(name)), 3) == ampere


def test_below_the_critical_current_it_settles_and_above_it_never_does():
    critical = critical_current(A)
    below = Muscle(A)
    below.step(1e6, 0.999 * critical)
    settled = below.step(1e6, 0.999 * critical).temperature
    assert settled == pytest.approx(steady_temperature(A, 0.999 * critical), rel=1e-9)
    above = Muscle(A)
    shown = [above.step(1.0, 1.001 * critical).temperature for _ in range(100)]
    assert (np.diff(shown, 2) > 0.0).all()
    assert steady_temperature(A, critical) == steady_temperature(A, 1.001 * critical) == inf


def test_heating_rate_at_the_critical_current_and_growth_above():
    muscle = Muscle(A)
    before = muscle.reading().temperature
    assert round(muscle.step(1.0, critical_current(A)).temperature - before, 1) == 37.9
    grown = [Muscle(A).step(t, 0.9).temperature for t in (100.0, 200.0)]
    assert round(np.log(grown[1] / grown[0]) / 100.0, 3) == 0.086


@pytest.mark.parametrize('slope', [0.0, -0.001])
def test_a_resistance_that_does_not_rise_never_runs_away(slope):
    assert critical_current(A.replace(a_R=slope)) == inf
    assert np.isfinite(steady_temperature(A.replace(a_R=slope), 5.0))


def test_current_for_120_degc():
    assert round(steady_current(A, 120.0 + ZERO_CELSIUS), 2) == 0.32


@given(st.floats(0.0, 0.6), st.floats(-20.0, 40.0))
def test_steady_state_is_where_the_muscle_stays(current, ambient):
    steady = steady_temperature(A, current, ambient + ZERO_CELSIUS)
    muscle = Muscle(A, ambient=ambient + ZERO_CELSIUS, temperature=steady)
    assert muscle.step(50.0, current).temperature == pytest.approx(steady, abs=1e-9)
    assert steady_current(A, steady, ambient + ZERO_CELSIUS) == pytest.approx(current, abs=1e-7)


def test_no_current_cools():
    assert steady_current(A, 280.0) == 0.0
    assert steady_current(A, 300.0, ambient=300.0) == 0.0


@given(st.floats(0.0, 1.0), st.floats(0.0, 5.0) | st.floats(5.0, 6.0))  # under 5.6 N it turns at T0
def test_temperature_for_length_undoes_length(share, force):
    low, high = shortening(A, force)
    kelvin = low + share * (high - low)
    height = length_at(A, kelvin, force)
    found = temperature_for_length(A, height, force)
    assert length_at(A, found, force) == pytest.approx(height, abs=1e-15)
    # Where the length turns it says little about the temperature.
    assert found == pytest.approx(kelvin, abs=1e-8 if kelvin < high - 1.0 else 2e-3)


@pytest.mark.parametrize('force', [0.0, 0.588, 0.98, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0])
def test_under_a_heavy_load_softening_overtakes_the_contraction(force):
    low, high = shortening(A, force)
    kelvin = np.arange(0.0, 120.001, 0.01) + ZERO_CELSIUS
    assert low == ZERO_CELSIUS
    assert high == pytest.approx(kelvin[np.argmin(length(A, kelvin, force))], abs=0.011)
    assert (high == kelvin[-1]) == (force < 0.9)


def test_where_heating_shortens_nowhere_no_warmth_is_of_use():
    T0 = A['T0']
    assert shortening(A, 8.0) == (T0, T0)
    assert temperature_for_length(A, length_at(A, 350.0, 8.0), 8.0) == temperature_for_length(A, 0.0, 8.0) == T0


def test_a_branch_begins_where_heating_begins_to_shorten():
    p = Parameters.named('sun_zhao_2021')
    for force in (0.0, 3.0, 5.0, 10.0):
        low, high = shortening(p, force)
        assert high == ZERO_CELSIUS + 120.0
        kelvin = np.linspace(ZERO_CELSIUS, high, 5000)
        assert low == pytest.approx(kelvin[np.argmax(length(p, kelvin, force))], abs=0.03)


def test_one_length_is_the_same_to_the_last_bit_as_in_an_array():
    t, f = np.random.default_rng(0).uniform((270.0, 0.0), (400.0, 1.0), (200, 2)).T
    assert length(A, t, f).tolist() == [length_at(A, *pair) for pair in zip(t, f, strict=True)]


def test_lengths_that_no_temperature_gives_answer_the_nearer_end():
    assert temperature_for_length(A, 1.0, 0.5) == pytest.approx(ZERO_CELSIUS, abs=1e-9)
    assert temperature_for_length(A, 0.0, 0.5) == pytest.approx(ZERO_CELSIUS + 120.0, abs=1e-9)


def test_arrays_of_any_shape():
    celsius = np.array([[0.0], [23.0], [80.0], [119.0]])
    force = np.array([0.1, 0.5, 1.0])
    kelvin = celsius + ZERO_CELSIUS
    np.testing.assert_allclose(length(A, kelvin, force), SET_A.length(celsius, force), rtol=0, atol=1e-14)
    np.testing.assert_allclose(resistance(A, kelvin), 14.0 * (1 + 0.003 * (celsius - 23.0)), rtol=1e-15)
    np.testing.assert_allclose(stiffness(A, kelvin), SET_A.stiffness(celsius), rtol=1e-11)
    assert length(A, kelvin, force).shape == (4, 3)
    assert resistance(A, 300.0).shape == stiffness(A, 300.0).shape == length(A, 300.0, 0.5).shape == ()


@given(st.floats(-20.0, 150.0), st.floats(0.0, 1.0))
def test_statics_and_the_stepping_muscle_agree(celsius, force):
    reading = Muscle(A, load=force, temperature=celsius + ZERO_CELSIUS).reading()
    assert float(length(A, reading.temperature, force)) == pytest.approx(reading.length, abs=1e-15)
    assert float(resistance(A, reading.temperature)) == pytest.approx(reading.resistance, rel=1e-15)

"""The thermal stage: the exact step against an adaptive solver, its energy, and the temperatures of docs/paper.md."""

from dataclasses import replace
from math import exp, fsum, log

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from muscle.reference import AS_PRINTED, CURRENTS, SET_A, SET_B

from tcp_muscle_ros.muscle import (
    ZERO_CELSIUS,
    Muscle,
    Parameters,
    critical_current,
    simulate,
    steady_temperature,
    thermal,
)

A = Parameters.named('karami_tadesse_2017')
B = Parameters.named('karami_tadesse_2017_set_b')
PRINTED = Parameters.named('karami_tadesse_2017_as_printed')
# Numbers for which i^2 R0 a_R - hA is 0 in floating point too: 0.25 * 16 * 2^-8 = 2^-6.
ON_THE_EDGE = A.replace(R0=16.0, a_R=2.0**-8, hA=2.0**-6)

ON, OFF = 25.0, 45.0
# Their Python text: compiled they are called by compiled functions only.
phi1, phi2 = thermal.phi1.py_func, thermal.phi2.py_func
seconds = st.floats(1e-4, 200.0)
amperes = st.floats(0.0, 0.6)
celsius = st.floats(-20.0, 150.0)


def muscle(parameters=A, *, start=23.0, ambient=23.0, **options):
    return Muscle(parameters, temperature=start + ZERO_CELSIUS, ambient=ambient + ZERO_CELSIUS, **options)


def after(duration, drive, kind='current', parameters=A, **options):
    """Fibre temperature (degC) after one step."""
    return muscle(parameters, **options).step(duration, drive, kind).fibre_temperature - ZERO_CELSIUS


def cycles(parameters, current, count=3):
    """Peak and following trough (degC) of each cycle of the paper's protocol."""
    one = muscle(parameters)
    for _ in range(count):
        peak = one.step(ON, current).temperature - ZERO_CELSIUS
        yield peak, one.step(OFF, 0.0).temperature - ZERO_CELSIUS


# --- the numbers of docs/paper.md ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('parameters', 'peaks'),
    [
        (A, (46.4, 55.6, 66.7, 80.0)),
        (B, (46.8, 55.9, 66.9, 80.0)),
        (PRINTED, (26.1, 27.2, 28.5, 29.9)),
    ],
    ids=['set A', 'set B', 'as printed'],
)
def test_first_peaks_of_the_four_currents(parameters, peaks):
    first = [next(cycles(parameters, current, 1))[0] for current in CURRENTS]
    assert [round(peak, 1) for peak in first] == list(peaks)


@pytest.mark.parametrize('current', CURRENTS)
@pytest.mark.parametrize(
    ('parameters', 'sample'), [(A, SET_A), (B, SET_B), (PRINTED, AS_PRINTED)], ids=['set A', 'set B', 'as printed']
)
def test_three_cycles_against_an_adaptive_solver(parameters, sample, current):
    temperature = 23.0
    for peak, trough in cycles(parameters, current):
        temperature, *_ = sample.heat_up('current', current, temperature, 23.0, ON)
        assert peak == pytest.approx(temperature, abs=1e-9, rel=0)
        temperature, *_ = sample.heat_up('current', 0.0, temperature, 23.0, OFF)
        assert trough == pytest.approx(temperature, abs=1e-9, rel=0)


def test_set_a_repeats_its_cycles_and_set_b_does_not():
    (first, rest), _, (third, _) = cycles(A, 0.27)
    assert round(third - first, 2) == 0.03
    assert round(rest - 23.0, 2) == 0.34
    (first, rest), (second, _), _ = cycles(B, 0.27)
    assert round(second - first, 1) == 1.6
    assert round(rest - 23.0, 1) == 4.8


@pytest.mark.parametrize(('current', 'plateau'), [(0.18, 48.2), (0.21, 58.3), (0.24, 70.7), (0.27, 85.7)])
def test_plateaus(current, plateau):
    steady = steady_temperature(A, current) - ZERO_CELSIUS
    assert round(steady, 1) == plateau
    assert after(1e4, current) == pytest.approx(steady, abs=1e-9)


def test_without_the_rise_of_resistance_the_highest_peak_is_seven_kelvin_lower():
    assert round(after(ON, 0.27) - after(ON, 0.27, parameters=A.replace(a_R=0.0)), 1) == 7.3


# --- the exact step --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('current', 'duration', 'start', 'ambient'),
    [
        pytest.param(0.0, 45.0, 80.0, 23.0, id='cools'),
        pytest.param(0.0, 45.0, 5.0, 35.0, id='warms up'),
        pytest.param(0.27, 25.0, 23.0, 23.0, id='lambda < 0'),
        pytest.param(0.32, 300.0, 10.0, 30.0, id='lambda < 0, ambient is not T0'),
        pytest.param(0.678, 4.0, 23.0, 23.0, id='lambda barely < 0'),
        pytest.param(0.679, 4.0, 23.0, -5.0, id='lambda barely > 0'),
        pytest.param(0.9, 2.3, 23.0, 23.0, id='lambda > 0'),
        pytest.param(2.0, 0.4, 23.0, 28.0, id='lambda > 0, steep'),
        pytest.param(-0.27, 25.0, 23.0, 23.0, id='current the other way'),
    ],
)
def test_one_step_is_exact(current, duration, start, ambient):
    expected, *_ = SET_A.heat_up('current', current, start, ambient, duration)
    assert expected < 200.0
    assert after(duration, current, start=start, ambient=ambient) == pytest.approx(expected, abs=1e-9, rel=0)


def test_at_the_critical_current_the_temperature_is_a_straight_line():
    assert critical_current(ON_THE_EDGE) == 0.5
    slope = 0.5**2 * 16.0 / 0.17
    for duration in (0.01, 1.0, 5.0):
        assert after(duration, 0.5, parameters=ON_THE_EDGE) == pytest.approx(23.0 + slope * duration, abs=1e-9, rel=0)
    sample = replace(SET_A, R0=16.0, a_R=2.0**-8, hA=2.0**-6)
    expected, *_ = sample.heat_up('current', 0.5, 60.0, 30.0, 3.0)
    found = after(3.0, 0.5, parameters=ON_THE_EDGE, start=60.0, ambient=30.0)
    assert found == pytest.approx(expected, abs=1e-9, rel=0)


def test_far_past_runaway_the_relative_error_stays_small():
    expected, *_ = SET_A.heat_up('current', 0.9, 23.0, 23.0, 25.0)
    assert expected > 1000.0
    assert after(25.0, 0.9) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize('current', [0.0, 0.27, 0.678, 0.9])
def test_one_step_equals_five_hundred(current):
    duration = 2.0 if current > 0.5 else 25.0
    fine = muscle(start=60.0)
    for _ in range(500):
        last = fine.step(duration / 500, current)
    assert last.fibre_temperature - ZERO_CELSIUS == pytest.approx(after(duration, current, start=60.0), abs=1e-10)


@pytest.mark.parametrize('power', [0.0, 0.45, 1.0, 4.0])
def test_a_power_source_is_exact(power):
    expected, *_ = SET_A.heat_up('power', power, 40.0, 20.0, 25.0)
    assert after(25.0, power, 'power', start=40.0, ambient=20.0) == pytest.approx(expected, abs=1e-9, rel=0)


@pytest.mark.parametrize('voltage', [0.0, 2.7, 4.4, -4.4, 6.0])
def test_a_voltage_source_at_100_hz(voltage):
    # Not linear in T, so stepped by Runge-Kutta; the rest is the bound for smooth physics: 1e-6 K.
    expected, *_ = SET_A.heat_up('voltage', voltage, 23.0, 30.0, 25.0)
    shown = simulate(A, np.arange(2501) * 0.01, voltage, kind='voltage', ambient=30.0 + ZERO_CELSIUS,
                     temperature=23.0 + ZERO_CELSIUS)  # fmt: skip
    assert shown.temperature[-1] - ZERO_CELSIUS == pytest.approx(expected, abs=1e-6, rel=0)


def test_a_changing_ambient_acts_from_the_moment_it_changes():
    one, expected = muscle(), 23.0
    for ambient, current in ((23.0, 0.27), (35.0, 0.27), (10.0, 0.0), (23.0, 0.2)):
        shown = one.step(7.0, current, ambient=ambient + ZERO_CELSIUS).temperature - ZERO_CELSIUS
        expected, *_ = SET_A.heat_up('current', current, expected, ambient, 7.0)
        assert shown == pytest.approx(expected, abs=1e-9, rel=0)
    kept = one.step(7.0, 0.2).temperature - ZERO_CELSIUS
    expected, *_ = SET_A.heat_up('current', 0.2, expected, 23.0, 7.0)
    assert kept == pytest.approx(expected, abs=1e-9, rel=0)


@given(amperes, celsius, celsius, seconds, seconds)
def test_two_steps_are_one(current, start, ambient, first, second):
    split = muscle(start=start, ambient=ambient)
    split.step(first, current)
    shown = split.step(second, current).fibre_temperature
    whole = muscle(start=start, ambient=ambient).step(first + second, current).fibre_temperature
    assert shown == pytest.approx(whole, abs=1e-9, rel=1e-13)


@given(celsius, celsius, seconds)
def test_without_current_the_temperature_stays_between_start_and_ambient(start, ambient, duration):
    low, high = sorted((start, ambient))
    assert low - 1e-12 <= after(duration, 0.0, start=start, ambient=ambient) <= high + 1e-12


@given(st.floats(0.0, 5.0), celsius, celsius, seconds)
def test_heating_never_takes_it_below_ambient_and_start(current, start, ambient, duration):
    # R > 0 here: it would be 0 at 23 - 1/0.003 = -310 degC.
    assert after(min(duration, 5.0), current, start=start, ambient=ambient) >= min(start, ambient) - 1e-12


@given(st.floats(0.05, 2.0), st.floats(30.0, 180.0))
def test_time_to_a_temperature(current, target):
    """Against the solution turned round: t = (C/lam) ln[(theta + P/lam) / (P/lam)]."""
    cold = current**2 * SET_A.R0
    lam = cold * SET_A.a_R - SET_A.hA
    ratio = 1.0 + (target - SET_A.T0) * lam / cold
    assume(abs(lam) > 1e-6 and ratio > 1e-3)  # not the straight line, nor a temperature this current never reaches
    duration = SET_A.C / lam * log(ratio)
    assert after(duration, current) == pytest.approx(target, abs=1e-8)


# --- energy ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('kind', 'drive'), [('current', 0.27), ('current', 0.9), ('power', 1.0), ('voltage', 4.4), ('current', 0.0)]
)
@pytest.mark.parametrize('dt', [0.001, 0.01, 1.0, 25.0])
def test_energy_closes(kind, drive, dt):
    one = muscle(start=50.0, ambient=10.0)
    steps = round(min(25.0, 1000 * dt) / dt)
    for _ in range(steps):
        last = one.step(dt, drive, kind)
    stored = SET_A.C * (last.fibre_temperature - ZERO_CELSIUS - 50.0)
    moved = one.heated + abs(one.lost)
    assert one.heated - one.lost == pytest.approx(stored, abs=1e-12 * moved, rel=0)


@pytest.mark.parametrize(('kind', 'drive'), [('current', 0.27), ('current', 0.9), ('power', 1.0)])
def test_heat_given_and_lost_are_the_integrals(kind, drive):
    _, heated, lost = SET_A.heat_up(kind, drive, 50.0, 10.0, 5.0)
    one = muscle(start=50.0, ambient=10.0)
    one.step(5.0, drive, kind)
    assert (one.heated, one.lost) == (pytest.approx(heated, rel=1e-11), pytest.approx(lost, rel=1e-11))


def test_a_recording_books_the_same_energy_as_its_steps():
    drive = np.where(np.arange(700) < 250, 0.27, 0.0)
    shown = simulate(A, np.arange(700) * 0.1, drive, load=0.5)
    assert shown.heated - shown.lost == pytest.approx(
        SET_A.C * (shown.fibre_temperature[-1] - shown.fibre_temperature[0]), abs=1e-12 * shown.heated
    )


def test_reset_begins_a_new_account():
    one = muscle()
    one.step(10.0, 0.27)
    one.reset()
    assert (one.heated, one.lost) == (0.0, 0.0)


# --- the two functions of the exact step -----------------------------------------------------------------------------


def series(z, first):
    """Sum of z^k / (k + first)!, which is phi_first(z)."""
    terms, term = [], 1.0
    for divisor in range(2, first + 1):
        term /= divisor
    for k in range(80):
        terms.append(term)
        term *= z / (k + 1 + first)
    return fsum(terms)


@settings(max_examples=500)
@given(st.floats(-5.0, 5.0) | st.floats(-0.02, 0.02) | st.floats(-1e-7, 1e-7))
def test_phi_functions_near_zero(z):
    # The series itself cancels for z < 0: its largest term bounds what it can tell.
    assert phi1(z) == pytest.approx(series(z, 1), rel=2e-13 * exp(max(0.0, -2 * z)))
    assert phi2(z) == pytest.approx(series(z, 2), rel=2e-13 * exp(max(0.0, -2 * z)))


@pytest.mark.parametrize('edge', [1e-8, -1e-8, 1e-2, -1e-2])
def test_phi_functions_have_no_seam(edge):
    inside, outside = np.nextafter(edge, 0.0), np.nextafter(edge, 2 * edge)
    assert phi1(inside) == pytest.approx(phi1(outside), rel=1e-15)
    assert phi2(inside) == pytest.approx(phi2(outside), rel=1e-13)


def test_phi_functions_of_a_long_cooling():
    assert phi1(-800.0) == pytest.approx(1 / 800, rel=1e-15)
    assert phi2(-800.0) == pytest.approx((1 - 1 / 800) / 800, rel=1e-15)

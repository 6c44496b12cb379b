"""The mechanical stage: softening, contraction, and a muscle under a load, held at a length, or against a spring."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from muscle.reference import CURRENTS, LOADS, SET_A
from scipy.optimize import brentq

from tcp_muscle_ros.muscle import ZERO_CELSIUS, Muscle, Parameters, length, stiffness

A = Parameters.named('karami_tadesse_2017')
LOVE = A.with_effects('geometric_stiffening')

newtons = st.floats(0.0, 1.0)
celsius = st.floats(-20.0, 150.0)
warm = st.floats(23.0, 120.0)


def shown(temperature, parameters=A, **options):
    """What a muscle shows at this temperature (degC)."""
    return Muscle(parameters, temperature=temperature + ZERO_CELSIUS, **options).reading()


# --- softening -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(('temperature', 'ratio'), [(23.0, 1.0), (80.0, 0.676), (100.0, 0.533)])
def test_softening(temperature, ratio):
    assert round(float(stiffness(A, temperature + ZERO_CELSIUS)) / 23.0, 3) == ratio


@pytest.mark.parametrize(('outside', 'edge'), [(120.5, 120.0), (400.0, 120.0), (-0.5, 0.0), (-60.0, 0.0)])
def test_outside_its_domain_the_modulus_stays_as_at_the_edge(outside, edge):
    cold, hot = length(A, edge + ZERO_CELSIUS, [0.0, 1.0]), length(A, outside + ZERO_CELSIUS, [0.0, 1.0])
    assert np.diff(hot) == pytest.approx(np.diff(cold), rel=1e-12)


@pytest.mark.parametrize(
    ('temperature', 'inside'), [(-0.01, False), (0.01, True), (23.0, True), (119.99, True), (120.01, False)]
)
def test_outside_its_domain_it_says_so(temperature, inside):
    reading = shown(temperature, load=0.5)
    assert reading.in_domain is inside
    assert np.isfinite(reading[:7]).all()


@given(celsius)
def test_stiffness_of_every_temperature(temperature):
    expected = SET_A.stiffness(temperature)
    assert stiffness(A, temperature + ZERO_CELSIUS) == pytest.approx(expected, rel=1e-11)


def test_a_modulus_fitted_to_zero_within_the_domain_keeps_the_muscle_from_falling_apart():
    # a3 this low puts the zero of equation 27 near 51 degC.
    reading = shown(100.0, A.replace(a3=106e6), load=0.3)
    assert reading.length == pytest.approx(
        SET_A.H0 + SET_A.thermal(100.0) + 0.3 / (23.0 * 1.06e6 / (106e6 - 0.4655e6 * 23.0**1.381)), rel=1e-9
    )


# --- under a load ----------------------------------------------------------------------------------------------------


# mm at the end of the first 25 s: 0.18, 0.21, 0.24, 0.27 A under 30, 60, 100 g.
DISPLACEMENTS = {
    30: (25.6, 37.1, 52.1, 71.4),
    60: (23.9, 34.5, 48.1, 65.2),
    100: (21.7, 31.1, 42.8, 57.1),
}


@pytest.mark.parametrize(('grams', 'force'), list(zip(DISPLACEMENTS, LOADS, strict=True)))
def test_twelve_displacements(grams, force):
    found = [Muscle(A, load=force).step(25.0, current).displacement for current in CURRENTS]
    assert [round(1e3 * x, 1) for x in found] == list(DISPLACEMENTS[grams])
    for current, x in zip(CURRENTS, found, strict=True):
        peak, *_ = SET_A.heat_up('current', current, 23.0, 23.0, 25.0)
        assert x == pytest.approx(SET_A.length(23.0, force) - SET_A.length(peak, force), abs=1e-12, rel=0)


def test_lengths_cold_and_at_80_degc():
    assert [round(1e3 * float(length(A, 23.0 + ZERO_CELSIUS, f)), 1) for f in LOADS] == [162.8, 175.6, 192.6]
    assert [round(1e3 * float(length(A, 80.0 + ZERO_CELSIUS, f)), 1) for f in LOADS] == [91.4, 110.3, 135.6]


def test_softening_alone_lengthens():
    softer = [f / float(stiffness(A, 80.0 + ZERO_CELSIUS)) - f / 23.0 for f in LOADS]
    assert [round(1e3 * x, 1) for x in softer] == [6.1, 12.3, 20.5]


@given(celsius, newtons)
def test_length_of_every_temperature_and_load(temperature, force):
    reading = shown(temperature, load=force)
    assert reading.length == pytest.approx(SET_A.length(temperature, force), abs=1e-13)
    assert reading.force == force
    assert not reading.slack


@given(warm, warm, newtons)
def test_it_contracts_on_heating_under_every_load_of_the_paper(low, high, force):
    low, high = sorted((low, min(high, 100.0)))
    assert shown(high, load=force).length <= shown(low, load=force).length + 1e-15


@given(warm, newtons, newtons)
def test_more_load_is_a_longer_muscle_and_less_stroke(temperature, light, heavy):
    light, heavy = sorted((light, heavy))
    assert shown(temperature, load=heavy).length >= shown(temperature, load=light).length
    assert shown(temperature, load=heavy).displacement <= shown(temperature, load=light).displacement + 1e-15


# --- the zero of displacement ----------------------------------------------------------------------------------------


@given(celsius, newtons)
def test_zero_is_rest_at_t0_under_the_starting_load_wherever_it_starts(temperature, force):
    assert shown(23.0, load=force).displacement == 0.0
    expected = SET_A.length(23.0, force) - SET_A.length(temperature, force)
    assert shown(temperature, load=force).displacement == pytest.approx(expected, abs=1e-13)


def test_the_zero_stays_and_a_load_step_shows():
    muscle = Muscle(A, load=0.3)
    assert muscle.reading(load=0.6).displacement == pytest.approx(-0.3 / 23.0, abs=1e-15)
    muscle.step(25.0, 0.27, load=0.6)
    hot = muscle.reading()
    assert muscle.reading(load=0.3).displacement - hot.displacement == pytest.approx(
        0.3 / SET_A.stiffness(hot.temperature - ZERO_CELSIUS), rel=1e-12
    )
    muscle.reset(23.0 + ZERO_CELSIUS)
    assert muscle.reading(load=0.3).displacement == pytest.approx(0.0, abs=1e-16)


# --- held ends -------------------------------------------------------------------------------------------------------


@given(celsius, st.floats(0.05, 0.3))
def test_blocked_force(temperature, held):
    reading = shown(temperature, end='blocked', held_length=held)
    assert reading.length == held
    assert reading.force == pytest.approx(SET_A.force(temperature, held), abs=1e-12)
    assert reading.slack is bool(reading.force == 0.0)


def test_blocked_at_its_rest_pulls_with_the_starting_load_and_stands_still():
    muscle = Muscle(A, end='blocked', load=0.5)
    assert muscle.reading().force == pytest.approx(0.5, rel=1e-14)
    hot = muscle.step(25.0, 0.27)
    assert hot.displacement == 0.0
    assert hot.force == pytest.approx(SET_A.force(hot.temperature - ZERO_CELSIUS, SET_A.length(23.0, 0.5)), rel=1e-12)
    assert hot.force > 1.5


@pytest.mark.parametrize('parameters', [A, LOVE], ids=['linear', 'Love'])
@given(temperature=warm, force=st.floats(0.001, 1.0))
def test_blocked_undoes_loaded(parameters, temperature, force):
    """F held at H(T, F) is F."""
    there = shown(temperature, parameters, load=force).length
    assume(there > 0.0)
    back = shown(temperature, parameters, end='blocked', held_length=there).force
    assert back == pytest.approx(force, rel=1e-9, abs=1e-12)


@given(celsius, newtons, st.floats(1.0, 1e4))
def test_against_a_spring(temperature, preload, rate):
    reading = shown(temperature, end='spring', load=preload, spring_rate=rate)
    distance = SET_A.length(23.0, preload) + preload / rate
    expected = SET_A.force(temperature, distance, 1.0 / rate)
    assert reading.force == pytest.approx(expected, abs=1e-11)
    if not reading.slack:
        assert reading.length == pytest.approx(distance - expected / rate, abs=1e-12)
        assert reading.length == pytest.approx(SET_A.length(temperature, expected), abs=1e-12)


def test_a_spring_by_where_its_far_end_is_fixed():
    reading = shown(60.0, end='spring', spring_rate=50.0, held_length=0.30, spring_rest_length=0.12)
    assert reading.force == pytest.approx(SET_A.force(60.0, 0.30 - 0.12, 1 / 50.0), rel=1e-12)


def test_a_stiff_spring_blocks_and_a_soft_one_loads():
    stiff = shown(80.0, end='spring', load=0.5, spring_rate=1e9)
    assert stiff.force == pytest.approx(shown(80.0, end='blocked', load=0.5).force, rel=1e-6)
    soft = shown(80.0, end='spring', load=0.5, spring_rate=1e-6)
    assert soft.displacement == pytest.approx(shown(80.0, load=0.5).displacement, rel=1e-6)


@pytest.mark.parametrize('end', [{'end': 'blocked'}, {'end': 'spring', 'spring_rate': 100.0}])
def test_it_cannot_push(end):
    """Held at its free length it pulls when heated, and hangs loose when cooled below."""
    muscle = Muscle(A, temperature=80.0 + ZERO_CELSIUS, ambient=5.0 + ZERO_CELSIUS, **end)
    assert muscle.reading().force > 0.5 and not muscle.reading().slack
    cold = muscle.step(300.0, 0.0)
    assert cold.force == 0.0
    assert cold.slack
    assert cold.displacement == pytest.approx(0.0, abs=1e-16)  # the end stays where it is held
    again = muscle.step(25.0, 0.27)
    assert again.force > 0.1 and not again.slack


# --- the coil as a rod -----------------------------------------------------------------------------------------------

L, H, N, MU = 0.5, 0.15, 280, 0.4
SINE, TAN2 = H / L, (H / L) ** 2 / (1 - (H / L) ** 2)
GJ = 23.0 * L**3 / (2 * np.pi * N) ** 2 / (1 + (1 + MU) * TAN2)
EI = (1 + MU) * GJ


def rod_energy(height):
    """U(H), J, of an inextensible Kirchhoff-Love rod coiled N times (docs/paper.md, in place of equation 19)."""
    cosine, cosine0 = np.sqrt(1 - (height / L) ** 2), np.sqrt(1 - SINE**2)
    return L / 2 * (2 * np.pi * N / L) ** 2 * (EI * (cosine - cosine0) ** 2 + GJ * (height / L - SINE) ** 2)


def rod_force(height):
    """F = dU/dH, N, by a central difference of fourth order."""
    h = 1e-4
    near, far = (rod_energy(height + d) - rod_energy(height - d) for d in (h, 2 * h))
    return (8 * near - far) / (12 * h)


@pytest.mark.parametrize(
    ('force', 'linear', 'love'),
    [
        (LOADS[0], 12.8, 12.6),
        (LOADS[1], 25.6, 24.7),
        (LOADS[2], 42.6, 40.2),
        (2.0, 87.0, 76.7),
        (5.0, 217.4, 157.4),
    ],
)
def test_elongation_of_spring_and_rod(force, linear, love):
    assert round(1e3 * (shown(23.0, load=force).length - H), 1) == linear
    assert round(1e3 * (shown(23.0, LOVE, load=force).length - H), 1) == love


@pytest.mark.parametrize('force', [0.05, *LOADS, 2.0, 5.0])
def test_the_rod_force_is_the_slope_of_its_energy(force):
    assert rod_force(shown(23.0, LOVE, load=force).length) == pytest.approx(force, rel=1e-8)


def test_the_rod_begins_as_the_spring():
    assert 1e-6 / (shown(23.0, LOVE, load=1e-6).length - H) == pytest.approx(23.0, rel=1e-5)
    assert (round(GJ, 9), round(EI, 8)) == (8.16e-7, 1.14e-6)


@given(warm, st.floats(0.01, 3.0))
def test_a_hot_rod_is_the_cold_rod_under_more_force(temperature, force):
    cold_force = force * 23.0 / SET_A.stiffness(temperature)
    stretch = shown(temperature, LOVE, load=force).length - H - SET_A.thermal(temperature)
    expected = brentq(lambda x: rod_force(H + x) - cold_force, 0.0, 0.3)
    assert stretch == pytest.approx(expected, abs=1e-9)

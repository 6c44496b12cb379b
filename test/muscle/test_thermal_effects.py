"""What each effect on the temperature is: its equation solved by another integrator."""

from math import exp, pi, sqrt, tanh

import numpy as np
import pytest
from muscle.effect_runs import NOMINAL, PULSE, assert_same, contraction, expand, model, ohms, protocol, solve, stiffness
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tcp_muscle_ros.muscle import Muscle, simulate


def test_radiation_and_heat_capacity_and_latent_heat_solve_their_equations():
    for name, lost, capacity in (
        ('radiation', lambda T: 0.5 * 5.670374419e-8 * pi * 0.75e-3 * 0.15 * (T**4 - 296.15**4), lambda T: 0.17),
        (
            'heat_capacity',
            lambda T: 0.0,
            lambda T: 0.17 * (1.0 + 0.12 * (tanh((T - 323.15) / 40.0) + tanh(27.0 / 40.0))),
        ),
        ('latent_heat', lambda T: 0.0, lambda T: 0.17 + 0.04 * exp(-(((T - 333.15) / 6.0) ** 2) / 2.0)),
    ):

        def rates(t, y, i, load, lost=lost, capacity=capacity):
            return [(i**2 * ohms(y[0]) - 0.01933 * (y[0] - 296.15) - lost(y[0])) / capacity(y[0])]

        (kelvin,) = solve(rates, [296.15], PULSE)
        assert_same(model(name, PULSE), kelvin, contraction(kelvin))


def test_what_melts_freezes_lower_by_its_undercooling_and_gives_its_heat_back():
    """Heated through the upper band and cooled through the lower one; turned round between them nothing changes."""
    muscle = NOMINAL.with_effects('latent_heat').replace({'latent_heat.u': 20.0, 'latent_heat.w': 3.0})
    time = np.arange(0.0, 400.0, 0.02)
    hot, between = 0.27, 0.2  # to 80 degC; and to 57, below the band that it went through before
    out = simulate(muscle, time, np.select([time < 60.0, time < 130.0], [hot, between], 0.0))
    kelvin, rate = out.fibre_temperature, np.gradient(out.fibre_temperature, time)
    flux = NOMINAL['hA'] * (kelvin - 296.15)
    heating = np.where(time < 60.0, hot, np.where(time < 130.0, between, 0.0)) ** 2 * out.resistance
    stored = (heating - flux) * 0.02

    def capacity(where):
        return float(np.median((stored / 0.02)[where] / rate[where]))

    warming, cooling = time < 59.0, time > 131.0
    near = np.abs(kelvin - 333.15) < 0.5, np.abs(kelvin - 313.15) < 0.5
    assert capacity(warming & near[0]) == pytest.approx(0.21, rel=0.01)
    assert capacity(warming & near[1]) == pytest.approx(0.17, rel=0.01)
    assert capacity(cooling & near[1]) == pytest.approx(0.21, rel=0.01)
    assert kelvin[(time > 125.0) & (time < 130.0)] == pytest.approx(kelvin[time < 130.0][-1], abs=0.1)
    assert 313.15 + 9.0 < kelvin[time < 130.0][-1] < 333.15
    assert np.sum(stored) == pytest.approx(0.17 * (kelvin[-1] - 296.15), abs=0.01)  # of 0.3 J of the transition


def test_exposed_area_and_motion_convection_solve_their_equations():
    def area(t, y, i, load):
        length = 0.15 + expand(y[0]) + load / stiffness(y[0])
        return [(i**2 * ohms(y[0]) - 0.01933 * sqrt(length / 0.15) * (y[0] - 296.15)) / 0.17]

    (kelvin,) = solve(area, [296.15], PULSE)
    assert_same(model('exposed_area', PULSE), kelvin, contraction(kelvin))

    def stirred(t, y, i, load):
        def length(T):
            return expand(T) + load / stiffness(T)

        slope = (length(y[0] + 1e-3) - length(y[0] - 1e-3)) / 2e-3
        loss = 0.01933 * (y[0] - 296.15)
        still = (i**2 * ohms(y[0]) - loss) / 0.17
        # v = slope dT/dt and dT/dt = still - (loss/C) c |v|, solved for |v| with the sign of v that of slope * still
        sign = np.sign(slope * still)
        speed = slope * still / (1.0 + slope * loss / 0.17 * 10.0 * sign)
        return [still - loss / 0.17 * 10.0 * abs(speed)]

    (kelvin,) = solve(stirred, [296.15], PULSE)
    assert_same(model('motion_convection', PULSE), kelvin, contraction(kelvin))


def test_motion_convection_goes_with_a_power_of_the_speed():
    """With the root of it; the motion, which depends on the heating that it changes, found by bracketing."""

    def stirred(t, y, i, load):
        def length(T):
            return expand(T) + load / stiffness(T)

        slope = (length(y[0] + 1e-3) - length(y[0] - 1e-3)) / 2e-3
        loss = 0.01933 * (y[0] - 296.15)

        def rate(speed):
            return (i**2 * ohms(y[0]) - loss * (1.0 + 10.0 * speed * (max(speed, 1e-5) / 0.01) ** -0.5)) / 0.17

        speed = brentq(lambda v: abs(slope * rate(v)) - v, 0.0, 1.0, xtol=1e-14) if rate(0.0) else 0.0
        return [rate(speed)]

    (kelvin,) = solve(stirred, [296.15], PULSE)
    assert_same(model('motion_convection', PULSE, {'n': 0.5}), kelvin, contraction(kelvin))


@pytest.mark.parametrize(('c', 'n'), [(30.0, 1.4), (40.0, 1.5), (100.0, 1.5), (100.0, 0.3)])
def test_a_muscle_that_cools_the_faster_it_moves_does_so_once(c, n):
    """Within the bounds of c and n there are motions that feed themselves without end: one of them could be chosen in
    one step and another in the next, which ended below the ambient temperature and far from the next muscle."""
    time, on = protocol(4.0, 140.0)
    muscle = NOMINAL.with_effects('motion_convection').replace({'motion_convection.c': c, 'motion_convection.n': n})
    one, next_to_it = (
        simulate(p, time, 0.30 * on, load=0.5884) for p in (muscle, muscle.replace({'hA': muscle['hA'] * (1.0 + 1e-6)}))
    )
    assert one.temperature.min() > 296.149
    assert np.abs(one.displacement - next_to_it.displacement).max() < 1e-6


def test_motion_convection_ends_where_motion_ends():
    time, on = protocol(20.0, 40.0)
    held, free = (
        simulate(p, time, 0.27 * on, load=0.5884, end='blocked')
        for p in (NOMINAL.with_effects('motion_convection'), NOMINAL)
    )
    assert held.temperature == pytest.approx(free.temperature, abs=1e-9)


def test_moisture_solves_its_equations():
    def rates(t, y, i, load):
        T, w = y
        dw = (0.015 * exp(-0.055 * (T - 296.15)) - w) / 15.0 * exp(0.065 * (T - 333.15))
        return [(i**2 * ohms(T) - 0.01933 * (T - 296.15) + 1e-4 * 2.4e6 * dw) / 0.17, dw]

    kelvin, _ = solve(rates, [296.15, 0.015], PULSE)
    assert_same(model('moisture', PULSE), kelvin, contraction(kelvin))


def test_two_node_solves_its_equations():
    def rates(t, y, i, load):
        flow = 0.12 * (y[0] - y[1])
        return [(i**2 * ohms(y[0]) - 0.01933 * (y[0] - 296.15) - flow) / 0.085, flow / 0.085]

    sheath, core = solve(rates, [296.15, 296.15], PULSE)
    assert_same(model('two_node', PULSE), sheath, contraction(core))
    assert_same(model('two_node', PULSE, {'pull': 1.0}), sheath, contraction(0.5 * (sheath + core)))


def test_end_conduction_solves_its_equations():
    eta, tau = 2.0 * 0.005 / 0.15, 0.17 / 0.01933

    def rates(t, y, i, load):
        T, deficit = y
        middle = T + deficit - 296.15
        loss = 0.01933 * (T - 296.15) + 0.01933 * (2.0 * eta * middle - deficit)
        return [(i**2 * ohms(T) - loss) / 0.17, 2.0 * (eta * middle - deficit) / tau]

    kelvin, deficit = solve(rates, [296.15, 0.0], PULSE)
    assert_same(model('end_conduction', PULSE), kelvin, contraction(kelvin), shown=kelvin + deficit)


def test_end_conduction_loses_as_a_fin_does():
    """A rod cut into 600 cells with cold ends: mean and middle temperature, steady and on the way."""
    n, length, fin, tau = 600, 0.15, 0.003, 0.17 / 0.01933
    diffusivity, cell = fin**2 / tau, length / n
    power = 0.25**2 * 14.0 / 0.17

    def rates(t, theta):
        padded = np.concatenate(([-theta[0]], theta, [-theta[-1]]))
        return diffusivity * np.diff(padded, 2) / cell**2 - theta / tau + power

    done = solve_ivp(rates, (0.0, 60.0), np.zeros(n), method='BDF', t_eval=[10.0, 60.0], rtol=1e-8, atol=1e-8)
    p = NOMINAL.replace({'a_R': 0.0, 'end_conduction.l': fin}).with_effects('end_conduction')
    run = simulate(p, np.arange(601) * 0.1, 0.25)
    for at, row, tolerance in ((100, 0, 0.12), (600, 1, 0.01)):
        middle, mean = done.y[n // 2, row], done.y[:, row].mean()
        assert run.temperature[at] - 296.15 == pytest.approx(middle, rel=0.01)
        shown = run.temperature[at] - run.fibre_temperature[at]
        assert shown == pytest.approx(middle - mean, rel=tolerance)


def test_a_load_jump_warms_the_muscle_as_its_entropy_says():
    """C ln T + F dD/dT + F^2/2 d(1/k)/dT is the same before and after: 1.8 K for 0.69 N at 70 degC, and back again."""
    p = NOMINAL.with_effects('elastocaloric')
    muscle = Muscle(p, load=0.2942, ambient=343.15)
    before = muscle.reading(0.0, load=0.2942).temperature
    after = muscle.reading(0.0, load=0.9807).temperature

    def entropy(T: float, force: float) -> float:
        thermal = (expand(T + 0.01) - expand(T - 0.01)) / 0.02
        soft = (1.0 / stiffness(T + 0.01) - 1.0 / stiffness(T - 0.01)) / 0.02
        return 0.17 * np.log(T) + force * thermal + 0.5 * force**2 * soft

    assert before == pytest.approx(343.15, abs=1e-9)
    assert after - before == pytest.approx(1.8, abs=0.15)
    # The terms of second order, T-dependence of the expansion over 1.8 K, are below a hundredth.
    assert entropy(after, 0.9807) == pytest.approx(entropy(before, 0.2942), abs=0.01 * 0.17 * 1.8 / 343.15)
    assert muscle.reading(0.0, load=0.2942).temperature == pytest.approx(before, abs=1e-9)


def test_a_held_muscle_heats_by_its_own_force():
    """At constant length the capacity is C + T (dH/dT)^2 / (dH/dF), seen from constant force: it heats more slowly."""

    def rates(t, y, i, load):
        T, force = y
        k = stiffness(T)
        slope = (expand(T + 0.01) - expand(T - 0.01)) / 0.02 + force * (
            1.0 / stiffness(T + 0.01) - 1.0 / stiffness(T - 0.01)
        ) / 0.02
        rate = (i**2 * ohms(T) - 0.01933 * (T - 296.15)) / (0.17 - T * slope**2 * k)
        return [rate, -slope * k * rate]

    kelvin, force = solve(rates, [296.15, 0.5884], PULSE)
    run = model('elastocaloric', PULSE, end='blocked')
    assert run.temperature == pytest.approx(kelvin, abs=1e-6)
    assert run.force == pytest.approx(force, abs=1e-7)


def test_airflow_and_ambient_drift_solve_their_equations():
    def step(z):
        return 1.0 / (1.0 + exp(-z / 0.5))

    def gust(t, y, i, load):
        factor = 1.0 + 0.3 * (step(t - 10.0) - step(t - 18.0))
        return [(i**2 * ohms(y[0]) - 0.01933 * factor * (y[0] - 296.15)) / 0.17]

    (kelvin,) = solve(gust, [296.15], PULSE)
    assert_same(model('airflow', PULSE, {'t1': 10.0, 'd': 8.0}), kelvin, contraction(kelvin))

    def warming(t, y, i, load):
        z = t / 30.0 if t < 30.0 else 1.0
        ambient = 296.15 + 1.5 * (z + 0.8 * z * (1.0 - z) - 2.0 * z * (1.0 - z) * (1.0 - 2.0 * z))
        return [(i**2 * ohms(y[0]) - 0.01933 * (y[0] - ambient)) / 0.17]

    (kelvin,) = solve(warming, [296.15], PULSE)
    drift = model('ambient_drift', PULSE, {'a': 1.5, 'b': 0.8, 'c': -2.0, 'tau': 30.0})
    assert_same(drift, kelvin, contraction(kelvin))

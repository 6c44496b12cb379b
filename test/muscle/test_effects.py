"""What every effect of the registry keeps, whoever adds it, and what each of them is.

E0 is the paper's protocol: 25 s on, 45 s off, three cycles, 0.18 to 0.27 A, 30 to 100 g.
"""

from functools import cache
from itertools import product
from math import cosh, exp, log, log1p, pi, sqrt, tanh

import numpy as np
import pytest
from muscle.reference import Sample
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tcp_muscle_ros.muscle import EFFECTS, Muscle, Outputs, Parameters, simulate
from tcp_muscle_ros.muscle.layout import STATES
from tcp_muscle_ros.muscle.points import HEATING_POINTS

NOMINAL = Parameters.named('karami_tadesse_2017')
LOADS = (0.2942, 0.5884, 0.9807)
CURRENTS = (0.18, 0.27)
# The catalogue: every name, its row and its stage. Rows without a name are out of scope.
CATALOGUE = {
    'resistance_strain': ('E-01', 'electrical'),
    'contact_shorting': ('E-02', 'electrical'),
    'contact_resistance': ('E-03', 'electrical'),
    'tcr_curvature': ('E-04', 'electrical'),
    'resistance_drift': ('E-05', 'electrical'),
    'supply_lag': ('E-06', 'electrical'),
    'natural_convection': ('T-01', 'thermal'),
    'radiation': ('T-02', 'thermal'),
    'airflow': ('T-03', 'thermal'),
    'ambient_drift': ('T-04', 'thermal'),
    'motion_convection': ('T-05', 'thermal'),
    'exposed_area': ('T-06', 'thermal'),
    'heat_capacity': ('T-07', 'thermal'),
    'latent_heat': ('T-08', 'thermal'),
    'moisture': ('T-09', 'thermal'),
    'two_node': ('T-10', 'thermal'),
    'end_conduction': ('T-11', 'thermal'),
    'elastocaloric': ('T-12', 'thermal'),
    'creep': ('M-01', 'mechanical'),
    'viscous_flow': ('M-02', 'mechanical'),
    'hysteresis': ('M-03', 'mechanical'),
    'branch_cte': ('M-04', 'mechanical'),
    'shear_softening': ('M-05', 'mechanical'),
    'load_stroke': ('M-06', 'mechanical'),
    'geometric_stiffening': ('M-07', 'mechanical'),
    'cte_kink': ('M-08', 'mechanical'),
    'coil_contact': ('M-09', 'mechanical'),
    'slack': ('M-10', 'mechanical'),
    'first_cycle': ('M-11', 'mechanical'),
    'fatigue': ('M-12', 'mechanical'),
    'inertia': ('M-13', 'mechanical'),
    'friction': ('M-14', 'mechanical'),
    'torsional_leakage': ('M-16', 'mechanical'),
    'thermocouple_lag': ('S-01', 'sensor'),
    'thermocouple_gain': ('S-02', 'sensor'),
    'temperature_offset': ('S-03', 'sensor'),
    'displacement_drift': ('S-04', 'sensor'),
    'displacement_offset': ('', 'sensor'),
    'clock_skew': ('S-05', 'sensor'),
    'current_gain': ('', 'sensor'),
}
NOISE = {'temperature': 0.2, 'resistance': 0.02, 'displacement': 5e-5}
INVISIBLE = {'elastocaloric'}  # at constant force nothing is left of it
every_effect = pytest.mark.parametrize('name', EFFECTS)


def protocol(rate_hz: float = 20.0, duration: float = 210.0, cycle: float = 70.0) -> tuple[np.ndarray, np.ndarray]:
    """Time and whether the current is on."""
    time = np.arange(round(duration * rate_hz) + 1) / rate_hz
    return time, np.mod(np.arange(time.size), round(cycle * rate_hz)) < round(25 / 70 * cycle * rate_hz)


def e0(parameters: Parameters, load: float, current: float) -> Outputs:
    time, on = protocol()
    return simulate(parameters, time, current * on, load=load)


@cache
def baseline(load: float, current: float) -> Outputs:
    return e0(NOMINAL, load, current)


def channels(run: Outputs) -> dict[str, np.ndarray]:
    names = ('temperature', 'fibre_temperature', 'resistance', 'displacement', 'force', 'current', 'voltage', 'power')
    return {name: getattr(run, name) for name in names}


def at_strength(name: str, value: float) -> Parameters:
    return NOMINAL.replace({f'{name}.{EFFECTS[name].strength}': value}).with_effects(name)


def default_strength(name: str) -> float:
    return NOMINAL[f'{name}.{EFFECTS[name].strength}']


# --- what every effect keeps ---------------------------------------------------------------------------------------


def test_the_registry_is_the_catalogue():
    assert {name: (effect.row, effect.stage) for name, effect in EFFECTS.items()} == CATALOGUE


@every_effect
def test_it_has_one_to_three_documented_parameters(name):
    effect = EFFECTS[name]
    rows = {row.name: row for row in effect.parameters}
    assert 1 <= len(effect.fitted) <= 3
    assert effect.equation and effect.source
    for row in rows.values():
        assert row.low <= row.value <= row.high
        assert row.unit and row.meaning and row.source
    strength = rows[effect.strength]
    assert strength.low <= effect.none <= strength.high
    assert strength.value != effect.none


@every_effect
def test_off_it_changes_no_bit(name):
    moved = {f'{name}.{row.name}': row.high for row in EFFECTS[name].parameters}
    run = e0(NOMINAL.replace(moved), 0.5884, 0.27)
    for channel, values in channels(baseline(0.5884, 0.27)).items():
        assert channels(run)[channel].tobytes() == values.tobytes(), channel
    assert (run.heated, run.lost) == (baseline(0.5884, 0.27).heated, baseline(0.5884, 0.27).lost)


@every_effect
def test_without_strength_it_is_the_resolved_model(name):
    run = e0(at_strength(name, EFFECTS[name].none), 0.5884, 0.27)
    for channel, values in channels(baseline(0.5884, 0.27)).items():
        assert channels(run)[channel] == pytest.approx(values, abs=1e-9, rel=0.0), channel


@every_effect
def test_it_grows_from_nothing_in_proportion(name):
    """A fit that starts at nothing sees a slope."""
    effect = EFFECTS[name]
    step = 1e-3 * (default_strength(name) - effect.none)
    load = LOADS[0] if name in ('slack', 'coil_contact') else LOADS[1]
    once, twice = (e0(at_strength(name, effect.none + factor * step), load, 0.27) for factor in (1.0, 2.0))
    nothing = baseline(load, 0.27)
    for channel, noise in NOISE.items():
        first = channels(once)[channel] - channels(nothing)[channel]
        second = channels(twice)[channel] - channels(nothing)[channel]
        if np.abs(second).max() > 1e-5 * noise:
            assert np.linalg.norm(second - 2.0 * first) < 0.02 * np.linalg.norm(second), channel


@every_effect
def test_it_is_seen_in_e0(name):
    """Some channel differs from the resolved model by more than its noise, in one of the loads and currents."""
    seen = False
    for load, current in product(LOADS, CURRENTS):
        run = channels(e0(NOMINAL.with_effects(name), load, current))
        nothing = channels(baseline(load, current))
        seen |= any(np.abs(run[channel] - nothing[channel]).max() > noise for channel, noise in NOISE.items())
    assert seen is (name not in INVISIBLE)


@every_effect
@pytest.mark.parametrize('end', ['load', 'blocked', 'spring'])
def test_it_stays_finite_at_any_end_and_with_any_source(name, end):
    time, on = protocol(10.0, 80.0)
    for (kind, drive), load in product((('current', 0.27), ('power', 1.02), ('voltage', 4.4)), (LOADS[0], LOADS[2])):
        run = simulate(NOMINAL.with_effects(name), time, drive * on, kind=kind, load=load, end=end, spring_rate=40.0)
        for channel, values in channels(run).items():
            assert np.all(np.isfinite(values)), (kind, load, channel)
        assert run.force.min() >= 0.0
        assert run.fibre_temperature.min() > 290.0 and run.fibre_temperature.max() < 420.0


@pytest.mark.parametrize('end', ['load', 'blocked', 'spring'])
@pytest.mark.parametrize('kind', ['current', 'power', 'voltage'])
def test_all_at_once_stay_finite(kind, end):
    time, on = protocol(10.0, 8.0, 8.0)
    drive = {'current': 0.27, 'power': 1.02, 'voltage': 4.4}[kind]
    load = np.where(time < 4.0, LOADS[0], LOADS[2])
    run = simulate(NOMINAL.with_effects(*EFFECTS), time, drive * on, kind=kind, load=load, end=end, spring_rate=40.0)
    for channel, values in channels(run).items():
        assert np.all(np.isfinite(values)), channel
    assert run.fibre_temperature.min() > 290.0 and run.fibre_temperature.max() < 420.0


@pytest.mark.parametrize('seed', range(6))
def test_any_subset_stays_finite(seed):
    rng = np.random.default_rng(seed)
    names = rng.choice(list(EFFECTS), size=5, replace=False)
    time, on = protocol(10.0, 80.0)
    end = ('load', 'blocked', 'spring')[seed % 3]
    run = simulate(NOMINAL.with_effects(*names), time, 0.27 * on, load=rng.choice(LOADS), end=end, spring_rate=40.0)
    for channel, values in channels(run).items():
        assert np.all(np.isfinite(values)), (names, channel)


@every_effect
def test_heat_is_booked(name):
    """What was released and not lost is in the muscle: exactly where its capacity is constant."""
    time, on = protocol(20.0, 40.0)
    load = np.where(time < 20.0, LOADS[0], LOADS[2])
    muscle = Muscle(NOMINAL.with_effects(name), load=LOADS[0])
    start = muscle.reading(0.0).fibre_temperature
    for current, force in zip(0.27 * on, load, strict=True):
        end = muscle.step(0.05, current, load=force).fibre_temperature
    stored = NOMINAL['C'] * (end - start)
    gained = muscle.heated - muscle.lost
    assert muscle.heated > 20.0 and muscle.lost > 0.0
    if name == 'two_node':
        f, core = NOMINAL['two_node.f'], muscle.state[STATES['two_node']][0]
        assert gained == pytest.approx((1.0 - f) * stored + f * NOMINAL['C'] * (core - start), rel=1e-8)
    elif name == 'heat_capacity':
        c, middle, width = (NOMINAL[f'heat_capacity.{key}'] for key in ('c', 'Tg', 'w'))
        risen = width * log(cosh((end - middle) / width) / cosh((start - middle) / width)) / (end - start)
        mean = 1.0 + c * width * (risen - tanh((296.15 - middle) / width))
        assert gained == pytest.approx(stored * mean, rel=1e-8)
    elif name == 'latent_heat':
        assert gained > stored
    else:
        assert gained == pytest.approx(stored, rel=1e-8)


# --- what each effect is: its equation solved by another integrator ------------------------------------------------

PAPER = Sample()
STEP = 0.01  # s


def expand(kelvin: np.ndarray | float) -> np.ndarray | float:
    return PAPER.thermal(kelvin - 273.15)


def stiffness(kelvin: np.ndarray | float) -> np.ndarray | float:
    return PAPER.stiffness(kelvin - 273.15)


def ohms(kelvin: float) -> float:
    return 14.0 * (1.0 + 0.003 * (kelvin - 296.15))


def solve(rates, start, segments, method: str = 'DOP853') -> np.ndarray:
    """States every STEP over segments (seconds, current A, load N) of constant input; shape (states, samples)."""
    states, columns, begin = np.array(start, dtype=float), [], 0.0
    for seconds, current, load in segments:
        at = np.arange(round(seconds / STEP) + 1) * STEP
        done = solve_ivp(
            lambda t, y, i=current, f=load, t0=begin: rates(t0 + t, y, i, f),
            (0.0, at[-1]),
            states,
            method=method,
            t_eval=at,
            rtol=1e-12,
            atol=1e-13,
        )
        assert done.success
        columns.append(done.y[:, :-1])
        states, begin = done.y[:, -1], begin + seconds
    return np.hstack([*columns, states[:, None]])


def model(name: str, segments, values=None, **options) -> Outputs:
    time, currents, loads = [], [], []
    for seconds, current, load in segments:
        n = round(seconds / STEP)
        currents += [current] * n
        loads += [load] * n
    time = np.arange(len(currents) + 1) * STEP
    p = NOMINAL.replace({f'{name}.{key}': value for key, value in (values or {}).items()}).with_effects(name)
    return simulate(p, time, [*currents, currents[-1]], load=[*loads, loads[-1]], **options)


def assert_same(run: Outputs, kelvin, displacement, shown=None) -> None:
    assert run.fibre_temperature == pytest.approx(kelvin, abs=1e-6, rel=0.0)
    assert run.temperature == pytest.approx(kelvin if shown is None else shown, abs=1e-6, rel=0.0)
    assert run.displacement == pytest.approx(displacement, abs=1e-9, rel=0.0)


PULSE = ((12.0, 0.27, 0.5884), (10.0, 0.0, 0.5884), (5.0, 0.2, 0.5884))
PULSE_AND_LOAD = ((8.0, 0.27, 0.5884), (6.0, 0.27, 0.2942), (8.0, 0.0, 0.5884))


def contraction(kelvin, load=0.5884):
    return load / 23.0 - expand(kelvin) - load / stiffness(kelvin)


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


def test_lags_solve_their_equations():
    def bead(t, y, i, load):
        return [(i**2 * ohms(y[0]) - 0.01933 * (y[0] - 296.15)) / 0.17, (y[0] - y[1]) / 2.0]

    kelvin, shown = solve(bead, [296.15, 296.15], PULSE)
    assert_same(model('thermocouple_lag', PULSE), kelvin, contraction(kelvin), shown)

    def supply(t, y, i, load):
        return [(y[1] ** 2 * ohms(y[0]) - 0.01933 * (y[0] - 296.15)) / 0.17, (i - y[1]) / 0.5]

    kelvin, _ = solve(supply, [296.15, 0.0], PULSE)
    run = model('supply_lag', PULSE)
    assert_same(run, kelvin, contraction(kelvin))
    assert run.current[0] == 0.27 and run.power[0] == 0.0  # the display shows the setting, the muscle gets nothing yet


def test_creep_and_viscous_flow_solve_their_equations():
    def creep(t, y, i, load):
        T, xv = y
        wanted = 0.1 * load / stiffness(T)
        return [(i**2 * ohms(T) - 0.01933 * (T - 296.15)) / 0.17, (wanted - xv) / 15.0 * exp(0.07 * (T - 323.15))]

    kelvin, late = solve(creep, [296.15, 0.1 * 0.5884 / 23.0], PULSE_AND_LOAD)
    run = model('creep', PULSE_AND_LOAD)
    load = np.repeat([0.5884, 0.2942, 0.5884], [800, 600, 801])
    assert_same(run, kelvin, 1.1 * 0.5884 / 23.0 - expand(kelvin) - load / stiffness(kelvin) - late)

    def flow(t, y, i, load):
        T, _ = y
        return [(i**2 * ohms(T) - 0.01933 * (T - 296.15)) / 0.17, 1e-5 * load * exp(0.05 * (T - 333.15))]

    kelvin, flown = solve(flow, [296.15, 0.0], PULSE_AND_LOAD)
    run = model('viscous_flow', PULSE_AND_LOAD)
    assert_same(run, kelvin, 0.5884 / 23.0 - expand(kelvin) - load / stiffness(kelvin) - flown)


def test_inertia_solves_its_equations():
    def swing(t, y, i, load):
        T, height, speed = y
        k, mass = stiffness(T), load / 9.80665
        equilibrium = 0.15 + expand(T) + load / k
        pull = max(0.0, load + k * (height - equilibrium))
        force = load - pull - 2.0 * 0.05 * sqrt(k * mass) * speed
        return [(i**2 * ohms(T) - 0.01933 * (T - 296.15)) / 0.17, speed, force / mass]

    rest = 0.15 + 0.5884 / 23.0
    kelvin, height, _ = solve(swing, [296.15, rest, 0.0], PULSE)
    assert_same(model('inertia', PULSE), kelvin, rest - height)


@pytest.mark.parametrize('pressed', [0.0, 0.5, 1.0])
def test_a_weight_that_leaps_presses_on_the_muscle_as_far_as_its_coil_holds(pressed):
    """From 1 N to 0.3 N it swings higher than the muscle is long without a load."""
    heavy, light, k = 0.9807, 0.2942, stiffness(296.15)

    def swing(t, y):
        pull = k * y[0]
        force = light - (pull if pull > 0.0 else pressed * pull) - 2.0 * 0.05 * sqrt(k * light / 9.80665) * y[1]
        return [y[1], force * 9.80665 / light]

    time = np.arange(401) * STEP
    run = simulate(
        NOMINAL.replace({'inertia.q': pressed}).with_effects('inertia'), time, 0.0, load=light, starting_load=heavy
    )
    stretch = solve_ivp(swing, (0.0, time[-1]), [heavy / k, 0.0], t_eval=time, rtol=1e-10, atol=1e-12).y[0]
    assert stretch.min() < -0.01
    assert run.displacement - run.displacement[0] == pytest.approx(heavy / k - stretch, abs=2e-5)


def test_inertia_rings_at_the_frequency_of_spring_and_weight():
    time = np.arange(400) * 0.005
    run = simulate(
        NOMINAL.with_effects('inertia'), time, 0.0, load=np.where(time < 0.1, 0.5, 0.5884), starting_load=0.5884
    )
    late = run.displacement[21:]
    crossings = np.flatnonzero(np.diff(np.sign(late - late[-60:].mean())))
    hertz = 0.5 / (np.diff(crossings).mean() * 0.005)
    assert hertz == pytest.approx(sqrt(23.0 * 9.80665 / 0.5884) / (2.0 * pi), rel=0.03)  # 3.1 Hz at 60 g


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


def test_effects_of_the_resistance_solve_their_equations():
    rest = 0.15 + 0.5884 / 23.0
    for name, ohm in (
        ('tcr_curvature', lambda t, T, H: 14.0 * (1.0 + 0.003 * (T - 296.15) - 4e-6 * (T - 296.15) ** 2)),
        ('contact_shorting', lambda t, T, H: ohms(T) * (1.0 - 0.1 / (1.0 + exp((H - 0.087) / 0.005)))),
        ('resistance_drift', lambda t, T, H: ohms(T) * (1.0 + 1e-4 * t)),
        ('resistance_strain', lambda t, T, H: ohms(T) * (1.0 + 0.15 * (H - 0.15) / 0.15)),
    ):

        def rates(t, y, i, load, ohm=ohm):
            length = rest - contraction(y[0])
            return [(i**2 * ohm(t, y[0], length) - 0.01933 * (y[0] - 296.15)) / 0.17]

        (kelvin,) = solve(rates, [296.15], PULSE)
        run = model(name, PULSE)
        assert_same(run, kelvin, contraction(kelvin))
        expected = [ohm(t, T, rest - contraction(T)) for t, T in zip(run.time, kelvin, strict=True)]
        assert run.resistance == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize(('kind', 'drive'), [('current', 0.27), ('power', 1.02), ('voltage', 4.4)])
def test_contact_resistance_is_in_series(kind, drive):
    time, on = protocol(20.0, 40.0)
    run = simulate(NOMINAL.with_effects('contact_resistance'), time, drive * on, kind=kind, load=0.5884)
    hot = on & (time > 0)
    assert run.resistance - 0.5 == pytest.approx(ohms(run.temperature), abs=1e-9)
    assert run.voltage[hot] / run.current[hot] == pytest.approx(run.resistance[hot])
    assert run.power[hot] == pytest.approx(run.current[hot] * run.voltage[hot])
    released = np.sum((run.power * (1.0 - 0.5 / run.resistance))[:-1] * np.diff(time))
    assert run.heated == pytest.approx(released, rel=5e-3)  # rectangles over 50 ms


@pytest.mark.parametrize('zero', [0.0, 0.004, -0.004])
@pytest.mark.parametrize(('kind', 'drive'), [('current', 0.27), ('power', 1.02), ('voltage', 4.4)])
def test_current_gain_is_in_what_the_ammeter_shows(kind, drive, zero):
    time, on = protocol(20.0, 40.0)
    run = simulate(
        NOMINAL.replace({'current_gain.z': zero}).with_effects('current_gain'), time, drive * on, kind=kind, load=0.5884
    )
    g = NOMINAL['current_gain.g']
    assert getattr(run, kind) == pytest.approx(drive * on, abs=1e-10)  # what was recorded is what was shown
    flowing = run.current > 0.0
    assert np.array_equal(flowing, on)
    i = g * (run.current[flowing] - zero)
    true = ohms(run.temperature)[flowing]
    assert run.resistance[flowing] == pytest.approx(i * true / run.current[flowing], abs=1e-8)
    assert run.voltage[flowing] == pytest.approx(i * true, abs=1e-8)
    # What really flowed, set with a right ammeter, heats as much (a power with a zero is not constant over a tick).
    really = np.zeros(time.size)
    really[flowing] = {'current': i, 'power': i * run.voltage[flowing], 'voltage': run.voltage[flowing]}[kind]
    right = simulate(NOMINAL, time, really, kind=kind, load=0.5884)
    assert run.temperature == pytest.approx(right.temperature, abs=1e-3 if kind == 'power' and zero else 1e-8)


@pytest.mark.parametrize('drive', [0.001, 0.0031, 0.0035])
def test_an_ammeter_whose_zero_is_as_large_as_the_current_neither_turns_it_round_nor_shows_any_resistance(drive):
    """What flows has the sign of what is set, and what is shown stays near what is there."""
    time = 0.05 * np.arange(40)
    muscle = NOMINAL.replace({'current_gain.z': 0.003}).with_effects('current_gain')
    run = simulate(muscle, time, drive, load=0.5884)
    assert np.all(run.voltage >= 0.0)
    assert np.all(run.temperature[1:] >= 296.15)
    assert np.all((run.resistance > ohms(296.15) / 3.1) & (run.resistance < 3.1 * ohms(296.15)))


@pytest.mark.parametrize('rate_hz', [20.0, 100.0])
@pytest.mark.parametrize('delay', [0.05, 0.2, 0.3, 0.5])
def test_clock_skew_is_a_pure_delay(rate_hz, delay):
    time, on = protocol(rate_hz, 60.0)
    skewed = simulate(NOMINAL.replace({'clock_skew.d': delay}).with_effects('clock_skew'), time, 0.27 * on, load=0.5)
    plain = simulate(NOMINAL, time, 0.27 * on, load=0.5)
    late = np.interp(time - delay, time, plain.temperature)
    assert skewed.temperature == pytest.approx(late, abs=0.03 if (rate_hz, delay) == (100.0, 0.5) else 1e-3)
    assert skewed.displacement == pytest.approx(plain.displacement, abs=1e-12)


@pytest.mark.parametrize(
    ('number', 'channel', 'end'), [(1, 'displacement', 'load'), (2, 'resistance', 'load'), (3, 'force', 'blocked')]
)
def test_any_channel_may_come_from_a_clock_that_is_late_and_slow(number, channel, end):
    time, on = protocol(20.0, 60.0)
    load = np.where((time > 29.99) & (time < 44.99), 0.9, 0.5)  # its jumps stay jumps
    values = {'clock_skew.d': 0.23, 'clock_skew.r': 2e-3, 'clock_skew.channel': float(number)}
    more = {'end': end, 'starting_load': 0.5} if end == 'blocked' else {'load': load}
    skewed = simulate(NOMINAL.replace(values).with_effects('clock_skew'), time, 0.27 * on, **more)
    plain = simulate(NOMINAL, time, 0.27 * on, **more)
    fine = np.arange(round(60.0 * 2000.0) + 1) / 2000.0
    if end == 'load':
        more = {'load': np.where((fine > 29.9999) & (fine < 44.9999), 0.9, 0.5)}
    true = simulate(NOMINAL, fine, 0.27 * (np.mod(np.arange(fine.size), 140000) < 50000), **more)
    late = np.interp(time - 0.23 - 2e-3 * time, fine, getattr(true, channel))
    shown, was = getattr(skewed, channel), getattr(plain, channel)
    assert np.max(np.abs(was - late)) > 30 * np.max(np.abs(shown - late)[5:])
    others = {'temperature', 'resistance', 'displacement', 'force'} - {channel}
    for name in others:
        assert getattr(skewed, name) == pytest.approx(getattr(plain, name), abs=1e-9)


def test_sensor_errors_are_what_they_say():
    plain = baseline(0.5884, 0.27)
    gain = e0(NOMINAL.with_effects('thermocouple_gain'), 0.5884, 0.27)
    assert gain.temperature == pytest.approx(296.15 + 0.93 * (plain.temperature - 296.15), abs=1e-8)
    offset = e0(NOMINAL.with_effects('temperature_offset'), 0.5884, 0.27)
    assert offset.temperature == pytest.approx(plain.temperature + 0.5, abs=1e-8)
    drift = e0(NOMINAL.with_effects('displacement_drift'), 0.5884, 0.27)
    assert drift.displacement == pytest.approx(plain.displacement + 2.5e-6 * plain.time, abs=1e-12)
    course = {'displacement_drift.b': 0.8, 'displacement_drift.c': -2.0, 'displacement_drift.tau': 30.0}
    bent = e0(NOMINAL.replace(course).with_effects('displacement_drift'), 0.5884, 0.27)
    z = np.minimum(plain.time / 30.0, 1.0)
    way = 2.5e-6 * plain.time * (1.0 + (1.0 - z) * (0.8 - 2.0 * (1.0 - 2.0 * z)))
    assert bent.displacement == pytest.approx(plain.displacement + way, abs=1e-12)
    zero = e0(NOMINAL.with_effects('displacement_offset'), 0.5884, 0.27)
    assert zero.displacement == pytest.approx(plain.displacement + 5e-4, abs=1e-12)


def test_static_mechanics_are_what_they_say():
    """Each length as a function of the temperature of the baseline, written out."""
    load = LOADS[0]
    plain = baseline(load, 0.27)
    T = plain.fibre_temperature
    k, rest = stiffness(T), 0.15 + load / 23.0
    thermal = expand(T)
    resolved = 0.15 + thermal + load / k

    def alpha_times(driving):
        return (0.25 / 0.15) * (-3.5e-6 * driving + 4.2e-4) * (driving - 296.15)

    def above(x):
        return 4.0 * np.log1p(np.exp(x / 4.0))

    gap = 0.0025 * exp(-load / 0.1)
    kinked = T - 0.5 * (T - 296.15 - above(T - 323.15) + above(296.15 - 323.15))
    for name, length, start in (
        ('shear_softening', 0.15 + thermal + load / (23.0 * (k / 23.0) ** 0.59), rest),
        ('load_stroke', 0.15 + thermal / (1.0 + load / (23.0 * 0.15)) + load / k, rest),
        ('cte_kink', 0.15 + alpha_times(kinked) + load / k, rest),
        (
            'coil_contact',
            resolved + 0.95 * 0.002 * np.log1p(np.exp((0.095 - resolved) / 0.002)),
            rest + 0.95 * 0.002 * log1p(exp((0.095 - rest) / 0.002)),
        ),
        ('slack', resolved + gap * np.array([tanh(value) for value in -thermal / gap]), rest),
    ):
        run = e0(NOMINAL.with_effects(name), load, 0.27)
        assert run.displacement == pytest.approx(start - length, abs=1e-9), name


def test_load_stroke_may_grow_with_the_square_of_the_load():
    load = LOADS[0]
    T = baseline(load, 0.27).fibre_temperature
    opened = load / (23.0 * 0.15)
    length = 0.15 + expand(T) / (1.0 + opened**2 / 0.2) + load / stiffness(T)
    run = e0(NOMINAL.replace({'load_stroke.law': 1.0}).with_effects('load_stroke'), load, 0.27)
    assert run.displacement == pytest.approx(0.15 + load / 23.0 - length, abs=1e-9)


# --- effects that switch -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    'name', ['hysteresis', 'friction', 'first_cycle', 'branch_cte', 'fatigue', 'torsional_leakage']
)
def test_switching_effects_converge_with_the_step(name):
    """Against steps of 1.25 ms: the error falls at least in proportion to the step, or is below a nanometre."""

    def at_coarse_times(step: float) -> np.ndarray:
        time = np.arange(round(140.0 / step) + 1) * step
        on = np.mod(np.arange(time.size), round(70.0 / step)) < round(25.0 / step)
        run = simulate(NOMINAL.with_effects(name), time, 0.27 * on, load=0.5884)
        return run.displacement[:: round(0.08 / step)]

    fine = at_coarse_times(0.00125)
    errors = [np.abs(at_coarse_times(step) - fine).max() for step in (0.08, 0.02, 0.005)]
    assert errors[1] < max(0.4 * errors[0], 1e-9) and errors[2] < max(0.4 * errors[1], 1e-9), errors
    assert errors[2] < 1e-5


def test_hysteresis_does_not_depend_on_the_rate():
    """A triangle of temperature, and one four times slower: displacement over temperature is the same."""
    loops = []
    for slow in (1.0, 4.0):
        p = NOMINAL.replace(C=1e-4).with_effects('hysteresis')  # so light that T follows the current
        seconds = np.arange(0.0, 4.0, 0.01)
        wanted = 50.0 * (1.0 - np.abs(seconds / 2.0 - 1.0))
        current = np.sqrt(0.01933 * wanted / (14.0 * (1.0 + 0.003 * wanted)))
        run = simulate(p, seconds * slow, current, load=0.5884)
        peak = int(np.argmax(run.temperature))
        x, T = run.displacement, run.temperature - 296.15
        up, down = (
            np.interp([25.0, 35.0, 45.0], T[:peak], x[:peak]),
            np.interp([-25.0, -15.0, -5.0], -T[peak:], x[peak:]),
        )
        loops.append(np.concatenate((up, down)))
    assert loops[0] == pytest.approx(loops[1], abs=2e-6)


# --- the stroke-temperature loop -----------------------------------------------------------------------------------


def loop(parameters: Parameters, slow: bool) -> np.ndarray:
    """x heating - x cooling (mm) at 40, 55 and 70 degC as shown, in the second cycle.

    Fast is the paper's protocol, 25 s on and 45 s off; slow a triangle of power over 140 s.
    """
    cycle = 140.0 if slow else 70.0
    time = np.arange(round(2.0 * cycle * 20.0) + 1) / 20.0
    phase = np.mod(time, cycle) / cycle
    current = 0.27 * np.sqrt(1.0 - np.abs(2.0 * phase - 1.0)) if slow else 0.27 * (phase < 25.0 / 70.0)
    run = simulate(parameters, time, current, load=0.5884)
    half = round(cycle * 20.0)
    x, T = run.displacement[half:], run.temperature[half:] - 273.15
    peak = int(np.argmax(T))
    up = np.interp([40.0, 55.0, 70.0], T[:peak], x[:peak])
    down = np.interp([-40.0, -55.0, -70.0], -T[peak:], x[peak:])
    return 1e3 * (up - down)


@pytest.mark.parametrize(
    ('name', 'top', 'persists'),
    [
        ('thermocouple_lag', 'heating', False),
        ('creep', 'heating', False),
        ('branch_cte', 'heating', True),
        ('end_conduction', 'heating', False),
        ('two_node', 'cooling', False),
        ('hysteresis', 'cooling', True),
        ('friction', 'cooling', True),
    ],
)
def test_the_loop_has_its_direction(name, top, persists):
    """Direction, and whether a slower cycle leaves it: the two marks that tell the causes of a loop apart."""
    fast, slow = loop(NOMINAL.with_effects(name), slow=False), loop(NOMINAL.with_effects(name), slow=True)
    sign = 1.0 if top == 'heating' else -1.0
    assert np.all(sign * fast[1:] > 0.0) and np.all(sign * slow[1:] > 0.0), (fast, slow)
    share = slow[1] / fast[1]
    assert share > 0.85 if persists else share < 0.85, (fast, slow)


@pytest.mark.parametrize('name', [n for n, e in EFFECTS.items() if HEATING_POINTS.isdisjoint(e.hooks) and not e.motion])
@pytest.mark.parametrize('kind', ['current', 'power'])
def test_what_leaves_the_heat_alone_leaves_its_exact_solution(name, kind):
    """Mechanics and sensors do not cost the temperature its independence of the step."""
    t = np.arange(0.0, 140.0, 3.5)
    drive = np.where(np.mod(t, 70.0) < 25.0, 0.25 if kind == 'current' else 1.0, 0.0)
    paper = simulate(Parameters({}), t, drive, kind=kind, load=0.6)
    assert np.array_equal(
        simulate(Parameters({}).with_effects(name), t, drive, kind=kind, load=0.6).fibre_temperature,
        paper.fibre_temperature,
    )


def test_fatigue_counts_the_cycles_before():
    """A muscle that has gone through n cycles goes on as one that is given n0 = n."""
    t = np.arange(0.0, 420.0, 0.1)
    drive = np.where(np.mod(t, 70.0) < 25.0, 0.27, 0.0)
    whole = simulate(Parameters({'fatigue.c': 0.02}).with_effects('fatigue'), t, drive, load=0.6)
    half = t.size // 2
    travel = float(np.sum(np.abs(np.diff(whole.fibre_temperature[: half + 1])))) / 100.0
    worn = Parameters({'fatigue.c': 0.02, 'fatigue.n0': travel}).with_effects('fatigue')
    start = float(whole.fibre_temperature[half])
    after = simulate(worn, t[half:] - t[half], drive[half:], load=0.6, temperature=start)
    swing = np.ptp(after.displacement)
    assert np.ptp(whole.displacement[half:]) == pytest.approx(swing, rel=1e-4)
    assert swing < 0.97 * np.ptp(whole.displacement[:700])

"""What every effect of the registry keeps, whoever adds it."""

from itertools import product
from math import cosh, log, tanh

import numpy as np
import pytest
from muscle.effect_runs import LOADS, NOMINAL, baseline, e0, protocol
from scipy.interpolate import CubicSpline

from tcp_muscle_ros.muscle import EFFECTS, Muscle, Outputs, Parameters, simulate
from tcp_muscle_ros.muscle.layout import STATES
from tcp_muscle_ros.muscle.points import HEATING_POINTS

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
    'stick_slip': ('', 'mechanical'),
    'thermocouple_lag': ('S-01', 'sensor'),
    'thermocouple_gain': ('S-02', 'sensor'),
    'temperature_offset': ('S-03', 'sensor'),
    'thermocouple_pickup': ('', 'sensor'),
    'displacement_drift': ('S-04', 'sensor'),
    'displacement_offset': ('', 'sensor'),
    'clock_skew': ('S-05', 'sensor'),
    'current_gain': ('', 'sensor'),
    # Laws without a name, and so without a row.
    'free_conductance': ('', 'thermal'),
    'free_capacity': ('', 'thermal'),
    'free_surroundings': ('', 'thermal'),
    'free_resistance': ('', 'electrical'),
    'free_stroke': ('', 'mechanical'),
    'free_stiffness': ('', 'mechanical'),
    'free_slow_state': ('', 'mechanical'),
    'free_delay': ('', 'mechanical'),
}
NOISE = {'temperature': 0.2, 'resistance': 0.02, 'displacement': 5e-5}
INVISIBLE = {'elastocaloric'}  # at constant force nothing is left of it
every_effect = pytest.mark.parametrize('name', EFFECTS)


def channels(run: Outputs) -> dict[str, np.ndarray]:
    names = ('temperature', 'fibre_temperature', 'resistance', 'displacement', 'force', 'current', 'voltage', 'power')
    return {name: getattr(run, name) for name in names}


def at_strength(name: str, value: float) -> Parameters:
    return NOMINAL.replace({f'{name}.{EFFECTS[name].strength}': value}).with_effects(name)


def default_strength(name: str) -> float:
    return NOMINAL[f'{name}.{EFFECTS[name].strength}']


def test_the_registry_is_the_catalogue():
    assert {name: (effect.row, effect.stage) for name, effect in EFFECTS.items()} == CATALOGUE


@every_effect
def test_it_has_few_and_documented_parameters(name):
    effect = EFFECTS[name]
    rows = {row.name: row for row in effect.parameters}
    assert 1 <= len(effect.fitted) <= 4
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


@pytest.mark.parametrize('name', [name for name, effect in EFFECTS.items() if not effect.chance])
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
    elif name == 'free_capacity':
        p = muscle.parameters
        law = CubicSpline(p.column('free_capacity.at'), p.column('free_capacity.value'), bc_type='natural')
        assert gained == pytest.approx(stored + NOMINAL['C'] * law.integrate(start, end), rel=1e-8)
    elif name == 'latent_heat':
        assert gained > stored
    else:
        assert gained == pytest.approx(stored, rel=1e-8)


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


@every_effect
@pytest.mark.parametrize('channel', range(4))
def test_a_late_clock_has_long_shown_what_is_shown_at_rest(name: str, channel: int) -> None:
    late = NOMINAL.replace({'clock_skew.d': 0.5, 'clock_skew.channel': float(channel)}).with_effects(name, 'clock_skew')
    time = np.arange(0.0, 0.8, 0.05)  # begins before, and ends after the delay
    at_once = channels(simulate(NOMINAL.with_effects(name), time, 0.0))
    for what, values in channels(simulate(late, time, 0.0)).items():
        np.testing.assert_allclose(values, at_once[what], rtol=1e-3, atol=1e-3, err_msg=what)

"""What each effect on the stroke is: its equation written out, or solved by another integrator."""

from math import exp, log1p, pi, sqrt, tanh

import numpy as np
import pytest
from muscle.effect_runs import (
    LOADS,
    NOMINAL,
    PULSE,
    PULSE_AND_LOAD,
    STEP,
    assert_same,
    baseline,
    contraction,
    e0,
    expand,
    model,
    ohms,
    solve,
    stiffness,
)
from scipy.integrate import solve_ivp

from tcp_muscle_ros.muscle import EFFECTS, Parameters, simulate


@pytest.mark.parametrize('n', [1.0, 3.0])
def test_creep_and_viscous_flow_solve_their_equations(n):
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
        return [
            (i**2 * ohms(T) - 0.01933 * (T - 296.15)) / 0.17,
            1e-5 * load * (load / 0.5) ** (n - 1.0) * exp(0.05 * (T - 333.15)),
        ]

    kelvin, flown = solve(flow, [296.15, 0.0], PULSE_AND_LOAD)
    run = model('viscous_flow', PULSE_AND_LOAD, {'law': n - 1.0})
    assert_same(run, kelvin, 0.5884 / 23.0 - expand(kelvin) - load / stiffness(kelvin) - flown)


def test_creep_over_many_times_is_that_of_four_units_a_decade_apart():
    """Their shares grow with the cube root of their times (Andrade 1910)."""
    times = 15.0 * 10.0 ** np.array([-1.5, -0.5, 0.5, 1.5])
    shares = np.cbrt(times) / np.cbrt(times).sum()

    def creep(t, y, i, load):
        T, wanted = y[0], 0.1 * load / stiffness(y[0])
        late = (wanted * shares - y[1:]) / times * exp(0.07 * (T - 323.15))
        return [(i**2 * ohms(T) - 0.01933 * (T - 296.15)) / 0.17, *late]

    kelvin, *late = solve(creep, [296.15, *(0.1 * shares * 0.5884 / 23.0)], PULSE_AND_LOAD)
    load = np.repeat([0.5884, 0.2942, 0.5884], [800, 600, 801])
    shown = 1.1 * 0.5884 / 23.0 - expand(kelvin) - load / stiffness(kelvin) - np.sum(late, axis=0)
    assert_same(model('creep', PULSE_AND_LOAD, {'law': 1.0}), kelvin, shown)


@pytest.mark.parametrize('tau', [2.0, 40.0])
def test_a_first_stroke_solves_its_equation_and_what_it_gave_it_gives_once(tau):
    def train(t, y, i, load):
        T, given = y
        sets_free = 1.0 - exp(min((296.15 - T) / 15.0, 0.0))
        return [(i**2 * ohms(T) - 0.01933 * (T - 296.15)) / 0.17, max(0.0, sets_free - given) / tau]

    kelvin, given = solve(train, [296.15, 0.0], PULSE)
    assert_same(model('first_cycle', PULSE, {'tau': tau}), kelvin, contraction(kelvin) + 0.005 * given)
    assert np.all(np.diff(given) >= -1e-12)


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


def test_what_the_shear_modulus_lacks_of_the_softening_may_change_with_the_temperature():
    load = LOADS[0]
    T = baseline(load, 0.27).fibre_temperature
    power = 1.0 - 0.41 * (1.0 - 0.8 * (T - 296.15) / 50.0)
    length = 0.15 + expand(T) + load / (23.0 * (stiffness(T) / 23.0) ** power)
    run = e0(NOMINAL.replace({'shear_softening.m': -0.8}).with_effects('shear_softening'), load, 0.27)
    assert run.displacement == pytest.approx(0.15 + load / 23.0 - length, abs=1e-9)


def test_the_shear_modulus_may_fall_at_a_temperature_of_its_own():
    load = LOADS[0]
    T = baseline(load, 0.27).fibre_temperature
    cold, hot = (1.0 - 0.2 / (1.0 + np.exp(-(t - 320.0) / 5.0)) for t in (296.15, T))
    length = 0.15 + expand(T) + load / (stiffness(T) * hot / cold)
    step = {'where': 1.0, 'b': 0.2, 'Tg': 320.0, 'w': 5.0}
    muscle = NOMINAL.replace({f'shear_softening.{name}': value for name, value in step.items()})
    run = e0(muscle.with_effects('shear_softening'), load, 0.27)
    assert run.displacement == pytest.approx(0.15 + load / 23.0 - length, abs=1e-9)


def test_load_stroke_may_grow_with_the_square_of_the_load():
    load = LOADS[0]
    T = baseline(load, 0.27).fibre_temperature
    opened = load / (23.0 * 0.15)
    length = 0.15 + expand(T) / (1.0 + opened**2 / 0.2) + load / stiffness(T)
    run = e0(NOMINAL.replace({'load_stroke.n': 2.0}).with_effects('load_stroke'), load, 0.27)
    assert run.displacement == pytest.approx(0.15 + load / 23.0 - length, abs=1e-9)


@pytest.mark.parametrize('rest', [0.03, 0.06])
def test_a_pulley_before_a_spring_holds_as_the_force_over_it_is(rest):
    """Warm and cooling again, the end is off its balance by friction over both stiffnesses, at any rate of ticks."""
    spring = {'end': 'spring', 'spring_rate': 40.0, 'spring_rest_length': rest}
    muscle = NOMINAL.replace({'friction.law': 1.0, 'friction.Ff': 0.1, 'friction.d': 1e-6}).with_effects('friction')
    shown = []
    for step in (0.02, 0.005):
        time = np.arange(round(60.0 / step) + 1) * step
        current = np.where((time >= 5.0) & (time < 30.0), 0.25, 0.0)
        free, rubbed = (simulate(m, time, current, **spring) for m in (NOMINAL, muscle))
        k = stiffness(free.temperature) + 40.0
        held = (free.displacement - rubbed.displacement) * k / (0.1 / 0.5)
        at = (time == 25.0) | (time == 50.0)
        assert held[at] == pytest.approx(np.array([1.0, -1.0]) * free.force[at], rel=0.01)
        shown.append(rubbed.displacement[at])
    assert shown[0] == pytest.approx(shown[1], abs=1e-6)


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


@pytest.mark.parametrize('law', [0, 1])
def test_a_pulley_rubs_in_proportion_to_the_force_over_it_and_a_guide_alike_under_any(law):
    """The play of the end at 45 K above the room, while warming and while cooling: 2 Ff/k as far as it has built up."""
    stiff = {'C': 1e-4, 'friction.d': 1e-6, 'friction.law': float(law)}
    seconds = np.arange(0.0, 4.0, 0.01)
    wanted = 70.0 * (1.0 - np.abs(seconds / 2.0 - 1.0))
    current = np.sqrt(0.01933 * wanted / (14.0 * (1.0 + 0.003 * wanted)))
    plays = []
    for load in (0.5, 1.5):
        run = simulate(NOMINAL.replace(stiff).with_effects('friction'), seconds, current, load=load)
        peak, T = int(np.argmax(run.temperature)), run.temperature
        at = T[0] + 45.0
        up = np.interp(at, T[:peak], run.displacement[:peak])
        down = np.interp(-at, -T[peak:], run.displacement[peak:])
        plays.append((down - up) * float(stiffness(np.array([at]))[0]))
    assert plays[0] == pytest.approx(2 * 0.01, rel=0.02)
    assert plays[1] == pytest.approx(plays[0] * (3.0 if law else 1.0), rel=0.02)


def test_a_pulley_that_is_relieved_holds_no_more_than_it_can():
    """Friction that had built up under a load does not outlast it."""
    time = np.arange(0.0, 80.0, 0.02)
    load = np.where(time < 40.0, 1.2, 0.05)
    muscle = NOMINAL.replace({'friction.law': 1.0, 'friction.Ff': 0.05}).with_effects('friction')
    current = np.where((time > 5.0) & (time < 30.0), 0.2, 0.0)
    free, rubbed = (simulate(m, time, current, load=load) for m in (NOMINAL, muscle))
    held = np.abs(rubbed.displacement - free.displacement) * stiffness(free.temperature)
    assert held[time < 40.0].max() == pytest.approx(0.05 * 1.2 / 0.5, rel=0.02)
    assert held[time > 41.0].max() <= 1.001 * 0.05 * 0.05 / 0.5


@pytest.mark.parametrize('law', [0.0, 1.0])
def test_hysteresis_does_not_depend_on_the_rate(law):
    """A triangle of temperature, and one four times slower: displacement over temperature is the same."""
    loops = []
    for slow in (1.0, 4.0):
        lawful = {'C': 1e-4, 'hysteresis.law': law}
        p = NOMINAL.replace(**lawful).with_effects('hysteresis')  # so light that T follows the current
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


def test_both_laws_of_hysteresis_stand_still_at_a_turn_and_only_one_is_as_wide_in_length():
    """Where the temperature turns, the share of the contraction that has play stands still. The loop of Bouc and Wen is
    as wide in length at every temperature, that of the plays where the muscle contracts more."""
    seconds = np.arange(0.0, 4.0, 0.01)
    wanted = 70.0 * (1.0 - np.abs(seconds / 2.0 - 1.0))
    current = np.sqrt(0.01933 * wanted / (14.0 * (1.0 + 0.003 * wanted)))
    paper = simulate(NOMINAL.replace(C=1e-4), seconds, current, load=0.3)
    peak = int(np.argmax(paper.temperature))
    wider = []
    for law in (0.0, 1.0):
        changed = {'C': 1e-4, 'hysteresis.w': 0.5, 'hysteresis.r': 3.0, 'hysteresis.law': law}
        x = simulate(NOMINAL.replace(**changed).with_effects('hysteresis'), seconds, current, load=0.3).displacement
        behind = paper.displacement - x
        after = peak + 4  # 1.4 K further
        slope = (behind[after] - behind[peak]) / (paper.displacement[after] - paper.displacement[peak])
        assert slope > 0.2
        cool, hot = (
            np.interp(at, paper.temperature[:peak], behind[:peak])
            - np.interp(-at, -paper.temperature[peak:], behind[peak:])
            for at in (325.0, 345.0)
        )
        wider.append(hot / cool)
    assert wider[0] > 1.05 and wider[1] == pytest.approx(1.0, abs=0.02)


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


def test_an_end_turns_by_load_and_heat_and_back_where_it_gives_way():
    """The clamp that holds a light weight lets go under a heavy one; cold, a clamp that slips keeps what it has lost,
    glue gives it back."""
    t = np.arange(0.0, 160.0, 0.1)
    drive = np.where(t < 80.0, 0.25, 0.0)

    def lost(load, tau):
        changed = NOMINAL.replace({'torsional_leakage.tau': tau})
        leaking = simulate(changed.with_effects('torsional_leakage'), t, drive, load=load)
        return simulate(NOMINAL, t, drive, load=load).displacement - leaking.displacement

    held = lost(0.6, 1e5)
    assert held[800] > 1e-4 and held[-1] == pytest.approx(held[850], rel=0.01)
    assert lost(0.2, 1e5)[-1] < 0.5 * held[-1]
    assert lost(0.6, 20.0)[-1] < 0.2 * held[-1]


@pytest.mark.parametrize(('b', 'side'), [(0.44, -1.0), (-0.44, 1.0)])
def test_the_words_on_a_kink_are_right_for_both_signs(b, side):
    (strength,) = (row for row in EFFECTS['cte_kink'].parameters if row.name == 'b')
    assert 'by this share less than above, or more where negative' in strength.meaning
    kinked = NOMINAL.with_effects('cte_kink').replace({'cte_kink.b': b, 'cte_kink.Tg': 60.0 + 273.15})
    time = np.arange(0.0, 60.0, 0.1)
    runs = [simulate(muscle, time, np.full(time.size, 0.27)) for muscle in (kinked, NOMINAL)]
    below, above = (
        np.ptp([np.interp((at, at + 5.0), run.temperature - 273.15, run.displacement) for run in runs], axis=1)
        for at in (30.0, 80.0)
    )
    here = (below[0] / above[0]) / (below[1] / above[1])  # beside above the kink, where c2 bends all of it a little
    assert 0.3 < side * (here - 1.0) < 0.7

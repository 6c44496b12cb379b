"""Stick-slip: rests and jumps both ways, the same for the same seed."""

import numpy as np
import pytest
from muscle.effect_runs import NOMINAL, stiffness
from scipy.stats import kstest

from tcp_muscle_ros.muscle import Muscle, Muscles, Parameters, simulate

TIME = np.arange(0.0, 300.0, 0.02)
POWER = 1.0 - np.abs(TIME / 150.0 - 1.0)  # up and down
LOAD = 0.5


def stuck(**values) -> Parameters:
    return NOMINAL.replace({f'stick_slip.{name}': value for name, value in values.items()}).with_effects('stick_slip')


def test_it_rests_and_jumps_both_ways_by_as_much_as_it_breaks_away_by():
    """Jumps are (Fi - r Fb)/k with Fi - r Fb log-normal about (1 - r) Fb, of the spread that was given."""
    paper = simulate(NOMINAL, TIME, POWER, kind='power', load=LOAD)
    normal, up, down = [], 0, 0
    for seed in range(4):
        run = simulate(stuck(Fb=0.01, r=0.4, s=0.6, seed=seed), TIME, POWER, kind='power', load=LOAD)
        assert np.array_equal(run.temperature, paper.temperature)
        steps = np.diff(run.displacement)
        jumps = np.flatnonzero(steps)
        assert jumps.size < 0.05 * steps.size
        up, down = up + np.sum(steps > 0.0), down + np.sum(steps < 0.0)
        force = np.abs(steps[jumps]) * stiffness(run.fibre_temperature[jumps + 1])
        turned = np.flatnonzero(np.diff(np.sign(steps[jumps]))) + 1
        assert turned.size <= 1
        force = np.delete(force, turned)  # after a turn it has come the other way first
        normal += list((np.log(force / (0.6 * 0.01)) + 0.5 * 0.6**2) / 0.6)
    assert len(normal) > 200 and up > 50 and down > 50
    assert kstest(normal, 'norm').pvalue > 0.01
    assert kstest(np.array(normal) * 1.3, 'norm').pvalue < 0.01  # the test would see a spread a third larger


def test_the_pull_never_exceeds_what_it_broke_away_by_and_turns_wait():
    run = simulate(stuck(Fb=0.02, r=0.5, s=0.0), TIME, POWER, kind='power', load=LOAD)
    paper = simulate(NOMINAL, TIME, POWER, kind='power', load=LOAD)
    pull = (paper.displacement - run.displacement) * stiffness(run.fibre_temperature)
    assert np.abs(pull).max() == pytest.approx(0.02, rel=0.02)
    moves = np.flatnonzero(np.diff(run.displacement))
    after = pull[moves + 1]
    assert np.abs(after).min() > 0.0099 and np.abs(after).max() < 0.0115  # slid to 0.01 N, and pulled on for a tick
    rests = np.diff(TIME[moves])
    at_turn = np.flatnonzero(np.diff(np.sign(after)))[0]
    assert rests[at_turn] > 3.0 * np.median(rests)


def test_the_same_seed_does_the_same_again_in_ticks_and_together():
    first, again = (simulate(stuck(seed=3), TIME, POWER, kind='power', load=LOAD) for _ in range(2))
    other = simulate(stuck(seed=4), TIME, POWER, kind='power', load=LOAD)
    assert np.array_equal(first.displacement, again.displacement)
    assert np.abs(first.displacement - other.displacement).max() > 5e-4
    alone = Muscle(stuck(seed=3), load=LOAD)
    pair = Muscles([Muscle(stuck(seed=3), load=LOAD), Muscle(stuck(seed=4), load=LOAD)])
    currents = 0.27 * np.sqrt(np.linspace(0.0, 1.0, 2000))
    seen = np.array(
        [(alone.step(0.02, i).displacement, *(r.displacement for r in pair.step(0.02, [i, i]))) for i in currents]
    )
    assert np.array_equal(seen[:, 0], seen[:, 1]) and not np.array_equal(seen[:, 0], seen[:, 2])


def test_the_step_changes_neither_the_jumps_nor_their_order():
    """Only the stiffness within a step counts, and its error falls with the step."""
    held = np.repeat(POWER[::50], 50)
    fine, tenth, whole = (
        simulate(stuck(seed=1), TIME[::n], held[::n], kind='power', load=LOAD).displacement[:: 50 // n]
        for n in (1, 5, 50)
    )
    errors = [np.quantile(np.abs(run - fine), 0.9) for run in (whole, tenth)]
    assert errors[0] < 5e-4 and errors[1] < 0.2 * errors[0]


def test_a_spring_holds_too_and_a_blocked_end_does_not_move():
    time, current = TIME[::5], 0.25 * np.sqrt(POWER[::5])
    blocked = [simulate(p, time, current, load=LOAD, end='blocked').force for p in (NOMINAL, stuck())]
    assert np.array_equal(*blocked)
    sprung = simulate(stuck(s=0.0), time, current, load=LOAD, end='spring', spring_rate=40.0)
    largest = np.abs(np.diff(sprung.displacement)).max()
    assert largest == pytest.approx(0.5 * 0.03 / (40.0 + 19.0), rel=0.15)


@pytest.mark.parametrize('other', ['inertia', 'friction'])
def test_with_no_force_to_break_away_by_it_leaves_inertia_and_friction_what_they_are(other):
    time, current = TIME[::5], 0.25 * np.sqrt(POWER[::5])
    load = np.where(time < 100.0, LOAD, 0.8)
    alone, beside = (
        simulate(p, time, current, load=load).displacement
        for p in (NOMINAL.with_effects(other), stuck(Fb=0.0).with_effects(other))
    )
    assert np.array_equal(alone, beside)


def test_a_guide_that_rubs_is_pulled_against_beside_what_sticks():
    """While it warms the balance is ahead by both forces: friction and what breaks it away, or what it slides by."""
    rubbed = {'friction.Ff': 0.02, 'friction.d': 1e-6}
    sticking = stuck(Fb=0.02, r=0.5, s=0.0).replace(rubbed).with_effects('friction')
    run = simulate(sticking, TIME, POWER, kind='power', load=LOAD)
    paper = simulate(NOMINAL, TIME, POWER, kind='power', load=LOAD)
    pull = ((paper.displacement - run.displacement) * stiffness(run.fibre_temperature))[TIME < 145.0]
    moves = np.flatnonzero(np.diff(run.displacement[TIME < 145.0]))
    assert pull.max() == pytest.approx(0.04, rel=0.02)
    assert moves.size > 20 and np.median(pull[moves + 1]) == pytest.approx(0.03, rel=0.05)


def test_a_weight_swings_as_far_as_the_end_does_not_hold_it():
    """After a step of the load it is never further from where the weight alone would be than what breaks it away."""
    time = np.arange(0.0, 4.0, 0.002)
    load = np.where(time < 0.5, 0.5, 0.6)
    swings, held = (
        simulate(p, time, 0.0, load=load)
        for p in (NOMINAL.with_effects('inertia'), stuck(Fb=0.01, s=0.0).with_effects('inertia'))
    )
    apart = np.abs(held.displacement - swings.displacement) * stiffness(swings.fibre_temperature)
    assert 0.009 < apart.max() <= 0.01001
    assert np.ptp(held.displacement) > 0.9 * np.ptp(swings.displacement)

"""Angle and co-contraction by two muscles: met at rest whatever the model does not know, and the angle first."""

import numpy as np
import pytest

from tcp_muscle_ros.control.antagonist import Antagonist, Hold, Side
from tcp_muscle_ros.control.joint_controller import JointController, Measured
from tcp_muscle_ros.muscle import Joint, Link, Muscle, Muscles, Parameters, stiffness, tension

PAPER = Parameters.named('karami_tadesse_2017')
PERIOD, LOAD, LIMIT, RADIUS = 0.01, 0.4, 0.27, 0.01
AMBIENT = PAPER['T0']


def closed_loop(profile, seconds, plant=(PAPER, PAPER), noise=0.0):
    """Angle, mean tension and both temperatures (K), at every tick; ``profile(t)``: rad, N, N m from outside, and
    N m/rad where a stiffness is wanted.
    """
    muscles = [Muscle(one, end='blocked', load=LOAD) for one in plant]
    joint = Joint(Link(RADIUS, 1e-5, 4e-4, -1.2, 1.2), *muscles)
    together = Muscles(muscles, [joint])
    side = Side(PAPER, LOAD, LIMIT, 373.15)
    controller = JointController(side, side, RADIUS, PERIOD)
    chance = np.random.default_rng(3)
    flowing, shown = (0.0, 0.0), []
    for k in range(round(seconds / PERIOD)):
        angle, mean, joint.torque, *stiffness = profile(k * PERIOD)
        readings = together.step(PERIOD, flowing)
        measured = Measured(
            joint.angle,
            tuple(max(0.0, reading.force + noise * chance.standard_normal()) for reading in readings),
            tuple(reading.temperature for reading in readings),
            flowing,
            (AMBIENT, AMBIENT),
        )
        flowing = controller.update(angle, mean, measured, stiffness=stiffness[0] if stiffness else None)
        shown.append((joint.angle, sum(r.force for r in readings) / 2.0, *(r.temperature for r in readings)))
    return np.array(shown).T


def stiffness_at(*temperatures):
    """N m/rad, of the joint as it is."""
    return RADIUS**2 * float(np.sum(stiffness(PAPER, np.array(temperatures))))


@pytest.mark.parametrize(
    'plant',
    [
        (PAPER, PAPER),
        (PAPER.replace(hA=0.016, k0=26.0, R0=15.0), PAPER.replace(hA=0.023, k0=21.0, R0=13.0)),
        (PAPER.with_effects('creep', 'hysteresis'), PAPER.with_effects('natural_convection')),
    ],
    ids=['as modelled', 'other parameters', 'other physics'],
)
def test_both_are_met_at_rest_under_a_torque_from_outside(plant):
    angle, mean, *_ = closed_loop(lambda t: (0.4, 0.8, 0.0 if t < 10.0 else 1.5e-3), 20.0, plant)
    for end in (990, 1990):
        assert angle[end] == pytest.approx(0.4, abs=3e-3)
        assert mean[end] == pytest.approx(0.8, abs=3e-3)


def test_the_angle_comes_by_heating_and_does_not_wait_for_the_other_muscle_to_cool():
    angle, mean, *_ = closed_loop(lambda t: (0.5 if t < 15.0 else -0.5, 0.6, 0.0), 32.0)
    reached = np.flatnonzero(np.abs(angle[1500:] + 0.5) > 0.05)[-1] * PERIOD
    # Passive cooling alone: C / hA = 8.8 s for 63 % of it.
    assert reached < 4.0
    assert mean[1500 + 400] > 0.65 and mean[-1] == pytest.approx(0.6, abs=2e-3)


def test_the_angle_goes_before_a_co_contraction_that_cannot_be():
    """Too little: the stretched muscle pulls with more even cold. Too much: it would take more than the limit."""
    for mean, bound in ((0.1, (0.3, 0.6)), (5.0, (1.0, 3.0))):
        angle, met, one, two = closed_loop(lambda t, mean=mean: (0.5, mean, 0.0), 60.0)
        assert angle[-1] == pytest.approx(0.5, abs=0.02)
        assert bound[0] < met[-1] < bound[1]
        assert max(one.max(), two.max()) < 373.65


def test_noise_of_the_tensions_does_not_reach_the_angle():
    angle, *_ = closed_loop(lambda _: (0.3, 0.7, 0.0), 15.0, noise=2e-3)
    assert np.std(angle[800:]) < 3e-3 and np.mean(angle[800:]) == pytest.approx(0.3, abs=3e-3)


@pytest.mark.parametrize('wanted', [4.2e-3, 3.6e-3])
def test_a_stiffness_is_met_and_the_angle_with_it(wanted):
    angle, _, *temperatures = closed_loop(lambda _: (0.3, 0.0, 0.0, wanted), 40.0)
    assert angle[-1] == pytest.approx(0.3, abs=3e-3)
    assert stiffness_at(*(t[-1] for t in temperatures)) == pytest.approx(wanted, rel=5e-3)


def test_a_stiffness_beyond_the_muscles_limits_gives_the_nearest_and_the_angle_all_the_same():
    """Stiffer than cold muscles are, softer than hot ones may be."""
    angle, _, *cold = closed_loop(lambda _: (0.3, 0.0, 0.0, 1.0), 40.0)
    assert angle[-1] == pytest.approx(0.3, abs=3e-3) and min(t[-1] for t in cold) < AMBIENT + 0.5
    angle, _, *hot = closed_loop(lambda _: (0.3, 0.0, 0.0, 1e-4), 60.0)
    assert angle[-1] == pytest.approx(0.3, abs=3e-3)
    assert 350.0 < max(t.max() for t in hot) < 373.65


def test_what_was_gone_for_is_said():
    side = Side(PAPER, LOAD, LIMIT, 373.15)
    law = Antagonist(side, side, RADIUS, PERIOD, 0.3)
    law.update(0.0, 0.0, 0.0, (LOAD, LOAD), (AMBIENT, AMBIENT), stiffness=1.0)
    assert law.cocontraction == pytest.approx(LOAD, rel=1e-6)
    assert law.stiffness == pytest.approx(stiffness_at(AMBIENT, AMBIENT), rel=1e-6)


def test_what_is_known_to_pull_at_the_setpoint_takes_the_place_of_what_pulls_now():
    """Of a torque that the tensions show, the known part is exchanged at once; the rest is followed as ever."""
    side = Side(PAPER, LOAD, LIMIT, 373.15)

    def difference(hold):
        law = Antagonist(side, side, RADIUS, PERIOD, 0.3)
        wanted = law.update(0.2, 0.9, 0.0, (LOAD + 0.05, LOAD - 0.05), (AMBIENT, AMBIENT), hold=hold)
        one, two = (tension(PAPER, h, t) for h, t in zip(law.lengths(0.2), wanted, strict=True))
        return one - two

    assert difference(Hold()) == pytest.approx(0.1, abs=1e-6)
    assert difference(Hold(here=1e-3, there=-0.5e-3)) == pytest.approx(0.1 - 1.5e-3 / RADIUS, abs=1e-6)

"""Angle and co-contraction by two muscles: met at rest whatever the model does not know, and the angle first."""

import numpy as np
import pytest

from tcp_muscle_ros.control.antagonist import Antagonist, Side
from tcp_muscle_ros.control.inverse import Inverse
from tcp_muscle_ros.control.tracking import TrackingController
from tcp_muscle_ros.muscle import Joint, Link, Muscle, Muscles, Parameters

PAPER = Parameters.named('karami_tadesse_2017')
PERIOD, LOAD, LIMIT, RADIUS = 0.01, 0.4, 0.27, 0.01
AMBIENT = PAPER['T0']


def closed_loop(profile, seconds, plant=(PAPER, PAPER), noise=0.0):
    """Angle, mean tension and both temperatures (K), at every tick; ``profile(t)``: rad, N, N m from outside."""
    muscles = [Muscle(one, end='blocked', load=LOAD) for one in plant]
    joint = Joint(Link(RADIUS, 1e-5, 4e-4, -1.2, 1.2), *muscles)
    together = Muscles(muscles, [joint])
    side = Side(PAPER, LOAD, LIMIT, 373.15)
    law = Antagonist(side, side, RADIUS, PERIOD, 0.3)
    inverse = Inverse(PAPER, LOAD)
    controllers = [TrackingController(PAPER, PERIOD, LIMIT, LOAD, AMBIENT) for _ in muscles]
    chance = np.random.default_rng(3)
    flowing, shown = [0.0, 0.0], []
    for k in range(round(seconds / PERIOD)):
        angle, mean, joint.torque = profile(k * PERIOD)
        readings = together.step(PERIOD, flowing)
        tensions = tuple(max(0.0, reading.force + noise * chance.standard_normal()) for reading in readings)
        wanted = law.update(angle, mean, joint.angle, tensions, (AMBIENT, AMBIENT))
        flowing = [
            controller.update(
                inverse.displacement(temperature, tension),
                displacement=sign * RADIUS * joint.angle,
                load=tension,
                temperature=reading.temperature,
                applied_current=current,
            ).current
            for controller, temperature, tension, sign, reading, current in zip(
                controllers, wanted, tensions, (1.0, -1.0), readings, flowing, strict=True
            )
        ]
        shown.append((joint.angle, sum(r.force for r in readings) / 2.0, *(r.temperature for r in readings)))
    return np.array(shown).T


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

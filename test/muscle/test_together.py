"""Muscles stepped together are the muscles stepped alone; two on a joint balance it."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Joint, Link, Muscle, Muscles, Parameters, length, stiffness
from tcp_muscle_ros.muscle.quantities import IN_WALL

PAPER = Parameters.named('karami_tadesse_2017')
LINK = Link(radius=0.01, inertia=1e-5, damping=4e-4, low=-1.0, high=1.0)


def different():
    return [
        Muscle(PAPER, load=0.5),
        Muscle(PAPER.replace(hA=0.03).with_effects('creep', 'hysteresis'), load=0.3),
        Muscle(PAPER.with_effects('natural_convection', 'elastocaloric'), end='blocked', load=0.4),
        Muscle(PAPER, end='spring', load=0.4, spring_rate=30.0, ambient=300.0),
    ]


def test_together_is_alone_to_the_last_bit():
    alone, together = different(), different()
    group = Muscles(together)
    for k in range(300):
        currents = [0.25 if (k // 60 + n) % 2 else 0.0 for n in range(4)]
        if k == 150:
            alone[0].impose(load=0.7)
            together[0].impose(load=0.7)
        assert group.step(0.01, currents) == [
            muscle.step(0.01, current) for muscle, current in zip(alone, currents, strict=True)
        ]
    together[1].reset(310.0)
    alone[1].reset(310.0)
    assert group.step(0.0, [0.0] * 4)[1] == alone[1].reading(0.0)


def pair(load=0.4, link=LINK, warm=15.0, **more):
    muscles = [Muscle(PAPER, end='blocked', load=load, temperature=PAPER['T0'] + t) for t in (warm, 0.0)]
    joint = Joint(link, *muscles, **more)
    return joint, muscles, Muscles(muscles, [joint])


def tension(temperature, held):
    slack = held - float(length(PAPER, temperature, 0.0))
    return max(0.0, float(stiffness(PAPER, temperature)) * slack)


def test_the_joint_moves_as_its_equation_of_motion_says():
    """Against an adaptive solver on the same tensions; the muscles are kept at their temperatures."""
    errors = []
    for period in (1e-3, 5e-4):  # below the substep: first order in the period
        joint, muscles, group = pair(torque=-1e-3)
        rest = [muscle.imposed[IN_WALL] for muscle in muscles]
        states = [muscle.state.copy() for muscle in muscles]
        angles = []
        for _ in range(round(0.5 / period)):
            for muscle, state in zip(muscles, states, strict=True):
                muscle.state[:] = state
            group.step(period, [0.0, 0.0])
            angles.append(joint.angle)

        def motion(_, y, rest=rest):
            one = tension(PAPER['T0'] + 15.0, rest[0] - LINK.radius * y[0])
            two = tension(PAPER['T0'], rest[1] + LINK.radius * y[0])
            return [y[1], (LINK.radius * (one - two) - 1e-3 - LINK.damping * y[1]) / LINK.inertia]

        ticks = np.arange(1, len(angles) + 1) * period
        truth = solve_ivp(motion, (0.0, 0.5), [0.0, 0.0], t_eval=ticks, rtol=1e-9, atol=1e-12).y[0]
        errors.append(np.abs(np.array(angles) - truth).max())
        assert np.ptp(truth) > 0.2
    assert errors[0] < 0.01 and 1.5 < errors[0] / errors[1] < 2.5, errors


def test_at_rest_the_tensions_carry_the_torque_and_the_muscles_share_the_angle():
    joint, _, group = pair(torque=1.5e-3)
    for _ in range(12000):
        one, two = group.step(0.01, [0.0, 0.15])
    assert joint.velocity == pytest.approx(0.0, abs=1e-6)
    assert LINK.radius * (two.force - one.force) == pytest.approx(1.5e-3, rel=1e-5)
    assert one.displacement == pytest.approx(LINK.radius * joint.angle, abs=1e-12)
    assert two.displacement == pytest.approx(-LINK.radius * joint.angle, abs=1e-12)


def test_a_slack_muscle_does_not_push_and_a_stop_holds():
    joint, _, group = pair(load=0.1, warm=0.0, torque=0.05)
    for _ in range(200):
        one, two = group.step(0.01, [0.0, 0.0])
    assert joint.angle == LINK.high and joint.velocity == 0.0
    assert one.slack and one.force == 0.0 and two.force > 0.1


def test_reset_is_where_it_was_mounted_and_other_properties_keep_the_lengths():
    joint, muscles, group = pair()
    group.step(0.01, [0.2, 0.0])
    joint.reset()
    for muscle in muscles:
        muscle.reset(PAPER['T0'])
    assert [reading.force for reading in group.step(0.0, [0.0, 0.0])] == pytest.approx([0.4, 0.4])
    stiffer = [Muscle(PAPER.replace(k0=30.0), end='blocked', load=0.4) for _ in muscles]
    joint.take(*stiffer)
    assert [muscle.imposed[IN_WALL] for muscle in stiffer] == [muscle.imposed[IN_WALL] for muscle in muscles]


def test_what_cannot_be_mounted_is_refused():
    with pytest.raises(BadInput, match='must be blocked'):
        Joint(LINK, Muscle(PAPER, load=0.4), Muscle(PAPER, end='blocked', load=0.4))
    with pytest.raises(BadInput, match='leaves nothing of a muscle of 0\\.1'):
        pair(link=Link(0.2, 1e-5, 0.0, -1.0, 1.0))

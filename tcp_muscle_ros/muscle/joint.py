"""A joint between two muscles: one turns it by pulling, the other turns it back.

    I d2(angle)/dt2 + b d(angle)/dt = r (F_agonist - F_antagonist) + torque
    lengths: l_agonist = l1 - r angle, l_antagonist = l2 + r angle

l1, l2: the lengths at which both were mounted, with the tension of their starting load at rest at T0. The tensions are
the muscles' own, F >= 0: where one hangs slack, the other works against inertia, damping and the torque alone.
Implicit Euler steps of at most a millisecond: stable however stiff the muscles and however light the link.
"""

from dataclasses import dataclass
from math import ceil

import numpy as np

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import quantities as at
from tcp_muscle_ros.muscle import stepping
from tcp_muscle_ros.muscle.arrays import Array, Mask
from tcp_muscle_ros.muscle.compiled import entry
from tcp_muscle_ros.muscle.muscle import Muscle
from tcp_muscle_ros.muscle.quantities import FORCE, IN_WALL, STIFFNESS

_ANGLE, _VELOCITY = 0, 1
_LONGEST = 1e-3  # s, of a substep


@entry
def _turn(
    state: Array, inertia: float, damping: float, radius: float, torque: float, low: float, high: float,
    x1: Array, u1: Array, p1: Array, on1: Mask, x2: Array, u2: Array, p2: Array, on2: Mask,
    mounted: Array, q: Array, work: Array, dt: float, substeps: int,
) -> None:  # fmt: skip
    """Advance angle and velocity by ``dt``, and set both muscles' lengths; their temperatures stay what they are."""
    h = dt / max(substeps, 1)
    for _ in range(substeps):
        before, velocity = state[0], state[1]
        angle = before + h * velocity
        for _ in range(30):  # Newton; the slope counts both muscles as taut, so where one is slack it falls short
            u1[IN_WALL], u2[IN_WALL] = mounted[0] - radius * angle, mounted[1] + radius * angle
            stepping._evaluate(x1, u1, p1, on1, q, work[0])
            pull, rate = q[FORCE], q[STIFFNESS]
            stepping._evaluate(x2, u2, p2, on2, q, work[0])
            pull -= q[FORCE]
            rate += q[STIFFNESS]
            speed = (angle - before) / h
            missing = radius * pull + torque - inertia * (speed - velocity) / h - damping * speed
            change = missing / (inertia / h**2 + damping / h + radius**2 * rate)
            angle += change
            if abs(change) < 1e-14:
                break
        state[0], state[1] = angle, (angle - before) / h
        if not low <= angle <= high:  # a stop takes up the momentum
            state[0], state[1] = min(max(angle, low), high), 0.0
    u1[IN_WALL], u2[IN_WALL] = mounted[0] - radius * state[0], mounted[1] + radius * state[0]


@dataclass(frozen=True)
class Link:
    """What turns: SI. ``radius`` m of the pulley, ``inertia`` kg m^2, ``damping`` N m s, stops in rad."""

    radius: float
    inertia: float
    damping: float
    low: float
    high: float


class Joint:
    """Two muscles on one pulley. It holds their lengths; they must be ``blocked``.

    Args:
        link: what they turn.
        agonist: turns it towards positive angles; at angle 0 it has the length that it now has.
        antagonist: turns it back.
        torque: N m from outside, towards positive angles.

    Raises:
        BadInput: a muscle whose end is not ``blocked``, or a turn by which one of them would have no length left.
    """

    def __init__(self, link: Link, agonist: Muscle, antagonist: Muscle, torque: float = 0.0) -> None:
        self.link = link
        self.torque = torque
        self._state = np.zeros(2)
        self._q, self._work = stepping.scratch()
        self._pair = agonist, antagonist
        for muscle in self._pair:
            if not muscle.blocked:
                raise BadInput('a joint holds the ends of its muscles: they must be blocked')
        self._mounted = np.array([muscle.imposed[at.IN_WALL] for muscle in self._pair])
        if self._mounted.min() <= link.radius * max(abs(link.low), abs(link.high)):
            raise BadInput(
                f'a turn of {max(abs(link.low), abs(link.high)):g} rad on a radius of {link.radius:g} m leaves nothing '
                f'of a muscle of {self._mounted.min():g} m'
            )

    @property
    def angle(self) -> float:
        """rad, positive where the agonist has turned it."""
        return float(self._state[_ANGLE])

    @property
    def velocity(self) -> float:
        """rad/s."""
        return float(self._state[_VELOCITY])

    def reset(self) -> None:
        """At rest at angle 0. (The muscles are reset by whoever owns them.)"""
        self._state[:] = 0.0
        self._hold()

    def take(self, agonist: Muscle, antagonist: Muscle) -> None:
        """The same muscles with other properties, mounted as they were."""
        self._pair = agonist, antagonist
        self._hold()

    def _hold(self) -> None:
        turned = self.link.radius * self._state[_ANGLE]
        for muscle, mounted, sign in zip(self._pair, self._mounted, (-1.0, 1.0), strict=True):
            muscle.imposed[at.IN_WALL] = mounted + sign * turned

    def turn(self, dt: float) -> None:
        """Move for ``dt`` (s, 0 or more) with the muscles as warm as they are, and give them their lengths."""
        one, two = self._pair
        link = self.link
        _turn(
            self._state, link.inertia, link.damping, link.radius, self.torque, link.low, link.high,
            one.state, one.imposed, one.parameters.vector, one.parameters.mask,
            two.state, two.imposed, two.parameters.vector, two.parameters.mask,
            self._mounted, self._q, self._work, dt, ceil(dt / _LONGEST - 1e-9),
        )  # fmt: skip

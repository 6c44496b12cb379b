"""Many muscles in one step: a hand's sixteen cost little more than one, and two may pull at one joint."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from tcp_muscle_ros.muscle import quantities as at
from tcp_muscle_ros.muscle import stepping
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.joint import Joint
from tcp_muscle_ros.muscle.muscle import Muscle, Reading


class Muscles:
    """Muscles that are stepped together, with the same result to the last bit as each for itself.

    They stay whole: what is asked of one of them (``reset``, ``impose``) is asked of its row of the shared arrays.

    Args:
        muscles: in the order of what ``step`` takes and gives; a Muscle belongs to one group at a time.
        joints: at which pairs of them pull.
    """

    def __init__(self, muscles: Sequence[Muscle], joints: Sequence[Joint] = ()) -> None:
        self._muscles, self._joints = list(muscles), list(joints)
        self._x = np.array([muscle.state for muscle in muscles])
        self._u = np.array([muscle.imposed for muscle in muscles])
        self._p = np.array([muscle.parameters.vector for muscle in muscles])
        self._on = np.array([muscle.parameters.mask for muscle in muscles])
        self._y = np.empty((len(muscles), at.N_OUTPUTS))
        for readable in (self._p, self._on):
            readable.setflags(write=False)
        self._q, self._work = stepping.scratch()
        for k, muscle in enumerate(muscles):
            muscle.state, muscle.imposed = self._x[k], self._u[k]
        self._drives = self._u[:, at.IN_DRIVE]

    def step(self, dt: float, currents: ArrayLike) -> list[Reading]:
        """Hold the currents (A, one a muscle) for ``dt`` (s), then read all; a ``dt`` of 0 only reads."""
        if len(self._muscles) == 1:  # by itself, as offline: no more machine code to load when a node starts
            self._drives[:] = currents
            return [self._muscles[0].advance(dt)]
        rows = self.advance(dt, currents).tolist()
        return [muscle.shown(row, dt) for muscle, row in zip(self._muscles, rows, strict=True)]

    def advance(self, dt: float, currents: ArrayLike) -> Array:
        """As ``step`` for thousands of muscles: shape (n, N_OUTPUTS), see ``quantities.py``; filled anew each time."""
        self._drives[:] = currents
        stepping.advance_many(self._x, self._u, self._p, self._on, self._q, self._work, dt, self._y)
        if self._joints:
            for joint in self._joints:
                joint.turn(dt)
            # The same instant, seen with the lengths that the joints have given the muscles.
            stepping.advance_many(self._x, self._u, self._p, self._on, self._q, self._work, 0.0, self._y)
        return self._y

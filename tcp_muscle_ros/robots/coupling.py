"""Muscles as tendons: length and velocity in, tension out, temperatures stepped with the simulator.

One step of the simulator, from t to t + h:

1. The muscle is held at its present length l while its temperature goes from t to t + h (the model's own stepping).
2. It is asked for its tension F and its stiffness k at the length at which its end would arrive, l + h v, by the
   velocity v of the tendon. A muscle cannot push: where it hangs slack there, F = k = 0.
3. The simulator is given the tension as a straight line, F + k h (v' - v), in the velocity v' at the end of the step.
   An integrator that is implicit in velocities (``implicitfast``) then takes the step of backward Euler: it is stable
   however stiff the muscle and however light the link, and costs what an explicit one costs.

What backward Euler takes away, k (h v')^2/2 a step, is an error of first order in h. ``Book`` shows it.
"""

from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.muscle import Muscle, stepping
from tcp_muscle_ros.muscle import quantities as at
from tcp_muscle_ros.muscle.arrays import Array, Mask
from tcp_muscle_ros.muscle.compiled import entry

# The columns of a muscle's account, all since the start: J, but for the first two, N.
(
    TENSION,  # at the length at which the end was expected
    SLOPE,  # N s/m: k h of the step under way; 0 where slack
    EXPECTED,  # m, the length at the beginning of the step under way
    SPEED,  # m/s, of lengthening at the beginning of the step under way
    ELASTIC,  # J, elastic energy now
    WORK,  # J, done by the tendon on the muscle
    BY_HEAT,  # J, elastic energy that changes of temperature brought in
) = range(7)
N_COLUMNS = 7


@entry
def couple(
    x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array, y: Array,
    length: Array, speed: Array, current: Array, h: float, account: Array,
) -> None:  # fmt: skip
    """Close the step that ended, and begin the next of ``h`` (s): fills TENSION and SLOPE of every muscle.

    ``length`` (m), ``speed`` (m/s) and ``current`` (A) have shape (n,), ``account`` (n, N_COLUMNS), the rest as in
    ``stepping.advance_many``.
    """
    for k in range(length.size):
        a, imposed = account[k], u[k]
        applied = a[TENSION] + a[SLOPE] * (speed[k] - a[SPEED])
        a[WORK] += applied * (length[k] - a[EXPECTED])
        imposed[at.IN_DRIVE] = current[k]
        imposed[at.IN_WALL] = length[k]
        stepping.advance(x[k], imposed, p[k], on[k], q, work, 0.0, y[k])
        before = 0.5 * q[at.FORCE] * q[at.ELASTIC]
        stepping.advance(x[k], imposed, p[k], on[k], q, work, h, y[k])
        a[ELASTIC] = 0.5 * q[at.FORCE] * q[at.ELASTIC]
        a[BY_HEAT] += a[ELASTIC] - before
        imposed[at.IN_WALL] = max(length[k] + h * speed[k], 1e-6)
        stepping.advance(x[k], imposed, p[k], on[k], q, work, 0.0, y[k])
        a[TENSION], a[SLOPE] = q[at.FORCE], h * q[at.STIFFNESS] if q[at.FORCE] > 0.0 else 0.0
        a[EXPECTED], a[SPEED] = length[k], speed[k]


@dataclass(frozen=True)
class Book:
    """Where the energy of a robot's muscles went since the start, J, all muscles together.

    The paper's heat balance does not pay for mechanical work: what heat brings into the elastic energy by contracting
    and softening (``by_heat``) is told from the muscle's own law, and stands beside the heat.
    """

    heated: float  # by the currents
    lost: float  # to the ambient
    stored_heat: float  # C (T - T at the start)
    by_heat: float  # elastic energy that contraction and softening brought in
    work: float  # of the tendons on the muscles; negative: the muscles moved the robot
    stored_elastic: float  # change of the elastic energy

    @property
    def heat_error(self) -> float:
        """J: current less loss less stored heat."""
        return self.heated - self.lost - self.stored_heat

    @property
    def work_error(self) -> float:
        """J: what the coupling lost (positive) or made (negative) of mechanical energy."""
        return self.work + self.by_heat - self.stored_elastic

    @property
    def error(self) -> float:
        """Share of the input: tendon work and Joule heat less loss and stored change, over the Joule heat."""
        return (self.heat_error + self.work_error) / self.heated if self.heated > 0.0 else 0.0


class Tendons:
    """Muscles that are held by a simulator's tendons, stepped together.

    Args:
        muscles: ``blocked`` at the lengths at which they are mounted.
    """

    def __init__(self, muscles: list[Muscle]) -> None:
        self.muscles = muscles
        self._x = np.array([muscle.state for muscle in muscles])
        self._u = np.array([muscle.imposed for muscle in muscles])
        self._p = np.array([muscle.parameters.vector for muscle in muscles])
        self._on = np.array([muscle.parameters.mask for muscle in muscles])
        self._q, self._work = stepping.scratch()
        self.shown = np.zeros((len(muscles), at.N_OUTPUTS))
        self.account = np.zeros((len(muscles), N_COLUMNS))
        for k, muscle in enumerate(muscles):  # they stay whole: what is asked of one is asked of its row
            muscle.state, muscle.imposed = self._x[k], self._u[k]
        self.rest_lengths = self._u[:, at.IN_WALL].copy()
        for readable in (self._p, self._on):
            readable.setflags(write=False)
        self._capacity = np.array([muscle.parameters['C'] for muscle in muscles])
        self.begin(self.rest_lengths)

    def begin(self, length: Array) -> None:
        """Open the book anew, with the muscles as they are and at these lengths (m), at rest."""
        still = np.zeros(len(self.muscles))
        self.account[:] = 0.0
        self._couple(length, still, still, 0.0)
        self.account[:, [WORK, BY_HEAT]] = 0.0
        self._at_start = self._x.copy()
        self._elastic = self.account[:, ELASTIC].sum()

    def _couple(self, length: Array, speed: Array, current: Array, h: float) -> None:
        couple(
            self._x, self._u, self._p, self._on, self._q, self._work, self.shown,
            length, speed, current, h, self.account,
        )  # fmt: skip

    def step(self, length: Array, speed: Array, current: Array, h: float) -> tuple[Array, Array]:
        """The tension (N) of each muscle over the next ``h`` (s), as a straight line in the tendon's velocity.

        Args:
            length: m, of each muscle now.
            speed: m/s, of its lengthening now.
            current: A.
            h: s.

        Returns:
            The tension at velocity 0, N, and its slope, N s/m; both shape (n,).
        """
        self._couple(length, speed, current, h)
        tension, slope = self.account[:, TENSION], self.account[:, SLOPE]
        return tension - slope * speed, slope

    def book(self) -> Book:
        """Where the energy went since ``begin``, up to the beginning of the step under way."""
        gone = self._x - self._at_start
        return Book(
            heated=float(gone[:, at.X_HEATED].sum()),
            lost=float(gone[:, at.X_LOST].sum()),
            stored_heat=float((self._capacity * gone[:, at.X_TEMPERATURE]).sum()),
            by_heat=float(self.account[:, BY_HEAT].sum()),
            work=float(self.account[:, WORK].sum()),
            stored_elastic=float(self.account[:, ELASTIC].sum() - self._elastic),
        )

"""How warm two muscles on one joint must be for an angle and a co-contraction, or for an angle and a stiffness.

    F_agonist, F_antagonist = co-contraction +- torque / (2 r)

torque is what the muscles must hold against. It is not estimated through a model: whatever pulls at a joint that is at
rest, the difference of the two measured tensions holds it. What of it is known to be other at the setpoint (gravity, by
``gravity.py``) is put in its place; a joint that turns far then need not first hang too low to be corrected. A muscle
of the wanted length under the wanted tension has one temperature; a TrackingController brings it there, and as it reads
its temperature coordinate from the measured angle and tension through the same map, what the map does not know is in
both, and the angle is met all the same.

A muscle takes seconds to heat and longer to cool. So nothing is asked for but what it can soon be: while one of them is
too warm the other pulls harder, while one is too cold the other waits. The angle is met first, and the co-contraction
comes to what is wanted after it.

A stiffness is a co-contraction too: the joint's is r^2 (k1(T1) + k2(T2)) as long as both are taut, and nylon softens as
it warms, so more co-contraction makes this joint softer. What the limits of both muscles leave is found first, the
stiffness that is nearest to the wanted one within it then.
"""

from dataclasses import dataclass
from math import expm1, inf

from tcp_muscle_ros.muscle import Parameters, length, length_at, temperature_for_length, tension

# Filter times, of which the first makes up for the filter's lag: what a muscle cools or heats by in them is asked for.
_COOLING, _HEATING = 1.2, 1.4
_ROUNDS = 18  # of a bisection of the co-contraction: to 4e-6 of its range


@dataclass(frozen=True)
class Side:
    """One muscle as the controller believes it to be."""

    model: Parameters
    mounted_load: float  # N, its tension at angle 0, at rest at T0
    current_limit: float  # A
    temperature_limit: float  # K

    def stiffness(self, temperature: float) -> float:
        """N/m, at a temperature (K)."""
        return 1.0 / (length_at(self.model, temperature, 1.0) - length_at(self.model, temperature, 0.0))

    def soon(self, now: float, ambient: float, time: float) -> tuple[float, float]:
        """The coldest and the hottest (K) that it can be a short time (s) after the temperature ``now``."""
        p = self.model
        cooling = p['hA'] / p['C'] * (now - ambient)
        heating = self.current_limit**2 * p['R0'] * (1.0 + p['a_R'] * (now - p['T0'])) / p['C'] - cooling
        coldest = max(now - max(cooling, 0.0) * _COOLING * time, min(now, ambient))
        return coldest, min(now + max(heating, 0.0) * _HEATING * time, self.temperature_limit)


@dataclass(frozen=True)
class Hold:
    """The torque (N m, towards positive angles) by which the muscles hold what is known to pull, such as gravity."""

    here: float = 0.0  # at the measured angle
    there: float = 0.0  # at the setpoint


FREE = Hold()


class Antagonist:
    """Angle (rad) and co-contraction (N, the mean of both tensions) in, temperatures (K) of both muscles out.

    ``cocontraction`` and ``stiffness`` (N m/rad) are what the last update went for, within what the muscles can do.

    Args:
        agonist: turns the joint towards positive angles.
        antagonist: turns it back.
        radius: m, of the pulley.
        period: s, between two updates.
        filter_time: s, with which the measured torque and temperatures are followed.
    """

    def __init__(self, agonist: Side, antagonist: Side, radius: float, period: float, filter_time: float) -> None:
        self._sides = agonist, antagonist
        self._signs = 1.0, -1.0
        self._radius = radius
        self._follow = -expm1(-period / filter_time) if filter_time > 0.0 else 1.0
        self._lag = max(filter_time, period)
        self._mounted = tuple(float(length(side.model, side.model['T0'], side.mounted_load)) for side in self._sides)
        self.reset()

    def reset(self) -> None:
        """Forget what was measured."""
        self._difference: float | None = None
        self._now: tuple[float, ...] = ()
        self.cocontraction = self.stiffness = 0.0

    def lengths(self, angle: float) -> tuple[float, ...]:
        """Both muscles' lengths (m) at an angle (rad)."""
        turned = self._radius * angle
        return tuple(mounted - sign * turned for mounted, sign in zip(self._mounted, self._signs, strict=True))

    def update(
        self,
        setpoint: float,
        cocontraction: float,
        angle: float,
        tensions: tuple[float, float],
        ambients: tuple[float, float],
        *,
        stiffness: float | None = None,
        hold: Hold = FREE,
    ) -> tuple[float, ...]:
        """One period: what is wanted, measured and around -> the two temperatures (K) to go to.

        Args:
            setpoint: rad.
            cocontraction: N, the mean of both tensions.
            angle: rad, measured.
            tensions: N, measured.
            ambients: K.
            stiffness: N m/rad; where it is given, the co-contraction is the one that comes nearest to it.
            hold: what is known to pull at the joint.
        """
        self._see(angle, tensions, hold)
        assert self._difference is not None
        difference = self._difference + 0.5 * hold.there / self._radius
        least, most = abs(difference), inf
        wanted = self.lengths(setpoint)
        for side, height, sign, now, ambient in zip(self._sides, wanted, self._signs, self._now, ambients, strict=True):
            coldest, hottest = side.soon(now, ambient, self._lag)
            least = max(least, tension(side.model, height, coldest) - sign * difference)
            most = min(most, tension(side.model, height, hottest) - sign * difference)
        if stiffness is not None:
            cocontraction = self._for_stiffness(stiffness, wanted, difference, least, max(least, most))
        self.cocontraction = max(min(cocontraction, most), least)
        found = self._temperatures(wanted, self.cocontraction, difference)
        self.stiffness = self._stiffness(found)
        return found

    def _temperatures(self, wanted: tuple[float, ...], mean: float, difference: float) -> tuple[float, ...]:
        return tuple(
            temperature_for_length(side.model, height, max(0.0, mean + sign * difference))
            for side, height, sign in zip(self._sides, wanted, self._signs, strict=True)
        )

    def _stiffness(self, temperatures: tuple[float, ...]) -> float:
        pairs = zip(self._sides, temperatures, strict=True)
        return self._radius**2 * sum(side.stiffness(temperature) for side, temperature in pairs)

    def _for_stiffness(
        self, stiffness: float, wanted: tuple[float, ...], difference: float, low: float, high: float
    ) -> float:
        """The co-contraction (N) between two that comes nearest to a stiffness (N m/rad)."""

        def excess(mean: float) -> float:
            return self._stiffness(self._temperatures(wanted, mean, difference)) - stiffness

        at_low, at_high = excess(low), excess(high)
        if at_low * at_high >= 0.0:
            return low if abs(at_low) <= abs(at_high) else high
        for _ in range(_ROUNDS):
            middle = 0.5 * (low + high)
            if excess(middle) * at_low > 0.0:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)

    def _see(self, angle: float, tensions: tuple[float, float], hold: Hold) -> None:
        difference = 0.5 * (tensions[0] - tensions[1]) - 0.5 * hold.here / self._radius
        now = tuple(
            temperature_for_length(side.model, height, pull)
            for side, height, pull in zip(self._sides, self.lengths(angle), tensions, strict=True)
        )
        if self._difference is None:
            self._difference, self._now = difference, now
        self._difference += self._follow * (difference - self._difference)
        self._now = tuple(old + self._follow * (new - old) for old, new in zip(self._now, now, strict=True))

"""How warm two muscles on one joint must be for an angle and a co-contraction.

    F_agonist, F_antagonist = co-contraction +- torque / (2 r)

torque is what the muscles must hold against. It is not estimated through a model: whatever pulls at a joint that is at
rest, the difference of the two measured tensions holds it. A muscle of the wanted length under the wanted tension has
one temperature; a TrackingController brings it there, and as it reads its temperature coordinate from the measured
angle and tension through the same map, what the map does not know is in both, and the angle is met all the same.

A muscle takes seconds to heat and longer to cool. So nothing is asked for but what it can soon be: while one of them is
too warm the other pulls harder, while one is too cold the other waits. The angle is met first, and the co-contraction
comes to what is wanted after it.
"""

from dataclasses import dataclass
from math import expm1, inf

from tcp_muscle_ros.muscle import Parameters, length, temperature_for_length, tension

# Filter times, of which the first makes up for the filter's lag: what a muscle cools or heats by in them is asked for.
_COOLING, _HEATING = 1.2, 1.4


@dataclass(frozen=True)
class Side:
    """One muscle as the controller believes it to be."""

    model: Parameters
    mounted_load: float  # N, its tension at angle 0, at rest at T0
    current_limit: float  # A
    temperature_limit: float  # K

    def soon(self, now: float, ambient: float, time: float) -> tuple[float, float]:
        """The coldest and the hottest (K) that it can be a short time (s) after the temperature ``now``."""
        p = self.model
        cooling = p['hA'] / p['C'] * (now - ambient)
        heating = self.current_limit**2 * p['R0'] * (1.0 + p['a_R'] * (now - p['T0'])) / p['C'] - cooling
        coldest = max(now - max(cooling, 0.0) * _COOLING * time, min(now, ambient))
        return coldest, min(now + max(heating, 0.0) * _HEATING * time, self.temperature_limit)


class Antagonist:
    """Angle (rad) and co-contraction (N, the mean of both tensions) in, temperatures (K) of both muscles out.

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
    ) -> tuple[float, ...]:
        """One period: what is wanted (rad, N), measured (rad, N) and around (K) -> the two temperatures to go to."""
        self._see(angle, tensions)
        assert self._difference is not None
        least, most = abs(self._difference), inf
        wanted = self.lengths(setpoint)
        for side, height, sign, now, ambient in zip(self._sides, wanted, self._signs, self._now, ambients, strict=True):
            coldest, hottest = side.soon(now, ambient, self._lag)
            least = max(least, tension(side.model, height, coldest) - sign * self._difference)
            most = min(most, tension(side.model, height, hottest) - sign * self._difference)
        mean = max(min(cocontraction, most), least)
        return tuple(
            temperature_for_length(side.model, height, mean + sign * self._difference)
            for side, height, sign in zip(self._sides, wanted, self._signs, strict=True)
        )

    def _see(self, angle: float, tensions: tuple[float, float]) -> None:
        difference = 0.5 * (tensions[0] - tensions[1])
        now = tuple(
            temperature_for_length(side.model, height, pull)
            for side, height, pull in zip(self._sides, self.lengths(angle), tensions, strict=True)
        )
        if self._difference is None:
            self._difference, self._now = difference, now
        self._difference += self._follow * (difference - self._difference)
        self._now = tuple(old + self._follow * (new - old) for old, new in zip(self._now, now, strict=True))

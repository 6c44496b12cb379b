"""Between what is asked for and what the current can change: displacement and temperature under a load.

The controller works in the model's temperature coordinate: z, the temperature at which the model has the
length that was measured under the present load. z* of the setpoint goes through the same map, so where the
map is wrong (stroke gain, stiffness) the error is in both and z = z* still means that the setpoint is met.
"""

from math import inf

from tcp_muscle_ros.muscle import Parameters, length_at, shortening, temperature_for_length
from tcp_muscle_ros.muscle.mechanical import DOMAIN_HIGH

_STEP = 0.05  # K, half of the difference that gives a slope
_RESERVE = 2.0  # K short of a turn: at it the length does not say how warm the muscle is, beyond it the contrary


class Inverse:
    """Displacement (m) to temperature (K) and back, displacement being zero at rest at T0 under ``load`` (N)."""

    def __init__(self, model: Parameters, load: float) -> None:
        self._model = model
        self._rest = length_at(model, model['T0'], load)

    def displacement(self, temperature: float, load: float) -> float:
        """The contraction (m) at a temperature (K) under a load (N)."""
        return self._rest - length_at(self._model, temperature, load)

    def furthest(self, load: float) -> float | None:
        """The contraction (m) beyond which heating lengthens the muscle again; None where it never does.

        It does where softening overtakes the contraction, under a heavy load, or where a table says so
        (``free_stroke``). A setpoint beyond it has no temperature on the branch that is used.
        """
        _, high = shortening(self._model, load)
        return None if high >= DOMAIN_HIGH else self.displacement(high, load)

    def hottest(self, load: float) -> float:
        """Up to which temperature (K) a position can be held by its feedback; inf where heating never lengthens."""
        _, high = shortening(self._model, load)
        return inf if high >= DOMAIN_HIGH else high - _RESERVE

    def slope(self, temperature: float, load: float) -> float:
        """How much further the muscle contracts a kelvin, m/K; at least a tenth of what it does at T0 unloaded."""
        reach = self.displacement(temperature + _STEP, load) - self.displacement(temperature - _STEP, load)
        cold = self.displacement(self._model['T0'] + _STEP, 0.0) - self.displacement(self._model['T0'] - _STEP, 0.0)
        return max(reach, 0.1 * cold) / (2.0 * _STEP)

    def temperature(self, displacement: float, load: float) -> float:
        """The temperature (K) at which it is contracted by this much (m); beyond the domain along the tangent."""
        found = temperature_for_length(self._model, self._rest - displacement, load)
        missing = displacement - self.displacement(found, load)
        if abs(missing) < 1e-9:
            return found
        return found + missing / self.slope(found, load)

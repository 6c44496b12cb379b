"""What the controller knows of the muscle: its temperature coordinate, and how far the model is off.

    C dz/dt = -hA (z - Tinf) + g i^2 R(z) + w

z is measured with noise; g (1 in the model) is what the heating gain really is: it takes up errors of R0, of C and
of the stroke gain; w (0 in the model, W) takes up every other power: of convection, of ambient, of creep as it
looks in z. An extended Kalman filter estimates the three with the current that really flowed. It is the integral
action of the controller, and cannot wind up: at a limit the prediction is made with the limit.

g beside w is what keeps a large step from overshooting. With w alone, an error of 20 % of the full current's power
would be carried over into the much smaller power that holds the setpoint.
"""

from math import exp, expm1, sqrt

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.muscle import Parameters

_GAIN_SPREAD = 0.35  # of g before anything is known: 20 % each of R0, C and the stroke gain
_GAIN_DRIFT = 0.01  # of g in a root second
_POWER_SPREAD = 0.1  # of w before anything is known, in units of the power lost at 50 K above ambient
_POWER_DRIFT = 0.06  # of w in a root second, in the same units
_GAIN_RANGE = (0.2, 5.0)
_JUMP = 6.0  # standard deviations; a larger surprise is a jump of z (a load nobody announced), not a power
_QUIETEST = 2e-3  # K, no sensor is taken to be better


def _phi1(z: float) -> float:
    return expm1(z) / z if abs(z) > 1e-8 else 1.0 + 0.5 * z


class Noise:
    """Standard deviation of a sensor's noise from its second differences: a muscle hardly bends within a sample.

    White noise of variance s^2 gives second differences of variance 6 s^2; quantisation and jitter of the time
    stamps are seen the same way. Averaged over about 100 samples; a single jump counts little.
    """

    def __init__(self) -> None:
        self._before: list[float] = []
        self._variance = (5.0 * _QUIETEST) ** 2

    def add(self, value: float) -> None:
        """One more sample, K."""
        self._before.append(value)
        if len(self._before) == 3:
            first, second, third = self._before
            surprise = (first - 2.0 * second + third) ** 2 / 6.0
            self._variance += 0.01 * (min(surprise, 25.0 * self._variance) - self._variance)
            del self._before[0]

    @property
    def deviation(self) -> float:
        """K, at least 2 mK."""
        return max(sqrt(self._variance), _QUIETEST)


class Observer:
    """The filter. Temperatures in K, currents in A, powers in W; one ``predict`` a period."""

    def __init__(self, model: Parameters, period: float) -> None:
        self.period = period
        self._R0, self._a_R, self._T0 = model['R0'], model['a_R'], model['T0']
        self._hA, self._C = model['hA'], model['C']
        self._unit = 50.0 * self._hA
        self.noise = Noise()
        self.started = False
        self.temperature, self.gain, self.power = self._T0, 1.0, 0.0
        self._P: NDArray[np.float64] = np.zeros((3, 3))

    def start(self, temperature: float) -> None:
        """Begin at this temperature (K), with the model as it stands. What is known of the noise stays."""
        self.started = True
        self.temperature, self.gain, self.power = temperature, 1.0, 0.0
        self._P = np.diag([0.1**2 + self.noise.deviation**2, _GAIN_SPREAD**2, (_POWER_SPREAD * self._unit) ** 2])

    def resistance(self, temperature: float) -> float:
        """The model's resistance, ohm."""
        return self._R0 * (1.0 + self._a_R * (temperature - self._T0))

    def after(self, temperature: float, current: float, ambient: float) -> float:
        """Where the temperature is a period later: the exact step under a constant current."""
        cold = self.gain * current**2 * self._R0
        rate = (cold * self._a_R - self._hA) / self._C
        constant = cold * (1.0 + self._a_R * (ambient - self._T0)) + self.power
        z = rate * self.period
        return ambient + (temperature - ambient) * exp(z) + constant * self.period / self._C * _phi1(z)

    def predict(self, current: float, ambient: float) -> None:
        """One period passes with this current."""
        rate = (self.gain * current**2 * self._R0 * self._a_R - self._hA) / self._C
        weight = self.period / self._C * _phi1(rate * self.period)
        heating = current**2 * self.resistance(self.temperature)
        step = np.array([[exp(rate * self.period), heating * weight, weight], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        self.temperature = self.after(self.temperature, current, ambient)
        self._P = step @ self._P @ step.T
        # A gain shows only while current flows; without it, not knowing must not grow without end.
        if self._P[1, 1] < _GAIN_SPREAD**2:
            self._P[1, 1] += self.period * _GAIN_DRIFT**2
        self._P[2, 2] += self.period * (_POWER_DRIFT * self._unit) ** 2

    def correct(self, measured: float, deviation: float | None = None) -> None:
        """A measured temperature coordinate (K) of now; ``deviation`` (K) of its noise, None: as it shows itself."""
        if deviation is None:
            self.noise.add(measured)
            deviation = self.noise.deviation
        if not self.started:
            self.start(measured)
            return
        surprise = measured - self.temperature
        variance = deviation**2
        if surprise**2 > _JUMP**2 * (self._P[0, 0] + variance):
            self._P[0, :] = self._P[:, 0] = 0.0
            self._P[0, 0] = surprise**2
        share = self._P[:, 0] / (self._P[0, 0] + variance)
        self.temperature += share[0] * surprise
        self.gain = min(max(self.gain + share[1] * surprise, _GAIN_RANGE[0]), _GAIN_RANGE[1])
        self.power += share[2] * surprise
        self._P = self._P - np.outer(share, self._P[0, :])
        self._P = 0.5 * (self._P + self._P.T)

    def steady_temperature(self, current: float, ambient: float) -> float:
        """Where this current would settle (K), by what is known of the muscle; inf where it runs away."""
        cold = self.gain * current**2 * self._R0
        loss = self._hA - cold * self._a_R
        if loss <= 0.0:
            return float('inf')
        return ambient + (cold * (1.0 + self._a_R * (ambient - self._T0)) + self.power) / loss

    def current_between(self, begin: float, end: float, ambient: float) -> float:
        """The constant current (A) that goes from one temperature (K) to the other in a period; 0 where none does.

        The exact step for a constant power, with the resistance half-way.
        """
        decay = self._hA * self.period / self._C
        power = self._hA * (end - ambient - (begin - ambient) * exp(-decay)) / -expm1(-decay) - self.power
        return sqrt(max(power, 0.0) / (self.gain * max(self.resistance(0.5 * (begin + end)), 0.1 * self._R0)))

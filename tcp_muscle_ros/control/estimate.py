"""The temperature of a muscle from whatever is measured of it: thermometer, resistance, displacement, any of them.

Each is turned into the model's temperature coordinate; the controller's observer takes their mean, weighed by the noise
that each shows.
"""

from math import sqrt

from tcp_muscle_ros.control.inverse import Inverse
from tcp_muscle_ros.control.observer import Noise, Observer
from tcp_muscle_ros.muscle import ZERO_CELSIUS, Parameters

_COLDEST, _HOTTEST = ZERO_CELSIUS - 60.0, ZERO_CELSIUS + 250.0  # K


class Estimate:
    """``update`` once a period (s) with what was measured; ``temperature`` is K, None before the first measurement."""

    def __init__(self, model: Parameters, period: float, load: float) -> None:
        self.model = model
        self._inverse = Inverse(model, load)
        self._observer = Observer(model, period)
        self._noise = {name: Noise() for name in ('temperature', 'resistance', 'displacement')}

    @property
    def temperature(self) -> float | None:
        """K, of the fibre."""
        return self._observer.temperature if self._observer.started else None

    def update(
        self,
        current: float,
        load: float,
        ambient: float,
        *,
        temperature: float | None = None,
        resistance: float | None = None,
        displacement: float | None = None,
    ) -> float | None:
        """A period with this current (A), then what was measured at its end: K, ohm, m; None where it was not."""
        if self._observer.started:
            self._observer.predict(current, ambient)
        shown = {
            'temperature': temperature,
            'resistance': None if resistance is None else self._of_resistance(resistance),
            'displacement': None if displacement is None else self._inverse.temperature(displacement, load),
        }
        total = weight = 0.0
        for name, value in shown.items():
            if value is not None:
                value = min(max(value, _COLDEST), _HOTTEST)
                noise = self._noise[name]
                noise.add(value)
                share = noise.deviation**-2
                total += share * value
                weight += share
        if weight:
            self._observer.correct(total / weight, 1.0 / sqrt(weight))
        return self.temperature

    def _of_resistance(self, resistance: float) -> float | None:
        slope = self.model['R0'] * self.model['a_R']
        return self.model['T0'] + (resistance - self.model['R0']) / slope if slope else None

    def begin_anew(self) -> None:
        """Nothing is known of the state; what is known of the noise stays."""
        self._observer.started = False

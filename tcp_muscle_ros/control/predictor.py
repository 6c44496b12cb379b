"""What a model says that a muscle shows, tick by tick, and how far its own uncertainty spreads that."""

from collections.abc import Sequence

import numpy as np

from tcp_muscle_ros.muscle import Muscle, Muscles, Parameters
from tcp_muscle_ros.muscle import quantities as at
from tcp_muscle_ros.muscle.arrays import Array

CHANNELS = ('temperature', 'resistance', 'displacement', 'force')
_SHOWN = [at.Y_TEMPERATURE, at.Y_RESISTANCE, at.Y_DISPLACEMENT, at.Y_FORCE]
# What nobody would call a difference: K, ohm, m, N. Below it models and sensors are never at one.
LEAST = np.array([0.05, 5e-3, 1e-5, 2e-3])


class Predictor:
    """A model beside muscles drawn from its intervals, all under the currents that really flowed.

    Args:
        model: the muscle as it is believed to be.
        variants: muscles that it might be as well (of a calibration's intervals); none: it is taken to be exact.
        load: N, the starting load, under which displacement is zero at rest at T0.
        ambient: K, the room in which the model was found; where nobody measures one it is the one that it predicts in.
        end: what holds the muscle, with what ``Muscle`` takes for it.
        source: the file of the model, for whoever is to use it too.
    """

    def __init__(
        self,
        model: Parameters,
        variants: Sequence[Parameters] = (),
        *,
        load: float,
        ambient: float,
        end: str = 'load',
        source: str = '',
        **held: float,
    ) -> None:
        self.source = source
        self.model, self.variants = model, tuple(variants)
        self._muscles = [Muscle(one, end=end, load=load, ambient=ambient, **held) for one in (model, *variants)]
        self._together = Muscles(self._muscles)
        self._imposed = (load, ambient)
        self.ambient = ambient
        self.value: Array = np.zeros(len(CHANNELS))
        self.spread: Array = LEAST.copy()  # standard deviation of the prediction
        self.fibre_temperature = ambient  # K, of the model
        self._rows(self._together.advance(0.0, 0.0))

    def start(self, temperature: float) -> None:
        """At rest at this temperature (K)."""
        for muscle in self._muscles:
            muscle.reset(temperature)
        self._rows(self._together.advance(0.0, 0.0))

    def step(self, dt: float, current: float, load: float, ambient: float | None, late: float) -> None:
        """``dt`` (s) under this current (A), load (N) and ambient (K; None: its own). ``late`` (s): how far the times
        are unsure."""
        imposed = (load, self.ambient if ambient is None else ambient)
        if imposed != self._imposed:
            self._imposed = imposed
            for muscle in self._muscles:
                muscle.impose(*imposed)
        before = self.value
        self._rows(self._together.advance(dt, current))
        if dt > 0.0:
            self.spread = np.hypot(self.spread, np.abs(self.value - before) * (late / dt))

    @property
    def excess(self) -> float:
        """How far the fibre is above the ambient, K."""
        return self.fibre_temperature - self._imposed[1]

    def _rows(self, shown: Array) -> None:
        rows = shown[:, _SHOWN]
        self.value = rows[0].copy()
        self.fibre_temperature = float(shown[0, at.Y_FIBRE_TEMPERATURE])
        own = np.mean((rows[1:] - rows[0]) ** 2, axis=0) if len(rows) > 1 else 0.0
        self.spread = np.sqrt(own + LEAST**2)

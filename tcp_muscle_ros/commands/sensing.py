"""What the sensors of sim_node would make of simulated outputs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tcp_muscle_ros.muscle.sensors import Noise, Sensor

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tcp_muscle_ros.muscle import Outputs
    from tcp_muscle_ros.settings.parameter_file import ParameterFile

_SENSORS = {'temperature': 'k', 'resistance': 'ohm', 'displacement': 'm', 'force': 'n'}


class Sensing:
    """The sensors of one muscle as the parameter file describes them, for outputs that come piece by piece.

    ``seed``: of the noise.
    """

    def __init__(self, file: ParameterFile, seed: int) -> None:
        self._noise = Noise(seed, len(_SENSORS))
        self._sensors = {
            name: Sensor(
                file.number(f'{name}_lag_s'), file.number(f'{name}_noise_{unit}'), file.number(f'{name}_quantum_{unit}')
            )
            for name, unit in _SENSORS.items()
        }
        self._last: float | None = None

    def sensed(self, outputs: Outputs) -> dict[str, NDArray]:
        """The four output channels after lag, noise and quantisation; outputs follow on those of the call before."""
        if all(sensor.ideal for sensor in self._sensors.values()):
            return {name: getattr(outputs, name) for name in _SENSORS}
        before = outputs.time[0] if self._last is None else self._last
        steps = np.diff(outputs.time, prepend=before).tolist()
        self._last = float(outputs.time[-1])
        draws = np.array([self._noise.row() for _ in steps])
        return {
            name: np.array(
                [
                    sensor.read(value, dt, normal)
                    for value, dt, normal in zip(
                        getattr(outputs, name).tolist(), steps, draws[:, k].tolist(), strict=True
                    )
                ]
            )
            for k, (name, sensor) in enumerate(self._sensors.items())
        }

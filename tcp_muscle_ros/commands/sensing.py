"""What the sensors of sim_node would make of simulated outputs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tcp_muscle_ros.muscle.sensors import Noise, Sensor

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tcp_muscle_ros.muscle import Outputs
    from tcp_muscle_ros.settings.parameter_file import ParameterFile

_SENSORS = {'temperature': 'k', 'resistance': 'ohm', 'displacement': 'm', 'force': 'n'}


def sensed(outputs: Outputs, file: ParameterFile) -> dict[str, NDArray]:
    """The four output channels after lag, seeded noise and quantisation as the parameter file says."""
    import numpy as np

    noise = Noise(int(file.number('seed')), len(_SENSORS))
    steps = np.diff(outputs.time, prepend=outputs.time[0])
    shown = {}
    sensors = {
        name: Sensor(
            file.number(f'{name}_lag_s'), file.number(f'{name}_noise_{unit}'), file.number(f'{name}_quantum_{unit}')
        )
        for name, unit in _SENSORS.items()
    }
    if all(sensor.ideal for sensor in sensors.values()):
        return {name: getattr(outputs, name) for name in _SENSORS}
    draws = np.array([noise.row() for _ in outputs.time])
    for k, (name, sensor) in enumerate(sensors.items()):
        values = getattr(outputs, name).tolist()
        read = [sensor.read(v, dt, z) for v, dt, z in zip(values, steps.tolist(), draws[:, k].tolist(), strict=True)]
        shown[name] = np.array(read)
    return shown

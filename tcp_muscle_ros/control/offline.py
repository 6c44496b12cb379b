"""Controller and simulated muscle in one loop, as fast as it goes, with the timing of the two nodes.

At t_k the muscle is measured and the current decided a period ago begins to flow; the controller's answer flows
from t_{k+1}.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tcp_muscle_ros.control.tracking import TrackingController
from tcp_muscle_ros.muscle import Muscle

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sensors:
    """Standard deviations and quanta; 0 = perfect. ``feedback``: what the controller is given."""

    displacement_noise: float = 0.0  # m
    displacement_quantum: float = 0.0  # m
    resistance_noise: float = 0.0  # ohm
    least_sense_current: float = 0.0  # A, below it no resistance
    feedback: str = 'displacement'  # or 'resistance'
    load_is_told: bool = True
    seed: int = 0


PERFECT = Sensors()


@dataclass(frozen=True)
class Run:
    """What happened: arrays of shape (n,), SI, temperature (of the fibre) in K."""

    time: Array
    setpoint: Array
    shaped: Array
    displacement: Array
    temperature: Array
    current: Array


def run(
    controller: TrackingController,
    muscle: Muscle,
    period: float,
    setpoint: ArrayLike,
    *,
    load: ArrayLike | None = None,
    sensors: Sensors = PERFECT,
) -> Run:
    """Close the loop over ``setpoint`` (m, shape (n,)), with the load (N, shape (n,)) if it changes."""
    wanted = np.asarray(setpoint, dtype=np.float64)
    loads = None if load is None else np.asarray(load, dtype=np.float64)
    chance = np.random.default_rng(sensors.seed)
    x, shaped, temperature, current = (np.zeros(wanted.size) for _ in range(4))
    flowing = 0.0
    reading = muscle.reading(0.0, load=None if loads is None else float(loads[0]))
    for k in range(wanted.size):
        x[k], temperature[k], current[k] = reading.displacement, reading.fibre_temperature, flowing
        seen = reading.displacement + sensors.displacement_noise * chance.standard_normal()
        if sensors.displacement_quantum:
            seen = round(seen / sensors.displacement_quantum) * sensors.displacement_quantum
        ohm = reading.resistance + sensors.resistance_noise * chance.standard_normal()
        by_resistance = sensors.feedback == 'resistance'
        command = controller.update(
            float(wanted[k]),
            displacement=None if by_resistance else seen,
            resistance=ohm if by_resistance and flowing >= sensors.least_sense_current else None,
            load=float(loads[k]) if loads is not None and sensors.load_is_told else None,
            applied_current=flowing,
        )
        shaped[k] = command.shaped_setpoint
        # The load of t_k acts from t_k on, as the current does.
        reading = muscle.step(period, flowing, load=None if loads is None else float(loads[k]))
        flowing = command.current
    return Run(period * np.arange(wanted.size, dtype=np.float64), wanted, shaped, x, temperature, current)

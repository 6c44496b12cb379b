"""The muscle: given current, power or voltage, load or held length, ambient and dt, what it shows.

Knows nothing of files, ROS or the time of day.
"""

from tcp_muscle_ros.muscle.effects import EFFECTS
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.electrical import KINDS
from tcp_muscle_ros.muscle.muscle import ENDS, Muscle, Outputs, Reading, simulate
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.parameters import SETS, SPECIFICATIONS, Parameters
from tcp_muscle_ros.muscle.statics import (
    critical_current,
    length,
    resistance,
    steady_current,
    steady_temperature,
    stiffness,
    temperature_for_length,
)
from tcp_muscle_ros.muscle.table import TABLE

__all__ = [
    'EFFECTS',
    'ENDS',
    'KINDS',
    'SETS',
    'SPECIFICATIONS',
    'TABLE',
    'ZERO_CELSIUS',
    'Effect',
    'Muscle',
    'Outputs',
    'Parameter',
    'Parameters',
    'Reading',
    'critical_current',
    'length',
    'resistance',
    'simulate',
    'steady_current',
    'steady_temperature',
    'stiffness',
    'temperature_for_length',
]

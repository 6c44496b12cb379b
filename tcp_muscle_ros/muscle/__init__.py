"""The muscle: given current, power or voltage, load or held length, ambient and dt, what it shows.

Knows nothing of files, ROS or the time of day.
"""

from tcp_muscle_ros.muscle.effects import EFFECTS, LISTED
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.electrical import KINDS
from tcp_muscle_ros.muscle.joint import Joint, Link
from tcp_muscle_ros.muscle.muscle import ENDS, Muscle, Outputs, Reading, Schedule, follow, simulate, simulate_on
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.parameters import SETS, SPECIFICATIONS, Parameters
from tcp_muscle_ros.muscle.statics import (
    critical_current,
    length,
    length_at,
    resistance,
    shortening,
    steady_current,
    steady_temperature,
    stiffness,
    temperature_for_length,
    tension,
)
from tcp_muscle_ros.muscle.table import TABLE
from tcp_muscle_ros.muscle.together import Muscles

__all__ = [
    'EFFECTS',
    'ENDS',
    'KINDS',
    'LISTED',
    'SETS',
    'SPECIFICATIONS',
    'TABLE',
    'ZERO_CELSIUS',
    'Effect',
    'Joint',
    'Link',
    'Muscle',
    'Muscles',
    'Outputs',
    'Parameter',
    'Parameters',
    'Reading',
    'Schedule',
    'critical_current',
    'follow',
    'length',
    'length_at',
    'resistance',
    'shortening',
    'simulate',
    'simulate_on',
    'steady_current',
    'steady_temperature',
    'stiffness',
    'temperature_for_length',
    'tension',
]

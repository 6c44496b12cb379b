"""What was imposed on a muscle, and what held its end."""

from dataclasses import dataclass, field

import numpy as np

from tcp_muscle_ros.muscle.arrays import Array

FOLLOWS_SETPOINT = 'follows_setpoint'  # in Experiment.known: a setpoint of the displacement was recorded


@dataclass(frozen=True)
class Imposed:
    """What was imposed: drive (A, W or V by ``kind``), load (N), ambient (K) at ``time`` (s), each shape (n,).

    ``switches``: when a record that samples the drive last showed a level, and first the next one (s), shape (k, 2);
    ``lost``: the same where samples between the two were lost. ``unsure``: what of the ambient its thermometer does not
    tell, K.
    """

    kind: str
    time: Array
    drive: Array
    load: Array
    ambient: Array
    switches: Array = field(default_factory=lambda: np.empty((0, 2)))
    lost: Array = field(default_factory=lambda: np.empty((0, 2)))
    unsure: float = 0.0


@dataclass(frozen=True)
class Holding:
    """What holds the end: as the arguments of Muscle."""

    end: str = 'load'
    starting_load: float = 0.0
    held_length: float = 0.0
    spring_rate: float = 0.0
    spring_rest_length: float = 0.0

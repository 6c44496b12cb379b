"""What was imposed on a muscle, and what held its end."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tcp_muscle_ros.muscle import Schedule
from tcp_muscle_ros.muscle.arrays import Array, Mask

_AT, _SAME = 1e-6, 1e-9  # s, less is no other instant
_DRIVEN = 0.1  # of the largest drive

FOLLOWS_SETPOINT = 'follows_setpoint'  # in Experiment.known: a setpoint of the displacement was recorded


def driven(drive: Array) -> Mask:
    """Where a drive heats, shape as it has: what is a tenth of its largest or less keeps the resistance readable."""
    size = np.abs(drive)
    return np.asarray(size > _DRIVEN * np.max(size, initial=0.0))


class Earlier(NamedTuple):
    """A switch of the drive between two samples, last ``before`` it and first as ``shown`` (s): it came by a ``share``
    of the time between them earlier than shown."""

    before: float
    shown: float
    share: float


@dataclass(frozen=True)
class Imposed:
    """What was imposed: drive (A, W or V by ``kind``), load (N), ambient (K) at ``time`` (s), each shape (n,).

    ``switches``: when a record that samples the drive last showed a level, and first the next one (s), shape (k, 2);
    ``lost``: the same where samples between the two were lost. ``unsure``: what of the ambient its thermometer does not
    tell, K; ``unread``: it had none.
    """

    kind: str
    time: Array
    drive: Array
    load: Array
    ambient: Array
    switches: Array = field(default_factory=lambda: np.empty((0, 2)))
    lost: Array = field(default_factory=lambda: np.empty((0, 2)))
    unsure: float = 0.0
    unread: bool = False

    @cached_property
    def schedule(self) -> Schedule:
        """It, as a muscle follows it."""
        return Schedule.of(self.time, self.drive, self.load, self.ambient)

    def switched(self, switch: Earlier) -> 'Imposed':
        """The same with the drive switched earlier than it was shown."""
        at = switch.shown - switch.share * (switch.shown - switch.before)
        next_level = self.drive[np.searchsorted(self.time, switch.shown - _SAME)]
        imposed = self
        if not np.any(np.abs(self.time - at) < _AT):
            k = int(np.searchsorted(self.time, at))
            imposed = replace(
                self,
                time=np.insert(self.time, k, at),
                drive=np.insert(self.drive, k, self.drive[k - 1]),
                load=np.insert(self.load, k, self.load[k - 1]),
                ambient=np.insert(self.ambient, k, self.ambient[k - 1]),
            )
        early = (imposed.time > at - _AT) & (imposed.time < switch.shown - _SAME)
        return replace(imposed, drive=np.where(early, next_level, imposed.drive))


@dataclass(frozen=True)
class Holding:
    """What holds the end: as the arguments of Muscle."""

    end: str = 'load'
    starting_load: float = 0.0
    held_length: float = 0.0
    spring_rate: float = 0.0
    spring_rest_length: float = 0.0

    @property
    def hangs(self) -> bool:
        """Whether a load is at the end, and nothing holds it."""
        return self.end == 'load'

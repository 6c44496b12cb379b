"""Whose numbers a topic of joint states holds: of one joint, of several, of one and another in turn."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.recording.bag_channels import Source
from tcp_muscle_ros.recording.cdr import FieldPath
from tcp_muscle_ros.recording.columns import Topic
from tcp_muscle_ros.recording.recording import Array

JOINT_STATE = 'sensor_msgs/msg/JointState'
_NAME = 'name['
_SECOND = f'{_NAME}1]', 'position[1]'  # a driver may leave out the names


def joint_paths(places: Iterable[str | int]) -> dict[str, FieldPath]:
    """What to decode beside the numbers at these places of the sequences: who is there, and whether there are more."""
    names: dict[str, FieldPath] = {f'{_NAME}{place}]': ('name', place) for place in places if isinstance(place, int)}
    return names | dict(zip(_SECOND, (('name', 1), ('position', 1)), strict=True))


@dataclass(frozen=True)
class Joints:
    """The joints of a topic: whether any message has several, and where, as name[0], not all have the same."""

    several: bool
    changing: frozenset[str]

    def doubt(self, source: Source, value: Array) -> str:
        """Why a source's values are maybe not the muscle's; '' where nothing speaks against it."""
        place = f'{_NAME}{source.field.partition("[")[2]}'
        if place in self.changing:
            end = '' if source.explicit else ': left out'
            return f'{source.topic}: not every message has the same joint at {source.field}{end}'
        if source.explicit:
            return ''
        if self.several:
            choice = f'--channel {source.channel}={source.topic}.{source.field}'
            return f"{source.topic}: has several joints, left out; say which is the muscle's, for example {choice}"
        if source.channel == 'force' and not value.any():  # it would be taken for the load
            return f'{source.topic}: its effort is 0 throughout, as where none is measured: left out'
        return ''


def joints_of(topic: Topic) -> Joints:
    """The joints of a topic of which the ``joint_paths`` were decoded; once, for they are not kept."""
    decoded = {path: topic.field(path) for path in topic.paths if '[' in path}
    names = {path: found for path, found in decoded.items() if path.startswith(_NAME)}
    changing = frozenset(path for path, (who, there) in names.items() if there.any() and np.ptp(who[there]) > 0)
    return Joints(any(decoded[path][1].any() for path in _SECOND), changing)

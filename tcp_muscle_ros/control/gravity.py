"""The torques by which the joints of a robot hold its links against gravity, from its URDF.

    tau_j = - axis_j . sum_i m_i (c_i - o_j) x g   over the links i that joint j carries

Fixed and turning joints; links without ``inertial`` weigh nothing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import cos, isfinite, sin
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.errors import BadInput, nearest

Array = NDArray[np.float64]
EARTH = (0.0, 0.0, -9.81)  # m/s^2


@dataclass(frozen=True)
class _Link:
    joint: str  # by which it hangs on its parent; '' for one that does not turn
    parent: int  # its place in the list; -1 for the root
    place: Array  # of its frame in the parent's, m
    turn: Array  # likewise, a rotation
    axis: Array
    mass: float  # kg
    centre: Array  # of mass, m, in its frame


def _numbers(element: ElementTree.Element | None, name: str, default: str, of: str) -> Array:
    """As many as the default has. BadInput, with the name of the link or joint ``of`` which they are."""
    element = ElementTree.Element('') if element is None else element
    text, count = element.get(name, default), len(default.split())
    try:
        found = [float(part) for part in text.split()]
    except ValueError:
        found = []
    if len(found) != count or not all(map(isfinite, found)):
        hint = '; run xacro over it first' if '${' in text else ''
        wanted = 'a number' if count == 1 else f'{count} numbers'
        raise BadInput(f"the robot description has <{element.tag} {name}='{text}'> in {of}; expected {wanted}{hint}")
    return np.array(found)


def _axis(joint: ElementTree.Element) -> Array:
    """Of length 1."""
    axis = _numbers(joint.find('axis'), 'xyz', '1 0 0', _called(joint))
    length = np.linalg.norm(axis)
    if length == 0.0:
        raise BadInput(f'the robot description has {_called(joint)} turn about the axis 0 0 0; expected a direction')
    return np.asarray(axis / length)


def _called(element: ElementTree.Element) -> str:
    return f"{element.tag} '{element.get('name')}'"


def _cross(vector: Array) -> Array:
    """The matrix that multiplies from the left as ``vector x``."""
    x, y, z = vector.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation(axis: Array, angle: float) -> Array:
    """The matrix that turns by ``angle`` (rad) about a unit ``axis``. Rodrigues."""
    cross = _cross(axis)
    return np.asarray(np.eye(3) + sin(angle) * cross + (1.0 - cos(angle)) * (cross @ cross))


def _roll_pitch_yaw(rpy: Array) -> Array:
    x, y, z = np.eye(3)
    return np.asarray(rotation(z, rpy[2]) @ rotation(y, rpy[1]) @ rotation(x, rpy[0]))


class Gravity:
    """What gravity asks of each turning joint.

    Args:
        urdf: the robot's description, as text.

    Raises:
        BadInput: no URDF, a joint that neither turns nor is fixed, or what is no number where one is expected.
    """

    def __init__(self, urdf: str) -> None:
        try:
            robot = ElementTree.fromstring(urdf)
        except ElementTree.ParseError as problem:
            raise BadInput(f'the robot description is no XML: {problem}') from None
        joints = robot.findall('joint')
        carried = {self._end(joint, 'child'): joint for joint in joints}
        self._links: list[_Link] = []
        self._index: dict[str, int] = {}
        waiting = [str(link.get('name')) for link in robot.findall('link')]
        elements = {str(link.get('name')): link for link in robot.findall('link')}
        while waiting:
            ready = [
                name for name in waiting if name not in carried or self._end(carried[name], 'parent') in self._index
            ]
            if not ready:
                raise BadInput(f"the robot description is no tree: link '{waiting[0]}' hangs on nothing")
            for name in ready:
                self._index[name] = len(self._links)
                self._links.append(self._read(elements[name], carried.get(name)))
                waiting.remove(name)
        self.joints = tuple(link.joint for link in self._links if link.joint)

    @staticmethod
    def _end(joint: ElementTree.Element, which: str) -> str:
        """The link at that end of a joint: ``parent`` or ``child``."""
        end = joint.find(which)
        link = None if end is None else end.get('link')
        if link is None:
            raise BadInput(f"the robot description has no <{which} link='...'> in {_called(joint)}")
        return link

    def _read(self, link: ElementTree.Element, joint: ElementTree.Element | None) -> _Link:
        inertial = link.find('inertial')
        mass = inertial.find('mass') if inertial is not None else None
        origin = inertial.find('origin') if inertial is not None else None
        kind = 'fixed' if joint is None else joint.get('type')
        if kind not in ('fixed', 'revolute', 'continuous'):
            raise BadInput(f"link '{link.get('name')}' hangs on a joint that is {kind}; expected fixed or revolute")
        at = None if joint is None else joint.find('origin')
        of = '' if joint is None else _called(joint)
        turning = None if kind == 'fixed' else joint  # the axis of one that is fixed is often written as 0 0 0
        return _Link(
            joint='' if turning is None else str(turning.get('name')),
            parent=-1 if joint is None else self._index[self._end(joint, 'parent')],
            place=_numbers(at, 'xyz', '0 0 0', of),
            turn=_roll_pitch_yaw(_numbers(at, 'rpy', '0 0 0', of)),
            axis=np.array([1.0, 0.0, 0.0]) if turning is None else _axis(turning),
            mass=float(_numbers(mass, 'value', '0', _called(link))[0]),
            centre=_numbers(origin, 'xyz', '0 0 0', _called(link)),
        )

    def torques(self, angles: Mapping[str, float], gravity: Sequence[float] = EARTH) -> dict[str, float]:
        """The torque (N m) that each joint must give to stay at ``angles`` (rad; 0 where none is given).

        Args:
            angles: by the names of joints.
            gravity: m/s^2, in the frame of the robot's root.

        Raises:
            BadInput: an angle of a joint that the robot does not have.
        """
        for name in angles:
            if name not in self.joints:
                raise BadInput(f"the robot description has no turning joint '{name}'{nearest(name, self.joints)}")
        places: list[Array] = []
        turns: list[Array] = []
        for link in self._links:
            turn, place = (np.eye(3), np.zeros(3)) if link.parent < 0 else (turns[link.parent], places[link.parent])
            places.append(place + turn @ link.place)
            turns.append(turn @ link.turn @ rotation(link.axis, angles.get(link.joint, 0.0) if link.joint else 0.0))
        mass, first_moment = self._carried(places, turns)
        pull = np.asarray(gravity, dtype=np.float64)
        return {
            link.joint: float(-(first_moment[k] - mass[k] * places[k]) @ _cross(pull) @ turns[k] @ link.axis)
            for k, link in enumerate(self._links)
            if link.joint
        }

    def _carried(self, places: list[Array], turns: list[Array]) -> tuple[Array, Array]:
        """Of each link with all that hangs on it: mass (kg), and mass times place (kg m)."""
        mass = np.array([link.mass for link in self._links])
        moment = np.array(
            [link.mass * (at + turn @ link.centre) for link, at, turn in zip(self._links, places, turns, strict=True)]
        )
        for k in range(len(places) - 1, 0, -1):
            parent = self._links[k].parent
            if parent >= 0:
                mass[parent] += mass[k]
                moment[parent] += moment[k]
        return mass, moment

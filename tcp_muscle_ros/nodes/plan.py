"""Which muscles and joints a node works for, and the values of each.

Without ``muscles`` a node has one muscle, called '' here: its parameters and topics stand in the node's own namespace.
With ``muscles: [thumb, index]`` a name such as ``hA`` is the value of all of them and ``thumb.hA`` that of one.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle import EFFECTS
from tcp_muscle_ros.nodes.parameters import KNOWN, Settings, of_rclpy, read, read_list, read_rows
from tcp_muscle_ros.settings.operating import JOINT, JOINTS, MUSCLES, joint_in

_NAME = re.compile(r'[A-Za-z](_?[A-Za-z0-9])*')


@dataclass(frozen=True)
class Plan:
    """The values of each muscle and joint by its name, and those that muscles share where they have no own."""

    muscles: Mapping[str, Settings]
    joints: Mapping[str, Settings]
    shared: Settings

    @property
    def many(self) -> bool:
        """Whether the muscles have names, and so topics and parameters of their own."""
        return '' not in self.muscles


@contextmanager
def naming(name: str) -> Iterator[None]:
    """A mistake found within says whose it is."""
    try:
        yield
    except BadInput as problem:
        raise BadInput(f'{name}: {problem}' if name else str(problem)) from None


def read_plan(overrides: Mapping[str, object], owner: str, namespace: str = '') -> Plan:
    """The plan that files and the command line make for the node ``owner`` in a namespace.

    Raises:
        BadInput: an unknown or unfit name, or a value that its parameter refuses.
    """
    given = dict(overrides)
    names = _names(MUSCLES, given.pop(MUSCLES, None), taken=())
    joint_names = _names(JOINTS, given.pop(JOINTS, None), taken=names)
    if not names:
        if joint_names:
            raise BadInput("parameter 'joints' needs 'muscles': a joint is turned by two of them")
        one = read({'joint_name': joint_in(namespace), **given}, owner)
        return Plan({'': one}, {}, one)
    own: dict[str, dict[str, object]] = {name: {} for name in (*names, *joint_names)}
    shared: dict[str, object] = {}
    for name, value in given.items():
        head, dot, rest = name.partition('.')
        if head in own:
            own[head][rest] = value
        elif (
            dot and name not in KNOWN and head not in EFFECTS and (rest in KNOWN or rest in JOINT or rest == 'effects')
        ):
            raise BadInput(f"parameter '{name}': unknown muscle '{head}'{nearest(head, own)}")
        else:
            shared[name] = value
    if 'joint_name' in shared:
        raise BadInput(f"parameter 'joint_name' is one muscle's: write '{names[0]}.joint_name' (default: '{names[0]}')")
    everywhere = read(shared, owner)
    joints, muscles = {}, {}
    for name in joint_names:
        with naming(name):
            joints[name] = read_rows(own[name], JOINT, owner)
    for name in _on_joints(joints, names):
        end = own[name].get('end', shared.get('end', 'blocked'))
        if end != 'blocked':
            raise BadInput(f"{name}: parameter 'end' is '{end}', but a joint holds its end; leave it out")
        own[name]['end'] = 'blocked'
    for place, name in enumerate(names):
        with naming(name):
            muscles[name] = _of_one(name, place, own[name], shared, everywhere, owner)
    _refuse_twice('joint_name', [*(settings['joint_name'] for settings in muscles.values()), *joints])
    return Plan(muscles, joints, everywhere)


def _of_one(
    name: str, place: int, own: Mapping[str, object], shared: Mapping[str, object], everywhere: Settings, owner: str
) -> Settings:
    for parameter in own:
        if of_rclpy(parameter) or (parameter in KNOWN and KNOWN[parameter].per_node):
            raise BadInput(f"parameter '{parameter}' is the whole node's: write it without '{name}.'")
    default: dict[str, object] = {'joint_name': name}
    if 'seed' in everywhere:
        default['seed'] = everywhere['seed'] + place  # the same noise on every sensor would be none to an average
    return read({**shared, **default, **own}, owner)


def _names(parameter: str, value: object, taken: Iterable[str]) -> tuple[str, ...]:
    names = read_list(parameter, value, 'such as [thumb, index]')
    for name in names:
        if not _NAME.fullmatch(name):
            raise BadInput(
                f"parameter '{parameter}': '{name}' is no name for topics; expected letters, digits and single "
                f'underscores, a letter first'
            )
        if name in EFFECTS:
            raise BadInput(f"parameter '{parameter}': '{name}' is the name of an effect; choose another")
    _refuse_twice(f"parameter '{parameter}'", [*taken, *names])
    return names


def _refuse_twice(what: str, names: Iterable[str]) -> None:
    seen = set()
    for name in names:
        if name in seen:
            raise BadInput(f"{what}: '{name}' stands there twice")
        seen.add(name)


def pair(joint: Settings) -> tuple[str, str]:
    """The names of the agonist and the antagonist of a joint."""
    return joint['agonist'], joint['antagonist']


def _on_joints(joints: Mapping[str, Settings], muscles: Iterable[str]) -> Iterable[str]:
    """The muscles that pull at joints."""
    known = set(muscles)
    used: dict[str, str] = {}
    for joint, settings in joints.items():
        for role, name in zip(('agonist', 'antagonist'), pair(settings), strict=True):
            if name not in known:
                raise BadInput(f"{joint}: parameter '{role}' is '{name}', no muscle{nearest(name, known)}")
            if name in used:
                raise BadInput(f"{joint}: parameter '{role}': '{name}' already pulls at '{used[name]}'")
            used[name] = joint
    return used

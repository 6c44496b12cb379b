"""The nodes' ROS parameters, declared from the two tables in which each is written once.

What the muscle is stands in ``muscle.edges.EDGES``, how it is run in ``operating.OPERATING``.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor

from tcp_muscle_ros.control.safety import Limits
from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle import EFFECTS, ZERO_CELSIUS, Parameters
from tcp_muscle_ros.muscle.edges import EDGES, Edge, check_whole, inside
from tcp_muscle_ros.muscle.family import GEOMETRY
from tcp_muscle_ros.settings.operating import BOTH, OPERATING, Operating, read_value, shown
from tcp_muscle_ros.settings.rig import on_rig, read_rig

Value = float | int | bool | str | tuple[str, ...] | tuple[float, ...]

_DECLARED_BY_RCLPY = ('use_sim_time', 'start_type_description_service')
_LARGEST_INTEGER = 2**63 - 1


def _is_a_law(name: str, edge: Edge) -> bool:
    """Whether it says which law an effect follows that has states: to another law those of the first mean nothing."""
    return bool(edge.row.choices) and bool(EFFECTS[name.partition('.')[0]].states)


def _of_the_muscle(name: str, edge: Edge) -> Operating:
    row, default = edge.row, edge.default
    meaning = f'{edge.meaning}; {edge.source}'
    fixed = name in GEOMETRY or _is_a_law(name, edge)
    if isinstance(default, tuple):
        many = Operating(name, default, edge.unit, meaning, BOTH, row.low, row.high, same_as=edge.follows)
        return replace(many, fewest=edge.fewest, most=len(edge.members))
    if isinstance(default, str):
        return Operating(name, default, '', meaning, BOTH, choices=row.choices, read_only=fixed)
    # Zero stands for "derived from the others" where the table says so: then the bounds must reach it.
    low, high = min(row.edge_low, default), max(row.edge_high, default)
    return Operating(name, default, edge.unit, meaning, BOTH, low, high, read_only=fixed)


KNOWN: Mapping[str, Operating] = {
    **{name: _of_the_muscle(name, edge) for name, edge in EDGES.items()},
    **OPERATING,
}


def read_list(parameter: str, value: object, example: str) -> tuple[str, ...]:
    """A list of names; ``['']`` and an empty list, which ROS hands over as nothing, are none."""
    if value is None:
        return ()
    if isinstance(value, str) or not isinstance(value, Iterable) or not all(isinstance(name, str) for name in value):
        raise BadInput(f"parameter '{parameter}' is {shown(value)}; expected a list of names, {example}")
    return tuple(name for name in value if name)


def read_effects(value: object) -> tuple[str, ...]:
    """The value of ``effects``."""
    names = read_list('effects', value, 'such as [creep, radiation]')
    for name in names:
        if name not in EFFECTS:
            raise BadInput(f"parameter 'effects': unknown effect '{name}'{nearest(name, EFFECTS)}")
    return names


def descriptor(row: Operating) -> ParameterDescriptor:
    """What ``ros2 param describe`` shows, and the bounds that rclpy holds later changes to."""
    unit = f' ({row.unit})' if row.unit else ''
    made = ParameterDescriptor(name=row.name, description=f'{row.meaning}{unit}', read_only=row.read_only)
    if row.choices:
        made.additional_constraints = 'one of: ' + ', '.join(row.choices)
    if isinstance(row.default, tuple):
        made.additional_constraints = f'{row.fewest} to {row.most} numbers, each {row.low:g} to {row.high:g}'
    elif isinstance(row.default, float):
        made.floating_point_range = [FloatingPointRange(from_value=float(row.low), to_value=float(row.high), step=0.0)]
    elif isinstance(row.default, int) and not isinstance(row.default, bool):
        high = min(int(row.high), _LARGEST_INTEGER)
        made.integer_range = [IntegerRange(from_value=int(row.low), to_value=high, step=1)]
    return made


class Settings(Mapping[str, Any]):
    """A node's parameters by name, as they are in force. Temperatures are in degC, as at the edge."""

    def __init__(self, values: Mapping[str, Value], rows: Mapping[str, Operating] = KNOWN) -> None:
        self._values = dict(values)
        self.rows = rows

    def __getitem__(self, name: str) -> Any:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def kelvin(self, name: str) -> float:
        """A temperature as the model takes it."""
        return float(self[name]) + ZERO_CELSIUS

    def muscle(self) -> Parameters:
        """The muscle that these values describe, on the rig whose file they name.

        Raises:
            BadInput: a value outside its bounds, or a rig that cannot be read.
        """
        given = {name: self[name] for name in EDGES if name in self}
        muscle = Parameters(inside(given)).with_effects(*self['effects'])
        rig = self.get('rig_file')
        return on_rig(muscle, read_rig(rig)) if rig else muscle

    def limits(self, *, command_timeout: float) -> Limits:
        """The safety limits that these values describe.

        Raises:
            BadInput: limits that contradict each other.
        """
        return Limits(
            current=self['current_limit_a'],
            slew=self['slew_limit_a_per_s'],
            command_timeout=command_timeout,
            derate_temperature=self.kelvin('derate_temperature_c'),
            max_temperature=self.kelvin('max_temperature_c'),
            longest_step=self.longest_step,
        )

    @property
    def longest_step(self) -> float:
        """A longer step of the clock, s, is a jump."""
        return max(1.0, 10.0 / self['rate_hz'])

    def changed(self, changes: Mapping[str, object]) -> 'Settings':
        """These with some values replaced. Raises BadInput as ``read_value``."""
        taken = {name: read_value(self.rows[name], value) for name, value in changes.items() if name in self.rows}
        return Settings({**self._values, **taken}, self.rows)


def of_rclpy(name: str) -> bool:
    """Whether rclpy itself declares the parameter."""
    return name in _DECLARED_BY_RCLPY or name.startswith('qos_overrides.')


def read_rows(overrides: Mapping[str, object], rows: Mapping[str, Operating], owner: str) -> Settings:
    """The values of one table, as far as they are the node's. Raises BadInput as ``read``."""
    for name, value in overrides.items():
        if name not in rows:
            raise BadInput(f"unknown parameter '{name}'{nearest(name, rows)}")
        read_value(rows[name], value)
    mine = {name: row for name, row in rows.items() if owner in row.owners}
    return Settings({name: read_value(row, overrides.get(name, row.default)) for name, row in mine.items()}, rows)


def read(overrides: Mapping[str, object], owner: str) -> Settings:
    """The values of the node ``owner``: the defaults, and over them what files and the command line say.

    A name of the package's other node is accepted and left alone, so that one file serves both; so are the parameters
    of effects that are off.

    Raises:
        BadInput: an unknown name (with the nearest one), or a value that its parameter refuses.
    """
    taken: dict[str, Value] = {}
    for name, value in overrides.items():
        if name in KNOWN:
            taken[name] = read_value(KNOWN[name], value)  # the other node's too: a mistake is one wherever it stands
        elif name != 'effects' and not of_rclpy(name):
            raise BadInput(f"unknown parameter '{name}'{nearest(name, ('effects', *KNOWN))}")
    if not str(taken.get('joint_name', 'left out')).strip():
        raise BadInput("parameter 'joint_name' is ''; expected the name of a joint, or leave it out")
    check_whole(taken)
    effects = read_effects(overrides.get('effects'))
    values: dict[str, Value] = {'effects': effects}
    for name, row in KNOWN.items():
        effect, of_an_effect, _ = name.partition('.')
        if owner in row.owners and (not of_an_effect or effect in effects):
            values[name] = taken.get(name, values[row.same_as] if row.same_as else row.default)
    return Settings(values)

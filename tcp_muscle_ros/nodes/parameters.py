"""The nodes' ROS parameters: the muscle's own from its table, the operating ones from here, each written once."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from tcp_muscle_ros import muscle
from tcp_muscle_ros.control.safety import Limits
from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle import ZERO_CELSIUS, Parameters

Value = float | int | bool | str | tuple[str, ...]

_GEOMETRY = ('L0', 'H0', 'D0')
_OURS_TOO = ('use_sim_time', 'start_type_description_service')  # rclpy declares these itself


@dataclass(frozen=True)
class Setting:
    """One ROS parameter. The unit is in the name; ``like`` names the one whose value is the default."""

    name: str
    default: Value
    meaning: str
    low: float = 0.0
    high: float = 0.0
    unit: str = ''
    choices: tuple[str, ...] = ()
    read_only: bool = False
    like: str = ''

    def read(self, value: object) -> Value:
        """A value from a file or the command line as this one's type.

        Raises:
            BadInput: a wrong type, outside the bounds, or none of the choices.
        """
        wanted: Value | None = None
        if isinstance(self.default, bool):
            wanted = value if isinstance(value, bool) else None
        elif isinstance(self.default, int):
            whole = isinstance(value, int) or (isinstance(value, float) and value.is_integer())
            wanted = int(value) if whole and not isinstance(value, bool) else None  # type: ignore[call-overload]
        elif isinstance(self.default, float):
            wanted = float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
        elif isinstance(self.default, str):
            wanted = value if isinstance(value, str) else None
        elif value is None:  # `effects: []`
            wanted = ()
        elif isinstance(value, Sequence) and all(isinstance(entry, str) for entry in value):
            wanted = tuple(value)
        if wanted is None:
            raise BadInput(f"parameter '{self.name}' is {_shown(value)}; expected {self._expected()}")
        if isinstance(wanted, str) and self.choices and wanted not in self.choices:
            raise BadInput(f"parameter '{self.name}' is '{wanted}'{nearest(wanted, self.choices)}")
        if self._has_range and not self.low <= wanted <= self.high:  # type: ignore[operator] # false for NaN
            raise BadInput(f"parameter '{self.name}' is {_shown(wanted)}; expected {self._expected()}")
        return wanted

    @property
    def _has_range(self) -> bool:
        return isinstance(self.default, int | float) and not isinstance(self.default, bool)

    def _expected(self) -> str:
        if isinstance(self.default, bool):
            return 'true or false'
        if isinstance(self.default, str):
            return ' or '.join(self.choices) if self.choices else 'a text'
        if isinstance(self.default, tuple):
            return 'a list of names, as [creep, natural_convection]'
        kind = 'a whole number from ' if isinstance(self.default, int) else ''
        return f'{kind}{self.low:g} to {self.high:g} {self.unit}'.rstrip() + f' ({self.meaning})'

    def descriptor(self) -> ParameterDescriptor:
        """What ``ros2 param describe`` shows, and what rclpy holds later changes to."""
        unit = f', {self.unit}' if self.unit else ''
        descriptor = ParameterDescriptor(name=self.name, description=f'{self.meaning}{unit}', read_only=self.read_only)
        if self.choices:
            descriptor.additional_constraints = 'one of: ' + ', '.join(self.choices)
        if self._has_range and isinstance(self.default, int):
            descriptor.integer_range = [IntegerRange(from_value=int(self.low), to_value=int(self.high), step=1)]
        elif self._has_range:
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=float(self.low), to_value=float(self.high), step=0.0)
            ]
        return descriptor


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if value is None:
        return 'empty'
    return f'{value:g}' if isinstance(value, float) else f"'{value}'" if isinstance(value, str) else str(value)


def _degrees(name: str, default: float, low: float, high: float, meaning: str, **more: Any) -> Setting:
    return Setting(name, default, meaning, low, high, 'degC', **more)


_DEFAULT = Limits()

SHARED = (
    Setting('rate_hz', 100.0, 'ticks a second', 1.0, 2000.0, 'Hz', read_only=True),
    Setting('joint_name', 'tcp_muscle', 'name of the joint, and frame of the stamped messages', read_only=True),
    Setting('start_enabled', True, 'current may flow without ~/enable', read_only=True),
    Setting('load_n', 0.588399, 'pulling force until one arrives on load; displacement is zero under it',
            0.0, 1000.0, 'N', read_only=True),
    _degrees('ambient_temperature_c', 23.0, -50.0, 150.0, 'ambient until one arrives on ambient_temperature'),
    Setting('current_limit_a', _DEFAULT.current, 'highest current', 0.0, 10.0, 'A'),
    Setting('slew_limit_a_per_s', _DEFAULT.slew, 'fastest change of the current; 0 = off', 0.0, 1e6, 'A/s'),
    _degrees('derate_temperature_c', _DEFAULT.derate_temperature - ZERO_CELSIUS, 0.0, 250.0,
             'from here the current limit falls, to zero at max_temperature_c'),
    _degrees('max_temperature_c', _DEFAULT.max_temperature - ZERO_CELSIUS, 0.0, 250.0,
             'here the fault latches'),
    Setting('displacement_quantum_m', 0.0, 'step of the displacement sensor; 0 = none', 0.0, 0.1, 'm'),
    Setting('resistance_quantum_ohm', 0.0, 'step of the resistance measurement; 0 = none', 0.0, 1e3, 'ohm'),
)  # fmt: skip


def _sensor(name: str, unit: str, suffix: str, high: float, *, quantum: bool) -> Iterable[Setting]:
    yield Setting(f'{name}_noise_{suffix}', 0.0, f'noise of the {name}, standard deviation', 0.0, high, unit)
    yield Setting(f'{name}_lag_s', 0.0, f'time constant of the {name} sensor', 0.0, 1e3, 's')
    if quantum:
        yield Setting(f'{name}_quantum_{suffix}', 0.0, f'step of the {name} sensor; 0 = none', 0.0, high, unit)


SIM_NODE = (
    Setting('real_time_factor', 1.0, 'simulated over real time; 0 = as fast as it goes; other than 1 publishes /clock',
            0.0, 1e4, read_only=True),
    _degrees('initial_temperature_c', 23.0, -50.0, 150.0, 'at the start and after ~/reset; default the ambient',
             like='ambient_temperature_c'),
    Setting('end', 'load', 'what the end pulls on', choices=muscle.ENDS, read_only=True),
    Setting('held_length_m', 0.0, 'of a blocked muscle, or to the far end of the spring; 0 = that with load_n at rest',
            0.0, 100.0, 'm', read_only=True),
    Setting('spring_rate_n_per_m', 0.0, 'for end: spring', 0.0, 1e7, 'N/m', read_only=True),
    Setting('spring_rest_length_m', 0.0, 'for end: spring', 0.0, 100.0, 'm', read_only=True),
    Setting('command_timeout_s', _DEFAULT.command_timeout, 'age at which a command counts no more; 0 = never',
            0.0, 3600.0, 's'),
    Setting('min_sense_current_a', 0.0, 'below it no resistance is published', 0.0, 10.0, 'A'),
    Setting('seed', 0, 'of the sensor noise', 0, 2**31 - 1, read_only=True),
    *_sensor('temperature', 'K', 'k', 100.0, quantum=True),
    *_sensor('resistance', 'ohm', 'ohm', 1e3, quantum=False),
    *_sensor('displacement', 'm', 'm', 0.1, quantum=False),
    *_sensor('force', 'N', 'n', 100.0, quantum=True),
)  # fmt: skip

CONTROLLER_NODE = (
    Setting('feedback', 'displacement', 'what is measured', choices=('displacement', 'resistance'), read_only=True),
    Setting('mode', 'model', 'model inverse with feedback, or a plain PID', choices=('model', 'pid'), read_only=True),
    Setting('feedback_timeout_s', 0.0, 'age at which feedback counts as lost; 0 = the longer of 3 periods and 0.2 s',
            0.0, 60.0, 's'),
    Setting('probe_current_a', 0.0, 'with resistance feedback: flows while no resistance comes; 0 = none',
            0.0, 1.0, 'A'),
)  # fmt: skip


def _of_the_muscle(name: str, row: muscle.Parameter) -> Setting:
    # Zero stands for "derived from the others" where the table says so: then the bounds must reach it.
    low, high = min(row.edge_low, row.edge_value), max(row.edge_high, row.edge_value)
    meaning = f'{row.meaning} [{row.source}]'
    return Setting(name, float(row.edge_value), meaning, low, high, row.edge_unit, read_only=name in _GEOMETRY)


MUSCLE = tuple(_of_the_muscle(name, row) for name, row in muscle.SPECIFICATIONS.items())
EFFECTS = Setting('effects', (), "physics beside the paper's model: " + ', '.join(muscle.EFFECTS), read_only=True)
KNOWN = {setting.name: setting for setting in (EFFECTS, *MUSCLE, *SHARED, *SIM_NODE, *CONTROLLER_NODE)}


@dataclass
class Settings(Mapping[str, Any]):
    """The values in force: a mapping by name, kept up to date when a parameter is set.

    ``check`` is handed the values as they would be and raises BadInput against a combination that makes no
    sense; ``apply`` is called with the new values once they are in force. Temperatures stay in degC here.
    """

    in_force: dict[str, Value] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Any:
        return self.in_force[name]

    def __iter__(self) -> Any:
        return iter(self.in_force)

    def __len__(self) -> int:
        return len(self.in_force)

    def kelvin(self, name: str) -> float:
        """A temperature for the model."""
        return float(self.in_force[name]) + ZERO_CELSIUS  # type: ignore[arg-type]

    def muscle(self) -> Parameters:
        """The muscle that these values describe.

        Raises:
            BadInput: an unknown effect or a value outside its bounds.
        """
        given = {
            name: row.from_edge(self.in_force[name])  # type: ignore[arg-type]
            for name, row in muscle.SPECIFICATIONS.items()
            if name in self.in_force
        }
        return Parameters(given).with_effects(*self.in_force['effects'])  # type: ignore[misc]

    def limits(self, *, command_timeout: float, longest_step: float) -> Limits:
        """The safety limits that these values describe."""
        return Limits(
            current=self['current_limit_a'],
            slew=self['slew_limit_a_per_s'],
            command_timeout=command_timeout,
            derate_temperature=self.kelvin('derate_temperature_c'),
            max_temperature=self.kelvin('max_temperature_c'),
            longest_step=longest_step,
        )


def read(overrides: Mapping[str, object], own: Iterable[Setting]) -> Settings:
    """The node's values: defaults, and over them what files and the command line say.

    A name of the package's other node is accepted and left alone, so that one file serves both; the
    parameters of effects that are off likewise.

    Raises:
        BadInput: an unknown name (with the nearest known one), or a value that its setting refuses.
    """
    for name in overrides:
        if name not in KNOWN and name not in _OURS_TOO and not name.startswith('qos_overrides.'):
            raise BadInput(f"unknown parameter '{name}'{nearest(name, KNOWN)}")
    for name in overrides:
        if name in KNOWN:
            KNOWN[name].read(overrides[name])  # also what is the other node's: a mistake is one wherever it stands
    effects = EFFECTS.read(overrides.get('effects', ()))
    values: dict[str, Value] = {'effects': effects}
    for setting in (*MUSCLE, *own):
        effect, dot, _ = setting.name.partition('.')
        if dot and effect not in effects:  # type: ignore[operator]
            continue
        default = values[setting.like] if setting.like else setting.default
        values[setting.name] = setting.read(overrides.get(setting.name, default))
    return Settings(values)


def declare(
    node: Node,
    own: Iterable[Setting],
    check: Callable[[Settings], None],
    apply: Callable[[Settings], None],
) -> Settings:
    """Declare the muscle's parameters and the node's ``own`` on the node; say which values are in force.

    Raises:
        BadInput: as ``read`` does, or from ``check``.
    """
    # rclpy keeps what came by file and command line here; it has no public way to list what was not declared.
    overrides = {name: given.value for name, given in node._parameter_overrides.items()}
    settings = read(overrides, (*SHARED, *own))
    check(settings)
    for name, value in settings.items():
        plain = list(value) if isinstance(value, tuple) else value
        node.declare_parameter(name, plain, KNOWN[name].descriptor(), ignore_override=True)

    def candidate(changes: Iterable[RosParameter]) -> Settings:
        values = dict(settings.in_force)
        for change in changes:
            if change.name in values:
                values[change.name] = KNOWN[change.name].read(change.value)
        return Settings(values)

    def may_be_set(changes: list[RosParameter]) -> SetParametersResult:
        try:
            check(candidate(changes))
        except BadInput as problem:
            return SetParametersResult(successful=False, reason=str(problem))
        return SetParametersResult(successful=True)

    def was_set(changes: list[RosParameter]) -> None:
        settings.in_force = candidate(changes).in_force
        apply(settings)

    node.add_on_set_parameters_callback(may_be_set)
    node.add_post_set_parameters_callback(was_set)
    node.get_logger().info('parameters: ' + ', '.join(f'{name}={_plain(value)}' for name, value in settings.items()))
    return settings


def _plain(value: Value) -> str:
    if isinstance(value, tuple):
        return '[' + ', '.join(value) + ']'
    return f'{value:g}' if isinstance(value, float) else str(value)

"""A plan's values as ROS parameters: declared, logged, and changed while the node runs."""

from collections.abc import Callable, Iterable

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle import EFFECTS
from tcp_muscle_ros.nodes.parameters import KNOWN, Settings, descriptor, of_rclpy
from tcp_muscle_ros.nodes.plan import Plan, naming, read_plan
from tcp_muscle_ros.settings.operating import JOINTS, MUSCLES, SIM, shown
from tcp_muscle_ros.settings.parameter_file import idle

_CLOCK = 'use_sim_time'
_DOUBLE = RosParameter.Type.DOUBLE
_WORDS = {
    RosParameter.Type.BOOL: 'true or false',
    RosParameter.Type.INTEGER: 'a whole number',
    RosParameter.Type.DOUBLE: 'a number',
    RosParameter.Type.STRING: 'a text',
}
_EFFECTS = "physics beside the paper's model: " + ', '.join(EFFECTS)


class DeclaredNode(Node):  # type: ignore[misc]
    """A node that takes a change of its parameters as it takes them at its start, and refuses one in the same words.

    rclpy names no parameter that it does not know, and refuses 1 where 1.0 is meant.
    """

    def set_parameters_atomically(self, parameter_list: list[RosParameter]) -> SetParametersResult:
        """What rclpy calls for every request; the reason against one is one line."""
        try:
            wanted = [self._as_declared(parameter) for parameter in parameter_list]
        except BadInput as problem:
            return SetParametersResult(successful=False, reason=str(problem))
        return super().set_parameters_atomically(wanted)

    def _as_declared(self, parameter: RosParameter) -> RosParameter:
        """The parameter, in the type in which it was declared."""
        name, value = parameter.name, parameter.value
        if not self.has_parameter(name):
            raise BadInput(self._why_unknown(name))
        declared = self.describe_parameter(name)
        if of_rclpy(name):
            return parameter
        if declared.read_only:
            now = self.get_parameter(name).value
            raise BadInput(
                f"parameter '{name}' is {shown(now)} as long as the node runs; set another at the start: "
                f'--ros-args -p {name}:=...'
            )
        kind = RosParameter.Type(declared.type)
        if kind is parameter.type_:
            return parameter
        if kind is _DOUBLE and parameter.type_ is RosParameter.Type.INTEGER:
            return RosParameter(name, kind, float(value))
        if kind is RosParameter.Type.DOUBLE_ARRAY and parameter.type_ is RosParameter.Type.INTEGER_ARRAY:
            return RosParameter(name, kind, [float(number) for number in value])
        expected = _WORDS.get(kind, 'numbers')
        raise BadInput(f"parameter '{name}' is {shown(value)}; expected {expected} ({declared.description})")

    def _why_unknown(self, name: str) -> str:
        """Why there is no parameter of this name: a slip, or one of an effect that is off."""
        effect = next(
            (edge.partition('.')[0] for edge in KNOWN if '.' in edge and f'.{name}'.endswith(f'.{edge}')), None
        )
        if effect is not None:
            at_the_start = f'effects are switched on at the start: --ros-args -p effects:=[{effect}]'
            return f"parameter '{name}' is of an effect that is off; {at_the_start}"
        return f"unknown parameter '{name}'{nearest(name, self.list_parameters([], 0).names)}"


def declare(node: Node, owner: str, check: Callable[[Settings], None], apply: Callable[[str, Settings], None]) -> Plan:
    """Declare a node's parameters, and say in the log which values are in force.

    Of several muscles each has its parameters under its name (``thumb.hA``); what holds for the node stands without.

    Args:
        node: the node, without parameters of its own.
        owner: its name in the tables.
        check: raises BadInput against a muscle's values that do not go together; also asked before a later change.
        apply: takes over values of a muscle or joint, by its name, that were changed later.

    Raises:
        BadInput: as ``read_plan``, or from ``check``.
    """
    # What came by file and command line; rclpy has no public way to list what has not been declared.
    given = {name: parameter.value for name, parameter in node._parameter_overrides.items()}
    plan = read_plan(given, owner, node.get_namespace())
    for name, settings in plan.muscles.items():
        with naming(name):
            check(settings)
    for name, listed in ((MUSCLES, plan.muscles), (JOINTS, plan.joints)):
        names = ParameterDescriptor(name=name, description=f'{name} of this node, by name', read_only=True)
        node.declare_parameter(name, list(listed) or [''], names, ignore_override=True)
    if plan.many:
        _declare(node, '', plan.shared, [name for name in plan.shared if name in KNOWN and KNOWN[name].per_node])
    for name, settings in (*plan.muscles.items(), *plan.joints.items()):
        _declare(node, f'{name}.' if name else '', settings, settings)
    _say(node, plan)
    if owner == SIM:
        _warn_of_idle(node, plan, given)
    changes = _Changes(node, plan, check, apply)
    node.add_on_set_parameters_callback(changes.may_be_made)
    node.add_post_set_parameters_callback(changes.were_made)
    return plan


class _Changes:
    """Of parameters, while the node runs: refused where they do not go together, else handed on."""

    def __init__(
        self, node: Node, plan: Plan, check: Callable[[Settings], None], apply: Callable[[str, Settings], None]
    ) -> None:
        self._node, self._plan, self._check, self._apply = node, plan, check, apply
        self._in_force = {**plan.muscles, **plan.joints}

    def _made_of(self, parameters: list[RosParameter]) -> dict[str, Settings]:
        """The values then of each muscle and joint that they concern."""
        new: dict[str, dict[str, object]] = {}
        for parameter in parameters:
            if of_rclpy(parameter.name):
                continue
            name, _, rest = parameter.name.partition('.') if self._plan.many else ('', '', parameter.name)
            new.setdefault(name, {})[rest] = parameter.value
        in_force = self._in_force
        return {name: in_force[name].changed(values) for name, values in new.items() if name in in_force}

    def may_be_made(self, parameters: list[RosParameter]) -> SetParametersResult:
        """rclpy asks before; a reason against them is one line."""
        try:
            _refuse_another_clock(self._node, parameters)
            for name, settings in self._made_of(parameters).items():
                if name in self._plan.muscles:
                    with naming(name):
                        self._check(settings)
        except BadInput as problem:
            return SetParametersResult(successful=False, reason=str(problem))
        return SetParametersResult(successful=True)

    def were_made(self, parameters: list[RosParameter]) -> None:
        """rclpy says so afterwards; what was set stands in the log."""
        for name, settings in self._made_of(parameters).items():
            before = self._in_force[name]
            for key in (key for key in settings if settings[key] != before[key]):
                told = f"parameter '{f'{name}.' if name else ''}{key}' is {shown(settings[key])} now"
                self._node.get_logger().info(f'{told}, was {shown(before[key])}')
            self._in_force[name] = settings
            self._apply(name, settings)


def _refuse_another_clock(node: Node, parameters: Iterable[RosParameter]) -> None:
    """The ticks keep to the clock that they began with; rclpy would change that of the stamps alone."""
    now = node.get_parameter(_CLOCK).value
    if any(parameter.name == _CLOCK and parameter.value != now for parameter in parameters):
        raise BadInput(
            f"parameter '{_CLOCK}' is {str(now).lower()} as long as the node runs; set another at the start: "
            f'--ros-args -p {_CLOCK}:={str(not now).lower()}'
        )


def _declare(node: Node, prefix: str, settings: Settings, names: Iterable[str]) -> None:
    for name in names:
        if name == 'effects':
            effects = ParameterDescriptor(name=f'{prefix}effects', description=_EFFECTS, read_only=True)
            node.declare_parameter(f'{prefix}effects', list(settings[name]) or [''], effects, ignore_override=True)
        elif not (prefix and name in KNOWN and KNOWN[name].per_node):
            described = descriptor(settings.rows[name])
            described.name = prefix + name
            node.declare_parameter(prefix + name, settings[name], described, ignore_override=True)


def _say(node: Node, plan: Plan) -> None:
    say = node.get_logger().info
    say('parameters: ' + _listed(plan.shared, plan.shared))
    if plan.many:
        for name, settings in plan.muscles.items():
            own = [key for key, value in settings.items() if key not in plan.shared or value != plan.shared[key]]
            say(f'{name}: ' + _listed(settings, own))
    for name, settings in plan.joints.items():
        say(f'{name}: ' + _listed(settings, settings))


def _warn_of_idle(node: Node, plan: Plan, given: Iterable[str]) -> None:
    """A line for each effect that was given parameters and is not on: of all muscles, or of one by its name."""
    on = {name: settings['effects'] for name, settings in plan.muscles.items()}
    told = idle(given, list(dict.fromkeys(effect for effects in on.values() for effect in effects)))
    for name, effects in on.items() if plan.many else ():
        own = [key.removeprefix(f'{name}.') for key in given if key.startswith(f'{name}.')]
        told += [f'{name}: {sentence}' for sentence in idle(own, effects)]
    for sentence in told:
        node.get_logger().warning(sentence)


def _listed(settings: Settings, names: Iterable[str]) -> str:
    return ', '.join(f'{name}={_plain(settings[name])}' for name in names)


def _plain(value: object) -> str:
    if isinstance(value, tuple):
        return '[' + ', '.join(_plain(item) for item in value) + ']'
    return f'{value:g}' if isinstance(value, float) else str(value)

"""A controlled joint between two muscles: an angle and a co-contraction or a stiffness in, two setpoints out."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from std_msgs.msg import Float64

from tcp_muscle_ros.control.antagonist import FREE, Antagonist, Hold, Side
from tcp_muscle_ros.control.gravity import Gravity
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.nodes.controlled_muscle import ControlledMuscle
from tcp_muscle_ros.nodes.controllers import other_model
from tcp_muscle_ros.nodes.home import Home
from tcp_muscle_ros.nodes.parameters import Settings
from tcp_muscle_ros.nodes.safe_muscle import number
from tcp_muscle_ros.nodes.topics import COMMAND_QOS, MEASUREMENT_QOS
from tcp_muscle_ros.settings.operating import JOINT

_STIFFEST = 1000.0  # N m/rad, that may be asked for
_MISSED = 0.01  # rad from its setpoint, with a muscle at its limit
_PATIENCE = 10.0  # s; from cold, a muscle is at its limit for nearly as long on its way to an angle that it reaches


def _side(settings: Settings) -> Side:
    return Side(
        model=other_model(settings) or settings.muscle(),  # by which its controller aims too
        mounted_load=settings['load_n'],
        current_limit=settings['current_limit_a'],
        temperature_limit=settings.kelvin('derate_temperature_c'),
    )


class ControlledJoint:
    """Hears ``<name>/angle``, ``<name>/angle_setpoint`` (rad) and ``<name>/cocontraction_setpoint`` (N, both tensions'
    mean) or ``<name>/stiffness_setpoint`` (N m/rad), of which the later counts; each is held until the next. Where a
    muscle is stopped by a fault or disabled, here or where its current is applied, so is the other.
    """

    def __init__(
        self,
        node: Home,
        name: str,
        settings: Settings,
        agonist: ControlledMuscle,
        antagonist: ControlledMuscle,
    ) -> None:
        self._node, self.name = node, name
        self._pair = agonist, antagonist
        self.setpoint: float | None = None  # rad
        self.angle: float | None = None  # rad, measured
        self._idle = 'no setpoint yet'  # why its muscles are told nothing; '' while they are
        self._short = ''  # said of a setpoint that is not reached
        self._short_since: float | None = None
        self._settings = settings
        self._cocontraction: float = settings['cocontraction_n']
        self._stiffness: float | None = None
        self.apply(settings)
        # What is still to be compiled is compiled before the first tick.
        self._control.update(0.0, 0.0, 0.0, (0.0, 0.0), (agonist.ambient, antagonist.ambient), stiffness=0.0)
        self._control.reset()
        for muscle in self._pair:
            muscle.feedback_topic = node.resolve_topic_name(f'{name}/angle')
        node.listen(Float64, f'{name}/angle', self._take_angle, MEASUREMENT_QOS)
        node.listen(Float64, f'{name}/angle_setpoint', self._take_setpoint, COMMAND_QOS)
        node.listen(Float64, f'{name}/cocontraction_setpoint', self._take_cocontraction, COMMAND_QOS)
        node.listen(Float64, f'{name}/stiffness_setpoint', self._take_stiffness, COMMAND_QOS)

    def apply(self, settings: Settings) -> None:
        """Take over values, of it or its muscles; what came by topic stays, unless ``cocontraction_n`` changed."""
        if settings['cocontraction_n'] != self._settings['cocontraction_n']:
            self._cocontraction, self._stiffness = settings['cocontraction_n'], None
        self._settings = settings
        agonist, antagonist = self._pair
        self._control = Antagonist(
            _side(agonist.settings),
            _side(antagonist.settings),
            radius=settings['radius_m'],
            period=self._node.period,
            filter_time=settings['torque_filter_s'],
        )

    def renew(self) -> None:
        """One of its muscles has other values."""
        self.apply(self._settings)

    def turns(self, muscle: ControlledMuscle) -> bool:
        """Whether it is one of the two."""
        return muscle in self._pair

    def forget(self) -> None:
        """~/reset: no setpoint, nothing measured."""
        self.setpoint = None
        self._cocontraction, self._stiffness = self._settings['cocontraction_n'], None
        self._control.reset()

    # What comes in

    def _within(self, name: str, value: float, low: float, high: float, unit: str) -> bool:
        """Whether it is within the bounds; if not, it is counted with the agonist."""
        return self._pair[0].within(f'{self.name}/{name}', value, low, high, unit)

    def _take_setpoint(self, message: Float64) -> None:
        self.go_to(message.data, f'{self.name}/angle_setpoint')

    def go_to(self, value: float, name: str) -> None:
        """Where it is to be, rad, by the input of that name; what is refused is counted with the agonist."""
        if self._pair[0].within(name, value, self._settings['low_rad'], self._settings['high_rad'], 'rad'):
            self.setpoint = value

    def _take_cocontraction(self, message: Float64) -> None:
        row = JOINT['cocontraction_n']
        if self._within('cocontraction_setpoint', message.data, row.low, row.high, row.unit):
            self._cocontraction, self._stiffness = message.data, None

    def _take_stiffness(self, message: Float64) -> None:
        if self._within('stiffness_setpoint', message.data, 0.0, _STIFFEST, 'N m/rad'):
            self._stiffness = message.data

    def _take_angle(self, message: Float64) -> None:
        if isfinite(message.data):
            self.angle = message.data
        turned = self._settings['radius_m'] * message.data
        for muscle, sign in zip(self._pair, (1.0, -1.0), strict=True):
            muscle.take_measurement(sign * turned)

    # One tick

    def work(self, now: float, hold: Hold = FREE) -> None:
        """Say to both muscles how warm to be, if their tensions and the angle are known.

        ``hold``: what is known to pull at the joint.
        """
        self._find_shortfall(now)
        agonist, antagonist = self._pair
        agonist.partner_stopped, antagonist.partner_stopped = antagonist.stopped, agonist.stopped
        agonist.partner_refuses, antagonist.partner_refuses = antagonist.refuses, agonist.refuses
        one, two = agonist.tension(now), antagonist.tension(now)
        if self.setpoint is None or self.angle is None:
            self._idle = 'no setpoint yet' if self.setpoint is None else 'no angle yet'
            self._control.reset()
            return
        if one is None or two is None or agonist.silent or antagonist.silent:
            self._idle = agonist.refuses or antagonist.refuses or 'a muscle is stopped or not measured'
            self._control.reset()
            return
        self._idle = ''
        wanted = self._control.update(
            self.setpoint,
            self._cocontraction,
            self.angle,
            (one, two),
            (agonist.ambient, antagonist.ambient),
            stiffness=self._stiffness,
            hold=hold,
        )
        for muscle, temperature in zip(self._pair, wanted, strict=True):
            muscle.aim(temperature)

    def _limiting(self) -> str:
        """Which muscle can pull no harder while the setpoint is not reached; '' where none is asked to."""
        if self.setpoint is None or self.angle is None or abs(self.setpoint - self.angle) <= _MISSED:
            return ''
        muscle = self._pair[self.setpoint < self.angle]  # the one that turns it towards the setpoint
        return f'{muscle.name} {muscle.at_limit}' if muscle.at_limit else ''

    def _find_shortfall(self, now: float) -> None:
        limiting = self._limiting()
        if not limiting:
            self._short_since = None
        elif self._short_since is None:
            self._short_since = now
        patient = self._short_since is None or now - self._short_since < _PATIENCE
        self._short = (
            '' if patient else f'setpoint {self.setpoint:.4g} rad is not reached: {self.angle:.4g} rad, {limiting}'
        )

    # Diagnostics

    def status(self) -> DiagnosticStatus:
        """What /diagnostics says of it."""
        driven = not self._idle
        facts = {
            'angle_rad': self.angle,
            'setpoint_rad': self.setpoint,
            'cocontraction_n': self._control.cocontraction if driven else None,
            'stiffness_n_m_per_rad': self._control.stiffness if driven else None,
        }
        return DiagnosticStatus(
            level=DiagnosticStatus.OK if driven and not self._short else DiagnosticStatus.WARN,
            name=f'{self._node.get_fully_qualified_name()}/{self.name}',
            message=self._idle or self._short or 'driven',
            hardware_id=self.name,
            values=[KeyValue(key=key, value=number(value)) for key, value in facts.items()],
        )


class Weight:
    """What gravity asks of a node's joints, by the description of the robot that they turn, which stands upright.

    Args:
        file: a URDF; empty: nothing is known to pull.
        joints: the node's.

    Raises:
        BadInput: a file that cannot be read or describes no such robot.
    """

    def __init__(self, file: str, joints: Iterable[ControlledJoint]) -> None:
        self._joints = list(joints)
        self._gravity: Gravity | None = None
        if not file:
            return
        if not self._joints:
            raise BadInput("parameter 'description_file' needs 'joints': the weight of a robot is held by them")
        try:
            text = Path(file).read_text(encoding='utf-8')
        except (OSError, UnicodeDecodeError) as problem:
            reason = getattr(problem, 'strerror', None) or 'no text'
            raise BadInput(f"parameter 'description_file': cannot read {file}: {reason}") from None
        self._gravity = Gravity(text)
        self._gravity.torques({joint.name: 0.0 for joint in self._joints})  # it has all of them

    def holds(self) -> list[Hold]:
        """One a joint, here and where it is to be, the others being where they are; nothing until all angles came."""
        angles = {joint.name: joint.angle for joint in self._joints if joint.angle is not None}
        if self._gravity is None or len(angles) < len(self._joints):
            return [FREE] * len(self._joints)
        here = self._gravity.torques(angles)
        found = []
        for joint in self._joints:
            there = here if joint.setpoint is None else self._gravity.torques(angles | {joint.name: joint.setpoint})
            found.append(Hold(here[joint.name], there[joint.name]))
        return found

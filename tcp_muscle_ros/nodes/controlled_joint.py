"""A controlled joint between two controlled muscles: an angle and a co-contraction in, two setpoints out."""

from __future__ import annotations

from math import isfinite

from std_msgs.msg import Float64

from tcp_muscle_ros.control.antagonist import Antagonist, Side
from tcp_muscle_ros.nodes.controlled_muscle import ControlledMuscle
from tcp_muscle_ros.nodes.home import Home
from tcp_muscle_ros.nodes.parameters import Settings
from tcp_muscle_ros.nodes.topics import COMMAND_QOS, MEASUREMENT_QOS
from tcp_muscle_ros.settings.operating import JOINT


def _side(settings: Settings) -> Side:
    return Side(
        model=settings.muscle(),
        mounted_load=settings['load_n'],
        current_limit=settings['current_limit_a'],
        temperature_limit=settings.kelvin('derate_temperature_c'),
    )


class ControlledJoint:
    """Hears ``<name>/angle``, ``<name>/angle_setpoint`` (rad) and ``<name>/cocontraction_setpoint`` (N, both tensions'
    mean); each is held until the next. Where a muscle is stopped by a fault or disabled, so is the other.
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
        self._setpoint: float | None = None
        self._angle: float | None = None
        self.apply(settings)
        # What is still to be compiled is compiled before the first tick.
        self._control.update(0.0, 0.0, 0.0, (0.0, 0.0), (agonist.ambient, antagonist.ambient))
        self._control.reset()
        for muscle in self._pair:
            muscle.feedback_topic = node.resolve_topic_name(f'{name}/angle')
        node.listen(Float64, f'{name}/angle', self._take_angle, MEASUREMENT_QOS)
        node.listen(Float64, f'{name}/angle_setpoint', self.take_setpoint, COMMAND_QOS)
        node.listen(Float64, f'{name}/cocontraction_setpoint', self._take_cocontraction, COMMAND_QOS)

    def apply(self, settings: Settings) -> None:
        """Take over values, of the joint or of its muscles."""
        self._settings = settings
        self._cocontraction: float = settings['cocontraction_n']
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
        cocontraction = self._cocontraction
        self.apply(self._settings)
        self._cocontraction = cocontraction

    def turns(self, muscle: ControlledMuscle) -> bool:
        """Whether it is one of the two."""
        return muscle in self._pair

    def forget(self) -> None:
        """~/reset: no setpoint, nothing measured."""
        self._setpoint = None
        self._cocontraction = self._settings['cocontraction_n']
        self._control.reset()

    # What comes in

    def _within(self, name: str, value: float, low: float, high: float, unit: str) -> bool:
        """Whether it is within the bounds; if not, it is counted with the agonist."""
        return self._pair[0].within(f'{self.name}/{name}', value, low, high, unit)

    def take_setpoint(self, message: Float64) -> None:
        """Where it is to be, rad."""
        if self._within('angle_setpoint', message.data, self._settings['low_rad'], self._settings['high_rad'], 'rad'):
            self._setpoint = message.data

    def _take_cocontraction(self, message: Float64) -> None:
        row = JOINT['cocontraction_n']
        if self._within('cocontraction_setpoint', message.data, row.low, row.high, row.unit):
            self._cocontraction = message.data

    def _take_angle(self, message: Float64) -> None:
        if isfinite(message.data):
            self._angle = message.data
        turned = self._settings['radius_m'] * message.data
        for muscle, sign in zip(self._pair, (1.0, -1.0), strict=True):
            muscle.take_measurement(sign * turned)

    # One tick

    def work(self, now: float) -> None:
        """Say to both muscles how warm to be, if their tensions and the angle are known."""
        agonist, antagonist = self._pair
        agonist.partner_stopped, antagonist.partner_stopped = antagonist.stopped, agonist.stopped
        one, two = agonist.tension(now), antagonist.tension(now)
        lost = agonist.silent or antagonist.silent
        if self._setpoint is None or self._angle is None or one is None or two is None or lost:
            self._control.reset()
            return
        wanted = self._control.update(
            self._setpoint, self._cocontraction, self._angle, (one, two), (agonist.ambient, antagonist.ambient)
        )
        for muscle, temperature in zip(self._pair, wanted, strict=True):
            muscle.aim(temperature)

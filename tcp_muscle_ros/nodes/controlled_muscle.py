"""One controlled muscle: the tracking controller behind its topics, for the simulated muscle or a real one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from tcp_muscle_ros.control.inverse import Inverse
from tcp_muscle_ros.control.safety import Limits, State
from tcp_muscle_ros.control.tracking import Command
from tcp_muscle_ros.control.watches import ASKED, THERMOMETER, CurrentWatch, FeedbackWatch, Latest
from tcp_muscle_ros.muscle import ZERO_CELSIUS
from tcp_muscle_ros.muscle.family import not_stated
from tcp_muscle_ros.nodes.controllers import make_controller, make_handover, other_model
from tcp_muscle_ros.nodes.home import ControlHome
from tcp_muscle_ros.nodes.mixing import Mixing
from tcp_muscle_ros.nodes.parameters import Settings
from tcp_muscle_ros.nodes.safe_muscle import SafeMuscle, number
from tcp_muscle_ros.nodes.topics import COMMAND_QOS, MEASUREMENT_QOS

# Steps of a sensor that is not said to have any: movement below five of them proves nothing.
_FINE = {'displacement': 2e-5, 'resistance': 2e-3}  # m, ohm: 20 um of movement, or what it changes the resistance by
_RELEASED = 1e-3  # m, by which a muscle that is let go may stay above its setpoint in a room that is a little warmer
_UNIT = {'displacement': 'm', 'resistance': 'ohm'}
_CELL = 0.1  # N, by which the zero of a load cell may lie below 0
_HOTTEST_READING = 1000.0  # degC; more is a broken thermometer rather than a hot muscle


class ControlledMuscle(SafeMuscle):
    """Once a tick: is the feedback alive, which current, may it flow.

    The last setpoint is held for as long as no other comes: a muscle that lets go because a commander fell silent may
    drop what it holds. Without live feedback the current is 0 (or ``probe_current_a``) and what the controller had
    learnt is forgotten; it begins again where the muscle then is.

    ``on_joint``: a joint says how long it is and how warm it is to be, and its load is the tension that it shows. A
    current that its receiver does not take stops the joint; a small one is asked for meanwhile, to see when it does.
    """

    node: ControlHome

    def __init__(self, node: ControlHome, name: str, settings: Settings, on_joint: bool) -> None:
        super().__init__(node, name, settings)
        self.on_joint = on_joint
        self._feedback: str = 'displacement' if on_joint else settings['feedback']
        self.feedback_topic = node.resolve_topic_name(self.topic(self._feedback))
        self._setpoint: float | None = None  # m
        self._let_go: float | None = None  # m: sent while in a fault, it asks for no current until another comes
        self._measured_anew = False
        self._ambient: float | None = None  # K
        self._load: float | None = None  # N
        self._temperature, self._current, self._tension = (Latest() for _ in range(3))
        self.partner_stopped = ''  # why the other muscle of the joint pulls no more
        self.partner_refuses = ''  # the same, but it is asked
        self._taking = CurrentWatch()
        self._command: Command | None = None
        self._fibre: float | None = None  # K, by the model from what has flowed; None before the first command
        self._lost = 'no feedback yet'
        self._mixing = Mixing()
        self._mixed: Sequence[str] = ()
        self._controller = make_handover(settings)
        self._watch = FeedbackWatch('angle' if on_joint else self._feedback, 0.0, 0.0)
        self._apply_watch()
        self._warn_of_resistance()

        self._current_command = self.publisher('current_command', COMMAND_QOS)
        self._shaped = self.publisher('shaped_setpoint')
        if on_joint:
            self.listen(Float64, 'force', self._take_force, MEASUREMENT_QOS)
        else:
            self.listen(Float64, 'displacement_setpoint', self.take_setpoint)
            self.listen(Float64, self._feedback, self._take_feedback, MEASUREMENT_QOS)
            self.listen(Float64, 'load', self._take_load, MEASUREMENT_QOS)
        self.listen(Float64, 'current', self._take_current, MEASUREMENT_QOS)
        self.listen(Temperature, 'temperature', self._take_temperature, MEASUREMENT_QOS)
        self.listen(Temperature, 'ambient_temperature', self._take_ambient, MEASUREMENT_QOS)

    # Parameters

    def limits_of(self, settings: Settings) -> Limits:
        """The safety limits. The node commands itself every tick: there is no commander to watch."""
        return settings.limits(command_timeout=0.0)

    def change(self, settings: Settings) -> None:
        """Another model alone takes over without a step in the current."""
        if self.on_joint or {**self.settings, 'model_file': settings['model_file']} != dict(settings):
            super().change(settings)
            return
        self.settings = settings
        model = other_model(settings)
        self._controller.adopt(None if model is None else make_controller(settings, model))
        self._watch.expect_anew()  # what is expected is another model's now
        self._apply_watch()

    def apply(self, settings: Settings) -> None:
        """A new controller; it begins where the muscle is."""
        self._begin_anew()
        self._apply_watch()
        self.node.renew(self)

    def _apply_watch(self) -> None:
        settings = self.settings
        quantum = settings[f'{self._feedback}_quantum_{_UNIT[self._feedback]}']
        self._watch.timeout = settings['feedback_timeout_s'] or max(3.0 * self.node.period, 0.2)
        self._watch.quantum = max(quantum, _FINE[self._feedback])
        self._model = other_model(settings) or settings.muscle()
        self._inverse = Inverse(self._model, settings['load_n'])

    def _warn_of_resistance(self) -> None:
        source = not_stated('R0', self._model)
        if source:
            self.node.get_logger().warning(
                f"{self.said}R0 = {self._model['R0']:g} ohm is that of the paper's muscle: the source of {source} "
                f'states none, so nobody knows how warm a current makes it; measure R0'
            )

    # What comes in

    def take_setpoint(self, message: Float64) -> None:
        """Where it is to be, m."""
        self.go_to(message.data, 'displacement_setpoint')

    def go_to(self, value: float, name: str) -> None:
        """Where it is to be, m, by the input of that name; of 0 or below while in a fault, it lets go.

        In a room colder than T0 the muscle needs a current to be at 0: that would never clear a fault. Nor may it flow
        once the fault is cleared, though the same setpoint comes again and again.
        """
        # Nothing moves by more than its own fibre: a larger number is a wrong unit.
        length = self._model['L0']
        furthest = self._inverse.furthest(self.settings['load_n'] if self._load is None else self._load)
        most = length if furthest is None else min(length, furthest)
        if not self.within(name, value, -length, most, 'm'):
            return
        with self.node.lock:
            if self.safety.state is State.FAULT and value <= 0.0:
                self._stop_asking()
                self._let_go = value
            elif value != self._let_go:
                self._setpoint, self._let_go = value, None

    def _take_feedback(self, message: Float64) -> None:
        self.take_measurement(message.data)

    def take_measurement(self, value: float) -> None:
        """What it measures, m or ohm."""
        with self.node.lock:
            if self._watch.receive(value, self.node.seconds()):
                self._measured_anew = True
            else:
                self.refused_inputs[self._watch.name] += 1

    def _take_force(self, message: Float64) -> None:
        # A muscle cannot push: a little below 0 is a slack one and the zero of its cell, more one the wrong way round.
        force = 0.0 if -_CELL <= message.data < 0.0 else message.data
        if self.accept('force', force, like='load_n'):
            self._load = force
            self._tension.take(force, self.node.seconds())

    def _take_current(self, message: Float64) -> None:
        # Either way round it heats: -1 mA of an ammeter's zero is next to nothing like 1 mA, and what flows through one
        # that is connected the other way is not to be taken for no current, and the muscle for a cold one.
        if self.accept('current', abs(message.data), like='current_limit_a'):
            self._current.take(abs(message.data), self.node.seconds())

    def _take_temperature(self, message: Temperature) -> None:
        if self.within('temperature', message.temperature, -ZERO_CELSIUS, _HOTTEST_READING, 'degC'):
            self._temperature.take(message.temperature + ZERO_CELSIUS, self.node.seconds())

    def _take_load(self, message: Float64) -> None:
        if self.accept('load', message.data, like='load_n'):
            self._load = message.data

    def _take_ambient(self, message: Temperature) -> None:
        if self.accept('ambient_temperature', message.temperature, like='ambient_temperature_c'):
            self._ambient = message.temperature + ZERO_CELSIUS

    # What a joint asks and says

    def tension(self, now: float) -> float | None:
        """N, measured; None where it is not known."""
        return self._tension.fresh(now, self._watch.timeout)

    @property
    def ambient(self) -> float:
        """K."""
        return self.settings.kelvin('ambient_temperature_c') if self._ambient is None else self._ambient

    @property
    def silent(self) -> bool:
        """Whether its feedback was lost at the last tick."""
        return bool(self._lost)

    @property
    def stopped(self) -> str:
        """Why it cannot pull until somebody does something about it; '' where it can."""
        state = self.safety.state
        return f'{self.name} is stopped: {state.value}' if state in (State.FAULT, State.DISABLED) else ''

    @property
    def refuses(self) -> str:
        """Why its receiver lets nothing flow of what is asked for; '' where it does."""
        return f'{self.name} does not take its current: disabled or in fault' if self._taking.untaken else ''

    @property
    def at_limit(self) -> str:
        """Which limit keeps it from pulling harder; '' where none does."""
        command, most = self._command, self.settings['current_limit_a']
        if self.silent or command is None or command.current < 0.99 * min(most, command.highest_current):
            return ''
        return 'at its current limit' if most <= command.highest_current else 'at its temperature limit'

    def aim(self, temperature: float) -> None:
        """Be so warm (K) under the tension that it has: as a displacement, which is what the controller takes."""
        if self._load is not None:
            self._setpoint = self._inverse.displacement(temperature, self._load)

    def forget(self) -> str:
        """~/reset: no setpoint and no current, nothing learnt."""
        self._stop_asking()
        self._begin_anew()
        return 'reset: waiting for a setpoint'

    def _stop_asking(self) -> None:
        """No setpoint and no current."""
        self._setpoint = self._let_go = self._command = None
        self._watch.expect_anew()
        self.safety.command(0.0, self.node.seconds())

    def _begin_anew(self) -> None:
        """Another controller: nothing learnt, but the muscle is as hot as it was."""
        self._controller = make_handover(self.settings)
        if self._fibre is not None:
            self._controller.carry(self._fibre)
        self._command = None
        self._watch.expect_anew()

    def look_for_others(self, node: Node) -> None:
        """Also for a second node that publishes what the muscle is measured by."""
        super().look_for_others(node)
        names = ('current', 'temperature', *(('force',) if self.on_joint else ()))
        topics = [self.feedback_topic, *(node.resolve_topic_name(self.topic(name)) for name in names)]
        self._mixed = self._mixing.look(node, topics, node.get_logger().warning)

    # One tick

    def work(self, dt: float, now: float, publish: bool) -> None:
        """Ask the controller, then the safety machine, and publish what remains."""
        temperature = self._temperature.fresh(now, max(self._watch.timeout, THERMOMETER))
        self._taking.update(now, self.safety.current, self._current.fresh(now, self._watch.timeout))
        lost, self._lost = self._lost, self._problem(now)
        if lost and not self._lost:
            self._watch.expect_anew()  # what is expected begins where the muscle then is
        if self._watch.value is not None and (self._setpoint is not None or self._fibre is not None):
            self._decide(now, temperature)
        elif self._probe() > 0.0:
            self.safety.command(self._probe(), now)
        silent = '' if self._setpoint is None or self._probe() > 0.0 else self._lost
        current = self.safety.update(now, dt, temperatures=(temperature, self._fibre), silent=silent)
        if publish:
            self._publish(current)

    def _decide(self, now: float, temperature: float | None) -> None:
        """Ask the controller. Without a setpoint it only says how hot the muscle is by what has flowed."""
        command = self._controller.update(
            0.0 if self._setpoint is None else self._setpoint,
            temperature=temperature,
            load=self._load,
            ambient=self._ambient,
            applied_current=self._flowing(now),
            **self._measurement(),
        )
        self._fibre = command.predicted_temperature
        if self._lost or self._setpoint is None or not self.safety.state.lets_flow:
            self._controller.reset()  # nobody sees what the muscle does meanwhile; the model's heat goes on
        if self._setpoint is not None:
            self._command = command
            self.safety.command(self._probe() if self._lost else command.current, now)

    def _problem(self, now: float) -> str:
        """Why nothing may be built on the feedback; '' where it is alive."""
        if self.feedback_topic in self.node.out_of_step:
            return self.node.out_of_step[self.feedback_topic]
        problem = self._lifeless(now)
        return self.node.unmatched.get(self.feedback_topic, problem) if problem else ''

    def _lifeless(self, now: float) -> str:
        if not self.on_joint:
            return self._watch.problem(now, self._expected_feedback())
        # Two muscles may warm and the angle stand still: that it does not move says nothing.
        silent = self._watch.problem(now, None) or self.partner_stopped
        if not silent and self.tension(now) is None:
            return f'no force for {self._watch.timeout:g} s'
        return silent or self.refuses or self.partner_refuses

    def _measurement(self) -> dict[str, float]:
        # The model controller fills the gaps between samples itself; a PID holds the last one.
        new, self._measured_anew = self._measured_anew, False
        if self._lost or self._watch.value is None or not (new or self.settings['mode'] == 'pid'):
            return {}
        return {self._feedback: self._watch.value}

    def _flowing(self, now: float) -> float:
        measured = self._current.fresh(now, self._watch.timeout)
        return self.safety.current if measured is None else measured

    def _expected_feedback(self) -> float | None:
        if self._command is None:
            return None
        if self._feedback == 'displacement':
            return self._command.expected_displacement
        return self._command.expected_resistance

    def _probe(self) -> float:
        """A, that flows although nothing may be built on the feedback; 0 where none does."""
        if not self._lost or self._setpoint is None:
            return 0.0
        if self._lost == self.refuses:
            return ASKED
        return float(self.settings['probe_current_a']) if self._feedback == 'resistance' else 0.0

    def _publish(self, current: float) -> None:
        self._current_command.send(current)
        if self._command is not None:
            self._shaped.send(self._command.shaped_setpoint)

    def publish_zero(self) -> Sequence[Publisher]:
        """Command 0 A."""
        self._current_command.send(0.0)
        return [self._current_command.publisher]

    # Diagnostics

    def worries(self) -> Iterable[str]:
        """What keeps it from working, beside safety."""
        yield from self._mixed
        if self._taking.untaken and not self.on_joint:  # a joint says it, and stops
            yield 'none of the current that is asked for flows: its receiver is disabled or in fault'
        if self._probe() > 0.0:
            yield f'{self._lost}, probing'
        elif self._lost and self._setpoint is None:
            yield self._lost
        if self._let_go is not None:
            yield f'let go by setpoint {self._let_go:g} m, which came while in a fault: send another'
        elif self._setpoint is None:
            yield 'no setpoint yet'
        elif self._command is not None and not self.on_joint:
            shaped = self._command.shaped_setpoint
            if self._setpoint - shaped > _FINE['displacement']:
                yield (
                    f'setpoint {self._setpoint:.4g} m is beyond reach: {shaped:.4g} m is the most under its load at '
                    f'{self.settings["current_limit_a"]:g} A and {self.settings["derate_temperature_c"]:g} degC'
                )
            elif shaped - self._setpoint > _RELEASED:
                yield (
                    f'setpoint {self._setpoint:.4g} m is beyond reach: {shaped:.4g} m is the least, without a current '
                    '(positive when shorter)'
                )

    def facts(self) -> Mapping[str, str]:
        """What is wanted, measured and believed."""
        command, measured = self._command, self._watch.value
        return {
            'mode': self.settings['mode'],
            'model_file': self.settings['model_file'] or 'none',
            'feedback': self._feedback,
            'setpoint_m': number(self._setpoint),
            'shaped_setpoint_m': number(None if command is None else command.shaped_setpoint),
            f'{self._feedback}_{_UNIT[self._feedback]}': number(measured),
            'predicted_displacement_m': number(None if command is None else command.predicted_displacement),
            'predicted_temperature_c': number(None if self._fibre is None else self._fibre - ZERO_CELSIUS),
        }

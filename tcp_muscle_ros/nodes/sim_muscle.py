"""One simulated muscle behind its topics and its sensors."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import Float64

from tcp_muscle_ros.control.safety import Kind, Limits
from tcp_muscle_ros.muscle import ZERO_CELSIUS, Muscle, Reading
from tcp_muscle_ros.muscle.mechanical import COIL_LONGEST, COIL_SHORTEST, DOMAIN_HIGH, DOMAIN_LOW
from tcp_muscle_ros.muscle.quantities import IN_ZERO
from tcp_muscle_ros.muscle.sensors import Noise, Sensor
from tcp_muscle_ros.nodes.home import SimHome
from tcp_muscle_ros.nodes.parameters import Settings
from tcp_muscle_ros.nodes.safe_muscle import SafeMuscle, number
from tcp_muscle_ros.nodes.topics import MEASUREMENT_QOS

_CHANNELS = {'temperature': 'k', 'resistance': 'ohm', 'displacement': 'm', 'force': 'n'}


def make_muscle(settings: Settings) -> Muscle:
    """The muscle that the parameters describe, at rest at its initial temperature.

    Raises:
        BadInput: values that make no muscle.
    """
    return Muscle(
        settings.muscle(),
        end=settings['end'],
        load=settings['load_n'],
        held_length=settings['held_length_m'],
        spring_rate=settings['spring_rate_n_per_m'],
        spring_rest_length=settings['spring_rest_length_m'],
        ambient=settings.kelvin('ambient_temperature_c'),
        temperature=settings.kelvin('initial_temperature_c'),
    )


def joint_states(names: Sequence[str]) -> JointState:
    """All at rest at 0."""
    message = JointState(name=names)
    message.position, message.velocity, message.effort = ([0.0] * len(names) for _ in range(3))
    return message


class SimMuscle(SafeMuscle):
    """A muscle's inputs, sensors and safety; ``SimNode`` steps it.

    ``current`` (A) was decided at the last tick and flows until the next.
    """

    node: SimHome

    def __init__(self, node: SimHome, name: str, settings: Settings) -> None:
        super().__init__(node, name, settings)
        self.current = 0.0
        self.muscle = make_muscle(settings)
        self._load: float | None = None  # N, once it came by topic
        self._ambient: float | None = None  # K, likewise
        self._reading: Reading = self.muscle.reading(0.0)
        self._shown: tuple[float, ...] = ()
        self._sensors = {channel: Sensor() for channel in _CHANNELS}
        self._noise = Noise(settings['seed'], len(_CHANNELS))

        self._current, self._voltage, self._resistance, self._displacement, self._force = (
            self.publisher(channel) for channel in ('current', 'voltage', 'resistance', 'displacement', 'force')
        )
        thermometer = Temperature()
        thermometer.header.frame_id = self.frame
        self._temperature, (self._celsius, self._variance) = node.stamped(
            self.topic('temperature'), thermometer, 'temperature', 'variance'
        )
        joint = joint_states([settings['joint_name']])
        joint.header.frame_id = self.frame
        self._joint, (self._position, self._velocity, self._effort) = node.stamped(
            self.topic('joint_states'), joint, 'position', 'velocity', 'effort'
        )

        self._apply_sensors()
        for kind in Kind:
            self.listen(Float64, f'{kind.name.lower()}_command', self._commander(kind))
        self.listen(Float64, 'load', self._take_load, MEASUREMENT_QOS)
        self.listen(Temperature, 'ambient_temperature', self._take_ambient, MEASUREMENT_QOS)

    # Parameters

    def limits_of(self, settings: Settings) -> Limits:
        """The safety limits, with the watchdog."""
        return settings.limits(command_timeout=settings['command_timeout_s'])

    def apply(self, settings: Settings) -> None:
        """The same muscle in its present state, with other properties; its ruler keeps its zero."""
        before = self.muscle
        self.muscle = make_muscle(settings)
        self.muscle.state[:] = before.state
        if settings['end'] == 'load':  # a softer coil lets its load hang lower
            self.muscle.imposed[IN_ZERO] = before.imposed[IN_ZERO]
        self.muscle.impose(self._load, self._ambient)
        self.node.gather()  # a joint or a robot gives it its length
        self.muscle.go_on_from(before)
        self._apply_sensors()

    def _apply_sensors(self) -> None:
        settings = self.settings
        for name, unit in _CHANNELS.items():
            sensor = self._sensors[name]
            sensor.lag = settings[f'{name}_lag_s']
            sensor.noise = settings[f'{name}_noise_{unit}']
            sensor.quantum = settings[f'{name}_quantum_{unit}']
        self._ideal = all(sensor.ideal for sensor in self._sensors.values())
        self._variance[0] = self._sensors['temperature'].noise ** 2
        self._min_sense_current = settings['min_sense_current_a']

    # What comes in

    def _commander(self, kind: Kind) -> Callable[[Float64], None]:
        def take(message: Float64) -> None:
            with self.node.lock:
                self.safety.command(message.data, self.node.seconds(), kind)

        return take

    def _take_load(self, message: Float64) -> None:
        if self.accept('load', message.data, like='load_n'):
            with self.node.lock:
                self._load = message.data
                self.muscle.impose(load=self._load)

    def _take_ambient(self, message: Temperature) -> None:
        if self.accept('ambient_temperature', message.temperature, like='ambient_temperature_c'):
            with self.node.lock:
                self._ambient = message.temperature + ZERO_CELSIUS
                self.muscle.impose(ambient=self._ambient)

    def forget(self) -> str:
        """~/reset: the muscle is at rest at its initial temperature again, the noise begins anew."""
        self.muscle.reset(self.settings.kelvin('initial_temperature_c'))
        self._noise = Noise(self.settings['seed'], len(_CHANNELS))
        for sensor in self._sensors.values():
            sensor.reset()
        return f'reset: at rest at {self.settings["initial_temperature_c"]:g} degC'

    # One tick

    def decide(self, reading: Reading, dt: float, now: float) -> None:
        """Look at the muscle through its sensors, and decide the current that flows from now on."""
        self._reading = reading
        shown: tuple[float, ...] = reading.temperature, reading.resistance, reading.displacement, reading.force
        if not self._ideal:
            sensors, draws = self._sensors.values(), self._noise.row()
            shown = tuple(
                sensor.read(value, dt, normal) for sensor, value, normal in zip(sensors, shown, draws, strict=True)
            )
        self._shown = shown
        self.current = self.safety.update(
            now, dt, resistance=reading.resistance, temperatures=(shown[0], reading.fibre_temperature)
        )

    def publish(self) -> None:
        """Publish what was seen and decided; the stamp is the node's."""
        temperature, resistance, displacement, force = self._shown
        reading, current = self._reading, self.current
        self._celsius[0] = temperature - ZERO_CELSIUS
        self._temperature.publish()
        self._current.send(current)
        self._voltage.send(current * reading.resistance)
        self._displacement.send(displacement)
        self._force.send(force)
        if current >= self._min_sense_current:
            self._resistance.send(resistance)
        self._position[0], self._velocity[0], self._effort[0] = displacement, reading.velocity, force
        self._joint.publish()

    def joint_state(self) -> tuple[float, float, float]:
        """Position m, velocity m/s and effort N, as ``publish`` says them."""
        return self._shown[2], self._reading.velocity, self._shown[3]

    def publish_zero(self) -> Sequence[Publisher]:
        """0 A, and so 0 V."""
        self.current = 0.0
        zeroed = self._current, self._voltage
        for topic in zeroed:
            topic.send(0.0)
        return [topic.publisher for topic in zeroed]

    # Diagnostics

    def worries(self) -> Iterable[str]:
        """What the model cannot vouch for."""
        if not DOMAIN_LOW <= self._reading.fibre_temperature <= DOMAIN_HIGH:
            yield "outside the model's domain (0 to 120 degC)"
        elif not self._reading.in_domain:
            yield 'outside the table of a free law, which is extrapolated'
        if not self._is_a_coil:
            hint = ': is the load in N?' if self._stretch > COIL_LONGEST else ''
            yield f'{self._stretch:.3g} times its own length, which no coil is{hint}'
        if self._reading.slack:
            yield 'slack: a muscle cannot push'

    @property
    def _stretch(self) -> float:
        """How long it is, in its own length."""
        return self._reading.length / self.muscle.parameters['H0']

    @property
    def _is_a_coil(self) -> bool:
        return COIL_SHORTEST <= self._stretch <= COIL_LONGEST

    def facts(self) -> Mapping[str, str]:
        """The muscle behind the sensors."""
        return {
            'fibre_temperature_c': number(self._reading.fibre_temperature - ZERO_CELSIUS),
            'in_domain': str(self._reading.in_domain and self._is_a_coil).lower(),
            'slack': str(self._reading.slack).lower(),
            'effects': ', '.join(self.settings['effects']) or 'none',
        }

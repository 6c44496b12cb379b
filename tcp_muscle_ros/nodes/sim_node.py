"""A muscle that is not there: takes currents, powers or voltages, and shows what a real one with its sensors would."""

import time
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence

from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import Float64

from tcp_muscle_ros.control.safety import Kind, Limits, celsius
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import ZERO_CELSIUS, Muscle, Reading
from tcp_muscle_ros.nodes.lifetime import run
from tcp_muscle_ros.nodes.parameters import Settings
from tcp_muscle_ros.nodes.safe_node import COMMAND_QOS, STATE_QOS, SafeNode
from tcp_muscle_ros.nodes.sensors import Noise, Sensor
from tcp_muscle_ros.nodes.ticks import SECOND, ScaledTime, TimeBase
from tcp_muscle_ros.operating import SIM

_CLOCK_QOS = QoSProfile(depth=1)
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


class SimNode(SafeNode):
    """Steps the muscle at a fixed rate and publishes what contracts.md calls one muscle's topics.

    At tick k the state is advanced to t_k under the current decided at tick k - 1; then the current of tick k is
    decided. State and current of one tick are published together: an input stamped t_k holds from t_k to t_{k+1}.
    """

    def __init__(self) -> None:
        super().__init__(SIM)
        self._ambient: float | None = None  # K, once it came by topic
        self._load: float | None = None  # N, likewise
        self._muscle = make_muscle(self.settings)
        self._reading: Reading = self._muscle.reading(0.0)
        self._sensors = {name: Sensor() for name in _CHANNELS}
        self._noise = Noise(self.settings['seed'], len(_CHANNELS))
        self._current = 0.0  # A, flows until the next tick

        self._values = {
            name: (self.create_publisher(Float64, name, STATE_QOS), Float64())
            for name in ('current', 'voltage', 'resistance', 'displacement', 'force')
        }
        self._temperature = self.create_publisher(Temperature, 'temperature', STATE_QOS), Temperature()
        self._joint = self.create_publisher(JointState, 'joint_states', STATE_QOS), JointState()
        self._clock_publisher = None
        if isinstance(self.time_base, ScaledTime):
            self._clock_publisher = self.create_publisher(Clock, '/clock', _CLOCK_QOS)
            self._clock_message = Clock()
        self._temperature[1].header.frame_id = self._joint[1].header.frame_id = self.settings['joint_name']
        self._joint[1].name = [self.settings['joint_name']]
        # Arrays that are written in place: handing over a list would copy it into a new one each time.
        self._position, self._velocity, self._effort = array('d', [0.0]), array('d', [0.0]), array('d', [0.0])
        self._joint[1].position, self._joint[1].velocity, self._joint[1].effort = (
            self._position,
            self._velocity,
            self._effort,
        )

        self._apply_sensors()
        for kind in Kind:
            self.create_subscription(Float64, f'{kind.name.lower()}_command', self._commander(kind), COMMAND_QOS)
        self.create_subscription(Float64, 'load', self._take_load, COMMAND_QOS)
        self.create_subscription(Temperature, 'ambient_temperature', self._take_ambient, COMMAND_QOS)

    # Parameters

    def check(self, settings: Settings) -> None:
        """Raise BadInput against values that make no muscle, no limits or no clock."""
        super().check(settings)
        make_muscle(settings)
        if settings['real_time_factor'] != 1.0 and self.get_parameter('use_sim_time').value:
            raise BadInput(
                f'real_time_factor is {settings["real_time_factor"]:g} and use_sim_time is true: this node cannot '
                f'publish /clock and follow it; expected one of them'
            )

    def limits_of(self, settings: Settings) -> Limits:
        """The safety limits, with the watchdog."""
        return settings.limits(command_timeout=settings['command_timeout_s'])

    def apply(self, settings: Settings) -> None:
        """The same muscle in its present state, with other properties."""
        state = self._muscle.state
        self._muscle = make_muscle(settings)
        self._muscle.state[:] = state
        self._apply_sensors()

    def _apply_sensors(self) -> None:
        settings = self.settings
        for name, unit in _CHANNELS.items():
            sensor = self._sensors[name]
            sensor.lag = settings[f'{name}_lag_s']
            sensor.noise = settings[f'{name}_noise_{unit}']
            sensor.quantum = settings[f'{name}_quantum_{unit}']
        self._ideal = all(sensor.ideal for sensor in self._sensors.values())
        self._temperature[1].variance = self._sensors['temperature'].noise ** 2
        self._min_sense_current = settings['min_sense_current_a']

    def make_time_base(self) -> TimeBase:
        """The clock that the ticks keep to: its own unless it runs in real time."""
        if self.settings['real_time_factor'] != 1.0:
            return ScaledTime(self.settings['real_time_factor'])
        return super().make_time_base()

    # What comes in

    def _commander(self, kind: Kind) -> Callable[[Float64], None]:
        def take(message: Float64) -> None:
            with self.lock:
                self.safety.command(message.data, time.monotonic(), kind)

        return take

    def _take_load(self, message: Float64) -> None:
        if self.accept('load', message.data, like='load_n'):
            self._load = message.data

    def _take_ambient(self, message: Temperature) -> None:
        if self.accept('ambient_temperature', message.temperature, like='ambient_temperature_c'):
            self._ambient = message.temperature + ZERO_CELSIUS

    def forget(self) -> str:
        """~/reset: the muscle is at rest at its initial temperature again, the noise begins anew."""
        self._muscle.reset(self.settings.kelvin('initial_temperature_c'))
        self._noise = Noise(self.settings['seed'], len(_CHANNELS))
        for sensor in self._sensors.values():
            sensor.reset()
        return f'reset: at rest at {self.settings["initial_temperature_c"]:g} degC'

    # One tick

    def work(self, stamp: int, dt: float, now: float, publish: bool) -> None:
        """Advance the muscle to this tick, decide the current, publish both."""
        if 0.0 < dt <= self.safety.limits.longest_step:
            reading = self._muscle.step(dt, self._current, 'current', self._load, self._ambient)
        else:  # no step of time: the muscle stays as it is, the safety machine counts it
            dt, reading = 0.0, self._muscle.reading(self._current, 'current', self._load, self._ambient)
        temperature, resistance, displacement, force = self._measure(reading, dt)
        self._reading = reading
        self._current = self.safety.update(
            now, dt, resistance=reading.resistance, temperatures=(temperature, reading.fibre_temperature)
        )
        if publish:
            self._publish(stamp, temperature, resistance, displacement, force)

    def _measure(self, reading: Reading, dt: float) -> tuple[float, float, float, float]:
        true = reading.temperature, reading.resistance, reading.displacement, reading.force
        if self._ideal:
            return true
        sensors, draws = self._sensors.values(), self._noise.row()
        temperature, resistance, displacement, force = (
            sensor.read(value, dt, normal) for sensor, value, normal in zip(sensors, true, draws, strict=True)
        )
        return temperature, resistance, displacement, force

    def _publish(self, stamp: int, temperature: float, resistance: float, displacement: float, force: float) -> None:
        seconds, nanoseconds = divmod(stamp, SECOND)
        if self._clock_publisher is not None:
            self._clock_message.clock.sec, self._clock_message.clock.nanosec = seconds, nanoseconds
            self._clock_publisher.publish(self._clock_message)
        publisher, message = self._temperature
        message.header.stamp.sec, message.header.stamp.nanosec = seconds, nanoseconds
        message.temperature = temperature - ZERO_CELSIUS
        publisher.publish(message)
        current = self._current
        shown = {
            'current': current,
            'voltage': current * self._reading.resistance,
            'displacement': displacement,
            'force': force,
        }
        if current >= self._min_sense_current:
            shown['resistance'] = resistance
        for name, value in shown.items():
            publisher, number = self._values[name]
            number.data = float(value)
            publisher.publish(number)
        publisher, joint = self._joint
        joint.header.stamp.sec, joint.header.stamp.nanosec = seconds, nanoseconds
        self._position[0], self._velocity[0], self._effort[0] = displacement, self._reading.velocity, force
        publisher.publish(joint)

    def publish_zero(self) -> Sequence[Publisher]:
        """0 A, and so 0 V."""
        self._current = 0.0
        publishers = []
        for name in ('current', 'voltage'):
            publisher, message = self._values[name]
            message.data = 0.0
            publisher.publish(message)
            publishers.append(publisher)
        return publishers

    # Diagnostics

    def worries(self) -> Iterable[str]:
        """What the model cannot vouch for."""
        if not self._reading.in_domain:
            yield "outside the model's domain (0 to 120 degC)"
        if self._reading.slack:
            yield 'slack: a muscle cannot push'

    def facts(self) -> Mapping[str, str]:
        """The muscle behind the sensors."""
        return {
            'fibre_temperature_c': celsius(self._reading.fibre_temperature),
            'in_domain': str(self._reading.in_domain).lower(),
            'slack': str(self._reading.slack).lower(),
            'effects': ', '.join(self.settings['effects']) or 'none',
        }


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run(SimNode, SIM, args)


if __name__ == '__main__':
    raise SystemExit(main())

"""sim_node as its users meet it: a process, its topics, its clock and its services."""

import signal
import time
from itertools import pairwise
from math import nan, sqrt

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import DescribeParameters, GetParameters, SetParameters, SetParametersAtomically
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from tcp_muscle_ros.muscle import Muscle, Parameters
from tcp_muscle_ros.settings.operating import OPERATING

pytestmark = pytest.mark.processes

NUMBERS = ('current', 'voltage', 'resistance', 'displacement', 'force')
LOAD = float(OPERATING['load_n'].default)


def stamp(message):
    """The time of a stamped message, ns."""
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


class Muscles:
    """Everything that one sim_node says."""

    def __init__(self, bench, namespace, *more, numbers=NUMBERS, **parameters):
        self.bench, self.namespace = bench, namespace
        self.heard = {name: bench.listen(f'/{namespace}/{name}') for name in numbers}
        self.temperature = bench.listen(f'/{namespace}/temperature', Temperature)
        self.joints = bench.listen(f'/{namespace}/joint_states', JointState)
        self.program = bench.start('sim_node', namespace, *more, **parameters)

    def __getattr__(self, name):
        return self.heard[name]

    def speaking(self):
        self.bench.until(lambda: self.temperature and self.joints, 'sim_node publishes nothing', 120.0)
        return self

    def call(self, kind, service, **fields):
        return self.bench.call(kind, f'/{self.namespace}/sim_node/{service}', **fields)

    def end(self):
        self.program.kill()
        self.bench.forget(self.temperature, self.joints, *self.heard.values())


@pytest.fixture(scope='module')
def sim(bench):
    made = Muscles(bench, 'shared', temperature_noise_k=0.0, rate_hz=200.0).speaking()
    yield made
    made.end()


def test_one_tick_carries_one_stamp_and_ticks_are_a_period_apart(bench, sim):
    bench.until(lambda: len(sim.temperature) > 100 and len(sim.joints) > 100, 'too few ticks')
    temperatures = {stamp(message) for _, message in sim.temperature[5:95]}
    assert temperatures <= {stamp(message) for _, message in sim.joints}
    apart = [b - a for a, b in pairwise(sorted(temperatures))]
    assert apart.count(5_000_000) > 80 and all(step % 5_000_000 == 0 for step in apart), apart
    came, message = sim.temperature[50]
    behind = time.time_ns() - (time.monotonic() - came) * 1e9 - stamp(message)
    assert abs(behind) < 0.5e9, 'stamps are not on the system clock'
    assert message.header.frame_id == 'shared_moving_end' == sim.joints.last.header.frame_id
    assert sim.joints.last.name == ['shared'], 'named after the namespace'


def test_the_muscle_on_the_topics_is_the_muscle_of_the_model_to_the_last_bit(bench, sim):
    command = bench.speaker('/shared/current_command')
    with bench.repeating(command, 0.1) as change:  # not the way of heating that is compared
        bench.until(lambda: sim.temperature.last.temperature > 23.1, 'no heating')
        change(0.25)
        bench.until(lambda: sim.temperature.last.temperature > 24.0, 'no heating')
        begun = time.monotonic()
        assert bench.call(Trigger, '/shared/sim_node/reset').message == 'reset: at rest at 23 degC'
        cold = bench.until(lambda: sim.temperature.last.temperature < 23.2, 'no reset')
        bench.until(lambda: len(sim.joints.since(cold)) > 150 and len(sim.voltage.since(cold)) > 150, 'too few ticks')
    muscle = Muscle(Parameters.named('karami_tadesse_2017'), load=LOAD)
    model = [muscle.step(0.005, 0.25) for _ in range(100)]

    def agree(topic, shown, of_the_model):
        """What came between the first and the last value of the model is the model's, in its order."""
        expected = [of_the_model(reading) for reading in model]
        place = {value: k for k, value in enumerate(expected)}
        known = [k for k, value in enumerate(shown) if value in place]
        between = [place.get(value, -1) for value in shown[known[0] : known[-1] + 1]]
        assert between == sorted(between) and min(between) >= 0 and len(between) > 50, topic

    temperatures, joints = sim.temperature.since(begun), sim.joints.since(begun)
    agree('temperature', [m.temperature for m in temperatures], lambda r: r.temperature - 273.15)
    agree('joint position', [m.position[0] for m in joints], lambda r: r.displacement)
    agree('displacement', [m.data for m in sim.displacement.since(begun)], lambda r: r.displacement)
    agree('resistance', [m.data for m in sim.resistance.since(begun)], lambda r: r.resistance)
    agree('voltage', [m.data for m in sim.voltage.since(begun)], lambda r: 0.25 * r.resistance)
    assert {m.effort[0] for m in joints} == {m.data for m in sim.force.since(begun)} == {LOAD}


def test_a_current_decided_at_a_tick_flows_from_that_tick_on(bench, sim):
    bench.until(lambda: sim.current.last.data == 0.0, 'the watchdog does not bite')
    bench.call(Trigger, '/shared/sim_node/reset')
    rest = bench.until(lambda: sim.temperature.last.temperature == 23.0, 'no reset')
    bench.speaker('/shared/voltage_command').publish(Float64(data=2.8))
    bench.until(lambda: any(message.data for message in sim.current.since(rest)), 'no current')
    first = next(message.data for message in sim.current.since(rest) if message.data)
    assert first == 2.8 / 14.0, 'decided with the resistance of that tick, before any heating'
    bench.until(lambda: any(message.data for message in sim.voltage.since(rest)), 'no voltage')
    assert next(message.data for message in sim.voltage.since(rest) if message.data) == first * 14.0


def test_power_and_voltage_are_met_by_a_current_that_follows_the_resistance(bench, sim):
    for kind, value, expected in (
        ('power', 0.7, lambda r: sqrt(0.7 / r)),
        ('voltage', 3.0, lambda r: 3.0 / r),
        ('power', 50.0, lambda _: 0.27),
    ):
        with bench.repeating(bench.speaker(f'/shared/{kind}_command'), value):
            heard = len(sim.resistance)
            bench.until(lambda heard=heard: len(sim.resistance) > heard + 100, 'too few ticks')
            currents = set(sim.current.values)
            agreeing = sum(expected(r) in currents for r in sim.resistance.values[heard + 20 : heard + 80])
            assert agreeing > 50, kind
        bench.until(lambda: sim.current.last.data == 0.0, 'the watchdog does not bite')


def test_load_and_ambient_come_by_topic_and_nonsense_is_refused(bench, sim):
    diagnostics = bench.listen('/diagnostics', DiagnosticArray)
    load = bench.speaker('/shared/load')
    ambient = bench.speaker('/shared/ambient_temperature', Temperature)
    bench.insist(load, Float64(data=1.0), lambda: sim.force.last.data == 1.0, 'the load is not heard')
    bench.until(lambda: sim.displacement.last.data < -0.015, 'a heavier load lengthens the muscle')
    for broken in (nan, -1.0, 1e308):
        load.publish(Float64(data=broken))
    bench.insist(
        ambient,
        Temperature(temperature=296.0),  # kelvin
        lambda: any(
            value.key == 'refused_inputs' and 'load' in value.value and 'ambient_temperature' in value.value
            for _, array in diagnostics
            for status in array.status
            for value in status.values
        ),
        'not counted',
    )
    assert sim.force.last.data == 1.0
    no_coil = 'times its own length, which no coil is'  # grams, taken for newtons
    bench.insist(
        load,
        Float64(data=100.0),
        lambda: any(no_coil in status.message for _, array in diagnostics[-20:] for status in array.status),
        'nobody is told',
    )
    warm = Temperature(temperature=30.0)
    bench.insist(ambient, warm, lambda: sim.temperature.last.temperature > 25.0, 'the ambient is not heard')
    ambient.publish(Temperature(temperature=23.0))
    load.publish(Float64(data=LOAD))


def test_parameters_can_be_looked_at_and_changed_while_it_runs(bench, sim):
    described = sim.call(DescribeParameters, 'describe_parameters', names=['hA', 'L0', 'end', 'seed']).descriptors
    assert described[0].floating_point_range[0].to_value == 10.0 and 'W/K' in described[0].description
    assert [descriptor.read_only for descriptor in described] == [False, True, True, True]
    assert described[2].additional_constraints == 'one of: load, blocked, spring'

    def change(**values):
        parameters = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
        return sim.call(SetParametersAtomically, 'set_parameters_atomically', parameters=parameters).result

    refused = change(derate_temperature_c=120.0)
    assert not refused.successful and refused.reason.startswith('derating must begin below')
    for values in ({'hA': nan}, {'hA': 1e3}, {'L0': 0.4}, {'seed': 3}):
        assert not change(**values).successful, values
    with bench.repeating(bench.speaker('/shared/current_command'), 0.27):
        bench.until(lambda: sim.temperature.last.temperature > 26.0, 'no heating')
        begun = time.monotonic()
        assert change(hA=1.0).successful
        bench.until(lambda: sim.temperature.last.temperature < 24.5, 'the change is not felt')
        seen = [(stamp(message) * 1e-9, message.temperature) for message in sim.temperature.since(begun)]
        assert change(hA=0.01933).successful
    fastest = max(abs((b - a) / (then - at)) for (at, a), (then, b) in pairwise(seen))
    # What hA = 1 W/K takes from the hottest that was seen; heating adds less, and a state that is lost 600 K/s.
    assert fastest < 1.1 * (max(b for _, b in seen) - 23.0) / Parameters.named('karami_tadesse_2017')['C'], 'it jumped'
    values = sim.call(GetParameters, 'get_parameters', names=['hA']).values
    assert values[0].double_value == 0.01933


def test_a_parameter_that_is_set_does_not_move_it(bench, sim):
    """What it is now is not what it was before the heating: of that the velocity knows nothing."""
    parameters = [Parameter('command_timeout_s', value=0.6).to_parameter_msg()]
    with bench.repeating(bench.speaker('/shared/current_command'), 0.27):
        bench.until(lambda: sim.displacement.last.data > 0.005, 'it does not contract')
        begun = time.monotonic()
        assert sim.call(SetParameters, 'set_parameters', parameters=parameters).results[0].successful
        bench.until(lambda: len(sim.joints.since(begun)) > 50, 'too few ticks')
    fastest = max(abs(message.velocity[0]) for message in sim.joints.since(begun))
    assert 1e-4 < fastest < 0.02, fastest
    parameters = [Parameter('command_timeout_s', value=0.5).to_parameter_msg()]
    assert sim.call(SetParameters, 'set_parameters', parameters=parameters).results[0].successful


def test_a_change_is_taken_as_at_the_start_and_refused_in_the_same_words(bench, sim):
    def change(name, value):
        parameters = [Parameter(name, value=value).to_parameter_msg()]
        return sim.call(SetParameters, 'set_parameters', parameters=parameters).results[0]

    assert change('load_n', 1).reason.startswith("parameter 'load_n' is 0.588399 as long as the node runs; set another")
    assert change('current_limit_a', 1).successful  # `ros2 param set` sends 1 as a whole number
    (value,) = sim.call(GetParameters, 'get_parameters', names=['current_limit_a']).values
    assert value.double_value == 1.0
    assert change('current_limit_a', 0.27).successful
    for name, value, reason in (
        ('curent_limit_a', 0.1, "unknown parameter 'curent_limit_a'; did you mean 'current_limit_a'?"),
        ('hA', 'much', "parameter 'hA' is 'much'; expected a number (convection conductance"),
        ('hA', True, "parameter 'hA' is true; expected a number (convection conductance"),
        ('rate_hz', 50.0, "parameter 'rate_hz' is 200 as long as the node runs; set another at the start: --ros-args"),
        ('natural_convection.n', 0.3, "parameter 'natural_convection.n' is of an effect that is off; effects are"),
        ('command_timeout', 1.0, "unknown parameter 'command_timeout'; did you mean 'command_timeout_s'?"),
    ):
        refused = change(name, value)
        assert not refused.successful
        assert refused.reason.startswith(reason), refused.reason
        assert '\n' not in refused.reason


def test_a_coil_that_becomes_softer_lets_its_load_hang_lower(bench, sim):
    """The ruler keeps its zero: rest under the starting load, as the muscle was then."""
    k0 = Parameters.named('karami_tadesse_2017')['k0']

    def change(value):
        parameters = [Parameter('k0', value=value).to_parameter_msg()]
        return sim.call(SetParametersAtomically, 'set_parameters_atomically', parameters=parameters).result.successful

    assert change(k0)  # a first attempt may have left it softer
    sim.call(Trigger, 'reset')  # cold
    bench.until(lambda: sim.temperature.last.temperature < 23.2, 'it is not cold')
    cold = time.monotonic()
    bench.until(lambda: len(sim.displacement.since(cold)) > 5, 'too few ticks')  # the stroke of a tick may come later
    before = sim.displacement.last.data
    assert change(0.9 * k0)
    lower = 0.06 * 9.80665 / k0 * (1.0 / 0.9 - 1.0)
    bench.until(lambda: sim.displacement.last.data == pytest.approx(before - lower, abs=2e-4), 'the load stays up')
    assert change(k0)
    bench.until(lambda: sim.displacement.last.data == pytest.approx(before, abs=2e-4), 'it stays down')


def test_the_clock_stays_the_one_that_it_began_with(bench, sim):
    def change(value):
        parameters = [Parameter('use_sim_time', value=value).to_parameter_msg()]
        return sim.call(SetParametersAtomically, 'set_parameters_atomically', parameters=parameters).result

    refused = change(True)
    assert not refused.successful
    assert refused.reason.endswith('set another at the start: --ros-args -p use_sim_time:=true')
    assert change(False).successful
    begun = time.monotonic()
    bench.until(lambda: sim.temperature.since(begun), 'it ticks no more')
    assert abs(stamp(sim.temperature.last) - time.time_ns()) < 5e9, 'stamps are not on the system clock'


# Other ways to start it


def test_two_muscles_side_by_side_with_one_parameter_file(bench, tmp_path):
    file = tmp_path / 'muscle.yaml'
    file.write_text('/**:\n  ros__parameters:\n    R0: 20.0\n    effects: [creep]\n    creep.J: 0.2\n    mode: pid\n')
    left = Muscles(bench, 'hand/left', '--params-file', str(file))
    right = Muscles(bench, 'hand/right', '--params-file', str(file), R0=15.0)
    for muscle, resistance in ((left, 20.0), (right, 15.0)):
        muscle.speaking()
        bench.until(lambda muscle=muscle: muscle.resistance, 'no resistance')
        assert muscle.resistance.last.data == pytest.approx(resistance)
        assert 'effects=[creep]' in muscle.program.said() and 'creep.J=0.2' in muscle.program.said()
    bench.speaker('/hand/left/current_command').publish(Float64(data=0.1))
    bench.until(lambda: 0.1 in left.current.values, 'the left one does not hear its command')
    assert set(right.current.values) == {0.0}
    left.end()
    right.end()


def test_a_blocked_muscle_pulls_and_a_small_current_shows_no_resistance(bench):
    sim = Muscles(bench, 'blocked', end='blocked', min_sense_current_a=0.05, start_enabled=False)
    sim.speaking()
    command = bench.speaker('/blocked/current_command')
    with bench.repeating(command, 0.2):
        bench.until(lambda: len(sim.current) > 30, 'too few ticks')
        assert set(sim.current.values) == {0.0} and not sim.resistance, 'disabled at the start'
        assert sim.call(SetBool, 'enable', data=True).success
        bench.until(lambda: sim.force.last.data > LOAD + 0.05, 'no force')
        assert sim.resistance and abs(sim.displacement.last.data) < 1e-12
    sim.end()


@pytest.mark.parametrize('rate', [1.0, 2000.0])
def test_the_slowest_and_the_fastest_rate(bench, rate):
    sim = Muscles(bench, f'rate_{rate:.0f}', numbers=('current',), rate_hz=rate, command_timeout_s=0.0).speaking()
    bench.speaker(f'/rate_{rate:.0f}/current_command').publish(Float64(data=0.2))
    bench.until(lambda: sim.current.last.data == 0.2, 'no current')
    bench.until(lambda: len(sim.joints) >= min(4.0, rate) and sim.temperature.last.temperature > 23.5, 'too slow')
    steps = {b - a for a, b in pairwise(sorted(stamp(message) for _, message in sim.joints))}
    period = round(1e9 / rate)
    # A missed tick leaves a gap of whole periods; setting the system's clock moves the stamps by what it was set by.
    assert min(steps) > 0.9 * period and sum(abs(step / period - round(step / period)) < 0.01 for step in steps) > 0
    sim.end()


def test_as_fast_as_it_can_is_faster_than_real_time_and_carries_the_clock(bench):
    clock = bench.listen('/clock', Clock, depth=1)
    sim = Muscles(bench, 'hurried', numbers=(), real_time_factor=0.0).speaking()
    # From the first message heard on: how far the simulation had come by then is the machine's affair.
    early = sim.joints[0][1]
    bench.until(lambda: stamp(sim.joints.last) > stamp(early) + 30e9, 'no hurry')
    bench.until(lambda: best_pace(sim.joints[:]) > 2.0, 'no second of it is hurried')
    assert stamp(early) % 10_000_000 == 0
    bench.until(lambda: clock.last.clock.sec >= 29, 'no clock of it')
    sim.end()
    bench.forget(clock)


def test_the_seed_alone_decides_the_noise(bench):
    runs = [  # at once: their start takes longest
        Muscles(
            bench, namespace, numbers=('displacement',), rate_hz=20.0, real_time_factor=5.0, seed=seed,
            temperature_noise_k=0.5, displacement_noise_m=1e-4, displacement_quantum_m=1e-5, force_lag_s=0.1,
        )
        for namespace, seed in (('seed_a', 7), ('seed_b', 7), ('seed_c', 8))
    ]  # fmt: skip
    for sim in runs:
        sim.speaking()

    def noise():
        return [{stamp(message): message.temperature for _, message in sim.temperature[:]} for sim in runs]

    def ticks_of_all(heard):
        """Each may have left out ticks for which its process was too late."""
        return sorted(set.intersection(*map(set, heard)))

    bench.until(lambda: len(ticks_of_all(noise())) > 200, 'too few ticks that all have')
    for sim in runs:
        sim.end()
    first, heard = runs[0], noise()
    shared = ticks_of_all(heard)
    assert len(shared) > 200
    assert [heard[0][at] for at in shared] == [heard[1][at] for at in shared]
    assert sum(heard[0][at] == heard[2][at] for at in shared) == 0
    draws = np.array([heard[0][at] for at in shared]) - 23.0
    assert abs(draws.std() - 0.5) < 5 * 0.5 / sqrt(2 * draws.size) and abs(draws.mean()) < 5 * 0.5 / sqrt(draws.size)
    assert first.temperature.last.variance == 0.25
    steps = np.array(first.displacement.values) / 1e-5
    assert np.allclose(steps, np.round(steps), atol=1e-6) and len(set(np.round(steps))) > 10


def test_a_real_time_factor_sets_the_pace(bench):
    sim = Muscles(bench, 'paced', numbers=(), real_time_factor=5.0).speaking()
    bench.until(lambda: len(sim.joints) > 50, 'too few ticks')
    begun = len(sim.joints)
    bench.until(lambda: stamp(sim.joints.last) - stamp(sim.joints[begun - 1][1]) > 5e9, 'too slow')
    bench.until(lambda: best_pace(sim.joints[begun:]) > 2.5, 'no second of it is hurried')
    sim.end()
    heard = sim.joints[:]
    (came, first), (ended, last) = heard[begun], heard[-1]
    # A busy machine may make it slower, never faster: but the first may have come late, by no more than we were silent,
    # and what was lost in less than 0.1 s is run after.
    pause = max(b - a for (a, _), (b, _) in pairwise(heard))
    assert (stamp(last) - stamp(first)) * 1e-9 <= 5.0 * (ended - came + 0.1 + pause)


def best_pace(heard):
    """The fastest that about one second of stamps went by."""
    marks = []
    for came, message in heard:
        if not marks or stamp(message) - marks[-1][1] >= 10**9:
            marks.append((came, stamp(message)))
    return max(((then - at) * 1e-9 / (b - a) for (a, at), (b, then) in pairwise(marks)), default=0.0)


def test_it_follows_a_clock_that_is_not_its_own_also_back_and_far_ahead(bench):
    sim = Muscles(bench, 'timed', numbers=('current',), use_sim_time=True, command_timeout_s=0.0)
    diagnostics = bench.listen('/diagnostics', DiagnosticArray)
    clock = bench.node.create_publisher(Clock, '/clock', 10)
    now = [100.0]

    def advance(step=0.02):
        now[0] += step
        message = Clock()
        message.clock.sec, message.clock.nanosec = int(now[0]), round((now[0] % 1.0) * 1e9)
        clock.publish(message)
        time.sleep(0.01)

    def facts():
        found = [
            {value.key: value.value for value in status.values}
            for _, array in diagnostics
            for status in array.status
            if status.name == '/timed/sim_node'
        ]
        return found[-1] if found else {}

    def has_heard(condition, otherwise):
        def heard():
            advance(0.0)  # a clock goes on speaking: of its messages, which nobody acknowledges, one may be lost
            return condition()

        bench.until(heard, otherwise)

    bench.until(clock.get_subscription_count, 'it does not listen to /clock')
    while not sim.joints:
        advance()
    command, deadline = bench.speaker('/timed/current_command'), time.monotonic() + 60.0
    while sim.temperature.last.temperature < 24.0:
        command.publish(Float64(data=0.2))  # the first may come before the node has met its publisher
        advance()
        assert time.monotonic() < deadline, 'it does not warm up'
    steady = now[0]  # until here it may have been catching up with what it met late
    for _ in range(40):
        advance()
        has_heard(lambda: stamp(sim.joints.last) > (now[0] - 0.03) * 1e9, 'it falls behind')
    stamps = sorted({stamp(message) for _, message in sim.joints if stamp(message) > steady * 1e9})
    apart = [b - a for a, b in pairwise(stamps)]
    assert apart.count(10_000_000) > 0.9 * len(apart), 'two ticks for each step of the clock'
    for jump in (-50.0, 1000.0):
        counted = int(facts().get('clock_jumps', 0))  # a machine that stood still for a second has one already
        before = sim.temperature.last.temperature
        advance(jump)
        landed = now[0]
        has_heard(lambda: abs(stamp(sim.joints.last) * 1e-9 - now[0]) < 0.1, 'it does not go along')
        for _ in range(10):
            advance()
        has_heard(lambda landed=landed: stamp(sim.joints.last) * 1e-9 > landed + 0.15, 'it stands still')
        assert 0.0 < sim.temperature.last.temperature - before < 1.5, 'nothing but the ticks counts'
        assert sim.current.last.data == 0.2
        bench.until(lambda counted=counted: int(facts().get('clock_jumps', 0)) > counted, 'not counted')
        assert facts()['skipped_steps'] == facts()['clock_jumps']
    bench.until(lambda: 'the clock jumped' in sim.program.said(), 'not said')
    sim.end()
    bench.forget(diagnostics)


@pytest.mark.long
def test_a_first_start_says_that_it_compiles_and_how_far_it_is_and_ends_at_once_when_asked(bench, tmp_path):
    """With an empty cache of compiled code; test_serial_driver.py has a node that needs none."""
    program = bench.start_uncompiled('sim_node', 'first_start', tmp_path)
    bench.until(lambda: 'compiling, 1 of 5: ' in program.said(), 'it compiles in silence', 120.0)
    assert 'compiling the model for this machine, 15 to 40 s; later starts find it' in program.said()
    assert program.end(signal.SIGINT) == 0
    assert 'Traceback' not in program.said()

"""What can go wrong with two processes and a muscle between them, done to real processes. In the end: 0 A."""

import signal
import time
from math import inf, nan

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

pytestmark = pytest.mark.processes

TIMEOUT = 0.5  # s, sim_node's default
# The last command's age at the moment, two ticks, and what was under way; a pause that was heard comes on top.
MARGIN = 0.06  # s
FLOOD_OF = 30_000

FLOOD = """
import sys, time
import rclpy
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64
rclpy.init()
node = rclpy.create_node('flood')
publisher = node.create_publisher(Float64, sys.argv[1], QoSProfile(depth=1))
while not publisher.get_subscription_count():
    time.sleep(0.01)
message, begun, sent = Float64(data=0.1), time.monotonic(), 0
while sent < int(sys.argv[2]):
    while sent < min((time.monotonic() - begun) * 10_000, int(sys.argv[2])):
        publisher.publish(message)
        sent += 1
    time.sleep(0.0005)
print('sent', flush=True)
"""


def diagnostics_of(heard, name):
    """The values of the latest diagnostics of a node, by key."""
    for _, array in reversed(heard):
        for status in array.status:
            if status.name == name:
                return {'message': status.message, 'level': status.level, **{v.key: v.value for v in status.values}}
    return {}


@pytest.fixture(scope='module')
def sim(bench):
    """One simulated muscle that most of these tests share; each leaves it enabled, cool and without a fault."""

    class Sim:
        program = bench.start('sim_node', 'sim')
        current = bench.listen('/sim/current')
        diagnostics = bench.listen('/diagnostics', DiagnosticArray)
        command = bench.speaker('/sim/current_command')

        def facts(self):
            return diagnostics_of(self.diagnostics, '/sim/sim_node')

    made = Sim()
    bench.until(lambda: made.current, 'sim_node publishes nothing', 120.0)
    return made


def test_a_commander_that_falls_silent_leaves_zero_within_the_watchdog_time_and_may_come_back(bench, sim):
    with bench.repeating(sim.command, 0.2):
        bench.until(lambda: sim.current.last.data == 0.2, 'the command is not applied')
    silent = time.monotonic()
    bench.until(lambda: sim.current.last.data == 0.0, 'the watchdog does not bite', 5.0)
    pause = sim.current.pause(silent)
    assert 0.3 - pause < sim.current.flowing_for(silent) < TIMEOUT + MARGIN + pause
    sim.command.publish(Float64(data=0.1))
    bench.until(lambda: sim.current.last.data == 0.1, 'the next command is not applied')
    bench.until(lambda: sim.facts().get('state') == 'timed out', 'the diagnostics do not say so', 5.0)
    assert sim.facts()['message'].startswith('timed out, no command for 0.5 s')


@pytest.mark.parametrize('broken', [nan, inf, -inf, 1e308, -0.1])
def test_a_command_that_is_no_usable_number_neither_counts_nor_keeps_the_last_one_alive(bench, sim, broken):
    with bench.repeating(sim.command, 0.2):
        bench.until(lambda: sim.current.last.data == 0.2, 'the command is not applied')
    begun = time.monotonic()
    with bench.repeating(sim.command, broken):
        bench.until(lambda: sim.current.last.data != 0.2, 'the broken command keeps the last one alive', 5.0)
        assert sim.current.last.data == 0.0
        assert sim.current.flowing_for(begun) < TIMEOUT + MARGIN + sim.current.pause(begun)
        count = int(sim.facts().get('rejected_commands', 0))
        bench.until(lambda: int(sim.facts()['rejected_commands']) > count, 'not counted', 5.0)
    assert all(0.0 <= value <= 0.27 for value in sim.current.values)
    assert sim.program.process.poll() is None


def test_a_flood_of_ten_thousand_commands_a_second_changes_nothing(bench, sim):
    ticks = len(sim.current)
    begun = time.monotonic()
    flood = bench.run(['-c', FLOOD, '/sim/current_command', str(FLOOD_OF)], 'flood')
    bench.until(lambda: sim.current.last.data == 0.1, 'the flood is not heard')
    response = bench.call(SetBool, '/sim/sim_node/enable', data=True)
    assert response.success, 'no service while flooded'
    ended = bench.until(lambda: 'sent' in flood.said(), 'the flood does not end', 60.0)
    bench.until(lambda: sim.current.last.data == 0.0, 'the watchdog does not bite', 5.0)
    assert sim.current.flowing_for(ended) < TIMEOUT + MARGIN + sim.current.pause(ended)
    # 100 Hz throughout: what the flood delays is made up for or counted, and most is in time.
    assert len(sim.current) - ticks > 0.8 * 100.0 * (ended - begun - sim.current.pause(begun))
    bench.until(lambda: flood.process.poll() == 0, 'who made the flood does not end')


def test_disable_is_obeyed_at_once_and_enable_begins_at_zero(bench, sim):
    with bench.repeating(sim.command, 0.2):
        bench.until(lambda: sim.current.last.data == 0.2, 'the command is not applied')
        response = bench.call(SetBool, '/sim/sim_node/enable', data=False)
        assert response.success and response.message == 'disabled, 0 A'
        disabled = time.monotonic()
        bench.until(lambda: len(sim.current.from_zero(disabled)) > 30, 'nothing is published while disabled')
        assert set(sim.current.from_zero(disabled)) == {0.0}
        assert sim.current.flowing_for(disabled) < MARGIN + sim.current.pause(disabled)
        bench.call(SetBool, '/sim/sim_node/enable', data=True)
        bench.until(lambda: sim.current.last.data == 0.2, 'enabling does nothing')


@pytest.fixture
def hot(bench, sim):
    """What heats the room of the muscle. Afterwards it is cool, has the limits it had, and no fault: a rerun counts."""
    ambient = bench.speaker('/sim/ambient_temperature', Temperature)
    temperature = bench.listen('/sim/temperature', Temperature)
    yield ambient, temperature
    room = Temperature(temperature=23.0)
    bench.insist(ambient, room, lambda: temperature.last.temperature < 90.0, 'it does not cool')
    set_parameters(bench, '/sim/sim_node', max_temperature_c=115.0, derate_temperature_c=100.0)
    sim.command.publish(Float64(data=0.0))
    bench.until(lambda: bench.call(Trigger, '/sim/sim_node/clear_fault').success, 'cannot be cleared', 5.0)
    bench.forget(temperature)


def test_heat_derates_then_latches_and_is_cleared_only_when_all_is_well(bench, sim, hot):
    ambient, temperature = hot
    with bench.repeating(sim.command, 0.2) as change:
        hottest = Temperature(temperature=100.0)  # the bounds of an ambient end here; 0.2 A adds the rest
        bench.insist(ambient, hottest, lambda: sim.facts().get('state') == 'derating', 'no derating')
        assert float(sim.facts()['current_limit_a']) < 0.27
        # Derating alone holds the muscle below the maximum. The fault comes where a limit is set below what it has.
        bench.until(lambda: temperature.last.temperature > 101.0, 'it does not heat')
        assert set_parameters(bench, '/sim/sim_node', derate_temperature_c=80.0, max_temperature_c=100.0) == ''
        bench.until(lambda: sim.facts().get('state') == 'fault', 'no fault')
        latched = time.monotonic()
        refused = bench.call(Trigger, '/sim/sim_node/clear_fault')
        assert not refused.success and refused.message.startswith('the cause is still there: over-temperature')
        room = Temperature(temperature=23.0)
        bench.insist(ambient, room, lambda: temperature.last.temperature < 90.0, 'it does not cool')
        refused = bench.call(Trigger, '/sim/sim_node/clear_fault')
        assert not refused.success and refused.message == 'the command is 0.2 A: command 0 first'
        refused = bench.call(SetBool, '/sim/sim_node/enable', data=True)
        assert not refused.success and 'fault latched' in refused.message
        assert set(sim.current.from_zero(latched)) == {0.0}
        assert sim.current.flowing_for(latched) < MARGIN + sim.current.pause(latched)
        change(0.0)
        cleared = []
        bench.until(
            lambda: cleared.append(bench.call(Trigger, '/sim/sim_node/clear_fault')) or cleared[-1].success,
            'cannot be cleared',
            5.0,
        )
        assert cleared[-1].message == 'fault cleared'
        assert bench.call(Trigger, '/sim/sim_node/clear_fault').message == 'there was no fault'
        change(0.1)
        bench.until(lambda: sim.current.last.data == 0.1, 'the muscle does not work again')
    assert set_parameters(bench, '/sim/sim_node', max_temperature_c=115.0, derate_temperature_c=100.0) == ''
    assert 'fault latched, 0 A: over-temperature' in sim.program.said()
    assert "parameter 'max_temperature_c' is 100 now, was 115" in sim.program.said()


def set_parameters(bench, node, **values):
    """Set them together; returns why that was refused, '' where it was not."""
    response = bench.call(
        SetParametersAtomically,
        f'{node}/set_parameters_atomically',
        parameters=[Parameter(name, value=value).to_parameter_msg() for name, value in values.items()],
    )
    return response.result.reason


# Both nodes


@pytest.fixture
def loop(bench, request):
    """A muscle and its controller, holding 10 mm; namespaces are those of the test."""
    namespace = request.node.name.replace('[', '_').rstrip(']').replace('-', '_')[:60]

    class Loop:
        def __init__(self):
            self.namespace = namespace
            self.sim = bench.start('sim_node', namespace)
            self.controller = bench.start('controller_node', namespace)
            self.current = bench.listen(f'/{namespace}/current')
            self.command = bench.listen(f'/{namespace}/current_command')
            self.displacement = bench.listen(f'/{namespace}/displacement')
            self.setpoint = bench.speaker(f'/{namespace}/displacement_setpoint')
            bench.until(lambda: self.displacement and self.command, 'no messages', 120.0)
            self.setpoint.publish(Float64(data=0.01))

        def works(self):
            bench.until(
                lambda: self.current.last.data > 0.05 and self.displacement.last.data > 0.001, 'the loop does not heat'
            )

        def end(self):
            for program in (self.controller, self.sim):
                if program.process.poll() is None:
                    program.kill()

    made = Loop()
    yield made
    made.end()


def test_kill_9_of_the_controller_leaves_zero_within_the_watchdog_time(bench, loop):
    loop.works()
    loop.controller.kill()
    killed = time.monotonic()
    bench.until(lambda: loop.current.last.data == 0.0, 'the current stays on', 5.0)
    pause = loop.current.pause(killed)
    assert 0.3 - pause < loop.current.flowing_for(killed) < TIMEOUT + MARGIN + pause
    bench.until(lambda: 'no command for 0.5 s' in loop.sim.said(), 'nothing is said', 5.0)
    assert loop.sim.said().count('no command for 0.5 s') == 1


def test_kill_9_of_the_muscle_takes_the_controller_to_zero_and_it_recovers(bench, loop):
    loop.works()
    loop.sim.kill()
    killed = time.monotonic()
    zero = bench.until(lambda: loop.command.last.data == 0.0, 'the command stays on', 5.0)
    assert loop.command.flowing_for(killed) < 0.2 + MARGIN + loop.command.pause(killed)
    bench.until(lambda: len(loop.command.since(zero)) > 50, 'the controller does not go on')
    assert {message.data for message in loop.command.since(zero)} == {0.0}
    loop.sim = bench.start('sim_node', loop.namespace)
    loop.works()
    bench.until(lambda: abs(loop.displacement.last.data - 0.01) < 2e-4, 'it does not reach its setpoint again')


@pytest.mark.parametrize(
    'signals', [(signal.SIGINT,), (signal.SIGTERM,), (signal.SIGINT, signal.SIGINT)], ids=['INT', 'TERM', 'INT_INT']
)
def test_a_signal_ends_both_nodes_with_zero_as_the_last_word(bench, loop, signals):
    loop.works()
    loop.setpoint.publish(Float64(data=0.04))  # full current when the signal comes
    bench.until(lambda: loop.command.last.data > 0.2 and loop.current.last.data > 0.2, 'no current')
    assert loop.controller.end(*signals) == 0
    # What was acknowledged is on its way to our callback.
    bench.until(lambda: loop.command.last.data == 0.0, 'the last command is not 0 A', 2.0)
    assert loop.sim.end(*signals) == 0
    bench.until(lambda: loop.current.last.data == 0.0, 'the last current is not 0 A', 2.0)
    for program in (loop.sim, loop.controller):
        assert 'Traceback' not in program.said() and 'Error' not in program.said(), program.said()


@pytest.mark.parametrize('signals', [(signal.SIGINT,), (signal.SIGINT, signal.SIGINT)], ids=['INT', 'INT_INT'])
def test_a_driving_current_ends_with_sim_node(bench, signals):
    # The commander goes on: the last word must come from the node that ends, not from the watchdog.
    namespace = f'driven_{len(signals)}'
    program = bench.start('sim_node', namespace)
    current = bench.listen(f'/{namespace}/current')
    with bench.repeating(bench.speaker(f'/{namespace}/current_command'), 0.2):
        bench.until(lambda: current and current.last.data == 0.2, 'no current')
        assert program.end(*signals) == 0
        bench.until(lambda: current.last.data == 0.0, 'the last current is not 0 A', 2.0)
    assert 'Traceback' not in program.said()

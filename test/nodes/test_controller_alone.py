"""The controller's node in this process, with a muscle that it drives tick by tick: what keeps it from burning."""

import os
from math import inf, nan
from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

import rclpy
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import Float64

from tcp_muscle_ros.muscle import ZERO_CELSIUS, Muscle
from tcp_muscle_ros.nodes import mixing
from tcp_muscle_ros.nodes.controller_node import ControllerNode
from tcp_muscle_ros.nodes.sim_node import SimNode
from tcp_muscle_ros.settings.parameter_file import write

ANTAGONIST = ('--params-file', 'config/antagonist.yaml', '-p', 'command_timeout_s:=0.0')
PERIOD = 0.01  # s
_LEFT = []  # nodes: kept, so that nothing destroys them (see conftest.py)


@pytest.fixture
def begun(request):
    """ROS with these arguments, and a clock that the test sets."""
    rclpy.init(args=['--ros-args', *request.param], domain_id=1 + (os.getpid() + 67) % 100)
    clock = SimpleNamespace(now=0.0)

    def made(kind):
        node = kind()
        node.time_base.seconds = lambda: clock.now
        _LEFT.append(node)
        return node

    yield made, clock
    rclpy.try_shutdown()


class Driven:
    """A muscle (``off`` times what the controller believes it to be) and the controller that drives it."""

    def __init__(self, begun, **off):
        made, self._clock = begun
        self.node = made(ControllerNode)
        (self.controlled,) = self.node.muscles
        model = self.controlled.settings.muscle()
        model = model.replace({name: factor * model[name] for name, factor in off.items()})
        settings = self.controlled.settings
        self._muscle = Muscle(model, load=settings['load_n'], ambient=settings.kelvin('ambient_temperature_c'))
        self.hottest = 0.0  # degC

    def runs(self, seconds, shows, every=1, thermometer=0, current=None):
        """So long, with a displacement as the sensor ``shows`` it at every so many ticks (0: at none)."""
        for k in range(round(seconds / PERIOD)):
            self._clock.now += PERIOD
            flows = self.controlled.safety.current if current is None else current
            reading = self._muscle.step(PERIOD, flows)
            self.hottest = max(self.hottest, reading.fibre_temperature - ZERO_CELSIUS)
            if every and k % every == 0:
                self.controlled.take_measurement(shows(reading))
            if thermometer and k % thermometer == 0:
                self.controlled._take_temperature(Temperature(temperature=reading.temperature - ZERO_CELSIUS))
            self.controlled._take_current(Float64(data=flows))
            self.controlled.work(PERIOD, self._clock.now, True)


def tenth(reading):
    """What a jammed end shows."""
    return 0.1 * reading.displacement


STRONG = ('-p', 'current_limit_a:=0.4')


@pytest.mark.parametrize('begun', [STRONG], indirect=True)
@pytest.mark.parametrize('what', ['gap', 'parameter'])
def test_what_has_flowed_has_heated_the_muscle_whatever_happens_to_the_feedback(begun, what):
    """Without a thermometer the model's heat is all that keeps it below 100 degC."""
    driven = Driven(begun)
    driven.controlled._setpoint = 0.05
    driven.runs(60.0, tenth)
    for k in range(8):
        if what == 'gap':
            driven.runs(0.25, tenth, every=0)
        else:
            driven.node.set_parameters([Parameter('time_constant_s', value=0.071 + 0.001 * k)])
        driven.runs(2.0, tenth)
    assert 95.0 < driven.hottest < 100.5


@pytest.mark.parametrize('begun', [('-p', 'load_n:=3.0')], indirect=True)
def test_what_softening_puts_out_of_reach_under_a_heavy_load_is_refused(begun):
    driven = Driven(begun)
    controlled = driven.controlled
    controlled.take_setpoint(Float64(data=0.0155))
    controlled.take_setpoint(Float64(data=0.0175))
    assert controlled._setpoint == 0.0155 and controlled.refused_inputs == {'displacement_setpoint': 1}
    driven.runs(40.0, lambda reading: reading.displacement)
    assert controlled._watch.value == pytest.approx(0.0155, abs=2e-5)
    controlled._take_load(Float64(data=0.5))
    controlled.take_setpoint(Float64(data=0.0175))
    assert controlled._setpoint == 0.0175, 'a lighter load gives way further'


@pytest.mark.parametrize('begun', [STRONG], indirect=True)
def test_a_sensor_that_is_stuck_and_slower_than_the_timeout_does_not_burn_the_muscle(begun):
    driven = Driven(begun)
    driven.controlled._setpoint = 0.05
    driven.runs(60.0, lambda _: 0.0, every=25)
    assert driven.hottest < 100.5


@pytest.mark.parametrize('begun', [()], indirect=True)
def test_a_coarse_sensor_that_is_off_is_not_called_frozen_after_a_gap(begun):
    """At rest it says the same again, and the model, which goes on through a gap, is that much off."""
    driven = Driven(begun)
    driven.controlled._setpoint = 0.0

    def coarse(reading):
        return round((reading.displacement + 0.5e-3) / 2e-5) * 2e-5

    driven.runs(10.0, coarse)
    driven.runs(0.6, coarse, every=0)
    assert driven.controlled.silent
    for _ in range(50):
        driven.runs(0.1, coarse)
        assert not driven.controlled.silent


@pytest.mark.parametrize('begun', [STRONG], indirect=True)
def test_a_reset_does_not_cool_a_muscle_that_the_model_says_is_too_hot(begun):
    driven = Driven(begun)
    driven.controlled._setpoint, safety = 0.03, driven.controlled.safety
    for _ in range(600):
        if safety.state.value == 'fault':
            break
        driven.runs(0.1, lambda r: r.displacement, current=0.6)  # the driver gives more than it is asked for
    assert safety.state.value == 'fault'
    driven.controlled.forget()
    driven.runs(0.1, lambda r: r.displacement, current=0.6)
    assert 'the cause is still there' in safety.clear_fault()
    driven.runs(30.0, lambda r: r.displacement)
    assert safety.clear_fault() == '' and driven.controlled._setpoint is None


COLD = ('-p', 'ambient_temperature_c:=15.0')  # where a muscle needs a current to be at 0
PROBING = ('-p', 'feedback:=resistance', '-p', 'probe_current_a:=0.05')  # without a current it is blind


@pytest.mark.parametrize(('begun', 'every'), [(COLD, 1), (PROBING, 0)], indirect=['begun'])
def test_setpoint_0_lets_a_fault_be_cleared_and_no_current_flows_before_another_setpoint(begun, every):
    driven = Driven(begun)
    controlled, safety = driven.controlled, driven.controlled.safety

    def flows_at(setpoint, ticks=100):
        flowed = set()
        for _ in range(ticks):  # as `ros2 topic pub -r` says it, again and again
            controlled.take_setpoint(Float64(data=setpoint))
            driven.runs(PERIOD, lambda r: r.displacement if every else r.resistance, every=every)
            flowed.add(safety.current)
        return flowed != {0.0}

    assert flows_at(0.02)
    safety.trip('too hot')
    for setpoint in (0.0, 0.02, -0.001):
        assert not flows_at(setpoint, 20)
        if setpoint > 0.0:
            assert 'command 0 first' in safety.clear_fault()
    assert safety.clear_fault() == ''
    assert not flows_at(-0.001) and any('let go' in worry for worry in controlled.worries())
    assert flows_at(0.02) and not any('let go' in worry for worry in controlled.worries())
    controlled.take_setpoint(Float64(data=-0.001))
    assert controlled._setpoint == -0.001, 'without a fault it is a setpoint like others'


@pytest.mark.parametrize('begun', [STRONG], indirect=True)
@pytest.mark.parametrize('every', [50, 100])
def test_a_thermometer_of_one_reading_a_second_keeps_a_muscle_from_getting_too_hot(begun, every):
    driven = Driven(begun, hA=0.7, k0=0.9, B=0.7)
    driven.controlled._setpoint = 0.07
    driven.runs(60.0, lambda r: r.displacement, thermometer=every)
    assert 95.0 < driven.hottest < 110.0 and driven.controlled.safety.state.value != 'fault'


@pytest.mark.parametrize('begun', [()], indirect=True)
def test_a_driver_that_is_disabled_is_noticed_by_an_ammeter_whose_zero_is_below_0(begun):
    driven = Driven(begun)
    controlled = driven.controlled
    controlled._setpoint = 0.03
    driven.runs(10.0, lambda reading: reading.displacement, current=-1e-3)
    assert controlled.refuses and not controlled.refused_inputs
    assert controlled._fibre == pytest.approx(23.0 + ZERO_CELSIUS, abs=0.1), 'a cold muscle'


@pytest.mark.parametrize('begun', [()], indirect=True)
def test_what_flows_through_an_ammeter_that_is_the_other_way_round_heats(begun):
    driven = Driven(begun)
    controlled = driven.controlled
    controlled._setpoint = 0.03
    driven.runs(10.0, lambda reading: reading.displacement, current=-0.25)
    assert not controlled.refuses and not controlled.refused_inputs
    assert controlled._fibre - ZERO_CELSIUS == pytest.approx(driven.hottest, abs=0.5)
    assert driven.hottest > 40.0


@pytest.mark.parametrize('begun', [()], indirect=True)
def test_of_what_is_measured_nonsense_is_refused_and_of_a_load_that_is_told_what_is_below_0(begun):
    (muscle,) = begun[0](ControllerNode).muscles
    for value in (nan, -inf, -2e3, 2e3):
        muscle._take_current(Float64(data=value))
        muscle._take_force(Float64(data=value))
    muscle._take_force(Float64(data=-0.4))  # of a cell the wrong way round, which would show none that is slack
    muscle._take_load(Float64(data=-2e-3))
    assert muscle.refused_inputs == {'current': 4, 'force': 5, 'load': 1}
    assert muscle._current.value is muscle._tension.value is muscle._load is None


def turned(controller, simulated, clock, seconds, zero=0.0):
    """The angle that a joint then has, with cells that show so much (N) more than the tension."""
    (joint,) = controller._joints.values()
    (turns,) = simulated._joints
    for _ in range(round(seconds / PERIOD)):
        clock.now += PERIOD
        simulated.work(0, PERIOD, clock.now, False)
        joint._take_angle(Float64(data=turns.joint.angle))
        for muscle, true in zip(controller.muscles, simulated.muscles, strict=True):
            muscle._take_temperature(Temperature(temperature=true._shown[0] - ZERO_CELSIUS))
            muscle._take_force(Float64(data=true._shown[3] + zero))
            muscle._take_current(Float64(data=true.current))
        controller.work(0, PERIOD, clock.now, False)
        for muscle, true in zip(controller.muscles, simulated.muscles, strict=True):
            true.safety.command(muscle.safety.current, clock.now)
    return turns.joint.angle


@pytest.mark.parametrize('begun', [ANTAGONIST], indirect=True)
def test_a_joint_whose_muscles_have_another_model_goes_to_its_angle(begun, tmp_path):
    """What turns a length into a warmth and what turns it back are one model: its errors cancel."""
    made, clock = begun
    controller, simulated = made(ControllerNode), made(SimNode)
    (joint,) = controller._joints.values()
    joint.setpoint = 0.4
    model = controller.muscles[0].settings.muscle()
    write(tmp_path / 'other.yaml', model.replace(B=0.8 * model['B'], k0=0.9 * model['k0']))
    for muscle in controller.muscles:
        path = Parameter(f'{muscle.name}.model_file', value=str(tmp_path / 'other.yaml'))
        assert controller.set_parameters([path])[0].successful
    assert turned(controller, simulated, clock, 90.0) == pytest.approx(0.4, abs=2e-3)


@pytest.mark.parametrize('begun', [ANTAGONIST], indirect=True)
def test_a_slack_muscle_whose_cell_shows_less_than_nothing_does_not_stop_its_joint(begun):
    made, clock = begun
    controller, simulated = made(ControllerNode), made(SimNode)
    (joint,) = controller._joints.values()
    joint.setpoint = 0.2
    turned(controller, simulated, clock, 5.0)
    _, extensor = controller.muscles
    for muscle, shown in zip(controller.muscles, (0.9, -2e-3), strict=True):
        muscle._take_force(Float64(data=shown))
    clock.now += PERIOD
    controller.work(0, PERIOD, clock.now, False)
    assert extensor.tension(clock.now) == 0.0 and not extensor.silent and not joint._idle
    assert turned(controller, simulated, clock, 60.0, zero=-2e-3) == pytest.approx(0.2, abs=2e-3)


@pytest.mark.parametrize('begun', [ANTAGONIST], indirect=True)
def test_what_came_by_topic_stays_where_another_value_is_set(begun):
    controller = begun[0](ControllerNode)
    (joint,) = controller._joints.values()
    joint._take_cocontraction(Float64(data=0.9))
    joint._take_stiffness(Float64(data=0.05))
    controller.set_parameters([Parameter(f'{joint.name}.torque_filter_s', value=0.31)])
    assert (joint._cocontraction, joint._stiffness) == (0.9, 0.05)
    controller.set_parameters([Parameter(f'{joint.name}.cocontraction_n', value=0.7)])
    assert (joint._cocontraction, joint._stiffness) == (0.7, None)


@pytest.mark.parametrize('begun', [()], indirect=True)
def test_a_limit_is_lowered_though_the_file_of_the_model_is_gone_and_no_filter_is_a_filter(begun, tmp_path):
    controller = begun[0](ControllerNode)
    (muscle,) = controller.muscles
    path = tmp_path / 'other.yaml'
    write(path, muscle.settings.muscle())
    assert controller.set_parameters([Parameter('model_file', value=str(path))])[0].successful
    path.unlink()
    for name, value in (('current_limit_a', 0.05), ('pid_filter_time_s', 0.0), ('mode', 'pid')):
        assert controller.set_parameters([Parameter(name, value=value)])[0].successful
    assert muscle.safety.limits.current == 0.05
    assert not controller.set_parameters([Parameter('model_file', value=str(tmp_path / 'never.yaml'))])[0].successful


@pytest.mark.parametrize(
    ('begun', 'topic'), [((), '/displacement'), (ANTAGONIST, '/knuckle/angle')], indirect=['begun']
)
def test_a_second_node_that_publishes_the_feedback_is_a_worry(begun, topic, monkeypatch):
    node = begun[0](ControllerNode)
    ends = [
        SimpleNamespace(node_name=name, node_namespace='/', endpoint_gid=[process] * 16)
        for process, name in enumerate(('sim_node', 'driver'))
    ]
    monkeypatch.setattr(node, 'count_publishers', lambda name: len(ends) if name == topic else 0)
    monkeypatch.setattr(node, 'get_publishers_info_by_topic', lambda name: ends if name == topic else [])
    monkeypatch.setattr(mixing, 'REMEMBERED', 0.0)
    for muscle in node.muscles:
        muscle.look_for_others(node)
        assert any(worry.startswith(f'{topic} is published by /driver and by /sim_node') for worry in muscle.worries())


@pytest.mark.parametrize('begun', [()], indirect=True)
@pytest.mark.parametrize(
    ('names', 'positions', 'goes_to', 'counted'),
    [
        ([], [0.01], None, 1),
        (['tcp_muscle'], [0.01, 0.5], 0.01, 1),
        (['tcp_muscle', 'wheel'], [0.01], 0.01, 1),
        (['tcp_muscle', 'wheel'], [0.01, 0.5], 0.01, 0),
        ([], [], None, 0),
    ],
)
def test_joint_commands_without_a_position_for_each_name_are_counted(begun, names, positions, goes_to, counted):
    node = begun[0](ControllerNode)
    (muscle,) = node.muscles
    node._take_joint_commands(JointState(name=names, position=positions))
    assert muscle._setpoint == goes_to and muscle.refused_inputs['joint_commands'] == counted

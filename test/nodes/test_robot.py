"""The finger in MuJoCo behind the topics: joint commands in, joint states and pictures out, and 0 A in the end."""

import re
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')
pytest.importorskip('mujoco', reason="needs MuJoCo (extra 'mujoco', Python 3.11 and later)")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.time import Time
from sensor_msgs.msg import Image, JointState, Temperature
from std_msgs.msg import Float64
from std_srvs.srv import SetBool

from tcp_muscle_ros.muscle import Muscle, Parameters
from tcp_muscle_ros.nodes.sim_robot import Eye, SimRobot
from tcp_muscle_ros.nodes.ticks import SECOND

pytestmark = pytest.mark.processes
ROOT = Path(__file__).resolve().parents[2]
FINGER = ROOT / 'config' / 'finger.yaml'
JOINTS, MUSCLES = ['knuckle', 'middle'], ['knuckle_flexor', 'knuckle_extensor', 'middle_flexor', 'middle_extensor']


def in_frames_of_the_robot(bench, heard):
    """Whatever the nodes publish with a frame is in a link of the robot's description, as finger.launch.py shows it."""
    links = {link.get('name') for link in ElementTree.parse(ROOT / 'urdf' / 'finger.urdf').getroot().findall('link')}
    kinds = {kind.__module__.split('.')[0] + '/msg/' + kind.__name__: kind for kind in (Temperature, JointState, Image)}
    made = {
        topic.removeprefix('/finger/'): kinds.get(types[0])
        for topic, types in bench.node.get_topic_names_and_types()
        if {one.node_name for one in bench.node.get_publishers_info_by_topic(topic)} & {'sim_node', 'controller_node'}
        and types[0].split('/')[0] in ('sensor_msgs', 'geometry_msgs', 'std_msgs')
        and types[0] != 'std_msgs/msg/Float64'
    }
    assert len(made) == 2 + 2 * len(MUSCLES) and all(made.values()), made
    more = {topic: bench.listen(f'/finger/{topic}', kind) for topic, kind in made.items() if topic not in heard}
    for topic, messages in {**heard, **more}.items():
        bench.until(lambda messages=messages: messages, f'nothing on {topic}')
        assert messages.last.header.frame_id in links, f'{topic}: no link is called {messages.last.header.frame_id!r}'
    bench.forget(*more.values())


def test_it_goes_where_it_is_told_is_seen_and_ends_without_current(bench):
    file, weight = ['--params-file', str(FINGER)], f'description_file:={ROOT / "urdf" / "finger.urdf"}'
    nodes = [
        bench.start('sim_node', 'finger', *file),
        bench.start('controller_node', 'finger', *file, '-p', weight),  # as finger.launch.py does
    ]
    states = bench.listen('/finger/joint_states', JointState)
    images = bench.listen('/finger/camera/image', Image)
    currents = {name: bench.listen(f'/finger/{name}/current') for name in MUSCLES}
    command = bench.speaker('/finger/joint_commands', JointState)
    torque = bench.speaker('/finger/knuckle/external_torque')
    told = JointState(name=JOINTS, position=[-0.1, 0.25])

    def angles():
        return dict(zip(states.last.name, states.last.position, strict=True)) if states else dict.fromkeys(JOINTS, 9.0)

    def there():
        shown = angles()
        return all(abs(shown[joint] - at) < 0.02 for joint, at in zip(JOINTS, told.position, strict=True))

    with bench.repeating(command, told, rate=20.0):
        bench.until(there, 'not reached')
        assert states.last.name == [*MUSCLES, *JOINTS]
        shown = dict(zip(states.last.name, states.last.position, strict=True))
        assert shown['knuckle_flexor'] == pytest.approx(0.01 * shown['knuckle'], abs=1e-4)

        bench.until(lambda: images, 'no picture')
        in_frames_of_the_robot(bench, {'camera/image': images, 'joint_states': states})
        picture = images.last
        assert (picture.width, picture.height, picture.encoding, picture.step) == (320, 200, 'rgb8', 960)
        assert np.frombuffer(picture.data, dtype=np.uint8).std() > 10.0
        bench.forget(images)  # none is drawn where nobody looks

        torque.publish(Float64(data=0.004))  # pushed towards the palm: it gives way, and comes back under the push
        bench.until(lambda: angles()['knuckle'] > 0.0, 'the push is not felt')
        bench.until(there, 'not held against the push')

        bench.call(SetBool, '/finger/sim_node/knuckle_flexor/enable', data=False)  # as if its wire were cut
        bench.until(lambda: angles() and currents['knuckle_flexor'].last.data == 0.0, 'current in a muscle that is off')
    nodes[1].kill()
    bench.until(lambda: all(heard.last.data == 0.0 for heard in currents.values()), 'current without a controller')
    assert nodes[0].end(2) == 0, nodes[0].said()


@pytest.mark.long
def test_a_setpoint_beyond_the_ball_is_said_not_to_be_reached_and_the_documents_is(bench):
    file = ['--params-file', str(FINGER)]
    nodes = [bench.start(name, 'finger', *file) for name in ('sim_node', 'controller_node')]
    states, diagnostics = (
        bench.listen('/finger/joint_states', JointState),
        bench.listen('/diagnostics', DiagnosticArray),
    )
    command = bench.speaker('/finger/joint_commands', JointState)

    def angle():
        return states.last.position[states.last.name.index('knuckle')] if states else 9.0

    def status():
        found = [s for _, array in list(diagnostics)[-20:] for s in array.status if s.name.endswith('node/knuckle')]
        return found[-1] if found else DiagnosticStatus()

    def told(text):
        names, position = re.search(r"JointState '{name: \[(.*?)\], position: \[(.*?)\]}'", text).groups()
        return JointState(name=names.split(', '), position=[float(each) for each in position.split(', ')])

    with bench.repeating(command, JointState(name=JOINTS, position=[0.3, 0.5]), rate=20.0):
        bench.until(lambda: 'is not reached' in status().message, 'not said', 60.0)
        assert re.fullmatch(
            r'setpoint 0\.3 rad is not reached: 0\.0[67]\d* rad, knuckle_flexor at its current limit', status().message
        )
        assert status().level == DiagnosticStatus.WARN
    document = told((ROOT / 'docs' / 'robots.md').read_text(encoding='utf-8'))
    with bench.repeating(command, document, rate=20.0):
        wanted = document.position[document.name.index('knuckle')]
        bench.until(lambda: abs(angle() - wanted) < 0.002, "the document's setpoint is not reached", 60.0)
        bench.until(lambda: status().message == 'driven' and status().level == DiagnosticStatus.OK, 'still said', 5.0)
    assert [node.end(2) for node in nodes] == [0, 0]


@pytest.mark.parametrize('dt', [0.001, 0.0032, 0.01])
def test_a_velocity_is_that_of_the_simulators_time_at_any_rate_of_ticks(dt):
    """Ticks of which some see no step of the simulator, or one more than the last, are no jerks of the muscle."""
    model = Parameters.named('karami_tadesse_2017')
    muscles = {name: SimpleNamespace(muscle=Muscle(model, end='blocked', load=0.4)) for name in MUSCLES}
    it = SimRobot('finger', muscles)
    for _ in range(round(1.5 / dt)):
        it.step(dt, [0.25, 0.0, 0.25, 0.0])
    seen = [it.step(dt, [0.25, 0.0, 0.25, 0.0])[2].velocity for _ in range(6)]
    arm, turned = it.robot.moment_arm('middle_flexor', 'middle'), it.robot.data.qvel[it.robot.speed_place('middle')]
    assert abs(arm * turned) > 1e-3
    assert seen == pytest.approx([arm * turned] * 6, rel=0.1)


@pytest.mark.parametrize('reached', [0, 12 * SECOND + 340_000_000])
def test_a_picture_is_of_the_time_of_the_ticks(reached):
    """Which a simulation that is faster than the clock on the wall has for itself."""
    seen = []
    node = SimpleNamespace(
        topics=SimpleNamespace(
            publisher=lambda *_: SimpleNamespace(get_subscription_count=lambda: 1, publish=seen.append)
        ),
        create_timer=lambda *_, **__: None,
        lock=nullcontext(),
        time_base=SimpleNamespace(now=lambda: reached),
        get_clock=lambda: Clock(clock_type=ClockType.SYSTEM_TIME),
    )
    eye = Eye(
        node,
        SimpleNamespace(robot=SimpleNamespace(still=dict)),
        {'image_width': 3, 'image_height': 2, 'image_rate_hz': 5.0},
    )
    eye._camera = SimpleNamespace(picture=lambda _: np.zeros((2, 3, 3), np.uint8))
    eye._look()
    assert [Time.from_msg(picture.header.stamp).nanoseconds for picture in seen] == [reached]


@pytest.mark.parametrize(
    ('given', 'line'),
    [
        (['robot:=fingr'], "unknown robot 'fingr'; did you mean 'finger'"),
        (['robot:=arm'], "the robot has no tendon 'knuckle_flexor'"),
        (['knuckle.radius_m:=0.02'], "knuckle: parameter 'radius_m' is 0.02, but 'knuckle_flexor' pulls"),
        (['knuckle_flexor.end:=load'], "knuckle_flexor: parameter 'end' is 'load'"),
    ],
)
def test_what_does_not_fit_is_one_line(given, line):
    arguments = [word for one in given for word in ('-p', one)]
    command = ['-m', 'tcp_muscle_ros.nodes.sim_node', '--ros-args', '--params-file', str(FINGER), *arguments]
    done = subprocess.run([sys.executable, *command], capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert line in done.stderr and 'Traceback' not in done.stderr

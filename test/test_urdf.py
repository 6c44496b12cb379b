"""The URDF is the contract's joint, and its ros2_control block speaks the contract's topics."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[1]
xacro = pytest.importorskip('xacro', reason='xacro comes with ROS 2 or with requirements/test.txt')


def expanded(**arguments):
    document = xacro.process_file(str(ROOT / 'urdf' / 'tcp_muscle.urdf.xacro'), mappings=arguments)
    return ElementTree.fromstring(document.toxml())


@pytest.fixture
def robot():
    return expanded(name='finger_1', namespace='/finger_1', length='0.2', stroke='0.05')


def test_position_is_contraction(robot):
    joint = robot.find("joint[@name='finger_1']")
    assert joint.get('type') == 'prismatic'
    # The moving end hangs below and rises when the position grows.
    assert [float(x) for x in joint.find('origin').get('xyz').split()] == [0.0, 0.0, -0.2]
    assert [float(x) for x in joint.find('axis').get('xyz').split()] == [0.0, 0.0, 1.0]
    limit = joint.find('limit')
    assert (float(limit.get('lower')), float(limit.get('upper'))) == (0.0, 0.05)


def test_it_is_one_tree(robot):
    links = {link.get('name') for link in robot.findall('link')}
    joints = robot.findall('joint')
    children = [joint.find('child').get('link') for joint in joints]
    assert len(children) == len(set(children))
    assert {joint.find('parent').get('link') for joint in joints} <= links
    assert links - set(children) == {'world'}


def test_ros2_control_goes_over_the_topics(robot):
    control = robot.find('ros2_control')
    hardware = control.find('hardware')
    assert hardware.findtext('plugin') == 'joint_state_topic_hardware_interface/JointStateTopicSystem'
    parameters = {param.get('name'): param.text for param in hardware.findall('param')}
    assert parameters == {
        'joint_commands_topic': '/finger_1/joint_commands',
        'joint_states_topic': '/finger_1/joint_states',
        # Anything else stops sending while a setpoint is held, which looks like a dead commander.
        'trigger_joint_command_threshold': '-1',
    }
    joint = control.find('joint')
    assert joint.get('name') == 'finger_1'
    assert [interface.get('name') for interface in joint.findall('command_interface')] == ['position']
    assert [interface.get('name') for interface in joint.findall('state_interface')] == [
        'position',
        'velocity',
        'effort',
    ]


def test_defaults_are_the_papers_muscle_under_60_g():
    robot = expanded()
    joint = robot.find("joint[@name='tcp_muscle']")
    # 150 mm, and 60 g on 23 N/m.
    rest = 0.150 + 0.060 * 9.80665 / 23.0
    assert -float(joint.find('origin').get('xyz').split()[2]) == pytest.approx(rest, abs=1e-4)

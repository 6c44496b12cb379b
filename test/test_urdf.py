"""The URDF is the contract's joint, and its ros2_control block speaks the contract's topics."""

from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
xacro = pytest.importorskip('xacro', reason='xacro comes with ROS 2 or with requirements/test.txt')


def expanded(file='tcp_muscle.urdf.xacro', **arguments):
    document = xacro.process_file(str(ROOT / 'urdf' / file), mappings=arguments)
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


def test_the_frame_of_stamped_messages_is_a_link():
    """As nodes/safe_muscle.py makes it of joint_name: the end that moves."""
    source = (ROOT / 'tcp_muscle_ros' / 'nodes' / 'safe_muscle.py').read_text(encoding='utf-8')
    assert """f'{settings["joint_name"]}_moving_end'""" in source
    for name in ('tcp_muscle', 'finger_1'):
        assert f'{name}_moving_end' in {link.get('name') for link in expanded(name=name).findall('link')}


@pytest.mark.parametrize(('file', 'root'), [('tcp_muscle.urdf.xacro', 'world'), ('antagonist.urdf.xacro', 'palm')])
def test_it_is_one_tree(file, root):
    robot = expanded(file)
    links = {link.get('name') for link in robot.findall('link')}
    joints = robot.findall('joint')
    children = [joint.find('child').get('link') for joint in joints]
    assert len(children) == len(set(children))
    assert {joint.find('parent').get('link') for joint in joints} <= links
    assert links - set(children) == {root}


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


DESCRIPTIONS = sorted(path.name for ending in ('urdf', 'urdf.xacro') for path in (ROOT / 'urdf').glob(f'*.{ending}'))


@pytest.mark.parametrize('file', DESCRIPTIONS)
def test_without_a_namespace_its_topics_are_not_those_of_joint_state_broadcaster(file):
    """Which says /joint_states of all joints: a robot that read them there would hear itself."""
    assert {'arm.urdf', 'finger.urdf', 'antagonist.urdf.xacro', 'tcp_muscle.urdf.xacro'} <= set(DESCRIPTIONS)
    robot = expanded(file)
    hardware = robot.findall('ros2_control/hardware')
    assert len(hardware) == 1
    topics = {param.get('name'): param.text for param in hardware[0].findall('param')}
    place = robot.get('name')
    assert place
    assert topics['joint_states_topic'] == f'/{place}/joint_states'
    assert topics['joint_commands_topic'] == f'/{place}/joint_commands'


def test_the_controllers_are_for_the_joint_of_the_urdf():
    controllers = yaml.safe_load((ROOT / 'config' / 'controllers.yaml').read_text())
    joint = expanded().find('ros2_control/joint')
    own = controllers['muscle_position_controller']['ros__parameters']
    assert own['joints'] == [joint.get('name')]
    assert own['interface_name'] in {one.get('name') for one in joint.findall('command_interface')}
    kinds = {
        k: v['type'] for k, v in controllers['controller_manager']['ros__parameters'].items() if k != 'update_rate'
    }
    packages = {kind.partition('/')[0] for kind in kinds.values()} | {'joint_state_topic_hardware_interface'}
    depends = {one.text for one in ElementTree.parse(ROOT / 'package.xml').getroot().findall('exec_depend')}
    assert packages <= depends


def test_defaults_are_the_papers_muscle_under_60_g():
    robot = expanded()
    joint = robot.find("joint[@name='tcp_muscle']")
    # 150 mm, and 60 g on 23 N/m.
    rest = 0.150 + 0.060 * 9.80665 / 23.0
    assert -float(joint.find('origin').get('xyz').split()[2]) == pytest.approx(rest, abs=1e-4)


def test_the_antagonist_is_the_joint_of_its_parameter_file():
    """Names, radius, stops, inertia and lengths; and the flexor's end rises where the joint turns positive."""
    from tcp_muscle_ros.muscle import Parameters, length

    values = yaml.safe_load((ROOT / 'config' / 'antagonist.yaml').read_text())['/**']['ros__parameters']
    joint, robot = values['knuckle'], expanded('antagonist.urdf.xacro', namespace='/arm')
    assert {one.get('name') for one in robot.findall('joint') if one.get('type') != 'fixed'} == {
        *values['muscles'],
        *values['joints'],
    }
    knuckle = robot.find("joint[@name='knuckle']")
    limit = knuckle.find('limit')
    assert (float(limit.get('lower')), float(limit.get('upper'))) == (joint['low_rad'], joint['high_rad'])
    places = {
        name: [float(x) for x in robot.find(f"joint[@name='{name}_mount']/origin").get('xyz').split()]
        for name in values['muscles']
    }
    assert places[joint['agonist']][0] == joint['radius_m'] == -places[joint['antagonist']][0]
    # Turned by a small angle about the axis, the rim at (r, 0, 0) moves along axis x (r, 0, 0).
    _, y, _ = (float(x) for x in knuckle.find('axis').get('xyz').split())
    assert -y * joint['radius_m'] > 0.0
    paper = Parameters.named('karami_tadesse_2017')
    assert places['flexor'][2] == pytest.approx(float(length(paper, paper['T0'], values['load_n'])), abs=1e-4)
    inertial = robot.find("link[@name='finger']/inertial")
    mass, arm = float(inertial.find('mass').get('value')), -float(inertial.find('origin').get('xyz').split()[2])
    about_joint = float(inertial.find('inertia').get('iyy')) + mass * arm**2
    assert about_joint == pytest.approx(joint['inertia_kg_m2'], rel=0.02)
    topics = {param.get('name'): param.text for param in robot.find('ros2_control/hardware').findall('param')}
    assert topics['joint_commands_topic'] == '/arm/joint_commands'

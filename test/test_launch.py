"""The launch files: what they start and what they refuse, with stand-ins for launch, or with launch where it is."""

import importlib.util
import re
import sys
import tempfile
from configparser import ConfigParser
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest
import yaml

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.settings.launch_arguments import joint_of, read_arguments
from tcp_muscle_ros.settings.operating import joint_in

ROOT = Path(__file__).resolve().parents[1]
LAUNCH_FILES = sorted((ROOT / 'launch').glob('*.launch.py'))
LAUNCHING = 'tcp_muscle_ros.nodes.launching'


def programs():
    """The names of the console scripts that setup.py makes."""
    return set(re.findall(r"'(\w+) = tcp_muscle_ros[\w.]*:\w+'", (ROOT / 'setup.py').read_text(encoding='utf-8')))


def load(path):
    specification = importlib.util.spec_from_file_location(path.name.split('.')[0] + '_launch', path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_all_of_them_are_there():
    assert [path.name for path in LAUNCH_FILES] == [
        'antagonist.launch.py',
        'closed_loop.launch.py',
        'finger.launch.py',
        'hand.launch.py',
        'hardware.launch.py',
        'record.launch.py',
        'ros2_control.launch.py',
        'sim.launch.py',
        'twin.launch.py',
    ]


class StandIn(SimpleNamespace):
    """A class of launch's: what it is made with."""

    def __init__(self, *given, **named):
        super().__init__(given=given, **named)

    def perform(self, context):
        raise AssertionError('what only a ROS 2 installation can say is asked for before anything starts')


STAND_INS = {
    'launch': ['LaunchDescription'],
    'launch.actions': ['DeclareLaunchArgument', 'ExecuteProcess', 'OpaqueFunction'],
    'launch.substitutions': ['Command', 'FindExecutable', 'PathJoinSubstitution'],
    'launch_ros': [],
    'launch_ros.actions': ['Node'],
    'launch_ros.parameter_descriptions': ['ParameterValue'],
    'launch_ros.substitutions': ['ExecutableInPackage', 'FindPackageShare'],
}


@pytest.fixture
def launched(monkeypatch):
    """What a launch file starts where `ros2 launch` is told so: its actions, in a launch that only takes notes."""
    for name, classes in STAND_INS.items():
        module = ModuleType(name)
        vars(module).update({one: type(one, (StandIn,), {}) for one in classes})
        monkeypatch.setitem(sys.modules, name, module)
    specification = importlib.util.find_spec(LAUNCHING)
    helper = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(helper)
    monkeypatch.setitem(sys.modules, LAUNCHING, helper)

    def launched(name, **given):
        words = [f'{argument}:={value}' for argument, value in given.items()]
        monkeypatch.setattr(sys, 'argv', ['ros2', 'launch', 'tcp_muscle_ros', name, *words])
        (entities,) = load(ROOT / 'launch' / name).generate_launch_description().given
        *declared, function = entities
        assert all(one.description for one in declared)
        defaults = {one.given[0]: one.default_value for one in declared}
        return function.function(SimpleNamespace(launch_configurations=defaults | given))

    return launched


def arguments_of(path):
    """The names that a launch file declares."""
    return set(re.findall(r"^    \('(\w+)', ", path.read_text(encoding='utf-8'), re.MULTILINE))


def test_every_kind_of_file_is_an_argument_of_some_launch_file():
    """The check below goes by the names."""
    files = {name for path in LAUNCH_FILES for name in arguments_of(path) if 'file' in name}
    assert files == {'params_file', 'model_file', 'rig_file', 'controllers_file'}


def parameters_of(action):
    """What a node gets where the last entry wins, files read."""
    values = {}
    for entry in action.parameters:
        if isinstance(entry, str):
            entry = yaml.safe_load(Path(entry).read_text())['/**']['ros__parameters']
        values |= entry
    return values


@pytest.mark.parametrize('path', LAUNCH_FILES, ids=lambda path: path.name)
def test_names_programs_that_are_installed(path, launched):
    actions = launched(path.name, namespace='left')
    mine = [one for one in actions if getattr(one, 'package', '') == 'tcp_muscle_ros']
    tools = [one.cmd[0] for one in actions if hasattr(one, 'cmd')]
    assert mine or tools
    assert {one.executable for one in [*mine, *tools]} <= programs()
    assert {one.namespace for one in mine} <= {'left'}
    assert all(Path(entry).is_file() for one in mine for entry in one.parameters if isinstance(entry, str))


def test_later_parameters_win_over_the_file_that_was_given(launched, tmp_path):
    file = tmp_path / 'muscle.yaml'
    file.write_text('/**:\n  ros__parameters:\n    {rate_hz: 20.0, joint_name: thumb, current_limit_a: 0.3}\n')
    muscle, controller = launched(
        'closed_loop.launch.py', params_file=str(file), rate_hz='50', joint_name='index', real_time_factor='0'
    )
    same = {'rate_hz': 50.0, 'joint_name': 'index', 'current_limit_a': 0.3}
    assert parameters_of(muscle) == same | {'real_time_factor': 0.0, 'lockstep_nodes': 1}
    assert parameters_of(controller) == same | {'use_sim_time': True}
    (hardware,) = launched('hardware.launch.py', params_file=str(file))
    assert parameters_of(hardware) == {
        'rate_hz': 20.0, 'joint_name': 'thumb', 'current_limit_a': 0.1, 'start_enabled': False
    }  # fmt: skip
    (simulated,) = launched('sim.launch.py', namespace='left/finger_1', real_time_factor='2')
    assert parameters_of(simulated) == {'real_time_factor': 2.0}, 'the node itself goes by its namespace'
    assert [one.executable for one in launched('hand.launch.py', controller='false')] == ['sim_node']


HOT = '  ros__parameters: {start_enabled: true, current_limit_a: 0.27}\n'
FOR_ALL = '/**:\n  ros__parameters: {load_n: 0.5}\n'


def as_launch_ros_gives(action, folder):
    """The arguments that a node is started with: launch_ros writes what is no file into one, for all nodes."""
    arguments = [action.executable, '--ros-args', *(['-r', f'__ns:=/{action.namespace}'] if action.namespace else [])]
    for number, entry in enumerate(action.parameters):
        if not isinstance(entry, str):
            file = folder / f'launch_params_{number}.yaml'
            file.write_text(yaml.safe_dump({'/**': {'ros__parameters': entry}}))
            entry = str(file)
        arguments += ['--params-file', entry]
    return arguments


def as_ros_takes(arguments, **among):
    """Of a node started so: the values that rcl gives it, of those that may be ``among`` them."""
    rclpy = pytest.importorskip('rclpy', reason='needs ROS 2')
    context = rclpy.Context()
    context.init(args=arguments)
    node = rclpy.create_node(arguments[0], context=context, automatically_declare_parameters_from_overrides=True)
    try:
        return {name: node.get_parameter_or(name).value for name in among}
    finally:
        node.destroy_node()
        context.shutdown()


@pytest.mark.parametrize(
    ('text', 'below'),
    [
        (FOR_ALL + 'controller_node:\n' + HOT, 'controller_node'),
        (FOR_ALL + '/controller_node:\n' + HOT, '/controller_node'),
        (FOR_ALL + '/**/controller_node:\n' + HOT, '/**/controller_node'),
        (FOR_ALL + "'**':\n" + HOT, '**'),
        (FOR_ALL + "'/*':\n" + HOT, '/*'),
        (FOR_ALL + 'finger:\n  controller_node:\n    ' + HOT.strip() + '\n', 'finger/controller_node'),
        (FOR_ALL + 'controller_node: {ros__parameters: {muscles: [thumb], thumb.current_limit_a: 0.27}}', ''),
        (FOR_ALL + 'controller_node: {ros__parameters: {thumb: {start_enabled: true}}}', ''),
    ],
)
def test_no_section_of_a_file_starts_a_real_muscle_hot(launched, tmp_path, text, below):
    file = tmp_path / 'muscle.yaml'
    file.write_text(text)
    with pytest.raises(BadInput) as caught:
        launched('hardware.launch.py', params_file=str(file))
    said = str(caught.value)
    assert said.startswith(f"{file}: '") and f"stands below '{below or 'controller_node'}': expected it" in said
    assert '\n' not in said


@pytest.mark.parametrize('namespace', ['', 'finger'])
def test_what_hardware_launch_says_of_a_real_muscle_is_what_ros_takes(launched, tmp_path, namespace):
    file = tmp_path / 'muscle.yaml'
    file.write_text(
        '/**:\n' + HOT + 'serial_driver_node:\n' + HOT + 'controller_node: {ros__parameters: {rate_hz: 50.0}}\n'
    )
    (hardware,) = launched('hardware.launch.py', params_file=str(file), namespace=namespace)
    safe = {'start_enabled': False, 'current_limit_a': 0.1}
    assert as_ros_takes(as_launch_ros_gives(hardware, tmp_path), **safe) == safe


@pytest.mark.parametrize('path', LAUNCH_FILES, ids=lambda path: path.name)
def test_what_it_does_not_know_is_refused_before_anything_starts(path, launched, tmp_path):
    with pytest.raises(BadInput, match=r"unknown launch argument 'namspace'; did you mean 'namespace'\?"):
        launched(path.name, namspace='finger')
    names = arguments_of(path)
    for name in sorted(name for name in names if name.endswith('_file')):
        what = 'rig_file' if name == 'rig_file' else 'parameter file'
        with pytest.raises(BadInput, match=rf'missing\.yaml: cannot read the {what}: No such file or directory'):
            launched(path.name, **{name: str(tmp_path / 'missing.yaml')})
        if what == 'parameter file':
            (tmp_path / 'empty.yaml').write_text('hA: 0.02\n')
            with pytest.raises(BadInput, match=r"empty\.yaml: no parameters; expected '/\*\*:'"):
                launched(path.name, **{name: str(tmp_path / 'empty.yaml')})
    for name in names & {'rate_hz', 'real_time_factor', 'duration_s', 'current_limit_a'}:
        with pytest.raises(BadInput, match=f"launch argument '{name}' is 'fast'; expected a number"):
            launched(path.name, **{name: 'fast'})


def test_within_another_launch_file_its_arguments_are_left_alone():
    rows = [('namespace', '', 'of the muscle'), ('rate_hz', '', 'ticks a second')]
    argv = ['ros2', 'launch', 'my_robot', 'bringup.launch.py', 'robot:=left']
    configurations = {'robot': 'left', 'namespace': '', 'rate_hz': ''}
    values = read_arguments(str(ROOT / 'launch' / 'sim.launch.py'), rows, configurations, argv)
    assert values == {'namespace': '', 'rate_hz': ''}


def test_the_joint_follows_the_namespace_unless_told_otherwise(tmp_path):
    file = tmp_path / 'muscle.yaml'
    for text, namespace, given, expected in (
        ('hA: 0.02', '/left/finger_1', '', 'finger_1'),
        ('hA: 0.02', '', '', 'tcp_muscle'),
        ('hA: 0.02', 'finger_1', 'knuckle', 'knuckle'),
        ('joint_name: thumb', 'finger_1', '', 'thumb'),
    ):
        file.write_text(f'/**:\n  ros__parameters:\n    {text}\n')
        values = {'joint_name': given, 'namespace': namespace, 'params_file': str(file)}
        assert joint_of(values, 'sim_node') == expected, (text, namespace, given)
    assert joint_of({'joint_name': '', 'namespace': 'finger_1', 'params_file': ''}, 'sim_node') == 'finger_1'


def test_ros2_control_has_one_joint_in_urdf_controllers_and_muscle_and_leaves_one_file(launched, tmp_path, monkeypatch):
    monkeypatch.setenv('ROS_HOME', str(tmp_path / 'ros'))
    monkeypatch.setattr(tempfile, 'tempdir', str(tmp_path))
    for given, namespace, joint in (
        ({'namespace': '/left/finger_1'}, 'left/finger_1', 'finger_1'),
        ({'namespace': 'left/finger_1'}, 'left/finger_1', 'finger_1'),
        ({'joint_name': 'knuckle'}, 'knuckle', 'knuckle'),
        ({'namespace': 'left', 'joint_name': 'knuckle'}, 'left', 'knuckle'),
        ({}, 'tcp_muscle', 'tcp_muscle'),
    ):
        muscle, controller, publisher, manager, _ = launched('ros2_control.launch.py', **given)
        assert muscle.namespace == controller.namespace == namespace, given
        plan = {**parameters_of(muscle), **parameters_of(controller)}
        assert plan.get('joint_name', joint_in(namespace)) == joint, given
        command = publisher.parameters[0]['robot_description'].given[0].given[0]
        assert command[-2:] == [f' name:={joint}', f' namespace:=/{namespace}'], given
        controllers = yaml.safe_load(Path(manager.parameters[0]).read_text(encoding='utf-8'))
        assert controllers['muscle_position_controller']['ros__parameters']['joints'] == [joint], given
    left = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob('*') if path.is_file()}
    written = ('finger_1', 'knuckle', 'tcp_muscle')
    assert left == {f'ros/tcp_muscle_ros/controllers_{joint}.yaml' for joint in written}
    assert {path.name for path in tmp_path.iterdir()} == {'ros'}


@pytest.mark.parametrize('robot', ['finger', 'antagonist'])
def test_the_nodes_of_a_robot_stand_where_its_description_looks_for_them(robot, launched):
    """In the namespace of its name (test_urdf.py), and so do the topics of every line to type after the launch."""
    *nodes, publisher = launched(f'{robot}.launch.py')
    assert {one.namespace for one in (*nodes, publisher)} == {robot}, 'and /tf is made of the joint_states there'
    assert [one.executable for one in nodes] == ['sim_node', 'controller_node']
    assert publisher.executable == 'robot_state_publisher'
    told = publisher.parameters[0]['robot_description'].given[0].given[0][2].given[0]
    assert told[-1].startswith(f'{robot}.urdf') and (ROOT / 'urdf' / told[-1]).is_file()
    told = 0
    for path in (ROOT / 'README.md', *LAUNCH_FILES, *(ROOT / 'docs').glob('*.md')):
        for block in path.read_text(encoding='utf-8').split('\n\n'):
            if f'ros2 launch tcp_muscle_ros {robot}.launch.py\n' in block:
                topics = re.findall(r'ros2 topic pub .*?(/\S+)', block)
                assert all(topic.startswith(f'/{robot}/') for topic in topics), (path.name, topics)
                told += len(topics)
    assert told >= 2


def test_a_switch_is_true_or_false(launched):
    with pytest.raises(BadInput, match="launch argument 'controller' is 'maybe'; expected true or false"):
        launched('hand.launch.py', controller='maybe')


def test_ros2_run_finds_the_programs():
    cfg = ConfigParser()
    cfg.read(ROOT / 'setup.cfg')
    assert cfg['install']['install_scripts'] == '$base/lib/tcp_muscle_ros'
    assert cfg['develop']['script_dir'] == '$base/lib/tcp_muscle_ros'
    assert programs() == {'sim_node', 'controller_node', 'serial_driver_node', 'twin_node', 'tcp_muscle'}


@pytest.mark.parametrize('path', LAUNCH_FILES, ids=lambda path: path.name)
def test_launch_accepts_it(path):
    """On a real ROS 2 only: launch and launch_ros are not to be had from a package index."""
    pytest.importorskip('launch_ros', reason='launch comes with a ROS 2 installation, not with the wheels')
    from launch import LaunchContext
    from launch.actions import DeclareLaunchArgument, OpaqueFunction

    description = load(path).generate_launch_description()
    context = LaunchContext()
    arguments = [entity for entity in description.entities if isinstance(entity, DeclareLaunchArgument)]
    assert all(argument.description for argument in arguments)
    for argument in arguments:
        argument.execute(context)
    (function,) = (entity for entity in description.entities if isinstance(entity, OpaqueFunction))
    assert function.execute(context)

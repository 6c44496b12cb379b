"""The launch files: they name programs that exist; where ROS 2's launch is installed, they are loaded by it."""

import ast
import importlib.util
import re
from configparser import ConfigParser
from pathlib import Path

import pytest

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.settings.launch_arguments import joint_of, read_arguments

ROOT = Path(__file__).resolve().parents[1]
LAUNCH_FILES = sorted((ROOT / 'launch').glob('*.launch.py'))


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


@pytest.mark.parametrize('path', LAUNCH_FILES, ids=lambda path: path.name)
def test_names_programs_that_are_installed(path):
    tree = ast.parse(path.read_text(encoding='utf-8'))
    functions = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
    assert 'generate_launch_description' in functions
    text = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    assert text & programs()
    assert 'tcp_muscle_ros' in text


def arguments_of(path):
    """The table ARGUMENTS of a launch file, without launch."""
    tree = ast.parse(path.read_text(encoding='utf-8'))
    (table,) = (
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and [getattr(one, 'id', '') for one in node.targets] == ['ARGUMENTS']
    )
    return ast.literal_eval(table)


def read(path, nodes=('sim_node',), **given):
    """What the launch file reads where `ros2 launch` is told so."""
    rows = arguments_of(path)
    configurations = {name: default for name, default, _ in rows} | given
    argv = ['ros2', 'launch', 'tcp_muscle_ros', path.name, *(f'{name}:={value}' for name, value in given.items())]
    return read_arguments(str(path), rows, configurations, argv, nodes)


@pytest.mark.parametrize('path', LAUNCH_FILES, ids=lambda path: path.name)
def test_what_it_does_not_know_is_refused_before_anything_starts(path, tmp_path):
    calls = {node.func.id for node in ast.walk(ast.parse(path.read_text())) if hasattr(getattr(node, 'func', 0), 'id')}
    assert 'read_arguments' in calls
    with pytest.raises(BadInput, match=r"unknown launch argument 'namspace'; did you mean 'namespace'\?"):
        read(path, namspace='finger')
    names = {name for name, _, _ in arguments_of(path)}
    if 'params_file' in names:
        with pytest.raises(BadInput, match=r'missing\.yaml: cannot read the parameter file'):
            read(path, params_file=str(tmp_path / 'missing.yaml'))
    for name in names & {'rate_hz', 'real_time_factor', 'duration_s', 'current_limit_a'}:
        with pytest.raises(BadInput, match=f"launch argument '{name}' is 'fast'; expected a number"):
            read(path, **{name: 'fast'})


def test_within_another_launch_file_its_arguments_are_left_alone():
    path = ROOT / 'launch' / 'sim.launch.py'
    rows = arguments_of(path)
    argv = ['ros2', 'launch', 'my_robot', 'bringup.launch.py', 'robot:=left']
    values = read_arguments(str(path), rows, {'robot': 'left', **{name: default for name, default, _ in rows}}, argv)
    assert values['namespace'] == '' and 'robot' not in values


def test_the_joint_follows_the_namespace_unless_told_otherwise(tmp_path):
    file = tmp_path / 'muscle.yaml'
    for text, namespace, given, expected in (
        ('hA: 0.02', '/left/finger_1', '', {'joint_name': 'finger_1'}),
        ('hA: 0.02', '', '', {}),
        ('hA: 0.02', 'finger_1', 'knuckle', {'joint_name': 'knuckle'}),
        ('joint_name: thumb', 'finger_1', '', {}),
        ('muscles: [thumb, index]', 'hand', '', {}),
    ):
        file.write_text(f'/**:\n  ros__parameters:\n    {text}\n')
        values = {'joint_name': given, 'namespace': namespace, 'params_file': str(file)}
        assert joint_of(values, 'sim_node') == expected, (text, namespace, given)
    assert joint_of({'joint_name': '', 'namespace': 'finger_1', 'params_file': ''}, 'sim_node') == {
        'joint_name': 'finger_1'
    }


def test_a_switch_is_true_or_false():
    with pytest.raises(BadInput, match="launch argument 'controller' is 'maybe'; expected true or false"):
        read(ROOT / 'launch' / 'hand.launch.py', controller='maybe')


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

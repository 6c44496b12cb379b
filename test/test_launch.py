"""The launch files: they name programs that exist; where ROS 2's launch is installed, they are loaded by it."""

import ast
import importlib.util
import re
from configparser import ConfigParser
from pathlib import Path

import pytest

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
        'hand.launch.py',
        'hardware.launch.py',
        'record.launch.py',
        'sim.launch.py',
    ]


@pytest.mark.parametrize('path', LAUNCH_FILES, ids=lambda path: path.name)
def test_names_programs_that_are_installed(path):
    tree = ast.parse(path.read_text(encoding='utf-8'))
    functions = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
    assert 'generate_launch_description' in functions
    text = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    assert text & programs()
    assert 'tcp_muscle_ros' in text


def test_ros2_run_finds_the_programs():
    cfg = ConfigParser()
    cfg.read(ROOT / 'setup.cfg')
    assert cfg['install']['install_scripts'] == '$base/lib/tcp_muscle_ros'
    assert cfg['develop']['script_dir'] == '$base/lib/tcp_muscle_ros'
    assert programs() == {'sim_node', 'controller_node', 'tcp_muscle'}


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

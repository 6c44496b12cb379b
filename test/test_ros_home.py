"""What a ROS 2 installation makes of this package: rosdep's keys, and the plugins that its pytest loads."""

import os
import re
import runpy
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest
import setuptools
import yaml

ROOT = Path(__file__).resolve().parents[1]
README = ' '.join((ROOT / 'README.md').read_text(encoding='utf-8').split())
TAGS = ('depend', 'build_depend', 'exec_depend', 'test_depend', 'buildtool_depend')


def keys():
    package = ElementTree.parse(ROOT / 'package.xml').getroot()
    return {element.text for tag in TAGS for element in package.findall(tag)}


@pytest.fixture(scope='module')
def known():
    return yaml.safe_load((ROOT / 'test' / 'rosdep_keys.yaml').read_text(encoding='utf-8'))


def test_rosdep_has_every_key_of_package_xml(known):
    assert not {key for key in keys() if known.get(key, 'none') == 'none'}


def test_what_comes_by_pip_is_said_with_what_ubuntu_needs_for_it(known):
    by_pip = {key for key in keys() if known[key] == 'pip'}
    assert by_pip == {'python3-rosbags-pip'}
    assert 'PIP_BREAK_SYSTEM_PACKAGES=1 rosdep install' in README and '`rosbags`' in README
    # No key of rosdep leads to these: one line installs them, mcap brings both compressors.
    assert 'python3 -m pip install --break-system-packages mcap' in README


@pytest.mark.parametrize(('argument', 'code'), [('--needs', 0), ('--need', 2)])
def test_with_ros_says_what_it_needs(argument, code):
    done = subprocess.run(
        [ROOT / 'scripts' / 'with_ros', argument], env={'PATH': '/usr/bin:/bin'}, capture_output=True, text=True
    )
    assert done.returncode == code
    script = (ROOT / 'scripts' / 'with_ros').read_text(encoding='utf-8').replace('\\\n', '')
    needed = set(' '.join(re.findall(r'^(?:if )?needs ([\w ]+)', script, re.MULTILINE)).split())
    assert {'ros2bag', 'joint_state_topic_hardware_interface', 'ament_pep257'} <= needed
    assert all((package in done.stdout) == (code == 0) for package in needed), needed


def test_ci_tries_with_ros_and_takes_its_answer():
    assert './scripts/with_ros\n' in (ROOT / '.ci' / 'run').read_text(encoding='utf-8')


def test_with_ros_tries_every_launch_file():
    script = (ROOT / 'scripts' / 'with_ros').read_text(encoding='utf-8')
    names = {path.name.split('.')[0] for path in (ROOT / 'launch').glob('*.launch.py')}
    (several,) = re.findall(r'for file in ([\w ]+); do', script)
    by_name = set(re.findall(r'ros2 launch tcp_muscle_ros (\w+)\.launch\.py', script))
    assert names == set(several.split()) | by_name


BROKEN_PLUGIN = 'raise ImportError("a plugin for another pytest")\n'


@pytest.mark.parametrize('name', ['launch_testing', 'launch_ros'])
def test_a_plugin_of_ros_that_does_not_fit_this_pytest_stops_nothing(tmp_path, name):
    """As an older launch_testing does beside a newer pytest: its entry point is found and must not be loaded."""
    (tmp_path / 'of_another_time.py').write_text(BROKEN_PLUGIN)
    info = tmp_path / f'{name}-1.0.dist-info'
    info.mkdir()
    (info / 'METADATA').write_text(f'Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n')
    (info / 'entry_points.txt').write_text(f'[pytest11]\n{name} = of_another_time\n')
    done = subprocess.run(
        [
            sys.executable,
            '-m',
            'pytest',
            '--collect-only',
            '-q',
            '-p',
            'no:cacheprovider',
            'test/recording/test_units.py',
        ],
        cwd=ROOT,
        env={'PYTHONPATH': f'{tmp_path}:{ROOT}', 'PATH': '/usr/bin:/bin', 'HOME': str(Path.home())},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_pytest_of_ubuntu_24_04_is_new_enough():
    """7.4.4; .ci/run runs colcon's tests under it."""
    tomllib = pytest.importorskip('tomllib', reason='tomllib is of Python 3.11')
    options = tomllib.loads((ROOT / 'pyproject.toml').read_text(encoding='utf-8'))['tool']['pytest']['ini_options']
    assert tuple(int(part) for part in options['minversion'].split('.')) <= (7, 4)


@pytest.mark.filterwarnings('ignore')  # setuptools warns of its own command, which colcon uses
@pytest.mark.parametrize(
    ('given', 'compiled'), [({'editable': True}, 1), ({}, 0), ({'editable': True, 'uninstall': 1}, 0)]
)
def test_colcon_with_links_compiles_the_model_where_it_will_be_imported_from(given, compiled, monkeypatch, tmp_path):
    """As colcon calls it (`develop --editable`, in its build folder); .ci/run has colcon do so and starts a node."""
    made, ran = {}, []
    monkeypatch.setattr(setuptools, 'setup', lambda **named: made.update(named))
    runpy.run_path(str(ROOT / 'setup.py'))
    command = made['cmdclass']['develop'](setuptools.Distribution())
    vars(command).update(given)
    monkeypatch.setattr(type(command).__mro__[1], 'run', lambda self: None)
    monkeypatch.setattr(
        subprocess, 'run', lambda *words, **named: ran.append((words[0], named)) or SimpleNamespace(returncode=0)
    )
    monkeypatch.chdir(tmp_path)
    command.run()
    assert len(ran) == compiled
    for words, named in ran:
        assert words[1:] == ['-m', 'tcp_muscle_ros.robots'], "into the user's cache, not into the source"
        assert named['env']['PYTHONPATH'].split(os.pathsep)[0] == str(tmp_path)
        assert named['env'].get('XDG_CACHE_HOME') == os.environ.get('XDG_CACHE_HOME')

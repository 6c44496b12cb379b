"""The frame holds: what is declared agrees, imports go down only, and an installed package has its files."""

import ast
import json
import re
import shutil
import subprocess
import sys
import zipfile
from dataclasses import fields
from functools import cache
from importlib import resources
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml
from packaging.requirements import Requirement

import tcp_muscle_ros
from tcp_muscle_ros.muscle import EFFECTS, SPECIFICATIONS, Outputs
from tcp_muscle_ros.recording.recording import OUTPUTS

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / 'tcp_muscle_ros'

# A room imports only from floors below its own; rooms on one floor do not know each other. `errors` is no room but the
# one class that all of them raise.
FLOORS = [
    {'errors', 'process'},
    {'files'},
    {'muscle', 'recording'},
    {'settings', 'control'},
    {'diagnosis', 'studies', 'robots'},
    {'report', 'nodes'},
    {'commands'},
    {'tool', 'interface'},
]
# The diagnosis from the ground up: each of its rooms imports only those before it.
DIAGNOSIS = ['model', 'observation', 'noise', 'hypothesis', 'fitting', 'search', 'answer', 'diagnose']
LONGEST_FUNCTION = 60  # lines, its docstring among them; how branched it may be, ruff says (C901)
WITHOUT_ROS = ['muscle', 'recording', 'settings', 'control', 'studies', 'diagnosis', 'robots']
# What package.xml calls a dependency -> what pip calls it and what Python imports.
PYTHON_DEPENDENCIES = {
    'python3-numpy': [('numpy', 'numpy')],
    'python3-scipy': [('scipy', 'scipy')],
    'python3-numba': [('numba', 'numba')],
    'python3-matplotlib': [('matplotlib', 'matplotlib')],
    'python3-jinja2': [('Jinja2', 'jinja2')],
    'python3-yaml': [('PyYAML', 'yaml')],
    'python3-rosbags-pip': [('rosbags', 'rosbags')],
}
# What rosdep has no key for (the README says how it is installed). mcap requires the two compressors, and we read its
# chunks with them ourselves.
WITHOUT_KEY = [('mcap', 'mcap'), ('lz4', 'lz4'), ('zstandard', 'zstandard')]
# Extras that code imports only where they are asked for.
OPTIONAL_DEPENDENCIES = {
    'cluster': {'distributed'},
    'hardware': {'serial'},
    'labs': {'openpyxl', 'pandas', 'pyarrow', 'threadpoolctl'},
    'mujoco': {'mujoco'},
}
CALLED_OTHERWISE = {'pyserial': 'serial'}  # what pip calls it -> what Python imports
TEST_DEPENDENCIES = {
    'python3-pytest': 'pytest',
    'python3-hypothesis': 'hypothesis',
    'python3-psutil': 'psutil',
    'python3-jsonschema': 'jsonschema',
}
# ROS packages that launch files import, with what they share in `nodes.launching`: a ROS 2 installation has them.
LAUNCH = {'launch', 'launch_ros'}
# ROS packages that only launch files name.
LAUNCH_DEPENDENCIES = {
    'xacro',
    'robot_state_publisher',
    'controller_manager',
    'joint_state_broadcaster',
    'forward_command_controller',
    'joint_state_topic_hardware_interface',
}


def tracked_files():
    """Everything that is shipped: what git tracks, or every file where there is no repository."""
    if (ROOT / '.git').exists():
        listing = subprocess.run(['git', 'ls-files', '-z'], cwd=ROOT, check=True, capture_output=True, text=True).stdout
        found = [ROOT / name for name in listing.split('\0') if name]
    else:
        found = [path for path in ROOT.rglob('*') if not any(part.startswith('.') for part in path.parts)]
    return [path for path in found if path.is_file()]


def package_xml():
    return ElementTree.parse(ROOT / 'package.xml').getroot()


def declared(tag):
    return {element.text for element in package_xml().findall(tag)}


@pytest.fixture(scope='module')
def setup_py():
    """setup.py's own answer, asked as a build would."""
    ask = (
        'import json, setuptools\n'
        'from distutils.core import run_setup\n'
        "d = run_setup('setup.py', stop_after='init')\n"
        'print(json.dumps({"version": d.metadata.version, "requires": d.install_requires, "license": '
        'd.metadata.license, "extras": d.extras_require, "email": d.metadata.maintainer_email}))'
    )
    done = subprocess.run([sys.executable, '-c', ask], cwd=ROOT, check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


@cache
def parsed(path):
    """A file of Python, parsed once for all tests."""
    return ast.parse(path.read_text(encoding='utf-8'))


@cache
def walked(tree):
    """Every node of it, likewise."""
    return tuple(ast.walk(tree))


def modules():
    """(dotted name, parsed source) of every module of the package."""
    for path in sorted(PACKAGE.rglob('*.py')):
        parts = path.relative_to(ROOT).with_suffix('').parts
        yield '.'.join(parts).removesuffix('.__init__'), parsed(path)


def imported(name, tree, *, is_package):
    """Full dotted names that a module imports, relative ones resolved."""
    for node in walked(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ''
            if node.level:
                here = name.split('.')
                here = here[: len(here) - node.level + (1 if is_package else 0)]
                base = '.'.join([*here, base] if base else here)
            yield from (f'{base}.{alias.name}' for alias in node.names)


def all_imports():
    """(importing module, imported dotted name) for the whole package."""
    for name, tree in modules():
        is_package = (ROOT / Path(*name.split('.'))).is_dir()
        for target in imported(name, tree, is_package=is_package):
            yield name, target


def room(dotted):
    parts = dotted.split('.')
    return parts[1] if len(parts) > 1 and parts[0] == 'tcp_muscle_ros' else None


def test_package_xml_is_what_colcon_accepts():
    root = package_xml()
    assert root.get('format') == '3'
    assert root.findtext('name') == 'tcp_muscle_ros'
    assert root.find('export').findtext('build_type') == 'ament_python'
    # colcon ignores the whole file, with only a warning, when this address does not look like one.
    assert re.fullmatch(r'[^@\s]+@[^@\s]+\.[^@\s.]+', root.find('maintainer').get('email'))
    assert (ROOT / root.find('license').get('file')).is_file()


def test_versions_agree(setup_py):
    changelog = re.search(r'^## (\d+\.\d+\.\d+)', (ROOT / 'CHANGELOG.md').read_text(encoding='utf-8'), re.M)
    assert changelog, 'CHANGELOG.md has no "## X.Y.Z" heading'
    assert package_xml().findtext('version') == tcp_muscle_ros.__version__ == setup_py['version']
    assert changelog[1] == tcp_muscle_ros.__version__


def test_package_xml_and_setup_py_declare_the_same(setup_py):
    required = {Requirement(text).name for text in setup_py['requires']} - {'setuptools'}
    from_xml = {key for key in declared('exec_depend') if key.startswith('python3-')}
    assert from_xml == set(PYTHON_DEPENDENCIES)
    assert required == {pip_name for names in [*PYTHON_DEPENDENCIES.values(), WITHOUT_KEY] for pip_name, _ in names}
    assert declared('test_depend') == set(TEST_DEPENDENCIES)
    # colcon test finds no tests at all without pytest in this extra.
    assert set(setup_py['extras']['test']) == set(TEST_DEPENDENCIES.values())
    assert package_xml().findtext('license') == setup_py['license']
    assert package_xml().find('maintainer').get('email') == setup_py['email']


def test_what_is_imported_is_declared_and_the_reverse(setup_py):
    outside = {target.split('.')[0] for _, target in all_imports()}
    outside -= {'tcp_muscle_ros', '', *sys.stdlib_module_names}
    python = {module for names in [*PYTHON_DEPENDENCIES.values(), WITHOUT_KEY] for _, module in names}
    ros = {key for key in declared('exec_depend') if not key.startswith('python3-')}
    optional = set().union(*OPTIONAL_DEPENDENCIES.values())
    assert outside == python | optional | (ros - LAUNCH_DEPENDENCIES)
    for extra, names in OPTIONAL_DEPENDENCIES.items():
        declared_names = {Requirement(text).name for text in setup_py['extras'][extra]}
        assert {CALLED_OTHERWISE.get(name, name) for name in declared_names} == names


def test_ros_extra_has_every_ros_package_that_is_imported(setup_py):
    wheels = {Requirement(text).name for text in setup_py['extras']['ros']}
    ros = {key for key in declared('exec_depend') if not key.startswith('python3-')} - LAUNCH_DEPENDENCIES - LAUNCH
    wanted = {'ros-' + name.replace('_', '-') for name in ros - {'rclpy'}} | {'ros-jazzy-rclpy'}
    assert wheels == wanted


def test_imports_only_go_down():
    floor = {name: level for level, rooms in enumerate(FLOORS) for name in rooms}
    wrong = []
    for name, target in all_imports():
        mine, theirs = room(name), room(target)
        if mine is None or theirs is None or theirs == '__version__' or mine == theirs:
            continue
        assert mine in floor, f'{name}: put the room {mine!r} on a floor of FLOORS'
        assert theirs in floor, f'{name} imports {target}: {theirs!r} is on no floor'
        if floor[theirs] >= floor[mine]:
            wrong.append(f'{name} imports {target}')
    assert not wrong


def test_only_nodes_and_commands_know_ros():
    ros = {key for key in declared('exec_depend') if not key.startswith('python3-')}
    wrong = [f'{name} imports {target}' for name, target in all_imports() if target.split('.')[0] in ros]
    assert wrong, 'no module imports ROS: the names of its packages are not what package.xml says'
    assert not [line for line in wrong if room(line.split()[0]) not in ('nodes', 'commands')]


def test_the_rooms_of_the_diagnosis_know_only_those_before_them():
    wrong, seen = [], set()
    for name, target in all_imports():
        mine, theirs = name.split('.')[1:3], target.split('.')[1:3]
        if len(mine) == len(theirs) == 2 and mine[0] == theirs[0] == 'diagnosis':
            seen |= {mine[1], theirs[1]}
            if DIAGNOSIS.index(theirs[1]) > DIAGNOSIS.index(mine[1]):
                wrong.append(f'{name} imports {target}')
    assert not wrong
    assert seen == set(DIAGNOSIS)


def test_the_diagnosis_knows_no_effect_by_its_name():
    # What it needs of one, the effect says in its own file (see Effect).
    named = [
        f'{name}:{node.lineno}: {node.value}'
        for name, tree in modules()
        if room(name) == 'diagnosis'
        for node in walked(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.partition('.')[0] in EFFECTS
    ]
    imported_by_name = [
        f'{name} imports {target}'
        for name, target in all_imports()
        if room(name) == 'diagnosis' and target.split('.')[1:3] == ['muscle', 'effects']
        if target.split('.')[3] in EFFECTS
    ]
    assert not named + imported_by_name


# Where the diagnosis may name what the muscle has, and why.
NAMES_THE_MUSCLE = {
    'model.tcp_muscle': 'the muscle says here what the engine asks of a machine',
    'observation.admission': 'whether a recording can be that of a muscle at all',
    'observation.holding': 'which channel of a recording is the load, and which shows the end',
    'observation.prepare': 'how the channels of a recording become what was imposed and what was seen',
    'answer.next_experiment': 'what can be done with a muscle on its rig, and what would be recorded',
}


def test_the_diagnosis_knows_no_parameter_column_or_channel_by_its_name():
    # What it needs of a machine, that says itself (see model/model.py); what is imposed has the same names for all.
    parameters = {name for name in SPECIFICATIONS if '.' not in name}
    columns = {field.name for field in fields(Outputs)} - {'time', 'current', 'power', 'voltage', 'heated', 'lost'}
    names = parameters | columns | set(OUTPUTS)
    named = {}
    for name, tree in modules():
        if room(name) != 'diagnosis':
            continue
        for node in walked(tree):
            literal = isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in names
            if literal or (isinstance(node, ast.Attribute) and node.attr in names - parameters):
                named.setdefault(name.removeprefix('tcp_muscle_ros.diagnosis.'), []).append(node.lineno)
    assert set(named) == set(NAMES_THE_MUSCLE), named


def test_no_modules_import_each_other_in_a_circle():
    known = {name for name, _ in modules()}
    left: dict[str, set[str]] = {name: set() for name in known}
    for name, target in all_imports():
        left[name] |= {target if target in known else target.rpartition('.')[0]} & known
    # What imports nothing that is left stands in no circle, nor does what nothing left imports.
    while free := [name for name, targets in left.items() if not targets & left.keys()]:
        for name in free:
            del left[name]
    while top := left.keys() - set().union(*left.values()):
        for name in top:
            del left[name]
    assert not left


def test_functions_are_read_in_one_go():
    long = [
        f'{path.relative_to(ROOT)}:{node.lineno}: {node.name} has {lines} lines'
        for folder in (PACKAGE, ROOT / 'proof')
        for path in sorted(folder.rglob('*.py'))
        for node in walked(parsed(path))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        for lines in [node.end_lineno - node.lineno + 1]
        if lines > LONGEST_FUNCTION
    ]
    assert not long


def test_the_longest_tests_have_been_run():
    """./scripts/test leaves them out: docs/long_checks.md says what came of each file of them."""
    page = (ROOT / 'docs' / 'long_checks.md').read_text(encoding='utf-8')
    rows = re.findall(r'^\| (test/\S+\.py) \| (\d+) \| (\d+) \| (\d+) \| (\d+) \|', page, re.M)
    marked = {
        str(path.relative_to(ROOT))
        for path in (ROOT / 'test').rglob('test_*.py')
        if re.search(r'pytest\.mark\.long\b', path.read_text(encoding='utf-8'))
    }
    assert {file for file, *_ in rows} == marked
    assert [file for file, *_, failed in rows if failed != '0'] == []


def test_ground_floors_import_with_rclpy_blocked():
    names = [name for name, _ in modules() if room(name) in WITHOUT_ROS]
    assert {room(name) for name in names} >= {'muscle', 'recording', 'control'}
    ros = sorted(key for key in declared('exec_depend') if not key.startswith('python3-'))
    program = (
        'import importlib, sys\n'
        f'for blocked in {ros!r}:\n'
        '    sys.modules[blocked] = None\n'
        f'for name in {names!r}:\n'
        '    importlib.import_module(name)\n'
    )
    done = subprocess.run([sys.executable, '-c', program], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_parameter_files_reach_nodes_in_any_namespace():
    files = [path for path in (ROOT / 'config').glob('*.yaml') if 'ros__parameters' in path.read_text('utf-8')]
    assert files, 'config/ holds no ROS parameter file'
    files.remove(ROOT / 'config' / 'controllers.yaml')  # of ros2_control's nodes, which its spawner finds by name
    for path in files:
        content = yaml.safe_load(path.read_text(encoding='utf-8'))
        assert list(content) == ['/**'], f'{path.name}: a file keyed by a node name is ignored in a namespace'
        assert list(content['/**']) == ['ros__parameters'], path.name


def test_config_is_package_data():
    shipped = {path.name for path in (resources.files('tcp_muscle_ros') / 'config').iterdir()}
    assert shipped == {path.name for path in (ROOT / 'config').iterdir()}


def test_a_wheel_holds_config_for_python_and_for_ros(tmp_path):
    source = tmp_path / 'source'
    for path in tracked_files():
        copy = source / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, copy)
    # git tracks tcp_muscle_ros/config as a link; the files behind it come through the link again.
    link = source / 'tcp_muscle_ros' / 'config'
    if not link.exists():
        link.symlink_to('../config')
    subprocess.run(
        [
            sys.executable,
            '-m',
            'pip',
            'wheel',
            '--quiet',
            '--no-deps',
            '--no-build-isolation',
            '--wheel-dir',
            tmp_path,
            source,
        ],
        check=True,
    )
    (wheel,) = tmp_path.glob('*.whl')
    names = set(zipfile.ZipFile(wheel).namelist())
    share = f'tcp_muscle_ros-{tcp_muscle_ros.__version__}.data/data/share/'
    assert share + 'ament_index/resource_index/packages/tcp_muscle_ros' in names
    assert share + 'tcp_muscle_ros/package.xml' in names
    for folder in ('config', 'launch', 'urdf'):
        files = [path.name for path in (source / folder).iterdir() if path.is_file()]
        assert files
        assert {f'{share}tcp_muscle_ros/{folder}/{name}' for name in files} <= names
    assert {f'tcp_muscle_ros/config/{path.name}' for path in (source / 'config').iterdir()} <= names
    assert not [name for name in names if name.startswith(('test/', 'scripts/'))]


def test_requirements_are_pinned_and_within_what_setup_py_allows(setup_py):
    pins = {}
    for path in sorted((ROOT / 'requirements').glob('*.txt')):
        for line in path.read_text(encoding='utf-8').splitlines():
            if not line or line.startswith('#'):
                continue
            requirement = Requirement(line)
            specifiers = list(requirement.specifier)
            assert [s.operator for s in specifiers] == ['=='], f'{path.name}: {line!r} is not pinned with =='
            assert '*' not in specifiers[0].version, f'{path.name}: {line!r} is not one version'
            pins.setdefault(requirement.name, []).append(specifiers[0].version)
    for text in setup_py['requires']:
        requirement = Requirement(text)
        assert pins[requirement.name]
        assert all(requirement.specifier.contains(version) for version in pins[requirement.name]), text


def test_nothing_tracked_names_a_registry_or_somebodys_home():
    registry = re.compile('|'.join(['pypi' + r'\.org', 'python' + 'hosted', '--(?:extra-)?index' + '-url']))
    home = re.compile(r'(?<![\w.$}])/(?:root|work|home/\w+|Users/\w+)/')
    wrong = []
    for path in tracked_files():
        try:
            text = path.read_text(encoding='utf-8')
        except UnicodeDecodeError:
            continue
        for number, line in enumerate(text.splitlines(), 1):
            if registry.search(line) or home.search(line):
                wrong.append(f'{path.relative_to(ROOT)}:{number}: {line.strip()[:80]}')
    assert not wrong

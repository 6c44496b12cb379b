"""scripts/setup on machines that cannot be set up: one line that says what to do, and nothing is left behind."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import domains
import pytest

ROOT = Path(__file__).resolve().parents[1]
TOOLS = ['bash', 'cat', 'dirname', 'flock', 'sha256sum', 'uname', 'rm']


@pytest.fixture
def machine(tmp_path):
    """A checkout's set-up files, and a PATH with the tools of a bare Debian and no Python."""
    checkout = tmp_path / 'checkout'
    shutil.copytree(ROOT / 'scripts', checkout / 'scripts', ignore=shutil.ignore_patterns('__pycache__'))
    shutil.copytree(ROOT / 'requirements', checkout / 'requirements')
    shutil.copyfile(ROOT / 'setup.py', checkout / 'setup.py')
    programs = tmp_path / 'bin'
    programs.mkdir()
    for name in TOOLS:
        (programs / name).symlink_to(shutil.which(name))
    return checkout, programs


def program(folder, name, script):
    """An executable shell script that stands in for a program of another machine."""
    path = folder / name
    path.unlink(missing_ok=True)
    path.write_text('#!' + shutil.which('bash') + '\n' + script + '\n', encoding='utf-8')
    path.chmod(0o755)


def run(machine, *arguments):
    """What bash does there."""
    checkout, programs = machine
    return subprocess.run(
        [programs / 'bash', *arguments],
        env={'PATH': str(programs), 'HOME': str(checkout)},
        capture_output=True,
        text=True,
        timeout=60,
    )


def said(machine):
    """The one line on stderr of a set-up that must fail."""
    checkout, _ = machine
    done = run(machine, checkout / 'scripts' / 'test')
    assert done.returncode == 1
    assert not (checkout / '.venv').exists()
    (line,) = done.stderr.splitlines()
    assert line.startswith('setup: ')
    return line


def test_the_shell_of_a_person_who_sources_it_stays_open(machine):
    done = run(machine, '-c', f'source {machine[0]}/scripts/setup && setup run || echo goes on')
    assert done.stdout == 'goes on\n'
    assert 'no python3 found' in done.stderr


def test_no_python(machine):
    assert 'no python3 found: sudo apt install' in said(machine)


def test_python_too_old(machine):
    program(machine[1], 'python3', 'echo 3.9')
    assert 'is Python 3.9, and this needs 3.10 to 3.13' in said(machine)


def test_python_too_new(machine):
    program(machine[1], 'python3', 'echo 3.14')
    assert 'is Python 3.14, and this needs 3.10 to 3.13' in said(machine)


def test_debian_without_the_venv_package(machine, tmp_path):
    (tmp_path / 'debian').mkdir()
    (tmp_path / 'debian' / 'ensurepip.py').write_text('raise ImportError\n', encoding='utf-8')
    program(machine[1], 'python3', f'PYTHONPATH={tmp_path / "debian"} exec {sys.executable} "$@"')
    version = '{}.{}'.format(*sys.version_info)
    assert f'Python {version} has no venv: sudo apt install python{version}-venv' in said(machine)


def test_machine_without_wheels(machine):
    program(machine[1], 'uname', '[ "$1" = -m ] && echo aarch64 || echo Linux')
    program(machine[1], 'python3', f'exec {sys.executable} "$@"')
    assert 'no wheels of ROS 2 for Linux on aarch64: install ROS 2' in said(machine)


@pytest.mark.parametrize(('kind', 'kept'), [('run', True), ('test', False)])
def test_what_the_user_has_exported_counts_for_what_he_runs_and_tests_keep_to_themselves(tmp_path, kind, kept):
    given = {'ROS_DOMAIN_ID': '177', 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET', 'ROS_LOG_DIR': str(tmp_path)}
    script = (
        f'source {ROOT}/scripts/setup; find_ros() {{ :; }}; prepare() {{ :; }}; flock() {{ :; }}; root={tmp_path}; '
    )
    for environment in (given, {}):
        done = subprocess.run(
            ['bash', '-c', script + f'setup {kind}; echo $ROS_DOMAIN_ID $ROS_AUTOMATIC_DISCOVERY_RANGE $ROS_LOG_DIR'],
            env={'PATH': os.environ['PATH'], **environment},
            capture_output=True,
            text=True,
            timeout=60,
        )
        domain, reach, folder = done.stdout.split()
        if environment and kept:
            assert (domain, reach, folder) == tuple(given.values())
        else:
            assert 1 <= int(domain) < domains.FIRST and reach == 'LOCALHOST' and folder.endswith('.venv/log')

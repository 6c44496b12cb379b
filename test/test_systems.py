"""What works on a system that is not Linux: everything but nodes and locks."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LINUX_ONLY = ('fcntl', 'termios', 'tty', 'pty', 'resource', 'pwd', 'grp')


def test_the_offline_commands_load_without_linux_only_modules():
    names = sorted(path.stem for path in (ROOT / 'tcp_muscle_ros' / 'commands').glob('[a-z]*.py'))
    assert 'campaign' in names and 'simulate' in names
    program = (
        'import importlib, sys\n'
        f'for blocked in {LINUX_ONLY!r}:\n'
        '    sys.modules[blocked] = None\n'
        'import tcp_muscle_ros.tool\n'
        f'for name in {names!r}:\n'
        "    importlib.import_module(f'tcp_muscle_ros.commands.{name}')\n"
    )
    done = subprocess.run([sys.executable, '-c', program], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_file_is_read_and_cores_are_counted_where_the_system_has_not_what_linux_has(tmp_path):
    (tmp_path / 'text').write_text('0.27 A', encoding='utf-8')
    program = (
        'import os, signal, sys\n'
        'del os.O_NONBLOCK, os.sched_getaffinity, signal.pthread_sigmask\n'
        'from tcp_muscle_ros.commands import campaign, engines\n'
        'from tcp_muscle_ros.files.inputs import read_text\n'
        'with engines._deaf():\n'
        "    print(read_text(sys.argv[1]), campaign._cores() >= 1, sep=', ')\n"
    )
    done = subprocess.run(
        [sys.executable, '-c', program, str(tmp_path / 'text')], cwd=ROOT, capture_output=True, text=True
    )
    assert done.stdout.strip() == '0.27 A, True', done.stderr

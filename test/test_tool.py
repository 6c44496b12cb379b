"""The command line: exit codes, one line for a mistake, no needless imports."""

import os
import subprocess
import sys
import types

import pytest

from tcp_muscle_ros import tool
from tcp_muscle_ros.commands import progress
from tcp_muscle_ros.errors import BadInput


def run(*arguments):
    process = subprocess.run(
        [sys.executable, '-m', 'tcp_muscle_ros.tool', *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    return process.returncode, process.stdout, process.stderr


@pytest.fixture
def command(monkeypatch):
    """Put a function in the place of what ``tcp_muscle replay`` runs; the command line around it is the real one."""

    def install(body):
        module = types.SimpleNamespace(add_arguments=lambda parser: None, run=lambda args: body())
        monkeypatch.setattr(tool.importlib, 'import_module', lambda name: module)

    return install


def test_help_lists_every_command_and_loads_nothing_heavy():
    code = (
        'import sys; from tcp_muscle_ros import tool; tool.main(["--help"]);'
        'heavy = {"numpy", "scipy", "numba", "rclpy", "rosbags", "matplotlib", "yaml"} & set(sys.modules);'
        'assert not heavy, heavy'
    )
    process = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, timeout=60, check=False)
    assert process.returncode == 0, process.stderr
    for name in ('simulate', 'record', 'import', 'calibrate', 'replay', 'diagnose'):
        assert f'  {name} ' in process.stdout or f'  {name}\n' in process.stdout


@pytest.mark.parametrize(
    ('arguments', 'says'),
    [
        (['simulte'], "unknown command 'simulte'; did you mean 'simulate'?"),
        ([], 'the following arguments are required: COMMAND'),
        (['import', 'x.csv'], 'tcp_muscle import: x.csv: no such file'),
        (['export', 'bag'], 'tcp_muscle export: bag: which table? expected --csv, --parquet, or'),
        (['import', 'x.csv', '--map', 'm', '--output', 'o', '--nmae'], 'unrecognized arguments: --nmae'),
        (
            ['import', 'x.csv', '--map', 'nowhere.yaml', '--output', 'o'],
            'tcp_muscle import: nowhere.yaml: cannot be read',
        ),
        (['record', '--output', 'o', '--duration', '-1'], 'tcp_muscle record: --duration -1: expected a number'),
        (['diagnose', 'bag', '--output', 'o', '--seed', '1'], 'unrecognized arguments: --seed 1'),
        (['diagnose', 'bag', '--ouput', 'o'], "unrecognized argument: --ouput; did you mean '--output'?; see"),
        (['replay', 'bag', '--parms=x'], "tcp_muscle replay: unrecognized argument: --parms; did you mean '--params'?"),
        (['info', '--', '--chanel'], 'tcp_muscle info: --chanel: no such bag'),
    ],
)
def test_a_mistake_is_one_line_and_exit_code_2(arguments, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('PYTHONPATH', ':'.join(sys.path))
    code, out, error = run(*arguments)
    assert (code, out) == (2, '')
    assert says in error
    assert error.count('\n') == 1


def test_bad_input_in_a_command_is_one_line_and_exit_code_2(command, capsys):
    def body():
        raise BadInput('bag: no such\nbag')

    command(body)
    assert tool.main(['replay']) == 2
    assert capsys.readouterr().err == 'tcp_muscle replay: bag: no such bag\n'


def test_an_internal_error_is_one_line_with_a_way_to_see_more_and_exit_code_1(command, capsys, monkeypatch):
    monkeypatch.delenv('TCP_MUSCLE_DEBUG', raising=False)
    command(lambda: 1 / 0)
    assert tool.main(['replay']) == 1
    error = capsys.readouterr().err
    assert error.startswith(
        'tcp_muscle replay: internal error: ZeroDivisionError: division by zero (set TCP_MUSCLE_DEBUG=1'
    )
    assert error.count('\n') == 1
    monkeypatch.setenv('TCP_MUSCLE_DEBUG', '1')
    with pytest.raises(ZeroDivisionError):
        tool.main(['replay'])


def test_interrupted_is_130(command, capsys):
    def body():
        raise KeyboardInterrupt

    command(body)
    assert tool.main(['replay']) == 130
    assert capsys.readouterr().err == 'tcp_muscle replay: interrupted\n'


def test_what_a_command_returns_is_the_exit_code(command):
    command(lambda: 0)
    assert tool.main(['replay']) == 0


# A reader who has seen enough, and a disk that is full


def unheard():
    """A stream to a reader who is gone."""
    read, write = os.pipe()
    os.close(read)
    return open(write, 'w')


def full():
    """A stream to a disk without room."""
    return open('/dev/full', 'w')


def run_into(sink, *arguments, **environment):
    """The tool with its standard output there; exit code and stderr."""
    with sink:
        process = subprocess.run(
            [sys.executable, '-m', 'tcp_muscle_ros.tool', *map(str, arguments)],
            stdout=sink,
            stderr=subprocess.PIPE,
            env={name: text for name, text in os.environ.items() if name != 'PYTHONUNBUFFERED'} | environment,
            text=True,
            timeout=120,
            check=False,
        )
    return process.returncode, process.stderr


def test_a_reader_who_has_seen_enough_is_no_mistake():
    assert run_into(unheard(), '--help') == (0, '')


def test_a_full_disk_under_the_output_is_one_line_and_exit_code_2():
    code, error = run_into(full(), '--help')
    assert code == 2
    assert error.startswith('tcp_muscle: standard output cannot be written (No space left on device)')
    assert error.count('\n') == 1


@pytest.mark.parametrize('sink', [unheard, full])
def test_the_work_is_done_although_nobody_hears_of_it(tmp_path, sink):
    for name in 'ab':
        (tmp_path / f'{name}.csv').write_text('t,x\n0,1\n1,2\n')
    (tmp_path / 'map.yaml').write_text(
        "time: {column: t}\ncolumns: {displacement: {column: x, unit: mm}}\nruns: [{file: '*.csv'}]\n"
    )
    command = ['import', tmp_path, '--map', tmp_path / 'map.yaml', '--output', tmp_path / 'out']
    code, _ = run_into(sink(), *command, PYTHONUNBUFFERED='1')
    assert code == (0 if sink is unheard else 2)
    assert sorted(path.name for path in (tmp_path / 'out').iterdir()) == ['a', 'b', 'import_map.yaml']


def test_signs_of_life_that_nobody_sees_end_no_work(command, monkeypatch):
    done = []

    def body():
        with progress.Progress('working') as sign:
            for step in range(3):
                sign.beat()
                done.append(step)
        return 0

    monkeypatch.setattr(progress, '_FIRST', -1.0)
    monkeypatch.setattr(progress, '_BETWEEN', -1.0)
    with unheard() as stream:
        monkeypatch.setattr(sys, 'stderr', stream)
        command(body)
        assert tool.main(['replay']) == 0
    assert done == [0, 1, 2]


def test_import_writes_one_bag_a_run_and_overwrites_nothing(tmp_path):
    (tmp_path / 'a.csv').write_text('t,x\n0,1\n1,2\n')
    (tmp_path / 'b.csv').write_text('t,x\n0,1\n1,3\n')
    (tmp_path / 'c.csv').write_text('other\n')
    (tmp_path / 'map.yaml').write_text(
        "time: {column: t}\ncolumns: {displacement: {column: x, unit: mm}}\nruns: [{file: '[ab].csv'}]\n"
    )
    command = ['import', tmp_path, '--map', tmp_path / 'map.yaml', '--output', tmp_path / 'out']
    code, out, error = run(*command)
    assert (code, error) == (0, '')
    assert '2 run(s) imported' in out
    assert 'c.csv matches no run of' in out
    assert sorted(path.name for path in (tmp_path / 'out').iterdir()) == ['a', 'b', 'import_map.yaml']
    code, _, error = run(*command)
    assert code == 2
    assert 'exists already and is not overwritten' in error


def test_import_writes_nothing_when_one_file_is_bad(tmp_path):
    (tmp_path / 'a.csv').write_text('t,x\n0,1\n1,2\n')
    (tmp_path / 'b.csv').write_text('t,x\n0,1\n1,three\n')
    (tmp_path / 'map.yaml').write_text(
        "time: {column: t}\ncolumns: {displacement: {column: x, unit: mm}}\nruns: [{file: '*.csv'}]\n"
    )
    code, _, error = run('import', tmp_path, '--map', tmp_path / 'map.yaml', '--output', tmp_path / 'out')
    assert code == 2
    assert "b.csv: row 3, column 'x': 'three' is not a number" in error
    assert not (tmp_path / 'out').exists()

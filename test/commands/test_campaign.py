"""``tcp_muscle diagnose --manifest``: many runs, in local processes and on a dask cluster on loopback."""

import argparse
import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from report.diagnoses import creep

from tcp_muscle_ros.commands.engines import _started
from tcp_muscle_ros.commands.one_run import Task
from tcp_muscle_ros.report.campaign_summary import NOT_DONE, Row, terminal_table
from tcp_muscle_ros.report.report_json import as_data
from tcp_muscle_ros.report.words import error_text
from tcp_muscle_ros.tool import main

pytestmark = pytest.mark.processes
TOOL = (sys.executable, '-m', 'tcp_muscle_ros.tool')
PROTOCOL = """
rate_hz: 5
input: current
segments:
  - {duration_s: 18, value: 0.25, load_n: 0.5884}
  - {duration_s: 22, value: 0}
"""
MUSCLE = """
/**:
  ros__parameters:
    hA: %s
    seed: 3
    temperature_noise_k: 0.2
    resistance_noise_ohm: 0.02
    displacement_noise_m: 5.0e-5
"""
HA = (0.022, 0.024)  # W/K, by recording


@pytest.fixture(scope='module')
def bags(tmp_path_factory):
    """Two sound bags ``bag_0`` and ``bag_1`` of two muscles, and one that is none."""
    folder = tmp_path_factory.mktemp('bags')
    (folder / 'protocol.yaml').write_text(PROTOCOL)
    for k, hA in enumerate(HA):
        (folder / 'muscle.yaml').write_text(MUSCLE % hA)
        made = [
            'simulate',
            folder / 'protocol.yaml',
            '--params',
            folder / 'muscle.yaml',
            '--output',
            folder / f'bag_{k}',
        ]
        assert main([str(word) for word in made]) == 0
    (folder / 'broken').mkdir()
    (folder / 'broken' / 'broken.mcap').write_bytes(b'no bag')
    return folder


def manifest(bags, name, *runs):
    path = bags / name
    path.write_text('runs:\n' + ''.join(f'  - {run}\n' for run in runs))
    return path


def diagnosed(path, output, *options):
    command = [*TOOL, 'diagnose', '--manifest', str(path), '--output', str(output), *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert 'Traceback' not in done.stderr
    return done


def whole(report):
    """Whether a report is there with all that belongs to one."""
    content = json.loads((report / 'report.json').read_text())
    return content['partial'] is False and {'report.html', 'improved.yaml', 'figures'} <= set(os.listdir(report))


def times(output):
    return {path: path.stat().st_mtime_ns for path in output.glob('*/*') if path.is_file()}


@pytest.fixture(scope='module')
def campaign(bags):
    """Three runs, one of them broken: (manifest, output, what was said)."""
    path = manifest(
        bags,
        'runs.yaml',
        '{name: thumb_0, bags: [bag_0], muscle: thumb, cycles: 0, day: 2026-03-01}',
        '{name: torn, bags: [broken], muscle: thumb, cycles: 500, day: 2026-03-02}',
        '{name: index_0, bags: [bag_1], muscle: index, cycles: 1000, day: 2026-03-03}',
    )
    return path, bags / 'out', diagnosed(path, bags / 'out', '--jobs', '2')


def test_a_broken_run_is_listed_and_does_not_stop_the_rest(campaign):
    _, output, done = campaign
    assert done.returncode == 0, done.stderr
    assert sorted(os.listdir(output)) == ['.lock', 'index_0', 'summary.csv', 'summary.json', 'thumb_0', 'trends.png']
    assert whole(output / 'thumb_0') and whole(output / 'index_0')
    (line,) = [line for line in done.stdout.splitlines() if line.startswith('  torn: ')]
    assert line.endswith('broken.mcap: not an MCAP file, expected a rosbag2')


def test_a_run_is_what_diagnose_of_its_bags_gives(campaign, bags, capsys):
    _, output, _ = campaign
    assert main(['diagnose', str(bags / 'bag_0'), '--output', str(bags / 'alone')]) == 0
    alone, run = (json.loads((d / 'report.json').read_text()) for d in (bags / 'alone', output / 'thumb_0'))
    del alone['seconds'], run['seconds']
    assert run == alone
    assert not [path for path in output.glob('*/*') if path.is_file() and b'.unfinished' in path.read_bytes()]


def test_the_summary_has_every_run_with_the_parameters_of_its_muscle(campaign):
    _, output, _ = campaign
    with (output / 'summary.csv').open() as file:
        rows = {row['run']: row for row in csv.DictReader(file)}
    assert list(rows) == ['thumb_0', 'torn', 'index_0']
    for name, hA in zip(('thumb_0', 'index_0'), HA, strict=True):
        assert float(rows[name]['hA_low']) <= float(rows[name]['hA']) <= float(rows[name]['hA_high'])
        assert float(rows[name]['hA']) == pytest.approx(hA, rel=0.02)
        assert rows[name]['verdict'] == 'wrong_parameters'
        assert float(rows[name]['held_out_rmse_after']) == pytest.approx(5e-5, rel=0.5)
    assert rows['torn']['verdict'] == '' and 'not an MCAP file' in rows['torn']['failed']
    runs = json.loads((output / 'summary.json').read_text())['runs']
    assert [(run['day'], run['cycles']) for run in runs] == [
        ('2026-03-01', 0.0),
        ('2026-03-02', 500.0),
        ('2026-03-03', 1000.0),
    ]


@pytest.mark.long
def test_what_is_done_is_not_done_again_unless_its_inputs_changed(campaign, bags):
    path, output, _ = campaign
    before = times(output)
    again = diagnosed(path, output, '--jobs', '2')
    assert (again.returncode, times(output)) == (0, before)
    assert again.stdout.startswith('2 of 3 runs were done already\n')

    (bags / 'muscle.yaml').write_text(MUSCLE % 0.022)
    changed = manifest(bags, 'changed.yaml', '{name: thumb_0, bags: [bag_0], params: muscle.yaml}')
    assert diagnosed(changed, output, '--jobs', '1').returncode == 0
    assert json.loads((output / 'thumb_0' / 'report.json').read_text())['calibration']['hA']['nominal'] == 0.022
    assert {p for p in before if times(output).get(p) == before[p]} == {p for p in before if p.parent.name == 'index_0'}


def test_the_table_names_the_first_finding_with_its_probability_and_errors():
    diagnosis, _ = creep()
    rows = [
        Row('thumb', None, None, None, as_data(diagnosis), None),
        Row('torn', None, None, None, None, 'bag: not a rosbag2'),
        Row('last', None, None, None, None, NOT_DONE),
    ]
    heads, _, thumb, torn, last, *rest = terminal_table(rows).splitlines()
    assert heads.split() == ['run', 'verdict', 'first', 'finding', 'probability', 'held-out', 'error']
    first = diagnosis.findings[0]
    assert thumb.split()[:4] == ['thumb', diagnosis.verdict, first.effect, f'{first.probability:.2f}']
    before, after = (getattr(diagnosis.fit['displacement'].held_out, when) for when in ('before', 'after'))
    told = [error_text('displacement', error, unit=False) for error in (before, after)]
    assert thumb.endswith(f'displacement {told[0]} to {told[1]} mm')
    assert torn.split()[:2] == ['torn', 'failed'] and last.split()[:3] == ['last', 'not', 'done']
    assert rest == ['', '1 of 3 runs failed:', '  torn: bag: not a rosbag2']


def test_all_runs_bad_is_bad_input_and_a_folder_of_somebody_else_stays(bags):
    output = bags / 'bad'
    (output / 'mine').mkdir(parents=True)
    (output / 'mine' / 'notes.txt').write_text('kept')
    path = manifest(bags, 'bad.yaml', '{name: torn, bags: [broken]}', '{name: mine, bags: [bag_0]}')
    done = diagnosed(path, output, '--jobs', '1')
    assert done.returncode == 2
    assert 'mine: is there already and no report of a manifest' in done.stdout
    assert (output / 'mine' / 'notes.txt').read_text() == 'kept'


@pytest.mark.parametrize(
    ('text', 'told'),
    [
        ('run: []', "unknown key 'run'; did you mean 'runs'?"),
        ('runs: []', 'runs is [], expected a list with at least one entry'),
        ('runs: [{name: a, bags: [b], musle: m}]', "runs 1: unknown key 'musle'; did you mean 'muscle'?"),
        ('runs: [{name: a}]', "runs 1: the key 'bags' is missing"),
        ('runs: [{name: a, bags: b}]', "runs 1: bags is 'b', expected a list of paths"),
        ('runs: [{name: a/b, bags: [b]}]', "runs 1: name is 'a/b', expected a name for a folder"),
        ('runs: [{name: .., bags: [b]}]', "runs 1: name is '..', expected a name for a folder"),
        ('runs: [{name: a, bags: [b]}, {name: A, bags: [c]}]', "runs 2: name is 'A', as of another run"),
        ('runs: [{name: a, bags: [b], cycles: many}]', "runs 1: cycles is 'many', expected a number"),
        ('runs: [{name: a, bags: [b], day: monday}]', "runs 1: day is 'monday', expected a date, as in 2026-03-01"),
    ],
)
def test_mistakes_in_the_manifest_are_one_line(tmp_path, capsys, text, told):
    (tmp_path / 'runs.yaml').write_text(text)
    assert main(['diagnose', '--manifest', str(tmp_path / 'runs.yaml'), '--output', str(tmp_path / 'out')]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert 'runs.yaml: ' in line and told in line
    assert not (tmp_path / 'out').exists()


@pytest.mark.parametrize(
    ('options', 'told'),
    [
        ([], 'expected BAG..., or --manifest RUNS.yaml'),
        (['bag', '--jobs', '2'], '--jobs goes with --manifest RUNS.yaml only'),
        (['bag', '--manifest', 'runs.yaml'], 'either bags or --manifest'),
        (['--manifest', 'runs.yaml', '--jobs', '0'], '--jobs 0: expected 1 or more'),
        (['--manifest', 'runs.yaml', '--jobs', '2', '--scheduler', 'here:1'], '--scheduler has its own workers'),
        (['--manifest', 'runs.yaml', '--separate', 'B0'], '--separate B0: expected one of'),
    ],
)
def test_options_that_do_not_go_together_are_one_line(tmp_path, capsys, options, told):
    assert main(['diagnose', *options, '--output', str(tmp_path / 'out')]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert told in line


def test_options_of_reading_and_fitting_hold_for_every_run(bags, monkeypatch):
    given = []

    def engine(tasks, jobs):
        given.extend(task.options for task in tasks)
        yield from ()

    monkeypatch.setattr('tcp_muscle_ros.commands.engines.local', engine)
    path = manifest(bags, 'options.yaml', '{name: a, bags: [bag_0]}', '{name: b, bags: [bag_1]}')
    options = ['--separate', 'B', '--unit', 'temperature=K']
    main(['diagnose', '--manifest', str(path), '--output', str(bags / 'options'), *options])
    assert [(one.separate, one.unit) for one in given] == 2 * [(['B'], ['temperature=K'])]


def workers(process):
    """The processes that a campaign has its runs done in."""
    return [p for p in psutil.Process(process.pid).children() if 'spawn_main' in ' '.join(p.cmdline())]


def wait_for(condition, seconds=60.0):
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, 'waited in vain'
        time.sleep(0.02)
    return found


def caught(worker, output):
    """The number of the run that a worker was stopped in the middle of; None where it was between two."""
    worker.suspend()
    wait_for(lambda: worker.status() == psutil.STATUS_STOPPED)
    drafts = [path.name for path in (output / '.unfinished').rglob('run_*-*')]
    if not drafts:
        worker.resume()
        return None
    (draft,) = drafts
    return int(draft.partition('-')[0].removeprefix('run_'))


@pytest.mark.long
def test_a_process_that_is_killed_costs_its_run_and_ctrl_c_keeps_the_rest(bags):
    runs = [f'{{name: run_{k}, bags: [bag_{k % 2}]}}' for k in range(30)]
    output = bags / 'killed'
    command = [*TOOL, 'diagnose', '--manifest', str(manifest(bags, 'killed.yaml', *runs)), '--output', str(output)]
    process = subprocess.Popen(  # who starts the tests in the background has SIGINT ignored, and that is inherited
        ['env', '--default-signal=INT', *command, '--jobs', '1'],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        (first,) = wait_for(lambda: workers(process))
        wait_for((output / 'run_0').is_dir)
        lost = wait_for(lambda: caught(first, output))
        first.kill()
        wait_for((output / f'run_{lost + 1}').is_dir)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: everyone hears it
        said, complained = process.communicate(timeout=60)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 130, complained
    assert 'Traceback' not in complained
    assert f'  run_{lost}: its process died (SIGKILL; out of memory?)' in said
    assert '1 of 30 runs failed' in said
    assert 'INTERRUPTED' in said
    reports = {path.name for path in output.iterdir() if path.is_dir()}
    assert {'run_0', f'run_{lost + 1}'} <= reports and f'run_{lost}' not in reports and len(reports) < 29
    assert all(whole(output / name) for name in reports)


def test_a_process_whose_parent_leaves_before_it_reads_the_outcome_ends_without_a_word(bags, capfd):
    task = Task('none', ('no_such_bag',), '', str(bags), argparse.Namespace(), '')
    pipe, process = _started()
    pipe.send(task)
    assert pipe.poll(60.0)
    pipe.close()  # what it sent is unread: its end of the pipe is reset, not closed
    process.join(60.0)
    assert process.exitcode == 0
    assert capfd.readouterr().err == ''


@pytest.fixture
def cluster(tmp_path):
    """A dask scheduler and two workers of one thread on loopback: (address, [worker, worker])."""
    pytest.importorskip('distributed', reason="needs the extra 'cluster'")
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(filter(None, sys.path))}
    started = []

    def start(*words):
        log = (tmp_path / f'log_{len(started)}').open('w')
        command = [sys.executable, '-m', 'distributed.cli.' + words[0], *words[1:]]
        started.append(subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, env=environment, cwd=tmp_path))
        log.close()
        return started[-1]

    try:
        told = tmp_path / 'scheduler.json'
        start('dask_scheduler', '--host', '127.0.0.1', '--port', '0', '--no-dashboard', '--scheduler-file', str(told))
        wait_for(told.exists)
        options = ('--scheduler-file', str(told), '--nthreads', '1', '--no-nanny', '--no-dashboard')
        pair = [start('dask_worker', *options, '--host', '127.0.0.1', '--name', name) for name in ('victim', 'heir')]
        address = json.loads(wait_for(told.read_text))['address']
        for k in (1, 2):
            wait_for(lambda k=k: 'Registered to' in Path(tmp_path / f'log_{k}').read_text())
        yield address, pair
    finally:
        for process in reversed(started):
            process.kill()
            process.wait()


@pytest.mark.long
def test_a_cluster_loses_nothing_where_a_worker_is_killed_in_the_middle(bags, cluster):
    import distributed

    address, (victim, _) = cluster
    runs = [f'{{name: run_{k}, bags: [bag_{k % 2}]}}' for k in range(5)]
    output = bags / 'cluster'
    command = [*TOOL, 'diagnose', '--manifest', str(manifest(bags, 'many.yaml', *runs)), '--output', str(output)]
    process = subprocess.Popen(
        [*command, '--scheduler', address.removeprefix('tcp://')],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        with distributed.Client(address) as client:
            wait_for(lambda: any((output / '.unfinished').rglob('run_*/figures')))
            names = {url: worker['name'] for url, worker in client.scheduler_info()['workers'].items()}
            lost = [runs for url, runs in client.processing().items() if names[url] == 'victim']
            victim.kill()
        assert lost and lost[0], 'the worker had nothing to lose'
        assert process.poll() is None
        said, complained = process.communicate(timeout=90)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 0, complained
    assert 'Traceback' not in complained
    assert 'failed' not in said
    assert all(whole(output / f'run_{k}') for k in range(5))
    assert not (output / '.unfinished').exists()


@pytest.mark.parametrize(
    ('address', 'told'),
    [
        ('here', 'expected HOST:PORT, as in localhost:8786'),
        ('127.0.0.1:1', 'nobody answers there (Connection refused)'),
    ],
)
def test_where_no_scheduler_answers_it_is_one_line(bags, capsys, address, told):
    pytest.importorskip('distributed', reason="needs the extra 'cluster'")
    path = manifest(bags, 'nobody.yaml', '{name: run, bags: [bag_0]}')
    assert main(['diagnose', '--manifest', str(path), '--output', str(bags / 'nobody'), '--scheduler', address]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f'--scheduler {address}: {told}' in line

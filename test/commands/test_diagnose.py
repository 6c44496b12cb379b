"""``tcp_muscle diagnose``: what it adds to a diagnosis from the recordings themselves, and how it is interrupted."""

import json
import signal
import subprocess
import sys

import jsonschema
import numpy as np
import pytest
from report.diagnoses import NOMINAL, match

from tcp_muscle_ros.diagnosis.answer.issues import with_issues
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.recording.bag_writer import write_recording
from tcp_muscle_ros.recording.mending import Mended
from tcp_muscle_ros.recording.recording import Channel, Recording
from tcp_muscle_ros.report.report_json import schema
from tcp_muscle_ros.settings.parameter_file import read, write
from tcp_muscle_ros.tool import main

TOOL = (sys.executable, '-m', 'tcp_muscle_ros.tool')


def recording_of(made, path='bag', notes=()):
    """The recording that an experiment was."""
    channels = {name: Channel(name, o.time, o.value, name) for name, o in made.observed.items()}
    channels['current'] = Channel('current', made.imposed.time, made.imposed.drive, 'current')
    return Recording(str(path), channels, 0, {'load_n': made.holding.starting_load}, notes)


@pytest.fixture
def bag(tmp_path):
    (written,) = bags_of(tmp_path, 'bag')
    return written


def bags_of(folder, *names):
    """The recording of a muscle that is nominal, under each of these names."""
    _, (made,) = match()
    for name in names:
        write_recording(folder / name, recording_of(made))
    return [folder / name for name in names]


def test_the_checks_of_the_recordings_are_in_the_report():
    diagnosis, (made,) = match()
    recording = recording_of(made, notes=('the bag was cut short',))
    stroke = recording['displacement']
    kept = (stroke.time < 100.0) | (stroke.time > 112.0)
    recording.channels['displacement'] = Channel('displacement', stroke.time[kept], stroke.value[kept], 'displacement')
    experiment = prepare(recording, NOMINAL, most=1000)

    mended = [Mended((recording,), ())]
    (summary,) = with_issues(diagnosis, [recording], mended, [experiment]).recordings
    told = '\n'.join(summary.issues)
    assert 'displacement: no sample for 12.2 s from 99.900 s' in told
    assert 'averaged in blocks of up to so many samples: temperature (4)' in told
    assert summary.issues.count('the bag was cut short') == 1
    assert np.isfinite(summary.duration)

    again = diagnosis
    for _ in range(2):
        again = with_issues(again, [recording], mended, [experiment])
    assert again.recordings == (summary,)


@pytest.mark.processes
@pytest.mark.slow
def test_an_interrupted_diagnosis_leaves_a_partial_report(tmp_path):
    # Long enough to be caught at it: of one bag alone the work may end before it tells how far it is.
    bags = [str(bag) for bag in bags_of(tmp_path, *(f'bag_{number}' for number in range(15)))]
    # Who starts the tests in the background has SIGINT ignored, and that is inherited.
    process = subprocess.Popen(
        ['env', '--default-signal=INT', *TOOL, 'diagnose', *bags, '--output', str(tmp_path / 'report')],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stderr.readline().startswith('diagnosing: ')
        process.send_signal(signal.SIGINT)
        said, complained = process.communicate(timeout=120)
    finally:
        process.kill()
    assert process.returncode == 130, complained
    assert 'Traceback' not in complained
    assert 'INTERRUPTED' in said
    content = json.loads((tmp_path / 'report' / 'report.json').read_text())
    jsonschema.validate(content, schema())
    assert content['partial'] is True
    assert 'interrupted' in (tmp_path / 'report' / 'report.html').read_text()
    assert read(tmp_path / 'report' / 'improved.yaml').parameters.effects == ()


@pytest.mark.processes
def test_a_folder_that_holds_something_is_refused_before_any_work(bag, tmp_path):
    (tmp_path / 'report').mkdir()
    (tmp_path / 'report' / 'mine.txt').write_text('kept')
    done = subprocess.run(
        [*TOOL, 'diagnose', str(bag), '--output', str(tmp_path / 'report')], capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (2, '')
    (line,) = done.stderr.splitlines()
    assert 'report: is not empty and is not overwritten; give another --output, or --force' in line


@pytest.mark.slow
def test_a_muscle_that_is_exactly_nominal_is_a_match_though_its_noise_moves_a_parameter(tmp_path, monkeypatch):
    """Recalibration moves the parameters beyond their intervals here, and improves nothing."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'protocol.yaml').write_text(
        'rate_hz: 10\ninput: current\nend: load\nload_n: 0.588\nrepeat: 3\nsegments:\n'
        '  - {duration_s: 25, value: 0.27}\n  - {duration_s: 45, value: 0}\n'
    )
    noise = {'temperature_noise_k': 0.2, 'resistance_noise_ohm': 0.02, 'displacement_noise_m': 5e-5}
    write('muscle.yaml', NOMINAL, operating={'load_n': 0.588, 'seed': 6, **noise})
    assert main(['simulate', 'protocol.yaml', '--params', 'muscle.yaml', '--output', 'bag']) == 0
    assert main(['diagnose', 'bag', '--output', 'report']) == 0
    report = json.loads((tmp_path / 'report' / 'report.json').read_text())
    assert report['verdict'] == 'match'
    for fit in report['fit'].values():
        assert fit['rmse_nominal'] == pytest.approx(fit['rmse_calibrated'], rel=0.02)

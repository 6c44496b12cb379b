"""The public recordings, where they are: every run is in the document, and a calibration helps each kind of it."""

import os
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from tcp_muscle_ros.diagnosis.answer.replaying import replay
from tcp_muscle_ros.diagnosis.diagnose import diagnose
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.fitting.least_squares import fit
from tcp_muscle_ros.diagnosis.noise.repeatability import between_runs
from tcp_muscle_ros.diagnosis.noise.replicates import protocols
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording.csv_import import import_runs, lab_files
from tcp_muscle_ros.recording.import_map import read_import_map

ROOT = Path(__file__).resolve().parent.parent
DATA = Path(os.environ.get('TCP_MUSCLE_SHARED', ROOT.parent / 'shared')) / 'data'
NOMINAL = Parameters.named('karami_tadesse_2017')

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason=f'the public recordings are not at {DATA}')


@pytest.fixture(scope='module')
def runs():
    found = {}
    for rig in ('bench', 'video'):
        import_map = read_import_map(ROOT / 'config' / f'import_tca_{rig}_rig.yaml')
        for run in import_runs(import_map, lab_files([DATA / f'tca_{rig}_rig'])):
            found[run.name] = run.recording
    return found


def test_every_run_has_its_row_in_the_document(runs):
    page = (ROOT / 'docs' / 'real_recordings.md').read_text()
    missing = [name for name in runs if f'| {name} |' not in page and 'outlier' not in name]
    assert missing == []


@pytest.mark.parametrize('name', ['stroke_3W_2a', 'force_3W_1', 'force_trial1_5W_1', 'mandrel_3W_forced_1'])
def test_a_calibrated_muscle_is_closer_to_the_recording_than_the_papers(runs, name):
    experiment = prepare(runs[name], NOMINAL)
    calibration = calibrate([experiment], NOMINAL)
    channel = next(iter(experiment.observed))
    left = calibration.rmse()[channel][0]
    compared = replay(experiment, NOMINAL)[channel]
    assert left < 0.5 * compared.rmse
    assert left < 0.12 * float(np.ptp(experiment.observed[channel].value))


@pytest.mark.parametrize('name', ['self_coiled_3W_free_1', 'force_4W_3', 'stroke_4W_7'])
def test_a_stroke_or_a_force_alone_is_fitted_as_well_from_nowhere_else(runs, name):
    """Gain, heat exchange and capacity trade against each other: a fit that gives up early ends anywhere in between."""
    fitted = calibrate([prepare(runs[name], NOMINAL)], NOMINAL).fit
    problem, names = fitted.problem, [u.name for u in fitted.problem.unknowns]
    for hA, C in product((0.4, 1.0, 3.0), repeat=2):
        z = problem.start()
        z[names.index('hA')] += np.log(hA)
        z[names.index('C')] += np.log(C)
        assert fitted.objective < fit(problem, z, rounds=200).objective + problem.policy.told_apart, (hA, C)


def test_runs_of_one_power_are_found_by_themselves_and_repeat_as_the_document_says(runs):
    stroke = [prepare(runs[n], NOMINAL, most=200) for n in sorted(runs) if n.startswith('stroke_')]
    assert [len(p.recordings) for p in protocols(stroke)] == [5, 6, 5, 8]
    found = between_runs(stroke)['displacement']
    page = (ROOT / 'docs' / 'real_recordings.md').read_text()
    row = next(line for line in page.splitlines() if line.startswith('| bench rig, stroke |'))
    assert 100.0 * found.own_gain == pytest.approx(float(row.split('|')[4]), abs=0.15)
    assert found.gains_differ and found.plain > 0.15


def test_no_circumstance_is_named_on_the_public_rigs(runs):
    page = (ROOT / 'docs' / 'real_recordings.md').read_text()
    rows = [line.split('|') for line in page.splitlines() if line.startswith(('| bench rig', '| video rig'))]
    assert len(rows) == 7
    for cells in rows:
        assert 'airflow' not in cells[8] and 'ambient' not in cells[8]
    assert 'no other listed effect explains as much' not in page


@pytest.mark.long
def test_strokes_that_stick_and_slip_are_predicted_without_their_jumps(runs):
    """Five strokes of tens of millimetres: nothing is named, how the runs differ is said, and no jump is copied."""
    names = ('stroke_1W_2', 'stroke_1W_3', 'stroke_3W_2a', 'stroke_4W_5', 'stroke_4W_6')
    found = diagnose([prepare(runs[n], NOMINAL, most=250) for n in names], NOMINAL)
    assert found.verdict in ('not_repeatable', 'unexplained') and found.findings == ()
    assert any('runs of one protocol differ in the stroke' in note for note in found.notes)
    assert not any('a reading changed suddenly' in note for note in found.notes)
    assert found.fit['displacement'].improved == pytest.approx(found.fit['displacement'].calibrated)


def test_the_table_of_the_document_counts_the_runs_that_stick(runs, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / 'scripts'))
    from repeatability import sticks

    mine = {n: prepare(runs[n], NOMINAL, most=None) for n in ('stroke_3W_1a', 'stroke_3W_5a', 'force_4W_1')}
    assert [sticks([run]) for run in mine.values()] == [1, 1, 0]


def test_what_comes_late_is_a_cluster_across_stages(runs):
    """The positions were read every second, and later every two: a lag of the supply of 0.6 s is resolved no less than
    one of the core or a clock."""
    names = ('mandrel_1W_free_1', 'mandrel_3W_free_0g_1', 'mandrel_3W_free_20g_1')
    found = diagnose([prepare(runs[n], NOMINAL, most=250) for n in names], NOMINAL)
    (finding,) = found.findings
    members = {m.effect: m for m in finding.cluster}
    assert {'supply_lag', 'two_node', 'clock_skew'} <= set(members)
    assert {m.stage for m in members.values()} == {'electrical', 'thermal', 'sensor'}
    assert sum(m.probability for m in members.values()) == pytest.approx(1.0)
    assert finding.effect in members and not finding.singled_out

"""``tcp_muscle investigate``: what it says of the run that was kept back."""

import json
import re
import shutil
from argparse import ArgumentParser
from types import SimpleNamespace

import pytest

from tcp_muscle_ros.commands import investigate
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.settings.ages import Age, write_ages
from tcp_muscle_ros.settings.parameter_file import write
from tcp_muscle_ros.tool import main

MUSCLE = Parameters({'hA': 0.0212})
WORN = MUSCLE.with_effects('fatigue')
LAGGING = 'instruments: {temperature: {lag_s: %s}}\n'
PROTOCOL = """
rate_hz: 10
input: current
load_n: 0.588
segments: [{duration_s: 10, value: 0}, {duration_s: 40, value: 0.2}, {duration_s: 40, value: 0}]
"""


def arguments(*words):
    parser = ArgumentParser()
    investigate.add_arguments(parser)
    return parser.parse_args(list(map(str, words)))


@pytest.fixture(scope='module')
def found(tmp_path_factory):
    """The folder of an investigation that is to be concluded: of a muscle that wore, before a thermometer that lags."""
    folder = tmp_path_factory.mktemp('found')
    truth = WORN.with_effects('thermocouple_lag').replace({'thermocouple_lag.tau': 2.5, 'fatigue.n0': 4000.0})
    write(folder / 'truth.yaml', truth, operating={'temperature_noise_k': 0.05, 'displacement_noise_m': 1e-6})
    (folder / 'protocol.yaml').write_text(PROTOCOL)
    bag = folder / 'kept_back'
    asked = ('--params', str(folder / 'truth.yaml'), '--output', str(bag))
    assert main(['simulate', str(folder / 'protocol.yaml'), *asked]) == 0
    report = folder / 'reports' / 'report_1'
    report.mkdir(parents=True)
    write(report / 'improved.yaml', WORN)
    recording = read_bag(bag)
    then = Age(recording.start_ns, {'fatigue.n0': 4000.0}, recording.end, recording.fingerprint)
    write_ages(report / 'improved.yaml', [then])
    (report / 'rig.yaml').write_text(LAGGING % 2.5)
    (folder / 'known.yaml').write_text(LAGGING % 2.0)
    return folder


@pytest.mark.parametrize('known', [True, False])
def test_the_error_of_the_run_that_was_kept_back_is_that_which_replay_shows(found, tmp_path, capsys, known):
    rig = ('--rig', str(found / 'known.yaml')) if known else ()
    shutil.copytree(found, tmp_path / 'done')
    done, steps = tmp_path / 'done', {'end': [{'why': ''}], 'diagnosis': [{'headline': ''}], 'run': []}
    log = SimpleNamespace(of=lambda step: steps.get(step, []))
    ended = SimpleNamespace(last_report=done / 'reports' / 'report_1', kept_back=[found / 'kept_back'], log=log)
    investigate._conclude(arguments('--output', done, *rig), ended, done)
    kept_back = json.loads((done / 'summary.json').read_text())['kept_back']
    capsys.readouterr()
    improved = ('--params', str(done / 'improved.yaml'), '--rig', str(done / 'report' / 'rig.yaml'))
    for when, words in (('rmse_before', ('--params', 'karami_tadesse_2017', *rig)), ('rmse_after', improved)):
        assert main(['replay', str(found / 'kept_back'), *words]) == 0
        shown = re.search(r'temperature +\d+ +(\S+) K', capsys.readouterr().out)
        assert kept_back['temperature'][when] == pytest.approx(float(shown[1]), rel=0.01)
    assert kept_back['temperature']['rmse_after'] == pytest.approx(0.05, rel=0.1)
    assert kept_back['displacement']['rmse_after'] < 2e-6

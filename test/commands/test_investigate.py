"""``tcp_muscle investigate``: with what it goes on when resumed, and what it says of the run that was kept back."""

import json
import re
import shutil
from argparse import ArgumentParser
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from recording.bags import float64, temperature, write_foreign

from tcp_muscle_ros.commands import investigate, plants
from tcp_muscle_ros.commands.investigation import Investigation, Log
from tcp_muscle_ros.commands.plants import Simulated
from tcp_muscle_ros.commands.run import allowed_by
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Parameters, simulate
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.protocol import read_protocol
from tcp_muscle_ros.settings.ages import Age, write_ages
from tcp_muscle_ros.settings.parameter_file import write
from tcp_muscle_ros.settings.rig import RigLimits
from tcp_muscle_ros.tool import main

MUSCLE = Parameters({'hA': 0.0212})
WORN = MUSCLE.with_effects('fatigue')
LASER = ('--channel', 'displacement=/laser', '--unit', 'displacement=mm')
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


@pytest.mark.parametrize(('known', 'read'), [(True, ()), (False, ()), (True, LASER)])
def test_the_error_of_the_run_that_was_kept_back_is_that_which_replay_shows(found, tmp_path, capsys, known, read):
    rig = (*(('--rig', str(found / 'known.yaml')) if known else ()), *read)
    shutil.copytree(found, tmp_path / 'done')
    done, steps = tmp_path / 'done', {'end': [{'why': ''}], 'diagnosis': [{'headline': ''}], 'run': []}
    log = SimpleNamespace(of=lambda step: steps.get(step, []))
    bag = with_laser(found / 'kept_back', tmp_path / 'laser') if read else found / 'kept_back'
    ended = SimpleNamespace(last_report=done / 'reports' / 'report_1', kept_back=[bag], log=log)
    asked = investigate._complete(arguments('--params', 'karami_tadesse_2017', '--output', done, *rig))
    investigate._conclude(asked, ended, done)
    kept_back = json.loads((done / 'summary.json').read_text())['kept_back']
    capsys.readouterr()
    improved = ('--params', str(done / 'improved.yaml'), '--rig', str(done / 'report' / 'rig.yaml'), *read)
    for when, words in (('rmse_before', ('--params', 'karami_tadesse_2017', *rig)), ('rmse_after', improved)):
        assert main(['replay', str(bag), *words]) == 0
        shown = re.search(r'temperature +\d+ +(\S+) K', capsys.readouterr().out)
        assert kept_back['temperature'][when] == pytest.approx(float(shown[1]), rel=0.01)
    if read:  # of this bag no age is known: the muscle is taken as worn as it is now
        assert kept_back['displacement']['rmse_after'] < 1e-3
    else:
        assert kept_back['temperature']['rmse_after'] == pytest.approx(0.05, rel=0.1)
        assert kept_back['displacement']['rmse_after'] < 2e-6


def with_laser(bag, path):
    """A bag with its current, temperature and load, and the displacement in mm on a topic of its own."""
    recording = read_bag(bag)
    topics = {'current': '/current', 'temperature': '/temperature', 'load': '/load', 'displacement': '/laser'}
    told = {'temperature': lambda value: value - 273.15, 'displacement': lambda value: 1e3 * value}
    rows = []
    for name, topic in topics.items():
        for time, value in zip(recording[name].time, recording[name].value, strict=True):
            stamp = recording.start_ns + round(1e9 * time)
            shown = float(told.get(name, float)(value))
            rows.append((topic, stamp, temperature(shown, stamp) if name == 'temperature' else float64(shown)))
    return write_foreign(path, rows)


@pytest.fixture
def begun(tmp_path, monkeypatch):
    """An investigation of a simulated muscle that was stopped before its first run, in ``lab/inquiry``."""
    (tmp_path / 'lab').mkdir()
    monkeypatch.chdir(tmp_path / 'lab')
    write(Path('mine.yaml'), MUSCLE)
    Path('rig.yaml').write_text('limits: {largest_current_a: 0.15}\n')
    monkeypatch.setattr(investigate, 'driver_allows', lambda *_: pytest.fail('asks the muscle on the topics'))
    monkeypatch.setattr(Investigation, 'run', interrupted)
    asked = ('--params', 'mine.yaml', '--simulated', 'mine.yaml', '--rig', 'rig.yaml', '--minutes', '60', '--yes')
    assert main(['investigate', '--output', 'inquiry', *asked]) == 130
    return Path('inquiry').absolute()


def interrupted(_):
    raise KeyboardInterrupt


def test_what_is_resumed_goes_on_as_it_was_begun_from_any_folder(begun, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    args, _, begin = investigate.admit(arguments('--output', begun, '--resume'))
    assert (args.minutes, args.runs, args.yes, args.namespace) == (60.0, 20, True, '')
    assert [args.params, args.simulated] == [str(tmp_path / 'lab' / 'mine.yaml')] * 2
    made = begin()
    assert isinstance(made._plant, Simulated)
    assert max(one.sampled().drive.max() for one in made._rounds[0]) <= 0.15


def test_a_budget_that_is_given_anew_holds_from_then_on_and_the_muscle_may_be_named_again(begun):
    again = ('--params', str(Path('mine.yaml').absolute()), '--rig', './rig.yaml')
    assert main(['investigate', '--output', str(begun), '--resume', '--minutes', '120', '--runs', '9', *again]) == 130
    args = investigate.admit(arguments('--output', begun, '--resume')).args
    assert (args.minutes, args.runs, args.cycles) == (120.0, 9, 1000)


@pytest.mark.parametrize(
    ('words', 'was'),
    [
        (('--params', 'karami_tadesse_2017'), "lab/mine.yaml')"),
        (('--simulated', 'karami_tadesse_2017'), "lab/mine.yaml')"),
        (('--rig', 'other.yaml'), "lab/rig.yaml')"),
        (('--namespace', 'thumb'), '(none)'),
        (('--first', 'protocol.yaml'), '(none)'),
        (('--unit', 'displacement=mm'), '(none)'),
        (('--channel', 'displacement=/laser/range.range'), '(none)'),
    ],
)
def test_what_names_another_muscle_than_it_was_begun_with_is_refused_in_one_line(begun, capsys, words, was):
    kept = (begun / 'settings.json').read_text()
    capsys.readouterr()
    assert main(['investigate', '--output', str(begun), '--resume', *words]) == 2
    said = capsys.readouterr().err.strip()
    assert f"--resume: {words[0]} '{words[1]}' is not that which it was begun with" in said and said.endswith(was)
    assert '\n' not in said and (begun / 'settings.json').read_text() == kept


@pytest.mark.parametrize('text', ['', '[]', '{"params'])
def test_a_folder_whose_settings_are_torn_is_none_of_an_investigation(begun, capsys, text):
    (begun / 'settings.json').write_text(text)
    assert main(['investigate', '--output', str(begun), '--resume']) == 2
    assert 'is no folder of an investigation' in capsys.readouterr().err


@pytest.mark.long
def test_a_report_that_the_diagnosis_of_a_killed_investigation_left_meanwhile_is_replaced(found, tmp_path):
    left = tmp_path / 'report_1'
    left.mkdir()
    (left / 'report.json').write_text('{"schema": "tcp_muscle_ros/diagnosis-2"}')
    content = investigate._diagnosed([found / 'kept_back'], left, investigate._complete(arguments('--output', 'x')))
    assert content['headline'] and content == json.loads((left / 'report.json').read_text())


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        (
            ('--channel', 'displacement=/laser', '--simulated', 'x.yaml'),
            'a simulated muscle has no topic beside its own',
        ),
        (('--channel', 'displacement'), 'expected --channel NAME=TOPIC[.FIELD]'),
        (('--unit', 'mm'), 'expected --unit NAME=UNIT'),
    ],
)
def test_what_says_how_bags_are_read_is_refused_before_anything_is_recorded(tmp_path, words, said):
    with pytest.raises(BadInput, match=re.escape(said)):
        investigate.admit(arguments('--output', tmp_path / 'new', *words))


def test_a_sensor_on_a_topic_of_its_own_is_recorded_in_every_run(tmp_path, monkeypatch):
    (tmp_path / 'p.yaml').write_text(PROTOCOL)
    named = ('--channel', 'displacement=/laser/range.range', '--channel', 'ambient=/room', '--namespace', 'thumb')
    args, asked = investigate._complete(arguments('--output', tmp_path / 'new', *named)), {}

    def play(*_, **words):
        asked.update(words)
        return SimpleNamespace(interrupted=False, bags=())

    monkeypatch.setattr(plants, 'play', play)
    plants.Live(args, MUSCLE, None, print).record(tmp_path / 'p.yaml', tmp_path / 'bag')
    assert asked['topics'] == ('/laser/range', '/room') and asked['namespace'] == 'thumb'


def test_a_simulated_muscle_is_as_old_in_a_run_as_those_before_made_it(tmp_path):
    """What a diagnosis counts, too: one that was new in every run would lack a wear that the runs have."""
    muscle = MUSCLE.with_effects('fatigue')
    write(tmp_path / 'mine.yaml', muscle, operating={'temperature_noise_k': 0.05})
    for name in ('protocols', 'runs'):
        (tmp_path / name).mkdir()
    plant, log = Simulated(str(tmp_path / 'mine.yaml'), tmp_path), Log(tmp_path)
    shown = {}
    for name in ('run_1', 'run_2', 'run_3'):
        protocol = tmp_path / 'protocols' / f'{name}.yaml'
        protocol.write_text(PROTOCOL)
        (bag,) = plant.record(protocol, tmp_path / 'runs' / name)
        log.add('run', name=name)
        shown[name] = read_bag(bag)
    first, second, third = (one['displacement'].value for one in shown.values())
    assert len({tuple(one['temperature'].value) for one in shown.values()}) == 3, 'each has noise of its own'
    drive = read_protocol(tmp_path / 'protocols' / 'run_1.yaml').sampled()
    travel = np.abs(np.diff(simulate(muscle, drive.time, drive.drive, load=drive.load).temperature)).sum()
    worn = simulate(muscle.replace({'fatigue.n0': travel / 100.0}), drive.time, drive.drive, load=drive.load)
    np.testing.assert_allclose(second, worn.displacement, atol=1e-9)
    assert first.max() > second.max() > third.max()


@pytest.mark.parametrize('longest', [200.0, 1e6, 100.0])
def test_what_lasts_longer_than_a_rig_runs_is_left_out_and_a_rig_that_runs_for_no_protocol_is_refused(longest):
    limits = RigLimits(loads=(0.3, 0.588), by_person=False, longest_run=longest)
    asked = (investigate._complete(arguments('--output', 'x')), MUSCLE, limits, allowed_by(limits, None))
    if longest == 100.0:
        with pytest.raises(BadInput, match='but the longest run is 100 s'):
            investigate._protocols(*asked)
        return
    rounds, kept = investigate._protocols(*asked)
    played = [protocol for those in rounds for protocol in those]
    assert all(protocol.duration <= longest for protocol in [*played, kept])
    assert (len(played) == 13) == (longest == 1e6) and all(rounds)

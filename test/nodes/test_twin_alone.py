"""The twin's node in this process, without a muscle: what it makes of what it is handed."""

import json
import os
import time
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

import rclpy
from rclpy.clock import ClockType
from rclpy.parameter import Parameter
from rclpy.time import Time
from std_msgs.msg import Float64

from tcp_muscle_ros.control.twin import Difference, State
from tcp_muscle_ros.muscle import Muscle, Parameters
from tcp_muscle_ros.nodes import twin_alarm
from tcp_muscle_ros.nodes.twin_alarm import save
from tcp_muscle_ros.nodes.twin_hearing import Heard
from tcp_muscle_ros.nodes.twin_node import TwinNode
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.settings.intervals import SCHEMA, path_beside
from tcp_muscle_ros.settings.parameter_file import read, write

RUN = [1000.0 + 0.01 * k for k in range(200)]  # s, two of them
_LEFT = []  # nodes: kept, so that nothing destroys them (see conftest.py)


def heard(when):
    """What a cold muscle shows."""
    return Heard(when, {'temperature': 296.15, 'displacement': 0.0, 'current': 0.0})


@pytest.fixture
def twin(request, tmp_path):
    """A node whose ticks are not begun, with the parameters that the test asks for."""
    given = {'report_folder': tmp_path, 'keep_s': 20.0, **getattr(request, 'param', {})}
    arguments = [word for name, value in given.items() for word in ('-p', f'{name}:={value}')]
    rclpy.init(args=['--ros-args', *arguments], domain_id=1 + (os.getpid() + 61) % 100)
    made = TwinNode()
    _LEFT.append(made)
    yield made
    rclpy.try_shutdown()


def until(condition):
    """Wait for what another node is to bring about."""
    deadline = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def message(twin):
    """What the twin's diagnostics say."""
    said = []
    twin._diagnostics = SimpleNamespace(publish=said.append)
    twin._look_after()
    return said[0].status[0].message


def test_what_two_models_are_compared_on_can_be_set_while_it_runs(twin):
    (done,) = twin.set_parameters([Parameter('trial_s', value=7.0)])
    assert done.successful
    assert twin._twin.trial == 7.0


@pytest.mark.parametrize('twin', [{'use_sim_time': True}], indirect=True)
def test_where_no_simulated_time_comes_the_twin_says_so_and_where_it_ends_too(twin):
    said = []
    twin._diagnostics = SimpleNamespace(publish=said.append)
    until(lambda: rclpy.spin_once(twin, timeout_sec=0.1) or said)
    assert said[0].status[0].message == 'waits for a muscle: use_sim_time is true, but no /clock has come'
    of_simulation = twin.get_clock()
    for now, why in ((5, ''), (6, ''), (6, ': /clock stands still'), (7, '')):
        of_simulation.set_ros_time_override(Time(seconds=now, clock_type=ClockType.ROS_TIME))
        assert message(twin) == f'waits for a muscle{why}'


def test_what_comes_after_its_tick_was_taken_loses_nothing(twin):
    for when in (*RUN, RUN[-1] - 0.001, RUN[-1] + 0.01):
        twin._take(heard(when))
    assert twin._follows_since is not None
    time, _ = twin._memory.columns()['current']
    assert time.tolist() == [*RUN, RUN[-1] + 0.01]


@pytest.mark.parametrize('twin', [{}, {'rate_hz': 1.0}], indirect=True)
def test_a_muscle_at_1_hz_is_followed(twin):
    """Its ticks are a little more than a second apart."""
    for k in range(5):
        twin._take(heard(1000.0 + 1.0003 * k))
    assert twin._follows_since is not None


def test_where_the_clock_is_set_back_what_is_kept_begins_anew(twin, tmp_path):
    """A bag's times go on: what came before the clock was set back would be left out, or what came after it."""
    for when in (*RUN, *(when - 5.0 for when in RUN)):
        twin._take(heard(when))
    save(tmp_path / 'bag', twin._memory.columns(), 0.0, 0.5)
    kept = read_bag(tmp_path / 'bag')
    assert not kept.notes and not kept.broken
    assert len(kept['current'].time) == len(RUN)
    assert kept.start_ns == pytest.approx((RUN[0] - 5.0) * 1e9)


@pytest.mark.parametrize('twin', [{}, {'rate_hz': 10.0}], indirect=True, ids=['kept', 'fell out of what is kept'])
def test_a_bag_says_the_load_and_the_room_that_were_said_before_it_begins(twin, tmp_path):
    """They are said where they change; a healthy muscle was diagnosed as one under the load of its file."""
    for k in range(500):
        said = {'load': 0.3, 'ambient': 291.0} if k == 0 else {}
        twin._take(Heard(1000.0 + 0.02 * k, {**heard(0.0).values, **said}))
    save(tmp_path / 'bag', twin._memory.columns(), 1009.01, 0.5)
    kept = read_bag(tmp_path / 'bag')
    assert (kept['load'].time.tolist(), kept['load'].value.tolist()) == ([0.0], [0.3])
    assert (kept['ambient'].time.tolist(), kept['ambient'].value.tolist()) == ([0.0], [pytest.approx(291.0)])
    assert kept['current'].time[0] == 0.0
    assert kept['temperature'].time[0] == pytest.approx(0.01)  # what is measured was so when it was measured


def test_an_alarm_of_before_the_clock_was_set_back_is_raised_anew(twin):
    """Since when it differs nobody could say in the new time."""
    for when in RUN:
        twin._take(heard(when))
    twin._twin.state = State.DIFFERS
    twin._take(heard(RUN[0] - 3600.0))
    assert twin._twin.state is State.FOLLOWS and twin._twin.difference is None


class Diagnosed:
    """In place of a diagnosis: it ends at once, with this model (None: without a report)."""

    def __init__(self, monkeypatch, model, beside=None, instruments='{}', **operating):
        self.params, self.bags = [], []  # what it was given, one entry a diagnosis

        def begun(command, **_):
            words = dict(pairwise(command))
            self.params.append(read(words['--params']))
            self.bags.append(read_bag(words['diagnose']))
            self.rig = words.get('--rig')
            report = Path(words['--output'])
            if model is not None:
                report.mkdir()
                (report / 'report.json').write_text('{"headline": "found"}')
                write(report / 'improved.yaml', model, operating=operating)
                (report / 'rig.yaml').write_text(f'instruments: {instruments}')
            if beside is not None:
                path_beside(report / 'improved.yaml').write_text(beside)
            return SimpleNamespace(pid=os.getpid(), poll=lambda: 0, returncode=0 if model is not None else 1)

        monkeypatch.setattr(twin_alarm, 'subprocess', SimpleNamespace(Popen=begun))
        monkeypatch.setattr(twin_alarm.os, 'setpriority', lambda *_: None)


def differs(twin, since):
    """What the twin's test may say at any time."""
    twin._twin.state = State.DIFFERS
    twin._twin.difference = Difference('electrical', 'resistance', since, 1.0)
    twin._notice()


def goes_on(twin, seconds):
    """So much later, with what a cold muscle shows meanwhile and one look a second."""
    for _ in range(round(seconds)):
        for _ in range(10):
            twin._take(heard(twin._then + 0.1))
        twin._notice()
        twin._look_after()


WORN = Parameters.named('karami_tadesse_2017').replace({'R0': 15.0})
ADOPTING = {'auto_diagnose': True, 'auto_adopt': True, 'collect_s': 3.0}


def adopts(twin):
    """The model on trial takes the other's place."""
    (trial,) = (one for one in twin._twin._trials if not one.former)
    trial.other = 1.0
    with twin._lock:
        twin._twin._decide(trial, twin._then)
        twin._notice()


@pytest.mark.parametrize('twin', [ADOPTING], indirect=True)
def test_an_alarm_after_an_adoption_is_diagnosed_against_the_model_that_was_adopted(twin, monkeypatch):
    done = Diagnosed(monkeypatch, WORN, ambient_temperature_c=21.0)
    for when in RUN:
        twin._take(heard(when))
    for _ in range(2):
        differs(twin, twin._then)
        goes_on(twin, 4)
        adopts(twin)
        goes_on(twin, 1)
    first, second = done.params
    assert first.parameters['R0'] != WORN['R0']
    assert second.parameters['R0'] == WORN['R0'] and second.number('ambient_temperature_c') == 21.0
    assert len(twin._found) == 2  # those of the two models of which one is in use


@pytest.mark.parametrize('twin', [ADOPTING], indirect=True)
def test_after_an_adoption_the_state_is_estimated_with_the_adopted_model(twin, monkeypatch):
    """Where nothing came for a while, the model starts from what is measured: here the resistance of a worn wire."""
    Diagnosed(monkeypatch, WORN)
    for when in RUN:
        twin._take(heard(when))
    differs(twin, twin._then)
    goes_on(twin, 4)
    adopts(twin)
    for k in range(200):
        twin._take(Heard(RUN[-1] + 100.0 + 0.01 * k, {'resistance': WORN['R0'], 'current': 0.0}))
    assert twin._follows_since is not None
    assert twin._twin.predictor.fibre_temperature == pytest.approx(WORN['T0'], abs=0.5)


def shown(muscle, flows, when, pull, **more):
    """What a muscle shows that is driven for a hundredth of a second, without noise."""
    reading = muscle.step(0.01, flows, load=pull)
    names = ('temperature', 'resistance', 'displacement')
    return Heard(when, {**{name: getattr(reading, name) for name in names}, **more})


def test_a_current_that_is_heard_no_more_is_not_taken_to_flow_for_ever(twin):
    muscle = Muscle(twin._file.parameters, load=twin._file.number('load_n'), ambient=296.15)
    for k in range(2000):
        twin._take(shown(muscle, 0.2, 1000.0 + 0.01 * k, None, current=0.2))
    assert twin._follows_since is not None
    for k in range(2000, 4000):  # its driver is dead, and the muscle cools
        twin._take(shown(muscle, 0.0, 1000.0 + 0.01 * k, None))
        twin._notice()
    assert twin._follows_since is None and twin._alarms == 0


def test_after_an_adoption_under_another_load_the_state_is_estimated_with_the_zero_of_the_first(twin):
    model = twin._file.parameters
    muscle = Muscle(model, load=twin._file.number('load_n'), ambient=296.15)
    adopted = twin._predictor(twin._file, model.replace(hA=model['hA']))
    for k in range(4000):
        if k == 1000:
            twin._twin._use(adopted)
            twin._twin.start(muscle.reading(0.0).fibre_temperature)
        # A gap of three seconds, after which it starts from what is measured.
        twin._take(shown(muscle, 0.2, 1000.0 + 0.01 * k + 3.0 * (k > 2000), 0.3, current=0.2, load=0.3))
        twin._notice()
    assert twin._alarms == 0
    assert twin._twin.predictor.fibre_temperature == pytest.approx(muscle.reading(0.0).fibre_temperature, abs=0.5)


KNOWN = {'schema': SCHEMA, 'coordinates': [{'name': 'R0', 'log': True, 'spread': 1.0}], 'covariance': [[1e-4]]}


@pytest.mark.parametrize('twin', [ADOPTING], indirect=True)
@pytest.mark.parametrize(('beside', 'exact'), [(json.dumps(KNOWN), False), (None, True), ('damaged', True)])
def test_an_adopted_model_is_as_uncertain_as_the_diagnosis_says(twin, monkeypatch, beside, exact):
    """One that is taken to be exact has too narrow a band, and differs soon."""
    said = []
    monkeypatch.setattr(twin, '_tell', said.append)
    Diagnosed(monkeypatch, WORN, beside)
    for when in RUN:
        twin._take(heard(when))
    differs(twin, twin._then)
    goes_on(twin, 4)
    adopts(twin)
    drawn = [one['R0'] for one in twin._twin.predictor.variants]
    assert twin._twin.predictor.model['R0'] == WORN['R0']
    assert len(drawn) == (0 if exact else 8)
    assert exact or 0.003 < np.std(drawn) / WORN['R0'] < 0.03
    assert any('taken to be exact' in sentence for sentence in said) == (beside == 'damaged')


@pytest.mark.parametrize('twin', [ADOPTING], indirect=True)
@pytest.mark.parametrize(
    ('instruments', 'effects'), [('{temperature: {lag_s: 2.0}}', ('thermocouple_lag',)), ('{thermometer: {}}', ())]
)
def test_an_adopted_model_shows_what_the_rig_shows_that_it_was_found_on(twin, monkeypatch, instruments, effects):
    said = []
    monkeypatch.setattr(twin, '_tell', said.append)
    Diagnosed(monkeypatch, WORN, json.dumps(KNOWN), instruments)
    for when in RUN:
        twin._take(heard(when))
    differs(twin, twin._then)
    goes_on(twin, 4)
    adopts(twin)
    predictor = twin._twin.predictor
    assert {one.effects for one in (predictor.model, *predictor.variants)} == {effects}
    assert (twin._new_alarm()._rig == str(Path(predictor.source).parent / 'rig.yaml')) == bool(effects)
    assert any("unknown key 'thermometer'" in sentence for sentence in said) == (not effects)


def not_adopted(twin):
    """The model on trial, if one is, is found to be no better."""
    for trial in list(twin._twin._trials):
        trial.own = 1.0
        with twin._lock:
            twin._twin._decide(trial, twin._then)


@pytest.mark.parametrize('twin', [{**ADOPTING, 'keep_s': 100.0}], indirect=True)
@pytest.mark.parametrize('model', [WORN, None])
def test_where_no_better_model_is_found_more_is_collected_and_diagnosed_a_few_times(twin, monkeypatch, model):
    said = []
    monkeypatch.setattr(twin, '_tell', said.append)
    done = Diagnosed(monkeypatch, model)
    for when in RUN:
        twin._take(heard(when))
    begun = RUN[0] + 0.5
    differs(twin, begun)
    for _ in range(8):
        goes_on(twin, 5)
        not_adopted(twin)
    durations = [bag.duration for bag in done.bags]
    assert len(done.bags) == 4 and len({bag.path for bag in done.bags}) == 4
    # It began within a second: what came before the end of that is partly of the muscle before.
    assert all(bag.start_ns == pytest.approx((begun + 1.0) * 1e9, abs=1e7) for bag in done.bags)
    assert all(later > before + 2.5 for before, later in pairwise(durations))
    assert twin._alarms == 1
    assert [sentence for sentence in said if 'still differs' in sentence] == [
        f'the muscle still differs: diagnosis {k} of at most 4 follows after a further 3 s' for k in (2, 3, 4)
    ]
    twin._reset(None, SimpleNamespace())
    goes_on(twin, 1)
    differs(twin, twin._then)
    goes_on(twin, 4)
    assert len(done.bags) == 5


@pytest.mark.parametrize('twin', [{**ADOPTING, 'auto_adopt': False}], indirect=True)
def test_what_a_person_has_the_report_of_is_not_diagnosed_again(twin, monkeypatch):
    done = Diagnosed(monkeypatch, WORN)
    for when in RUN:
        twin._take(heard(when))
    differs(twin, twin._then)
    goes_on(twin, 12)
    assert len(done.bags) == 1 and done.rig is None


def test_a_diagnosis_is_told_what_the_instruments_do(tmp_path, monkeypatch):
    done = Diagnosed(monkeypatch, WORN)
    alarm = twin_alarm.Alarm(tmp_path, WORN, {}, print, 'rig.yaml')
    alarm.diagnose({'current': (np.arange(9.0), np.zeros(9))}, 0.0, 0.5)
    assert alarm.poll() == 'found' and done.rig == 'rig.yaml'


def test_where_an_alarm_can_write_nothing_the_log_says_so_and_the_twin_goes_on(twin, tmp_path, monkeypatch):
    said = []
    monkeypatch.setattr(twin, '_tell', said.append)
    (tmp_path / 'taken').write_text('a file')
    twin._settings = {**twin._settings, 'report_folder': str(tmp_path / 'taken'), 'auto_diagnose': True}
    for when in RUN:
        twin._take(heard(when))
    differs(twin, twin._then)
    until(lambda: said)
    twin._alarm.diagnose(twin._memory.columns(), 0.0, 0.5)
    why = f'{twin._alarm.folder}: cannot be written (Not a directory)'
    assert said == [f'the last minutes are not kept: {why}', f'no diagnosis: {why}']
    assert not twin._alarm.busy and twin._alarm.poll() is None
    twin._take(heard(RUN[-1] + 0.01))
    twin._notice()


def test_a_muscle_that_publishes_and_is_not_heard_is_named_and_subscribed_to_anew(twin):
    _LEFT.append(muscle := rclpy.create_node('muscle'))
    current = muscle.create_publisher(Float64, 'current', 1)
    before = twin._hearing
    until(lambda: twin.count_publishers('/current'))
    assert message(twin) == 'waits for a muscle'
    for age, anew in ((5.0, False), (15.0, True)):
        twin._hearing._spoke['/current'] = time.monotonic() - age
        said = f'waits for a muscle: nothing has come on /current for {age:.0f} s, which is published'
        assert message(twin) == said
        assert (twin._hearing is not before) == anew
    assert message(twin) == 'waits for a muscle'
    heard = []

    def hears():
        current.publish(Float64(data=0.1))
        heard.extend(twin._hearing.ticks())
        return heard

    until(hears)
    assert heard[0].values == {'current': 0.1}

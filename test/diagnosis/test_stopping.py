"""A motion that ends against something is told from one that settles, from rests, and from other physics."""

import os
from pathlib import Path

import numpy as np
import pytest

from tcp_muscle_ros.diagnosis.answer.notes import led_by_stops, on_stops
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import Holding, Imposed
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.diagnosis.observation.stopping import stops
from tcp_muscle_ros.muscle import LISTED, Parameters, simulate
from tcp_muscle_ros.recording.csv_import import import_runs, lab_files
from tcp_muscle_ros.recording.import_map import read_import_map

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get('TCP_MUSCLE_SHARED', ROOT.parent / 'shared')) / 'data'
NOMINAL = Parameters.named('karami_tadesse_2017')
ITSELF = {'coil_contact', 'slack'}  # what ends a motion


def found(p, heating=30.0, noise=2e-5, power=1.0, seed=0):
    time = np.arange(0.0, 45.0 + heating, 0.2)
    drive = np.where((time >= 10.0) & (time < 10.0 + heating), power, 0.0)
    seen = simulate(p, time, drive, kind='power', load=0.3).displacement
    return list(stops(time, seen + noise * np.random.default_rng(seed).standard_normal(time.size), time, drive))


@pytest.mark.parametrize('heating', [10.0, 30.0, 60.0, 150.0])
@pytest.mark.parametrize('name', ['', *sorted(set(LISTED) - ITSELF)])
def test_what_settles_was_not_stopped_whatever_the_physics(name, heating):
    p = NOMINAL.with_effects(*([name] if name else []))
    assert [found(p, heating, noise) for noise in (0.0, 2e-5, 5e-4)] == [[]] * 3


@pytest.mark.parametrize('seed', range(8))
def test_the_rests_of_an_end_that_sticks_are_no_stops(seed):
    p = NOMINAL.replace({'stick_slip.Fb': 0.05, 'stick_slip.s': 0.7, 'stick_slip.seed': seed})
    assert found(p.with_effects('stick_slip'), noise=0.0) == []


@pytest.mark.parametrize('held', [0.95, 0.91, 0.87])
def test_a_drive_that_steps_down_to_what_holds_the_muscle_where_it_is_does_not_stop_it(held):
    time = np.arange(0.0, 75.0, 0.2)
    first = simulate(NOMINAL, time, np.where(time >= 10.0, 1.0, 0.0), kind='power', load=0.3).temperature
    there = time[np.argmax(first - first[0] >= held * (first[-1] - first[0]))]
    drive = np.where(time < 10.0, 0.0, np.where(time < there, 1.0, held)) * (time < 55.0)
    seen = simulate(NOMINAL, time, drive, kind='power', load=0.3).displacement
    assert list(stops(time, seen, time, drive)) == []


@pytest.mark.parametrize('noise', [0.0, 2e-5, 8e-5])
def test_a_motion_that_runs_into_something_is_stopped_there(noise):
    hard = NOMINAL.replace({'coil_contact.Hc': 0.135, 'coil_contact.s': 1.0, 'coil_contact.w': 2e-4})
    ((first, last, at),) = found(hard.with_effects('coil_contact'), noise=noise)
    assert 12.0 < first < 25.0 and last == pytest.approx(40.0, abs=0.3)
    assert at == pytest.approx(0.163 - 0.135, abs=2e-3)


@pytest.mark.parametrize(
    ('others', 'said'), [(0, ' at 28 mm, such as'), (2, ' at 28 mm in 1 of 3 recordings, such as')]
)
def test_the_stop_of_one_run_leads_what_is_said_with_the_length_of_that_run(others, said):
    hard = NOMINAL.replace({'coil_contact.Hc': 0.135, 'coil_contact.s': 1.0, 'coil_contact.w': 2e-4})
    free = [recorded(NOMINAL, f'run {k}') for k in range(others)]
    assert led_by_stops([recorded(NOMINAL, 'free')]) == ''
    assert led_by_stops([*free, recorded(hard.with_effects('coil_contact'), 'stopped')]).startswith(
        f'The stroke ends against a stop{said}'
    )


def recorded(p, name):
    time = np.arange(0.0, 75.0, 0.2)
    drive = np.where((time >= 10.0) & (time < 40.0), 1.0, 0.0)
    seen = Observed(time, simulate(p, time, drive, kind='power', load=0.3).displacement, np.ones(time.size))
    imposed = Imposed('power', time, drive, np.full(time.size, 0.3), np.full(time.size, NOMINAL['T0']))
    return Experiment(name, imposed, Holding('load', 0.3), {'displacement': seen})


def test_a_motion_that_ends_in_one_reading_was_not_seen_to_arrive():
    time = np.arange(0.0, 60.0, 0.2)
    drive = np.where(time >= 10.0, 1.0, 0.0)
    assert list(stops(time, 0.01 * (time >= 15.0), time, drive)) == []
    assert list(stops(time, np.zeros(time.size), time, drive)) == []


@pytest.mark.skipif(not DATA.is_dir(), reason=f'the public recordings are not at {DATA}')
def test_five_runs_of_the_bench_rig_end_against_a_stop_each_at_its_own_length():
    import_map = read_import_map(ROOT / 'config' / 'import_tca_bench_rig.yaml')
    runs = [
        prepare(run.recording, NOMINAL, most=None)
        for run in import_runs(import_map, lab_files([DATA / 'tca_bench_rig']))
        if run.name.startswith('stroke')
    ]
    (said,) = on_stops(runs)
    assert led_by_stops(runs).startswith('The stroke ends against a stop at 44.4 to 73.5 mm in 5 of ')
    expected = {
        '4W/encoder_4': '73.5 mm',
        '4W/encoder_5': '72.9 mm',
        '4W/encoder_6': '60.1 mm',
        '4W/encoder_7': '60.1 mm',
        '2W/encoder_3': '44.4 mm',
    }
    assert said.count(' mm from ') == len(expected)
    assert all(f'{name}.csv at {length} from ' in said for name, length in expected.items()), said

"""Rests and jumps beside a smooth prediction: told from coarse readings, noise, slips, stops, and other physics."""

import os
from dataclasses import replace
from itertools import pairwise, product
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tcp_muscle_ros.diagnosis.answer.notes import on_rests
from tcp_muscle_ros.diagnosis.answer.sticking import imitated, imitation, rests_of, said_of, stuck
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.fitting.slips import leapt, slipped
from tcp_muscle_ros.diagnosis.fitting.stick_slip import CHANCE, Signature, alike, signature
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.muscle import Parameters, simulate
from tcp_muscle_ros.recording.csv_import import import_runs, lab_files
from tcp_muscle_ros.recording.import_map import read_import_map
from tcp_muscle_ros.recording.recording import Channel, Recording

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get('TCP_MUSCLE_SHARED', ROOT.parent / 'shared')) / 'data'
NOMINAL = Parameters.named('karami_tadesse_2017')
TIME = np.arange(0.0, 75.0, 0.2)
WRONG = NOMINAL.replace(hA=0.021, C=0.16)  # what predicts is never quite the muscle


def stroke(p: Parameters, power: float = 1.0) -> np.ndarray:
    return simulate(p, TIME, np.where((TIME > 25.0) & (TIME < 55.0), power, 0.0), kind='power', load=0.1).displacement


def sticking(seed: int, force: float = 0.05) -> Parameters:
    values = {'stick_slip.Fb': force, 'stick_slip.s': 0.7, 'stick_slip.seed': seed}
    return NOMINAL.replace(values).with_effects('stick_slip')


def read_as(value: np.ndarray, step: float, noise: float, seed: int = 0) -> np.ndarray:
    noisy = value + noise * np.random.default_rng(seed).standard_normal(value.size)
    return np.round(noisy / step) * step if step else noisy


def shown(p: Parameters, step: float = 0.0, noise: float = 0.0, seed: int = 0) -> Signature:
    return signature(TIME, read_as(stroke(p), step, noise, seed), stroke(WRONG))


@pytest.mark.parametrize(
    'name', ['', 'friction', 'hysteresis', 'creep', 'two_node', 'slack', 'branch_cte', 'viscous_flow', 'cte_kink']
)
def test_neither_other_physics_nor_a_coarse_or_noisy_reading_is_stick_slip(name):
    p = NOMINAL.with_effects(*([name] if name else []))
    for step, noise, seed in product((0.0, 9e-6, 5e-4), (0.0, 2e-5, 2e-4), (0, 1)):
        assert shown(p, step, noise, seed).kind == 'none', (step, noise)


@pytest.mark.parametrize(('step', 'noise'), [(0.0, 0.0), (9e-6, 0.0), (0.0, 1e-5), (5e-5, 0.0)])
def test_stick_slip_is_found_and_measured_through_a_coarse_or_noisy_reading(step, noise):
    found = [shown(sticking(seed), step, noise, seed) for seed in range(10)]
    assert sum(s.kind == CHANCE for s in found) >= 9
    for way in (1.0, -1.0):
        sizes = np.concatenate([s.sizes(way) for s in found])
        assert 0.5 < np.mean(sizes) / (0.5 * 0.05 / 20.0) < 2.0  # (1 - r) Fb/k
    levels = [rest.level for s in found for rest in s.rests]
    assert min(levels) < 0.2 and max(levels) > 0.8


def test_a_reading_too_coarse_for_the_jumps_shows_none():
    assert all(shown(sticking(seed), step=5e-3).kind == 'none' for seed in range(4))


def test_slips_of_an_end_are_of_one_direction_and_without_rests():
    turn = 5.4e-3  # m, by which one turn less lengthens the coil
    slips = stroke(NOMINAL) - turn * np.searchsorted([33.1, 41.3, 50.9], TIME)
    found = signature(TIME, read_as(slips, 9e-6, 1e-5), stroke(WRONG))
    assert found.kind == 'one_way' and [j.size < 0.0 for j in found.jumps] == [True] * 3


def test_a_stop_is_one_long_rest_while_the_heating_goes_on():
    stopped = NOMINAL.replace({'coil_contact.Hc': 0.147, 'coil_contact.s': 1.0, 'coil_contact.w': 2e-4})
    found = shown(stopped.with_effects('coil_contact'), 9e-6, 1e-6)
    assert found.kind == 'stop'
    assert max(rest.duration for rest in found.rests if rest.missed > 0.0) > 10.0


def test_steps_of_twice_the_size_are_told_apart_and_those_of_another_seed_are_not():
    """Samples of five runs each: of 20 pairs at most three differ at 5 %, and doubled all but two do."""
    sizes = [np.concatenate([shown(sticking(10 * k + n)).sizes() for n in range(5)]) for k in range(21)]
    same = [alike(one, other) for one, other in pairwise(sizes)]
    double = [alike(one, 2.0 * other) for one, other in pairwise(sizes)]
    assert sum(p < 0.05 for p in same) <= 3
    assert sum(p < 0.05 for p in double) >= 18
    assert alike([1.0, 2.0], [3.0, 4.0, 5.0]) == 1.0


@pytest.mark.skipif(not DATA.is_dir(), reason=f'the public recordings are not at {DATA}')
def test_the_stroke_of_the_bench_rig_sticks_and_slips_and_its_force_does_not():
    import_map = read_import_map(ROOT / 'config' / 'import_tca_bench_rig.yaml')
    wanted = ('stroke_1W_1', 'stroke_1W_3', 'stroke_2W_2', 'stroke_2W_5', 'stroke_3W_1a', 'stroke_3W_5a')
    force = ('force_1W_1', 'force_2W_1', 'force_3W_1', 'force_4W_1')
    found, prepared = {}, []
    for run in import_runs(import_map, lab_files([DATA / 'tca_bench_rig'])):
        if run.name in (*wanted, *force):
            experiment = prepare(run.recording, NOMINAL, most=None)
            fitted = calibrate([experiment], NOMINAL).fit
            (channel,) = experiment.observed
            prepared += [experiment] if run.name in wanted[-2:] else []
            o = experiment.observed[channel]
            found[run.name] = signature(o.time, o.value, o.value - fitted.left[0][channel])
    assert [found[name].kind for name in wanted] == [CHANCE] * 6
    assert CHANCE not in [found[name].kind for name in force]
    up, down = (np.concatenate([found[name].sizes(way) for name in wanted]) for way in (1.0, -1.0))
    assert up.size > 40 and down.size > 25
    assert np.concatenate([found[name].durations() for name in wanted]).max() > 2.0
    told = on_rests(rests_of(calibrate(prepared, NOMINAL, separate=('B',)).fit))
    assert len(told) == 1 and 'the stroke sticks and slips in' in told[0] and 'jumps both ways' in told[0]
    one, other = found['stroke_2W_2'].sizes(), found['stroke_2W_5'].sizes()
    assert alike(one, other) > 0.05


def recorded(displacement: np.ndarray) -> Experiment:
    drive = np.where((TIME > 25.0) & (TIME < 55.0), 1.0, 0.0)
    channels = {'power': (TIME, drive), 'displacement': (TIME, displacement), 'load': (TIME[:1], np.array([0.1]))}
    return prepare(Recording('run', {n: Channel(n, *of, '') for n, of in channels.items()}, 0), NOMINAL)


@pytest.mark.parametrize('seed', [0, 6])
def test_the_jumps_of_an_end_that_sticks_are_neither_slips_nor_leaps(seed):
    """A fit that copies them from the recording predicts nothing, and leaves a worse muscle."""
    fitted = settle_noise(calibrate([recorded(stroke(sticking(seed, 0.1)))], NOMINAL).fit)[0]
    assert leapt(fitted) is None and slipped(fitted) is None


def test_what_sticks_is_simulated_with_jumps_and_rests_of_the_same_kind():
    runs, found = zip(*((recorded(stroke(sticking(seed))), shown(sticking(seed))) for seed in range(4)), strict=True)
    like = imitation(runs, NOMINAL, found)
    assert 0.6 < like.values['stick_slip.Fb'] / 0.05 < 1.6 and 0.4 < like.values['stick_slip.s'] < 1.2
    assert like.jumps > 0.01 and like.rests > 0.01
    assert 'has jumps as large (p = ' in said_of(like)
    assert imitation(runs[:1], NOMINAL, [shown(NOMINAL)]) is None and said_of(None) == ''
    even = [replace(s, jumps=tuple(replace(j, size=np.sign(j.size) * 1e-3) for j in s.jumps)) for s in found]
    assert 'jumps of other sizes (p < 0.001)' in said_of(imitation(runs, NOMINAL, even))


def test_rests_are_seen_beside_a_model_that_rests_itself():
    """Friction that was found rests too, and would explain away that the recording sticks and slips."""
    smooth = calibrate([recorded(stroke(sticking(3)))], NOMINAL).fit
    resting = SimpleNamespace(
        problem=smooth.problem, left=[{'displacement': np.zeros(TIME.size)}], muscle=smooth.muscle
    )
    assert on_rests(rests_of(resting)) == ()
    rests = rests_of(resting, smooth)
    (told,) = on_rests(rests)
    assert 'the stroke sticks and slips in 1 of 1 recordings' in told
    assert 'a simulation of improved.yaml with stick_slip.Fb ' in told
    assert rests.told.recordings == ('run',) and rests.told.values == rests.like.values
    beside = imitated(rests)
    assert np.array_equal(beside.recorded, stroke(sticking(3))) and beside.time[0] == 0.0
    jumps = [np.count_nonzero(np.abs(np.diff(run)) > 5e-4) for run in (beside.recorded, beside.simulated)]
    assert 0.4 < jumps[1] / jumps[0] < 2.5
    plain = calibrate([recorded(stroke(NOMINAL))], NOMINAL).fit
    assert imitated(rests_of(plain, plain)) is None


@pytest.mark.parametrize('stiffer', [0.5, 2.0])
def test_what_is_said_of_sticking_is_of_the_muscle_that_is_handed_on(stiffer):
    """The values go into its file: the pull that makes the same jumps of a stiffer one is larger."""
    smooth = calibrate([recorded(stroke(sticking(3)))], NOMINAL).fit
    handed = smooth.muscle.replace(k0=stiffer * smooth.muscle['k0'])
    plain, rests = rests_of(smooth), rests_of(smooth, smooth, handed)
    assert (rests.like.values['stick_slip.Fb'] > plain.like.values['stick_slip.Fb']) == (stiffer > 1.0)
    assert rests.like.jumps > 0.01
    alone = smooth.problem.experiments[0].predict(stuck(handed, rests.like, 0))['displacement']
    assert np.ptp(imitated(rests).simulated - alone) == pytest.approx(0.0, abs=1e-12)


def test_a_muscle_that_hardly_moves_is_said_to_stick_like_none():
    runs, found = [recorded(stroke(sticking(3)))], [shown(sticking(3))]
    assert imitation(runs, NOMINAL, found) is not None
    assert imitation(runs, NOMINAL.replace(B=NOMINAL['B'] * 1e-4), found) is None

"""Recordings are data: what is inferred of them is held by the problem that is fitted, never by them."""

import ast
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TIME, TRUE, experiment

import tcp_muscle_ros.diagnosis
from tcp_muscle_ros.diagnosis import diagnose as engine
from tcp_muscle_ros.diagnosis.fitting import forms, room, slips, weighing
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.hypothesis.latents import Before, Draught, Latent, Slip, Switched
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT, START
from tcp_muscle_ros.diagnosis.noise.discrepancy import Allowance
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import Imposed
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.diagnosis.search import holdout

CHANNELS = ('temperature', 'displacement')
SWINGING = np.mod(TIME, 70.0) < 40.0
DATA = {
    Experiment: {'name', 'imposed', 'holding', 'observed', 'known', 'notes', 'start_ns', 'model', 'fingerprint'},
    Imposed: {'kind', 'time', 'drive', 'load', 'ambient', 'switches', 'lost', 'unsure', 'unread'},
    Observed: {'time', 'value', 'count', 'swinging', 'spacing', 'stretch', 'within', 'steady', 'beside'},
}
ROOMS = Path(tcp_muscle_ros.diagnosis.__path__[0])
# What makes other experiments of a problem: a part of the data, and a planned recording.
MAKES_OTHERS = {'hypothesis/problem.py', 'answer/next_experiment.py'}


def sealed(recording):
    """The recording, none of whose arrays can be written to."""
    parts = (recording.imposed, *recording.observed.values())
    arrays = [value for part in parts for value in vars(part).values() if isinstance(value, np.ndarray)]
    for array in arrays:
        array.setflags(write=False)
    assert len(arrays) >= 5
    return recording


@pytest.fixture(scope='module')
def fitted():
    """A fit of recordings in which a weight swings, and of whose room little is known; nothing is inferred of them."""
    runs = []
    for k in range(2):
        run = experiment(CHANNELS, seed=k)
        seen = run.observed['displacement']
        wild = seen.value + np.where(SWINGING, 5e-4 * np.sin(20.0 * TIME), 0.0)
        seen = replace(seen, value=wild, swinging=SWINGING)
        run = replace(run, imposed=replace(run.imposed, unsure=0.02), observed={**run.observed, 'displacement': seen})
        runs.append(sealed(run))
    return calibrate(runs, NOMINAL, rounds=1).fit


@pytest.mark.parametrize(('kind', 'names'), DATA.items(), ids=lambda x: getattr(x, '__name__', ''))
def test_a_recording_has_no_field_of_a_hypothesis(kind, names):
    assert {field.name for field in fields(kind)} == names


def test_only_a_part_of_the_data_and_a_plan_make_other_experiments_of_a_problem():
    found = set()
    for path in sorted(ROOMS.rglob('*.py')):
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
            if isinstance(node, ast.Call) and any(keyword.arg == 'experiments' for keyword in node.keywords):
                found.add(path.relative_to(ROOMS).as_posix())
    assert found == MAKES_OTHERS


def test_whatever_is_inferred_of_recordings_they_stay_the_same(fitted):
    steps = {
        'ages': (in_turn, lambda latent: latent.before.cycles > 1.0 and latent.before.used == TIME[-1]),
        'slips': (lambda f: slips.added(f, [[], [Slip('displacement', 50.0, 1e-4, 1e-5, 0.1)]]), lambda x: x.slips),
        'readings': (room.as_well_as_read, lambda x: x.allowance('displacement').readings is not None),
        'draught': (
            lambda f: forms.allowing_forms(f, ['airflow']),
            lambda x: x.draught is not None and x.allowance('displacement').forms is not None,
        ),
        'calm': (lambda f: weighing.calmed(f, f), lambda x: x.allowance('displacement').calm < 1.0),
    }
    for name, (infer, there) in steps.items():
        found = infer(fitted).problem
        assert there(found.latents[1]), name
        assert not there(fitted.problem.latents[1]), name
        assert found.experiments is fitted.problem.experiments, name


def test_a_part_of_the_data_has_that_part_of_what_is_inferred(fitted):
    columns = np.column_stack([TIME, np.sin(TIME)])
    unsure = dict.fromkeys(CHANNELS, columns)
    before = Before(2.5, 210.0, 380.0)
    latent = Latent(
        before,
        Draught(TIME[::50], np.zeros(TIME.size), frozenset({'airflow'}), (0.1,), unsure),
        (Slip('displacement', 50.0, 1e-4, 1e-5, 0.1),),
        {name: Allowance(columns, 2.0 * columns, calm=0.3) for name in CHANNELS},
    )
    problem = fitted.problem.with_latent(latent, 1)
    fold = holdout.Fold(((1, 40.0, 80.0),))
    inside = (TIME >= 40.0) & (TIME <= 80.0)
    for part, keep in ((holdout.testing(problem, fold), inside), (holdout.training(problem, fold), ~inside)):
        kept = part.latents[1]
        assert (kept.before, kept.slips) == (before, latent.slips)
        assert kept.draught.warmer.size == TIME.size
        for name in CHANNELS:
            np.testing.assert_array_equal(part.experiments[1].observed[name].time, TIME[keep])
            np.testing.assert_array_equal(kept.draught.unsure[name], columns[keep])
            np.testing.assert_array_equal(kept.allowance(name).ways, np.hstack([columns, 2.0 * columns])[keep])
        expected = np.where(SWINGING[keep], 0.3, 1.0)
        np.testing.assert_array_equal(part.weight('displacement', 1), expected)
        assert part.weight('temperature', 1).max() == 1.0
    assert holdout.testing(problem, fold).latents[0].allowances == {}


def test_what_is_followed_is_what_was_imposed_and_what_was_read_stays(fitted):
    read = fitted.problem.experiments[1]
    imposed = replace(read.imposed, drive=np.roll(read.imposed.drive, 5))
    problem = fitted.problem.with_latent(Latent(switched=Switched(imposed, ('it switched later',))), 1)
    assert problem.experiments[1] is read
    assert problem.followed[0] is problem.experiments[0]
    assert problem.followed[1].imposed is imposed
    assert problem.followed[1].notes == (*read.notes, 'it switched later')
    room = np.full(TIME.size, fitted.values[AMBIENT, 1])
    later = replace(read, imposed=imposed).predict(fitted.muscle, fitted.values[START, 1], room)
    shown = problem.predict(fitted.values, 1)
    assert np.max(np.abs(shown['temperature'] - fitted.predictions[1]['temperature'])) > 1.0
    np.testing.assert_allclose(shown['temperature'], later['temperature'], atol=0.01)  # K: coarser steps
    part = problem.only([dict.fromkeys(CHANNELS, TIME < 50.0)] * 2)
    assert part.followed[1].imposed is imposed


def test_latents_belong_to_the_experiments_one_each(fitted):
    with pytest.raises(ValueError, match='1 latents of 2 experiments'):
        fitted.problem.with_latents([Latent()])


@pytest.mark.long
def test_a_diagnosis_leaves_its_recordings_as_they_were(monkeypatch):
    """Of a muscle whose stroke grows with its load."""
    muscle = TRUE.with_effects('load_stroke')
    runs = tuple(experiment(CHANNELS, 0.27, load, k, muscle=muscle) for k, load in enumerate((0.3, 0.588, 0.98)))
    ends = []
    conclude = engine.conclude

    def concluded(selection, *arguments):
        ends.append(selection)
        return conclude(selection, *arguments)

    monkeypatch.setattr(engine, 'conclude', concluded)
    engine.diagnose([sealed(run) for run in runs], NOMINAL)
    (selection,) = ends
    rivals = [rival.fit for chosen in selection.chosen for rival in chosen.rivals]
    assert rivals
    for fit in (selection.calibrated, selection.final, *rivals):
        assert [mine is run for mine, run in zip(fit.problem.experiments, runs, strict=True)] == [True] * 3
    assert selection.final.problem.latents[2].before.cycles > selection.final.problem.latents[1].before.cycles > 0.0

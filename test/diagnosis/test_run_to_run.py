"""Runs of one protocol that differ: found by themselves, measured, allowed for, and no physics is named for them."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TRUE

from tcp_muscle_ros.diagnosis.answer.cluster import cluster, one_channel
from tcp_muscle_ros.diagnosis.answer.conclusions import calibrated_values
from tcp_muscle_ros.diagnosis.answer.findings import RunToRun
from tcp_muscle_ros.diagnosis.answer.notes import on_unrepeated
from tcp_muscle_ros.diagnosis.answer.repeating import beyond_what_differs
from tcp_muscle_ros.diagnosis.diagnose import diagnose, skipped
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.fitting.least_squares import fit
from tcp_muscle_ros.diagnosis.fitting.run_to_run import allowing, differing
from tcp_muscle_ros.diagnosis.fitting.weighing import structures
from tcp_muscle_ros.diagnosis.noise.noise import quick_noise
from tcp_muscle_ros.diagnosis.noise.repeatability import between_runs
from tcp_muscle_ros.diagnosis.noise.replicates import protocols
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import Holding, Imposed
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.diagnosis.search.candidates import Candidate, with_effect
from tcp_muscle_ros.diagnosis.search.holdout import Gain, held_out, stretches
from tcp_muscle_ros.diagnosis.search.location import Unexplained
from tcp_muscle_ros.diagnosis.search.picking import NOTHING
from tcp_muscle_ros.diagnosis.search.rivals import Rival
from tcp_muscle_ros.diagnosis.search.selected import Chosen, Selection
from tcp_muscle_ros.muscle import SPECIFICATIONS, simulate

TIME = np.arange(0.0, 75.0, 0.5)
GAINS, COURSE = (0.8, 0.9, 1.15, 1.25), 0.04  # of each run: its gain, and how far its own course goes, of the peak


def run(power, gain=1.0, course=0.0, seed=0, begin=20.0, noise=2e-5):
    """One specimen heated once: its own gain, its own slow course (of the peak), an instrument's noise."""
    rng = np.random.default_rng(seed)
    drive = np.where((begin + 5.0 > TIME) & (begin <= TIME) | (begin + 8.0 <= TIME) & (begin + 30.0 > TIME), power, 0.0)
    value = simulate(TRUE.replace(B=gain * TRUE['B']), TIME, drive, kind='power', load=0.1).displacement
    knots = np.arange(0.0, TIME[-1] + 8.0, 8.0)
    own = course * np.ptp(value) * np.interp(TIME, knots, rng.standard_normal(knots.size))
    seen = Observed(TIME, value + own * (begin < TIME) + noise * rng.standard_normal(TIME.size), np.ones(TIME.size))
    imposed = Imposed('power', TIME, drive, np.full(TIME.size, 0.1), np.full(TIME.size, NOMINAL['T0']))
    return Experiment(f'run {seed}', imposed, Holding('load', 0.1), {'displacement': seen})


@pytest.fixture(scope='module')
def specimens():
    return [run(0.7, gain, COURSE, seed) for seed, gain in enumerate(GAINS)]


def test_runs_of_one_protocol_are_found_by_themselves():
    made = [run(0.7), run(0.5), run(0.7, seed=1, begin=24.0), run(0.3, seed=2), run(0.5, seed=3)]
    found = protocols(made)
    assert [p.recordings for p in found] == [(0, 2), (1, 4)]
    assert np.diff(found[0].begins)[0] == pytest.approx(4.0, abs=0.3)


def test_what_they_do_not_share_is_measured_with_and_without_a_gain_for_each(specimens):
    (found,) = between_runs(specimens).values()
    assert found.runs == 4
    assert found.own_gain == pytest.approx(COURSE * np.sqrt(2.0 / 3.0), rel=0.35)  # a course between knots
    assert found.plain > 1.3 * found.own_gain and found.gains_differ
    assert between_runs([specimens[0], run(0.5)]) == {}


def test_what_a_model_says_that_runs_differ_by_is_no_want_of_repetition():
    made, worn = [run(0.7, seed=k) for k in range(2)], run(0.7, seed=2)
    (seen,) = worn.observed.values()
    flowed = 0.1 * np.ptp(seen.value) * np.clip(TIME / TIME[-1], 0.0, 1.0)
    made.append(replace(worn, observed={'displacement': replace(seen, value=seen.value + flowed)}))
    course = simulate(TRUE, TIME, made[0].imposed.drive, kind='power', load=0.1).displacement
    foretold = [{'displacement': course}, {'displacement': course}, {'displacement': course + flowed}]
    (as_they_are,), (beside,) = between_runs(made).values(), between_runs(made, foretold).values()
    assert as_they_are.plain > 0.02 and beside.plain < 0.1 * as_they_are.plain


@pytest.mark.parametrize('ended', [0.0, 17.0, 20.5])
def test_a_channel_that_ended_before_the_heating_is_not_compared_and_ends_nothing(ended):
    made = [run(0.7, seed=k) for k in range(2)]
    (seen,) = made[0].observed.values()
    cut = seen.only(seen.time <= ended)
    made = [replace(e, observed={**e.observed, 'temperature': o}) for e, o in zip(made, (cut, seen), strict=True)]
    assert list(between_runs(made)) == ['displacement']


def test_a_channel_that_does_not_move_is_not_compared_whatever_a_model_foretells_of_it():
    made = [run(0.7, seed=k) for k in range(2)]
    (seen,) = made[0].observed.values()
    still = replace(seen, value=np.zeros_like(seen.value))
    made = [replace(e, observed={**e.observed, 'temperature': still}) for e in made]
    foretold = [{'displacement': seen.value, 'temperature': k + seen.value * (1 + k)} for k in range(2)]
    assert list(between_runs(made)) == ['displacement']
    assert list(between_runs(made, foretold)) == ['displacement']


def test_runs_that_repeat_each_other_to_the_noise_need_no_allowance():
    made = [run(0.7, seed=k) for k in range(3)]
    fitted = calibrate(made, NOMINAL).fit
    assert differing(fitted, between_runs(made)) == []


def test_an_allowed_course_explains_what_differs_and_not_what_is_larger(specimens):
    repeated = between_runs(specimens)
    fitted = calibrate(specimens, NOMINAL, separate=('B',)).fit
    assert differing(fitted, repeated) == ['displacement']
    quiet = fitted.problem.with_noise(quick_noise(fitted.problem.experiments))
    allowed = allowing(fit(quiet, fitted.z, rounds=1), repeated)
    assert allowed.misfit < 0.1 * float(sum(np.sum(part**2) for part in quiet.residuals(fitted.predictions)))
    left = [9.0 * mine['displacement'] for mine in allowed.left]  # as if the model had missed nine times as much
    expected = [allowed.problem.expected_discrepancy({'displacement': x}, k) for k, x in enumerate(left)]
    rest = [x - found['displacement'] for x, found in zip(left, expected, strict=True)]
    whitened = np.concatenate(rest) / allowed.problem.noise['displacement'].sigma
    assert float(np.mean(whitened**2)) > 2.0


def test_what_each_recording_has_for_itself_is_listed_and_the_muscle_has_the_mean(specimens):
    fitted = calibrate(specimens, NOMINAL, separate=('B',)).fit
    listed = calibrated_values(fitted, NOMINAL)
    own = np.array([listed[f'B [{k + 1}]'].value for k in range(4)])
    assert 'B' not in listed
    mean, usual = np.exp(np.mean(np.log(own))), np.exp(np.mean(np.log(GAINS)))
    assert own / mean == pytest.approx(np.array(GAINS) / usual, rel=0.15)
    assert fitted.muscle['B'] == pytest.approx(mean)


def skewed(runs, rate):
    """The runs as a clock shows them that is fast by a rate, and what a search that names it would end with."""
    made = []
    for k in runs:
        (o,) = k.observed.values()
        late = np.interp(TIME - rate * TIME, o.time, o.value)
        made.append(replace(k, observed={'displacement': replace(o, value=late)}))
    bare = calibrate(made, NOMINAL, separate=('B',)).fit
    usual = {name: row.value for name, row in SPECIFICATIONS.items() if name.startswith('clock_skew.')}
    usual['clock_skew.channel'] = float(SPECIFICATIONS['clock_skew.channel'].choices.index('displacement'))
    problem = with_effect(bare.problem, Candidate('clock_skew', usual, 0.0, 0.0))
    final = fit(problem, np.concatenate([bare.z, problem.start()[bare.z.size :]]), rounds=40)
    kept_back = stretches(problem)
    chosen = Chosen('clock_skew', 60.0, Gain(1.0, 0.1, 0.1, 1.0, 1), 0.5, (Rival('clock_skew', final, 0.0),))
    errors = held_out(bare, kept_back), held_out(final, kept_back)
    return Selection(bare, final, (chosen,), *errors, {}, structures(final), NOTHING, kept_back=kept_back)


@pytest.mark.parametrize(('rate', 'named'), [(0.0, ()), (0.06, ('clock_skew',))])
def test_a_sensor_is_named_only_where_it_explains_more_than_what_differs_from_run_to_run(specimens, rate, named):
    selection = skewed(specimens, rate)
    left = beyond_what_differs(selection, between_runs(specimens))
    assert tuple(c.effect for c in left.chosen) == named
    assert left.final is (selection.final if named else selection.calibrated)
    # Of a channel in which no runs are compared, nothing is known that it has to exceed.
    assert beyond_what_differs(selection, {}) is selection


@pytest.mark.long
def test_the_verdict_on_runs_that_differ_is_that_they_do_and_no_physics_is_named(specimens):
    found, (repeated,) = diagnose(specimens, NOMINAL), between_runs(specimens).values()
    assert found.verdict == 'not_repeatable' and found.findings == ()
    assert 'What remains differs from run to run' in found.headline and 'gains differ by a factor' in found.headline
    assert found.repeatability['displacement'] == pytest.approx(repeated.own_gain * repeated.peak)
    assert [r.protocol for r in found.runs] == [1] * 4
    gains = [r.gain for r in found.runs]
    assert max(gains) / min(gains) == pytest.approx(GAINS[-1] / GAINS[0], rel=0.15)
    said = next(note for note in found.notes if note.startswith('runs of one protocol differ in the stroke by'))
    quick, _, slow = (100.0 * share for share in repeated.by_scale)
    assert f'({quick:.1f} % quicker than 2 s, ' in said and f'{slow:.1f} % slower)' in said


def test_a_power_and_one_output_show_no_circumstance_of_a_recording(specimens):
    (o,) = specimens[0].observed.values()
    two = [replace(specimens[0], observed={'displacement': o, 'temperature': o})]
    assert {'airflow', 'ambient_drift'} <= set(skipped(specimens)) and 'airflow' not in skipped(two)


def test_causes_that_look_alike_share_one_probability_and_one_channel_is_known_as_such(specimens):
    fitted = calibrate(specimens[:1], NOMINAL).fit
    rivals = [
        Rival(effect, fitted, score) for effect, score in (('supply_lag', 10.0), ('two_node', 12.0), ('creep', 90.0))
    ]
    gain = Gain(1.0, 0.1, 0.1, 1.0, 1)
    found = cluster(Chosen('supply_lag', 60.0, gain, 0.5, tuple(rivals)))
    assert [(m.effect, m.stage) for m in found] == [('supply_lag', 'electrical'), ('two_node', 'thermal')]
    assert sum(m.probability for m in found) == pytest.approx(1.0) and found[0].probability < 0.8
    assert one_channel(fitted.problem)
    assert cluster(Chosen('supply_lag', 60.0, gain, 0.5, (rivals[0], rivals[2]))) == (), 'nothing looks alike'


def test_that_no_run_repeats_another_is_noted_only_where_something_is_unexplained():
    left = Unexplained('mechanical', 'displacement', 0.6, 'temperature', 300.0, 320.0, (0, 1.0, 2.0))
    (said,) = on_unrepeated(left, None)
    assert 'can be predicted at all is unknown' in said and 'a second run of the same protocol tells' in said
    assert on_unrepeated(left, RunToRun({'displacement': 1e-4})) == ()
    assert on_unrepeated(None, None) == ()


@pytest.mark.long
@pytest.mark.parametrize('repeated', [False, True])
def test_recordings_that_leave_something_unexplained_say_whether_one_repeats_another(repeated):
    made = [run(0.7, course=0.1), run(0.7 if repeated else 0.5, course=0.1, seed=0 if repeated else 1)]
    found = diagnose(made, NOMINAL)
    noted = any('none of them repeats another' in note for note in found.notes)
    assert noted is (found.unexplained is not None and not repeated)
    assert repeated or found.unexplained is not None
    assert (found.repeatability['displacement'] is None) is not repeated

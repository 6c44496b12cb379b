"""What a diagnosis hands on: a worn muscle as it is now, and what the instruments do."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOISE, NOMINAL, TIME, TRUE, experiment
from report.diagnoses import match, unexplained

from tcp_muscle_ros.diagnosis.answer.handed_on import ages_of, foretelling, handed_on
from tcp_muscle_ros.diagnosis.answer.improved import with_replay
from tcp_muscle_ros.diagnosis.answer.known import known_of
from tcp_muscle_ros.diagnosis.answer.replaying import as_given, own_of, replay
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise, with_noise
from tcp_muscle_ros.diagnosis.observation.experiment import one_load
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.diagnosis.search.candidates import screen
from tcp_muscle_ros.diagnosis.search.refitting import rivals_for
from tcp_muscle_ros.diagnosis.search.selection import select
from tcp_muscle_ros.recording.recording import UNDATED_NS, Channel, Recording
from tcp_muscle_ros.report.intervals_file import write_intervals
from tcp_muscle_ros.settings.ages import Age
from tcp_muscle_ros.settings.intervals import path_beside, variants
from tcp_muscle_ros.settings.parameter_file import write
from tcp_muscle_ros.settings.rig import Quantity, on_rig, read_rig, render_rig

CHANNELS = ('temperature', 'resistance', 'displacement')


def test_a_muscle_that_wears_is_handed_on_as_it_is_now_and_known_as_it_was():
    worn = [TRUE.replace({'fatigue.c': 0.03, 'fatigue.n0': 2.6 * k}).with_effects('fatigue') for k in range(4)]
    runs = [experiment(CHANNELS, 0.27, 0.588, k, muscle=worn[k]) for k in range(3)]
    runs = [replace(run, start_ns=100 + k, fingerprint=f'run {k}') for k, run in enumerate(runs)]
    fitted = in_turn(calibrate(runs, NOMINAL).fit)
    ranked, _ = screen(fitted, ['fatigue'])
    found = select(rivals_for(fitted, ranked, None)[0].fit, [])
    muscle, ages = handed_on(found)[0], ages_of(found.final.problem)
    assert muscle['fatigue.n0'] == pytest.approx(7.8, rel=0.3)
    assert [(age.start_ns, age.fingerprint) for age in ages] == [(100 + k, f'run {k}') for k in range(3)]
    assert ages[0].values == {'fatigue.n0': 0.0}
    # The next recording of the same muscle: as it is now it is predicted, as it was at first it is not.
    further = experiment(CHANNELS, 0.25, 0.45, 9, muscle=worn[3])
    now, first = (
        replay(further, m, own=own_of(further, m))['displacement'].rmse
        for m in (muscle, muscle.replace(ages[0].values))
    )
    assert now < 0.5 * first


def test_recordings_that_begin_at_the_same_instant_are_each_replayed_as_old_as_the_muscle_was_then():
    old = TRUE.with_effects('resistance_drift').replace({'resistance_drift.r': 1e-3})
    used = [{'resistance_drift.w0': w0} for w0 in (0.0, 300.0, 600.0)]
    runs = []
    for k, values in enumerate(used):
        seen = experiment(('resistance',), seed=k, muscle=old.replace(values))
        shown = {'current': seen.imposed.drive, 'resistance': seen.observed['resistance'].value}
        channels = {name: Channel(name, TIME, value, name) for name, value in shown.items()}
        runs.append(Recording('csv', channels, UNDATED_NS, {'load_n': 0.588}))
    assert len({prepare(run, old).fingerprint for run in runs}) == 3
    ages = tuple(Age(UNDATED_NS, values, run.end, run.fingerprint) for values, run in zip(used, runs, strict=True))
    diagnosis = replace(match()[0], improved=old.replace({'resistance_drift.w0': 900.0}), ages=ages)
    assert with_replay(diagnosis, runs, {}).fit['resistance'].improved == pytest.approx(NOISE['resistance'], rel=0.1)


@pytest.mark.parametrize('tried', [True, False])
def test_what_leads_and_that_nothing_was_tried_is_said_of_the_errors_of_a_replay_too(tried):
    seen, found = experiment(('resistance',), muscle=TRUE), unexplained()[0]
    shown = {'current': seen.imposed.drive, 'resistance': seen.observed['resistance'].value}
    run = Recording('csv', {n: Channel(n, TIME, value, n) for n, value in shown.items()}, UNDATED_NS, {'load_n': 0.588})
    found = replace(found, stopped='It ends.', location=None, headline='', ranking=found.ranking if tried else ())
    said = with_replay(found, [run], {}).headline
    assert said.startswith('It ends. After recalibration') and ('No listed effect was tried on it' in said) is not tried


def test_a_lag_of_the_thermometer_goes_to_the_rig_and_not_to_the_muscle():
    slow = TRUE.replace({'thermocouple_lag.tau': 2.0}).with_effects('thermocouple_lag')
    runs = [experiment(CHANNELS, current, 0.588, k, muscle=slow) for k, current in enumerate((0.27, 0.24))]
    found = select(in_turn(calibrate(runs, NOMINAL).fit), ['thermocouple_lag'])
    rig = handed_on(found)[1]
    lag = rig.instruments['temperature']['lag_s']
    assert lag.low <= lag.value <= lag.high
    assert lag.value == pytest.approx(2.0, rel=0.1)
    assert rig.limits.largest_current == pytest.approx(0.27)
    assert 'thermocouple_lag' not in handed_on(found)[0].effects


def test_the_room_and_the_zero_of_a_recording_are_its_own_and_nothing_else_is_fitted():
    run = experiment(CHANNELS, 0.27, 0.588, 1)
    assert own_of(run, TRUE) == as_given(run, TRUE)  # all is as stated: nothing is fitted
    stroke = run.observed['displacement']
    moved = replace(run, observed={**run.observed, 'displacement': replace(stroke, value=stroke.value + 2e-3)})
    own = own_of(moved, TRUE)
    assert own.zeros['displacement'] == pytest.approx(2e-3, abs=1e-4)
    wrong = TRUE.replace(B=0.7 * TRUE['B'])
    compared = replay(moved, wrong, own=own_of(moved, wrong))['displacement']
    assert compared.rmse > 0.1 * np.ptp(stroke.value) * 0.3  # a wrong muscle stays wrong


@pytest.mark.long
def test_an_ammeter_that_is_off_beside_an_ohmmeter_goes_to_the_rig_with_how_the_resistance_was_measured(tmp_path):
    shown = TRUE.replace({'current_gain.z': 4e-3, 'current_gain.g': 0.95}).with_effects('current_gain')
    shown = shown.replace({'current_gain.ohms': 1.0})
    runs = [experiment(CHANNELS, current, 0.588, k, muscle=shown) for k, current in enumerate((0.27, 0.15))]
    found = select(in_turn(calibrate(runs, NOMINAL).fit), ['current_gain'])
    assert [c.effect for c in found.chosen] == ['current_gain']
    rig = handed_on(found)[1]
    assert rig.instruments['current']['ohms_apart'].value == 1.0
    (tmp_path / 'rig.yaml').write_text(render_rig(rig))
    assert read_rig(tmp_path / 'rig.yaml') == rig
    further = experiment(CHANNELS, 0.2, 0.588, 9, muscle=shown)
    muscle = on_rig(handed_on(found)[0], rig)
    # Beside an ohmmeter nothing tells the heat loss from the gain: it is as assumed again, and the gain goes along.
    assert muscle['hA'] == pytest.approx(NOMINAL['hA'], rel=1e-3)
    own = own_of(further, muscle)
    for name, missed in replay(further, muscle, own=own).items():
        assert missed.rmse < 1.5 * NOISE[name], name
    # Each by itself could be anything; on this rig the muscle is known, and so is what it will show.
    known = known_of(found, handed_on(found)[0])
    loss = next(e for e in known.estimates if e.name == 'hA')
    assert not loss.fixed and loss.high > 1.5 * loss.low
    path = tmp_path / 'improved.yaml'
    write(path, handed_on(found)[0])
    write_intervals(path_beside(path), known)
    might_be = {k: on_rig(one, rig) for k, one in variants(path, handed_on(found)[0]).items()}
    for name, shown in replay(further, muscle, might_be, own).items():
        assert np.max(shown.high - shown.low) < 4.0 * NOISE[name], name


def test_a_sensor_that_the_parameter_file_states_goes_to_the_rig_and_a_current_may_flow_either_way():
    stated = {'thermocouple_lag.tau': 4.0}
    slow, nominal = (muscle.replace(stated).with_effects('thermocouple_lag') for muscle in (TRUE, NOMINAL))
    runs = [experiment(CHANNELS, current, 0.588, k, muscle=slow) for k, current in enumerate((-0.27, 0.24))]
    muscle, rig = handed_on(select(in_turn(calibrate(runs, nominal).fit), []))
    assert muscle.effects == ()
    assert rig.instruments == {'temperature': {'lag_s': Quantity(4.0, 4.0, 4.0)}}
    assert rig.limits.largest_current == pytest.approx(0.27)
    missed = replay(runs[0], on_rig(muscle, rig), own=own_of(runs[0], on_rig(muscle, rig)))
    assert missed['temperature'].rmse < 1.2 * NOISE['temperature']


def test_a_room_that_drifted_stays_in_the_report():
    drift = 2.0 * np.sin(2.0 * np.pi * TIME / 300.0)
    runs = [experiment(CHANNELS, current, 0.588, k) for k, current in enumerate((0.27, 0.2))]
    runs = [warmer(run, drift) for run in runs]
    fitted = in_turn(calibrate(runs, NOMINAL).fit)
    (found,) = rivals_for(fitted, screen(fitted, ['ambient_drift'])[0], None)
    chosen = select(found.fit, [])
    assert 'ambient_drift' in chosen.final.muscle.effects
    assert 'ambient_drift' not in handed_on(chosen)[0].effects


def warmer(run, drift):
    """The recording as a muscle shows it whose room is warmer by ``drift``, which nobody wrote down."""
    imposed = replace(run.imposed, ambient=run.imposed.ambient + drift)
    shown, still = (replace(run, imposed=room).predict(TRUE) for room in (imposed, run.imposed))
    observed = {name: replace(o, value=o.value + shown[name] - still[name]) for name, o in run.observed.items()}
    return replace(run, observed=observed)


def test_under_one_load_the_stiffness_is_about_as_assumed_and_under_two_it_is_as_found():
    """What is left of a friction, told as a hysteresis, bends the stiffness; under one load nothing else tells it."""
    other = TRUE.replace({'friction.Ff': 0.03}).with_effects('friction')
    one = [experiment(CHANNELS, current, 0.588, k, muscle=other) for k, current in enumerate((0.27, 0.2))]
    two = [one[0], experiment(CHANNELS, 0.2, 1.2, 2, muscle=other)]
    assert one_load(one) and not one_load(two)
    for runs, trusted in ((one, False), (two, True)):
        fitted = in_turn(calibrate(runs, NOMINAL).fit)
        (found,) = rivals_for(fitted, screen(fitted, ['hysteresis'])[0], None)
        chosen = select(found.fit, [])
        bent = replace(chosen, calibrated=fitted)
        held, said = foretelling(bent.final, fitted).muscle['k0'], bent.final.muscle['k0']
        assert (held == said) == trusted
        if not trusted:
            assert abs(np.log(held / NOMINAL['k0'])) < abs(np.log(said / NOMINAL['k0']))


def test_a_muscle_of_another_make_keeps_what_one_load_tells_of_it():
    """A coil two hundred times as stiff as assumed: held near the assumed one, it would foretell nothing any more."""
    stiff = TRUE.replace({'k0': 5000.0, 'B': 0.1}).with_effects('hysteresis')
    runs = [experiment(CHANNELS, current, 1.77, k, muscle=stiff) for k, current in enumerate((0.27, 0.2))]
    fitted = in_turn(calibrate(runs, NOMINAL).fit)
    (found,) = rivals_for(fitted, screen(fitted, ['hysteresis'])[0], None)
    chosen = replace(select(found.fit, []), calibrated=fitted)
    further = experiment(CHANNELS, 0.25, 1.77, 9, muscle=stiff)
    muscle = handed_on(chosen)[0]
    assert muscle.effects == ('hysteresis',)
    compared = replay(further, muscle, own=own_of(further, muscle))
    for name, most in {'temperature': 0.3, 'displacement': 1e-4}.items():
        assert compared[name].rmse < most


def test_what_is_found_in_another_channel_moves_no_stiffness_that_the_stroke_tells():
    """A resistance that bends takes ten times what the stroke's form could lose."""
    curved = TRUE.replace({'k0': 500.0, 'B': 0.3, 'tcr_curvature.b': 4e-5}).with_effects('tcr_curvature')
    runs = [experiment(CHANNELS, current, 1.77, k, muscle=curved) for k, current in enumerate((0.29, 0.2))]
    fitted = in_turn(calibrate(runs, NOMINAL).fit)
    (found,) = rivals_for(fitted, screen(fitted, ['tcr_curvature'])[0], None)
    final = settle_noise(found.fit)[0]
    bare = with_noise(fitted, dict(final.problem.noise))
    held = foretelling(final, bare)
    assert final.objective < 0.7 * bare.objective
    left = [f.mean_square['displacement'] ** 0.5 for f in (held, final)]
    assert left[0] <= 1.02 * left[1]

"""Calibration: true values found, intervals that hold them, silence where the data fix nothing."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOISE, NOMINAL, TIME, TRUE, experiment

from tcp_muscle_ros.diagnosis.diagnose import diagnose
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.fitting.least_squares import fit, slopes
from tcp_muscle_ros.diagnosis.fitting.weighing import each_by_its_noise, structures
from tcp_muscle_ros.diagnosis.hypothesis.unknowns import base_unknowns
from tcp_muscle_ros.diagnosis.noise.noise import over_all
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.holding import Conditions
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.muscle import simulate
from tcp_muscle_ros.recording.recording import Channel, Recording


def estimates(found):
    return {e.name: e for e in (*found.estimates, *found.combinations) if e.recording is None}


def test_all_channels_under_three_loads_fix_the_muscle_and_intervals_hold_it():
    runs = [
        experiment(('temperature', 'resistance', 'displacement'), i, f, k)
        for k, (i, f) in enumerate([(0.27, 0.588), (0.24, 0.294), (0.21, 0.98)])
    ]
    found = estimates(calibrate(runs, NOMINAL))
    inside = 0
    for name in ('hA', 'C', 'R0', 'a_R', 'k0', 'B'):
        e = found[name]
        assert e.fixed, name
        assert e.value == pytest.approx(TRUE[name], rel=0.03), name
        width = e.high - e.low
        assert abs(e.value - TRUE[name]) < 1.5 * width, name
        inside += e.low <= TRUE[name] <= e.high
    assert inside >= 4  # of six at 90 %: fewer has a chance of 2 in 100


def test_an_eightfold_error_of_hA_in_the_nominal_set_is_found_home_from():
    printed = NOMINAL.replace(hA=0.15)
    found = estimates(calibrate([experiment(('temperature', 'resistance', 'displacement'))], printed))
    assert found['hA'].value == pytest.approx(TRUE['hA'], rel=0.02)


def running_away():
    """A problem, and where in it the model runs away: the hotter, the more heat, without end."""
    run = experiment(('resistance', 'temperature'), 0.27, 0.588, 0)
    problem = calibrate([run], NOMINAL).fit.problem
    strong = replace(run.imposed, drive=7.0 * run.imposed.drive)
    problem = replace(problem, experiments=(replace(run, imposed=strong),))
    steep = next(k for k, u in enumerate(problem.unknowns) if u.name == 'a_R')
    away = problem.start()
    away[steep] = problem.unknowns[steep].to_fit(0.05)
    return problem, away


def test_a_fit_that_is_begun_where_the_model_runs_away_begins_with_what_is_nominal():
    problem, away = running_away()
    begun = fit(problem, away, rounds=1)
    assert np.isfinite(begun.misfit)
    np.testing.assert_allclose(begun.z, fit(problem, rounds=1).z)


@pytest.mark.filterwarnings('ignore::RuntimeWarning')
def test_a_fit_goes_on_from_slopes_that_were_taken_where_the_model_runs_away():
    problem, away = running_away()
    shown = problem.predictions(away)
    assert not all(np.all(np.isfinite(values)) for values in shown[0].values())
    taken = slopes(problem, away, shown)
    assert all(np.all(np.isfinite(columns)) for columns in taken[0].values())
    assert np.isfinite(fit(problem, away, rounds=3, known=taken, polish=False).misfit)


@pytest.mark.parametrize('seed', range(3))
def test_stroke_alone_under_power_fixes_the_time_constant_and_by_the_modulus_the_temperature(seed):
    """Gain, heat exchange and capacity trade against each other along a valley, at whose end is the muscle: how its
    modulus falls tells how hot it is."""
    heat = np.where(np.mod(TIME, 70.0) < 25.0, 0.9, 0.0)
    found = estimates(calibrate([experiment(('displacement',), kind='power', drive=heat, seed=seed)], NOMINAL))
    assert found['C/hA'].fixed
    assert found['C/hA'].value == pytest.approx(TRUE['C'] / TRUE['hA'], rel=0.005)
    for name in ('hA', 'C', 'B'):
        e = found[name]
        assert e.value == pytest.approx(TRUE[name], rel=0.2), name
        assert e.low < TRUE[name] < e.high, name
    assert not found['k0'].fixed


def test_a_stroke_that_fixes_no_parameter_and_moves_plainly_is_not_too_little():
    """It jumps about whatever heats the muscle: no effect is tried, and where it is missed is said."""
    rng, run = np.random.default_rng(0), experiment(('displacement',))
    jumps = np.repeat(rng.uniform(0.0, 0.02, TIME.size // 50), 50) + NOISE['displacement'] * rng.standard_normal(
        TIME.size
    )
    o = run.observed['displacement']
    found = diagnose([replace(run, observed={'displacement': replace(o, value=jumps)})], NOMINAL)
    assert found.verdict == 'unexplained' and found.findings == ()
    assert found.location is not None and found.location.channel == 'displacement'
    assert any('no listed effect was tried' in note for note in found.notes)
    assert 'No listed effect was tried on it' in found.headline and not found.tried


def test_no_load_draws_a_muscle_to_more_than_twice_its_length():
    """Under one load a stroke that stops half way would be that of a muscle a thousand times as soft."""
    run = experiment(('displacement',), load=0.588)
    o = run.observed['displacement']
    stopped = np.minimum(o.value, 0.5 * o.value.max())
    found = estimates(calibrate([replace(run, observed={'displacement': replace(o, value=stopped)})], NOMINAL))
    assert found['k0'].value >= 0.588 / NOMINAL['H0'] * (1.0 - 1e-9)
    soft = NOMINAL.replace(k0=3.0)  # the lab knows its muscle to be soft
    assert next(u for u in base_unknowns([run], soft) if u.name == 'k0').low == pytest.approx(1.5)


def test_parameters_of_single_runs_are_kept_apart():
    runs = [experiment(('temperature', 'displacement'), seed=k) for k in range(2)]
    other = simulate(TRUE.replace(B=1.1), TIME, runs[1].imposed.drive, load=0.588)
    observed = {**runs[1].observed, 'displacement': Observed(TIME, other.displacement, np.ones(TIME.size))}
    runs[1] = Experiment('other', runs[1].imposed, runs[1].holding, observed)
    calibration = calibrate(runs, NOMINAL, separate=('B',))
    gains = {e.recording: e.value for e in calibration.estimates if e.name == 'B'}
    assert gains[1] / gains[0] == pytest.approx(1.1 / 1.45, rel=0.02)
    # A further run has a gain of its own, of which no more is known than how these differ.
    k = [u.name for u in calibration.known.unknowns].index('B')
    differ = np.var(np.log(list(gains.values())), ddof=1)
    assert differ < calibration.known.covariance[k, k] < 1.5 * differ


def test_gaps_and_channels_of_their_own_stamps_are_no_trouble():
    run = experiment(('temperature', 'displacement'))
    t, x = TIME[TIME > 3.0] + 0.037, run.observed['displacement'].value[TIME > 3.0]
    kept = (t < 90.0) | (t > 110.0)
    made = Recording(
        'made',
        {
            'current': Channel('current', TIME, run.imposed.drive, 'current'),
            'load': Channel('load', TIME[:1], np.array([0.588]), 'load'),
            'temperature': Channel('temperature', TIME, run.observed['temperature'].value, 'temperature'),
            'displacement': Channel('displacement', t[kept] - 0.037, x[kept], 'displacement'),
        },
        0,
    )
    found = estimates(calibrate([prepare(made, NOMINAL, Conditions())], NOMINAL))
    # No resistance was recorded, so heat is known as far as R0 is: the ratio is what the data fix.
    assert found['hA/R0'].value == pytest.approx(TRUE['hA'] / TRUE['R0'], rel=0.02)
    assert found['hA'].low < TRUE['hA'] < found['hA'].high


def test_the_error_of_a_calibration_is_that_of_single_samples_as_a_replay_has_it():
    seen = experiment(('displacement',))
    shown = {'current': seen.imposed.drive, 'displacement': seen.observed['displacement'].value}
    channels = {name: Channel(name, TIME, value, name) for name, value in shown.items()}
    recording = Recording('csv', channels, 0, {'load_n': 0.588})
    errors = [calibrate([prepare(recording, NOMINAL, most=most)], NOMINAL).rmse() for most in (None, 200)]
    assert errors[0]['displacement'][0] == pytest.approx(NOISE['displacement'], rel=0.1)
    assert errors[1]['displacement'][0] == pytest.approx(errors[0]['displacement'][0], rel=0.1)


CHANNELS = ('temperature', 'resistance', 'displacement')


def averaged_in(seed, current, samples, slow=0.0):
    """A recording of means of so many samples, with a noise (m) of the stroke that stays for seconds."""
    made, rng = experiment(CHANNELS, current, seed=seed), np.random.default_rng(seed + 50)
    clean = simulate(TRUE, TIME, made.imposed.drive, kind='current', load=0.588)
    wanders = np.zeros(TIME.size)
    for k, step in enumerate(slow * rng.standard_normal(TIME.size)):
        wanders[k] = 0.96 * wanders[k - 1] + 0.28 * step  # of 5 s
    observed = {}
    for name in CHANNELS:
        noise = NOISE[name] / np.sqrt(samples) * rng.standard_normal(TIME.size)
        value = getattr(clean, name) + noise + (wanders if name == 'displacement' else 0.0)
        observed[name] = Observed(TIME, value, np.full(TIME.size, float(samples)), spacing=0.2 / samples)
    return replace(made, observed=observed)


@pytest.mark.parametrize('samples', [(100, 100, 1), (1, 1, 100)])
def test_means_of_many_samples_and_single_ones_are_both_weighed_by_their_noise(samples):
    runs = [averaged_in(k, current, n) for k, (current, n) in enumerate(zip((0.27, 0.22, 0.25), samples, strict=True))]
    fitted = calibrate(runs, NOMINAL).fit
    for residuals in fitted.residuals:
        for white in np.split(residuals[:-1], len(CHANNELS)):
            assert 0.5 < np.mean(white**2) < 1.4  # a noise is a ten thousandth of the span at least
    noise = {name: found.noise for name, found in structures(fitted).items()}
    said = over_all(fitted.problem.experiments, noise)  # as errors are: over all values
    assert said['displacement'] == pytest.approx(
        NOISE['displacement'] * np.sqrt(np.mean(1.0 / np.array(samples))), rel=0.2
    )


def test_a_noise_that_no_mean_takes_away_is_not_taken_for_less_where_more_was_averaged():
    runs = [averaged_in(k, current, n, 5e-5) for k, (current, n) in enumerate([(0.27, 1), (0.22, 1), (0.25, 100)])]
    beside = [run.observed['displacement'].beside for run in calibrate(runs, NOMINAL).fit.problem.experiments]
    assert beside[:2] == pytest.approx([1.0, 1.0], abs=0.1)
    assert beside[2] < 2.0  # by the counts 10, by what is quick 5


def test_recordings_that_are_averaged_nearly_alike_have_one_noise():
    runs = [averaged_in(k, current, n) for k, (current, n) in enumerate([(0.27, 2), (0.22, 3)])]
    fitted = calibrate(runs, NOMINAL).fit
    assert each_by_its_noise(fitted) is fitted
    assert all(observed.beside == 1.0 for run in fitted.problem.experiments for observed in run.observed.values())

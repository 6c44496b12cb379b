"""What a listed form may miss: allowed for as an error of known size, and taken back."""

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TIME, TRUE, experiment

from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.fitting.forms import allowing_forms
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise
from tcp_muscle_ros.diagnosis.hypothesis.latents import Latent
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.noise.discrepancy import Allowance, expected, whitening_of
from tcp_muscle_ros.diagnosis.noise.noise import Noise
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.diagnosis.search.candidates import screen
from tcp_muscle_ros.diagnosis.search.refitting import rivals_for


@pytest.mark.parametrize('phi', [0.0, 0.7])
def test_an_allowed_error_weighs_what_its_covariance_says(phi):
    """Against the same with full matrices: noise of one colour, and columns of independent unit sizes."""
    rng = np.random.default_rng(5)
    time, noise = np.arange(120) * 0.2, Noise(0.3, phi)
    columns = np.column_stack([np.sin(time), np.linspace(0.0, 2.0, 120), rng.standard_normal(120)])
    observed, allowed = Observed(time, np.zeros(120), np.ones(120)), Allowance(columns[:, :1], columns[:, 1:])
    left = columns @ np.array([0.5, -1.0, 2.0]) + 0.3 * rng.standard_normal(120)
    of_noise = noise.sigma**2 * phi ** np.abs(np.subtract.outer(np.arange(120), np.arange(120)))
    together = of_noise + columns @ columns.T
    white = whitening_of(observed, allowed, noise)(left)
    assert white @ white == pytest.approx(left @ np.linalg.solve(together, left), rel=1e-9)
    most_likely = columns @ columns.T @ np.linalg.solve(together, left)
    np.testing.assert_allclose(expected(observed, allowed, noise, left), most_likely, atol=1e-9)


def test_an_error_that_channels_share_is_told_by_the_one_that_shows_it_plainly():
    """Against the same with full matrices; the zero of the displacement is known, or inferred with the error."""
    rng = np.random.default_rng(6)
    (run,) = [experiment(('temperature', 'displacement'), 0.27, 0.3, 0)]
    sizes = {name: observed.time.size for name, observed in run.observed.items()}
    noise = {'temperature': Noise(0.2, 0.0), 'displacement': Noise(1e-4, 0.0)}
    ways = {name: rng.standard_normal((n, 2)) * 20.0 * noise[name].sigma for name, n in sizes.items()}
    problem = Problem((run,), TRUE, (), noise, (Latent(together=ways),))
    columns = np.vstack([ways[name] for name in sizes])
    spread = np.concatenate([np.full(n, noise[name].sigma) for name, n in sizes.items()])
    together = np.diag(spread**2) + columns @ columns.T
    shown = problem.predict({}, 0)
    left = columns @ np.array([0.7, -1.2]) + spread * rng.standard_normal(spread.size)
    seen = dict(zip(sizes, np.split(left, [sizes['temperature']]), strict=True))
    moved = {name: run.observed[name].value - mine for name, mine in seen.items()}
    white = problem.residual({**shown, **moved}, 0, {'displacement': 0.0})[:-1]
    assert white @ white == pytest.approx(left @ np.linalg.solve(together, left), rel=1e-9)
    most_likely = np.concatenate(list(problem.expected_discrepancy(seen, 0).values()))
    np.testing.assert_allclose(most_likely, columns @ columns.T @ np.linalg.solve(together, left), atol=1e-9)
    # What the temperature says of the error tells it in the displacement, whatever that shows itself.
    constant = np.repeat([0.0, 1.0], list(sizes.values()))
    zero = 0.003
    off = {**moved, 'displacement': moved['displacement'] - zero}
    inverse = np.linalg.inv(together)
    best = float(constant @ inverse @ (left + zero * constant) / (constant @ inverse @ constant))
    assert problem.zeros({**shown, **off}, 0)['displacement'] == pytest.approx(best, rel=1e-6)
    white = problem.residual({**shown, **off}, 0)[:-1]
    least = left + (zero - best) * constant
    assert white @ white == pytest.approx(least @ inverse @ least, rel=1e-6)


def test_forms_are_allowed_for_and_taken_back():
    muscle = TRUE.with_effects('natural_convection')
    loads = (0.3, np.select([np.mod(TIME, 70.0) < 20.0, np.mod(TIME, 70.0) < 45.0], [0.3, 1.2], 0.6))
    runs = [experiment(('temperature', 'displacement'), 0.27, load, k, muscle=muscle) for k, load in enumerate(loads)]
    fitted = settle_noise(calibrate(runs, NOMINAL).fit)[0]
    (found,) = rivals_for(fitted, screen(fitted, ['natural_convection'])[0], None)
    plain = settle_noise(found.fit)[0]
    allowed = allowing_forms(plain, ['natural_convection'])
    for mine, latent in zip(allowed.problem.experiments, allowed.problem.latents, strict=True):
        for name, observed in mine.observed.items():
            # A quarter of what the effect shows beside what the parameters mimic, at every instant.
            forms = latent.allowance(name).forms
            assert forms is not None
            assert 0.0 < np.max(np.abs(forms)) < 4.0 * plain.problem.policy.form * np.ptp(observed.value)
    # The form is the muscle's own here: hardly anything is taken for an error of it.
    for left, weighed in zip(allowed.left, allowed.weighed, strict=True):
        for name, mine in left.items():
            assert np.std(mine - weighed[name]) < 0.5 * allowed.problem.noise[name].sigma
    back = allowing_forms(allowed, ())
    assert all(a.forms is None for latent in back.problem.latents for a in latent.allowances.values())
    assert back.objective == pytest.approx(plain.objective, rel=1e-4)

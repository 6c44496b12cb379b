"""What runs of one protocol do not share, from runs of which it is known."""

import numpy as np
import pytest

from tcp_muscle_ros.diagnosis.noise.repeatability import repeatability

TIME = np.arange(0.0, 60.0, 0.2)
COURSE = np.where(TIME < 30.0, 1.0 - np.exp(-TIME / 8.0), np.exp(-(TIME - 30.0) / 8.0))


def runs(count: int, gains: float = 0.0, quick: float = 0.0, slow: float = 0.0) -> np.ndarray:
    rng = np.random.default_rng(count)
    phase = rng.uniform(0.0, 2.0 * np.pi, (count, 1))
    own = quick * rng.standard_normal((count, TIME.size))
    own = own + slow * np.sqrt(2.0) * np.sin(2.0 * np.pi * TIME / 30.0 + phase)
    return (1.0 + gains * rng.standard_normal((count, 1))) * COURSE + own + 0.3 * rng.standard_normal((count, 1))


def test_one_run_says_nothing_and_equal_runs_repeat():
    assert repeatability(TIME, COURSE[None]) is None
    found = repeatability(TIME, np.stack([COURSE, COURSE, COURSE]))
    assert (found.runs, found.peak) == (3, pytest.approx(np.ptp(COURSE)))
    assert max(found.plain, found.own_gain, found.foretold, *found.by_scale) < 1e-12


def test_a_gain_and_a_zero_of_each_run_are_taken_out():
    found = repeatability(TIME, runs(8, gains=0.2))
    assert found.plain > 0.1 and found.own_gain < 1e-6 and found.foretold < 1e-9


@pytest.mark.parametrize(('kind', 'place'), [('quick', 0), ('slow', 2)])
def test_what_each_run_has_for_itself_is_measured_at_its_time_scale(kind, place):
    found = repeatability(TIME, runs(12, gains=0.1, **{kind: 0.05}))
    assert found.own_gain == pytest.approx(0.05, rel=0.15)
    assert found.foretold == pytest.approx(0.05 * np.sqrt(12 / 11), rel=0.15)
    rest = [size for k, size in enumerate(found.by_scale) if k != place]
    assert found.by_scale[place] == pytest.approx(0.05, rel=0.25) and max(rest) < 0.4 * found.by_scale[place]


def test_of_two_runs_one_foretells_the_other_less_well_than_their_course_would():
    found = repeatability(TIME, runs(2, quick=0.05))
    assert found.foretold == pytest.approx(0.05 * np.sqrt(2.0), rel=0.15)


def test_a_time_scale_shorter_than_two_samples_is_not_given():
    found = repeatability(TIME[::10], runs(3, slow=0.05)[:, ::10])
    assert np.isnan(found.by_scale[0]) and np.isfinite(found.by_scale[1:]).all()


def test_runs_that_do_not_move_say_nothing_and_runs_that_cancel_each_other_have_no_course():
    assert repeatability(TIME, np.zeros((2, TIME.size))) is None
    assert repeatability(TIME, np.full((2, TIME.size), 0.1)) is None
    found = repeatability(TIME, np.stack([COURSE, -COURSE]))
    assert found.own_gain == pytest.approx(np.sqrt(2.0) * np.std(COURSE))
    assert np.isfinite([found.plain, found.foretold, *found.by_scale]).all()

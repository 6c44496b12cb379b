"""Whether a measured signal is alive, and whether the current that is asked for flows."""

from math import exp, log, nan

import pytest

from tcp_muscle_ros.control.watches import ASKED, UNTAKEN, CurrentWatch, FeedbackWatch

PERIOD = 0.01


def test_feedback_is_lost_after_its_timeout_and_comes_back():
    watch = FeedbackWatch('displacement', 0.2, 1e-5)
    assert watch.problem(0.0, 0.0) == 'no displacement yet'
    watch.receive(0.001, 0.0)
    assert watch.problem(0.2, 0.0) == ''
    assert watch.problem(0.21, 0.0) == 'no displacement for 0.2 s'
    assert not watch.receive(nan, 0.22)
    assert watch.problem(0.22, 0.0) != ''
    watch.receive(0.001, 0.23)
    assert watch.problem(0.23, 0.0) == ''


def watched(asked, applied, seconds, watch=None, begin=0.0):
    """The watch after so many seconds of the same."""
    watch = watch or CurrentWatch()
    for k in range(round(seconds / PERIOD) + 1):
        watch.update(begin + k * PERIOD, asked, applied)
    return watch


def test_a_current_that_is_not_taken_is_noticed_and_that_it_is_again():
    assert not watched(0.27, 0.0, UNTAKEN - 2 * PERIOD).untaken, 'its receiver may still be discovered'
    watch = watched(0.27, 0.001, UNTAKEN + 2 * PERIOD)
    assert watch.untaken, 'noise is no current'
    assert watched(0.0, 0.0, 5.0, watch, 2.0).untaken, 'nothing is asked for: nothing is known'
    assert not watched(ASKED, ASKED, PERIOD, watch, 8.0).untaken


@pytest.mark.parametrize(('asked', 'applied'), [(0.0, 0.0), (0.5 * ASKED, 0.0), (0.27, 0.05), (0.27, None)], ids=str)
def test_little_that_is_asked_a_lower_limit_or_nobody_who_says_it_are_no_refusal(asked, applied):
    assert not watched(asked, applied, 5.0).untaken


def test_a_frozen_value_is_found_when_the_model_has_moved_by_more_than_five_quanta():
    watch = FeedbackWatch('displacement', 0.2, 1e-5)
    for tick in range(100):
        watch.receive(0.001, tick * 0.01)
        problem = watch.problem(tick * 0.01, predicted=tick * 1e-6)
        assert bool(problem) == (tick > 50), tick
    watch.receive(0.001 + 1e-12, 1.0)
    assert watch.problem(1.0, 1e-4) == ''


def test_a_late_message_or_a_slow_sensor_is_not_frozen():
    watch = FeedbackWatch('displacement', 0.2, 1e-5)
    for tick in range(1000):
        if tick % 10 == 0:  # a sensor at a tenth of the rate, of a muscle that moves
            watch.receive(tick * 1e-4, tick * 0.01)
        assert watch.problem(tick * 0.01, predicted=tick * 1e-4) == '', tick


def problems_while(watch, predictions, *, value=0.001, period=0.01):
    found = []
    for tick, predicted in enumerate(predictions):
        watch.receive(value, tick * period)
        found.append(bool(watch.problem(tick * period, predicted)))
    return found


def test_a_muscle_at_rest_is_not_frozen():
    watch = FeedbackWatch('displacement', 0.2, 1e-5)
    assert not any(problems_while(watch, [2e-3 + 1e-6 * (tick % 7) for tick in range(10_000)]))


def test_it_thaws_when_the_model_has_come_to_rest_too():
    watch = FeedbackWatch('displacement', 0.2, 1e-5)
    cooling = [1e-2 * exp(-tick * 0.01 / 1.0) for tick in range(1200)]
    frozen = problems_while(watch, cooling)
    thaw = frozen.index(False, 5)
    assert all(frozen[5:thaw]) and not any(frozen[thaw:])
    soonest = 100 * (1.0 + log(1e-2 * (1.0 - exp(-1.0)) / 1e-5))  # a second in which it moved by one quantum
    assert soonest <= thaw <= soonest + 100


def test_a_stuck_sensor_cannot_heat_the_muscle_by_retrying():
    # The model's first-order answer to a controller that drives at full speed whenever the watch lets it.
    watch = FeedbackWatch('displacement', 0.2, 1e-5)
    moved, highest = 0.0, 0.0
    for tick in range(20_000):
        watch.receive(0.001, tick * 0.01)
        driven = not watch.problem(tick * 0.01, moved)
        moved += ((5e-2 if driven else 0.0) - moved) * 0.01 / 9.0
        highest = max(highest, moved)
    assert 5e-5 < highest < 4e-4


def test_feedback_that_returns_is_not_held_to_what_the_model_said_before():
    watch = FeedbackWatch('displacement', 0.2, 1e-5)
    watch.receive(0.001, 0.0)
    assert watch.problem(0.0, 0.04) == ''
    assert watch.problem(1.0, 0.03) == 'no displacement for 0.2 s'
    watch.receive(0.001, 1.1)
    assert watch.problem(1.1, 0.02) == ''

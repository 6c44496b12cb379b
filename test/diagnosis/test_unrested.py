"""Recordings that begin before the muscle has rested."""

import pytest
from diagnosis.made import NOMINAL, TRUE, experiment

from tcp_muscle_ros.diagnosis.answer.handed_on import handed_on
from tcp_muscle_ros.diagnosis.answer.replaying import as_given, own_of, replay
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.search import second_start
from tcp_muscle_ros.diagnosis.search.second_start import select_twice

CHANNELS = ('temperature', 'resistance', 'displacement')
CREEPING = TRUE.replace({'creep.J': 0.3, 'creep.tau50': 20.0}).with_effects('creep')
AT_THE_START = (0.0, -1.0, -0.6)
FAR_APART = (0.0, -1.0, 1.0)  # so that only a second start finds the law


def found_in(starts):
    runs = [
        experiment(CHANNELS, current, 0.588, k, muscle=CREEPING.replace({'creep.start': start}))
        for k, (current, start) in enumerate(zip((0.27, 0.22, 0.25), starts, strict=True))
    ]
    return select_twice(in_turn(calibrate(runs, NOMINAL).fit), ['creep'])


def states(fitted):
    return {u.recording: fitted.values[u.key] for u in fitted.problem.unknowns if u.name == 'creep.start'}


@pytest.mark.long
def test_what_a_recording_begins_with_is_its_own_and_the_law_is_found_beside_it():
    found = found_in(AT_THE_START)
    assert [c.effect for c in found.chosen] == ['creep']
    assert [states(found.final)[k] for k in range(3)] == [pytest.approx(start, abs=0.15) for start in AT_THE_START]
    assert found.final.muscle['creep.J'] == pytest.approx(0.3, rel=0.15)
    # The next one probably begins as those after the first did; what it begins with is fitted to it.
    muscle = handed_on(found)[0]
    assert muscle['creep.start'] == pytest.approx(-0.8, abs=0.15)
    further = experiment(CHANNELS, 0.24, 0.588, 9, muscle=CREEPING.replace({'creep.start': 0.3}))
    own = own_of(further, muscle)
    assert own.states['creep.start'] == pytest.approx(0.3, abs=0.2)
    as_it_was, as_stated = (
        replay(further, muscle, own=o)['displacement'].rmse for o in (own, as_given(further, muscle))
    )
    assert as_it_was < 0.5 * as_stated


def test_of_a_muscle_that_has_rested_no_state_is_fitted():
    found = found_in((0.0, 0.0, 0.0))
    assert [c.effect for c in found.chosen] == ['creep']
    assert not states(found.final)
    assert handed_on(found)[0]['creep.start'] == 0.0


@pytest.mark.long
def test_a_second_start_after_which_no_work_is_left_does_not_count_for_nothing_holds_it_against_rivals(monkeypatch):
    best = second_start._best_start

    def spent(found, effects, progress):
        start = best(found, effects, progress)
        found.final.problem.work.add(found.final.problem.work.limit)
        return start

    assert [c.effect for c in found_in(FAR_APART).chosen] == ['creep']
    monkeypatch.setattr(second_start, '_best_start', spent)
    assert not found_in(FAR_APART).chosen

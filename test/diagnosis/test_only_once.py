"""A first stroke, which comes but once, and the sensor that warms up before each recording."""

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TRUE, experiment, shown_with

from tcp_muscle_ros.diagnosis.answer.handed_on import ages_of, handed_on
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.search.rivals import Rival, own, sound
from tcp_muscle_ros.diagnosis.search.selection import select

CHANNELS = ('temperature', 'resistance', 'displacement')
POOL = ['first_cycle', 'displacement_drift', 'creep', 'fatigue']
HOTTEST, COURSE = 'first_cycle.hottest', 'first_cycle.course'
NEW = TRUE.replace({'first_cycle.a': 0.004}).with_effects('first_cycle')
CURRENTS = (0.27, 0.22, 0.25)


def found_in(runs):
    return select(in_turn(calibrate(runs, NOMINAL).fit), POOL)


def warmed(run, size):
    """The same recording by a laser that warms up: so much (m), in five minutes."""
    return shown_with(run, lambda since: size * (1.0 - np.exp(-since / 300.0)))


@pytest.mark.parametrize('once', [True, False])
def test_a_first_stroke_comes_in_the_first_recording_or_in_each(once):
    muscles = [NEW if k == 0 or not once else TRUE for k in range(3)]
    made = zip(CURRENTS, muscles, strict=True)
    runs = [experiment(CHANNELS, current, 0.588, k, muscle=muscle) for k, (current, muscle) in enumerate(made)]
    found = found_in(runs)
    assert [c.effect for c in found.chosen] == ['first_cycle']
    muscle = handed_on(found)[0]
    assert muscle[COURSE] == float(once)
    assert muscle['first_cycle.a'] == pytest.approx(0.004, rel=0.3)
    # Handed on is the muscle after the last recording: the hottest was the first.
    hottest = max(float(outputs.temperature.max()) for outputs in found.final.outputs)
    assert muscle[HOTTEST] == pytest.approx(hottest, abs=1.0)
    assert [age.values[HOTTEST] for age in ages_of(found.final.problem)] == pytest.approx(
        [TRUE[HOTTEST], hottest, hottest], abs=1.0
    )


@pytest.mark.long
def test_a_law_that_is_bent_to_its_ends_is_the_sensor_in_its_place():
    """A first stroke at the least warming, and as slow as it may be, is a course in time."""
    runs = [
        warmed(experiment(CHANNELS, current, 0.588, k, muscle=TRUE), size)
        for k, (current, size) in enumerate(zip(CURRENTS, (3.0e-3, 1.5e-3, 1.6e-3), strict=True))
    ]
    found = found_in(runs)
    assert [c.effect for c in found.chosen] == ['displacement_drift']
    assert own(Rival('displacement_drift', found.final, 0.0))
    assert sound(Rival('displacement_drift', found.final, 0.0))

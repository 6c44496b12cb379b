"""What is refused before a fit, and what is a muscle of another make."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TIME, experiment

from tcp_muscle_ros.diagnosis.observation.admission import refuse_other_scale
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.recording import Recording

CHANNELS = ('temperature', 'displacement')
# A coil of thicker thread: it sheds so much heat that it stays whole under a current under which the assumed one melts.
THICK = NOMINAL.replace(R0=10.3, a_R=0.0019, hA=0.034, C=0.48, k0=500.0, B=0.2)
HELD = np.where(np.mod(TIME, 100.0) < 60.0, 0.65, 0.0)


def recorded(drive, muscle):
    return experiment(CHANNELS, drive=drive, load=1.0, muscle=muscle)


def refused(run):
    refuse_other_scale(run, NOMINAL, Recording('run', {}, 0))


def test_a_muscle_that_bears_what_the_assumed_one_does_not_is_none_in_other_units():
    run = recorded(HELD, THICK)
    assert np.ptp(run.observed['displacement'].value) < 0.01 * np.ptp(run.predict(NOMINAL)['displacement'])
    refused(run)


@pytest.mark.parametrize('factor', [1e3, 1e-3])
def test_its_stroke_in_another_unit_is_refused(factor):
    run = recorded(HELD, THICK)
    stroke = run.observed['displacement']
    scaled = {**run.observed, 'displacement': replace(stroke, value=factor * stroke.value)}
    with pytest.raises(BadInput, match='displacement moves as this muscle would'):
        refused(replace(run, observed=scaled))

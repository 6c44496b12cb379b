"""Another model takes over from the one in charge: the current makes no step, and no limit becomes looser."""

import numpy as np
import pytest

from tcp_muscle_ros.control.handover import FADE, Handover
from tcp_muscle_ros.control.tracking import TrackingController
from tcp_muscle_ros.muscle import Muscle, Parameters

PERIOD, LOAD, LIMIT = 0.01, 0.5884, 0.27
MODEL = Parameters.named('karami_tadesse_2017')
WORN = {
    'resistance': {'R0': 0.7 * MODEL['R0']},
    'loss': {'hA': 1.4 * MODEL['hA']},
    'stiffness': {'k0': 0.8 * MODEL['k0']},
}


def controller(model, limit=LIMIT, **more):
    return TrackingController(model, PERIOD, limit, LOAD, MODEL['T0'], **more)


def play(muscle, handover, setpoint, duration, before=0.0):
    """Rows of current (A), displacement (m) and fibre temperature (K) for so many s."""
    rows, current = [], before
    for k in range(round(duration / PERIOD)):
        reading = muscle.step(PERIOD, current)
        command = handover.update(
            setpoint(k * PERIOD) if callable(setpoint) else setpoint,
            displacement=reading.displacement,
            temperature=reading.temperature,
            applied_current=current,
        )
        current = command.current
        rows.append((current, reading.displacement, reading.fibre_temperature, command.predicted_temperature))
    return np.array(rows)


@pytest.mark.parametrize('worn', WORN)
@pytest.mark.parametrize('mode', ['model', 'pid'])
def test_a_model_is_adopted_and_taken_back_without_a_step_in_the_current(worn, mode):
    true = MODEL.replace(WORN[worn])
    muscle, handover = Muscle(true, load=LOAD), Handover(controller(MODEL, mode=mode), PERIOD)
    rows = play(muscle, handover, 0.006, 40.0)
    usual = np.abs(np.diff(rows[-500:, 0])).max()
    for adopted in (controller(true, mode=mode), None):
        before = rows[-1]
        handover.adopt(adopted)
        rows = play(muscle, handover, 0.006, 20.0, before[0])
        steps = np.abs(np.diff(np.concatenate([[before[0]], rows[:, 0]])))
        assert steps.max() < usual + 1e-3, f'{1e3 * steps.max():.2f} mA'
        assert np.abs(rows[:, 1] - 0.006).max() < 3e-4
        assert np.abs(rows[-200:, 1] - 0.006).max() < 1e-4


def test_a_step_would_show_without_the_handover():
    """The test above can fail: the controller of another model, put in place of the old one, does step."""
    muscle, handover = Muscle(MODEL, load=LOAD), Handover(controller(MODEL), PERIOD)
    before = play(muscle, handover, 0.006, 40.0)[-1]
    anew = play(muscle, Handover(controller(MODEL.replace(WORN['resistance'])), PERIOD), 0.006, 1.0, before[0])
    assert np.abs(np.diff(np.concatenate([[before[0]], anew[:, 0]]))).max() > 5e-3


@pytest.mark.parametrize('factor', [0.5, 2.0])
def test_the_hotter_of_both_temperatures_counts_whichever_model_is_in_charge(factor):
    """A model that believes in more or less loss and stroke than the muscle's: neither lets it be heated further."""
    other = MODEL.replace({'hA': factor * MODEL['hA'], 'B': factor * MODEL['B']})
    hottest = 273.15 + 60.0
    muscle = Muscle(MODEL, load=LOAD)
    handover = Handover(controller(MODEL, temperature_limit=hottest), PERIOD)
    handover.adopt(controller(other, temperature_limit=hottest))
    rows = play(muscle, handover, 0.05, 120.0)  # further than it reaches
    assert rows[:, 2].max() < hottest + 0.5
    alone = Handover(controller(other, temperature_limit=hottest), PERIOD)
    assert np.all(rows[1:, 3] >= rows[:-1, 2] - 0.5)  # what is said to be the temperature is not below the fibre's
    if factor > 1.0:
        blind = Muscle(MODEL, load=LOAD)
        current = 0.0
        for _ in range(12_000):
            blind.step(PERIOD, current)
            shown = blind.reading(current).displacement
            current = alone.update(0.05, displacement=shown, applied_current=current).current
        assert blind.reading(0.0).fibre_temperature > hottest + 5.0  # that model alone would have passed the limit


def test_models_that_follow_one_another_wait_for_the_one_before():
    muscle, handover = Muscle(MODEL, load=LOAD), Handover(controller(MODEL), PERIOD)
    rows = play(muscle, handover, 0.006, 30.0)
    usual = np.abs(np.diff(rows[-500:, 0])).max()
    for values in WORN.values():
        handover.adopt(controller(MODEL.replace(values)))
        more = play(muscle, handover, 0.006, 0.3 * FADE, rows[-1, 0])
        rows = np.concatenate([rows, more])
    rows = np.concatenate([rows, play(muscle, handover, 0.006, 4.0 * FADE, rows[-1, 0])])
    assert np.abs(np.diff(rows[-round(4.9 * FADE / PERIOD) :, 0])).max() < usual + 1e-3
    assert handover._active is not handover._own and handover._leaving is None

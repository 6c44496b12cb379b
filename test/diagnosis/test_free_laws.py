"""A law without a name: found where no listed effect explains, with its curve; not where one does, nor in a null."""

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TRUE, experiment

from tcp_muscle_ros.diagnosis.answer.free_curve import free_law
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.search.free_laws import promising, with_free_law
from tcp_muscle_ros.diagnosis.search.selection import select
from tcp_muscle_ros.muscle.free_basis import basis

CHANNELS = ('temperature', 'resistance', 'displacement')
LISTED = ['heat_capacity', 'friction', 'thermocouple_lag']


def selected(muscle, effects=LISTED):
    runs = [experiment(CHANNELS, i, load, k, muscle=muscle) for k, (i, load) in enumerate(((0.27, 0.588), (0.22, 0.3)))]
    return select(in_turn(calibrate(runs, NOMINAL).fit), effects)


@pytest.fixture(scope='module')
def bumpy():
    """Air that carries away a fifth more around 55 degC: a law that no listed effect is."""
    at = np.linspace(290.0, 365.0, 6)
    bump = 0.25 * np.exp(-(((at - 328.0) / 14.0) ** 2))
    return basis('free_conductance', 290.0, 365.0, 'temperature', 6).on(TRUE, bump)


def test_what_no_listed_effect_explains_is_a_law_with_its_curve(bumpy):
    before = selected(bumpy)
    found = with_free_law(before)
    (law,) = [c for c in found.chosen if c.effect.startswith('free_')]
    assert law.effect == 'free_conductance'
    assert found.unnamed is not None
    curve = free_law(found.final, law.effect, law.nearest)
    assert curve.driver == 'temperature'
    assert 312.0 < curve.at[np.argmax(curve.value)] < 345.0
    assert np.all(curve.low <= curve.high)
    for name, error in found.final.mean_square.items():
        assert error <= before.final.mean_square[name] * 1.05
    assert found.final.mean_square['temperature'] < 0.5 * before.calibrated.mean_square['temperature']


def test_a_null_and_a_listed_effect_have_no_law():
    null = selected(TRUE)
    assert with_free_law(null) is null
    listed = selected(TRUE.with_effects('natural_convection').replace({'natural_convection.n': 0.2}),
                      ['natural_convection', *LISTED])  # fmt: skip
    assert [c.effect for c in listed.chosen] == ['natural_convection']
    assert with_free_law(listed) is listed


def test_what_is_promising_is_the_law_that_is_there(bumpy):
    first = promising(selected(bumpy, []).final)[0]
    assert (first.basis.effect, first.basis.driver) == ('free_conductance', 'temperature')

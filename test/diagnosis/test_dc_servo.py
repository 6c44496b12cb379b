"""The engine knows its machine by what that says of itself: a servo is searched as a muscle is."""

from dataclasses import fields

import pytest
from diagnosis.dc_servo import DcServo, Servo, Shown, recordings

from tcp_muscle_ros.diagnosis.diagnose import insufficient, skipped
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.fitting.room import as_well_as_read
from tcp_muscle_ros.diagnosis.model.tcp_muscle import TCP_MUSCLE
from tcp_muscle_ros.diagnosis.search.free_laws import with_free_law
from tcp_muscle_ros.diagnosis.search.remaining import unexplained
from tcp_muscle_ros.diagnosis.search.second_start import select_twice
from tcp_muscle_ros.muscle import Outputs


@pytest.mark.parametrize(('model', 'shown'), [(TCP_MUSCLE, Outputs), (DcServo(), Shown)], ids=['muscle', 'servo'])
def test_a_machine_has_what_it_says_that_it_has(model, shown):
    columns = {field.name for field in fields(shown)}
    parameters = {name for name in model.specifications if '.' not in name}
    assert {model.state, model.motion, *model.channels, *(of.column for of in model.laws.values())} <= columns
    assert model.gauge in model.channels
    assert {*model.coarse, *model.separate, model.capacity, *filter(None, [model.gain])} <= parameters
    assert {name for ratio in model.ratios for name in (ratio.top, ratio.bottom)} <= parameters
    assert model.slowness in [ratio.name for ratio in model.ratios]
    assert set().union(*model.shown_by.values()) <= set(model.channels)
    assert set(model.listed) <= set(model.effects)
    assert {f'{e.name}.{row.name}' for e in model.effects.values() for row in e.parameters} <= set(model.specifications)


def searched(runs):
    """The walk of a diagnosis up to what is concluded."""
    assert insufficient(runs) is None
    assert skipped(runs) == {}
    bare = as_well_as_read(in_turn(calibrate(runs, Servo()).fit))
    return with_free_law(select_twice(bare, DcServo.listed))


def test_its_concealed_friction_is_named_and_nothing_else():
    found = searched(recordings(1, friction=0.012))
    assert [chosen.effect for chosen in found.chosen] == ['dry_friction']
    assert found.chosen[0].indistinguishable == ()
    muscle = found.final.muscle
    assert muscle['dry_friction.torque'] == pytest.approx(0.012, rel=0.05)
    assert muscle['J'] == pytest.approx(5e-3, rel=0.05)
    assert unexplained(found) is None


def test_a_rival_is_named_where_it_is_the_one():
    found = searched(recordings(2, drag=3e-6))
    assert [chosen.effect for chosen in found.chosen] == ['windage']


@pytest.mark.parametrize('seed', [3, 4])
def test_where_nothing_is_concealed_nothing_is_named(seed):
    found = searched(recordings(seed))
    assert found.chosen == ()
    assert unexplained(found) is None
    muscle = found.final.muscle
    assert {name: muscle[name] for name in 'JRkb'} == pytest.approx(
        {'J': 5e-3, 'R': 2.0, 'k': 0.05, 'b': 1e-4}, rel=0.05
    )

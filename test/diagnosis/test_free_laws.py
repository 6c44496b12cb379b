"""A law without a name: found where no listed effect explains, with its curve; not where one does, nor in a null."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TRUE, experiment

from tcp_muscle_ros.diagnosis.answer import doubtful
from tcp_muscle_ros.diagnosis.answer.doubtful import explained, named_only_if_explained, named_only_if_likely
from tcp_muscle_ros.diagnosis.answer.free_curve import free_law
from tcp_muscle_ros.diagnosis.answer.handed_on import handed_on
from tcp_muscle_ros.diagnosis.answer.notes import on_bent_form, on_doubtful, on_leads
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.fitting.least_squares import fit
from tcp_muscle_ros.diagnosis.search.bending import _no_worse, with_bent_form
from tcp_muscle_ros.diagnosis.search.candidates import Candidate, with_effect
from tcp_muscle_ros.diagnosis.search.elsewhere import as_small_elsewhere
from tcp_muscle_ros.diagnosis.search.free_laws import (
    _knots,
    _known,
    _range,
    _without_traces,
    promising,
    refitted,
    with_free_law,
)
from tcp_muscle_ros.diagnosis.search.rivals import Rival
from tcp_muscle_ros.diagnosis.search.selected import Weighed
from tcp_muscle_ros.diagnosis.search.selection import select
from tcp_muscle_ros.muscle import EFFECTS
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


@pytest.mark.parametrize(('tau', 'stays'), [(0.01, False), (2.0, True)])
def test_an_effect_of_which_a_law_leaves_next_to_nothing_goes(bumpy, tau, stays):
    """It had bent to what the law explains."""
    before = selected(bumpy, [])
    found = with_free_law(before)
    (law,), final = found.chosen, found.final
    problem = with_effect(final.problem, Candidate('thermocouple_lag', {'thermocouple_lag.tau': tau}, 0.0, 0.0))
    both = fit(problem, np.concatenate([final.z, problem.start()[final.z.size :]]), rounds=0)
    lagging = replace(law, effect='thermocouple_lag', rivals=(Rival('thermocouple_lag', both, 0.0),))
    left = _without_traces(replace(found, chosen=(lagging, law), final=both), before)
    assert [c.effect for c in left.chosen] == [*(['thermocouple_lag'] if stays else []), law.effect]
    assert ('thermocouple_lag' in left.final.muscle.effects) is stays


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


def test_a_law_is_begun_on_the_side_to_which_it_goes(bumpy):
    bare = selected(bumpy, []).final
    for law in promising(bare)[:2]:
        better = refitted(bare, law)
        went = np.array([better.values[name, None] for name in law.basis.names])
        assert np.corrcoef(law.values, went)[0, 1] > 0.5
        assert bare.objective - better.objective > 0.5 * law.gain


def test_a_law_has_fewer_knots_than_levels_at_which_its_driver_was_seen(bumpy):
    """Two loads hung: a straight line over the force, whatever a curve might do between them."""
    laws = promising(selected(bumpy, []).final)
    assert {len(law.basis.at) for law in laws if law.basis.driver == 'temperature'} == {4}
    assert {len(law.basis.at) for law in laws if law.basis.driver == 'force'} <= {2}
    assert _range(np.array([0.3, 0.3])) == (0.3, 0.3)
    assert [_knots(np.array(seen), 0.3, 1.5) for seen in ([0.3, 0.9, 1.5], [0.3, 0.7, 1.1, 1.5])] == [2, 3]
    assert _knots(np.array([0.3, 0.41, 1.39, 1.5]), 0.3, 1.5) == 2, 'nothing says where a knot in the middle goes'
    assert _knots(np.array([0.3] * 500 + [0.9] + [1.2] + [1.5] * 500), 0.3, 1.5) == 2, 'those were passed on the way'


def test_a_driver_that_a_law_calls_untried_is_not_tried(monkeypatch):
    """It would be found: a stroke that is there while a current flows."""
    switched = basis('free_stroke', 0.0, 0.3, 'current', 2).on(TRUE, [0.0, -2e-3])
    fitted = under(0.3, switched)
    by_current = [('free_stroke', 'current')]
    assert not [law for law in promising(fitted) if (law.basis.effect, law.basis.driver) in by_current]
    stroke = EFFECTS['free_stroke']
    monkeypatch.setitem(EFFECTS, 'free_stroke', replace(stroke, free=replace(stroke.free, untried=frozenset())))
    assert [law for law in promising(fitted) if (law.basis.effect, law.basis.driver) in by_current]


@pytest.fixture(scope='module')
def warmed():
    """A body in contact takes heat and gives it back: the surroundings warm by up to 5 K, a minute late."""
    return basis('free_surroundings', 296.0, 365.0, 'temperature', 3).on(
        TRUE.replace({'free_surroundings.tau': 60.0}), [0.0, 2.0, 5.0]
    )


@pytest.mark.long
def test_a_law_of_the_state_takes_the_place_of_a_room_that_it_beats(warmed):
    plain = selected(warmed, ['ambient_drift', 'airflow', *LISTED])
    assert [c.definition.circumstance for c in plain.chosen] == [True]
    found = with_free_law(plain)
    assert [(c.effect, c.nearest) for c in found.chosen] == [('free_surroundings', (plain.chosen[0].effect,))]
    assert found.final.muscle['free_surroundings.tau'] == pytest.approx(60.0, rel=0.2)


@pytest.mark.long
def test_a_room_that_drifts_by_itself_keeps_its_name():
    drifts = TRUE.with_effects('ambient_drift').replace({'ambient_drift.a': 2.0, 'ambient_drift.b': 0.5})
    found = selected(drifts, ['ambient_drift', *LISTED])
    assert [c.effect for c in found.chosen] == ['ambient_drift']
    assert with_free_law(found) is found


@pytest.fixture(scope='module')
def bent():
    """Natural convection of a form that is not the listed one: it stalls around 70 degC."""
    listed = TRUE.with_effects('natural_convection').replace({'natural_convection.n': 0.3})
    return basis('free_conductance', 290.0, 365.0, 'temperature', 4).on(listed, [0.0, 0.05, 0.0, -0.1])


def test_a_law_where_the_listed_effect_acts_bends_its_form_and_is_handed_on_not_named(bent):
    plain = selected(bent, ['natural_convection', *LISTED])
    named = with_free_law(plain)
    assert [c.effect for c in named.chosen] == ['natural_convection']
    found = with_bent_form(named)
    assert found.chosen == named.chosen
    assert found.final is named.final
    handed = handed_on(found)[0]
    assert handed.effects == ('natural_convection', 'free_conductance')
    assert on_bent_form(found)[0].startswith('the listed form of natural convection is not quite that of this muscle')
    unseen = experiment(CHANNELS, 0.25, 0.45, 7, muscle=bent)
    misses = [
        float(np.sqrt(np.mean((unseen.observed['temperature'].value - unseen.predict(m)['temperature']) ** 2)))
        for m in (handed_on(named)[0], handed)
    ]
    assert misses[1] < 0.8 * misses[0]


def test_a_form_is_not_bent_where_unseen_data_are_predicted_worse(bent):
    plain = selected(bent, ['natural_convection', *LISTED])
    assert _no_worse(plain, plain.final)
    assert not _no_worse(plain, plain.calibrated)


def under(load, muscle, channels=CHANNELS):
    """A fit to two recordings, the second under this load; the first under 0.588 N."""
    hung = enumerate(((0.27, 0.588), (0.22, load)))
    return in_turn(calibrate([experiment(channels, i, at, k, muscle=muscle) for k, (i, at) in hung], NOMINAL).fit)


@pytest.mark.parametrize('load', [0.588, 0.3])
def test_under_one_load_no_form_is_bent_with_what_only_different_loads_tell(load):
    """A stiffness does there what a stroke does, and unseen data hung there too."""
    form = basis('free_stiffness', 290.0, 365.0, 'temperature', 4).on(TRUE, [0.1, -0.1, 0.1, -0.1])
    fitted = under(load, form)
    plain, told = ({law.basis.effect for law in promising(fitted, told=told)} for told in (False, True))
    assert {'free_stiffness', 'free_stroke'} <= plain
    assert plain - told == ({'free_stiffness'} if load == 0.588 else set())


def test_a_length_drives_a_law_where_it_was_seen_and_under_loads_that_tell_it_from_the_temperature():
    one, two = (under(load, TRUE).problem for load in (0.588, 0.3))
    assert _known(one, 'temperature', any_load=False)
    assert not any(_known(one, driver, any_load=False) for driver in ('length', 'force'))
    assert all(_known(two, driver, any_load=True) for driver in ('temperature', 'length', 'force'))
    unseen = under(0.3, TRUE, CHANNELS[:2]).problem
    assert _known(unseen, 'force', any_load=True), 'it hangs there'
    assert not _known(unseen, 'length', any_load=True)


def test_a_table_that_runs_wild_between_two_loads_is_no_law(bent):
    """Two loads were hung, 0.3 and 0.588 N: what a table has between them, no recording says."""
    plain = selected(bent, ['natural_convection', *LISTED]).final

    def with_table(*values):
        law = basis('free_capacity', 0.3, 0.588, 'force', len(values))
        return replace(plain, problem=replace(plain.problem, parameters=law.on(plain.problem.parameters, values)))

    assert as_small_elsewhere(with_table(0.02, 0.02), plain)
    assert as_small_elsewhere(with_table(0.3, 0.3), plain), 'as large as that in the recordings'
    assert not as_small_elsewhere(with_table(0.0, 2.0, 0.0), plain)


def test_a_listed_form_that_fits_is_not_bent():
    listed = selected(TRUE.with_effects('natural_convection').replace({'natural_convection.n': 0.2}),
                      ['natural_convection'])  # fmt: skip
    assert with_bent_form(listed) is listed


def beside_convection(effect, **values):
    own = {f'{effect}.{name}': value for name, value in values.items()}
    two = TRUE.with_effects('natural_convection', effect).replace({'natural_convection.n': 0.3, **own})
    return selected(two, ['natural_convection', *LISTED, *({effect} - set(LISTED))])


@pytest.mark.long
def test_the_strongest_stays_and_a_weaker_effect_that_is_more_likely_absent_goes():
    found = beside_convection('friction', Ff=0.0025)
    assert len(found.chosen) == 2
    weaker = found.chosen[1].effect
    assert named_only_if_likely(found, lambda _: {weaker: Weighed(weaker, 0.6, {})}) is found
    left = named_only_if_likely(found, lambda _: {weaker: Weighed(weaker, 0.2, {})})
    assert left.chosen == found.chosen[:1]
    assert weaker not in left.final.muscle.effects
    assert [d.effect for d in left.doubtful] == [weaker]
    (said,) = on_doubtful(left)
    assert said.endswith('was found too, but not surely enough (probability 0.20): it is not named')


@pytest.mark.long
def test_a_weaker_effect_without_which_most_is_missed_stays_and_is_judged_by_what_it_then_explains():
    found = beside_convection('friction')
    first, weaker = found.chosen
    found = replace(found, chosen=(first, replace(weaker, drop=60.0)))  # under the noise that it made
    left = named_only_if_likely(found, lambda _: {weaker.effect: Weighed(weaker.effect, 0.01, {})})
    assert [c.effect for c in left.chosen] == [first.effect, weaker.effect]
    assert left.chosen[1].drop == pytest.approx(weaker.drop, rel=0.5)
    assert left.doubtful == ()


@pytest.mark.long
def test_an_end_that_turns_steadily_is_as_doubtful_as_any_other_beside_what_is_there():
    """Sudden slips are seen one by one, and stay; of a steady leak that is an effect like others, they tell nothing."""
    leaks = {'natural_convection.n': 0.3, 'torsional_leakage.r': 4e-4}
    leaking = TRUE.with_effects('natural_convection', 'torsional_leakage').replace(leaks)
    found = selected(leaking, ['natural_convection', 'torsional_leakage'])
    assert {c.effect for c in found.chosen} == {'natural_convection', 'torsional_leakage'}
    found = replace(found, chosen=tuple(sorted(found.chosen, key=lambda c: c.effect == 'torsional_leakage')))
    left = named_only_if_likely(found, lambda _: {'torsional_leakage': Weighed('torsional_leakage', 0.2, {})})
    assert [c.effect for c in left.chosen] == ['natural_convection']


def test_the_best_of_the_listed_effects_has_no_name_where_it_leaves_more_than_it_explains():
    listed = TRUE.with_effects('natural_convection').replace({'natural_convection.n': 0.3})
    found = selected(listed, ['natural_convection'])
    assert named_only_if_explained(found) is found
    poor = replace(found, final=found.calibrated)  # as if it had hardly helped
    left = named_only_if_explained(poor)
    assert left.chosen == ()
    assert left.final.muscle.effects == ()
    assert on_leads(found) == ()
    assert 'natural convection comes nearest to what is unexplained, but leaves more' in on_leads(left)[0]


def test_a_room_of_which_hardly_any_of_the_misfit_is_has_no_name(monkeypatch):
    """A draught has no form, and may leave what other physics does; a trifle of it is what that does to the heat."""
    drifting = TRUE.with_effects('ambient_drift').replace({'ambient_drift.a': 3.0})
    found = selected(drifting, ['ambient_drift'])
    assert [c.effect for c in found.chosen] == ['ambient_drift']
    monkeypatch.setattr(doubtful, 'explained', lambda selection: 0.2)
    assert named_only_if_explained(found) is found
    monkeypatch.setattr(doubtful, 'explained', lambda selection: 0.03)
    left = named_only_if_explained(found)
    assert left.chosen == ()
    assert left.leads == ('ambient_drift',)


def part_of_the_way(found, share):
    """The selection whose model stops on its way from the calibrated one, and so leaves more."""
    (chosen,), begun = found.chosen, found.calibrated.values
    effect = EFFECTS[chosen.effect]
    strength = f'{effect.name}.{effect.strength}'

    def before(unknown, z):
        return (
            unknown.to_fit(effect.none)
            if unknown.name == strength
            else unknown.to_fit(begun.get(unknown.key, unknown.from_fit(z)))
        )

    z = [
        share * z + (1.0 - share) * before(u, z)
        for u, z in zip(found.final.problem.unknowns, found.final.z, strict=True)
    ]
    return replace(found, final=fit(found.final.problem, np.array(z), rounds=0))


@pytest.mark.parametrize(('exponent', 'named'), [(0.3, True), (-0.3, False)])
def test_physics_the_other_way_round_is_named_only_where_it_leaves_no_more_than_its_form_may_miss(exponent, named):
    """It bends to what any law leaves."""
    muscle = TRUE.with_effects('exposed_area').replace({'exposed_area.e': exponent})
    found = selected(muscle, ['exposed_area'])
    assert [c.effect for c in found.chosen] == ['exposed_area']
    assert named_only_if_explained(found) is found, 'it explains all'
    some = part_of_the_way(found, 0.5)
    assert 0.55 < explained(some) < 0.78
    assert [c.effect for c in named_only_if_explained(some).chosen] == ['exposed_area'] * named

"""A law without a name in words: the form that a table was made from, and none where it has no such form."""

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TRUE
from diagnosis.test_free_laws import selected
from diagnosis.written import recorded

from proof.written import ROOM, SPAN, Written, case_of, written
from tcp_muscle_ros.diagnosis.answer.form_words import sentence
from tcp_muscle_ros.diagnosis.answer.free_curve import found_law
from tcp_muscle_ros.diagnosis.answer.in_words import apart, told_by_form
from tcp_muscle_ros.diagnosis.answer.law_forms import FORMS, Table, fitted_form
from tcp_muscle_ros.diagnosis.answer.sentences import free_sentence
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.search.free_laws import with_free_law
from tcp_muscle_ros.diagnosis.search.selection import select
from tcp_muscle_ros.muscle.free_basis import basis

AT = np.linspace(293.15, 363.15, 6)
V = (AT - 293.15) / 70.0
CURVES = {
    'constant': np.full(6, 0.2),
    'linear': 0.3 * V,
    'square': 0.3 * V**2,
    'cube': 0.3 * V**3,
    'power': 0.3 * V**0.5,
    'exponential': 0.3 * np.exp((V - 1.0) / 0.25),
    'saturation': -0.3 * np.exp(-V / 0.25),
    'threshold': 0.6 * np.maximum(V - 0.43, 0.0),
    'until': 0.6 * np.minimum(V, 0.53),
    'step': 0.3 / (1.0 + np.exp(-(V - 0.45) / 0.06)),
}


def table(*curves, relative=True, spread=1e-3, at=AT, origin=293.15):
    values = np.array(curves)
    return Table(at, values, np.eye(values.size) / spread**2, np.zeros(values.size), origin, relative)


def fitted(made):
    """The forms that a table may have, the best first; of those that miss as little the one with fewer numbers."""
    found = [said for form in FORMS if (said := fitted_form(form, made)) is not None]
    return sorted(found, key=lambda said: said.misfit + 2.0 * said.count)


def exact(form, number, relative, scale=1.0):
    """A table that is as near to a form over its range as a spline goes, times a factor."""
    blank = table(np.zeros(6), relative=relative)
    shape = blank.columns(next(f for f in FORMS if f.name == form), number)
    curve = shape @ np.array([0.0, 0.3])[: shape.shape[1]] if shape.shape[1] > 1 else np.full(6, 0.2)
    return table(scale * (1.0 + curve) - 1.0 if relative else curve, relative=relative)


@pytest.mark.parametrize(
    ('form', 'number'),
    [
        *(('constant', 0.0), ('linear', 0.0), ('square', 0.0), ('cube', 0.0), ('power', 0.5), ('exponential', 0.25)),
        *(('saturation', 0.25), ('threshold', 0.43), ('until', 0.53), ('step', 0.45)),
    ],
)
def test_a_table_has_the_form_that_it_was_made_from(form, number):
    """Of what multiplies a parameter, by any factor: that parameter takes it up."""
    for made in (exact(form, number, False), exact(form, number, True), exact(form, number, True, 1.1)):
        best = fitted(made)[0]
        assert best.form.name == form
        assert best.number == pytest.approx(number, abs=0.01)


def test_a_form_goes_on_beyond_the_range_as_it_does_within():
    for form, curve in (('exponential', lambda v: np.exp((v - 1.0) / 0.25)), ('square', lambda v: v**2)):
        made = exact(form, 0.25 if form == 'exponential' else 0.0, relative=False)
        said = next(one for one in fitted(made) if one.form.name == form)
        x = np.array([300.0, 363.15, 375.0])
        assert said.values(made, x)[0] == pytest.approx(0.3 * curve((x - 293.15) / 70.0), rel=1e-3, abs=1e-4)


def test_a_form_has_fewer_numbers_than_its_table_has_knots():
    two = table((0.0, 0.1), at=AT[[0, -1]], relative=False)
    assert [form.name for form in FORMS if fitted_form(form, two) is not None] == ['constant']
    four = table((0.0, 0.1, 0.4, 0.9), at=np.linspace(293.15, 363.15, 4), relative=False)
    threshold = next(form for form in FORMS if form.name == 'threshold')
    assert fitted_form(threshold, four) is not None
    assert fitted_form(threshold, table((0.0, 0.1, 0.4), at=AT[:3])) is None


def test_it_is_said_with_its_place_and_its_slope():
    rising = table(0.031 * np.maximum(AT - 325.15, 0.0))
    said = next(one for one in fitted(rising) if one.form.name == 'threshold')
    assert (
        sentence(said, rising, 'free_conductance', 'temperature')
        == 'As far as these recordings tell, the conductance rises above 52 degC, by 3.1 % per K.'
    )
    span = 'from 20 degC to 90 degC.'
    for curve, end in (
        ('linear', 'capacity rises evenly with the temperature, by 0.43 % per K.'),
        ('square', 'capacity rises as the square of the temperature above 20 degC, by 30 % ' + span),
        ('until', 'capacity rises up to 57 degC, by 0.85 % per K, and stays there.'),
    ):  # fmt: skip
        made = table(CURVES[curve])
        form = next(one for one in fitted(made) if one.form.name == curve)
        said = sentence(form, made, 'free_capacity', 'temperature')
        assert said == f'As far as these recordings tell, the {end}'


def test_heating_and_cooling_share_a_form():
    at = np.linspace(293.15, 363.15, 4)
    both = table(-1e-5 * (at - 293.15), -2e-5 * (at - 293.15), at=at, relative=False, spread=1e-6)
    said = fitted(both)[0]
    assert sentence(said, both, 'free_stroke', 'temperature') == (
        'As far as these recordings tell, the length falls evenly with the temperature, by 0.01 mm per K while it '
        'heats; falls evenly with the temperature, by 0.02 mm per K while it cools.'
    )


def test_what_lengthens_is_no_stroke_that_rises():
    at = np.linspace(293.15, 363.15, 4)
    longer = table(1e-5 * (at - 293.15), at=at, relative=False, spread=1e-6)
    for effect, noun in (('free_stroke', 'length'), ('free_slow_state', 'slow part of the length')):
        said = sentence(fitted(longer)[0], longer, effect, 'temperature')
        assert (
            said == f'As far as these recordings tell, the {noun} rises evenly with the temperature, by 0.01 mm per K.'
        )


def test_forms_that_predict_as_well_are_said_with_where_a_measurement_would_decide():
    vague = table(CURVES['square'], relative=False)
    square, other = (next(one for one in fitted(vague) if one.form.name == name) for name in ('square', 'exponential'))
    where, gap = apart(square, other, vague)
    assert where == pytest.approx(363.15 + 0.2 * 70.0)
    values = [one.values(vague, np.array([where]))[0, 0] for one in (square, other)]
    assert gap == pytest.approx(abs(values[1] - values[0]))
    also = sentence(square, vague, 'free_surroundings', 'temperature', (other,))
    assert also.endswith(
        '. An exponential predicts unseen data as well over the range seen; a measurement at 104 degC would decide, '
        f'where they differ by {gap:.2g} K.'
    )


def made_by(rise):
    """What is found of a muscle whose conductance rises so over the temperature."""
    at = np.linspace(290.0, 365.0, 8)
    found = with_free_law(selected(basis('free_conductance', 290.0, 365.0, 'temperature', 8).on(TRUE, rise(at))))
    (law,) = [c for c in found.chosen if c.effect == 'free_conductance']
    return found_law(found, law)


@pytest.mark.long
def test_a_law_of_a_form_is_said_in_words_and_how_far_the_catalogue_is():
    law = made_by(lambda at: 0.6 * ((at - 296.15) / 67.0) ** 2)
    assert law.in_words.form == 'square'
    assert law.in_words.value == pytest.approx(law.value, abs=0.01)
    assert law.nearest == 'heat_capacity'
    assert 0.0 < law.nearest_share < 0.5
    said = free_sentence('free_conductance', law)
    assert 'the conductance rises as the square of the temperature above 23 degC, by 2' in said
    assert said.endswith(f'The nearest listed law, heat capacity, explains {100 * law.nearest_share:.0f} % of it.')


@pytest.mark.long
def test_a_law_of_no_form_is_a_curve_and_no_words():
    law = made_by(lambda at: 0.25 * np.exp(-(((at - 328.0) / 14.0) ** 2)))
    assert law.in_words is None
    assert 'rises' not in free_sentence('free_conductance', law)


@pytest.mark.slow
@pytest.mark.parametrize(
    ('form', 'table', 'seed', 'said'),
    [
        ('square', 'soft', 1, ('square', 'power')),
        ('threshold', 'loss', 1, ('threshold',)),
        pytest.param('threshold', 'capacity', 2, ('threshold',), marks=pytest.mark.long),
        pytest.param('exponential', 'soft', 1, ('exponential',), marks=pytest.mark.long),
        pytest.param('saturation', 'capacity', 1, ('saturation',), marks=pytest.mark.long),
    ],
)
def test_a_law_that_was_written_elsewhere_is_said_in_its_form(tmp_path, form, table, seed, said):
    """Of muscles that the truth generator integrates."""
    law = written(form, table, np.random.default_rng(seed))
    found = with_free_law(select(in_turn(calibrate(recorded(case_of(law, seed), tmp_path), NOMINAL).fit), ['friction']))
    (effect,) = [c.effect for c in found.chosen if c.effect.startswith('free_')]
    told = told_by_form(found, effect)
    assert told.said.form.name in said
    if form == 'threshold':
        place = told.table.origin + told.said.number * told.table.span
        assert place == pytest.approx(273.15 + ROOM + SPAN * law.number, abs=2.0)


@pytest.mark.slow
def test_a_stroke_that_is_a_product_of_load_and_temperature_is_a_stiffness_over_temperature(tmp_path):
    """What multiplies what its stage already depends on is a product of two: here the elongation, F/k."""
    case = case_of(Written('linear', 'free', 0.0, 0.25, by_load=True), 3)
    found = with_free_law(select(in_turn(calibrate(recorded(case, tmp_path), NOMINAL).fit), ['friction']))
    (effect,) = [c.effect for c in found.chosen]
    assert effect == 'free_stiffness'
    assert found.final.mean_square['displacement'] < 1e-3 * found.calibrated.mean_square['displacement']
    told = told_by_form(found, effect)
    said = sentence(told.said, told.table, effect, 'temperature', told.others)
    assert said.startswith('As far as these recordings tell, the stiffness rises')

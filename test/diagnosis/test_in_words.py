"""A law without a name in words: the form that a table was made from, and none where it has no such form."""

import numpy as np
import pytest
from diagnosis.made import TRUE
from diagnosis.test_free_laws import selected

from tcp_muscle_ros.diagnosis.answer.form_words import sentence
from tcp_muscle_ros.diagnosis.answer.free_curve import found_law
from tcp_muscle_ros.diagnosis.answer.in_words import FORMS, Table, alike, fitted_form, sparsest
from tcp_muscle_ros.diagnosis.answer.sentences import free_sentence
from tcp_muscle_ros.diagnosis.search.free_laws import with_free_law
from tcp_muscle_ros.muscle.free_basis import basis
from tcp_muscle_ros.settings.policy import shipped

AT = np.linspace(293.15, 363.15, 6)
V = (AT - 293.15) / 70.0
CURVES = {
    'constant': np.full(6, 0.2),
    'linear': 0.3 * V,
    'square': 0.3 * V**2,
    'power': 0.3 * V**0.5,
    'exponential': 0.3 * np.exp((V - 1.0) / 0.25),
    'saturation': -0.3 * np.exp(-V / 0.25),
    'threshold': 0.6 * np.maximum(V - 0.43, 0.0),
    'until': 0.6 * np.minimum(V, 0.53),
    'step': 0.3 / (1.0 + np.exp(-(V - 0.45) / 0.06)),
}


def table(*curves, relative=True, spread=1e-3, at=AT, origin=293.15):
    values = np.array(curves)
    return Table(at, values, spread**2 * np.eye(values.size), tuple(range(values.size)), origin, relative)


@pytest.mark.parametrize('form', CURVES)
def test_a_table_has_the_form_that_it_was_made_from(form):
    """Of what multiplies a parameter, by any factor: that parameter takes it up."""
    curve = CURVES[form]
    assert sparsest(table(curve, relative=False), shipped()).form.name == form
    assert sparsest(table(curve), shipped()).form.name == form
    assert sparsest(table(1.1 * (1.0 + curve) - 1.0), shipped()).form.name == form


def test_every_form_has_a_case_here():
    assert set(CURVES) == {form.name for form in FORMS}


def test_a_form_has_fewer_numbers_than_its_table_has_knots():
    two = table((0.0, 0.1), at=AT[[0, -1]], relative=False)
    assert [form.name for form in FORMS if fitted_form(form, two) is not None] == ['constant']
    four = table((0.0, 0.1, 0.4, 0.9), at=np.linspace(293.15, 363.15, 4), relative=False)
    threshold = next(form for form in FORMS if form.name == 'threshold')
    assert fitted_form(threshold, four) is not None
    assert fitted_form(threshold, table((0.0, 0.1, 0.4), at=AT[:3])) is None


def test_it_is_said_with_its_place_and_its_slope():
    rising = table(0.031 * np.maximum(AT - 325.15, 0.0))
    said = sparsest(rising, shipped())
    assert (
        sentence(said, rising, 'free_conductance', 'temperature')
        == 'As far as these recordings tell, the conductance rises above 52 degC, by 3.1 % per K.'
    )
    span = 'from 20 degC to 90 degC.'
    for curve, end in (
        ('linear', 'capacity rises evenly with the temperature, by 0.43 % per K.'),
        ('square', 'capacity rises as the square of the temperature above 20 degC, by 30 % ' + span),
        ('until', 'capacity rises up to 57 degC, by 0.86 % per K, and stays there.'),
    ):  # fmt: skip
        made = table(CURVES[curve])
        said = sentence(sparsest(made, shipped()), made, 'free_capacity', 'temperature')
        assert said == f'As far as these recordings tell, the {end}'


def test_heating_and_cooling_share_a_form():
    at = np.linspace(293.15, 363.15, 4)
    both = table(-1e-5 * (at - 293.15), -2e-5 * (at - 293.15), at=at, relative=False, spread=1e-6)
    said = sparsest(both, shipped())
    assert sentence(said, both, 'free_stroke', 'temperature') == (
        'As far as these recordings tell, the stroke falls evenly with the temperature, by 0.01 mm per K while it '
        'heats; falls evenly with the temperature, by 0.02 mm per K while it cools.'
    )


def test_what_the_table_does_not_tell_apart_is_said():
    vague = table(CURVES['square'], spread=0.03)
    said = sparsest(vague, shipped())
    others = alike(said, vague, shipped())
    assert 'square' in (said.form.name, *others)
    also = sentence(said, vague, 'free_conductance', 'temperature', ('power', 'step'))
    assert also.endswith('. A power or a step fits its table as well.')


def made_by(rise):
    """What is found of a muscle whose conductance rises so over the temperature."""
    at = np.linspace(290.0, 365.0, 8)
    found = with_free_law(selected(basis('free_conductance', 290.0, 365.0, 'temperature', 8).on(TRUE, rise(at))))
    (law,) = [c for c in found.chosen if c.effect == 'free_conductance']
    return found_law(found, law)


def test_a_law_of_a_form_is_said_in_words_and_how_far_the_catalogue_is():
    law = made_by(lambda at: 0.6 * ((at - 296.15) / 67.0) ** 2)
    assert law.in_words.form == 'square'
    assert law.in_words.value == pytest.approx(law.value, abs=0.01)
    assert law.nearest == 'heat_capacity'
    assert 0.0 < law.nearest_share < 0.5
    said = free_sentence('free_conductance', law)
    assert 'the conductance rises as the square of the temperature above 23 degC, by 2' in said
    assert said.endswith(f'The nearest listed law, heat capacity, explains {100 * law.nearest_share:.0f} % of it.')


def test_a_law_of_no_form_is_a_curve_and_no_words():
    law = made_by(lambda at: 0.25 * np.exp(-(((at - 328.0) / 14.0) ** 2)))
    assert law.in_words is None
    assert 'rises' not in free_sentence('free_conductance', law)

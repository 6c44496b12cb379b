"""Parameters: the paper's Table 1 as printed, the shipped sets, and mistakes refused with the nearest name."""

import pickle

import numpy as np
import pytest

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import EFFECTS, SETS, SPECIFICATIONS, TABLE, ZERO_CELSIUS, Parameters
from tcp_muscle_ros.muscle.table import INDEX

A = Parameters.named('karami_tadesse_2017')

# Karami & Tadesse 2017, Table 1 and equations 26 and 27, copied from the page (in SI; T0 in degC).
PRINTED = {
    'L0': 0.500,
    'H0': 0.150,
    'D0': 0.75e-3,
    'cp': 1700.0,
    'm': 0.1e-3,
    'k0': 23.0,
    'R0': 14.0,
    'T0': 23.0,
    'a_R': 0.003,
    'c1': -3.50e-6,
    'c2': 4.20e-4,
    'a1': -0.4655e6,
    'a2': 1.381,
    'a3': 536e6,
}


def refused(call):
    with pytest.raises(BadInput) as caught:
        call()
    message = str(caught.value)
    assert message and '\n' not in message
    return message


def test_the_paper_row_by_row():
    assert {row.name: row.edge_value for row in TABLE if row.name in PRINTED} == PRINTED


def test_beside_the_paper_only_the_identified_and_the_derived():
    assert {row.name for row in TABLE} - set(PRINTED) == {'hA', 'C', 'B'}


def test_derived_values_follow_their_sources_until_given():
    assert A['C'] == 1e-4 * 1700.0
    assert A['B'] == 0.5**2 / 0.15
    assert A.replace(m=1.6e-4)['C'] == 1.6e-4 * 1700.0
    assert A.replace(H0=0.2)['B'] == 0.5**2 / 0.2
    given = A.replace(C=0.2, B=1.0, m=5e-4, H0=0.2)
    assert (given['C'], given['B']) == (0.2, 1.0)
    assert given.replace(C=0.0)['C'] == pytest.approx(5e-4 * 1700.0)


def test_the_shipped_sets():
    of_the_paper = {'karami_tadesse_2017', 'karami_tadesse_2017_as_printed', 'karami_tadesse_2017_set_b'}
    assert set(SETS) == of_the_paper | {'sun_zhao_2021', 'mcginty_iron_wire'}
    printed = Parameters.named('karami_tadesse_2017_as_printed')
    assert printed['hA'] == 0.15
    # Equations 16 to 18 as they stand: -(L0^2 - pi D0^2)/H0.
    assert printed['B'] == pytest.approx(-(0.25 - np.pi * 0.75e-3**2) / 0.15, rel=1e-15)
    b = Parameters.named('karami_tadesse_2017_set_b')
    assert (b['hA'], b['C']) == (0.015, pytest.approx(0.272, rel=1e-15))
    for name in PRINTED.keys() - {'m'}:
        assert printed[name] == b[name] == A[name]


@pytest.mark.parametrize('row', SPECIFICATIONS.values(), ids=list(SPECIFICATIONS))
def test_every_parameter_says_what_it_is_and_lies_within_its_bounds(row):
    assert row.unit and row.meaning and row.source
    assert row.low < row.high
    assert row.low <= row.value <= row.high or (row.name in ('C', 'B') and row.value == 0.0)
    assert row.from_edge(row.to_edge(row.value)) == pytest.approx(row.value, rel=1e-15)


def test_temperatures_are_kelvin_inside_and_degc_at_the_edge():
    row = SPECIFICATIONS['T0']
    assert (row.unit, row.edge_unit) == ('K', 'degC')
    assert (row.value, row.edge_value) == (296.15, 23.0)
    assert (row.edge_low, row.edge_high) == (-23.15, 76.85)
    assert row.from_edge(25.0) == 25.0 + ZERO_CELSIUS
    assert not SPECIFICATIONS['a_R'].absolute  # 1/K is a difference


def test_it_is_a_mapping_of_every_parameter():
    assert set(A) == set(SPECIFICATIONS) and len(A) == len(SPECIFICATIONS)
    for effect in EFFECTS.values():
        for row in effect.parameters:
            assert A[f'{effect.name}.{row.name}'] == row.value
    assert 'hA' in A and 'creep.J' in A and 'Creep.J' not in A


def test_changing_makes_a_new_one():
    changed = A.replace({'creep.J': 0.05}, hA=0.02).with_effects('creep')
    assert (A['hA'], A.effects) == (0.01933, ())
    assert (changed['hA'], changed['creep.J'], changed.effects) == (0.02, 0.05, ('creep',))
    assert changed.only_effects().effects == ()
    assert SETS['karami_tadesse_2017'] == {}
    with pytest.raises(ValueError):
        A.vector[0] = 1.0
    with pytest.raises(AttributeError):
        A.effects = ('creep',)


def test_the_order_in_which_effects_are_named_does_not_matter():
    names = list(EFFECTS)
    assert A.with_effects(*names) == A.with_effects(*reversed(names), names[0])
    assert hash(A.with_effects(*names)) == hash(A.with_effects(*reversed(names)))
    assert A.with_effects(*names).mask.all() and not A.mask.any()


def test_it_travels_between_processes():
    changed = A.replace(hA=0.02).with_effects('creep')
    copy = pickle.loads(pickle.dumps(changed))
    assert copy == changed
    np.testing.assert_array_equal(copy.vector, changed.vector)


@pytest.mark.parametrize(
    ('call', 'message'),
    [
        (lambda: A.replace(ha=0.02), "unknown parameter 'ha'; did you mean 'hA'?"),
        (lambda: A.replace({'crep.J': 0.1}), "unknown parameter 'crep.J'; did you mean 'creep.J'?"),
        (lambda: A['k_0'], "unknown parameter 'k_0'; did you mean 'k0'?"),
        (lambda: A['ko'], "unknown parameter 'ko'; did you mean 'k0'?"),
        (lambda: A.replace(hA=-0.01), "parameter 'hA' = -0.01 W/K is outside 1e-05 to 10 W/K"),
        (lambda: A.replace(hA=0.0), "parameter 'hA' = 0 W/K is outside 1e-05 to 10 W/K"),
        (lambda: A.replace(T0=23.0), "parameter 'T0' = -250.15 degC is outside -23.15 to 76.85 degC"),
        (lambda: A.replace(R0=float('nan')), "parameter 'R0' = nan ohm is outside 0.001 to 100000 ohm"),
        (lambda: A.replace(R0=float('inf')), "parameter 'R0' = inf ohm is outside 0.001 to 100000 ohm"),
        (lambda: A.replace(R0='14'), "parameter 'R0' = '14': expected a number in ohm"),
        (lambda: A.with_effects('crep'), "unknown effect 'crep'; did you mean 'creep'?"),
        (lambda: A.only_effects(['Creep']), "unknown effect 'Creep'; did you mean 'creep'?"),
        (
            lambda: Parameters.named('karami_tadese_2017'),
            "unknown parameter set 'karami_tadese_2017'; did you mean 'karami_tadesse_2017'?",
        ),
    ],
)
def test_a_mistake_is_named_with_the_nearest_choice(call, message):
    assert refused(call) == message


@pytest.mark.parametrize('value', [np.float64(0.02), np.float32(0.02), 1, np.int64(1)])
def test_numbers_of_every_make_are_taken(value):
    assert A.replace(hA=value)['hA'] == value


def test_what_is_done_to_the_dict_that_was_given_is_not_done_to_the_parameters():
    given = {'hA': 0.02}
    made = Parameters(given)
    given['hA'] = 0.03
    assert made['hA'] == 0.02 and made.vector[INDEX['hA']] == 0.02
    Parameters.named('karami_tadesse_2017_set_b').given['hA'] = 0.03
    assert SETS['karami_tadesse_2017_set_b']['hA'] == 0.015
    assert pickle.loads(pickle.dumps(made)) == made

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.recording import CHANNELS
from tcp_muscle_ros.recording.units import UNITS, unit_of


@pytest.mark.parametrize(
    ('unit', 'x', 'si'),
    [
        ('degC', 0.0, 273.15),
        ('degF', 212.0, 373.15),
        ('degF', -40.0, 233.15),
        ('g', 1000.0, 9.80665),
        ('lbf', 1.0, 4.4482216152605),
        ('mm', 25.4, 0.0254),
        ('in', 1.0, 0.0254),
        ('mA', 270.0, 0.27),
        ('kohm', 1.5, 1500.0),
        ('min', 2.0, 120.0),
    ],
)
def test_known_values(unit, x, si):
    assert UNITS[unit].to_si(x) == pytest.approx(si, rel=1e-12)


@given(st.sampled_from(sorted(UNITS)), st.floats(-1e6, 1e6))
def test_there_and_back(name, x):
    unit = UNITS[name]
    assert unit.from_si(unit.to_si(x)) == pytest.approx(x, rel=1e-9, abs=1e-6)


def test_arrays_are_converted_as_numbers_are():
    x = np.array([0.0, 100.0])
    assert UNITS['degC'].to_si(x).tolist() == [273.15, 373.15]


def test_every_channel_has_a_unit_of_the_table():
    assert all(kind.unit in UNITS for kind in CHANNELS.values())


def test_an_unknown_unit_names_the_nearest_of_its_quantity():
    with pytest.raises(BadInput, match=r"^--unit temperature: unknown unit 'celsius'; known: K, degC, degF$"):
        unit_of('celsius', 'temperature', '--unit temperature')
    with pytest.raises(BadInput, match="unknown unit 'mmm'; did you mean 'mm'"):
        unit_of('mmm', 'length', 'here')


def test_a_unit_of_another_quantity_is_refused():
    with pytest.raises(BadInput, match=r"'degC' is a unit of temperature, expected one of length: .*mm"):
        unit_of('degC', 'length', '--unit displacement')

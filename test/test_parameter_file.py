"""Parameter files: made from the table, read back as written."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import EFFECTS, SETS, TABLE, Parameters
from tcp_muscle_ros.settings.operating import OPERATING
from tcp_muscle_ros.settings.parameter_file import from_names, number_text, read, render, write

ROOT = Path(__file__).resolve().parent.parent


def maker():
    spec = importlib.util.spec_from_file_location('make_config', ROOT / 'scripts' / 'make_config.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_files_of_config_are_what_the_table_makes():
    for path, text in maker().files().items():
        assert path.read_text() == text, f'{path.name} has drifted: run scripts/make_config.py'


@pytest.mark.parametrize('name', SETS)
def test_a_shipped_file_is_its_set(name):
    found = read(ROOT / 'config' / f'{name}.yaml')
    assert np.array_equal(found.parameters.vector, Parameters.named(name).vector)
    assert found.parameters.effects == ()


def test_table_1_comes_first_and_row_by_row():
    lines = (ROOT / 'config' / 'karami_tadesse_2017.yaml').read_text().splitlines()
    names = [line.split(':')[0].strip() for line in lines if line.startswith('    ')][1:]
    assert names == [row.name for row in TABLE]
    assert names[:9] == ['L0', 'H0', 'D0', 'cp', 'm', 'k0', 'R0', 'T0', 'a_R']


def test_any_muscle_reads_back_bit_for_bit(tmp_path):
    muscle = (
        Parameters.named('karami_tadesse_2017_set_b').with_effects(*EFFECTS).replace({'hA': 1 / 57, 'creep.J': 1e-7})
    )
    (tmp_path / 'm.yaml').write_text(
        render(muscle, operating={'load_n': 0.25, 'end': 'spring', 'start_enabled': False})
    )
    found = read(tmp_path / 'm.yaml')
    assert found.parameters.effects == muscle.effects
    # Kelvin to degC and back may cost the last bit of an absolute temperature.
    assert np.allclose(found.parameters.vector, muscle.vector, rtol=1e-12, atol=0.0)
    assert found.operating == {'load_n': 0.25, 'end': 'spring', 'start_enabled': False}


@pytest.mark.parametrize('all_of_them', ['', '/**: {ros__parameters: {k0: 20.0}}\n'])
def test_two_muscles_are_not_read_as_one(tmp_path, all_of_them):
    file = tmp_path / 'two.yaml'
    thumb, index = (
        f'/{name}/sim_node: {{ros__parameters: {{k0: {k0}}}}}\n' for name, k0 in (('thumb', 23.0), ('index', 60.0))
    )
    file.write_text(thumb + all_of_them + index)
    with pytest.raises(BadInput) as caught:
        read(file)
    assert str(caught.value) == (
        f"{file}: parameter 'k0' = 23.0 below '/thumb/sim_node' and 60.0 below '/index/sim_node': expected the "
        "parameters of one muscle; make a file of each muscle's"
    )


@pytest.mark.parametrize(
    ('first', 'second'),
    [
        ('/**: {ros__parameters: {k0: 23.0}}', 'sim_node: {ros__parameters: {k0: 60.0}}'),  # of all, and of one
        ('sim_node: {ros__parameters: {k0: 6e1}}', 'safety_node: {ros__parameters: {k0: 60}}'),
        ('sim_node: {ros__parameters: {rate_hz: 100.0}}', 'safety_node: {ros__parameters: {rate_hz: 50.0, k0: 60}}'),
    ],
)
def test_sections_of_one_muscle_are_read_together(tmp_path, first, second):
    (tmp_path / 'm.yaml').write_text(f'{first}\n{second}\n')
    assert read(tmp_path / 'm.yaml').parameters['k0'] == 60.0


def test_effects_may_be_nested_and_words_of_YAML_are_numbers(tmp_path):
    (tmp_path / 'm.yaml').write_text(
        '/**:\n  ros__parameters:\n    effects: [creep]\n    creep: {J: 2e-1}\n    m: 1e-4\n'
    )
    found = read(tmp_path / 'm.yaml').parameters
    assert found['creep.J'] == 0.2
    assert found['C'] == pytest.approx(0.17)


NUMBERS = [row for row in OPERATING.values() if type(row.default) in (int, float)]


@pytest.mark.parametrize('row', NUMBERS, ids=lambda row: row.name)
def test_an_operating_parameter_has_the_bounds_of_the_nodes(row):
    kind = type(row.default)
    for value in (kind(row.low), kind(row.high), str(float(row.high))):
        assert from_names({row.name: value}).operating == {row.name: kind(float(value))}
    for value in (kind(row.low - 1), kind(2 * row.high), np.nan, 'warm', True, None):
        with pytest.raises(BadInput) as caught:
            from_names({row.name: value})
        assert str(caught.value).startswith(f"parameter '{row.name}' is ")
        assert f'{row.low:g} to {row.high:g}' in str(caught.value)


NASTY = [
    '', ' ', '7', '0x10', '1e-4', '.5', '1_000', '12:30', '2026-01-02', 'on', 'No', 'y', 'N', 'null', '~', 'TRUE',
    'nan', 'inf', '.inf', 'a: b', 'a:', '/dev/tty #1', '# a', '- a', '[a', '{a}', '&a', '*a', '!a', '%a', '@a', '`a',
    '| a', '> a', '? a', "it's", 'say "so"', '\\', 'C:\\new', ' ahead', 'behind ', 'two\nlines', 'tab\there',
    '/data/jürgen/筋 💪.yaml', '\x07', '\x7f', '\x85', '\u2028', '\ufeff', '---', '...', '=', '<<', 'long ' * 60,
    '/dev/ttyACM0', 'thumb',
]  # fmt: skip
TEXTS = [row for row in OPERATING.values() if isinstance(row.default, str)]


@pytest.mark.parametrize('row', TEXTS, ids=lambda row: row.name)
def test_a_text_reads_back_as_it_was(tmp_path, row):
    for value in row.choices or NASTY:
        write(
            tmp_path / 'm.yaml',
            Parameters.named('karami_tadesse_2017'),
            names=[],
            operating={row.name: value, 'load_n': 0.5},
        )
        assert read(tmp_path / 'm.yaml').operating == {row.name: value, 'load_n': 0.5}


def test_a_plain_word_stands_bare():
    assert '\n    end: spring\n' in render(Parameters.named('karami_tadesse_2017'), operating={'end': 'spring'})


@pytest.mark.parametrize('value', [1.0, 1e-7, 1e22, 0.1, -3.5e-6, 0.0])
def test_a_number_is_a_float_to_ROS_and_to_YAML(value):
    text = number_text(value)
    assert '.' in text
    assert float(text) == value

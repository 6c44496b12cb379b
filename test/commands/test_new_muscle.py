"""``tcp_muscle new-muscle``."""

import io

import pytest

from tcp_muscle_ros.muscle.geometry import Coil, estimates
from tcp_muscle_ros.settings.parameter_file import read
from tcp_muscle_ros.tool import main

PAPER = {
    'fibre-diameter-mm': '0.2',
    'fibre-length-mm': '500',
    'coil-length-mm': '150',
    'turns': '280',
    'resistance-ohm': '14',
}


def options(**changed):
    given = PAPER | {name.replace('_', '-'): value for name, value in changed.items()}
    return [part for name, value in given.items() for part in (f'--{name}', value)]


def test_it_writes_what_the_geometry_says_and_the_tools_read_it(tmp_path, capsys):
    path = tmp_path / 'mine.yaml'
    assert main(['new-muscle', *options(), '--output', str(path)]) == 0
    assert 'stiffness by geometry 0.801 N/m, likely up to 23.2 N/m' in capsys.readouterr().out
    muscle = read(path).parameters
    for name, estimate in estimates(Coil(0.2e-3, 0.5, 0.15, 280, 14.0)).items():
        assert muscle[name] == pytest.approx(estimate.value, rel=1e-12)
    text = path.read_text()
    assert '29 times too small' in text
    assert '0.801 to 23.2; G d^4/(8 D^3 N)' in text
    (heat,) = (line for line in text.splitlines() if line.strip().startswith('C: '))
    assert heat.strip().startswith('C: 0.0 '), 'follows a mass that is weighed later'
    assert heat.endswith('# J/K; 0 = 0.0304; 0.0158 to 0.17; m cp, with the cp of the paper')


def test_it_asks_for_what_no_option_says(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr('sys.stdin', io.StringIO('0.2\n500\n150\n280\n14\n'))
    asked, told = tmp_path / 'asked.yaml', tmp_path / 'told.yaml'
    assert main(['new-muscle', '--output', str(asked)]) == 0
    assert 'Diameter of the fibre, mm: ' in capsys.readouterr().out
    assert main(['new-muscle', *options(), '--output', str(told)]) == 0
    assert asked.read_text() == told.read_text()


@pytest.mark.parametrize(
    ('given', 'said'),
    [
        (options(turns='many'), "--turns 'many': expected a number, from 1 to 100000"),
        (options(coil_length_mm='600'), 'coil length 600 mm: expected less than the fibre length, 500 mm'),
        (options(turns='1e-308'), "--turns '1e-308': expected a number, from 1 to 100000"),
        (options(fibre_diameter_mm='0.0002'), "--fibre-diameter-mm '0.0002': expected a number in mm, from 0.01 to 10"),
        (options(fibre_length_mm='0.5'), "--fibre-length-mm '0.5': expected a number in mm, from 5 to 50000"),
        (options(resistance_ohm='14000'), "--resistance-ohm '14000': expected a number in ohm, from 0.01 to 5000"),
        (options(mass_g='-1'), "--mass-g '-1': expected a number in g, from 0.001 to 1000"),
        (options()[2:], '--fibre-diameter-mm is missing (diameter of the fibre), and nobody answers'),
    ],
)
def test_what_is_wrong_is_one_line(given, said, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr('sys.stdin', io.StringIO(''))
    path = tmp_path / 'mine.yaml'
    assert main(['new-muscle', *given, '--output', str(path)]) == 2
    errors = capsys.readouterr().err
    assert said in errors and len(errors.strip().splitlines()) == 1
    assert not path.exists()


def test_an_answer_that_is_not_text_is_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr('sys.stdin', io.TextIOWrapper(io.BytesIO(b'0.2\n\xd50\n'), encoding='utf-8'))
    assert main(['new-muscle', '--output', str(tmp_path / 'mine.yaml')]) == 2
    assert 'is not text' in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_what_is_there_stays_without_force(tmp_path, capsys):
    path = tmp_path / 'mine.yaml'
    path.write_text('mine')
    assert main(['new-muscle', *options(), '--output', str(path)]) == 2
    assert path.read_text() == 'mine'
    assert main(['new-muscle', *options(), '--output', str(path), '--force']) == 0
    assert read(path).parameters['R0'] == 14.0

"""improved.yaml gives the report's own numbers when it is replayed on the diagnosed bags."""

import json
import re
from contextlib import redirect_stdout
from io import StringIO

import numpy as np
import pytest
from commands import faulty_bags as bags

from tcp_muscle_ros.report.words import error_text
from tcp_muscle_ros.settings.parameter_file import read
from tcp_muscle_ros.tool import main


@pytest.fixture(scope='module')
def diagnosed(tmp_path_factory):
    """Three bags at three loads in a room of 24 degC, which the nominal parameters do not say; short enough that no
    samples are averaged, whose error would be less than that of each."""
    folder = tmp_path_factory.mktemp('replay')
    paths = [
        str(bags.write_bag(folder / f'bag_{k}', *bags.sound(load, on=(3,)))) for k, load in enumerate((0.3, 0.6, 1.0))
    ]
    said = StringIO()
    with redirect_stdout(said):
        assert main(['diagnose', *paths, '--output', str(folder / 'report')]) == 0
    (folder / 'said.txt').write_text(said.getvalue())
    return paths, folder / 'report' / 'improved.yaml', json.loads((folder / 'report' / 'report.json').read_text())


def replayed(path, params, capsys):
    """RMSE and number of samples by channel, from the table that ``tcp_muscle replay`` prints (SI)."""
    capsys.readouterr()
    assert main(['replay', path, '--params', str(params)]) == 0
    found = {}
    for line in capsys.readouterr().out.splitlines():
        row = re.match(r'(temperature|resistance|displacement) +(\d+) +(\S+) (K|ohm|mm)', line)
        if row:
            found[row[1]] = float(row[3]) * (1e-3 if row[4] == 'mm' else 1.0), int(row[2])
    return found


@pytest.mark.slow
@pytest.mark.parametrize('model', ['improved', 'nominal'])
def test_a_replay_gives_the_numbers_of_the_report(diagnosed, capsys, model):
    paths, improved, report = diagnosed
    params = improved if model == 'improved' else 'karami_tadesse_2017'
    tables = [replayed(path, params, capsys) for path in paths]
    for name, fit in report['fit'].items():
        rmse, count = np.array([table[name] for table in tables]).T
        assert np.sqrt(np.average(rmse**2, weights=count)) == pytest.approx(fit[f'rmse_{model}'], rel=2e-3)


@pytest.mark.slow
def test_the_terminal_shows_the_numbers_of_the_report(diagnosed):
    _, improved, report = diagnosed
    told = (improved.parents[1] / 'said.txt').read_text()
    for name, fit in report['fit'].items():
        errors = (fit['rmse_nominal'], fit['rmse_calibrated'], fit['rmse_improved'], fit['noise'])
        lines = [line for line in told.splitlines() if line.startswith(f'{name} ')]
        assert any(all(error_text(name, error) in line for error in errors) for line in lines), name


@pytest.mark.slow
def test_without_faults_of_sensors_that_is_the_error_on_unseen_data(diagnosed):
    _, _, report = diagnosed
    assert report['findings'] == []
    for name, fit in report['fit'].items():
        assert fit['rmse_improved'] == pytest.approx(fit['held_out']['rmse_with'], rel=0.15), name
        assert fit['rmse_improved'] < 0.2 * fit['rmse_nominal']


@pytest.mark.slow
def test_the_room_of_the_recordings_goes_into_the_improved_file(diagnosed):
    _, params, report = diagnosed
    rooms = [report['calibration'][name]['value'] for name in report['sensors'] if name.startswith('ambient')]
    assert read(params).operating['ambient_temperature_c'] == pytest.approx(np.median(rooms), abs=1e-6)
    assert len(rooms) == 3

"""``import tcp_muscle_ros as tcp``: the five functions, with DataFrames in and out."""

import doctest
import importlib.util
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import tcp_muscle_ros as tcp
from tcp_muscle_ros import interface
from tcp_muscle_ros.commands.progress import Progress
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.settings.parameter_file import read, write

ROOT = Path(__file__).resolve().parents[2]
PROTOCOL = {
    'rate_hz': 5,
    'input': 'current',
    'repeat': 2,
    'segments': [{'duration_s': 10, 'value': 0}, {'duration_s': 60, 'value': 0.25}, {'duration_s': 60, 'value': 0}],
}


@pytest.fixture(scope='module')
def muscle(tmp_path_factory):
    """A muscle that cools better the hotter it is, with sensor noise, as a parameter file."""
    path = tmp_path_factory.mktemp('muscle') / 'concealed.yaml'
    parameters = Parameters({'natural_convection.n': 0.35}, ('natural_convection',))
    noise = {'temperature_noise_k': 0.05, 'resistance_noise_ohm': 0.003, 'displacement_noise_m': 5e-6}
    write(path, parameters, operating=noise)
    return path


def test_importing_the_package_loads_nothing_heavy():
    program = 'import sys, tcp_muscle_ros; dir(tcp_muscle_ros); print(*sys.modules)'
    done = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True, check=True)
    loaded = {name.partition('.')[0] for name in done.stdout.split()}
    assert 'tcp_muscle_ros' in loaded
    assert not loaded & {'pandas', 'matplotlib', 'numba', 'rclpy', 'numpy', 'scipy', 'yaml'}


def test_the_examples_in_the_documentation_run():
    done = doctest.testmod(interface, optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS)
    assert done.attempted >= 3 and done.failed == 0


def test_the_examples_of_the_python_page_run(monkeypatch):
    monkeypatch.chdir(ROOT)
    done = doctest.testfile(str(ROOT / 'docs' / 'python.md'), module_relative=False)
    assert done.attempted >= 10 and done.failed == 0


def test_the_example_csv_is_what_its_command_makes(tmp_path, monkeypatch):
    specification = importlib.util.spec_from_file_location('example', ROOT / 'scripts' / 'make_example_csv.py')
    example = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(example)
    shipped = tcp.load(ROOT / 'config' / 'example_lab_run.csv')
    example.write(tmp_path / 'example_lab_run.csv')
    pd.testing.assert_frame_equal(tcp.load(tmp_path / 'example_lab_run.csv'), shipped, check_exact=False, atol=2e-2)


def test_from_a_protocol_to_an_improved_muscle_with_frames_in_between(muscle, tmp_path):
    frame = tcp.simulate(PROTOCOL, muscle)
    assert list(frame.columns)[:4] == ['current_A', 'voltage_V', 'load_N', 'ambient_degC']
    assert frame.index.name == 'time_s' and frame.index[-1] == pytest.approx(260.0)
    frame.to_csv(tmp_path / 'run.csv')
    pd.testing.assert_frame_equal(tcp.load(tmp_path / 'run.csv')[frame.columns], frame, check_exact=False, rtol=1e-9)

    found = tcp.diagnose(tcp.load(tmp_path / 'run.csv'))
    assert found.verdict == 'missing_physics'
    assert 'natural_convection' in {*found.findings['effect'], *found.findings['indistinguishable_from'][0].split(', ')}
    shown = found._repr_html_()
    assert found.headline.replace("'", '&#x27;') in shown and shown.count('<tr>') >= 5
    found.save(tmp_path / 'improved.yaml')
    written = read(tmp_path / 'improved.yaml').parameters
    for name in ('hA', 'B', 'natural_convection.n'):
        assert written[name] == pytest.approx(found.file.parameters[name], rel=1e-4)
    assert found.report(tmp_path / 'report').is_file()

    def missed(params):
        return float(np.sqrt(np.mean((tcp.simulate(PROTOCOL, params) - frame)['temperature_degC'] ** 2)))

    assert missed(found) < 0.5 * missed('karami_tadesse_2017')
    with pytest.raises(BadInput, match='exists already'):
        found.save(tmp_path / 'improved.yaml')


def test_a_calibration_is_a_table_a_file_and_a_muscle(tmp_path):
    frame = tcp.simulate(PROTOCOL)
    found = tcp.calibrate(frame)
    row = found.table.loc['hA']
    assert row['fixed'] and row['low'] <= row['value'] <= row['high']
    assert found.value('hA', 3) == pytest.approx(row['nominal'], rel=0.01)
    assert 'hA' in found._repr_html_()
    found.save(tmp_path / 'muscle.yaml')
    assert (tmp_path / 'muscle.intervals.json').is_file()
    again = tcp.simulate(PROTOCOL, found)
    np.testing.assert_allclose(again['displacement_m'], frame['displacement_m'], atol=2e-5)
    with pytest.raises(BadInput, match=r"unknown parameter 'ha'; did you mean 'hA'\?"):
        found.value('ha')


def test_a_plot_is_a_picture(tmp_path):
    picture = tcp.plot(tcp.simulate(PROTOCOL))
    assert picture._repr_png_().startswith(b'\x89PNG')
    picture.save(tmp_path / 'run.pdf')
    assert (tmp_path / 'run.pdf').read_bytes().startswith(b'%PDF')


@pytest.mark.parametrize(
    ('call', 'said'),
    [
        (
            lambda: tcp.simulate({'rate_hz': 5, 'segmnts': []}),
            r"protocol: unknown key 'segmnts'; did you mean 'segments'",
        ),
        (lambda: tcp.simulate(PROTOCOL, 'karami_tadesse_2071'), 'karami_tadesse_2071'),
        (tcp.diagnose, 'no recording'),
        (lambda: tcp.load('nowhere.csv'), 'nowhere.csv'),
        (lambda: tcp.diagnose(pd.DataFrame({'x_m': [1, 2]})), 'which is no plausible value'),
    ],
)
def test_a_mistake_is_one_line(call, said):
    with pytest.raises(BadInput, match=said) as raised:
        call()
    assert '\n' not in str(raised.value)


def test_a_file_with_several_runs_asks_which(tmp_path):
    from recording.labs.bench import FILES
    from recording.labs.first_forty import restarted

    (tmp_path / restarted.name).write_bytes(FILES[restarted.name].make()[0])
    with pytest.raises(BadInput, match=r"holds 3 runs; expected run='...'; known: restarts_1, restarts_2, restarts_3"):
        tcp.load(tmp_path / restarted.name)
    assert len(tcp.load(tmp_path / restarted.name, 'restarts_2')) == 18


def test_progress_rewrites_its_line_in_a_notebook(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, 'ipykernel', types.ModuleType('ipykernel'))
    with Progress('fitting') as progress:
        progress._start -= 10.0
        progress._shown -= 10.0
        progress.tell('3 runs of the model')
    assert capsys.readouterr().err.count('\n') == 0

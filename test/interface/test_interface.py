"""``import tcp_muscle_ros as tcp``: the five functions, with DataFrames in and out."""

import copy
import doctest
import importlib.util
import pickle
import re
import subprocess
import sys
import types
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from recording.bags import START, float64, write_foreign
from report.diagnoses import match

import tcp_muscle_ros as tcp
from tcp_muscle_ros import interface
from tcp_muscle_ros.commands.progress import Progress
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.interface.results import Diagnosed
from tcp_muscle_ros.interface.sources import recording_of
from tcp_muscle_ros.interface.wording import in_python
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording.options import this_unit
from tcp_muscle_ros.settings.ages import Age, write_ages
from tcp_muscle_ros.settings.intervals import variants
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


def test_every_other_block_of_the_python_page_runs_too(monkeypatch):
    monkeypatch.chdir(ROOT)
    blocks = re.findall(r'^```python\n(.*?)^```', (ROOT / 'docs' / 'python.md').read_text(), re.DOTALL | re.MULTILINE)
    (opening,) = [block for block in blocks if not block.startswith('>>>')]
    said: dict[str, object] = {}
    exec(opening, said)
    assert said['found'].verdict == 'missing_physics'


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
    assert len(variants(tmp_path / 'improved.yaml', written)) > 1
    assert found.file.operating == pytest.approx(read(tmp_path / 'improved.yaml').operating, rel=1e-4)
    assert found.report(tmp_path / 'report').is_file()

    def missed(params):
        return float(np.sqrt(np.mean((tcp.simulate(PROTOCOL, params) - frame)['temperature_degC'] ** 2)))

    assert missed(found) < 0.5 * missed('karami_tadesse_2017')
    with pytest.raises(BadInput, match='exists already'):
        found.save(tmp_path / 'improved.yaml')


def test_how_old_a_muscle_was_is_saved_with_it_and_goes_with_it(tmp_path):
    found = tcp.calibrate(tcp.simulate(PROTOCOL))
    ages = tmp_path / 'muscle.ages.json'
    write_ages(tmp_path / 'muscle.yaml', (Age(1, {'fatigue.n0': 3.0}),))
    assert ages.is_file()
    found.save(tmp_path / 'muscle.yaml')
    assert not ages.exists(), 'they are those of another muscle'
    d, experiments = match()
    worn = Diagnosed(replace(d, ages=(Age(1, {'fatigue.n0': 3.0}),)), tuple(experiments), {})
    worn.save(tmp_path / 'muscle.yaml', force=True)
    assert ages.is_file()
    Diagnosed(d, tuple(experiments), {}).save(tmp_path / 'muscle.yaml', force=True)
    assert not ages.exists()


def test_parameters_may_be_given_by_their_names(muscle):
    """As in a file: what is not given is as in the default set."""
    named = {'effects': ['natural_convection'], 'natural_convection.n': 0.35}
    noise = {'temperature_noise_k': 0.05, 'resistance_noise_ohm': 0.003, 'displacement_noise_m': 5e-6}
    pd.testing.assert_frame_equal(tcp.simulate(PROTOCOL, named | noise), tcp.simulate(PROTOCOL, muscle))
    start = tcp.calibrate(tcp.simulate(PROTOCOL, {'R0': 12.0}), params={'R0': 12.0}).table
    assert start.loc['R0', 'nominal'] == 12.0


def test_numbers_of_numpy_are_numbers_of_a_protocol():
    segments = [{'duration_s': np.int64(2), 'value': value} for value in np.linspace(0.0, 0.2, 3)]
    ramp = {'duration_s': 2, 'value': np.array([0.2, 0.0])}
    told = {'rate_hz': np.float64(5), 'input': 'current', 'segments': (*segments, ramp)}
    plain = [{'duration_s': 2, 'value': value} for value in (0.0, 0.1, 0.2, [0.2, 0.0])]
    pd.testing.assert_frame_equal(
        tcp.simulate(told), tcp.simulate({'rate_hz': 5, 'input': 'current', 'segments': plain})
    )


def test_the_instruments_of_a_rig_are_in_the_frame(tmp_path):
    (tmp_path / 'rig.yaml').write_text('instruments: {displacement: {offset_m: 1.0e-3}}\n')
    shown, ideal = tcp.simulate(PROTOCOL, rig=tmp_path / 'rig.yaml'), tcp.simulate(PROTOCOL)
    np.testing.assert_allclose((shown - ideal)['displacement_m'], 1e-3, atol=1e-9)


HOT = {'rate_hz': 10, 'load_n': 0.5, 'input': 'current', 'segments': [{'duration_s': 60, 'value': 0.4}]}


@pytest.mark.parametrize(
    ('protocol', 'params', 'said'),
    [
        (PROTOCOL, {'natural_convection.n': 0.35}, ['natural_convection.n has no effect: natural_convection is not']),
        (HOT, {}, ['outside 0 to 120 degC', 'to which no coil contracts']),
        (PROTOCOL, {'natural_convection.n': 0.35, 'effects': ['natural_convection']}, []),
        (PROTOCOL, {}, []),
    ],
)
def test_what_the_command_notes_of_a_simulation_is_a_warning(protocol, params, said):
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter('always')
        tcp.simulate(protocol, params)
    assert len(warned) == len(said) and all(each.filename == __file__ for each in warned)
    for each, text in zip(warned, said, strict=True):
        assert text in str(each.message)


def test_a_parameter_file_is_warned_of_once(tmp_path):
    (tmp_path / 'm.yaml').write_text('sim_node:\n  ros__parameters:\n    natural_convection.n: 0.35\n')
    with pytest.warns(UserWarning, match='has no effect') as warned:
        tcp.simulate(PROTOCOL, tmp_path / 'm.yaml')
    assert len(warned) == 1


def test_a_calibration_is_a_table_a_file_and_a_muscle(tmp_path):
    frame = tcp.simulate(PROTOCOL)
    found = tcp.calibrate(frame)
    row = found.table.loc['hA']
    assert row['fixed'] and row['low'] <= row['value'] <= row['high']
    assert found.value('hA', 3) == pytest.approx(row['nominal'], rel=0.01)
    assert 'hA' in found._repr_html_()
    intervals = re.findall(r'(\S+) to (\S+)', repr(found))
    assert len(intervals) >= 9 and all(low != high for low, high in intervals)  # of R0: 13.99995 to 14.00005
    found.save(tmp_path / 'muscle.yaml')
    assert (tmp_path / 'muscle.intervals.json').is_file()
    again = tcp.simulate(PROTOCOL, found)
    np.testing.assert_allclose(again['displacement_m'], frame['displacement_m'], atol=2e-5)
    with pytest.raises(BadInput, match=r"unknown parameter 'ha'; did you mean 'hA'\?"):
        found.value('ha')


@pytest.mark.parametrize('again', [lambda found: pickle.loads(pickle.dumps(found)), copy.deepcopy])
def test_a_calibration_can_be_kept_and_copied(frame, again):
    found = tcp.calibrate(frame)
    kept = again(found)
    pd.testing.assert_frame_equal(kept.table, found.table)
    assert repr(kept) == repr(found) and kept.calibration.rmse() == found.calibration.rmse()
    np.testing.assert_array_equal(kept.calibration.known.covariance, found.calibration.known.covariance)


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
        (lambda: tcp.calibrate('bag', './bag'), '^a recording is given twice'),
        (lambda: tcp.diagnose(*[pd.DataFrame({'x_m': [1, 2]})] * 2), '^a recording is given twice'),
        (lambda: tcp.load('nowhere.csv'), '^nowhere.csv: no such file'),
        (lambda: tcp.load('nowhere'), '^nowhere: no such bag'),
        (lambda: tcp.load(pd.DataFrame({'I (A)': []})), 'it has no rows'),
        (lambda: tcp.simulate(PROTOCOL, {'ha': 0.02}), r"^params: unknown parameter 'ha'; did you mean 'hA'\?"),
        (lambda: tcp.simulate(PROTOCOL, 3), '^params is 3; expected a parameter file'),
        (lambda: tcp.simulate(3), '^protocol is 3; expected a file'),
        (lambda: tcp.diagnose(pd.DataFrame({'x_m': [1, 2]}), params={'hA': 'x'}), '^params: '),
        (lambda: tcp.diagnose(pd.DataFrame({'x_m': [1, 2]})), 'which is no plausible value'),
    ],
)
def test_a_mistake_is_one_line(call, said):
    with pytest.raises(BadInput, match=said) as raised:
        call()
    assert '\n' not in str(raised.value)


@pytest.fixture(scope='module')
def frame():
    return tcp.simulate(PROTOCOL)


def changed(name, change):
    return lambda frame: frame.assign(**{name: change(frame[name])})


def swapped(frame):
    return frame.assign(temperature_degC=frame['resistance_ohm'], resistance_ohm=frame['temperature_degC'])


@pytest.mark.parametrize(
    ('change', 'advice'),
    [
        (changed('displacement_m', lambda v: 1e3 * v), "load(..., units={'displacement': 'mm'})"),
        (changed('displacement_m', lambda v: -v), "load(..., units={'displacement': '-m'})"),
        (changed('temperature_degC', lambda v: 1.8 * v + 32.0), "load(..., units={'temperature': 'degF'})"),
        (changed('load_N', lambda v: v / 9.80665e-3), "load(..., units={'load': 'g'})"),
        (changed('current_A', lambda v: 1e3 * v), "load(..., units={'current': 'mA'})"),
        (swapped, "load(..., channels={'temperature': 'resistance_ohm', 'resistance': 'temperature_degC'})"),
    ],
    ids=lambda value: value if isinstance(value, str) else '',
)
def test_the_gate_names_the_argument_that_mends_a_frame(frame, change, advice):
    """The advice is taken as it is written, and the same frame passes."""
    wrong = change(frame)
    with pytest.raises(BadInput) as raised:
        tcp.calibrate(wrong)
    assert advice in str(raised.value)
    assert '--' not in str(raised.value) and 'topic' not in str(raised.value)
    mended = eval(advice.replace('...', 'wrong'), {'load': tcp.load, 'wrong': wrong})
    pd.testing.assert_frame_equal(mended[frame.columns], frame, check_exact=False, atol=1e-9)
    assert tcp.calibrate(mended).value('hA', 2) == pytest.approx(0.019)


@pytest.mark.parametrize(
    ('call', 'said'),
    [
        (lambda f: tcp.calibrate(f[['temperature_degC']]), r"name one with load\(..., channels=\{'current': '...'\}\)"),
        (lambda f: tcp.calibrate(f, separate=('hB',)), r"separate=\('hB',\): expected one of hA, C"),
        (lambda f: tcp.load(3), '^3 is no recording; expected a DataFrame, or the path of a bag or of a file$'),
        (lambda f: tcp.diagnose(None), '^None is no recording; expected'),
        (lambda f: tcp.load(f, 'run_1'), "^run='run_1': a frame is one run of one muscle; expected it without run$"),
        (lambda f: tcp.load(f, namespace='/left'), "^namespace='/left': a frame is one run of one muscle"),
        (lambda f: tcp.load(f, units={'displacment': 'mm'}), r"units: unknown channel 'displacment'; did you mean"),
        (lambda f: tcp.load(f, units={'load': 'gram'}), r"units\['load'\]: unknown unit 'gram'; known: N,"),
        (lambda f: tcp.load(f[['current_A']], units={'load': 'g'}), r"units\['load'\]: frame has no channel of this"),
        (lambda f: tcp.load(f, channels={'load': 'Load'}), r"channels\['load'\]: frame has no column 'Load'; did you"),
        (lambda f: tcp.load(ROOT / 'config/example_lab_run.csv', channels={'load': 'F'}), 'tcp_muscle import --map'),
        (lambda f: tcp.plot(f).save(ROOT / 'setup.py'), 'give another path, or force=True'),
        (lambda f: tcp.calibrate(f).save(ROOT / 'README.md'), 'give another path, or force=True'),
    ],
)
def test_a_message_names_arguments_and_not_options(frame, call, said):
    with pytest.raises(BadInput, match=said) as raised:
        call(frame)
    assert '--' not in str(raised.value).replace('tcp_muscle import --map', '')


def test_what_mends_a_mistake_stays_an_option_of_its_reader_where_the_mistake_is_passed_on():
    passed = pickle.loads(pickle.dumps(BadInput('/tmp/draft: say ', this_unit('load', 'g')).replaced('/tmp/', '')))
    assert str(passed) == 'draft: say --unit load=g'
    with pytest.raises(BadInput, match=r"^draft: say load\(\.\.\., units=\{'load': 'g'\}\)$"):
        in_python(raising)(passed)


def raising(mistake):
    raise mistake


def test_a_bag_that_is_recorded_otherwise_is_told_the_arguments_of_load(tmp_path):
    rows = [('/a/laser', START + k * 10**8, float64(k)) for k in range(100)]
    bag = write_foreign(tmp_path / 'odd', rows)
    with pytest.raises(BadInput, match=r"say which is which with load\(..., channels=\{'NAME': '...'\}\)"):
        tcp.load(bag)
    loaded = tcp.load(bag, channels={'displacement': '/a/laser'}, units={'displacement': 'mm'})
    assert loaded['displacement_m'].iloc[-1] == pytest.approx(0.099)
    rows = [(f'/{name}/current', START + k, float64(0.1)) for name in ('left', 'right') for k in range(5)]
    write_foreign(tmp_path / 'two', rows)
    with pytest.raises(BadInput, match=r"choose one with load\(..., namespace='/left'\)"):
        tcp.load(tmp_path / 'two')


def test_a_file_and_its_frame_leave_out_the_same_numbers(frame, tmp_path):
    run = frame[['current_A', 'temperature_degC', 'displacement_m']].copy()
    run.iloc[100:111, 1] = -999.9
    run.to_csv(tmp_path / 'run.csv')
    of_file, of_frame = tcp.load(tmp_path / 'run.csv'), tcp.load(pd.read_csv(tmp_path / 'run.csv'))
    pd.testing.assert_frame_equal(of_frame, of_file[of_frame.columns])
    assert of_frame['temperature_degC'].isna().sum() == 11
    fits = [tcp.calibrate(source).table[['value', 'low', 'high']] for source in (tmp_path / 'run.csv', of_frame)]
    pd.testing.assert_frame_equal(*fits, rtol=1e-3)


@pytest.mark.parametrize('heading', ['distance', 'gap', 'laser', 'position', 'height', 'Weg', 'stroke'])
def test_a_file_and_its_frame_have_the_same_channels(frame, heading, tmp_path):
    run = frame[['current_A', 'temperature_degC']].assign(**{f'{heading} (mm)': 30 - 1e3 * frame['displacement_m']})
    run.to_csv(tmp_path / 'run.csv')
    of_file, of_frame = tcp.load(tmp_path / 'run.csv'), tcp.load(pd.read_csv(tmp_path / 'run.csv'))
    assert set(of_frame.columns) == set(of_file.columns) > {'displacement_m'}
    if heading in ('distance', 'gap'):
        pd.testing.assert_frame_equal(of_frame, of_file[of_frame.columns])


def recorded(path, *, back_s=0.0, odd=None):
    """A dated bag of a current that is switched on, by 0.1 s; its clock set back in its middle, one value ``odd``."""
    rows = []
    for k in range(200):
        stamp = START + k * 10**8 - (round(1e9 * back_s) if k >= 100 else 0)
        value = odd if k == 20 and odd is not None else 0.2 * (k >= 50)
        rows += [('/current', stamp, float64(value)), ('/displacement', stamp, float64(1e-5 * k))]
    return write_foreign(path, rows)


@pytest.mark.parametrize('call', [tcp.load, tcp.calibrate, lambda bag: tcp.calibrate(tcp.load(bag))])
def test_a_bag_whose_clock_was_set_back_is_refused_by_all(tmp_path, call):
    with pytest.raises(BadInput, match='runs backwards') as raised:
        call(recorded(tmp_path / 'back', back_s=8.0))
    assert '\n' not in str(raised.value)


def test_a_frame_keeps_the_date_and_the_notes_of_its_bag(tmp_path):
    frame = tcp.load(recorded(tmp_path / 'bag', odd=float('nan')))
    bag, again, later = recording_of(tmp_path / 'bag'), recording_of(frame), recording_of(frame.loc[5.0:])
    assert again.notes == bag.notes and 'not finite' in again.notes[0]
    assert again.start_ns == bag.start_ns == START and later.start_ns == START + 5 * 10**9
    assert again.known == bag.known
    assert recording_of(tcp.load(frame)).notes == bag.notes
    frame.to_parquet(tmp_path / 'run.parquet')
    read_again = recording_of(pd.read_parquet(tmp_path / 'run.parquet'))
    assert (read_again.start_ns, read_again.notes, read_again.known) == (START, bag.notes, bag.known)


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

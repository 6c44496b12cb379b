"""One gate for every command: what ``diagnose``, ``replay`` and ``calibrate`` refuse, each in the same words.

The recording is the independent truth generator's, and sound but for what is done to it here.
"""

import re

import numpy as np
import pytest
from commands import faulty_bags as bags
from recording.bags import START, float64, write_foreign

from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.bag_writer import write_recording
from tcp_muscle_ros.recording.plausibility import refuse_implausible
from tcp_muscle_ros.recording.recording import Channel, Recording
from tcp_muscle_ros.tool import main

NOMINAL = 'karami_tadesse_2017'


@pytest.fixture
def refused(tmp_path, capsys):
    """The line with which all three commands refuse a bag."""

    def run(bag, *options):
        before = sorted(tmp_path.rglob('*'))
        lines = set()
        for command in (
            ['diagnose', '--output', str(tmp_path / 'report')],
            ['calibrate', '--output', str(tmp_path / 'mine.yaml')],
            ['replay', '--output', str(tmp_path / 'replayed')],
        ):
            params = [] if '--params' in options else ['--params', NOMINAL]
            code = main([*command, str(bag), *params, *map(str, options)])
            out, err = capsys.readouterr()
            assert (code, out) == (2, ''), (command, code, err)
            (line,) = [line for line in err.splitlines() if not line.startswith('diagnosing: ')]
            lines.add(re.sub(r'from .* s on, under .* A', 'from x s on, under y A', line.partition(': ')[2]))
        assert sorted(tmp_path.rglob('*')) == before
        assert len(lines) == 1, lines
        return lines.pop()

    return run


@pytest.fixture
def made(tmp_path):
    def make(*changes, **sound):
        experiment, channels = bags.sound(**sound)
        for change in changes:
            experiment, channels = change(experiment, channels)
        return bags.write_bag(tmp_path / 'bag', experiment, channels)

    return make


def fahrenheit(value):
    return 1.8 * value + 32.0


def scaled(name, factor):
    return bags.changed(name, lambda value: factor * value)


def later(seconds):
    """The recording begins in the middle of a heating."""

    def cut(e, c):
        first = int(np.searchsorted(e.time, seconds))
        return e, {n: (k[k >= first], v[k >= first]) for n, (k, v) in c.items()}

    return cut


@pytest.mark.parametrize(
    ('fault', 'options', 'told'),
    [
        (scaled('current', 1e3), [], '--unit current=mA'),
        (scaled('temperature', 1.0), ['--unit', 'temperature=K'], '--unit temperature=degC'),
        (bags.changed('temperature', lambda v: v + 273.15), [], '--unit temperature=K'),
        (bags.changed('temperature', fahrenheit), [], r'would be a room of 2\d\.\d degC: .*--unit temperature=degF'),
        (scaled('temperature', 1.0), ['--unit', 'temperature=degF'], 'recorded in degC, not degF.*temperature=degC'),
        (bags.changed('temperature', lambda v: 35.0 - 0.5 * v), [], 'temperature falls when the muscle is heated: are'),
        (scaled('displacement', 1e3), [], '--unit displacement=mm'),
        (scaled('displacement', -1.0), [], '--unit displacement=-m'),
        (scaled('displacement', -1e3), ['--unit', 'displacement=mm'], '--unit displacement=-mm'),
        (scaled('load', 1e3 / 9.80665), [], r'load is about 60 N, .* if it is recorded in g, say --unit load=g'),
        (scaled('load', -1.0), [], '--unit load=-N'),
        (scaled('resistance', 1e-3), [], '--unit resistance=kohm'),
        (scaled('resistance', 1e3), [], '--unit resistance=mohm'),
        (
            scaled('current', 1.0),
            ['--unit', 'current=mA'],
            'temperature moves as this muscle would .* say --unit current=A; or state',
        ),
        (bags.set_back(6.0), [], 'the clock was set back'),
        (bags.swapped('current', 'displacement'), [], 'does /displacement carry an input'),
    ],
    ids=lambda value: value if isinstance(value, str) else '',
)
def test_every_command_refuses_what_cannot_be_in_the_same_words(made, refused, fault, options, told):
    line = refused(made(fault), *options)
    assert re.search(told, line), line


HELD = {'blocked': True}
GRAM = 1e3 / 9.80665
AMBIENT = ['--channel', 'ambient=/ambient']


@pytest.mark.parametrize(
    ('recorded', 'faults', 'options', 'told'),
    [
        ({'kind': 'power'}, [scaled('power', 1e3)], [], 'power=mW'),
        ({'kind': 'power'}, [], ['--unit', 'power=mW'], 'power=W'),
        ({'kind': 'power'}, [scaled('power', -1.0)], [], 'power=-W'),
        ({'kind': 'voltage'}, [scaled('voltage', 1e3)], [], 'voltage=mV'),
        ({'kind': 'voltage'}, [], ['--unit', 'voltage=mV'], 'voltage=V'),
        ({}, [bags.added('ambient', 296.15, 0.05)], AMBIENT, 'ambient=K'),
        ({}, [bags.added('ambient', 73.4, 0.05)], AMBIENT, 'ambient=degF'),
        ({}, [bags.added('ambient', 23.0, 0.05)], [*AMBIENT, '--unit', 'ambient=K'], 'ambient=degC'),
        ({}, [bags.added('ambient', 23.0, 0.05)], [*AMBIENT, '--unit', 'ambient=degF'], 'ambient=degC'),
        ({}, [bags.without('load'), bags.added('force', 60.0, 0.2)], [], 'force=g'),
        ({}, [bags.added('force', 60.0, 0.2)], [], 'force=g'),
        ({}, [bags.without('load'), bags.added('force', -0.5884, 2e-3)], [], 'force=-N'),
        ({}, [bags.added('force', -0.5884, 2e-3)], [], 'force=-N'),
        ({}, [bags.without('load'), bags.added('force', -60.0, 0.2)], [], 'force=-g'),
        ({}, [bags.added('force', -60.0, 0.2)], ['--unit', 'force=-N'], 'force=-g'),
        (HELD, [scaled('force', GRAM)], [], 'force=g'),
        (HELD, [scaled('force', 1e3)], [], 'force=mN'),
        (HELD, [scaled('force', -1.0)], [], 'force=-N'),
        (HELD, [scaled('force', -GRAM)], [], 'force=-g'),
    ],
    ids=lambda value: value if isinstance(value, str) else '',
)
def test_the_unit_that_every_command_names_is_the_one_that_mends(made, refused, recorded, faults, options, told):
    bag = made(*faults, **recorded)
    line = refused(bag, *options)
    assert re.search(rf'say (--unit \S+ or )?--unit {re.escape(told)}(?=[;, ]|$)', line), line
    channels = options[:2] if '--channel' in options else []
    assert main(['replay', str(bag), '--params', NOMINAL, *channels, '--unit', told]) == 0


@pytest.mark.parametrize(
    ('faults', 'options'),
    [
        ([bags.added('force', -0.05, 2e-3)], []),  # a load cell that hangs beside the weight
        ([bags.without('load'), bags.added('force', -0.005, 2e-3)], []),
        ([bags.added('ambient', 23.0, 0.05)], AMBIENT),
        ([bags.added('ambient', 12.0, 0.05)], AMBIENT),  # a window is open
    ],
)
def test_an_idle_load_cell_and_a_cold_room_are_not_refused(made, faults, options):
    assert main(['replay', str(made(*faults)), '--params', NOMINAL, *options]) == 0


def test_degrees_fahrenheit_are_seen_without_a_rest(made, refused):
    line = refused(made(later(8.0), bags.changed('temperature', fahrenheit)))
    assert re.search(r'where it cools down to, which in degF would be a room of 2\d', line), line


def test_a_recording_that_begins_hot_is_none_in_degrees_fahrenheit(made, tmp_path):
    assert main(['replay', str(made(later(25.0))), '--params', NOMINAL]) == 0


@pytest.mark.parametrize('rest', [0.0, 32.0])
def test_a_thermometer_is_not_told_to_be_in_the_unit_that_it_is_read_in(made, rest):
    bag = made(bags.changed('temperature', lambda v: v - 23.0 + rest))
    refuse_implausible(read_bag(bag))  # once: "recorded in degC, not degF? Then say --unit temperature=degC"


def test_a_load_that_is_stated_in_gram_is_refused(made, refused, tmp_path):
    (tmp_path / 'gram.yaml').write_text('/**:\n  ros__parameters:\n    load_n: 60.0\n')
    line = refused(made(bags.without('load')), '--params', tmp_path / 'gram.yaml')
    assert 'state it in N, not g (60 g are 0.588 N)' in line


def test_a_stiff_muscle_may_bear_what_draws_a_soft_one_to_many_times_its_length(made, tmp_path, capsys):
    bag = made(scaled('load', 1e3 / 9.80665))
    (tmp_path / 'stiff.yaml').write_text('/**:\n  ros__parameters:\n    k0: 2300.0\n')
    assert main(['replay', str(bag), '--params', str(tmp_path / 'stiff.yaml')]) == 0


def test_time_that_runs_backwards_in_the_middle_of_a_bag_is_refused(tmp_path, refused):
    time = np.concatenate([np.arange(0.0, 60.0, 0.1), np.arange(30.0, 90.0, 0.1)])
    rows = []
    for k, t in enumerate(time):
        at = START + round(t * 1e9)
        rows += [('/current', at, float64(0.2 * (k % 200 < 100))), ('/displacement', at, float64(1e-3 * np.sin(k)))]
    line = refused(write_foreign(tmp_path / 'back', rows))
    assert 'time runs backwards by 29.9 s at 59.9 s' in line
    assert 'two recordings are in one bag' in line


def constant(tmp_path, drive):
    time = np.arange(900) / 10.0
    rng = np.random.default_rng(3)
    flat = {'temperature': 310.0 + 0.1 * rng.standard_normal(900), 'displacement': np.full(900, 0.003)}
    channels = {name: Channel(name, time, value, name) for name, value in flat.items()}
    channels['current'] = Channel('current', time, drive(time), 'current')
    write_recording(tmp_path / 'still', Recording('', channels, START, {'load_n': 0.6}))
    return str(tmp_path / 'still')


@pytest.mark.parametrize(
    ('drive', 'why'),
    [
        (lambda t: np.full_like(t, 0.2), 'and neither does the input'),
        (lambda t: 0.2 * (t % 40 < 20), 'although the input changes: are the sensors connected?'),
    ],
)
def test_nothing_is_calibrated_from_channels_that_do_not_move(tmp_path, capsys, drive, why):
    bag = constant(tmp_path, drive)
    assert main(['calibrate', bag, '--output', str(tmp_path / 'mine.yaml')]) == 2
    assert f'still: displacement, temperature do not move, {why}' in capsys.readouterr().err
    assert not (tmp_path / 'mine.yaml').exists()


def test_a_prediction_that_is_not_finite_is_one_line(made, refused, tmp_path):
    (tmp_path / 'wild.yaml').write_text('/**:\n  ros__parameters:\n    a_R: 0.05\n    hA: 0.0001\n    C: 0.001\n')
    line = refused(made(bags.without('load')), '--params', tmp_path / 'wild.yaml')
    assert 'the model has no finite answer from x s on, under y A and 0 N: this muscle would have burnt' in line


def test_what_is_sound_passes(made, tmp_path):
    bag = str(made())
    assert main(['replay', bag, '--params', NOMINAL]) == 0


def test_an_input_that_begins_after_all_outputs_have_ended_is_refused(tmp_path, refused):
    time = np.arange(600) / 10.0
    warm = 296.0 + 5.0 * np.sin(time / 5.0) + 0.1 * np.random.default_rng(2).standard_normal(600)
    channels = {
        'temperature': Channel('temperature', time, warm, 'temperature'),
        'current': Channel('current', time + 1000.0, 0.2 * (time % 30.0 < 10.0), 'current'),
    }
    write_recording(tmp_path / 'late', Recording('', channels, START, {'load_n': 0.6}))
    line = refused(tmp_path / 'late')
    assert 'current begins at 1000 s, after the last of temperature (59.9 s): are these of one recording' in line

"""``tcp_muscle diagnose`` on recordings that are wrong: a clear line, or a verdict without a name. Never a wrong name.

The muscle is the independent truth generator's with nothing concealed, so every name would be a wrong one.
"""

import json
import re

import pytest
from commands import faulty_bags as bags

from tcp_muscle_ros.tool import main


@pytest.fixture
def diagnose(tmp_path, capsys):
    """Writes a bag of each (experiment, channels); returns (exit code, the report or the line on standard error)."""

    def run(*made, options=()):
        paths = [str(bags.write_bag(tmp_path / f'bag_{k}', *each)) for k, each in enumerate(made)]
        code = main(['diagnose', *paths, '--output', str(tmp_path / 'report'), *options])
        if code:
            *progress, line = capsys.readouterr().err.splitlines()
            assert all(said.startswith('diagnosing: ') for said in progress)
            return code, line
        return code, json.loads((tmp_path / 'report' / 'report.json').read_text())

    return run


def issues(report):
    return '\n'.join(issue for recording in report['recordings'] for issue in recording['issues'])


@pytest.mark.parametrize(
    ('fault', 'told'),
    [
        (bags.without('current'), 'no input recorded: expected a channel current, power or voltage'),
        (bags.without(*bags.CHANNELS), 'nothing to compare: expected at least one of temperature, resistance'),
        (bags.changed('displacement', lambda v: 1e2 * v), '--unit displacement=cm'),
        (bags.changed('displacement', lambda v: 0.1 - v), '--unit displacement=-m'),
        (bags.swapped('temperature', 'resistance'), 'are /temperature and /resistance swapped'),
        (bags.swapped('temperature', 'displacement'), '--channel displacement=TOPIC'),
        (bags.swapped('resistance', 'displacement'), '--channel resistance=TOPIC'),
        (bags.swapped('current', 'resistance'), '--channel current=TOPIC'),
        (bags.swapped('current', 'temperature'), '--channel current=TOPIC'),
    ],
    ids=lambda value: value if isinstance(value, str) else '',
)  # units, signs and clocks are in test_gate.py, for every command
def test_what_the_user_can_mend_is_one_line_that_says_how(diagnose, fault, told):
    code, line = diagnose(fault(*bags.sound()))
    assert code == 2
    assert 'bag_0: ' in line
    assert re.search(told, line), line


def test_what_the_line_said_mends_it(diagnose):
    made = bags.changed('temperature', lambda v: 1.8 * v + 32)(*bags.sound())
    made = bags.changed('displacement', lambda v: -1e3 * v)(*made)
    code, report = diagnose(made, options=('--unit', 'temperature=degF', '--unit', 'displacement=-mm'))
    assert (code, report['findings']) == (0, [])
    assert report['verdict'] in ('match', 'wrong_parameters')
    assert report['fit']['temperature']['rmse_calibrated'] < 0.4
    assert report['fit']['displacement']['rmse_calibrated'] < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    'missing', [pytest.param(c, marks=pytest.mark.long if c == 'temperature' else ()) for c in bags.CHANNELS]
)
def test_one_channel_less_is_no_other_verdict(diagnose, missing):
    code, report = diagnose(bags.without(missing)(*bags.sound()))
    assert code == 0
    assert (report['findings'], report['unexplained']) == ([], None)
    assert report['verdict'] in ('match', 'wrong_parameters')
    assert missing not in report['fit']


@pytest.mark.long
def test_two_loads_that_nobody_stated_are_no_physics(diagnose):
    made = [bags.without('load')(*bags.sound(load)) for load in (0.5884, 0.981)]
    code, report = diagnose(*made)
    # Nobody said what differs: the runs of one protocol do not repeat each other, in the stroke alone.
    assert (code, report['verdict'], report['findings']) == (0, 'not_repeatable', [])
    assert report['repeatability']['displacement'] > 2.0 * report['noise']['displacement']
    assert 'no load was recorded or stated: taken as 0 N; state load_n in --params' in issues(report)


@pytest.mark.slow
@pytest.mark.parametrize(('channel', 'share'), [('temperature', 0.0), ('displacement', 0.45)])
def test_a_sensor_that_stands_still_is_a_fault_of_the_set_up_and_left_out(diagnose, channel, share):
    code, report = diagnose(bags.changed(channel, bags.frozen(share))(*bags.sound()))
    assert (code, report['verdict'], report['findings']) == (0, 'sensor_or_setup', [])
    assert f'{channel} stands still' in issues(report)
    fit = report['fit'].get(channel)
    if share == 0.0:
        assert fit is None
    else:
        assert fit['rmse_calibrated'] < 1.5e-4


def test_where_the_only_sensor_is_dead_nothing_can_be_said(diagnose):
    made = bags.without('temperature', 'resistance')(*bags.sound())
    code, line = diagnose(bags.changed('displacement', bags.frozen(0.0))(*made))
    assert code == 2
    assert 'displacement stands still' in line
    assert line.endswith('and nothing else was recorded')


@pytest.mark.slow
@pytest.mark.parametrize(
    ('fault', 'why'),
    [
        (bags.kept(lambda t: (t < 28.0) | (t > 38.0)), 'no current for 10.'),  # the current went off in between
        (bags.glued(22.0, 0.1), 'temperature jumps at 22.'),
    ],
    ids=['gap', 'glued'],
)
def test_a_recording_is_cut_where_its_input_is_lost_or_another_begins(diagnose, fault, why):
    code, report = diagnose(fault(*bags.sound()))
    assert (code, report['findings'], report['unexplained']) == (0, [], None)
    assert report['verdict'] in ('match', 'wrong_parameters')
    assert len(report['recordings']) == 2
    assert f'of the recording, which was cut: {why}' in issues(report)
    assert report['fit']['temperature']['rmse_calibrated'] < 0.4
    assert report['fit']['displacement']['rmse_calibrated'] < 1e-4


@pytest.mark.slow
def test_values_that_are_not_numbers_are_left_out(diagnose):
    made = bags.changed('displacement', bags.some_nan)(*bags.changed('temperature', bags.some_nan)(*bags.sound()))
    code, report = diagnose(made)
    assert (code, report['findings'], report['unexplained']) == (0, [], None)
    assert report['verdict'] in ('match', 'wrong_parameters')
    assert 'temperature, displacement: 74 of 1250 values are not finite and were left out' in issues(report)


@pytest.mark.parametrize(
    ('made', 'why'),
    [
        (bags.kept(lambda t: t < 0.95)(*bags.sound()), 'the longest channel has 10 samples'),
        (bags.sound(level=0.0), 'the input never changes'),
        (bags.sound(level=0.2), 'the input never changes'),
    ],
    ids=['ten samples', 'no current', 'a constant current'],
)
def test_too_little_is_no_verdict(diagnose, made, why):
    code, report = diagnose(made)
    assert (code, report['verdict'], report['findings']) == (0, 'insufficient_data', [])
    assert report['calibration'] == {}
    assert all(why in each['why'] for each in report['not_testable'])

"""Every value in /diagnostics is a number with its unit in the key, a count, or words: all keys of all nodes."""

from math import inf, isfinite, isnan
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')
pytest.importorskip('serial', reason='needs pyserial, the extra hardware')

from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Float64

ANTAGONIST = Path(__file__).resolve().parents[2] / 'config' / 'antagonist.yaml'
pytestmark = pytest.mark.processes

UNITS = ('a', 'c', 'm', 'n', 'ohm', 'rad', 's')  # after the last underscore of a key
COUNTS = {
    *('ticks', 'missed_ticks', 'unpublished_ticks', 'clock_jumps'),
    *('rejected_commands', 'command_timeouts', 'skipped_steps', 'broken_lines', 'alarms'),
}
SHARES = {'sure'}  # of 1
WORDS = {
    *('state', 'limited_by', 'commanded_by', 'refused_inputs', 'effects', 'model_file'),
    *('mode', 'feedback', 'in_domain', 'slack', 'board', 'stage', 'channel', 'on_trial'),
}
SAFE = {
    *('state', 'current_a', 'current_limit_a', 'configured_current_limit_a', 'derate_temperature_c', 'limited_by'),
    *('hottest_c', 'command_age_s', 'commanded_by', 'rejected_commands', 'refused_inputs', 'command_timeouts'),
    *('skipped_steps', 'ticks', 'missed_ticks', 'unpublished_ticks', 'clock_jumps'),
}
CONTROLLED = SAFE | {
    *('mode', 'model_file', 'feedback', 'setpoint_m', 'shaped_setpoint_m'),
    *('predicted_displacement_m', 'predicted_temperature_c'),
}
KEYS = {
    'sim_node': SAFE | {'fibre_temperature_c', 'in_domain', 'slack', 'effects'},
    'controller_node': CONTROLLED | {'displacement_m'},
    'knuckle': {'angle_rad', 'setpoint_rad', 'cocontraction_n', 'stiffness_n_m_per_rad'},  # a joint of a controller
    'by_resistance': CONTROLLED | {'resistance_ohm'},
    'serial_driver_node': SAFE | {'board', 'board_uptime_s', 'broken_lines'},
    'twin_node': {
        *('state', 'stage', 'channel', 'differs_for_s', 'sure', 'alarms', 'hottest_c', 'effects'),
        *('model_file', 'on_trial'),
    },
}
KNOWN = {  # what is a finite number once the muscles run; a measurement that is late is nan again for a moment
    'sim_node': ('current_a', 'current_limit_a', 'hottest_c', 'command_age_s', 'fibre_temperature_c'),
    'controller_node': (
        *('setpoint_m', 'shaped_setpoint_m', 'displacement_m'),
        *('predicted_displacement_m', 'predicted_temperature_c'),
    ),
    'twin_node': ('hottest_c',),
    'knuckle': tuple(KEYS['knuckle']),
}


def is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True


def complaint(key, text):
    """What is wrong with a value; '' where nothing is."""
    if key in WORDS:
        return f'{key} is words, and {text} a number' if is_number(text) else ''
    if not is_number(text):
        return f'{key} is {text!r}, not a number'
    value = float(text)
    if key in COUNTS:
        return '' if value == int(value) >= 0 else f'{key} is {text}, no count'
    if key in SHARES:
        return '' if isnan(value) or 0.0 <= value <= 1.0 else f'{key} is {text}, no share'
    if key.rpartition('_')[2] not in UNITS:
        return f'{key} has no unit'
    return '' if abs(value) < 1e6 or value in (inf, -inf) or isnan(value) else f'{key} is {text}: too few digits'


@pytest.mark.long
def test_two_nodes_of_one_name_say_so(bench):
    diagnostics = bench.listen('/diagnostics', DiagnosticArray)
    both = [bench.start('controller_node', 'namesakes') for _ in range(2)]

    def said():
        told = [s.message for _, array in diagnostics[:] for s in array.status if s.name.startswith('/namesakes/')]
        return any('another node is named /namesakes/controller_node too' in message for message in told)

    bench.until(said, 'no word of it')
    bench.until(lambda: all('stop one of them' in node.said() for node in both), 'not in the log')
    for node in both:
        node.kill()


@pytest.fixture(scope='module')
def heard(bench, no_board):
    """node -> its latest values, of a muscle that is driven, controlled and followed, and of two on a joint."""
    diagnostics = bench.listen('/diagnostics', DiagnosticArray)
    bench.start('sim_node', 'told')
    bench.start('controller_node', 'told')
    by_resistance = {'feedback': 'resistance'}
    bench.start('controller_node', 'told/apart', '-r', '__node:=by_resistance', **by_resistance)
    bench.start('twin_node', 'told')
    bench.start('serial_driver_node', 'told/apart', port=no_board)
    for name in ('sim_node', 'controller_node'):
        bench.start(name, 'pair', '--params-file', str(ANTAGONIST))
    latest, of_joint = {}, '/pair/controller_node/knuckle'

    def all_of_them():
        for _, array in diagnostics[:]:
            for status in array.status:
                if status.name.startswith('/told/') or status.name == of_joint:
                    latest[status.name.rpartition('/')[2]] = {value.key: value.value for value in status.values}
        return set(latest) == set(KEYS)

    bench.speaker('/pair/knuckle/angle_setpoint').publish(Float64(data=0.2))

    def settled():
        known = (latest[node][key] for node, keys in KNOWN.items() for key in keys)
        return latest['twin_node']['state'] == 'follows' and all(
            is_number(text) and isfinite(float(text)) for text in known
        )

    with bench.repeating(bench.speaker('/told/displacement_setpoint'), 0.005):
        bench.until(lambda: all_of_them() and settled(), 'not all are heard', 240.0)
    return latest


@pytest.mark.parametrize('node', KEYS)
def test_every_value_is_a_number_with_its_unit_in_the_key_or_words(heard, node):
    assert set(heard[node]) == KEYS[node]
    assert not [wrong for key, text in heard[node].items() if (wrong := complaint(key, text))]


def test_what_is_known_has_its_size(heard):
    assert float(heard['controller_node']['setpoint_m']) == 0.005
    assert 20.0 < float(heard['sim_node']['fibre_temperature_c']) <= float(heard['sim_node']['hottest_c']) + 1.0
    joint = {key: float(text) for key, text in heard['knuckle'].items()}
    assert joint['setpoint_rad'] == 0.2 and abs(joint['angle_rad']) < 0.4
    assert 0.3 < joint['cocontraction_n'] < 1.0
    assert 0.001 < joint['stiffness_n_m_per_rad'] < 0.01, 'two coils of 20 N/m on 10 mm: 0.004'
    assert isnan(float(heard['serial_driver_node']['board_uptime_s'])), 'there is no board'


def test_the_recorder_publishes_no_diagnostics(bench, heard):
    command = ['-m', 'tcp_muscle_ros.tool', 'record', '--namespace', 'told', '--output', str(bench.folder / 'recorded')]
    program = bench.run(command, 'recorder')
    named = ('muscle_recorder', '/told')
    bench.until(lambda: named in bench.node.get_node_names_and_namespaces(), 'no recorder', 120.0)
    heard_by = bench.node.get_subscriber_names_and_types_by_node
    bench.until(lambda: '/told/displacement' in dict(heard_by(*named)), 'it records nothing')
    assert '/diagnostics' not in dict(bench.node.get_publisher_names_and_types_by_node(*named))
    program.kill()


@pytest.mark.parametrize(
    ('key', 'text'),
    [('current_a', 'none'), ('current', '0.1'), ('state', '3'), ('ticks', '1.5'), ('sure', '90'), ('age_s', '1.7e+09')],
)
def test_what_is_not_so_is_seen(key, text):
    assert complaint(key, text)

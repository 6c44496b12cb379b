"""The twin beside a simulated muscle: it predicts with a band, and says when the muscle changes."""

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter
from std_msgs.msg import String

from tcp_muscle_ros.recording.bag import read_bag

pytestmark = pytest.mark.processes

NOISE = {'temperature_noise_k': 0.1, 'resistance_noise_ohm': 0.01, 'displacement_noise_m': 2e-5}


def says(heard, name):
    """What the latest diagnostics of a node say."""
    for _, array in reversed(heard[-20:]):
        for status in array.status:
            if status.name == name:
                return {'message': status.message, 'level': status.level, **{v.key: v.value for v in status.values}}
    return {'state': '', 'stage': ''}


def test_a_muscle_is_followed_and_one_that_changes_is_said_to_differ_with_a_bag_and_a_finding(bench, tmp_path):
    bench.start('sim_node', 'twins', **NOISE)
    twin = bench.start(
        'twin_node', 'twins', report_folder=str(tmp_path), auto_diagnose=True, collect_s=4.0, keep_s=60.0
    )
    current = bench.listen('/twins/current')
    diagnostics = bench.listen('/diagnostics', DiagnosticArray)
    finding = bench.listen('/twins/twin_node/finding', String)
    topics = {
        name: bench.listen(f'/twins/twin_node/{name}')
        for name in ('predicted_temperature', 'predicted_displacement_low', 'predicted_displacement_high')
    }
    residual = bench.listen('/twins/twin_node/residual_temperature')
    command = bench.speaker('/twins/current_command')
    with bench.repeating(command, 0.2):
        bench.until(lambda: says(diagnostics, '/twins/twin_node')['state'] == 'follows', 'does not follow', 120.0)
        bench.until(lambda: current and current.last.data == 0.2 and len(residual) > 500, 'predicts nothing')
        assert says(diagnostics, '/twins/twin_node')['state'] == 'follows'
        assert abs(sum(residual.values[-300:]) / 300) < 0.1  # K
        low, high = (topics[f'predicted_displacement_{end}'].values[300:] for end in ('low', 'high'))
        assert all(below < above for below, above in zip(low, high, strict=False))
        change = [Parameter('hA', value=0.03).to_parameter_msg()]
        assert bench.call(SetParametersAtomically, '/twins/sim_node/set_parameters_atomically', parameters=change)
        bench.until(lambda: says(diagnostics, '/twins/twin_node')['state'] == 'differs', 'the change is not noticed')
        assert says(diagnostics, '/twins/twin_node')['stage'] == 'thermal'
        assert 'differs: thermal' in says(diagnostics, '/twins/twin_node')['message']
        assert 'or the room is not at 23.0 degC' in says(diagnostics, '/twins/twin_node')['message']  # nobody reads it
        bench.until(lambda: 'the muscle differs: thermal, by its ' in twin.said(), 'the log does not say it')
        bench.until(lambda: list(tmp_path.glob('alarm_*/last_minutes/metadata.yaml')), 'no bag is written')
        bench.until(lambda: finding, f'no finding: {twin.said()}', 120.0)
    (folder,) = tmp_path.glob('alarm_*')
    kept = read_bag(folder / 'last_minutes')
    assert {'temperature', 'resistance', 'displacement', 'current'} <= set(kept)
    assert kept.duration <= 60.0
    assert (folder / 'report' / 'report.json').is_file()
    assert len(finding.last.data) > 10 and 'failed' not in finding.last.data
    assert 'Traceback' not in twin.said()


def test_beside_a_controlled_muscle_that_conceals_an_effect_the_twin_says_so(bench, tmp_path):
    """The processes of launch/twin.launch.py, without launch: the controller tracks all the same."""
    bench.start('sim_node', 'concealing', effects='[natural_convection]', **NOISE)
    bench.start('controller_node', 'concealing')
    bench.start('twin_node', 'concealing', report_folder=str(tmp_path))
    diagnostics = bench.listen('/diagnostics', DiagnosticArray)
    displacement = bench.listen('/concealing/displacement')
    with bench.repeating(bench.speaker('/concealing/displacement_setpoint'), 0.012):
        bench.until(lambda: says(diagnostics, '/concealing/twin_node')['state'] == 'differs', 'not noticed', 120.0)
        bench.until(lambda: abs(displacement.last.data - 0.012) < 5e-4, 'does not track')
    assert says(diagnostics, '/concealing/twin_node')['stage'] in ('thermal', 'mechanical')
    bench.until(lambda: list(tmp_path.glob('alarm_*/last_minutes/metadata.yaml')), 'no bag is written')


def test_a_file_that_is_none_is_refused_in_one_line(bench):
    twin = bench.start('twin_node', 'nobody', params_file='nowhere.yaml')
    bench.programs.remove(twin)
    bench.until(lambda: twin.process.poll() is not None, 'does not end')
    assert twin.process.returncode == 2
    assert twin.said().strip().endswith('nowhere.yaml: cannot read the parameter file: No such file or directory')

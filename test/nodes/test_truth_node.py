"""A muscle of the truth behind a node: ``tcp_muscle run`` records in lockstep what the truth gives by itself."""

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from proof.investigated import as_experiment, drawn
from proof.truth import observe
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.protocol import read_protocol

pytestmark = pytest.mark.processes
PROTOCOL = """
rate_hz: 20
input: current
segments:
  - {duration_s: 30, value: 0.12, load_n: 0.3}
  - {duration_s: 10, value: 0.05, load_n: 0.588}
"""


def test_each_run_finds_the_muscle_cold_and_records_it_with_the_noise_of_its_instruments(bench, tmp_path):
    truth = bench.run(['-m', 'proof.truth_node', '--namespace', 'truth'], 'truth_node')
    (tmp_path / 'protocol.yaml').write_text(PROTOCOL)
    bench.until(lambda: 'ready' in truth.said(), 'the muscle is not there', 240.0)
    command = ['-m', 'tcp_muscle_ros.tool', 'run', str(tmp_path / 'protocol.yaml'), '--yes', '--namespace', 'truth']
    runs = [bench.run([*command, '--output', str(tmp_path / 'first')], 'run')]
    bench.until(lambda: runs[0].process.poll() is not None, 'the run does not end', 120.0)
    runs.append(bench.run([*command, '--output', str(tmp_path / 'second')], 'run'))
    bench.until(lambda: runs[1].process.poll() is not None, 'the run does not end', 120.0)
    assert [run.process.returncode for run in runs] == [0, 0], [run.said() for run in runs]

    case, _ = drawn(25, 0)
    done = as_experiment(read_protocol(tmp_path / 'protocol.yaml'), case.lab.ambient)
    dose = 0.0
    for number, name in enumerate(('first', 'second')):
        ideal, recorded = observe(case.bench, done, number, dose), read_bag(tmp_path / name)
        dose = ideal.dose
        for channel, offset in (('temperature', 273.15), ('displacement', 0.0)):
            count = len(done.time) - 1  # what flows from the last instant on is not the protocol's
            left = recorded[channel].value[1 : count + 1] - offset - getattr(ideal, channel)[:count]
            assert np.sqrt(np.mean(left**2)) == pytest.approx(case.noise[channel].sigma, rel=0.2), channel
        assert recorded['current'].value.max() == pytest.approx(0.12, abs=0.002)
    truth.kill()

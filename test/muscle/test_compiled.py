"""What is compiled ahead is what a start needs."""

import subprocess
import sys

AHEAD = 'from tcp_muscle_ros.muscle.__main__ import compile_ahead; compile_ahead()'
USE = """
import sys
import numpy as np
from tcp_muscle_ros.control.tracking import TrackingController
from tcp_muscle_ros.muscle import Muscle, Muscles, Parameters, length, simulate, tension

model = Parameters.named('karami_tadesse_2017').with_effects('creep', 'hysteresis', 'inertia', 'two_node')
Muscles([Muscle(model, load=0.5, end=end, spring_rate=10.0) for end in ('load', 'spring')]).step(0.01, [0.1, 0.1])
Muscle(model, end='blocked').step(0.01, 1.0, 'voltage')
simulate(model, np.arange(5) * 0.1, np.full(5, 0.1), load=[0.5] * 5, resolution=0.2)
TrackingController(model, 0.01, 0.27, 0.5, 300.0).update(0.01, displacement=0.0)
tension(model, float(length(model, 300.0, 0.2)), 310)
entries = {
    value
    for name, module in list(sys.modules.items()) if name.startswith('tcp_muscle_ros')
    for value in vars(module).values() if hasattr(value, 'py_func') and value.signatures
}
used = {entry.__name__: entry.stats for entry in entries if entry.stats.cache_hits or entry.stats.cache_misses}
print(sorted(used), sum(sum(stats.cache_misses.values()) for stats in used.values()))
"""


def test_after_compiling_ahead_nothing_is_compiled_when_a_node_or_a_fit_starts():
    subprocess.run([sys.executable, '-c', AHEAD], check=True, timeout=300)
    used = subprocess.run([sys.executable, '-c', USE], check=True, timeout=300, capture_output=True, text=True).stdout
    names = ('_invert', '_length', '_lengths', '_pull', 'advance', 'advance_many', 'reference_modulus', 'run', 'settle')
    assert used.strip() == f'{list(names)} 0'

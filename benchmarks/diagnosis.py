"""How long `tcp_muscle diagnose` takes, on one core and on two, and how much of it the model is.

    python benchmarks/diagnosis.py [--sizes small middle large]

The muscle in the recordings creeps and is cooled as air cools it, neither of which the paper's model knows; its sensors
are noisy. Each diagnosis is a process of its own that may use so many cores. The share of the model is the processor
time inside its compiled loop over a recording, of the processor time of the whole process.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from side_by_side import show

MUSCLE = """
/**:
  ros__parameters:
    hA: 0.021
    k0: 24.0
    effects: [creep, natural_convection]
    temperature_noise_k: 0.1
    resistance_noise_ohm: 0.01
    displacement_noise_m: 2.0e-5
    force_noise_n: 1.0e-3
    min_sense_current_a: 0.01
"""
SIZES = {  # recordings, seconds, Hz, aim in s on two cores
    'small': (3, 560, 20, 20),
    'middle': (1, 1800, 100, 60),
    'large': (1, 3600, 1000, 300),
}
LOADS = (0.5, 0.8, 0.35)  # N


def protocol(seconds: int, rate: int, load: float) -> str:
    """Steps of the paper's four currents, 25 s on and 45 s off, then a slow ramp with a change of the load."""
    segments = []
    for current in (0.18, 0.21, 0.24, 0.27):
        segments += [f'{{duration_s: 25, value: {current}}}', f'{{duration_s: 45, value: 0.012, load_n: {load}}}']
    segments += ['{duration_s: 140, value: [0.012, 0.25]}', f'{{duration_s: 70, value: 0.15, load_n: {1.3 * load}}}']
    segments += [f'{{duration_s: 70, value: 0.012, load_n: {load}}}']
    lines = [f'rate_hz: {rate}', 'input: current', 'end: load', f'repeat: {-(-seconds // 560)}', 'segments:']
    return '\n'.join([*lines, *(f'  - {segment}' for segment in segments)])


def role_diagnose(arguments: Sequence[str]) -> None:
    """Diagnose with the command line's own code; the last line is what it cost, as JSON."""
    from tcp_muscle_ros import tool
    from tcp_muscle_ros.muscle import stepping

    inside: list[float] = []
    whole = stepping.run

    def run(*given: Any) -> None:
        begin = time.thread_time()
        whole(*given)
        inside.append(time.thread_time() - begin)

    stepping.run = run
    begin = time.perf_counter()
    code = tool.main(['diagnose', *arguments])
    wall = time.perf_counter() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    share = sum(inside) / time.process_time()
    print(json.dumps({'code': code, 'wall': wall, 'cpu': time.process_time(), 'share': share, 'megabytes': peak}))


def diagnose(bags: Sequence[Path], output: Path, cores: int, limit: float) -> dict[str, float] | None:
    """One diagnosis in a process that may use so many cores; None if it takes longer than ``limit`` s."""
    allowed = sorted(os.sched_getaffinity(0))[:cores]
    try:
        done = subprocess.run(
            [sys.executable, __file__, '--role', *map(str, bags), '--output', str(output)],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False, timeout=limit,
            preexec_fn=lambda: os.sched_setaffinity(0, allowed),
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return None
    told: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    if told['code'] != 0:
        raise SystemExit(f'diagnosis.py: tcp_muscle diagnose ended with exit code {told["code"]}')
    return told


def main() -> None:
    """Simulate the recordings, diagnose them on one core and on two, print the table."""
    parser = argparse.ArgumentParser(description='How long a diagnosis takes.')
    parser.add_argument('--sizes', nargs='+', choices=SIZES, default=list(SIZES))
    parser.add_argument('--one-core', nargs='*', choices=SIZES, default=['small'], help='also on one core')
    parser.add_argument('--limit', type=float, default=1e4, help='seconds after which a diagnosis is given up')
    given = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory(prefix='diagnosis_') as name:
        folder = Path(name)
        (folder / 'muscle.yaml').write_text(MUSCLE)
        for size in given.sizes:
            count, seconds, rate, aim = SIZES[size]
            bags = []
            for number, load in zip(range(count), LOADS, strict=False):
                (folder / 'protocol.yaml').write_text(protocol(seconds, rate, load))
                bags.append(folder / f'{size}_{number}')
                command = ['-m', 'tcp_muscle_ros.tool', 'simulate', str(folder / 'protocol.yaml')]
                command += ['--params', str(folder / 'muscle.yaml'), '--output', str(bags[-1])]
                subprocess.run([sys.executable, *command], stdout=subprocess.DEVNULL, check=True)
            for cores in (1, 2) if size in given.one_core else (2,):
                told = diagnose(bags, folder / f'report_{size}_{cores}', cores, given.limit)
                length = f'{seconds} s' if seconds < 1800 else f'{seconds / 60:.0f} min'
                what = (f'{count} x {length} at {rate} Hz', str(cores))
                if told is None:
                    rows.append((*what, f'given up after {given.limit:.0f}', f'{aim}', '', '', ''))
                    continue
                cost = f'{told["cpu"]:.1f}', f'{told["share"]:.0%}', f'{told["megabytes"]:.0f}'
                rows.append((*what, f'{told["wall"]:.1f}', f'{aim}', *cost))
    columns = ('recordings', 'cores', 'time, s', 'aim, s', 'processor time, s', 'of it in the model', 'peak memory, MB')
    show('`tcp_muscle diagnose`, report and figures included', columns, rows)


if __name__ == '__main__':
    if sys.argv[1:2] == ['--role']:
        role_diagnose(sys.argv[2:])
    else:
        main()

"""A muscle, followed for a minute: python scripts/demo.py [--output FOLDER]

sim_node and controller_node run as two processes; setpoints (three steps, a sine, a release) under a load of 60 g are
recorded to an MCAP bag by `tcp_muscle record`; then the bag is read, a table printed and a picture drawn.
"""

import argparse
import math
import shutil
import sys
from pathlib import Path

import numpy as np

from tcp_muscle_ros.muscle import ZERO_CELSIUS, Parameters
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.recording import Recording
from tcp_muscle_ros.studies.tracking_session import Path as Followed
from tcp_muscle_ros.studies.tracking_session import Step, judge

LOAD = 0.060 * 9.80665  # N
LIMIT = 0.27  # A
NOISE = {'displacement_noise_m': 2e-5, 'temperature_noise_k': 0.1, 'resistance_noise_ohm': 5e-3}
SINE = (31.5, 63.5)  # s, begin and end: two periods
DURATION = 76.0  # s


def profile(t: float) -> float:
    """The setpoint (m) at a time (s)."""
    if SINE[0] <= t < SINE[1]:
        return 0.025 + 0.005 * math.cos(2.0 * math.pi * (t - SINE[0]) / 16.0)
    for until, target in ((2.5, 0.0), (12.5, 0.020), (23.5, 0.040), (SINE[0], 0.030)):
        if t < until:
            return target
    return 0.0


def run_session(bag: Path) -> dict[str, dict[str, str]]:
    """Run the processes; returns the nodes' last diagnostics."""
    from tcp_muscle_ros.nodes.session import Session

    common: dict[str, float | int | bool | str] = {'rate_hz': 100.0, 'load_n': LOAD, 'current_limit_a': LIMIT}
    print('starting sim_node, controller_node and the recorder (the first time, the model is compiled)', flush=True)
    with Session(bag, sim={**common, **NOISE}, controller=common) as session:
        session.follow(profile, DURATION, lambda t: show(t, session.displacement))
        print()
        return session.diagnostics


def show(t: float, displacement: float | None) -> None:
    """One line of progress a second, in place on a terminal."""
    x = math.nan if displacement is None else 1e3 * displacement
    line = f'{t:4.0f} of {DURATION:.0f} s   setpoint {1e3 * profile(t):5.1f} mm   measured {x:5.1f} mm'
    if sys.stdout.isatty():
        print('\r' + line, end='', flush=True)
    elif round(t) % 10 == 0:
        print(line, flush=True)


def print_table(
    recording: Recording, steps: list[Step], paths: list[Followed], diagnostics: dict[str, dict[str, str]]
) -> None:
    """What the session came to."""
    print(f'\n{"":24s}{"possible s":>12s}{"settled s":>12s}{"overshoot %":>13s}{"steady mm":>11s}')
    for step in steps:
        r = step.response
        name = f'{round(1e3 * r.start)} to {round(1e3 * r.target)} mm'
        under_way = math.isnan(r.settling_time)
        settled = 'cooling' if under_way else f'{r.settling_time:.2f}'
        steady = '' if under_way else f'{1e3 * r.steady_error:.3f}'
        print(f'{name:24s}{step.possible_time:12.2f}{settled:>12s}{100 * r.overshoot:13.2f}{steady:>11s}')
    for path in paths:
        errors = f'rms error {1e3 * path.rms_error:.3f} mm, largest {1e3 * path.largest_error:.3f} mm'
        print(f'{"sine 20 to 30 mm":24s}{errors}')
    peak = float(np.max(recording['temperature'].value)) - ZERO_CELSIUS
    print(f'peak temperature        {peak:.1f} degC, highest current {np.max(recording["current"].value):.3f} A')
    for node, values in sorted(diagnostics.items()):
        print(f'{node:24s}{values["missed_ticks"]} of {values["ticks"]} ticks late by a period or more')
    print('possible: when full current, or for a release passive cooling, enters the 2 % band. steady: the largest')
    print('error of the last 5 s, with the sensor noise of 0.02 mm in it.')


def draw(recording: Recording, path: Path) -> None:
    """Setpoint and displacement, temperature, current."""
    from tcp_muscle_ros.report.tracking_pictures import draw_followed

    title = f'A simulated TCP muscle under 60 g follows setpoints, at most {LIMIT} A'
    draw_followed(recording, path, title=title, current_limit=LIMIT, until=DURATION)


def main() -> int:
    """Run, read, print, draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--output', type=Path, default=Path('demo'), help='folder for bag and picture')
    output: Path = parser.parse_args().output
    bag = output / 'bag'
    if bag.exists():
        shutil.rmtree(bag)  # of the last demo
    output.mkdir(parents=True, exist_ok=True)
    try:
        diagnostics = run_session(bag)
    except KeyboardInterrupt:
        print('\ninterrupted')
        return 130
    recording = read_bag(bag)
    steps, paths = judge(recording, Parameters.named('karami_tadesse_2017'), LIMIT, LOAD)
    print_table(recording, steps, paths, diagnostics)
    draw(recording, output / 'demo.png')
    print(f'bag {bag}\npicture {output / "demo.png"}')
    return 0


if __name__ == '__main__':
    sys.exit(main())

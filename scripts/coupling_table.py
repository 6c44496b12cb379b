"""Where the energy of a minute goes, and how the coupling's error falls with the step: the table of docs/robots.md.

    python scripts/coupling_table.py [--seconds 60]

The arm, with currents in its four muscles that are drawn anew every half second. Needs MuJoCo (extra ``mujoco``).
"""

import argparse
import sys

import numpy as np

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Muscle, Parameters
from tcp_muscle_ros.robots.models import load
from tcp_muscle_ros.robots.robot import Robot

PAPER = Parameters.named('karami_tadesse_2017')
NAMES = [f'{joint}_{role}' for joint in ('shoulder', 'elbow') for role in ('flexor', 'extensor')]
STEPS = (0.01, 0.005, 0.0025, 0.00125)  # s
HELD, CURRENT = 0.5, 0.27  # s, A: how long a current is held, and the largest


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seconds', type=float, default=60.0)
    seconds: float = parser.parse_args().seconds
    print('| step, ms | Joule heat, J | lost, J | stored heat, J | by heat to work, mJ | stored elastic, mJ ', end='')
    print('| work on the robot, mJ | error, mJ | % of the work | % of the input |')
    print('|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|')
    try:
        for step in STEPS:
            model = load('arm')
            model.opt.timestep = step
            robot = Robot(model, {name: Muscle(PAPER, end='blocked', load=0.4) for name in NAMES})
            for currents in np.random.default_rng(5).uniform(0.0, CURRENT, (round(seconds / HELD), 4)):
                robot.advance(HELD, currents)
            book = robot.book()
            heat = f'{book.heated:.2f} | {book.lost:.2f} | {book.stored_heat:.2f}'
            work = f'{1e3 * book.by_heat:.3f} | {1e3 * book.stored_elastic:.3f} | {-1e3 * book.work:.3f}'
            error = f'{1e3 * book.work_error:.5f} | {100 * book.work_error / book.by_heat:.4f} | {100 * book.error:.6f}'
            print(f'| {1e3 * step:g} | {heat} | {work} | {error} |', flush=True)
    except BadInput as problem:
        print(f'coupling_table: {problem}', file=sys.stderr)
        return 2
    return 0


if __name__ == '__main__':
    sys.exit(main())

"""The arm in closed loop with muscles that are not as its controllers believe: the table of docs/robots.md.

    python scripts/arm_table.py [--draws 20] [--spread 0.2] [--seed 1]

Both joints are turned twice. For each: the time until the angle stays within 5 % of the step, beside the time in which
full current in one muscle of each joint and none in the other gets as far (the physical limit, up to what the joints'
weights do to each other); and the worst of the four turns: how far past the setpoint, and what was missing in the end.
In every draw each of the four muscles has values of its own. Needs MuJoCo.
"""

import argparse
import sys

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.robots.controlled import ControlledRobot

PAPER = Parameters.named('karami_tadesse_2017')
DRAWN = ('hA', 'k0', 'R0', 'm', 'B')
STEPS = ((0.4, 0.5), (-0.2, -0.4))  # rad: shoulder, elbow
LONG, COCONTRACTION, CURRENT, NEAR = 16.0, 0.7, 0.27, 0.05  # s, N, A, share of a step
Array = NDArray[np.float64]


def draw(chance: np.random.Generator, spread: float) -> dict[str, Parameters]:
    """Four muscles, each value of DRAWN off by up to ``spread``."""
    names = [f'{joint}_{role}' for joint in ('shoulder', 'elbow') for role in ('flexor', 'extensor')]
    return {
        name: PAPER.replace({key: PAPER[key] * chance.uniform(1.0 - spread, 1.0 + spread) for key in DRAWN})
        for name in names
    }


def turned(muscles: dict[str, Parameters], steps: int, all_out: bool) -> Array:
    """The angles (rad), shape (n, 2), over the last of so many steps; ``all_out``: driven by full current there."""
    arm = ControlledRobot('arm', PAPER, muscles)
    ticks = round(LONG / arm.period)
    angles = np.empty((ticks, 2))
    for number, setpoint in enumerate(STEPS[:steps]):
        full = np.array(
            [CURRENT * (going == (role == 0)) for going in np.greater(setpoint, arm.angles) for role in (0, 1)]
        )
        for k in range(ticks):
            if all_out and number == steps - 1:
                arm.robot.advance(arm.period, full)
            else:
                arm.tick(setpoint, (COCONTRACTION, COCONTRACTION))
            angles[k] = arm.angles
    return angles


def row(muscles: dict[str, Parameters], number: int) -> Array:
    """Of step ``number``: settled (s), limit (s), past (share of the step), missing (mrad), each for both joints."""
    angles, fastest = turned(muscles, number, False), turned(muscles, number, True)
    before = np.array(STEPS[number - 2]) if number > 1 else np.zeros(2)
    target, found = np.array(STEPS[number - 1]), []
    for joint in (0, 1):
        size = target[joint] - before[joint]
        done, quick = ((path[:, joint] - before[joint]) / size for path in (angles, fastest))
        outside = np.flatnonzero(np.abs(done - 1.0) > NEAR)
        there = np.flatnonzero(quick >= 1.0 - NEAR)
        found.append(
            (
                0.01 * (outside[-1] + 1),
                0.01 * (there[0] + 1) if there.size else np.inf,
                max(done.max() - 1.0, 0.0),
                1e3 * abs(angles[-1, joint] - target[joint]),
            )
        )
    return np.array(found)


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--draws', type=int, default=20)
    parser.add_argument('--spread', type=float, default=0.2, help='by which values are off at most, as a share')
    parser.add_argument('--seed', type=int, default=1)
    given = parser.parse_args()
    chance = np.random.default_rng(given.seed)
    print('| muscles | shoulder, 1st | elbow, 1st | shoulder, 2nd | elbow, 2nd | past, % | missing, mrad |')
    print('|---|---:|---:|---:|---:|---:|---:|')
    found = []
    try:
        for k in range(given.draws + 1):
            muscles = draw(chance, given.spread) if k else {}
            both = np.array([row(muscles, number) for number in (1, 2)])
            if k:
                found.append(both)
            times = ' | '.join(f'{settled:.2f} / {limit:.2f}' for settled, limit, *_ in both.reshape(4, 4))
            worst = f'{100.0 * both[..., 2].max():.1f} | {both[..., 3].max():.2f}'
            print(f'| {f"draw {k}" if k else "as assumed"} | {times} | {worst} |', flush=True)
    except BadInput as problem:
        print(f'arm_table: {problem}', file=sys.stderr)
        return 2
    if found:
        all_of_them = np.array(found)
        ratio = all_of_them[..., 0] / all_of_them[..., 1]
        past, missing = 100.0 * all_of_them[..., 2].max(), all_of_them[..., 3].max()
        usual = np.sort(ratio.ravel())[int(0.9 * ratio.size)]
        print(
            f'\n{given.draws} draws, {ratio.size} turns: settled after {np.median(ratio):.2f} times the limit in the '
            f'middle, {usual:.2f} in nine of ten, {ratio.max():.2f} at most; past the setpoint by {past:.1f} % at '
            f'most; {missing:.2f} mrad missing in the end at most'
        )
    return 0


if __name__ == '__main__':
    sys.exit(main())

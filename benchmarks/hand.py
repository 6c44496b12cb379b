"""One process with the muscles of a hand, beside a process for each, beside a bare loop that publishes the same.

    python benchmarks/hand.py [--duration 8]

100 Hz; seven topics a muscle and one of all joints, a subscriber on each. See ``publishing.py`` for how it is measured.
"""

import argparse

from publishing import Load, measure
from side_by_side import show

from tcp_muscle_ros.muscle.__main__ import compile_ahead

RATE = 100.0  # Hz


def main() -> None:
    """16 and 64 muscles, one after the other; print the table."""
    parser = argparse.ArgumentParser(description='Many muscles in one process, beside a process for each.')
    parser.add_argument('--duration', type=float, default=8.0, help='s measured, each')
    parser.add_argument('--domain', type=int, default=95, help='ROS_DOMAIN_ID')
    given = parser.parse_args()
    compile_ahead()
    rows = []
    for count, roles in ((16, ('bare', 'sim', 'sims')), (64, ('bare', 'sim'))):
        floor = None
        for role in roles:
            name = {'bare': 'least: bare loop', 'sim': 'ours: one sim_node', 'sims': f'{count} sim_nodes'}[role]
            try:
                result = measure(role, Load(count, RATE), given.duration, given.domain)
            except ChildProcessError as reason:
                print(f'Skipped: {count} muscles, {name}: {reason}\n')
                continue
            floor = floor or result
            rows.append(
                (
                    f'{count} muscles, {name}', f'{result.in_time:.1%}', f'{result.p50:.0f}', f'{result.p99:.0f}',
                    f'{result.cpu:.1%}', f'{result.cpu / floor.cpu:.2f}', f'{result.megabytes:.0f}',
                )
            )  # fmt: skip
    columns = ('', 'ticks in time', 'late p50, us', 'p99, us', 'of a core', 'over least', 'memory, MB')
    show(f'Many muscles at {RATE:g} Hz, {given.duration:g} s each (aim: CPU 1.3 of the least)', columns, rows)


if __name__ == '__main__':
    main()

"""How well sim_node keeps its rate, and what it costs, beside a bare loop that publishes the same messages.

    python benchmarks/node_rate.py [--duration 8] [--rates 100 1000 2000]

One muscle, seven topics, a subscriber on each. See ``publishing.py`` for how it is measured.
"""

import argparse

from publishing import Load, measure
from side_by_side import show

from tcp_muscle_ros.muscle.__main__ import compile_ahead


def main() -> None:
    """One after the other at every rate; print the table."""
    parser = argparse.ArgumentParser(description='How well sim_node keeps its rate, beside a bare loop.')
    parser.add_argument('--rates', type=float, nargs='+', default=[100.0, 1000.0, 2000.0], help='Hz')
    parser.add_argument('--duration', type=float, default=8.0, help='s measured, each')
    parser.add_argument('--domain', type=int, default=94, help='ROS_DOMAIN_ID')
    given = parser.parse_args()
    compile_ahead()
    rows = []
    for rate in given.rates:
        floor = None
        for role, name in (('bare', 'least: bare loop'), ('sim', 'ours: sim_node')):
            result = measure(role, Load(0, rate), given.duration, given.domain)
            floor = floor or result
            rows.append(
                (
                    f'{rate:g} Hz, {name}', f'{result.in_time:.2%}', f'{result.p50:.0f}', f'{result.p99:.0f}',
                    f'{result.p99 / floor.p99:.2f}', f'{result.cpu:.1%}', f'{result.cpu / floor.cpu:.2f}',
                )
            )  # fmt: skip
    columns = ('', 'ticks in time', 'late p50, us', 'p99, us', 'over least', 'of a core', 'over least')
    show(f'sim_node beside a bare loop, {given.duration:g} s each (aims: p99 1.5, CPU 1.3 of the least)', columns, rows)


if __name__ == '__main__':
    main()

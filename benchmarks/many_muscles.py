"""Muscles stepped together, beside one Python object each.

    python benchmarks/many_muscles.py

Steps of 10 ms. Together as arrays (`Muscles.advance`), together with a Reading for each (`Muscles.step`, as sim_node
calls it), and one `Muscle.step` after the other. The least work is one read and one write of the rows of outputs.
"""

import numpy as np
from side_by_side import Contender, in_turns, show

from tcp_muscle_ros.muscle import Muscle, Muscles, Parameters

PAPER = Parameters.named('karami_tadesse_2017')
FIVE = PAPER.with_effects('natural_convection', 'radiation', 'creep', 'hysteresis', 'thermocouple_lag')
PERIOD = 0.01  # s
STEPS = 40_960  # muscle-steps a turn


def contenders(model: Parameters, count: int) -> list[Contender]:
    """The least work and three ways to step so many muscles; every run is STEPS muscle-steps."""
    ticks = max(1, STEPS // count)
    currents = np.linspace(0.1, 0.25, count)
    arrays, readings = (Muscles([Muscle(model, load=0.5) for _ in range(count)]) for _ in range(2))
    alone = [Muscle(model, load=0.5) for _ in range(count)]
    rows = np.zeros((2, *arrays.advance(0.0, currents).shape))
    each = currents.tolist()

    def copy() -> None:
        for _ in range(ticks):
            np.copyto(rows[1], rows[0])

    def as_arrays() -> None:
        for _ in range(ticks):
            arrays.advance(PERIOD, currents)

    def as_readings() -> None:
        for _ in range(ticks):
            readings.step(PERIOD, each)

    def one_by_one() -> None:
        for _ in range(ticks):
            for muscle, current in zip(alone, each, strict=True):
                muscle.step(PERIOD, current)

    return [
        Contender('least: rows read and written', copy),
        Contender('ours: together, arrays', as_arrays),
        Contender('ours: together, readings', as_readings),
        Contender('one Python object each', one_by_one, repeats=3),
    ]


def main() -> None:
    """One table a model: million muscle-steps a second, by number of muscles."""
    counts = (1, 16, 256, 4096)
    for model, name in ((PAPER, "the paper's model"), (FIVE, 'with five effects')):
        measured = [in_turns(contenders(model, count)) for count in counts]
        rate = {
            (row.name, count): (max(1, STEPS // count) * count) / row.seconds / 1e6
            for count, rows in zip(counts, measured, strict=True)
            for row in rows
        }
        names = [row.name for row in measured[0]]
        show(
            f'Million muscle-steps a second on one core, {name}',
            ('muscles', *map(str, counts)),
            [(name, *(f'{rate[name, count]:.2f}' for count in counts)) for name in names],
        )


if __name__ == '__main__':
    main()

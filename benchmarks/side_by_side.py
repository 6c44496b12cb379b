"""What every benchmark here shares: contenders timed in turns within one run, and Markdown tables of the results.

A figure of one run on one machine says little; the ratio of two figures that were taken in turns says how they compare.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Contender:
    """One way to do the work.

    run      does it, and returns what is to be compared; None if it cannot be done here
    share    of the work that it is given, because all of it would take too long
    repeats  the best of so many counts, after a first one that compiles and warms up; 1: that one counts
    reason   why ``run`` is None
    """

    name: str
    run: Callable[[], Any] | None
    share: float = 1.0
    repeats: int = 7
    reason: str = ''


@dataclass(frozen=True)
class Measured:
    """The contender, the shortest time (s, for all of the work), and what it returned."""

    contender: Contender
    seconds: float
    result: Any

    @property
    def name(self) -> str:
        """The contender's name, with the share of the work that it was given."""
        share = self.contender.share
        return self.contender.name + (f' (on {share:.1%})' if share < 1.0 else '')


def in_turns(contenders: Sequence[Contender], clock: Callable[[], float] = time.thread_time) -> list[Measured]:
    """Time all of them in turns. ``clock``: processor time of this thread, or ``time.perf_counter`` where disks count.

    Who cannot run is named on stdout with the reason, and left out.
    """
    best: dict[str, Measured] = {}
    able = [one for one in contenders if one.run is not None]
    for turn in range(max(one.repeats for one in able) + 1):
        for one in able:
            if turn > (one.repeats if one.repeats > 1 else 0):
                continue
            assert one.run is not None
            start = clock()
            result = one.run()
            seconds = (clock() - start) / one.share
            before = best.get(one.name)
            if before is None or turn == 1 or seconds < before.seconds:
                best[one.name] = Measured(one, seconds, result)
    for one in contenders:
        if one.run is None:
            print(f'Skipped: {one.name}: {one.reason}.\n')
    return [best[one.name] for one in able]


def show(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], note: str = '') -> None:
    """One Markdown table on stdout, that a terminal shows aligned."""
    widths = [max(len(row[k]) for row in (columns, *rows)) for k in range(len(columns))]

    def line(cells: Sequence[str]) -> str:
        first, *rest = zip(cells, widths, strict=True)
        return f'| {first[0]:{first[1]}} | ' + ' | '.join(f'{cell:>{width}}' for cell, width in rest) + ' |'

    print(f'**{title}**\n')
    print(line(columns))
    print(f'|{"-" * (widths[0] + 2)}|' + '|'.join('-' * (width + 1) + ':' for width in widths[1:]) + '|')
    for row in rows:
        print(line(row))
    print(f'\n{note}\n' if note else '', flush=True)

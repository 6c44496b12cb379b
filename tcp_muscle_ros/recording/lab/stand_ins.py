"""Numbers that an instrument or a program writes where it has none: -999.9, 9.9E+37, or the end of its range."""

import math
import re
from collections import Counter
from collections.abc import Sequence

from tcp_muscle_ros.recording.lab.cells import number
from tcp_muscle_ros.recording.recording import DRIVES

_NINES = re.compile(r'[+-]?9{3,}(?:[.,][09]*)?')
_OVERFLOW = re.compile(r'[+-]?[19](?:[.,]\d*)?e\+?3[78]', re.I)
_FAR = 3.0  # spans of all that is measured, that it lies beyond it
_MOVES = 20  # different numbers in a column that moves
_GRADUAL = ('temperature', 'ambient', 'resistance')  # nothing moves them at once
_SWITCHED = (*DRIVES, 'load')  # may go between two values
_LEVEL = 20.0  # times the other value, where that is none of a drive that is off


def stand_ins(cells: Sequence[str], decimal: str, kind: str = '') -> frozenset[str]:
    """The texts of a column that are such numbers: nines, or an overflow, far from everything that was measured.

    Of what moves gradually, by the ``kind`` of the column, also the largest or smallest number that stands there, where
    it comes again and again and nothing comes near it: a thermometer that is open shows the end of its range. Of what
    may be switched, nines beside one other number are a level: a drive that is off, or gives 999 mA.
    """
    ends = _ends(cells, decimal) if kind in _GRADUAL else ()
    odd = {
        cell: value
        for cell in set(cells)
        if (_NINES.fullmatch(cell) or _OVERFLOW.fullmatch(cell) or cell in ends)
        and (value := number(cell, decimal)) is not None
    }
    rest = [value for cell in cells if cell not in odd and (value := number(cell, decimal)) is not None] if odd else []
    if len(rest) < 2:
        return frozenset()
    span = max(rest) - min(rest)
    if span == 0.0 and kind in _SWITCHED:
        most = _LEVEL * abs(rest[0]) or math.inf
        odd = {cell: value for cell, value in odd.items() if not 0.0 <= value <= most or _OVERFLOW.fullmatch(cell)}
    margin = _FAR * span
    return frozenset(cell for cell, value in odd.items() if not min(rest) - margin <= value <= max(rest) + margin)


def _ends(cells: Sequence[str], decimal: str) -> list[str]:
    """The texts of the largest and the smallest number of a column, if they come more than once."""
    count = Counter(cells)
    values = {cell: value for cell in count if (value := number(cell, decimal)) is not None}
    if len(values) < _MOVES:
        return []
    return [
        cell for cell in {max(values, key=values.__getitem__), min(values, key=values.__getitem__)} if count[cell] > 1
    ]

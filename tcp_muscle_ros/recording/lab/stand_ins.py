"""Numbers that an instrument or a program writes where it has none: -999.9, 9.9E+37."""

import re
from collections.abc import Sequence

from tcp_muscle_ros.recording.lab.cells import number

_NINES = re.compile(r'[+-]?(?:9{3,}(?:[.,][09]*)?|[19](?:[.,]\d*)?e\+?3[78])', re.I)
_FAR = 3.0  # spans of all that is measured, that it lies beyond it


def stand_ins(cells: Sequence[str], decimal: str) -> frozenset[str]:
    """The texts of a column that are such numbers: nines, or an overflow, far from everything that was measured."""
    odd = {
        cell: value for cell in set(cells) if _NINES.fullmatch(cell) and (value := number(cell, decimal)) is not None
    }
    rest = [value for cell in cells if cell not in odd and (value := number(cell, decimal)) is not None] if odd else []
    if len(rest) < 2:
        return frozenset()
    margin = _FAR * (max(rest) - min(rest))
    return frozenset(cell for cell, value in odd.items() if not min(rest) - margin <= value <= max(rest) + margin)

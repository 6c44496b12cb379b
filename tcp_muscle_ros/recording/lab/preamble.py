"""What stands above a table in words: the period of its rows, the length of the muscle."""

import re
from collections.abc import Sequence

from tcp_muscle_ros.recording.lab.cells import number
from tcp_muscle_ros.recording.lab.grid import Row
from tcp_muscle_ros.recording.lab.headings import plain
from tcp_muscle_ros.recording.lab.unit_names import unit_named
from tcp_muscle_ros.recording.units import UNITS

_RATE = re.compile(
    r'(?:sampl\w*|abtast\w*|scan|data|logging)?[ _]*(?:rate|frequency|freq|frequenz)\W{0,4}([\d.,]+)\s*(k?hz|/s|sps)',
    re.I,
)
_INTERVAL = re.compile(
    r'(?:interval\w*|\w*intervall|\w*period\w*|間隔|delta[_ ]?[xt]|\bdt)\W{0,6}([\d.,]+)\s*([^\W\d]+)', re.I
)
_DELTA = re.compile(r'delta_x\s+([\d.,]+(?:e[+-]?\d+)?)', re.I)  # LabVIEW, where the X dimension is the time
_LENGTH = re.compile(r'\b(?:length|länge|longueur|longitud|lunghezza)\b[^\d]*([\d.,]+)\W*(\w+)', re.I)


def sampled_every(preamble: Sequence[Row]) -> float | None:
    """The period (s) that is written above a table, as "Sample rate: 20 Hz" or "Intervall: 100 ms"."""
    lines = [plain(' '.join(row.cells)) for row in preamble]
    for line in lines:
        found = _INTERVAL.search(line)
        if found:
            unit, value = unit_named(found[2]), _number(found[1])
            if unit and value and UNITS[unit].quantity == 'time':
                return UNITS[unit].to_si(value)
        found = _RATE.search(line)
        if found and (value := _number(found[1])):
            return 1.0 / (value * (1000.0 if found[2].lower() == 'khz' else 1.0))
    if any(re.match(r'x_dimension time', line, re.I) for line in lines):
        found = next((match for line in reversed(lines) if (match := _DELTA.search(line))), None)
        return _number(found[1]) if found else None
    return None


def rest_length(preamble: Sequence[Row]) -> float | None:
    """The length (m) of the muscle that is written above a table."""
    for row in preamble:
        found = _LENGTH.search(plain(' '.join(row.cells)))
        unit, value = (unit_named(found[2]), _number(found[1])) if found else (None, None)
        if unit and value and UNITS[unit].quantity == 'length':
            return UNITS[unit].to_si(value)
    return None


def _number(text: str) -> float | None:
    return number(text) or number(text, ',')

"""What stands above a table in words: the period of its rows, the length of the muscle, what hangs on it, the room."""

import re
from collections.abc import Iterator, Sequence

from tcp_muscle_ros.recording.lab.cells import number
from tcp_muscle_ros.recording.lab.grid import Row
from tcp_muscle_ros.recording.lab.headings import one_word, plain
from tcp_muscle_ros.recording.lab.unit_names import unit_named
from tcp_muscle_ros.recording.plausibility import ROOM
from tcp_muscle_ros.recording.units import UNITS

_RATE = re.compile(
    r'(?:sampl\w*|abtast\w*|scan|data|logging)?[ _]*(?:rate|frequency|freq|frequenz)\W{0,4}([\d.,]+)\s*(k?hz|/s|sps)',
    re.I,
)
_INTERVAL = re.compile(
    r'(?:interval\w*|\w*intervall|\w*period\w*|間隔|delta[_ ]?[xt]|\bdt)\W{0,6}([\d.,]+)\s*([^\W\d]+)', re.I
)
# What tells that a rate or a period is that of the rows, and that it is that of what was imposed.
_OF_ROWS = re.compile(r'sampl|abtast|scan|\blog|data|delta|\bdt\b|mess|acqui|échant|muestr|campion|采样', re.I)
_OF_DRIVE = re.compile(
    r'heat|heiz|chauff|driv|cycl|zykl|signal|pwm|square|rechteck|\bsin(e|us\w*)?\b|wave|duty|puls|anreg|excit', re.I
)
_SAID = re.compile(r'(?:sampl|abtast|scan|logg)\w*(?:[ _-]*$|[ _]*(?:rate|freq))', re.I)  # just before a number
_ALIKE = 0.01  # of a period: so near are two of one rate
_DELTA = re.compile(r'delta_x\s+([\d.,]+(?:e[+-]?\d+)?)', re.I)  # LabVIEW, where the X dimension is the time
# Words that begin a line, a unit in brackets perhaps, a number, a unit perhaps.
_STATED = re.compile(
    r'[\W_]*(?P<words>[^\W\d](?:[^\d=:;\[(<]|(?<=[LHlh])0)*)(?:[\[(<](?P<of>[^\])>]*)[\])>])?[\s=:;,~≈]*'
    r'(?P<number>[+-]?[\d.,]+)[\s;]*(?P<unit>[^\W\d]+|°\s?[CF])?\W*'
)
_LENGTHS = 'length länge longueur longitud lunghezza comprimento lengte L0 H0 l0 長さ 试样长度 длина'
_LOADS = (
    'load weight mass gewicht last belastung zuglast masse charge carico carga massa masa peso gewichtskraft hanging '
    'belasting 荷重 重り 负载 负荷 нагрузка груз'
)
_ROOMS = 'room ambient raumtemperatur umgebungstemperatur raum ambiante ambiente kamertemperatuur 室温'
# Of the fibre before it was coiled, of what an instrument can bear.
_OF_OTHERS = (
    'fibre fiber faser faden filament thread wire cable cell sensor max maximum '
    'min capacity range limit pre preload pretension vorlast'
)
_PRELOADS = 'preload pretension vorlast vorspannung vorspannkraft vorkraft précharge precarico precarga'
_OF_MUSCLE = 'muscle muskel sample specimen probe'  # whose length is the muscle's, and whose weight hangs nowhere
_WITHIN = re.compile(r'[^\W\d_]+0?(?:\s*[\[(<][^\])>]*[\])>])?\s*[=:]\s*[+-]?[\d.,]+\s*[^\W\d]*')
_HANGS = (0.02, 50.0)  # N
_RESTS = (0.005, 2.0)  # m


def sampled_every(preamble: Sequence[Row]) -> float | None:
    """The period (s) that is written above a table, as "Sample rate: 20 Hz" or "Intervall: 100 ms".

    What is called a rate of samples comes before any other; None where two unlike ones are left.
    """
    lines = [plain(' '.join(row.cells)) for row in preamble]
    stated = [each for line in lines for each in _periods(line)]
    periods = [period for period, of_rows in stated if of_rows] or [period for period, _ in stated]
    if periods:
        return periods[0] if max(periods) - min(periods) <= _ALIKE * periods[0] else None
    if any(re.match(r'x_dimension time', line, re.I) for line in lines):
        found = next((match for line in reversed(lines) if (match := _DELTA.search(line))), None)
        return _number(found[1]) if found else None
    return None


def _periods(line: str) -> Iterator[tuple[float, bool]]:
    """The periods (s) that a line states, but for those of what was imposed ("Heating frequency: 0.05 Hz"), and whether
    each is said to be that of the samples."""
    found = sorted([*_INTERVAL.finditer(line), *_RATE.finditer(line)], key=lambda match: match.start())
    for begins, match in zip([0, *(each.end() for each in found)], found, strict=False):
        before, after = line[begins : match.start()], line[match.end() :] if match is found[-1] else ''
        own = re.split(r'[;,]\s', before)[-1] + match[0]
        of_rows = bool(_OF_ROWS.search(own))
        around = own if of_rows else before + match[0] + after
        period, said = _period(match), bool(_SAID.search(before) or _SAID.match(match[0]))
        if period and (said or not _OF_DRIVE.search(around)):
            yield period, of_rows


def _period(match: re.Match[str]) -> float | None:
    """The period (s) of a number and its unit; None where that is no time and no rate."""
    value = _number(match[1])
    if match.re is _RATE:
        return 1.0 / (value * (1000.0 if match[2].lower() == 'khz' else 1.0)) if value else None
    unit = unit_named(match[2])
    return UNITS[unit].to_si(value) if value and unit and UNITS[unit].quantity == 'time' else None


def rest_length(preamble: Sequence[Row]) -> float | None:
    """The length (m) of the muscle that is written above a table."""
    return _stated(preamble, _LENGTHS, 'length', _RESTS)


def hanging_load(preamble: Sequence[Row]) -> float | None:
    """What hangs on the muscle (N), as is written above a table: "Belastung: 60 g"."""
    return _stated(preamble, _LOADS, 'force', _HANGS)


def load_before(preamble: Sequence[Row]) -> float | None:
    """What pulled at a muscle (N) before its end was held, as is written above a table: "Preload: 60 g", or "Load"."""
    preload = _stated(preamble, _PRELOADS, 'force', _HANGS)
    return hanging_load(preamble) if preload is None else preload


def room_temperature(preamble: Sequence[Row]) -> float | None:
    """The room (K) that is written above a table."""
    return _stated(preamble, _ROOMS, 'temperature', ROOM)


def _stated(preamble: Sequence[Row], known: str, quantity: str, likely: tuple[float, float]) -> float | None:
    """The one value (SI) of a quantity that lines with such words state; None where they state none, or several."""
    values = set()
    for part in (part for row in preamble for part in _parts(row)):
        found = _STATED.fullmatch(part)
        words = re.findall(r'[^\W\d_]+0?', one_word(found['words'])) if found else []
        lower = {word.lower() for word in words}
        others = {*_OF_OTHERS.split(), *(() if quantity == 'length' else _OF_MUSCLE.split())}
        if not found or not ({*words, *lower} & {*known.split()}) or lower & (others - {*known.split()}):
            continue
        unit, value = unit_named(found['of'] or found['unit'] or ''), _number(found['number'])
        if unit and value and UNITS[unit].quantity == quantity:
            values.add(UNITS[unit].to_si(value))
    (one,) = values if len(values) == 1 else (None,)
    return one if one is not None and likely[0] <= one <= likely[1] else None


def _parts(row: Row) -> set[str]:
    """A line as a whole, and each thing that it states: "fs = 10 Hz, weight 100 g"."""
    line = plain(' '.join(row.cells))
    whole = {line, *re.split(r'[;,]\s+', line), *map(plain, row.cells)}
    return whole if any(map(_STATED.fullmatch, whole)) else whole | {*_WITHIN.findall(line)}


def _number(text: str) -> float | None:
    return number(text) or number(text, ',')

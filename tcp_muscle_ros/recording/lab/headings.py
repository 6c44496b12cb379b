"""What a heading means: a channel of the muscle, the time, or neither, and its unit; in the languages of labs."""

import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

from tcp_muscle_ros.recording.lab.unit_names import unit_named
from tcp_muscle_ros.recording.units import UNITS

# A word that begins so says what is measured. Longer words come first where one begins as another does.
_BEGINNINGS = {
    'time': 'time zeit uhrzeit datum date prüfzeit temps tiempo tempo elapsed epoch timestamp stamp clock seconds '
    'second millis micros 時間 時刻 经过 時分 时间 日付 経過 秒',
    'temperature': 'temperat températ temp thermo tc 温度 糸温 coilt',
    'ambient': 'ambient amb room raum luft air umgebung ambiance ambiente chamber 室温 環境 外気 环境',
    'resistance': 'resist résist widerst 抵抗 电阻 電阻',
    'current': 'current strom heizstrom intensit courant corrente corriente amper 電流 电流',
    'voltage': 'voltage volt spannung tensione voltaje 電圧 电压 印加電',
    'power': 'power leistung heizleistung puissance potenza potencia watt heater 電力 功率',
    'elongation': 'extension elongation dehnung verlängerung allongement allungamento 伸び 伸長 伸长 Δl δl',
    'length': 'length länge laenge longueur lunghezza longitud 長さ 全長 长度',
    'displacement': 'disp stroke weg hub position pos déplac deplac spost desplaz laser encoder contraction '
    'kontraktion verfahrweg standardweg travel 変位 位移 収縮',
    'force': 'force kraft effort forza fuerza loadcell standardkraft 張力 拉力 力',
    'load': 'load last weight gewicht mass masse charge carico carga hanging 荷重 负载 负荷 重り',
}
# A symbol that stands for itself; case counts.
_SYMBOLS = {
    'time': 't',
    'temperature': 'T ϑ θ Theta theta',
    'resistance': 'R',
    'current': 'I i',
    'voltage': 'U V u v',
    'power': 'P p',
    'displacement': 'x X s dx d',
    'elongation': 'dL dl',
    'length': 'L l',
    'force': 'F f Fz Fx',
}
_WHOLE = frozenset(
    ['tc', 'force', 'pos', 'hub', 'air', 'amb', 'last', 'masse', 'mass', 'weg', 'date', 'time', 'tempo', 'temps']
)  # no beginnings
_MODIFIERS = {
    'commanded': 'set soll cmd command commanded target setpoint sollwert 設定 consigne',
    'muscle': 'muscle muskel coil wire draht drahttemp specimen fibre fiber sample probe tcp tca muscolo fil yarn '
    '糸 筋肉',
}
_ROLES = {
    'index': 'index no nr number sample scan sequence 番号 point n lfd frame row id',
    'run': 'run trial versuch test experiment series serie lauf repeat rep essai prova 試行',
    'unit': 'unit units einheit 単位',
}
_QUANTITY = {
    'time': 'time',
    'temperature': 'temperature',
    'ambient': 'temperature',
    'resistance': 'resistance',
    'current': 'current',
    'voltage': 'voltage',
    'power': 'power',
    'elongation': 'length',
    'length': 'length',
    'displacement': 'length',
    'force': 'force',
    'load': 'force',
}
_SURE = 2
_OF_QUANTITY = {'length': 'displacement'}
_BRACKETS = re.compile(r'(.*?)[\[(<{]([^\])>}]*)[\])>}](.*)')
_TAIL = re.compile(r'(.*[^\W_]|.*\W)[_\s.,:-]+([^\s_,:-]+)')


@dataclass(frozen=True)
class Meaning:
    """What a column is.

    kind  a channel, ``time``, ``length`` (contraction is what it shrinks by), ``elongation`` (positive when longer),
          ``index``, ``run``, ``unit``, ``fraction`` (of a second); '' where nobody could say
    unit  a name of ``units.UNITS``, None where the heading has none
    """

    kind: str
    unit: str | None = None
    commanded: bool = False
    of_muscle: bool = False


def plain(text: str) -> str:
    """A text with full-width signs and letters as ordinary ones, and single spaces."""
    return ' '.join(unicodedata.normalize('NFKC', text).split())


def meaning(heading: str, more: str = '', unit_cell: str = '') -> Meaning:
    """What a heading means.

    ``more``: what is written of the column elsewhere, in a table of channels for example; ``unit_cell``: what stands in
    a row of units.
    """
    name, unit, sure = _split(plain(heading))
    if unit_named(unit_cell):
        unit, sure = unit_named(unit_cell), _SURE
    words = _words(f'{name} {plain(more)}')
    alone = _kind(words, None)
    if unit and sure < _SURE and _QUANTITY.get(alone, UNITS[unit].quantity) != UNITS[unit].quantity:
        unit = None  # T_min is no time
    kind = _kind(words, unit)
    if unit and kind != 'fraction' and _QUANTITY.get(kind) != UNITS[unit].quantity:
        kind, unit = (_by_unit(unit, words), unit) if sure else (kind, None)
    if kind == 'temperature' and _any(words, 'ambient', _BEGINNINGS):
        kind = 'ambient'
    return Meaning(kind, unit, _exactly(words, 'commanded'), _any(words, 'muscle', _MODIFIERS))


def known_words(text: str) -> int:
    """How often words that a lab writes, and that ASCII cannot, are in a text: the right encoding has the most."""
    found = unicodedata.normalize('NFKC', text).lower()
    words = {
        word for words in (*_BEGINNINGS.values(), *_MODIFIERS.values(), *_ROLES.values()) for word in words.split()
    }
    return sum(found.count(word) for word in ('°c', 'ω', 'μ', *words) if not word.isascii())


def _split(heading: str) -> tuple[str, str | None, int]:
    """Name, unit, and how surely that is one: in brackets or after a slash, a word at the end, a letter there."""
    bare = heading.strip(' _:')
    found = _BRACKETS.fullmatch(bare)
    if found and unit_named(found[2]):
        return f'{found[1]} {found[3]}', unit_named(found[2]), _SURE
    for between in ('/', ' in '):
        name, slash, tail = bare.rpartition(between)
        if slash and unit_named(tail):
            return name, unit_named(tail), _SURE
    if unit_named(bare) and len(bare) > 1:
        return bare, unit_named(bare), _SURE
    found = _TAIL.fullmatch(bare)
    if found and unit_named(found[2]):
        return found[1], unit_named(found[2]), int(len(found[2]) > 1)
    return bare, None, 0


def _words(text: str) -> list[str]:
    """Words of letters; a symbol keeps its case, a word its lower one is compared by."""
    return re.findall(r'[^\W\d_]+', re.sub(r'(?<=[a-zä-ü])(?=[A-Z][a-z])', ' ', text))


def _kind(words: list[str], unit: str | None) -> str:
    """By the words, then by the symbols, then by what the unit measures."""
    if _follow(words, 'load', 'cell'):
        return 'force'  # a load cell measures it
    if _follow(words, 'x', 'value'):
        return 'time'  # of LabVIEW
    if any(word.lower().startswith('fraction') for word in words):
        return 'fraction'
    quantity = UNITS[unit].quantity if unit else None
    begun = [kind for kind in _BEGINNINGS if _any(words, kind, _BEGINNINGS)]
    fitting = [kind for kind in begun if quantity in (None, _QUANTITY[kind])]
    if 'ambient' in begun and quantity is None and 'temperature' not in begun:
        return 'ambient'
    if fitting:
        return fitting[0]
    role = next((role for role, known in _ROLES.items() if len(words) <= 2 and _exactly(words, role)), None)
    if role and not unit:
        return role
    symbols = [kind for kind, known in _SYMBOLS.items() if any(word in known.split() for word in words)]
    return next((kind for kind in symbols if quantity in (None, _QUANTITY[kind])), begun[0] if begun else '')


def _by_unit(unit: str, words: list[str]) -> str:
    quantity = UNITS[unit].quantity
    return 'load' if quantity == 'force' and _any(words, 'load', _BEGINNINGS) else _OF_QUANTITY.get(quantity, quantity)


def _follow(words: list[str], first: str, second: str) -> bool:
    lower = [word.lower() for word in words]
    return (first, second) in pairwise(lower)


def _any(words: Iterable[str], kind: str, table: dict[str, str]) -> bool:
    known = table[kind].split()
    return any(_begins(word.lower(), beginning) for word in words for beginning in known)


def _begins(word: str, beginning: str) -> bool:
    if not beginning.isascii() and not beginning[0].isascii() and len(beginning) <= 3:
        return beginning in word  # Japanese and Chinese do not part their words
    if beginning in _WHOLE:
        return word == beginning
    return word.startswith(beginning)


def _exactly(words: Iterable[str], kind: str) -> bool:
    known = (_MODIFIERS.get(kind) or _ROLES[kind]).split()
    return any(word.lower() in known for word in words)

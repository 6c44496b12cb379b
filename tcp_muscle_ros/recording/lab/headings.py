"""What a heading means: a channel of the muscle, the time, or neither, and its unit; in the languages of labs."""

import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

from tcp_muscle_ros.recording.lab.unit_names import other_unit, unit_named
from tcp_muscle_ros.recording.lab.vocabulary import (
    ANGLES,
    BEGINNINGS,
    DEGREES,
    MEASURED,
    MODIFIERS,
    PRELOADS,
    RATIOS,
    ROLES,
    SETTINGS,
    SHARES,
    SYMBOLS,
    UNSCALED,
    WHOLE,
)
from tcp_muscle_ros.recording.units import UNITS

_QUANTITY = {
    'time': 'time',
    'temperature': 'temperature',
    'ambient': 'temperature',
    'resistance': 'resistance',
    'current': 'current',
    'voltage': 'voltage',
    'power': 'power',
    'elongation': 'length',
    'strain': 'length',
    'distance': 'length',
    'length': 'length',
    'displacement': 'length',
    'force': 'force',
    'load': 'force',
}
_SENSED = ('temperature', 'ambient', 'displacement', 'distance', 'length', 'elongation', 'force', 'load', 'current')
_ELECTRICAL = ('voltage', 'current')
_SECONDS = ('s', 'ms', 'us', 'ns')
_SURE = 2
_OF_QUANTITY = {'length': 'displacement'}
_BRACKETS = re.compile(r'(.*?)[\[(<{]([^\])>}]*)[\])>}](.*)')
_TAIL = re.compile(r'(.*[^\W_]|.*\W)[_\s.,:-]+([^\s_,:-]+)')


@dataclass(frozen=True)
class Meaning:
    """What a column is.

    kind  a channel, ``time``, ``length`` (contraction is what it shrinks by), ``elongation`` (positive when longer),
          ``distance`` (to what moves: either way), ``strain`` (share of the length), ``index``, ``run``, ``unit``,
          ``fraction`` (of a second); '' where nobody could say
    unit  a name of ``units.UNITS``, None where the heading has none
    raw   where it is a signal that nobody has scaled, or a share: what stands in place of a unit; ``kind`` is what the
          heading calls it
    """

    kind: str
    unit: str | None = None
    commanded: bool = False
    of_muscle: bool = False
    raw: str = ''


def plain(text: str) -> str:
    """A text with full-width signs and letters as ordinary ones, and single spaces."""
    return ' '.join(unicodedata.normalize('NFKC', text).split())


def one_word(text: str) -> str:
    """A text with pre-load and pre-tension as the one word that they are."""
    return re.sub(r'\b(pre|pré)[\s_-]+(?=load|tension|charge)', r'\1', text, flags=re.I)


def meaning(heading: str, more: str = '', unit_cell: str = '') -> Meaning:
    """What a heading means.

    ``more``: what is written of the column elsewhere, in a table of channels for example; ``unit_cell``: what stands in
    a row of units.
    """
    name, unit, sure = _split(plain(heading))
    words = _words(f'{name} {plain(more)}')
    alone = _kind(words, None)
    unscaled = '' if unit and sure else _unscaled(plain(heading), plain(unit_cell), _QUANTITY.get(alone, ''))
    if unit_named(unit_cell):
        unit, sure = unit_named(unit_cell), _SURE
    if any(word.lower() in SETTINGS for word in words):
        return Meaning('')
    fits = unit is not None and sure == _SURE and _QUANTITY.get(alone) == UNITS[unit].quantity
    if _any(words, 'angle', ANGLES) and not fits:
        return Meaning('')  # in Grad, which are no degrees Celsius
    of_another = words[:1] == ['t'] and unit in _SECONDS  # t_laser_s: the times of the laser
    if unit and sure < _SURE and not of_another and _QUANTITY.get(alone, UNITS[unit].quantity) != UNITS[unit].quantity:
        unit = None  # T_min is no time
    commanded, of_muscle = _exactly(words, 'commanded'), _any(words, 'muscle', MODIFIERS)
    kind = _kind(words, unit)
    if unscaled and alone in _QUANTITY:
        strain = unscaled in (*SHARES, *RATIOS) and _QUANTITY[alone] == 'length'
        return Meaning('strain' if strain else alone, None, commanded, of_muscle, unscaled)
    if unit and kind != 'fraction' and _QUANTITY.get(kind) != UNITS[unit].quantity:
        if sure and kind in _SENSED and UNITS[unit].quantity in _ELECTRICAL:
            return Meaning(kind, None, commanded, of_muscle, unit)  # what a sensor puts out
        kind, unit = (_by_unit(unit, words), unit) if sure else (kind, None)
    if kind == 'temperature' and _any(words, 'ambient', BEGINNINGS):
        kind = 'ambient'
    return Meaning(kind, unit, commanded, of_muscle)


def _unscaled(heading: str, unit_cell: str, quantity: str) -> str:
    """What stands in place of a unit of the quantity, where that is none of them: counts, a share, mils; '' else."""
    found = _BRACKETS.fullmatch(heading)
    tail = re.split(r'[\s_/]', heading)[-1]
    for text in (unit_cell, found[2] if found else '', tail):
        bare = text.strip('[(<{})>] ')
        angle = bare.lower() in DEGREES and quantity != 'temperature'  # T (deg) is sloppy, and no angle
        if bare.lower() in UNSCALED or angle or (quantity not in ('', 'time') and other_unit(bare, quantity)):
            return bare
    return ''


def known_words(text: str) -> int:
    """How often words that a lab writes, and that ASCII cannot, are in a text: the right encoding has the most."""
    found = unicodedata.normalize('NFKC', text).lower()
    words = {word for words in (*BEGINNINGS.values(), *MODIFIERS.values(), *ROLES.values()) for word in words.split()}
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
    """Words of letters; a symbol keeps its case, a word its lower one is compared by. 'Troom' is 'T room'."""
    text = one_word(text).replace('∞', ' infinity')
    words = re.findall(r'[^\W\d_]+', re.sub(r'(?<=[a-zä-ü])(?=[A-Z][a-z])', ' ', text))
    return [part for word in words for part in (_parts(word) or (word,))]


def _parts(word: str) -> tuple[str, str] | None:
    """A symbol and what stands straight after it, as in Iset and Tcoil; None for any other word."""
    symbols = {symbol for known in SYMBOLS.values() for symbol in known.split()}
    said = word[1:].lower() in MODIFIERS['commanded'].split() or word[1:].lower() in MEASURED
    return (word[0], word[1:]) if (word[0] in symbols and said) or _is_temperature_of(word) else None


def _is_temperature_of(word: str) -> bool:
    """Is it a T straight before what has that temperature?"""
    rest = word[1:].lower()
    known = (*BEGINNINGS['ambient'].split(), *MODIFIERS['muscle'].split())
    return word[:1] == 'T' and len(rest) > 2 and any(_begins(rest, beginning) for beginning in known)


def _kind(words: list[str], unit: str | None) -> str:
    """By the words, then by the symbols, then by what the unit measures."""
    if _follow(words, 'load', 'cell'):
        return 'force'  # a load cell measures it
    if _follow(words, 'x', 'value'):
        return 'time'  # of LabVIEW
    if any(word.lower().startswith('fraction') for word in words):
        return 'fraction'
    quantity = UNITS[unit].quantity if unit else None
    if quantity in (None, 'force') and _any(words, 'load', PRELOADS):
        return 'load'
    begun = [kind for kind in BEGINNINGS if _any(words, kind, BEGINNINGS)]
    fitting = [kind for kind in begun if quantity in (None, _QUANTITY[kind])]
    if 'ambient' in begun and quantity is None and 'temperature' not in begun:
        return 'ambient'
    if fitting:
        return fitting[0]
    role = next((role for role, known in ROLES.items() if len(words) <= 2 and _exactly(words, role)), None)
    if role and not unit:
        return role
    symbols = [kind for kind, known in SYMBOLS.items() if any(word in known.split() for word in words)]
    return next((kind for kind in symbols if quantity in (None, _QUANTITY[kind])), begun[0] if begun else '')


def _by_unit(unit: str, words: list[str]) -> str:
    quantity = UNITS[unit].quantity
    return 'load' if quantity == 'force' and _any(words, 'load', BEGINNINGS) else _OF_QUANTITY.get(quantity, quantity)


def _follow(words: list[str], first: str, second: str) -> bool:
    lower = [word.lower() for word in words]
    return (first, second) in pairwise(lower)


def _any(words: Iterable[str], kind: str, table: dict[str, str]) -> bool:
    known = table[kind].split()
    return any(_begins(word.lower(), beginning) for word in words for beginning in known)


def _begins(word: str, beginning: str) -> bool:
    if beginning[0] > '\u2e80' and len(beginning) <= 3:
        return beginning in word  # Japanese, Chinese and Korean do not part their words
    if beginning in WHOLE:
        return word == beginning
    return word.startswith(beginning)


def _exactly(words: Iterable[str], kind: str) -> bool:
    known = (MODIFIERS.get(kind) or ROLES[kind]).split()
    return any(word.lower() in known for word in words)

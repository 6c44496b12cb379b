"""What a free law does, in words: the form that was found for its table, with numbers in the units that people use."""

from collections.abc import Sequence

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import InWords
from tcp_muscle_ros.diagnosis.answer.in_words import apart, told_by_form, unit_of
from tcp_muscle_ros.diagnosis.answer.law_forms import STEP, Said, Table
from tcp_muscle_ros.diagnosis.answer.sentences import words
from tcp_muscle_ros.diagnosis.search.selected import Selection
from tcp_muscle_ros.muscle import EFFECTS, ZERO_CELSIUS
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.free_law import KELVIN, METRE, UNITS

_EQUATIONS = {
    'constant': 'c',
    'linear': 'c + b (x - o)/w',
    'square': 'c + b ((x - o)/w)^2',
    'cube': 'c + b ((x - o)/w)^3',
    'power': 'c + b ((x - o)/w)^p',
    'exponential': 'c + b exp((x - e)/s)',
    'saturation': 'c - b exp(-(x - e)/s)',
    'threshold': 'c + b max((x - a)/w, 0)',
    'until': 'c + b (min(x, a) - o)/w',
    'step': 'c + b/(1 + exp(-(x - a)/s))',
}
_SAYS = {
    'constant': 'is the same at every {driver}: {height}',
    'linear': '{rises} evenly with the {driver}, by {slope}',
    'square': '{rises} as the square of the {driver}{counted}, by {rise} {range}',
    'cube': '{rises} as the cube of the {driver}{counted}, by {rise} {range}',
    'power': '{rises} as the power {number:.2g} of the {driver}{counted}, by {rise} {range}',
    'exponential': '{rises} exponentially with the {driver}, by a factor e every {scale}, and by {rise} {range}',
    'saturation': '{rises} with the {driver} and levels off within some {scale}, by {rise} {range}',
    'threshold': '{rises} above {place}, by {slope}',
    'until': '{rises} up to {place}, by {slope}, and stays there',
    'step': '{rises} by {step} about {place}',
}
_LOOKS = {
    'constant': 'a constant',
    'linear': 'a straight line',
    'square': 'a square',
    'cube': 'a cube',
    'power': 'a power',
    'exponential': 'an exponential',
    'saturation': 'a saturation',
    'threshold': 'a threshold',
    'until': 'a limit',
    'step': 'a step',
}
_ACTS = ('', ' while it heats', ' while it cools')


def in_words(selection: Selection, effect: str, driver: str, at: Array) -> InWords | None:
    """A law in words, and its curve at these values of the driver; None where no form predicts as well as its table."""
    told = told_by_form(selection, effect)
    if told is None:
        return None
    said, table = told.said, told.table
    return InWords(
        said.form.name,
        sentence(said, table, effect, driver, told.others),
        _EQUATIONS[said.form.name],
        _parameters(said, table, effect, driver),
        tuple(other.form.name for other in told.others),
        said.values(table, at)[0],
    )


def sentence(said: Said, table: Table, effect: str, driver: str, others: Sequence[Said] = ()) -> str:
    """The law in words; of one that has values of its own for cooling, both; and the forms that predict as well."""
    free = EFFECTS[effect].free
    noun = (free and free.of) or words(effect.removeprefix('free_'))
    parts = [_does(said, table, effect, driver, k) for k in range(len(said.coefficients))]
    acts = _ACTS[1:] if len(parts) > 1 else _ACTS
    does = '; '.join(f'{part}{act}' for part, act in zip(parts, acts, strict=False))
    return f'As far as these recordings tell, the {noun} {does}.{_beside(said, table, effect, driver, others)}'


def _beside(said: Said, table: Table, effect: str, driver: str, others: Sequence[Said]) -> str:
    """The forms that unseen data do not tell from it, and what would."""
    if not others:
        return ''
    where, gap = max((apart(said, other, table) for other in others), key=lambda one: one[1])
    base = float(said.values(table, np.array([where]))[0, 0])
    differ = f'by {"up to " * (len(others) > 1)}{_size(effect, gap, base)}'
    return (
        f' {_either([other.form.name for other in others])} predicts unseen data as well over the range seen; a '
        f'measurement at {_place(driver, where)} would decide, where they differ {differ}.'
    )


def _does(said: Said, table: Table, effect: str, driver: str, curve: int) -> str:
    """What one curve does."""
    first, last = (float(y) for y in said.values(table, table.at[[0, -1]])[curve])
    c, b = (*said.coefficients[curve], 0.0)[:2]
    base = float(c) if said.form.name in ('threshold', 'step') else first
    unit, plain = _unit(driver), words(driver)
    low, high = (_place(driver, float(x)) for x in table.at[[0, -1]])
    origin = _place(driver, table.origin)
    scale = 1e3 if unit == 'mm' else 1.0
    return _SAYS[said.form.name].format(
        driver=plain,
        rises='rises' if last > first else 'falls',
        height=_size(effect, float(c), 0.0),
        slope=f'{_size(effect, abs(float(b)) / (table.span * scale), base)} per {unit}',
        rise=_size(effect, abs(last - first), first),
        step=_size(effect, abs(float(b)), base),
        range=f'from {low} to {high}',
        counted='' if table.origin == 0.0 else f' above {origin}',
        number=said.number,
        scale=f'{said.number * table.span * scale:.2g} {unit}',
        place=_place(driver, table.origin + said.number * table.span),
    )


def _size(effect: str, value: float, base: float) -> str:
    """A change of a law: of one that multiplies a parameter, beside what that is at ``base``."""
    unit = unit_of(effect)
    if unit == '1':
        return f'{100.0 * value / (1.0 + base):.2g} %'
    return f'{1e3 * value:.2g} mm' if unit == METRE else f'{value:.2g} {unit}'


def _unit(driver: str) -> str:
    return 'mm' if UNITS[driver] == METRE else UNITS[driver]


def _place(driver: str, x: float) -> str:
    """A value of a driver as people read it."""
    if UNITS[driver] == KELVIN:
        return f'{x - ZERO_CELSIUS:.0f} degC'
    return f'{1e3 * x if _unit(driver) == "mm" else x:.3g} {_unit(driver)}'


def _either(forms: Sequence[str]) -> str:
    shown = [_LOOKS[form] for form in forms]
    said = ' or '.join(filter(None, [', '.join(shown[:-1]), shown[-1]]))
    return said[0].upper() + said[1:]


def _parameters(said: Said, table: Table, effect: str, driver: str) -> dict[str, tuple[float, str]]:
    """The numbers of the equation, with their units (SI, temperatures in degC)."""
    unit, equation, span = UNITS[driver], _EQUATIONS[said.form.name], table.span
    zero, absolute = (ZERO_CELSIUS, 'degC') if unit == KELVIN else (0.0, unit)
    scale = STEP if said.form.name == 'step' else said.number
    known = {
        'o': (table.origin - zero, absolute),
        'w': (span, unit),
        'p': (said.number, '1'),
        'e': (float(table.at[0 if said.form.name == 'saturation' else -1]) - zero, absolute),
        's': (scale * span, unit),
        'a': (table.origin + said.number * span - zero, absolute),
    }
    own: dict[str, tuple[float, str]] = {}
    for k, mine in enumerate(np.atleast_2d(said.coefficients)):
        own |= {f'{name}{"_cooling" * k}': (float(y), unit_of(effect)) for name, y in zip('cb', mine, strict=False)}
    letters = equation.replace('exp', '').replace('max', '').replace('min', '')
    return own | {name: value for name, value in known.items() if name in letters}

"""Numbers and names of a diagnosis as people read them: mm and mN, absolute temperatures in degC, few digits."""

import re
from collections.abc import Sequence
from dataclasses import replace
from math import isfinite

from tcp_muscle_ros.diagnosis.answer.digits import digits_text, number, value_text
from tcp_muscle_ros.diagnosis.answer.findings import Change, ChannelFit, Diagnosis, Finding, Value
from tcp_muscle_ros.diagnosis.answer.sentences import EVEN, of_surroundings
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT, START
from tcp_muscle_ros.diagnosis.search.location import Driver, Unexplained
from tcp_muscle_ros.muscle import EFFECTS, SPECIFICATIONS, ZERO_CELSIUS
from tcp_muscle_ros.report.as_read import SHOWN

VERDICTS = {
    'match': 'the simulation matches the recordings',
    'wrong_parameters': 'the parameters are wrong, no physics is seen to be missing',
    'not_repeatable': 'predicted about as well as the runs repeat each other',
    'sensor_or_setup': 'a sensor or the set-up differs, not necessarily the muscle',
    'missing_physics': 'physics is missing from the simulation',
    'unexplained': 'something is missing that no listed effect explains',
    'insufficient_data': 'the recordings do not allow a verdict',
}
# Where a verdict is more likely wrong than right.
_DOUBTFUL = {
    'sensor_or_setup': 'a sensor or the set-up may differ, not necessarily the muscle',
    'missing_physics': 'physics may be missing from the simulation',
}
_NOT_TRIED = 'something is missing, and no listed effect was tried'
# Where all physics that was found is of the room or the air.
_SURROUNDINGS = 'the room or the air went its own way, no physics of the muscle is seen to be missing'
# Units of what a misfit may go with (SI inside); a temperature is absolute unless it is a rate.
_DRIVER_UNITS = {
    'temperature': 'K',
    'rate': 'K/s',
    'since_switch': 's',
    'time since': 's',
    'elapsed': 's',
    'load': 'N',
    'displacement': 'm',
    'cycle': '',
}
_PER_RECORDING = re.compile(rf'^({AMBIENT}|{START})(?![\w.])')


def verdict_words(diagnosis: Diagnosis) -> str:
    """A verdict as people say it."""
    physics = [f for f in diagnosis.findings if f.stage != 'sensor']
    if diagnosis.verdict == 'missing_physics' and physics and all(map(of_surroundings, physics)):
        return _SURROUNDINGS
    if diagnosis.verdict == 'unexplained' and not diagnosis.tried:
        return _NOT_TRIED
    probability = diagnosis.verdict_probability
    doubtful = probability is not None and probability < EVEN
    return _DOUBTFUL.get(diagnosis.verdict, VERDICTS[diagnosis.verdict]) if doubtful else VERDICTS[diagnosis.verdict]


def listed(names: Sequence[str]) -> str:
    """Names in a sentence: ``heating, cooling and rest``."""
    return ' and '.join(filter(None, [', '.join(names[:-1]), names[-1]]))


def is_absolute(name: str) -> bool:
    """Whether a parameter or an unknown of a recording (``ambient [1]``) is an absolute temperature."""
    row = SPECIFICATIONS.get(name)
    return row.absolute if row is not None else bool(_PER_RECORDING.match(name))


def at_edge(name: str, value: Value) -> Value:
    """The value as files and people have it: an absolute temperature in degC, all else unchanged."""
    if not is_absolute(name) or value.unit != 'K':
        return value
    return replace(
        value,
        **{key: round(getattr(value, key) - ZERO_CELSIUS, 9) for key in ('value', 'low', 'high', 'nominal')},
        unit='degC',
    )


def own_parameters(finding: Finding) -> dict[str, Value]:
    """A finding's parameters under their short names (``J``, not ``creep.J``), at the edge."""
    prefix = f'{finding.effect}.'
    return {
        name.removeprefix(prefix): at_edge(prefix + name.removeprefix(prefix), value)
        for name, value in finding.parameters.items()
    }


def driver_unit(variable: str) -> str:
    """The SI unit of what a misfit goes with, by the word that its name begins with."""
    return next((unit for word, unit in _DRIVER_UNITS.items() if variable.startswith(word)), '')


def driver_range(found: Driver | Unexplained) -> tuple[float, float, str]:
    """Low, high and unit at the edge of the range of a driver in which the misfit is."""
    variable, unit = (found.variable, found.unit) if isinstance(found, Driver) else (found.driver, '')
    unit = unit or driver_unit(variable)
    if variable.startswith('temperature') and unit == 'K':
        return found.low - ZERO_CELSIUS, found.high - ZERO_CELSIUS, 'degC'
    return found.low, found.high, unit


def plain(name: str) -> str:
    """An effect, verdict or stage as words."""
    return name.replace('_', ' ')


def parameter_text(effect: str, name: str, value: Value) -> str:
    """A finding's parameter: its value as above, or the name of what was chosen."""
    row = SPECIFICATIONS.get(f'{effect}.{name}')
    return row.choices[round(value.value)] if row is not None and row.choices else value_text(value)


def interval_text(value: Value) -> str:
    """``0.092 to 0.108``."""
    _, low, high = digits_text(value)
    return f'{low} to {high}'


def error_text(channel: str, rmse: float, *, unit: bool = True) -> str:
    """A root mean square error of a channel: ``1.90 mm``."""
    name, factor = SHOWN.get(channel, ('', 1.0))
    text = number(rmse * factor)
    return f'{text} {name}'.strip() if unit and text != '-' else text


def fit_texts(channel: str, fit: ChannelFit) -> list[str]:
    """The errors of a channel's models, nominal, recalibrated and improved, and its noise."""
    return [error_text(channel, error) for error in (fit.nominal, fit.calibrated, fit.improved, fit.noise)]


def change_text(channel: str, change: Change) -> str:
    """``1.90 to 0.20 mm``."""
    return f'{error_text(channel, change.before, unit=False)} to {error_text(channel, change.after)}'


def range_text(found: Driver | Unexplained) -> str:
    """``temperature 45 to 80 degC``."""
    low, high, unit = driver_range(found)
    variable = found.variable if isinstance(found, Driver) else found.driver
    name = 'time since the switch' if variable == 'since_switch' else plain(variable)
    if not (isfinite(low) and isfinite(high)):
        return name
    if unit == 'm':
        low, high, unit = 1e3 * low, 1e3 * high, 'mm'
    first, last = number(low, 2), number(high, 2)
    if first == last:
        _, first, last = digits_text(Value(low, low, high, unit))
    return f'{name} {first} to {last} {unit}'.strip()


def percent(share: float) -> str:
    """A share as per cent, ``-`` where there is none."""
    return f'{100.0 * share:.0f} %' if isfinite(share) else '-'


def chance(probability: float) -> str:
    """A probability as per cent; an expected one is never certain."""
    return '> 99 %' if probability > 0.99 else '< 1 %' if probability < 0.01 else percent(probability)


def told_apart(finding: Finding) -> str:
    """Whether the recordings leave anything else in the place of a finding, nothing included."""
    rivals = ' or '.join(plain(other) for other in finding.indistinguishable_from)
    said = [f'could as well be {rivals}'] if rivals else []
    said += ['its interval includes no effect'] if finding.may_be_nothing else []
    said += ['one channel does not tell the stages apart'] if finding.one_channel and not said else []
    nothing = 'no other listed effect explains as much' if finding.unlisted is None else 'no listed effect explains it'
    return '; '.join(said) or nothing


def left_by_listed(findings: Sequence[Finding]) -> str:
    """What to call a misfit that the listed effects leave: a law without a name may explain it."""
    lawful = any(finding.unlisted is not None for finding in findings)
    return 'explained by no listed effect, but by that law' if lawful else 'unexplained'


def cluster_text(finding: Finding) -> str:
    """``supply lag 0.54 (electrical), two node 0.31 (thermal)``: causes that look alike; empty where there are none."""
    return ', '.join(f'{plain(m.effect)} {number(m.probability, 2)} ({m.stage})' for m in finding.cluster)


def probability_text(finding: Finding) -> str:
    """``probability 0.97``, never a certainty; empty where there is none."""
    p = finding.probability
    return f'probability {"> 0.99" if p > 0.99 else number(p, 2)}' if isfinite(p) else ''


def meaning(effect: str, parameter: str) -> str:
    """What a parameter of an effect is, from the one table."""
    rows = EFFECTS[effect].parameters if effect in EFFECTS else ()
    return next((row.meaning for row in rows if row.name == parameter.split(maxsplit=1)[0]), '')

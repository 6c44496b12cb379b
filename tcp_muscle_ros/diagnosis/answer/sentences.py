"""Findings in plain words: one sentence opens the report, one says each effect."""

from collections.abc import Mapping, Sequence

from tcp_muscle_ros.diagnosis.answer.findings import ChannelFit, Finding, Value
from tcp_muscle_ros.diagnosis.search.location import Location, Unexplained
from tcp_muscle_ros.muscle import EFFECTS, SPECIFICATIONS, ZERO_CELSIUS

_QUANTITY = {
    'temperature': ('temperature', 'K', 1.0),
    'resistance': ('resistance', 'ohm', 1.0),
    'displacement': ('stroke', 'mm', 1e3),
    'force': ('force', 'mN', 1e3),
}


def words(effect: str) -> str:
    """An effect's name as words."""
    return effect.replace('_', ' ')


def amount(channel: str, value: float) -> str:
    """A size in the unit that people use for the channel."""
    _, unit, factor = _QUANTITY[channel]
    return f'{value * factor:.2g} {unit}'


def finding_sentence(effect: str, values: Mapping[str, Value], others: Sequence[str]) -> str:
    """What the effect is and how strong, and what it cannot be told from."""
    shown = []
    for name, v in values.items():
        row = SPECIFICATIONS[f'{effect}.{name.split()[0]}']  # of one recording: "g [2]"
        if row.choices:
            shown.append(f'{name} = {row.choices[round(v.value)]}')
            continue
        unit = '' if row.edge_unit == '1' else f' {row.edge_unit}'
        shown.append(
            f'{name} = {row.to_edge(v.value):.3g} ({row.to_edge(v.low):.3g} to {row.to_edge(v.high):.3g}){unit}'
        )
    kind = 'The sensors show' if EFFECTS[effect].stage == 'sensor' else 'The muscle shows'
    sentence = f'{kind} {words(effect)}: {", ".join(shown)}.'
    if others:
        sentence += f' These recordings admit as well: {", ".join(words(o) for o in others)}.'
    return sentence


def where(location: Location) -> str:
    """The place of the misfit as the beginning of a sentence."""
    driver = location.drivers[0]
    low, high = driver.low - ZERO_CELSIUS, driver.high - ZERO_CELSIUS
    place = f'Between {low:.0f} and {high:.0f} degC'
    phase = [p for p in location.phases if p != 'transition']
    doing = {'heating': 'while heating', 'cooling': 'while cooling', 'rest': 'at rest'}
    if phase and len(phase) < 3:
        place += ' ' + ' and '.join(doing[p] for p in phase)
    elif 'transition' in location.phases:
        place += ' just after the input switches'
    return place


def _misfit(location: Location) -> str:
    quantity = _QUANTITY[location.channel][0]
    side = 'above' if location.size > 0.0 else 'below'
    return f'the recorded {quantity} is typically {amount(location.channel, abs(location.size))} {side} the simulation'


def headline(
    verdict: str,
    findings: Sequence[Finding],
    location: Location | None,
    fits: Mapping[str, ChannelFit],
    unexplained: Unexplained | None,
) -> str:
    """The one plain sentence that opens the report."""
    if verdict == 'match':
        return 'The simulation agrees with the recordings to within their noise.'
    if verdict == 'wrong_parameters':
        return (
            'The recordings differ from the simulation because its parameters are not those of this muscle; '
            'recalibrated, it agrees.'
        )
    if location is None:
        if unexplained is None:
            return 'The recordings differ from the simulation.'
        return (
            f'Recalibrated, the simulation still misses the {unexplained.channel}; another channel shows the same, so '
            f'that it is no noise, and no effect of the catalogue explains it.'
        )
    opening = f'{where(location)}, {_misfit(location)}.'
    if verdict == 'unexplained' and unexplained is not None:
        return (
            f'{opening} No effect of the catalogue explains it: unlisted, {unexplained.stage} stage, '
            f'{100 * unexplained.share:.0f} % of the misfit remains.'
        )
    first = findings[0]
    names = [words(f.effect) for f in findings if (f.stage == 'sensor') == (first.stage == 'sensor')]
    said = ' and '.join(names)
    if first.indistinguishable_from:
        said += ' (or ' + ', or '.join(words(o) for o in first.indistinguishable_from) + ')'
    cause = f'The paper leaves out {said}' if first.stage != 'sensor' else f'The sensors add {said}'
    fit = fits.get(location.channel)
    if fit is None:
        return f'{opening} {cause}.'
    return (
        f'{opening} {cause}; with it the held-out error falls from {amount(location.channel, fit.calibrated)} to '
        f'{amount(location.channel, fit.improved)} (noise {amount(location.channel, fit.noise)}).'
    )

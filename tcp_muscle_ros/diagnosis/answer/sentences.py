"""Findings in plain words: one sentence opens the report, one says each effect."""

from collections.abc import Mapping, Sequence

from tcp_muscle_ros.diagnosis.answer.digits import value_text
from tcp_muscle_ros.diagnosis.answer.findings import ChannelFit, Finding, FreeLaw, Sticking, Value, includes_nothing
from tcp_muscle_ros.diagnosis.model.tcp_muscle import TCP_MUSCLE
from tcp_muscle_ros.diagnosis.search.location import Location, Unexplained
from tcp_muscle_ros.muscle import EFFECTS, SPECIFICATIONS, ZERO_CELSIUS

EVEN = 0.5  # what is less probable may be


def words(effect: str) -> str:
    """An effect's name as words."""
    return effect.replace('_', ' ')


def quantity(channel: str) -> str:
    """What people call a channel."""
    return TCP_MUSCLE.channels[channel].title


def amount(channel: str, value: float) -> str:
    """A size in the unit that people use for the channel."""
    known = TCP_MUSCLE.channels[channel]
    return f'{value * known.factor:.2g} {known.unit}'


def finding_sentence(effect: str, values: Mapping[str, Value], others: Sequence[str], probability: float = 1.0) -> str:
    """What the effect is and how strong, and what it cannot be told from."""
    shown = []
    for name, v in values.items():
        row = SPECIFICATIONS[f'{effect}.{name.split()[0]}']  # of one recording: "g [2]"
        if row.choices:
            shown.append(f'{name} = {row.choices[round(v.value)]}')
            continue
        edge = Value(row.to_edge(v.value), row.to_edge(v.low), row.to_edge(v.high), row.edge_unit)
        shown.append(f'{name} = {value_text(edge)}')
    say = 'show' if probability >= EVEN else 'may show'
    sentence = f'The recordings {say} {words(effect)}: {", ".join(shown)}.'
    if includes_nothing(effect, values):
        sentence += ' Its interval includes no effect at all.'
    if others:
        sentence += f' These recordings could also be explained by {", ".join(words(o) for o in others)}.'
    return sentence


def free_sentence(effect: str, law: FreeLaw, probability: float = 1.0) -> str:
    """What a law without a name does over its driver, and the listed effects that do not."""
    does = 'does' if probability >= EVEN else 'may'
    first, last = (float(law.value[k]) for k in (0, -1))
    meaning = next(column.meaning for column in EFFECTS[effect].columns if column.name == 'value')
    sentence = (
        f'No listed effect explains what is left, a law without a name {does}: {words(effect)} over '
        f'{words(law.driver)} ({meaning} from {first:.3g} to {last:.3g} {law.unit}).'
    )
    return ' '.join(filter(None, [sentence, law.in_words.sentence if law.in_words else '', nearest_law(law)]))


def nearest_law(law: FreeLaw) -> str:
    """The listed law that comes nearest to one without a name, and how far it is from it."""
    if law.nearest is None:
        return ''
    if law.nearest_share is None:
        return f'The nearest listed law is {words(law.nearest)}.'
    return f'The nearest listed law, {words(law.nearest)}, explains {100 * law.nearest_share:.0f} % of it.'


def where(location: Location) -> str:
    """The place of the misfit as the beginning of a sentence."""
    driver = location.drivers[0]
    ends, of_what = (driver.low, driver.high), 'degC'
    if not driver.unit:  # nobody knows how hot it was
        of_what = f'% of the range of the {quantity(location.channel)}'
    low, high = (end - ZERO_CELSIUS if driver.unit else 100.0 * end for end in ends)
    decimals = 0 if f'{low:.0f}' != f'{high:.0f}' else 1
    place = f'Between {low:.{decimals}f} and {high:.{decimals}f} {of_what}'
    phase = [p for p in location.phases if p != 'transition']
    doing = {'heating': 'while heating', 'cooling': 'while cooling', 'rest': 'at rest'}
    if phase and len(phase) < 3:
        place += ' ' + ' and '.join(doing[p] for p in phase)
    elif 'transition' in location.phases:
        place += ' just after the input switches'
    return place


def _misfit(location: Location) -> str:
    """How much the recalibrated model misses: above or below only where the mean has that sign for sure."""
    what = quantity(location.channel)
    if location.mean is None:
        size = amount(location.channel, location.size)
        return f'the recorded {what} differs from the recalibrated simulation by {size}'
    side = 'above' if location.mean > 0.0 else 'below'
    mean = amount(location.channel, abs(location.mean))
    return f'the recorded {what} is on average {mean} {side} the recalibrated simulation'


def headline(
    verdict: str,
    findings: Sequence[Finding],
    location: Location | None,
    fits: Mapping[str, ChannelFit],
    unexplained: Unexplained | None,
    repeats: str = '',
    tried: bool = True,
) -> str:
    """The one plain sentence that opens the report; ``repeats``: it, where it is about how the runs repeat each other;
    ``tried``: whether any effect was."""
    if verdict == 'match':
        return 'The simulation agrees with the recordings to within their noise.'
    if verdict == 'wrong_parameters':
        return f'No physics is seen to be missing; the parameters are those of another muscle: {_recalibrated(fits)}.'
    if verdict == 'not_repeatable':
        return repeats
    if location is None and repeats:
        return repeats
    if location is None:
        if unexplained is None:
            return 'The recordings differ from the simulation.'
        return (
            f'After recalibration the simulation still differs in the {unexplained.channel}. Another channel differs '
            f'at the same times, so it is not noise. {none_explains(tried)} it.'
        )
    opening = f'{where(location)}, {_misfit(location)}.'
    if verdict == 'unexplained' and unexplained is not None:
        return (
            f'{opening} {none_explains(tried)} it: {100 * unexplained.share:.0f} % of the misfit of the '
            f'{quantity(unexplained.channel)} beyond its noise is unexplained, in the {unexplained.stage} stage.'
        )
    return f'{opening} {_cause(findings, location.stage)}{_better(location.channel, findings, fits)}.'


def led_by(first: str, said: str) -> str:
    """What is said, after a sentence that comes first, unless it begins so already."""
    return said if said.startswith(first) else f'{first} {said}'


def none_explains(tried: bool) -> str:
    """That no listed effect explains what is said next, or that none was tried on it."""
    return 'No listed effect explains' if tried else 'No listed effect was tried on'


def with_sticking(said: str, sticking: Sticking | None) -> str:
    """The sentence that opens the report, and that the motion sticks and slips, unless it says so already."""
    if sticking is None:
        return said
    also = (
        f'The {quantity(sticking.channel)} sticks and slips in {len(sticking.recordings)} of {sticking.seen} '
        f'recordings; its jumps are chance, and no model predicts them.'
    )
    return said if said.endswith(also) else f'{said} {also}'


def _recalibrated(fits: Mapping[str, ChannelFit]) -> str:
    """What recalibration does to the channel that it helps most."""
    helped = {name: f.nominal / f.calibrated for name, f in fits.items() if f.calibrated < f.nominal}
    if not helped:
        return 'recalibration moves them by more than their uncertainty'
    name = max(helped, key=lambda channel: helped[channel])
    before, after, noise = (amount(name, e) for e in (fits[name].nominal, fits[name].calibrated, fits[name].noise))
    return f'recalibrated, the error of the {quantity(name)} falls from {before} to {after} (noise {noise})'


def of_surroundings(finding: Finding) -> bool:
    """Whether it is of the room or the air while it was recorded, and neither of the muscle nor of a sensor."""
    effect = EFFECTS.get(finding.effect)  # of another machine there is none
    return finding.stage != 'sensor' and effect is not None and effect.circumstance


def _cause(findings: Sequence[Finding], stage: str) -> str:
    """What was found: of the muscle, of what surrounds it, of the sensors; of these first, where the misfit that was
    told is of their ``stage``."""
    sensors = [f for f in findings if f.stage == 'sensor']
    around = [f for f in findings if of_surroundings(f)]
    muscle = [f for f in findings if f not in (*sensors, *around)]
    said = [_said('The simulation', 'lack', muscle)] if muscle else []
    if around:
        said.append(f'{_said("The recordings", "have", around)}, of the room and not of the muscle')
    if sensors and (stage == 'sensor' or not said):
        said.insert(0, _said('The sensors', 'add', sensors))
    first, *others = said
    return ', and '.join([first, *(other[0].lower() + other[1:] for other in others)])


def _said(who: str, does: str, findings: Sequence[Finding]) -> str:
    """What lacks or adds what, with what the data admit in its place. What is more likely absent than there may be."""
    likely = _joined([f for f in findings if f.probability >= EVEN])
    doubtful = _joined([f for f in findings if not f.probability >= EVEN])
    many = who.endswith('s')
    said = [f'{does if many else does + "s"} {likely}'] if likely else []
    said += [f'may {does} {doubtful}'] if doubtful else []
    return f'{who} {" and ".join(said)}'


def _joined(findings: Sequence[Finding]) -> str:
    """Names in a sentence, each with what else it could be."""
    said = []
    for f in findings:
        others = ' or '.join(words(o) for o in f.indistinguishable_from)
        name = f'a law without a name ({words(f.effect)})' if f.unlisted is not None else words(f.effect)
        said.append(f'{name} (or {others})' if others else name)
    return ' and '.join(filter(None, [', '.join(said[:-1]), *said[-1:]]))


def _better(channel: str, findings: Sequence[Finding], fits: Mapping[str, ChannelFit]) -> str:
    """What all findings together do to the error on unseen data, where they do not raise it."""
    fit = fits.get(channel)
    if fit is None or fit.held_out is None or not fit.held_out.after < fit.held_out.before:
        return ''
    before, after, noise = (amount(channel, e) for e in (fit.held_out.before, fit.held_out.after, fit.noise))
    change = f'falls from {before} to {after}' if before != after else f'stays about {after}'
    them = 'it' if len(findings) == 1 else 'all that was found'
    return f'; with {them} the error on unseen data {change} (noise {noise})'

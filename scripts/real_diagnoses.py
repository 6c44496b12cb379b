"""What the diagnosis says of the public rigs' recordings: part of scripts/real_recordings.py --diagnose.

Of each group a few runs are diagnosed with no hint and as they were recorded; the others are unseen. Errors on unseen
runs are free-running, root mean square over the peak to peak: (A) with gain and zero of the unseen run fitted to it,
(B) with its heat exchange too. The floor is what runs of one protocol do not share, each with a gain and a zero.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis
from tcp_muscle_ros.diagnosis.diagnose import diagnose
from tcp_muscle_ros.diagnosis.fitting.calibration import Calibration, Estimate, calibrate
from tcp_muscle_ros.diagnosis.noise.repeatability import Repeatability, between_runs
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle import SPECIFICATIONS, Parameters
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.report.words import chance, error_text, percent, plain, probability_text, range_text, told_apart

MOST = 250  # samples a run, averaged in blocks beyond: the time constants are seconds
KINDS = 3  # powers that are diagnosed
SEVERAL = 3  # runs of one power, from which two of the lowest and of the highest are diagnosed
HEAT = 1.5  # of the logarithm of hA, either way


@dataclass(frozen=True)
class Errors:
    """Errors on unseen runs as shares of their peaks, (A) and (B), recalibrated and improved."""

    recalibrated: tuple[float, float]
    improved: tuple[float, float]


@dataclass(frozen=True)
class Outcome:
    """A group's diagnosis, what it was made from, its errors on the runs that it has not seen, and the floor."""

    title: str
    diagnosis: Diagnosis
    fitted: tuple[str, ...]
    unseen: tuple[str, ...]
    errors: Errors | None
    floor: Repeatability | None


def power_of(name: str) -> str:
    """The kind of a run, with its power: its name without the last part."""
    return name.rsplit('_', 1)[0]


def chosen(names: Sequence[str], split: int = 0) -> list[str]:
    """The runs that are diagnosed in a split: of the lowest and the highest power two, where there are three or more,
    of one between them one; of one power alone half at most. Each split begins with another run."""
    powers: dict[str, list[str]] = {}
    for name in names:
        powers.setdefault(power_of(name), []).append(name)
    kinds = sorted(powers)
    places = np.unique(np.linspace(0, len(kinds) - 1, min(KINDS, len(kinds))).round().astype(int))
    found = []
    for k in places:
        runs = powers[kinds[k]]
        count = 2 if len(runs) >= SEVERAL and k in (0, len(kinds) - 1) else 1
        found += [runs[(count * split + n) % len(runs)] for n in range(count)]
    return found


def different(names: Iterable[str], most: int) -> list[int]:
    """The numbers of at most so many splits, no two of which diagnose the same runs."""
    ordered = sorted(names)
    numbers: dict[frozenset[str], int] = {}
    for split in range(len(ordered) * most):
        numbers.setdefault(frozenset(chosen(ordered, split)), split)
    return list(numbers.values())[:most]


def diagnose_group(title: str, runs: dict[str, Experiment], nominal: Parameters, split: int = 0) -> Outcome:
    """Diagnose a few runs of a group, and look at the others with what came out."""
    names = sorted(runs)
    fitted = chosen(names, split)
    unseen = [n for n in names if n not in fitted]
    found = diagnose([runs[n] for n in fitted], nominal)
    floor = next(iter(between_runs([runs[n] for n in names]).values()), None)
    errors = None
    if unseen and found.calibrated is not None:
        before, after = (unseen_errors([runs[n] for n in unseen], m) for m in (found.calibrated, found.improved))
        errors = Errors(before, after)
    return Outcome(title, found, tuple(fitted), tuple(unseen), errors, floor)


def unseen_errors(runs: Sequence[Experiment], muscle: Parameters) -> tuple[float, float]:
    """Errors (A) and (B), root mean square over the runs."""
    plainly = [missed(run, muscle) for run in runs]
    warmer = [
        float(minimize_scalar(lambda x, run=run: missed(run, heated(muscle, x)), bounds=(-HEAT, HEAT)).fun)
        for run in runs
    ]
    return float(np.sqrt(np.mean(np.square(plainly)))), float(np.sqrt(np.mean(np.square(warmer))))


def heated(muscle: Parameters, change: float) -> Parameters:
    """The muscle with another heat exchange, by a logarithm, as far as it goes."""
    row = SPECIFICATIONS['hA']
    return muscle.replace(hA=float(np.clip(muscle['hA'] * np.exp(change), row.low, row.high)))


def missed(run: Experiment, muscle: Parameters) -> float:
    """RMSE of a free run with its own gain and zero, over the recorded peak to peak."""
    (name,) = run.observed
    seen = run.observed[name].value
    return float(np.sqrt(np.mean((seen - with_gain(run.predict(muscle)[name], seen)) ** 2)) / np.ptp(seen))


def with_gain(predicted: Array, seen: Array) -> Array:
    """The prediction with the gain and zero that bring it nearest to what was seen."""
    columns = np.stack([predicted, np.ones_like(predicted)], axis=1)
    return np.asarray(columns @ np.linalg.lstsq(columns, seen, rcond=None)[0])


def row(outcomes: Sequence[Outcome]) -> str:
    """One row of the table of errors: means over the splits, in per cent of the peak."""
    first = outcomes[0]
    known = [o.errors for o in outcomes if o.errors is not None]

    def told(words: Iterable[str]) -> str:
        often = Counter(words).most_common()
        return ', '.join(
            word if count == len(outcomes) else f'{word} {count} of {len(outcomes)}' for word, count in often
        )

    def mean(which: str, k: int) -> str:
        return f'{100 * np.mean([getattr(e, which)[k] for e in known]):.1f}' if known else '-'

    floor = '-' if first.floor is None else f'{100 * first.floor.own_gain:.1f}'
    names = told(plain(f.effect) for o in outcomes for f in o.diagnosis.findings)
    verdicts = told(plain(o.diagnosis.verdict) for o in outcomes)
    cells = [mean('recalibrated', 0), mean('improved', 0), floor, mean('recalibrated', 1), mean('improved', 1)]
    return f'| {first.title} | {" | ".join(cells)} | {verdicts} | {names or "nothing"} |'


HEADING = (
    '| group | recalibrated (A) | improved (A) | floor | recalibrated (B) | improved (B) | verdict | named |\n'
    '|---|---|---|---|---|---|---|---|'
)


def required(outcomes: Sequence[Outcome]) -> str:
    """How often what no diagnosis of these recordings may say was said, over all groups and splits."""
    found = [f for o in outcomes for f in o.diagnosis.findings]
    named = Counter(f.effect for f in found)
    air, room = named['airflow'], named['ambient_drift']
    sure = sum(f.singled_out for f in found)
    return (
        f'In {len(outcomes)} diagnoses `airflow` was named {air} times, `ambient_drift` {room} times, and an effect '
        f'was singled out {sure} times.'
    )


def table_of_splits(outcomes: Sequence[Outcome]) -> list[str]:
    """What came out of each split of a group, as lines of markdown."""
    lines = [
        '| diagnosed | recalibrated (A) | improved (A) | recalibrated (B) | improved (B) | verdict | named |',
        '|---|---|---|---|---|---|---|',
    ]
    for o in outcomes:
        errors = ['-'] * 4
        if o.errors is not None:
            pairs = zip(o.errors.recalibrated, o.errors.improved, strict=True)
            errors = [f'{100 * share:.1f}' for pair in pairs for share in pair]
        named = ', '.join(' or '.join(map(plain, (f.effect, *f.indistinguishable_from))) for f in o.diagnosis.findings)
        cells = [', '.join(o.fitted), *errors, plain(o.diagnosis.verdict), named or 'nothing']
        lines.append(f'| {" | ".join(cells)} |')
    return [*lines, '']


def paragraphs(outcome: Outcome) -> list[str]:
    """The outcome of a group as lines of markdown."""
    d = outcome.diagnosis
    powers = sorted({power_of(n) for n in outcome.unseen} - {power_of(n) for n in outcome.fitted})
    count = len(outcome.unseen)
    seen_not = f'{count} other{"" if count == 1 else "s"}' + (
        f', with {", ".join(powers)} as a power of their own' if powers else ''
    )
    lines = [
        f'### {outcome.title[0].upper()}{outcome.title[1:]}',
        '',
        f'Diagnosed: {", ".join(outcome.fitted)}. Unseen: {seen_not if count else "none, there is one run"}.',
        '',
        f'* **Verdict**: {plain(d.verdict)}.',
    ]
    if d.location is not None:
        where = d.location
        drivers = ', '.join(f'largest at {range_text(x)} ({percent(x.share)} of it)' for x in where.drivers)
        phases = ' and '.join(where.phases) or 'all phases'
        lines.append(
            f'* **Located**: {where.stage} stage, {where.channel}, {phases}; {drivers}; root mean square '
            f'{error_text(where.channel, where.size)}.'
        )
    lines.append(f'* **In one sentence**: {d.headline}')
    for f in d.findings:
        lines += [f'* **Named**: {plain(f.effect)} ({f.stage}), {probability_text(f)}; {told_apart(f)}.']
    if not d.findings:
        lines.append('* **Named**: nothing.')
    if outcome.errors is not None:
        before, after = outcome.errors.recalibrated[0], outcome.errors.improved[0]
        lines.append(
            f'* **Unseen runs**, gain and zero fitted: {100 * before:.1f} % of the peak recalibrated, '
            f'{100 * after:.1f} % with what was found.'
        )
    for name, fit in d.fit.items():
        if fit.held_out is not None:
            lines.append(
                f'* **Within the diagnosis** (held out): {name} {error_text(name, fit.held_out.before)} recalibrated, '
                f'{error_text(name, fit.held_out.after)} improved, noise {error_text(name, fit.noise)}.'
            )
    if d.unexplained is not None:
        u = d.unexplained
        lines.append(f'* **Unexplained**: {percent(u.share)} of the misfit, {u.stage} stage, with {range_text(u)}.')
    else:
        lines.append('* **Unexplained**: no structure that stands out of the noise as these runs define it.')
    if d.next_experiment is not None:
        p = d.next_experiment
        first, second = map(plain, p.separates)
        lines.append(
            f'* **Next**: {plain(p.name)} would tell {first} from {second} with probability {chance(p.power)}.'
        )
    else:
        lines.append(
            '* **Next**: the same with a thermometer and a resistance: one channel cannot tell the stages apart.'
        )
    return [*lines, '']


def forced_air(free: Sequence[Experiment], forced: Sequence[Experiment], nominal: Parameters) -> list[str]:
    """Fit in free air, diagnose forced air: more heat exchange is the right answer."""
    still = calibrate(free, nominal)
    found = diagnose(forced, still.parameters)
    windy = calibrate(forced, still.parameters)
    ratio = found.improved['hA'] / still.parameters['hA']
    named = ', '.join(f'{plain(f.effect)} ({f.stage}, {probability_text(f)})' for f in found.findings)
    before, after = slowness(still), slowness(windy)
    fits = '; '.join(
        f'{name} {error_text(name, f.nominal)} as in free air, {error_text(name, f.calibrated)} recalibrated, '
        f'{error_text(name, f.improved)} improved'
        for name, f in found.fit.items()
    )
    return [
        '### A known answer: fitted in free air, diagnosed in forced air',
        '',
        f'The free-air runs of 3 W give C/hA = {combination(still, "C/hA")} s, the forced-air runs '
        f'{combination(windy, "C/hA")} s. With the free-air muscle as the nominal one, the verdict on the forced-air '
        f'runs is **{plain(found.verdict)}**, named: {named or "nothing"}; hA is {ratio:.2g} times that of free air.',
        f'More heat exchange is the right answer. C/hA falls by a factor of {before / after:.1f}; the fit puts '
        f'{ratio:.1f} of it into hA and the rest into C, because one output does not tell them apart. RMSE: {fits}.',
        '',
    ]


def slowness(found: Calibration) -> float:
    """C/hA, s."""
    return next(e.value for e in found.combinations if e.name == 'C/hA')


def combination(found: Calibration, name: str) -> str:
    """A ratio of a calibration with its interval."""
    e: Estimate = next(e for e in found.combinations if e.name == name)
    return f'{e.value:.3g} ({e.low:.3g} to {e.high:.3g})'

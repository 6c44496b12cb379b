"""What the diagnosis says of the public rigs' recordings: part of scripts/real_recordings.py --diagnose.

Of each group a few runs, of different powers, are diagnosed with no hint; the others are unseen: other runs, and where
there are more than three powers another power. Specimens of a group differ in their gain, which is no physics: each run
is first divided by its own gain relative to the group's, from the calibration with a gain for each run.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis
from tcp_muscle_ros.diagnosis.diagnose import diagnose
from tcp_muscle_ros.diagnosis.fitting.calibration import Calibration, Estimate, calibrate
from tcp_muscle_ros.diagnosis.hypothesis.problem import FLOATING_ZERO
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.report.words import chance, error_text, percent, plain, probability_text, range_text, told_apart

MOST = 500  # samples a run, averaged in blocks beyond: the time constants are seconds
FITTED = 3  # runs


@dataclass(frozen=True)
class Outcome:
    """A group's diagnosis, what it was made from, and the errors on the runs that it has not seen (share of peak)."""

    title: str
    diagnosis: Diagnosis
    fitted: tuple[str, ...]
    unseen: tuple[str, ...]
    before: float
    after: float


def power_of(name: str) -> str:
    """The kind of a run, with its power: its name without the last part."""
    return name.rsplit('_', 1)[0]


def chosen(names: Sequence[str]) -> list[str]:
    """The first run of the lowest, a middle and the highest power; of one power the first two."""
    powers: dict[str, list[str]] = {}
    for name in names:
        powers.setdefault(power_of(name), []).append(name)
    kinds = sorted(powers)
    if len(kinds) == 1:
        return powers[kinds[0]][: max(1, min(FITTED - 1, len(names) - 1))]
    places = np.unique(np.linspace(0, len(kinds) - 1, min(FITTED, len(kinds))).round().astype(int))
    return [powers[kinds[k]][0] for k in places]


def one_gain(runs: Sequence[Experiment], nominal: Parameters) -> list[Experiment]:
    """The runs divided by their own gain relative to the geometric mean of all."""
    together = calibrate(runs, nominal, separate=('B',))
    gains = {e.recording: e.value for e in together.estimates if e.name == 'B'}
    mean = float(np.exp(np.mean(np.log(list(gains.values())))))
    return [_scaled(run, gains[k] / mean) for k, run in enumerate(runs)]


def _scaled(run: Experiment, factor: float) -> Experiment:
    observed = {}
    for name, o in run.observed.items():
        rest = float(np.median(o.value[:5]))
        observed[name] = replace(o, value=rest + (o.value - rest) / factor)
    return replace(run, observed=observed)


def diagnose_group(title: str, runs: dict[str, Experiment], nominal: Parameters) -> Outcome:
    """Diagnose a few runs of a group, and look at the others with what came out."""
    names = sorted(runs)
    alike = dict(zip(names, one_gain([runs[n] for n in names], nominal), strict=True))
    fitted = chosen(names)
    unseen = [n for n in names if n not in fitted]
    found = diagnose([alike[n] for n in fitted], nominal)
    plainly = calibrate([alike[n] for n in fitted], nominal).parameters
    before, after = (nrmse([alike[n] for n in unseen], muscle) for muscle in (plainly, found.improved))
    return Outcome(title, found, tuple(fitted), tuple(unseen), before, after)


def nrmse(runs: Sequence[Experiment], muscle: Parameters) -> float:
    """RMSE of free runs over the recorded peak to peak, root mean square over runs; the rig's zero is taken out."""
    shares = []
    for run in runs:
        for name, predicted in run.predict(muscle).items():
            left = run.observed[name].value - predicted
            if name in FLOATING_ZERO:
                left = left - left.mean()
            shares.append(float(np.mean(left**2)) / float(np.ptp(run.observed[name].value)) ** 2)
    return float(np.sqrt(np.mean(shares))) if shares else float('nan')


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
        drivers = ', '.join(f'{percent(x.share)} of it at {range_text(x)}' for x in where.drivers)
        phases = ' and '.join(where.phases) or 'all phases'
        lines.append(
            f'* **Located**: {where.stage} stage, {where.channel}, {phases}; {drivers}; typically '
            f'{error_text(where.channel, where.size)}.'
        )
    for f in d.findings:
        lines += [f'* **Named**: {plain(f.effect)} ({f.stage}), {probability_text(f)}; {told_apart(f)}.']
    if not d.findings:
        lines.append('* **Named**: nothing.')
    if outcome.unseen:
        lines.append(
            f'* **Unseen runs**: RMSE {100 * outcome.before:.1f} % of the peak recalibrated, '
            f'{100 * outcome.after:.1f} % with what was found.'
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
    right = ratio > 1.2 or any(f.effect == 'airflow' for f in found.findings)
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
        f'More heat exchange is the right answer, and it is {"" if right else "not "}what was found. RMSE: {fits}.',
        '',
    ]


def combination(found: Calibration, name: str) -> str:
    """A ratio of a calibration with its interval."""
    e: Estimate = next(e for e in found.combinations if e.name == name)
    return f'{e.value:.3g} ({e.low:.3g} to {e.high:.3g})'

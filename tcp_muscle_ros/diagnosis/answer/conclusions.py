"""What a selection means: findings with their intervals, where, what remains, the verdict, and the better muscle."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.answer.cluster import cluster, one_channel
from tcp_muscle_ros.diagnosis.answer.findings import (
    Diagnosis,
    Finding,
    NotTestable,
    Proposal,
    Ranked,
    RecordingSummary,
    RunToRun,
    Series,
    Value,
)
from tcp_muscle_ros.diagnosis.answer.free_curve import found_law
from tcp_muscle_ros.diagnosis.answer.handed_on import ages_of, handed_on, of_form
from tcp_muscle_ros.diagnosis.answer.improvement import fits, noises, nominal_predictions, own_improvement
from tcp_muscle_ros.diagnosis.answer.known import known_of
from tcp_muscle_ros.diagnosis.answer.next_experiment import LEAST_CHANCE, allowing, propose
from tcp_muscle_ros.diagnosis.answer.notes import every_note, led_by_stops, on_age
from tcp_muscle_ros.diagnosis.answer.probability import of_verdict, probability, terms
from tcp_muscle_ros.diagnosis.answer.repeating import left_unexplained, said_of_runs
from tcp_muscle_ros.diagnosis.answer.sentences import finding_sentence, free_sentence, headline, led_by, with_sticking
from tcp_muscle_ros.diagnosis.answer.sticking import imitated, rests_of
from tcp_muscle_ros.diagnosis.fitting import slips
from tcp_muscle_ros.diagnosis.fitting.calibration import unit_of
from tcp_muscle_ros.diagnosis.fitting.generic import drivers
from tcp_muscle_ros.diagnosis.fitting.least_squares import WIDTH, Fit
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT, START
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.search.location import Location, Unexplained, locate, worst_channel
from tcp_muscle_ros.diagnosis.search.refitting import shrink
from tcp_muscle_ros.diagnosis.search.selected import Chosen, Selection, Weighed
from tcp_muscle_ros.muscle import EFFECTS, LISTED, SPECIFICATIONS, Parameters
from tcp_muscle_ros.settings.rig import Rig, RigLimits, beside

# Below this, in units of the noise, an effect at plausible strength leaves nothing that could be seen.
LEAST_SIGNAL = 3.0
_MATTERS = 0.02  # of what a parameter may differ by, a priori


def summaries(experiments: Sequence[Experiment]) -> tuple[RecordingSummary, ...]:
    """Each recording, and what was assumed of it."""
    found = []
    for e in experiments:
        count = max(float(o.count.sum()) for o in e.observed.values())
        channels = (e.imposed.kind, *e.observed)
        found.append(RecordingSummary(e.name, e.duration, count / max(e.duration, 1e-9), channels, e.notes))
    return tuple(found)


def calibrated_values(fitted: Fit, nominal: Parameters, without: Fit | None = None) -> dict[str, Value]:
    """The calibrated parameters of the muscle, with intervals; what each recording has for itself as ``B [2]``.

    What the effects move them by, as against a fit ``without`` any, is known as well as the effects' form is.
    """
    found = {}
    for k, u in enumerate(fitted.problem.unknowns):
        if '.' in u.name or u.name in (AMBIENT, START):
            continue
        low, high = fitted.interval(k, beside=of_form(fitted, without, k) if without else 0.0)
        value = u.from_fit(float(fitted.z[k]))
        fixed = u.fixed_by(float(np.sqrt(fitted.covariance[k, k])))
        edge = bool(np.isclose(value, u.low, rtol=1e-4) or np.isclose(value, u.high, rtol=1e-4))
        owner = '' if u.recording is None else f' [{u.recording + 1}]'
        unit = unit_of(fitted.problem.model, u.name)
        found[u.name + owner] = Value(value, low, high, unit, nominal[u.name], fixed, edge)
    return found


def _effect_values(fitted: Fit, effect: str) -> dict[str, Value]:
    found = {}
    roles = fitted.problem.model.roles
    leakage = slips.mean_leakage(fitted) if effect == roles.slips else None
    if leakage is not None:
        rate, beside = leakage.rate, WIDTH * leakage.unsure
        row = SPECIFICATIONS[roles.rate]
        found[row.name] = Value(rate, max(rate - beside, row.low), min(rate + beside, row.high), row.unit)
    for k, u in enumerate(fitted.problem.unknowns):
        if not u.name.startswith(f'{effect}.'):
            continue
        low, high = fitted.interval(k)
        value = u.from_fit(float(fitted.z[k]))
        row = SPECIFICATIONS[u.name]
        edge = not u.state and any(np.isclose(value, end, rtol=1e-4) and end != row.value for end in (u.low, u.high))
        usual = float('nan') if EFFECTS[effect].strength == row.name else row.value
        fixed = u.fixed_by(float(np.sqrt(fitted.covariance[k, k])))
        owner = '' if u.recording is None else f' [{u.recording + 1}]'
        found[row.name + owner] = Value(value, low, high, row.unit, usual, fixed, edge)
    for row in EFFECTS[effect].parameters:
        if row.choices:
            chosen = fitted.problem.parameters[f'{effect}.{row.name}']
            found[row.name] = Value(chosen, chosen, chosen, row.unit, row.value)
    return found


def _sensors(fitted: Fit, chosen: Sequence[Chosen]) -> dict[str, Value]:
    """Sensor nuisances: effects of the sensor stage, and what each recording started from."""
    found: dict[str, Value] = {}
    for c in chosen:
        if c.definition.stage == 'sensor':
            found |= {f'{c.effect}.{name}': v for name, v in _effect_values(fitted, c.effect).items()}
    for k, u in enumerate(fitted.problem.unknowns):
        if u.recording is not None and u.name in (AMBIENT, START):
            low, high = fitted.interval(k)
            found[f'{u.name} [{u.recording + 1}]'] = Value(u.from_fit(float(fitted.z[k])), low, high, 'K', u.start)
    return found


def _most_improved(selection: Selection) -> str | None:
    """The channel of whose misfit the chosen effects take the largest share away; None where none were chosen."""
    if not selection.chosen:
        return None
    had, has = selection.calibrated.mean_square, selection.final.mean_square
    return min(had, key=lambda name: has[name] / had[name])


def most_missed(selection: Selection) -> str | None:
    """The channel that the calibrated model misses by the most noises, of those where that has structure; None where
    nothing has."""
    missed, noise = selection.calibrated.mean_square, selection.structure_after
    standing = [name for name, s in selection.structure_before.items() if s.significant]
    return max(standing, key=lambda name: missed[name] / noise[name].noise.sigma ** 2, default=None)


def _findings(selection: Selection, remains: Unexplained | None) -> tuple[Finding, ...]:
    final = selection.final
    found = []
    for c in selection.chosen:
        effect = c.definition
        values = _effect_values(final, c.effect)
        law = found_law(selection, c) if effect.free is not None else None
        likely = _weighed(selection, c, values, remains is not None)
        found.append(
            Finding(
                c.effect,
                effect.stage,
                free_sentence(c.effect, law, likely.probability)
                if law
                else finding_sentence(c.effect, values, c.indistinguishable, likely.probability),
                effect.equation,
                values,
                likely.probability,
                c.indistinguishable,
                own_improvement(selection, c.effect),
                c.drop,
                law,
                likely.evidence,
                cluster(c),
                one_channel(final.problem),
            )
        )
    # Physics before sensors, the stronger first.
    return tuple(sorted(found, key=lambda f: (f.stage == 'sensor', -f.gain)))


def weighed(selection: Selection, runs: RunToRun | None) -> dict[str, Weighed]:
    """How likely each chosen effect is there, and by what."""
    final, remains = selection.final, left_unexplained(selection, runs) is not None
    return {c.effect: _weighed(selection, c, _effect_values(final, c.effect), remains) for c in selection.chosen}


def _weighed(selection: Selection, chosen: Chosen, values: Mapping[str, Value], anything_left: bool) -> Weighed:
    evidence = terms(selection, chosen, values, anything_left)
    return Weighed(chosen.effect, probability(evidence, selection.final.problem.policy.odds), evidence)


def not_testable(selection: Selection, untried: Mapping[str, str], differ: bool = False) -> tuple[NotTestable, ...]:
    """The effects of which these recordings could not have shown anything, and why; none that was fitted to them, but
    for the form of one that recordings never show.

    Args:
        selection: what was found.
        untried: the effects that were not tried, and why.
        differ: whether what runs of one protocol differ by was allowed beside the noise.
    """
    first, found = selection.first, [NotTestable(name, why) for name, why in untried.items()]
    named = {c.effect for c in selection.chosen}
    fitted = {*first.refitted, *selection.leads, *(each.effect for each in selection.doubtful)}
    lost = 'their noise and what runs of one protocol differ by' if differ else 'their noise'
    weak = (
        f'at plausible strength it would change these recordings by less than {lost} once the parameters are '
        f'recalibrated'
    )
    if not first.signals:  # the work was done before any was looked at
        weak = 'it was not tried'
    # As strong as it promises most, an effect changes them by the root of what it promises.
    best = {c.effect: float(np.sqrt(max(c.gain, 0.0))) for c in first.ranked}
    for name in LISTED:
        hidden, signal = EFFECTS[name].hidden, max(first.signals.get(name, 0.0), best.get(name, 0.0))
        unseen = name not in fitted and signal < LEAST_SIGNAL
        if name not in (*untried, *named) and (hidden or unseen):  # what is hidden is another form than was fitted
            found.append(NotTestable(name, hidden or weak))
    return tuple(found)


def _proposal(selection: Selection, limits: RigLimits | None) -> Proposal | None:
    """The experiment that tells the strongest finding of which there is doubt from what the data admit in its place."""
    for c in selection.chosen:
        if not c.indistinguishable or EFFECTS[c.effect].free is not None:
            continue
        rivals = {r.effect: r for r in c.rivals}
        alike = [rivals[name] for name in (c.effect, *c.indistinguishable)]
        return propose(alike, shrink(alike[0].fit, c.effect), c.drop, limits)
    return None


def _parameters_wrong(selection: Selection, nominal: Parameters) -> bool:
    """Whether recalibration mattered: the muscle's parameters lie outside what the data leave around nominal.

    All together, for what the data fix may be a combination, such as C/hA, and none of its members.
    """
    fitted = selection.calibrated
    mine = [k for k, u in enumerate(fitted.problem.unknowns) if u.recording is None and '.' not in u.name]
    unknowns = [fitted.problem.unknowns[k] for k in mine]
    shift = np.array([float(fitted.z[k]) - u.to_fit(nominal[u.name]) for k, u in zip(mine, unknowns, strict=True)])
    scale = np.array([max(u.prior_spread, 1e-9) for u in unknowns])
    distance = shift @ np.linalg.pinv(fitted.covariance[np.ix_(mine, mine)], hermitian=True) @ shift
    return bool(distance > fitted.problem.policy.least_drop + len(mine) and np.max(np.abs(shift) / scale) > _MATTERS)


def _verdict(findings: Sequence[Finding], unexplained: Unexplained | None, apart: bool, wrong: bool) -> str:
    if any(f.stage != 'sensor' for f in findings):
        return 'missing_physics'
    if unexplained is not None:
        return 'unexplained'
    if findings:
        return 'sensor_or_setup'
    if apart:
        return 'not_repeatable'
    return 'wrong_parameters' if wrong else 'match'


def _series(selection: Selection, nominal: Parameters) -> tuple[tuple[Series, ...], ...]:
    calibrated, final = selection.calibrated, selection.best
    nominals = nominal_predictions(final, nominal)
    rows = []
    for k, experiment in enumerate(final.problem.followed):
        outputs = final.outputs[k]
        first, last = calibrated.left[k], final.left[k]
        row = []
        for name, o in experiment.observed.items():
            d = drivers(experiment, outputs, o.time)
            row.append(
                Series(
                    name,
                    o.time,
                    o.value,
                    nominals[k][name],
                    o.value - first[name],
                    o.value - last[name],
                    d.level,
                    d.rate,
                    d.heating,
                )
            )
        rows.append(tuple(row))
    return tuple(rows)


def stage_of(findings: Sequence[Finding], channel: str) -> str:
    """The stage of the finding without which most of a channel would be missed: another acts where it does not show."""
    acting = [f for f in findings if channel in f.improvement]
    return max(acting, key=lambda f: f.improvement[channel].before, default=findings[0]).stage


def _location(selection: Selection, findings: Sequence[Finding], remains: Unexplained | None) -> Location | None:
    """Where the calibrated model misses most; its stage is that of what was named, else of what remains."""
    before = selection.structure_before
    channel, worst = most_missed(selection) or _most_improved(selection), worst_channel(before)
    if channel is None:
        return None
    if findings:
        stage = stage_of(findings, channel)
    else:
        stage = remains.stage if remains else selection.final.problem.model.channels[worst or channel].stage
    return locate(selection.calibrated, before, channel, stage)


def _ranking(selection: Selection) -> tuple[Ranked, ...]:
    """What each effect that was tried first promised, or gained, the best first."""
    refitted = selection.first.refitted
    found = [
        Ranked(c.effect, c.stage, refitted.get(c.effect, c.gain), c.effect in refitted) for c in selection.first.ranked
    ]
    return tuple(sorted(found, key=lambda r: -r.gain))


def conclude(
    selection: Selection,
    nominal: Parameters,
    untried: Mapping[str, str],
    seconds: Mapping[str, float],
    runs: RunToRun | None = None,
    rig: Rig | None = None,
) -> Diagnosis:
    """What a selection means for the nominal muscle; ``untried``: the effects that were not, and why; ``runs``: how
    runs of one protocol differ; ``rig``: what is known of it."""
    remains = left_unexplained(selection, runs)
    findings = _findings(selection, remains)
    location = _location(selection, findings, remains)
    (improved, used), ages = handed_on(selection), ages_of(selection.final.problem)
    rests = rests_of(selection.final, selection.calibrated, improved)
    errors = fits(selection, nominal)
    policy = selection.final.problem.policy
    wrong = _parameters_wrong(selection, nominal) and any(
        f.held_out is not None and f.held_out.before < policy.helps * f.nominal for f in errors.values()
    )
    verdict = _verdict(findings, remains, runs is not None and bool(runs.channel), wrong)
    proposal = likely_to_decide(_proposal(selection, rig.limits if rig else None))
    ranking, experiments = _ranking(selection), selection.final.problem.followed
    stopped = led_by_stops(experiments)
    opening = headline(verdict, findings, location, errors, remains, said_of_runs(runs, bool(ranking)), bool(ranking))
    if proposal is not None:
        used = replace(used, limits=allowing(used.limits, proposal, experiments, improved))
    return Diagnosis(
        headline=led_by(stopped, with_sticking(opening, rests.told)),
        verdict=verdict,
        recordings=summaries(experiments),
        noise=noises(selection),
        calibration=calibrated_values(selection.final, nominal, selection.calibrated),
        sensors=_sensors(selection.final, selection.chosen),
        location=location if verdict not in ('match', 'wrong_parameters', 'not_repeatable') else None,
        findings=findings,
        fit=errors,
        ranking=ranking,
        not_testable=not_testable(selection, untried, runs is not None and bool(runs.channel)),
        unexplained=remains,
        doubtful=selection.doubtful,
        next_experiment=proposal,
        nominal=nominal,
        improved=improved,
        ages=ages,
        rig=beside(rig, used),
        drive=tuple((e.imposed.kind, e.imposed.time, e.imposed.drive) for e in experiments),
        series=_series(selection, nominal),
        notes=(*every_note(selection, remains, untried, runs, rests), *on_age(improved, ages)),
        seconds=dict(seconds),
        calibrated=selection.calibrated.muscle,
        verdict_probability=of_verdict(verdict, findings, policy.odds),
        repeatability={name: runs.sizes.get(name) if runs else None for name in selection.structure_after},
        runs=runs.runs if runs else (),
        would_help=would_help(findings, proposal, experiments),
        sticking=rests.told,
        stopped=stopped,
        imitated=imitated(rests),
        known=known_of(selection, improved),
    )


def likely_to_decide(planned: Proposal | None) -> Proposal | None:
    """The planned experiment, if it decides with a probability of a half at least."""
    return planned if planned is not None and planned.power >= LEAST_CHANCE else None


def would_help(
    findings: Sequence[Finding], proposal: Proposal | None, experiments: Sequence[Experiment]
) -> tuple[str, ...]:
    """What to record where something is undecided and no planned experiment is likely to decide it."""
    undecided = [f for f in findings if f.indistinguishable_from]
    if not undecided or proposal is not None:
        return ()
    seen = {name for e in experiments for name in e.observed}
    channels = experiments[0].model.channels
    found = [channel.adds for name, channel in channels.items() if channel.adds and name not in seen]
    if len({round(float(e.imposed.load[0]), 2) for e in experiments}) < 2:
        found.append('the same protocol under a second load: what grows with the force is told from what does not')
    if len(experiments) < 3:
        found.append('each protocol three times: what repeats is told from what does not')
    return tuple(found) or ('sensors with less noise, or more repetitions of the same protocols',)

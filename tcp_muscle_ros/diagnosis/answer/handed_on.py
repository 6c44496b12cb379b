"""What a selection hands on for use: the muscle as it is now, how old it was before, and what its instruments do."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting import slips
from tcp_muscle_ros.diagnosis.fitting.as_assumed import as_assumed
from tcp_muscle_ros.diagnosis.fitting.calibration import ages
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.hypothesis.latents import Before, Latent
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.model.tcp_muscle import STIFFNESS
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment, one_load
from tcp_muscle_ros.diagnosis.observation.late import taken_out
from tcp_muscle_ros.diagnosis.search.selected import Selection
from tcp_muscle_ros.muscle import EFFECTS, SPECIFICATIONS, Parameters
from tcp_muscle_ros.settings.ages import Age
from tcp_muscle_ros.settings.rig import BY_EFFECT, Quantity, Rig, RigLimits, from_effects

_HUNG = 12  # different loads, at most
_STATED = 1e-4  # A
# Of the logarithm: how far the stiffness of one coil is from that of the next, and how far one that is held may move.
_COIL_TO_COIL, _HELD = 0.1, 0.01
_HARDLY = 0.01  # of what is left of a channel: what it hardly knows
_STEP = 0.7  # of the same: all else follows a stiffness that is moved by a factor of two


def handed_on(selection: Selection) -> tuple[Parameters, Rig]:
    """The improved muscle and the rig that it was recorded on, of one fit.

    The heat loss and the gain of an ammeter may each be one of many that fit: only together they foretell anything.
    """
    fitted = foretelling(as_assumed(selection.best), selection.calibrated)
    return _improved(selection, fitted), _rig(selection.best, fitted.muscle)


def _improved(selection: Selection, fitted: Fit) -> Parameters:
    """The muscle with its calibrated parameters and physics, as old as it is after the last recording.

    What belongs to the sensors goes to the rig. Circumstances stay in the report: a room that drifted, or a draught, in
    these recordings does so otherwise in the next. Of slips at their own instants it keeps the mean.
    """
    final = selection.best
    muscle = as_it_begins(now(fitted), fitted)
    own = _of_single_recordings(final)
    physics = [e for e in muscle.effects if EFFECTS[e].of_muscle and e not in own]
    leakage = leakage_of(selection, fitted)
    if leakage is None:
        return muscle.only_effects(physics)
    roles = final.problem.model.roles
    return muscle.only_effects([*physics, roles.slips]).replace(
        {roles.rate: leakage.rate, roles.begins: leakage.begins}
    )


def leakage_of(selection: Selection, fitted: Fit) -> slips.Leakage | None:
    """The mean of slips at their own instants, where such were found and have a name."""
    return slips.mean_leakage(fitted) if selection.leapt is None else None


def foretelling(final: Fit, calibrated: Fit) -> Fit:
    """The fit that foretells recordings under other loads: where one load was hung, the stiffness is about as assumed.

    Under one load only the form of the stroke over temperature tells the stiffness, and no form is quite the muscle's
    own: with an effect beside it the stiffness may be off by a factor of two while the misfit hardly knows. So it is
    the mean of what the fit says, known as well as the forms are, and of what was assumed, which holds to a tenth;
    all else is fitted to that. A muscle may be of another make than assumed: it goes no farther than the recordings let
    it, of each channel by a share of what was gained there.
    """
    problem, k = final.problem, stiffness_of_one_load(final, calibrated)
    if k is None:
        return final
    unknown = problem.unknowns[k]
    said, assumed = _said(final, calibrated, k), _COIL_TO_COIL**2
    held = (float(final.z[k]) * assumed + unknown.to_fit(unknown.start) * said) / (said + assumed)
    share, before = problem.policy.alike, _missed(calibrated)
    allowed = {n: (1.0 + _HARDLY) * e + share * max(before[n] - e, 0.0) for n, e in _missed(final).items()}
    steps = int(np.ceil(abs(held - float(final.z[k])) / _STEP))
    reached = final
    for z in np.linspace(float(final.z[k]), held, steps + 1)[1:]:
        near = _held_at(reached, k, float(z))
        if any(error > allowed[n] for n, error in _missed(near).items()):
            break
        reached = near
    return reached


def stiffness_of_one_load(final: Fit, calibrated: Fit) -> int | None:
    """Which unknown the stiffness is, where one load was hung and effects were found; else None."""
    effects = set(final.problem.parameters.effects) - set(calibrated.problem.parameters.effects)
    if not effects or not one_load(final.problem.experiments):
        return None
    return next((k for k, u in enumerate(final.problem.unknowns) if u.key == (STIFFNESS, None)), None)


def unsure_of_stiffness(final: Fit, calibrated: Fit, k: int) -> float:
    """How well that stiffness is known (variance, fit's coordinate): by what the fit says and what was assumed."""
    said, assumed = _said(final, calibrated, k), _COIL_TO_COIL**2
    return said * assumed / (said + assumed)


def _said(final: Fit, calibrated: Fit, k: int) -> float:
    """How well a fit says an unknown (variance): as well as the forms are known."""
    return float(final.covariance[k, k]) + of_form(final, calibrated, k) ** 2


def of_form(final: Fit, calibrated: Fit, k: int) -> float:
    """How well an unknown is known beside its covariance (standard deviation, fit's coordinate): what the effects move
    it by, as against a fit without any, is known as well as their form is.

    A stiffness that one load told is astray without them too: there it counts from what was assumed.
    """
    problem, z = final.problem, float(final.z[k])
    unknown = problem.unknowns[k]
    if final is calibrated:
        return 0.0
    bare = (float(z) for u, z in zip(calibrated.problem.unknowns, calibrated.z, strict=True) if u.key == unknown.key)
    moved = abs(z - next(bare, z))
    if unknown.key == (STIFFNESS, None) and one_load(problem.experiments):
        moved = max(moved, abs(z - unknown.to_fit(unknown.start)))
    return problem.policy.form * moved


def _missed(fitted: Fit) -> dict[str, float]:
    """What is left of each channel, root mean square (SI)."""
    return {name: float(np.sqrt(square)) for name, square in fitted.mean_square.items()}


def _held_at(fitted: Fit, k: int, z: float) -> Fit:
    """The fit with one of its unknowns hardly free to move from here."""
    problem, unknown, begun = fitted.problem, fitted.problem.unknowns[k], fitted.z.copy()
    begun[k] = z
    there = replace(unknown, start=unknown.from_fit(z), spread=_HELD)
    unknowns = (*problem.unknowns[:k], there, *problem.unknowns[k + 1 :])
    return fit(replace(problem, unknowns=unknowns), begun, rounds=30, tolerance=1e-5, known=fitted.rough_slopes)


def now(fitted: Fit) -> Parameters:
    """The fitted muscle as old as it is after the last recording."""
    problem = fitted.problem
    if not problem.ages:
        return fitted.muscle
    return fitted.muscle.replace(_age(problem.with_latent(Latent(gone_through(fitted)), 0), 0))


def gone_through(fitted: Fit) -> Before:
    """What the muscle went through in all of its recordings."""
    experiments = fitted.problem.experiments
    return ages((*experiments, experiments[0]), fitted.outputs)[-1]


def as_it_begins(muscle: Parameters, fitted: Fit) -> Parameters:
    """The muscle in the state that a recording of it usually begins in: the mean of all but the first, in which it may
    have been new."""
    found: dict[str, list[float]] = {}
    for name, recording in (u.key for u in fitted.problem.unknowns if u.state and '.' in u.name):
        if recording or len(fitted.problem.experiments) == 1:
            found.setdefault(name, []).append(fitted.values[name, recording])
    return muscle.replace({name: float(np.mean(values)) for name, values in found.items()})


def ages_of(problem: Problem) -> tuple[Age, ...]:
    """How old the muscle was at the beginning of each recording; empty for one that does not age."""
    if not problem.ages:
        return ()
    return tuple(
        Age(e.start_ns, _age(problem, k), float(e.imposed.time[-1]), e.fingerprint)
        for k, e in enumerate(problem.experiments)
    )


def _age(problem: Problem, recording: int) -> dict[str, float]:
    muscle = problem.muscle({}, recording)
    return {name: muscle[name] for name in problem.ages}


def _rig(fitted: Fit, muscle: Parameters) -> Rig:
    """What the instruments do, as far as it is the same in all recordings, and what the rig was seen to do: the values
    are those of ``muscle``, as uncertain as the fit leaves them."""
    found = _stated(muscle.only_effects(set(muscle.effects) - _of_single_recordings(fitted)))
    for k, u in enumerate(fitted.problem.unknowns):
        if u.recording is None and of_instrument(u.name):
            value, (low, high) = muscle[u.name], fitted.interval(k)
            found[u.name] = Quantity(value, min(low, value), max(high, value))
    return _of(muscle, found, fitted.problem.experiments)


def _of_single_recordings(fitted: Fit) -> set[str]:
    """The effects that each recording has for itself."""
    return {u.name.partition('.')[0] for u in fitted.problem.unknowns if u.each_has}


def stated_rig(muscle: Parameters, experiments: Sequence[Experiment]) -> Rig:
    """What the effects of sensors that are on in a muscle say of its rig, and what the rig was seen to do."""
    return _of(muscle, _stated(muscle), experiments)


def _of(muscle: Parameters, found: Mapping[str, Quantity], experiments: Sequence[Experiment]) -> Rig:
    late = taken_out(muscle, experiments[0].model)[1]
    return from_effects(found, late.channel if late else '', limits_seen(experiments, muscle))


def _stated(muscle: Parameters) -> dict[str, Quantity]:
    """By parameter, without intervals."""
    names = [name for name in SPECIFICATIONS if name.partition('.')[0] in muscle.effects and of_instrument(name)]
    return {name: Quantity(muscle[name], muscle[name], muscle[name]) for name in names}


def of_instrument(parameter: str) -> bool:
    """Whether a parameter is what a key of an instrument says: its own, or the delay and the pace of a late channel."""
    effect, _, name = parameter.partition('.')
    late = EFFECTS[effect].late if name else None
    return parameter in BY_EFFECT or (late is not None and name in late[:2])


def limits_seen(experiments: Sequence[Experiment], muscle: Parameters) -> RigLimits:
    """The largest current (of a power or a voltage: that in the ``muscle``), the loads and the longest run that were
    seen."""
    usual = RigLimits()
    current = max(_largest_current(e, muscle) for e in experiments)
    hanging = [e.imposed.load for e in experiments if e.holding.hangs]
    loads = {round(float(load), 4) for hung in hanging for load in np.unique(hung)}
    if len(loads) > _HUNG:  # a load cell's readings, and no weights that were hung
        loads = {round(float(np.median(hung)), 4) for hung in hanging}
    return RigLimits(
        largest_current=current if np.isfinite(current) else usual.largest_current,
        loads=tuple(sorted(loads)),
        held_end=any(e.holding.end == 'blocked' for e in experiments),
        longest_run=max(usual.longest_run, *(e.duration for e in experiments)),
    )


def _largest_current(experiment: Experiment, muscle: Parameters) -> float:
    """A, in one recording; that of another drive rounded up, for it is inferred."""
    if experiment.imposed.kind == 'current':
        return largest_drive([experiment], 'current')
    return rounded_up(float(np.max(experiment.outputs(muscle, only=('current',)).current)))


def rounded_up(current: float) -> float:
    """To 0.1 mA: a limit (A) that what was simulated does not pass."""
    return round(float(np.ceil(current / _STATED - 1e-6)) * _STATED, 4)


def largest_drive(experiments: Sequence[Experiment], kind: str) -> float:
    """The largest drive of a kind (A, W or V) that was recorded; 0 where none was."""
    return max((float(np.max(np.abs(e.imposed.drive))) for e in experiments if e.imposed.kind == kind), default=0.0)

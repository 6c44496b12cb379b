"""Laws without a name: where the listed effects leave a misfit, a table over a driver is tried, instead or beside.

A free law bends to much, so it is taken only where it explains half of what is left, by more than its coefficients
cost, and where unseen data confirm it. It takes the place of a listed effect only where that leaves a misfit, does not
explain nearly all, and the law leaves half of it at most: what the listed form merely misses of the muscle's own is no
reason to lose its name (``bending``). A room or a draught has no form, and bends to much itself: a law of the muscle's
state takes its place wherever it fits better, for a room does not know what state the muscle is in; unless runs of one
protocol differ by what that law leaves.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.fitting.projection import Projection
from tcp_muscle_ros.diagnosis.fitting.run_to_run import differing, repeating
from tcp_muscle_ros.diagnosis.fitting.weather import as_read, evidence_beside
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.model.unknown import LOG_SPREAD, Unknown
from tcp_muscle_ros.diagnosis.observation.experiment import one_load
from tcp_muscle_ros.diagnosis.search.elsewhere import as_small_elsewhere
from tcp_muscle_ros.diagnosis.search.holdout import Gain, confirmation, held_out
from tcp_muscle_ros.diagnosis.search.refitting import shrink
from tcp_muscle_ros.diagnosis.search.remaining import unexplained
from tcp_muscle_ros.diagnosis.search.rivals import Rival, begins, penalised
from tcp_muscle_ros.diagnosis.search.selected import Chosen, Selection
from tcp_muscle_ros.muscle import EFFECTS, SPECIFICATIONS, Parameters
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.free_basis import FREE, Basis, basis

_KNOTS, _FEWEST, _LEVELS = 4, 2, 12
_SELDOM = 0.005  # of the samples: a level that is passed on the way to another
_TRIED = 2  # laws that are refitted beside, and instead of, what is there
HALF = 0.5  # of what is left, that a law takes away at least
_PROBE = 0.1  # of a coefficient's prior spread, by which its slope is taken
_MARGIN = 0.02  # of a driver's range, so that the recordings do not end at the last knot
_ROUNDS = 25
_BEGUN = 0.3  # of the coefficients that the linear approximation has, which the muscle's parameters do not follow yet
_WHEN = 'time'  # the driver that is no state of the muscle
LAST = 1.25  # of the work that may be done: such a law comes last, when the listed ones may have taken it all
_LAGS = (5.0, 30.0, 180.0)  # s: where a law with a lag is begun; a fit goes on from the best


@dataclass(frozen=True)
class Law:
    """A free law in linear approximation: its table's form, where its coefficients would go, and the drop promised;
    ``lag`` (s): in which it is reached, None where it has none."""

    basis: Basis
    values: Array
    gain: float
    lag: float | None = None

    def on(self, parameters: Parameters, values: Array) -> Parameters:
        """The muscle with this law on, with these values at the knots."""
        table = self.basis.on(parameters, values)
        return table if self.lag is None else table.replace({_lag_of(self.basis.effect): self.lag})


def with_free_law(found: Selection, progress: Callable[[], None] | None = None) -> Selection:
    """The selection with a law without a name, where one explains what the listed effects leave, or better what a room
    or a draught was named for; else as it is."""
    unnamed, circumstance = unexplained(found.told), _only_a_circumstance(found)
    if (unnamed is None and circumstance is None) or found.leapt is not None:
        return found
    if not found.final.problem.work.within(LAST):
        return found
    least = found.final.problem.policy.least_drop
    best, scored = found, np.inf
    for begun, keeping in _starts(found) if circumstance is None or unnamed else [less(found, circumstance)]:
        replaced = circumstance if circumstance not in keeping else None  # by a law of the muscle's state
        of_state = replaced is not None
        left = excess(found.told.final if of_state else found.final, found)
        to_beat = _as_followed(begun, replaced.effect) - least if replaced else -np.inf
        tried: list[Rival] = []
        for law in promising(begun, progress, of_state)[:_TRIED]:
            start, kept, better = _alone(found, begun, keeping, refitted(begun, law), law)
            if _is_form(law, kept):
                continue
            score = penalised(better)
            tried.append(Rival(law.basis.effect, better, score))
            remains = excess(better, found)
            gained = penalised(start) - score
            enough = remains < HALF * left or (of_state and penalised(as_read(better)) < to_beat)
            if not (enough and gained > 2.0 * least and score < scored - least):
                continue
            if of_state and differing(better, repeating(better)):  # by a law of its state such runs are alike
                continue
            if (gain := confirmation(start, better)[0]).holds and as_small_elsewhere(better, start):
                chosen = _selection(found, start, better, law, kept, gain)
                best, scored = replace(chosen, unnamed=unnamed), score
                left = remains / HALF  # what comes after must be clearly better still
        if best is not found:
            # Where a law stands instead of a name, none is sought beside it.
            return _without_traces(_among(best, tried), found)
    return best


def _as_followed(begun: Fit, effect: str) -> float:
    """The score of a room or a draught with a course of its own on top of a fit, whose freedom is paid for.

    Under the noise of the instruments, like the law in its place: each under the noise that it leaves itself, what
    leaves more would pass for as good.
    """
    read = as_read(begun)
    return penalised(read) - evidence_beside(read, effect)


def _among(found: Selection, tried: Sequence[Rival]) -> Selection:
    """The selection whose law knows the other laws that were tried in its place, the best of each kind."""
    *kept, law = found.chosen
    others: dict[str, Rival] = {}
    for rival in sorted(tried, key=lambda r: r.score):
        others.setdefault(rival.effect, rival)
    mine = law.rivals[0]
    rivals = (mine, *(r for r in others.values() if r.effect != mine.effect))
    return replace(found, chosen=(*kept, replace(law, rivals=tuple(sorted(rivals, key=lambda r: r.score)))))


def _without_traces(best: Selection, found: Selection) -> Selection:
    """The selection without the effects of which a law leaves next to nothing, or what none in use is: they had bent to
    what it explains. One that leaves too much if it goes stays."""
    slips = found.final.problem.model.roles.slips
    for chosen in best.chosen[:-1]:
        if chosen.effect == slips or begins(Rival(chosen.effect, best.final, 0.0)):
            continue
        final, structure = settle_noise(shrink(best.final, chosen.effect), 1)
        if excess(final, found) < HALF * excess(found.final, found):
            left = tuple(c for c in best.chosen if c is not chosen)
            after = held_out(final, found.kept_back)
            best = replace(best, final=final, chosen=left, after=after, structure_after=structure)
    return best


def excess(fitted: Fit, found: Selection) -> float:
    """The squared error beyond the noise, in units of it, over all channels."""
    total = 0.0
    for name, s in found.structure_after.items():
        count = sum(e.observed[name].time.size for e in fitted.problem.experiments if name in e.observed)
        total += count * max(fitted.mean_square[name] / s.noise.sigma**2 - 1.0, 0.0)
    return total


def _only_a_circumstance(found: Selection) -> Chosen | None:
    """The one effect that is named, where it is of the room and not of the muscle."""
    physics = [c for c in found.chosen if c.definition.stage != 'sensor']
    return physics[0] if len(physics) == 1 and physics[0].definition.circumstance else None


def _starts(found: Selection) -> list[tuple[Fit, tuple[Chosen, ...]]]:
    """What a law is added to, and the effects that stay: instead of the one effect that is named, else beside all."""
    physics = [c for c in found.chosen if c.definition.stage != 'sensor']
    starts = [(found.final, found.chosen)]
    if len(physics) == 1 and not _explains_nearly_all(found):
        starts.insert(0, less(found, physics[0]))
    return starts


def less(found: Selection, chosen: Chosen) -> tuple[Fit, tuple[Chosen, ...]]:
    """The fit without one of the effects, and those that stay."""
    kept = tuple(c for c in found.chosen if c is not chosen)
    return (shrink(found.final, chosen.effect) if kept else found.calibrated), kept


def _explains_nearly_all(found: Selection) -> bool:
    """Whether the listed effects explain so much of what was missed that what is left may be their form."""
    explained = 1.0 - excess(found.final, found) / max(excess(found.calibrated, found), 1e-300)
    return explained >= found.final.problem.policy.nearly_all


def _alone(
    found: Selection, start: Fit, kept: tuple[Chosen, ...], better: Fit, law: Law
) -> tuple[Fit, tuple[Chosen, ...], Fit]:
    """What a law is added to, what stays, and the fit with it: without the effect of its own stage, where it serves as
    well alone from there, and that effect does not explain nearly all."""
    same = [c for c in kept if _is_form(law, (c,))]
    if len(same) != 1 or _explains_nearly_all(found):
        return start, kept, better
    alone = shrink(better, same[0].effect)
    return (
        (*less(found, same[0]), alone) if excess(alone, found) < HALF * excess(start, found) else (start, kept, better)
    )


def _is_form(law: Law, kept: Sequence[Chosen]) -> bool:
    """Whether a law acts where one of these effects does: then it bends that one's form, and is no further physics."""
    stage = EFFECTS[law.basis.effect].stage
    return any(c.definition.stage == stage and not c.definition.circumstance for c in kept)


def promising(
    fitted: Fit, progress: Callable[[], None] | None = None, of_state: bool = False, told: bool = False
) -> list[Law]:
    """Free laws by the drop of the misfit that they promise in linear approximation, less the price of each
    coefficient; only those that promise any. ``of_state``: none that only says what was when; ``told``: none that only
    different loads tell, where one and the same hung."""
    projection, any_load = Projection.of(fitted), not (told and one_load(fitted.problem.experiments))
    laws = []
    for effect in FREE:
        if effect in fitted.problem.parameters.effects:
            continue
        free = EFFECTS[effect].free
        if free is None or (free.by_loads and not any_load):
            continue
        for driver in free.drivers:
            if driver in free.untried or not _known(fitted.problem, driver, any_load) or (of_state and driver == _WHEN):
                continue
            seen = _seen(fitted, driver)
            low, high = _range(seen)
            if not high > low:  # nor where it is no number
                continue
            if progress:
                progress()
            form = basis(effect, low, high, driver, _knots(seen, low, high), both_ways=True)
            judged = [_judged(fitted, projection, form, lag) for lag in (_LAGS if _lag_of(effect) else (None,))]
            law = max((j for j in judged if j is not None), key=lambda j: j.gain, default=None)
            if law is not None and law.gain > fitted.problem.policy.least_drop:
                laws.append(law)
    return sorted(laws, key=lambda law: -law.gain)


def _known(problem: Problem, driver: str, any_load: bool) -> bool:
    """Whether the recordings say what a driver was: it was imposed in all, or something that shows it was recorded; and
    nothing else goes with it under the load that hung, unless ``any_load``."""
    depends = problem.model.laws.get(driver)
    if depends is None or (depends.by_loads and not any_load):
        return False
    given = all(e.holding.end in depends.given_at for e in problem.experiments)
    return given or not depends.shown_by or any(depends.shown_by & set(e.observed) for e in problem.experiments)


def _seen(fitted: Fit, driver: str) -> Array:
    """What a driver was in the recordings, shape (samples of all)."""
    column = fitted.problem.model.laws[driver].column
    return np.concatenate([getattr(o, column) for o in fitted.outputs])


def _range(seen: Array) -> tuple[float, float]:
    """Where a driver goes; a constant one has no range."""
    low, high = float(seen.min()), float(seen.max())
    if not high - low > 1e-6 * max(abs(high), 1e-12):
        return low, low
    spare = _MARGIN * (high - low)
    return low - spare, high + spare


def _knots(seen: Array, low: float, high: float) -> int:
    """How many knots a curve over a driver has: fewer than the levels at which it was seen, such as loads that were
    hung, and none far from all of them.

    A curve with as many knots as levels goes through all of them, whatever it does between; and nothing says where a
    knot goes that lies between two loads.
    """
    samples, ends = np.histogram(seen, _LEVELS, (low, high))
    levels = (0.5 * (ends[1:] + ends[:-1]))[samples > _SELDOM * seen.size]
    for count in range(min(levels.size - 1, _KNOTS), _FEWEST, -1):
        knots, half = np.linspace(low, high, count), 0.5 * (high - low) / (count - 1)
        if np.all(np.min(np.abs(knots[:, None] - levels), axis=1) <= half):
            return count
    return _FEWEST


def _lag_of(effect: str) -> str:
    """The parameter of a law that is the time in which it is reached; empty where it has none."""
    free = EFFECTS[effect].free
    return f'{effect}.{free.lag}' if free is not None and free.lag else ''


def _judged(fitted: Fit, projection: Projection, form: Basis, lag: float | None) -> Law | None:
    """The best coefficients in linear approximation, with this lag."""
    free = EFFECTS[form.effect].free
    assert free is not None
    law = Law(form, np.zeros(len(form.names)), 0.0, lag)
    problem, unknowns = fitted.problem, fitted.z.size
    columns = []
    for k in range(len(form.names)):
        values = np.zeros(len(form.names))
        values[k] = _PROBE * free.width
        changed = replace(problem, parameters=law.on(problem.parameters, values))
        moved = changed.predictions(fitted.z)
        parts = [
            -problem.columns({name: (after[name] - shown)[:, None] for name, shown in before.items()}, j)[:, 0]
            for j, (before, after) in enumerate(zip(fitted.predictions, moved, strict=True))
        ]
        columns.append(np.concatenate([*parts, np.zeros(unknowns)]) / (_PROBE * free.width))
    stacked = np.column_stack(columns)
    if not np.all(np.isfinite(stacked)):
        return None
    stacked = stacked - projection.orthonormal @ (projection.orthonormal.T @ stacked)
    normal = stacked.T @ stacked + form.prior.T @ form.prior
    reached = stacked.T @ projection.left
    values = np.linalg.solve(normal, reached)
    return replace(law, values=values, gain=float(reached @ values) - 2.0 * len(values))


def refitted(fitted: Fit, law: Law) -> Fit:
    """The fit with the law on, its coefficients unknown, from a little of what the linear approximation has."""
    problem, added = with_law(fitted.problem, law)
    begun = [*(_BEGUN * law.values), *([] if law.lag is None else [law.lag])]
    start = np.concatenate([fitted.z, [u.to_fit(_inside(u, v)) for u, v in zip(added, begun, strict=True)]])
    return fit(problem, start, rounds=_ROUNDS, tolerance=1e-5)


def _inside(unknown: Unknown, value: float) -> float:
    return float(min(max(value, unknown.low), unknown.high))


def with_law(problem: Problem, law: Law) -> tuple[Problem, tuple[Unknown, ...]]:
    """The problem with a law's coefficients as further unknowns, around nothing, and its lag; and these."""
    free = EFFECTS[law.basis.effect].free
    assert free is not None
    bounds = {name: SPECIFICATIONS[name] for name in law.basis.names}
    added = tuple(Unknown(name, 0.0, row.low, row.high, free.width) for name, row in bounds.items())
    parameters = law.on(problem.parameters, np.zeros(len(added)))
    if law.lag is not None:
        row = SPECIFICATIONS[name := _lag_of(law.basis.effect)]
        added = (*added, Unknown(name, law.lag, row.low, row.high, LOG_SPREAD, log=True))
    return replace(problem, parameters=parameters, unknowns=(*problem.unknowns, *added)), added


def _selection(found: Selection, start: Fit, better: Fit, law: Law, kept: Sequence[Chosen], gain: Gain) -> Selection:
    """The selection that has the law, and the listed effects that stay."""
    final, structure = settle_noise(better, 1)
    drop = penalised(start) - penalised(better)
    replaced = [c.effect for c in found.chosen if c not in kept]
    share = 1.0 - excess(better, found) / max(excess(found.calibrated, found), 1e-300)
    effect = law.basis.effect
    rivals = (Rival(effect, better, penalised(better)),)
    chosen = Chosen(effect, drop, gain, share, rivals, tuple(replaced), _closest(found, start, replaced, kept))
    return replace(
        found,
        final=final,
        chosen=(*kept, chosen),
        after=held_out(final, found.kept_back),
        structure_after=structure,
    )


def _closest(found: Selection, start: Fit, replaced: Sequence[str], kept: Sequence[Chosen]) -> tuple[str, float] | None:
    """The listed effect that comes closest to a law, and its drop from where the law has its own: that in whose place
    it stands, else the best of those that were tried alone; beside others none was."""
    if replaced:
        return replaced[0], penalised(start) - penalised(found.final)
    return max(found.first.refitted.items(), key=lambda one: one[1], default=None) if not kept else None

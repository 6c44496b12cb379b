"""Select the effects that the recordings demand: forward, with swaps and pruning, each confirmed on unseen data.

Sensors, physics and parameters compete on equal terms: every step refits all of them together. An effect is accepted
when the whitened misfit falls by more than chance gives over all that were tried, when unseen recordings improve, and
when the gain is a real share of what was unexplained.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.diagnosis.calibration import quick_noise
from tcp_muscle_ros.diagnosis.candidates import Candidate, screen, with_effect, without_effect
from tcp_muscle_ros.diagnosis.fitting import Fit, fit
from tcp_muscle_ros.diagnosis.generic import Structure, drivers, structure
from tcp_muscle_ros.diagnosis.holdout import Gain, HeldOut, held_out, improvement
from tcp_muscle_ros.diagnosis.noise import Noise
from tcp_muscle_ros.diagnosis.replicates import pure_error
from tcp_muscle_ros.muscle import EFFECTS

MOST_EFFECTS = 4
SHORTLIST, _REVISED = 7, 5
# 2 ln(trials / level) for some hundred directions at a level of 1 in 100, and 2 for each further parameter.
THRESHOLD = 20.0
PER_PARAMETER = 2.0
# Models whose misfit differs by less than this are not told apart: odds of e^3 = 20 to 1.
AMBIGUOUS = 6.0
# No listed form is quite the muscle's own. Where two explain all but this share of the same misfit, form decides
# nothing, however many samples there are; and what remains of it beside a strong effect gets no name of its own.
ALIKE = 0.02
LEAST_SHARE = 0.08
_TRIES = 3


@dataclass(frozen=True)
class Rival:
    """A model that competes for the place of one effect: the fit, and its objective."""

    effect: str
    fit: Fit
    score: float


def margin(drop: float) -> float:
    """The difference of scores below which two models are not told apart, given what both explain."""
    return max(AMBIGUOUS, ALIKE * drop)


def close_rivals(rivals: Sequence[Rival], drop: float) -> list[Rival]:
    """Those that are not told from the best."""
    best = min(r.score for r in rivals)
    return [r for r in rivals if r.score - best < margin(drop)]


@dataclass(frozen=True)
class Chosen:
    """One accepted effect: its drop of the misfit, the unseen data's word, and its rivals (best first, itself too)."""

    effect: str
    drop: float
    gain: Gain
    rivals: tuple[Rival, ...]

    @property
    def indistinguishable(self) -> tuple[str, ...]:
        """The effects that the data admit in its place."""
        return tuple(r.effect for r in close_rivals(self.rivals, self.drop) if r.effect != self.effect)

    @property
    def confidence(self) -> float:
        """Its share of the likelihood among its rivals."""
        scores = np.array([r.score for r in self.rivals])
        weights = np.exp(-0.5 * AMBIGUOUS / margin(self.drop) * (scores - scores.min()))
        mine = next(w for w, r in zip(weights, self.rivals, strict=True) if r.effect == self.effect)
        return float(mine / weights.sum())


@dataclass(frozen=True)
class Selection:
    """The outcome: the calibrated model, the selected one, and how both do on unseen data."""

    calibrated: Fit
    final: Fit
    chosen: tuple[Chosen, ...]
    before: HeldOut
    after: HeldOut
    structure_before: dict[str, Structure]
    structure_after: dict[str, Structure]
    ranked: tuple[Candidate, ...]
    refitted: dict[str, float]
    signals: dict[str, float]
    rejected: tuple[str, ...] = ()


def structures(fitted: Fit) -> dict[str, Structure]:
    """The generic model of what a fit leaves, by channel."""
    problem = fitted.problem
    values = fitted.values
    outputs = [problem.outputs(values, k) for k in range(len(problem.experiments))]
    left = [problem.raw_residuals(values, k) for k in range(len(problem.experiments))]
    floor = quick_noise(problem.experiments)
    found = {}
    for name in sorted({n for e in problem.experiments for n in e.observed}):
        owners = [k for k, e in enumerate(problem.experiments) if name in e.observed]
        times = [problem.experiments[k].observed[name].time for k in owners]
        drive = [drivers(problem.experiments[k], outputs[k], t) for k, t in zip(owners, times, strict=True)]
        mine = [left[k][name] for k in owners]
        found[name] = structure(mine, times, drive, floor[name].sigma, pure_error(problem.experiments, mine, name))
    return found


def robust_noise(found: dict[str, Structure]) -> dict[str, Noise]:
    """The noise by channel, with what its colour does not cover added to its size."""
    return {name: Noise(s.noise.sigma * float(np.sqrt(s.inflation)), s.noise.phi) for name, s in found.items()}


def settle_noise(fitted: Fit, rounds: int = 2) -> tuple[Fit, dict[str, Structure]]:
    """Refit with the noise that the generic model leaves, until both agree."""
    found = structures(fitted)
    for _ in range(rounds):
        fitted = fit(fitted.problem.with_noise(robust_noise(found)), fitted.z, rounds=8, tolerance=1e-5)
        found = structures(fitted)
    return fitted, found


def penalised(fitted: Fit) -> float:
    """The objective with a price on parameters of effects, so that a flexible rival does not win by flexibility."""
    count = sum('.' in u.name for u in fitted.problem.unknowns)
    return fitted.objective + PER_PARAMETER * count


def grow(fitted: Fit, candidate: Candidate, rounds: int = 10) -> Fit:
    """Refit with one more effect."""
    problem = with_effect(fitted.problem, candidate.effect, candidate.values)
    added = problem.unknowns[len(fitted.problem.unknowns) :]
    z0 = np.concatenate([fitted.z, [u.to_fit(candidate.values[u.name]) for u in added]])
    return fit(problem, z0, rounds=rounds, tolerance=1e-5)


def shrink(fitted: Fit, effect: str, rounds: int = 8) -> Fit:
    """Refit without one of the effects."""
    problem = without_effect(fitted.problem, effect)
    kept = {u.key for u in problem.unknowns}
    z0 = np.array([z for z, u in zip(fitted.z, fitted.problem.unknowns, strict=True) if u.key in kept])
    return fit(problem, z0, rounds=rounds, tolerance=1e-5)


def _prefer(rivals: Sequence[Rival], bare: float) -> Rival:
    """Among models that are not told apart the simplest: a sensor before physics, fewer parameters before more.

    ``bare`` is the score without any of them.
    """
    close = close_rivals(rivals, bare - min(r.score for r in rivals))
    return min(close, key=lambda r: (EFFECTS[r.effect].stage != 'sensor', len(EFFECTS[r.effect].parameters), r.score))


def rivals_for(
    base: Fit, ranked: Sequence[Candidate], progress: Callable[[], None] | None, most: int = SHORTLIST
) -> list[Rival]:
    """Refit the most promising candidates on top of a fit, best first."""
    found = []
    promising = [c for c in ranked if c.gain > 0.25 * ranked[0].gain or c.gain > THRESHOLD][:most]
    for candidate in promising:
        if progress:
            progress()
        grown = grow(base, candidate)
        found.append(Rival(candidate.effect, grown, penalised(grown)))
    return sorted(found, key=lambda r: r.score)


def _share(before: dict[str, Structure], fitted: Fit, after: Fit) -> float:
    """The largest share, over channels, of the misfit above noise that went."""
    shares = []
    for name, s in before.items():
        a = _mean_square(fitted, name)
        b = _mean_square(after, name)
        gap = a - s.noise.sigma**2
        if s.significant and gap > 0.0:
            shares.append((a - b) / gap)
    return max(shares, default=0.0)


def _mean_square(fitted: Fit, channel: str) -> float:
    left = [
        fitted.problem.raw_residuals(fitted.values, k)[channel]
        for k, e in enumerate(fitted.problem.experiments)
        if channel in e.observed
    ]
    return float(np.mean(np.concatenate(left) ** 2))


def select(
    calibrated: Fit, effects: Sequence[str], progress: Callable[[], None] | None = None, most: int = MOST_EFFECTS
) -> Selection:
    """Select effects on top of a calibrated fit.

    ``effects`` are the candidates by name. Returns every stage's evidence; accepting nothing is a full answer.
    """
    calibrated, before_structure = settle_noise(calibrated)
    before = held_out(calibrated)
    present, word = calibrated, before
    found_structure = before_structure
    first_ranked: tuple[Candidate, ...] = ()
    signals: dict[str, float] = {}
    refitted: dict[str, float] = {}
    accepted: list[str] = []
    rejected: list[str] = []
    gains: dict[str, Gain] = {}
    explained = 0.0
    while len(accepted) < most:
        pool = [e for e in effects if e not in accepted]
        ranked, seen = screen(present, pool, progress)
        if not first_ranked:
            first_ranked, signals = tuple(ranked), seen
        if not ranked or ranked[0].gain < 0.5 * THRESHOLD:
            break
        rivals = rivals_for(present, ranked, progress)
        bare = penalised(present)
        if not accepted:
            refitted = {r.effect: bare - r.score for r in rivals}
        picked = None
        for _ in range(_TRIES):
            rivals = [r for r in rivals if bare - r.score >= max(THRESHOLD, ALIKE * explained)]
            if not rivals:
                break
            pick = _prefer(rivals, bare)
            gain = improvement(word, held_out(pick.fit))
            if gain.holds and _share(found_structure, present, pick.fit) >= LEAST_SHARE:
                picked = pick
                break
            rejected.append(pick.effect)
            rivals = [r for r in rivals if r is not pick]
        if picked is None:
            break
        accepted.append(picked.effect)
        gains[picked.effect] = gain
        explained += bare - picked.score
        present, found_structure = settle_noise(picked.fit, 1)
        word = held_out(present)
    present, accepted, contests = _revise(present, accepted, effects, progress)
    if accepted:
        present, found_structure = settle_noise(present, 1)
        word = held_out(present)
    # Compared under one noise: the final model's.
    reference = fit(calibrated.problem.with_noise(present.problem.noise), calibrated.z, rounds=6, tolerance=1e-5)
    compared = held_out(reference) if accepted else before
    chosen = []
    for effect in accepted:
        drop, rivals = contests[effect]
        chosen.append(Chosen(effect, drop, gains.get(effect, improvement(compared, word)), tuple(rivals)))
    return Selection(
        reference if accepted else calibrated,
        present,
        tuple(sorted(chosen, key=lambda c: -c.drop)),
        compared,
        word,
        before_structure,
        found_structure,
        first_ranked,
        refitted,
        signals,
        tuple(rejected),
    )


def _revise(
    present: Fit, accepted: list[str], effects: Sequence[str], progress: Callable[[], None] | None
) -> tuple[Fit, list[str], dict[str, tuple[float, list[Rival]]]]:
    """Swap and prune: each effect must beat, in the company of the others, whatever could replace it."""
    contests: dict[str, tuple[float, list[Rival]]] = {}
    for _ in range(2):
        changed = False
        for effect in list(accepted):
            bare = shrink(present, effect)
            pool = [e for e in effects if e == effect or e not in accepted]
            ranked, _signals = screen(bare, pool, progress)
            rivals = [r for r in rivals_for(bare, ranked, progress, _REVISED) if r.effect != effect]
            rivals = sorted([*rivals, Rival(effect, present, penalised(present))], key=lambda r: r.score)
            drop = penalised(bare) - min(r.score for r in rivals)
            if drop < THRESHOLD:
                present, changed = bare, True
                accepted.remove(effect)
                contests.pop(effect, None)
                continue
            pick = _prefer(rivals, penalised(bare))
            if pick.effect != effect:
                present, changed = pick.fit, True
                accepted[accepted.index(effect)] = pick.effect
                contests.pop(effect, None)
            contests[pick.effect] = (drop, rivals)
        if not changed or len(accepted) < 2:
            break
    while accepted:
        weakest = min(accepted, key=lambda e: contests[e][0])
        if contests[weakest][0] >= ALIKE * max(contests[e][0] for e in accepted):
            break
        present = shrink(present, weakest)
        accepted.remove(weakest)
    return present, accepted, {e: contests[e] for e in accepted}

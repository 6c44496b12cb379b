"""Select the effects that the recordings demand: forward, with swaps and pruning, each confirmed on unseen data.

Sensors, physics and parameters compete on equal terms: every step refits all of them together. An effect is accepted
when the whitened misfit falls by more than chance gives over all that were tried, when unseen recordings improve, and
when the gain is a real share of what was unexplained.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tcp_muscle_ros.diagnosis.calibration import quick_noise
from tcp_muscle_ros.diagnosis.candidates import PER_PARAMETER, Candidate, screen, with_effect, without_effect
from tcp_muscle_ros.diagnosis.fitting import Fit, fit, slopes
from tcp_muscle_ros.diagnosis.generic import Structure, drivers, structure
from tcp_muscle_ros.diagnosis.holdout import Fold, Gain, HeldOut, conditions, confirmation, held_out, stretches
from tcp_muscle_ros.diagnosis.noise import Noise
from tcp_muscle_ros.diagnosis.replicates import pure_error
from tcp_muscle_ros.muscle import EFFECTS, SPECIFICATIONS

MOST_EFFECTS = 4
SHORTLIST, _REVISED = 6, 3
_MANY = 36  # unknowns: beyond, a refit takes many times as long, and what could replace an effect is tried once
# 2 ln(trials / level) for some hundred directions at a level of 1 in 100.
THRESHOLD = 20.0
# Models whose misfit differs by less than this are not told apart: odds of e^3 = 20 to 1.
AMBIGUOUS = 6.0
# No listed form is quite the muscle's own. Where two explain all but this share of the same misfit, form decides
# nothing, however many samples there are; and what remains of it beside a strong effect gets no name of its own.
ALIKE = 0.02
LEAST_SHARE = 0.08
LEAST_SHARE_OF_ALL = 0.05
# Of what is left without it, an effect takes most; while others are still to be found, less.
_OF_REST, _OF_REST_AT_FIRST = 0.65, 0.4
_FAR = 2.5  # times its usual strength: farther off is hardly ever a sensor that works
_TRIES = 4
_PROMISING = 0.15  # of the best candidate's gain, in linear approximation: worth a refit
_BEATEN = 0.003  # of the best rival's drop: a model that misses so much more is beaten
_HEAT, _LAGGING = 6, 0.3  # rounds that every rival is given, and the share of the best drop that earns it more
_CONTEST = 0.2  # of the best rival's drop: rivals that close are compared once more
_TRIFLE = 0.25  # of the noise's variance: what a companion of a stronger effect must take away at least
_REAL = 0.05  # of a channel's squared error: a drop that needs no further sign of being real


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
    """One accepted effect: its drop of the misfit, the unseen data's word on it in the company of the others, the share
    of the calibrated model's misfit that it takes away (the largest over channels), and its rivals (best first, itself
    too)."""

    effect: str
    drop: float
    gain: Gain
    share: float
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
    """The outcome: the calibrated model, the selected one, and how both do on unseen data.

    ``other_conditions``: these are whole recordings, not stretches of those that were fitted.
    """

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
    other_conditions: bool = True


@lru_cache(maxsize=8)
def structures(fitted: Fit) -> dict[str, Structure]:
    """The generic model of what a fit leaves, by channel."""
    problem = fitted.problem
    values = fitted.values
    outputs = [problem.outputs(values, k) for k in range(len(problem.experiments))]
    left = fitted.left
    floor = quick_noise(problem.experiments)
    found = {}
    for name in sorted({n for e in problem.experiments for n in e.observed}):
        owners = [k for k, e in enumerate(problem.experiments) if name in e.observed]
        times = [problem.experiments[k].observed[name].time for k in owners]
        drive = [drivers(problem.experiments[k], outputs[k], t) for k, t in zip(owners, times, strict=True)]
        mine = [left[k][name] for k in owners]
        averaged = float(np.mean(np.concatenate([problem.experiments[k].observed[name].count for k in owners])))
        repeated = pure_error(problem.experiments, mine, name)
        found[name] = structure(mine, times, drive, floor[name].sigma, repeated, averaged)
    return found


def robust_noise(fitted: Fit, found: dict[str, Structure]) -> dict[str, Noise]:
    """The noise by channel, with what its colour does not cover added to its size, and what the fit misses too.

    A channel that a model cannot follow must not pull the others along: the temperature would be bent until the stroke
    fits. Its weight returns as effects are accepted.
    """
    return {
        name: Noise(max(s.noise.sigma * float(np.sqrt(s.inflation)), fitted.mean_square[name] ** 0.5), s.noise.phi)
        for name, s in found.items()
    }


def with_noise(fitted: Fit, noise: dict[str, Noise]) -> Fit:
    """The same fit under another noise."""
    problem = fitted.problem.with_noise(noise)
    return fit(problem, fitted.z, rounds=20, tolerance=1e-5, known=fitted.rough_slopes)


def settle_noise(fitted: Fit, rounds: int = 2) -> tuple[Fit, dict[str, Structure]]:
    """Refit with the noise that the generic model leaves, until both agree."""
    found = structures(fitted)
    for _ in range(rounds):
        fitted = with_noise(fitted, robust_noise(fitted, found))
        found = structures(fitted)
    return fitted, found


def penalised(fitted: Fit) -> float:
    """The objective with a price on parameters of effects, so that a flexible rival does not win by flexibility."""
    count = sum('.' in u.name for u in fitted.problem.unknowns)
    return fitted.objective + PER_PARAMETER * count


def grow(fitted: Fit, candidate: Candidate, rounds: int) -> Fit:
    """Refit with one more effect, for so many rounds."""
    own = fitted.z.size
    tried = []
    for start in candidate.starts():
        problem = with_effect(fitted.problem, start)
        z = np.concatenate([fitted.z, problem.start()[own:]])
        shown = problem.predictions(z)
        tried.append((float(sum(part @ part for part in problem.residuals(shown))), problem, z, shown))
    _, problem, z, shown = min(tried, key=lambda t: t[0])
    added = slopes(problem, z, shown, range(own, len(problem.unknowns)))
    known = [
        {name: np.hstack([columns, more[name]]) for name, columns in mine.items()}
        for mine, more in zip(fitted.slopes, added, strict=True)
    ]
    return fit(problem, z, rounds=rounds, tolerance=1e-5, known=known, polish=False)


def shrink(fitted: Fit, effect: str, rounds: int = 30) -> Fit:
    """Refit without one of the effects."""
    problem = without_effect(fitted.problem, effect)
    kept = [k for k, u in enumerate(fitted.problem.unknowns) if u in problem.unknowns]
    known = fitted.rough_slopes
    if known is not None:
        known = [{name: columns[:, kept] for name, columns in mine.items()} for mine in known]
    return fit(problem, fitted.z[kept], rounds=rounds, tolerance=1e-5, known=known)


def _prefer(rivals: Sequence[Rival], bare: float) -> Rival:
    """The best model; among those that it does not beat, the simplest.

    That is one that holds for all recordings alike, then a sensor (unless it is off as hardly any ever is) before
    physics, then the fewest parameters. In one
    stage, where form decides, a form with more parameters follows another's by what it may bend: it must be more than
    alike to win. ``bare`` is the score without any of them.
    """
    best = min(r.score for r in rivals)
    close = [r for r in rivals if r.score - best < max(AMBIGUOUS, _BEATEN * (bare - best))]

    def order(rival: Rival) -> tuple[bool, int, int, float]:
        effect = EFFECTS[rival.effect]
        own = any(u.name.startswith(f'{rival.effect}.') and u.recording is not None for u in rival.fit.problem.unknowns)
        rank = 1 if effect.stage != 'sensor' else 2 if _far(rival) else 0
        return own, rank, len(effect.fitted), rival.score

    first = min(close, key=order)
    stage = EFFECTS[first.effect].stage
    alike = [r for r in close_rivals(rivals, bare - best) if EFFECTS[r.effect].stage == stage]
    return min([first, *alike], key=order)


def _far(rival: Rival) -> bool:
    """Whether an effect is much stronger than it usually is."""
    definition = EFFECTS[rival.effect]
    key = f'{rival.effect}.{definition.strength}'
    usual = abs(SPECIFICATIONS[key].value - definition.none)
    return abs(rival.fit.muscle[key] - definition.none) > _FAR * usual


def rivals_for(
    base: Fit,
    ranked: Sequence[Candidate],
    progress: Callable[[], None] | None,
    most: int = SHORTLIST,
    also: Collection[str] = (),
) -> list[Rival]:
    """Refit the most promising candidates on top of a fit, and those of ``also``, best first; those that soon lag
    behind not to the end."""
    promising = [c for c in ranked if c.gain > _PROMISING * ranked[0].gain][:most]
    promising += [c for c in ranked if c.effect in also and c not in promising]
    found = []
    for candidate in promising:
        if progress:
            progress()
        grown = grow(base, candidate, rounds=_HEAT)
        found.append(Rival(candidate.effect, grown, penalised(grown)))
    bare = penalised(base)
    least = bare - _LAGGING * max((bare - r.score for r in found), default=0.0)
    for k, rival in enumerate(found):
        if rival.score <= least:
            if progress:
                progress()
            begun = rival.fit
            fitted = fit(begun.problem, begun.z, rounds=40, tolerance=1e-5, known=begun.rough_slopes)
            found[k] = Rival(rival.effect, fitted, penalised(fitted))
    return sorted(found, key=lambda r: r.score)


def _rescored(bare: Fit, rivals: Sequence[Rival]) -> tuple[float, list[Rival]]:
    """The close rivals, and the score without any, under the noise that the best of them leaves.

    Under the noise of the poorer model, into which its misfit counts, good models look alike.
    """
    drop = penalised(bare) - rivals[0].score
    noise = robust_noise(rivals[0].fit, structures(rivals[0].fit))
    refitted = []
    for rival in rivals:
        if rival.score - rivals[0].score < _CONTEST * drop:
            again = with_noise(rival.fit, noise)
            refitted.append(Rival(rival.effect, again, penalised(again)))
    alone = with_noise(bare, noise)
    return penalised(alone), sorted(refitted, key=lambda r: r.score)


def _share(before: dict[str, Structure], fitted: Fit, after: Fit) -> float:
    """The largest share, over channels, of the misfit above noise that went.

    The noise is that of the better model where it is the smaller: what a model lacks may look like noise to it.
    """
    shares = []
    left = structures(after)
    for name, s in before.items():
        a = fitted.mean_square[name]
        b = after.mean_square[name]
        gap = a - min(s.noise.sigma, left[name].noise.sigma) ** 2
        if (s.significant or a - b > _REAL * a) and gap > 0.0:
            shares.append((a - b) / gap)
    return max(shares, default=0.0)


def select(
    calibrated: Fit, effects: Sequence[str], progress: Callable[[], None] | None = None, most: int = MOST_EFFECTS
) -> Selection:
    """Select effects on top of a calibrated fit.

    ``effects`` are the candidates by name. Returns every stage's evidence; accepting nothing is a full answer.
    """
    calibrated, before_structure = settle_noise(calibrated)
    present = calibrated
    found_structure = before_structure
    first_ranked: tuple[Candidate, ...] = ()
    signals: dict[str, float] = {}
    refitted: dict[str, float] = {}
    accepted: list[str] = []
    contests: dict[str, tuple[float, list[Rival]]] = {}
    rejected: list[str] = []
    while len(accepted) < most and present.problem.work.left:
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
            rivals = [r for r in rivals if bare - r.score >= THRESHOLD]
            if not rivals:
                break
            if len(rivals) > 1:
                settled, close = _rescored(present, rivals)
                effect = _prefer(close, settled).effect
                pick = next(r for r in rivals if r.effect == effect)
            else:
                pick = rivals[0]
            enough = _share(found_structure, present, pick.fit) >= LEAST_SHARE and (
                not accepted or _good_company(calibrated, present, pick.fit, _OF_REST_AT_FIRST)
            )
            if enough and confirmation(present, pick.fit)[0].holds:
                picked = pick
                break
            rejected.append(pick.effect)
            rivals = [r for r in rivals if r is not pick]
        if picked is None:
            break
        accepted.append(picked.effect)
        drop = bare - picked.score
        contests[picked.effect] = drop, [r for r in rivals if bare - r.score > (1.0 - _CONTEST) * drop]
        present, found_structure = settle_noise(picked.fit, 1)
    present, accepted, contests = _revise(present, accepted, effects, contests, progress)
    if accepted:
        present, found_structure = settle_noise(present, 1)
    present, accepted, standing, kept_back = _confirm(present, accepted, contests, calibrated)
    if accepted:
        found_structure = structures(present)
    # Compared under one noise: the final model's.
    reference = with_noise(calibrated, dict(present.problem.noise))
    chosen = []
    for effect in accepted:
        drop, rivals = contests[effect]
        chosen.append(Chosen(effect, drop, *standing[effect], tuple(rivals)))
    return Selection(
        reference if accepted else calibrated,
        present,
        tuple(sorted(chosen, key=lambda c: -c.drop)),
        held_out(reference if accepted else calibrated, kept_back),
        held_out(present, kept_back),
        before_structure,
        found_structure,
        first_ranked,
        refitted,
        signals,
        tuple(rejected),
        kept_back[0].whole is not None,
    )


def _confirm(
    present: Fit, accepted: list[str], contests: dict[str, tuple[float, list[Rival]]], calibrated: Fit
) -> tuple[Fit, list[str], dict[str, tuple[Gain, float]], tuple[Fold, ...]]:
    """Each effect once more on unseen data, in the company of the others: without it they must be predicted worse.

    Returns what was kept back too: other conditions if they could speak for every effect, else stretches.
    """
    standing: dict[str, tuple[Gain, float]] = {}
    kept_back = conditions(present.problem) or stretches(present.problem)
    strongest = max(accepted, key=lambda e: contests[e][0], default='')
    for effect in sorted(accepted, key=lambda e: contests[e][0]):
        bare = shrink(present, effect)
        gain, looked_at = confirmation(bare, present)
        if gain.holds and (effect == strongest or _good_company(calibrated, bare, present, _OF_REST)):
            standing[effect] = gain, _largest_share(calibrated, bare, present)
            if looked_at[0].whole is None:
                kept_back = stretches(present.problem)
        else:
            present = bare
            accepted = [e for e in accepted if e != effect]
    if any('.' in u.name and u.recording is not None for u in present.problem.unknowns):
        kept_back = stretches(present.problem)
    return present, accepted, standing, kept_back


def _good_company(calibrated: Fit, without: Fit, fitted: Fit, rest: float) -> bool:
    """Whether an effect beside a stronger one is more than what the stronger one's form leaves.

    It takes a real share of all that was missed, and a share ``rest`` of what is left: what a form leaves, several
    effects explain a little, and none of them all.
    """
    of_all = _largest_share(calibrated, without, fitted)
    return of_all >= LEAST_SHARE_OF_ALL and _largest_share(without, without, fitted, robust=False) >= rest


def _largest_share(missing: Fit, without: Fit, fitted: Fit, robust: bool = True) -> float:
    """The largest share, over channels, of what one model misses, that an effect takes away from another.

    Channels count in which it takes away something beside the noise; ``robust`` counts what it leaves as noise.
    """
    shares = []
    found = structures(fitted)
    noises = robust_noise(fitted, found) if robust else {name: s.noise for name, s in found.items()}
    for name, noise in noises.items():
        missed = missing.mean_square[name] - noise.sigma**2
        drop = without.mean_square[name] - fitted.mean_square[name]
        if missed > 0.0 and drop > _TRIFLE * noise.sigma**2:
            shares.append(drop / missed)
    return max(shares, default=0.0)


def _revise(
    present: Fit,
    accepted: list[str],
    effects: Sequence[str],
    first: Mapping[str, tuple[float, list[Rival]]],
    progress: Callable[[], None] | None,
) -> tuple[Fit, list[str], dict[str, tuple[float, list[Rival]]]]:
    """Swap and prune: each effect must beat, in the company of the others, whatever could replace it.

    ``first``: the contests in which they were accepted; who came close then is tried again.
    """
    contests = dict(first)
    for _ in range(2 if len(present.problem.unknowns) <= _MANY else 1):
        changed = False
        for effect in list(accepted):
            if not present.problem.work.left:
                break
            bare = shrink(present, effect)
            pool = [e for e in effects if e == effect or e not in accepted]
            ranked, _signals = screen(bare, pool, progress)
            most = _REVISED if len(bare.problem.unknowns) <= _MANY else 1
            known = [r.effect for r in first[effect][1]] if effect in first else []
            found = rivals_for(bare, ranked, progress, most, known)
            rivals = [r for r in found if r.effect != effect]
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
    return present, accepted, contests

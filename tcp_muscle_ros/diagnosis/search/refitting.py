"""Refitting: what competes for the place of one effect, fitted in full, by each of its choices."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit, slopes_with_more
from tcp_muscle_ros.diagnosis.hypothesis.problem import without_effect
from tcp_muscle_ros.diagnosis.search.candidates import Candidate, Screen, best_of, told, with_effect
from tcp_muscle_ros.diagnosis.search.rivals import Rival, penalised
from tcp_muscle_ros.muscle.arrays import Array

SHORTLIST = 6
_PROMISING = 0.15  # of the best candidate's gain, in linear approximation: worth a refit
_CHOOSING = 0.5  # of the best drop: a rival so far is tried by its other choices too
_WHOLE = 40  # rounds of a fit to its end
_HEAT, _LAGGING = 6, 0.3  # rounds that every rival is given, and the share of the best drop that earns it more
_FELL_SHORT = 0.5  # of what it promises: a fit that reaches less began where the effect does nothing
_FARTHER = 4  # times these rounds, where the muscle has a long way back


def grow(fitted: Fit, candidate: Candidate, rounds: int) -> Fit | None:
    """Refit with one more effect, for so many rounds; None where the model runs away with it from every start."""
    grown = _grown(fitted, fitted.z, candidate, rounds)
    if candidate.begun is None:
        return grown
    again = _grown(fitted, candidate.begun, candidate, _FARTHER * rounds)
    return min((f for f in (grown, again) if f is not None), key=lambda f: f.objective, default=None)


def _grown(fitted: Fit, begun: Array, candidate: Candidate, rounds: int) -> Fit | None:
    """Refit with one more effect, with what was unknown before begun here."""
    own = fitted.z.size
    tried = []
    for start in candidate.starts():
        problem = with_effect(fitted.problem, start)
        z = np.concatenate([begun, problem.start()[own:]])
        with np.errstate(over='ignore', invalid='ignore'):  # where it runs away
            shown = problem.predictions(z)
            misfit = float(sum(part @ part for part in problem.residuals(shown)))
        if np.isfinite(misfit):
            tried.append((misfit, problem, z, shown))
    if not tried:
        return None
    _, problem, z, shown = min(tried, key=lambda t: t[0])
    known = slopes_with_more(fitted, problem, z, shown) if begun is fitted.z else None
    return fit(problem, z, rounds=rounds, tolerance=1e-5, known=known, polish=False)


def shrink(fitted: Fit, effect: str, rounds: int = 30) -> Fit:
    """Refit without one of the effects."""
    problem, kept = without_effect(fitted.problem, effect)
    known = fitted.rough_slopes
    if known is not None:
        known = [{name: columns[:, kept] for name, columns in mine.items()} for mine in known]
    return fit(problem, fitted.z[kept], rounds=rounds, tolerance=1e-5, known=known)


def rivals_for(
    base: Fit,
    ranked: Sequence[Candidate],
    progress: Callable[[], None] | None,
    most: int = SHORTLIST,
    also: Collection[str] = (),
) -> list[Rival]:
    """Refit the most promising candidates on top of a fit, and those of ``also``, best first; those that soon lag
    behind what they and others promise not to the end."""
    promising = [c for c in ranked if c.gain > _PROMISING * ranked[0].gain][:most]
    promising += [c for c in ranked if c.effect in also and c not in promising]
    begun = []
    for candidate in promising:
        if progress:
            progress()
        rival = _heated(base, candidate)
        if rival is not None:
            begun.append((candidate, rival))
    bare = penalised(base)
    best = max((bare - rival.score for _, rival in begun), default=0.0)
    found = []
    for candidate, rival in begun:
        # One that promises more than any has reached, and is far from it, has met a long valley.
        if bare - rival.score >= _LAGGING * best or candidate.gain > best:
            if progress:
                progress()
            rival = _to_the_end(rival)
        found.append((candidate, rival))
    bar = bare - _CHOOSING * max((bare - rival.score for _, rival in found), default=0.0)
    chosen = [
        _best_choice(base, c, _afresh(base, c, rival), progress) if rival.score <= bar else rival for c, rival in found
    ]
    return sorted(chosen, key=lambda r: r.score)


def _heated(base: Fit, candidate: Candidate) -> Rival | None:
    """The candidate after a few rounds; from the best of its sets, where it falls short of what it promises by
    as much as an effect explains at least; with the muscle brought back, which takes longer, by most of it."""
    found: list[Rival] = []
    bare = penalised(base)
    for start in (candidate, *candidate.others):
        farther = start.begun is not candidate.begun
        if farther and any(bare - rival.score > _FELL_SHORT * candidate.gain for rival in found):
            break
        grown = grow(base, start, rounds=_HEAT)
        if grown is not None:
            found.append(Rival(candidate.effect, grown, penalised(grown)))
            if candidate.gain - (bare - found[0].score) < base.problem.policy.least_drop:
                break
    return min(found, key=lambda r: r.score, default=None)


def one_for_all(base: Fit, effect: str) -> Rival | None:
    """The effect with one strength for all recordings, refitted on top of a fit; None where the model runs away."""
    return _refitted(base, [c for c in Screen.of(base).candidates(effect) if not c.own], None)


def one_for_each(base: Fit, effect: str, progress: Callable[[], None] | None) -> Rival | None:
    """The circumstance in every recording as it was there, refitted on top of a fit; None where the model runs away."""
    alone = len(base.problem.experiments) == 1  # what a single recording has for itself, all have
    return _refitted(base, [c for c in Screen.of(base).candidates(effect) if c.own or alone], progress)


def _refitted(base: Fit, candidates: Sequence[Candidate], progress: Callable[[], None] | None) -> Rival | None:
    """The most promising of these candidates, refitted."""
    return next(iter(rivals_for(base, [best_of(candidates, 0.0)], progress)), None) if candidates else None


def _to_the_end(rival: Rival) -> Rival:
    """The rival after as many rounds as its fit needs."""
    head = rival.fit
    whole = fit(head.problem, head.z, rounds=_WHOLE, tolerance=1e-5, known=head.rough_slopes)
    return Rival(rival.effect, whole, penalised(whole))


def _afresh(base: Fit, candidate: Candidate, rival: Rival) -> Rival:
    """The rival, or the same begun with the muscle as it was before it was calibrated, where that fits clearly better:
    what the muscle became to make up for an effect may hold a fit back from it. Only of what explains as much as an
    effect at least, for all recordings alike, and beside no other, which would have to begin anew too."""
    policy = base.problem.policy
    if base.problem.parameters.effects or candidate.own or penalised(base) - rival.score < policy.least_drop:
        return rival
    of_recording = [u.recording is not None for u in base.problem.unknowns]
    whole = _grown(base, np.where(of_recording, base.z, base.problem.start()), candidate, _WHOLE)
    if whole is None or rival.score - penalised(whole) < policy.told_apart:
        return rival
    return Rival(rival.effect, whole, penalised(whole))


def _best_choice(base: Fit, candidate: Candidate, rival: Rival, progress: Callable[[], None] | None) -> Rival:
    """The same effect by the choice that fits best: in linear approximation, by which it was made, choices look alike.

    A choice that says which channel or stage an effect touches is plain there; one that brings parameters of its own
    is begun anew.
    """
    best, problem = rival, rival.fit.problem
    for row in rival.definition.parameters:
        key = f'{rival.effect}.{row.name}'
        if not row.choices or row.spelled or row.name in (rival.definition.late or ()) or not told(problem, row):
            continue
        for other in range(len(row.choices)):
            if other == round(problem.parameters[key]) or (rival.definition.hidden and other == row.value):
                continue
            if progress:
                progress()
            if any(r.only and r.only[0] == row.name for r in rival.definition.parameters):
                anew = next((c for c in candidate.by_choice if round(c.values[key]) == other), None)
                again = grow(base, anew, rounds=_HEAT) if anew else None
            else:
                changed = replace(problem, parameters=problem.parameters.replace({key: float(other)}))
                again = fit(changed, rival.fit.z, rounds=_HEAT, tolerance=1e-5, known=rival.fit.rough_slopes)
            if again is not None and penalised(again) < best.score:
                best = _to_the_end(Rival(rival.effect, again, penalised(again)))
    return best

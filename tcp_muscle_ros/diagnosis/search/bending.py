"""The form of what was found, as far as the recordings bend it: handed on with the muscle, not named.

No listed form is quite the muscle's own. Where the listed effects leave a misfit, and a law without a name in the stage
of one of them takes most of it away, also on unseen data, that law is no further physics: it is what the listed form
misses. The effects stay about as strong as they were found; their values and intervals are those without it.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.search.elsewhere import as_small_elsewhere
from tcp_muscle_ros.diagnosis.search.free_laws import HALF, excess, promising, refitted
from tcp_muscle_ros.diagnosis.search.holdout import HeldOut, confirmation, held_out
from tcp_muscle_ros.diagnosis.search.rivals import penalised
from tcp_muscle_ros.diagnosis.search.selected import Selection
from tcp_muscle_ros.muscle import EFFECTS

_TRIED = 2
_AS_WELL = 1.02  # times the error on unseen data
_REAL = 0.25  # of the noise's variance: what a channel is missed by at least beyond it


def with_bent_form(found: Selection, progress: Callable[[], None] | None = None) -> Selection:
    """The selection with the fit in which a law without a name bends a listed form, where one does; else as it is.

    Beside a draught none is sought: its course bends to what is left. Under one load a table that only different loads
    tell fits as well as any, and goes wrong under the next: none is tried, and no unseen data say so.
    """
    if found.followed is not None:
        return found
    definitions = [c.definition for c in found.chosen]
    stages = {d.stage for d in definitions if d.of_muscle}
    if not stages or found.leapt is not None or any(d.free is not None for d in definitions):
        return found
    if not _missed(found) or not found.final.problem.work.left:
        return found
    left, least = excess(found.final, found), found.final.problem.policy.least_drop
    start, best, score = _held(found.final), None, penalised(found.final) - 2.0 * least
    laws = promising(found.final, progress, told=True)
    for law in [law for law in laws if EFFECTS[law.basis.effect].stage in stages][:_TRIED]:
        better = refitted(start, law)
        enough = penalised(better) < score and excess(better, found) < HALF * left
        enough = enough and confirmation(start, better)[0].holds and _no_worse(found, better)
        if enough and as_small_elsewhere(better, found.final):
            best, score = better, penalised(better)
    return found if best is None else replace(found, bent=best, after=held_out(best, found.kept_back))


def _missed(found: Selection) -> bool:
    """Whether the model misses a channel by more than its noise, though it may be by less than the noise is."""
    missed = found.final.mean_square
    return any(missed[name] > (1.0 + _REAL) * s.noise.sigma**2 for name, s in found.structure_after.items())


def _no_worse(found: Selection, bent: Fit) -> bool:
    """Whether it predicts no channel of unseen data worse than the plain form: a table bends to what one recording has
    alone, and may well be right of most of the others."""
    return as_well(held_out(found.final, found.kept_back), held_out(bent, found.kept_back))


def as_well(plain: HeldOut, other: HeldOut) -> bool:
    """Whether another model predicts no channel of unseen data worse than a plain one."""
    errors = other.rmse()
    return all(errors[name] <= _AS_WELL * error for name, error in plain.rmse().items())


def _held(fitted: Fit) -> Fit:
    """The fit with its effects about as strong as they were found: as well known as their forms are."""
    problem, held, z = fitted.problem, [], []
    for u, at in zip(problem.unknowns, fitted.z, strict=True):
        value = u.from_fit(float(at))
        firm = replace(u, start=value, spread=problem.policy.form * u.spread) if '.' in u.name else u
        held.append(firm)
        z.append(firm.to_fit(value))
    return fit(replace(problem, unknowns=tuple(held)), np.array(z), rounds=0)

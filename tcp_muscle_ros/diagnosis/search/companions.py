"""Companions that a stronger effect's form hides: sought with what the forms of those found may miss allowed for."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from tcp_muscle_ros.diagnosis.fitting import draught
from tcp_muscle_ros.diagnosis.fitting.forms import allowing_forms
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise, structures
from tcp_muscle_ros.diagnosis.search.company import (
    Contest,
    alone_explains,
    bends,
    beside_it,
    good_company,
    largest_share,
    least_of_all,
    least_of_rest,
    stands_alone,
)
from tcp_muscle_ros.diagnosis.search.holdout import Gain, confirmation
from tcp_muscle_ros.diagnosis.search.picking import pick
from tcp_muscle_ros.diagnosis.search.refitting import shrink
from tcp_muscle_ros.diagnosis.search.rivals import Rival, penalised

_PROMISES = 2.0  # least drops, worth the time of its refits: what is found promises several times as much
_PLAIN = 5.0  # least drops


@dataclass(frozen=True)
class Companions:
    """What was found beside others: the fit with all of them, and of each its contest, and its standing (what unseen
    data say, its share of all that was missed); whether unseen data were ``other_conditions`` for all."""

    fit: Fit
    contests: dict[str, Contest]
    standing: dict[str, tuple[Gain, float]]
    other_conditions: bool


def companions(
    present: Fit,
    accepted: Sequence[str],
    effects: Sequence[str],
    calibrated: Fit,
    most: int,
    progress: Callable[[], None] | None,
) -> Companions:
    """Those of ``effects`` that go beside those accepted, ``most`` in all; each must hold on unseen data in the company
    of the others."""
    contests: dict[str, Contest] = {}
    while len(accepted) + len(contests) < most and present.problem.work.left:
        others = (*accepted, *contests)
        beside = allowing_for(present, others)

        def good(rival: Rival, rivals: Sequence[Rival], beside: Fit = beside, others: tuple[str, ...] = others) -> bool:
            after = _anew(rival.fit, others)
            rest = least_of_rest(rival, rival.policy.of_rest_at_first)
            if good_company(calibrated, beside, after, rest, _least(rival)):
                return True
            alike = beside_it(rival.effect, rivals, penalised(beside))
            if stands_alone(rival, alike) and _no_weather(rival, beside):
                return True
            return alone_explains(calibrated, beside, after, rival, alike)

        pool = [e for e in effects if e not in contests]
        picked = pick(beside, structures(beside), pool, good, progress, least=_PROMISES)
        if picked.rival is None:
            break
        present = picked.rival.fit
        contests[picked.rival.effect] = picked.contest
    standing: dict[str, tuple[Gain, float]] = {}
    other_conditions = True
    for effect in sorted(contests, key=lambda e: contests[e][0]):
        beside = allowing_for(present, (*accepted, *(e for e in contests if e != effect)))
        bare = shrink(beside, effect)
        gain, looked_at = confirmation(bare, beside)
        if gain.holds:
            standing[effect] = gain, largest_share(calibrated, bare, beside)
            other_conditions &= looked_at[0].whole is not None
        else:
            present = bare
            del contests[effect]
    return Companions(allowing_for(present, ()), contests, standing, other_conditions)


def stand_ins(present: Fit, accepted: Sequence[str]) -> tuple[list[str], Fit]:
    """Those of the accepted effects that a companion leaves nothing to explain, though what their forms may miss was
    allowed for: they stood in its place. And the fit without them."""
    found: list[str] = []
    for effect in accepted:
        bare = shrink(present, effect)
        if penalised(bare) - penalised(present) < present.problem.policy.least_drop:
            found.append(effect)
            present = bare
    return found, present


def allowing_for(present: Fit, others: tuple[str, ...]) -> Fit:
    """The fit by which an effect beside these others is judged: what their forms may miss is allowed for."""
    allowed = allowing_forms(present, others)
    return present if allowed is present else settle_noise(allowed, 1)[0]


def _anew(fitted: Fit, others: tuple[str, ...]) -> Fit:
    """The fit with the course of a draught or a room inferred anew, where there is one: it had bent to what an effect
    beside it explains."""
    return allowing_for(draught.without_course(fitted), others) if _has_course(fitted) else fitted


def _has_course(fitted: Fit) -> bool:
    """Whether the course of a draught or a room is inferred."""
    return any(latent.draught is not None for latent in fitted.problem.latents)


def _no_weather(rival: Rival, beside: Fit) -> bool:
    """Whether it is plainly there beside a course, which leaves nothing to take, and none that heat does: of that the
    course, which is never quite as it usually is, may leave some."""
    plain = penalised(beside) - rival.score >= _PLAIN * rival.policy.least_drop
    return _has_course(beside) and plain and rival.definition.stage in ('electrical', 'mechanical')


def _least(rival: Rival) -> float:
    """Of all that was missed, what an effect must take away beside others.

    Beside a draught, whose course is free, no form misses much.
    """
    if bends(rival):
        return least_of_all(rival)
    return 0.0 if _has_course(rival.fit) else rival.policy.companion_of_all

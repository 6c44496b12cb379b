"""Companions that a stronger effect's form hides: sought with what the forms of those found may miss allowed for."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from tcp_muscle_ros.diagnosis.fitting import draught
from tcp_muscle_ros.diagnosis.fitting.forms import allowing_forms
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise, structures
from tcp_muscle_ros.diagnosis.search.company import Contest, good_company, largest_share, least_of_all, least_of_rest
from tcp_muscle_ros.diagnosis.search.holdout import Gain, confirmation
from tcp_muscle_ros.diagnosis.search.picking import pick
from tcp_muscle_ros.diagnosis.search.refitting import shrink
from tcp_muscle_ros.diagnosis.search.rivals import Rival, penalised, turned

_PROMISES = 2.0  # least drops, worth the time of its refits: what is found promises several times as much
# Of what is left, an effect that none comes near takes so much that it may be less of what was missed.
_MOST, _LITTLE, _NEAR = 0.7, 0.001, 0.65
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
            alone = not _bends(rival) and _stands_alone(rival, rivals, beside)
            if alone and _no_weather(rival, beside):
                return True
            return alone and good_company(calibrated, beside, after, least_of_rest(rival, _MOST), _LITTLE)

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


def _stands_alone(rival: Rival, rivals: Sequence[Rival], beside: Fit) -> bool:
    """Whether no other effect explains nearly as much: what a form misses, several explain."""
    bare = penalised(beside)
    return all(bare - r.score < _NEAR * (bare - rival.score) for r in rivals if r is not rival)


def _bends(rival: Rival) -> bool:
    """Whether it bends to what any form misses: what differs from recording to recording, and physics the other way
    round than it is known."""
    return rival.definition.circumstance or turned(rival)


def _least(rival: Rival) -> float:
    """Of all that was missed, what an effect must take away beside others.

    Beside a draught, whose course is free, no form misses much.
    """
    if _bends(rival):
        return least_of_all(rival)
    return 0.0 if _has_course(rival.fit) else rival.policy.companion_of_all

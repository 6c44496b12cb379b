"""What is doubtful is not named, and not handed on: what is not probable enough, beside what is there, and what leaves
more than it explains.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

from tcp_muscle_ros.diagnosis.answer.improvement import fitted_without
from tcp_muscle_ros.diagnosis.fitting import slips
from tcp_muscle_ros.diagnosis.fitting.least_squares import fit
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise, structures
from tcp_muscle_ros.diagnosis.search.holdout import PLAINLY, held_out
from tcp_muscle_ros.diagnosis.search.rivals import Rival, turned
from tcp_muscle_ros.diagnosis.search.selected import Selection, Weighed

_LEAST = 0.6  # probability: of findings at 0.6 to 0.7 11 of 13 were right, of eight below two (`outside`, 2026-11-29)
_HALF = 0.5  # more than is left
_FORMS = 2.0  # standard deviations of what a form may miss
_PLAIN = 0.2  # of the misfit of the channel that is missed most, in noises: less is no measure of an explanation


def named_only_if_likely(selection: Selection, weighed: Callable[[Selection], Mapping[str, Weighed]]) -> Selection:
    """The selection without the weaker effects that are improbable (its ``doubtful`` ones), the least likely first;
    ``weighed`` says how likely each is, by name.

    The strongest stays whatever its probability: something is missing there, and its rivals stand beside it. So do
    sudden slips, which are seen one by one, and what explains most of what would be left without it: beside another
    effect it was found under the noise that it had itself made.
    """
    needed: set[str] = set()
    while True:
        sudden = selection.final.problem.model.roles.slips if slips.slipping(selection.final) else None
        strongest = max(selection.chosen, key=lambda c: c.drop, default=None)  # a law without a name comes last
        weaker = [
            c.effect for c in selection.chosen if c is not strongest and c.effect != sudden and c.effect not in needed
        ]
        if not weaker:
            return selection
        found = weighed(selection)
        least = found[min(weaker, key=lambda effect: found[effect].probability)]
        if least.probability >= _LEAST:
            return selection
        fewer = without(selection, least.effect)
        if _needed(selection, fewer):
            needed.add(least.effect)
            selection = _told_by_what_is_left(selection, least.effect, fewer)
        else:
            selection = replace(fewer, doubtful=(*selection.doubtful, least))


def _needed(selection: Selection, fewer: Selection) -> bool:
    """Whether an effect, without which there are ``fewer``, explains most of what a channel then misses, and that is
    more than its noise."""
    left, missed = (_beyond_noise(selection, fitted.mean_square) for fitted in (selection.final, fewer.final))
    return any(missed[name] > PLAINLY and left[name] < (1.0 - _HALF) * missed[name] for name in missed)


def _told_by_what_is_left(selection: Selection, effect: str, fewer: Selection) -> Selection:
    """The selection in which an effect lowers the misfit by what it does under the noise that is left in the end."""
    noise = {name: s.noise for name, s in selection.structure_after.items()}
    without_it, with_it = (
        fit(fitted.problem.with_noise(noise), fitted.z, rounds=0).objective for fitted in (fewer.final, selection.final)
    )
    chosen = (replace(c, drop=max(c.drop, without_it - with_it)) if c.effect == effect else c for c in selection.chosen)
    return replace(selection, chosen=tuple(chosen))


def named_only_if_explained(selection: Selection) -> Selection:
    """The selection without its effects where they leave more than they take in every channel; these are its ``leads``.

    The evidence compares effects and does not vouch for any: the best of forty may be a poor one. A course that wiggles
    looks like slips here and there, too. Physics that acts the other way round than it is known to bends to what any
    law leaves: where nothing else is named it leaves no more than its form may miss of it. Circumstances stay, which go
    as they like and have no form; but not where hardly any of it is theirs: a draught may then be what a resistance
    that is not understood does to the heat.
    """
    final, policy = selection.final, selection.final.problem.policy
    named = [c for c in selection.chosen if not c.definition.circumstance]
    bent = all(turned(Rival(c.effect, final, 0.0)) for c in named)
    if explained(selection) >= (1.0 / (1.0 + (_FORMS * policy.form) ** 2) if bent and named else _HALF):
        return selection
    fewer = selection
    for chosen in named:
        fewer = without(fewer, chosen.effect)
    for chosen in fewer.chosen if explained(fewer) < policy.of_all else ():
        fewer = without(fewer, chosen.effect)
    leads = tuple(c.effect for c in selection.chosen if c not in fewer.chosen)
    return replace(fewer, leads=leads) if leads else selection


def explained(selection: Selection) -> float:
    """The share of what was missed beyond the noise that the effects take, of the channel in which it is largest.

    Where a weight swings, of all that was missed: while it does, samples weigh little beside the others.
    """
    swings = selection.final.problem.model.roles.swings in {c.effect for c in selection.chosen}
    had, has = (
        _beyond_noise(selection, fitted.plain_square if swings else fitted.mean_square)
        for fitted in (selection.calibrated, selection.final)
    )
    most = max(had.values())
    return max((1.0 - has[name] / had[name] for name in had if had[name] > _PLAIN * most), default=1.0)


def _beyond_noise(selection: Selection, square: Mapping[str, float]) -> dict[str, float]:
    """By how much a mean square error exceeds the noise, in variances of the noise that is left in the end, by
    channel."""
    noise = {name: s.noise.sigma**2 for name, s in selection.structure_after.items()}
    return {name: max(square[name] / of_noise - 1.0, 0.0) for name, of_noise in noise.items()}


def without(selection: Selection, effect: str) -> Selection:
    """The selection without one of its effects."""
    left = tuple(c for c in selection.chosen if c.effect != effect)
    final = settle_noise(fitted_without(selection, effect), 1)[0] if left else selection.calibrated
    return replace(
        selection,
        final=final,
        chosen=left,
        after=held_out(final, selection.kept_back),
        structure_after=structures(final),
        unnamed=None,
        bent=None,
    )

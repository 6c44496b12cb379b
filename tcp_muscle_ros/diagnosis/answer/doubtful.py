"""What is doubtful is not named, and not handed on: what is more likely absent than there, beside what is there, and
what leaves more than it explains.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

from tcp_muscle_ros.diagnosis.answer.improvement import fitted_without
from tcp_muscle_ros.diagnosis.fitting import slips
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise, structures
from tcp_muscle_ros.diagnosis.search.holdout import held_out
from tcp_muscle_ros.diagnosis.search.selection import Selection, Weighed

_EVEN = 0.5  # more likely than not; more than is left
_PLAIN = 0.2  # of the misfit of the channel that is missed most, in noises: less is no measure of an explanation


def named_only_if_likely(selection: Selection, weighed: Callable[[Selection], Mapping[str, Weighed]]) -> Selection:
    """The selection without the weaker effects that are more likely absent than there (its ``doubtful`` ones), the
    least likely first; ``weighed`` says how likely each is, by name.

    The strongest stays whatever its probability: something is missing there, and its rivals stand beside it. So do
    sudden slips, which are seen one by one.
    """
    while True:
        sudden = selection.final.problem.model.roles.slips if slips.slipping(selection.final) else None
        strongest = max(selection.chosen, key=lambda c: c.drop, default=None)  # a law without a name comes last
        weaker = [c.effect for c in selection.chosen if c is not strongest and c.effect != sudden]
        if not weaker:
            return selection
        found = weighed(selection)
        least = found[min(weaker, key=lambda effect: found[effect].probability)]
        if least.probability >= _EVEN:
            return selection
        selection = replace(without(selection, least.effect), doubtful=(*selection.doubtful, least))


def named_only_if_explained(selection: Selection) -> Selection:
    """The selection without its effects where they leave more than they take in every channel; these are its ``leads``.

    The evidence compares effects and does not vouch for any: the best of forty may be a poor one. A course that wiggles
    looks like slips here and there, too. Circumstances stay, which go as they like and have no form.
    """
    named = [c for c in selection.chosen if not c.definition.circumstance]
    if not named or explained(selection) >= _EVEN:
        return selection
    for chosen in named:
        selection = without(selection, chosen.effect)
    return replace(selection, leads=tuple(c.effect for c in named))


def explained(selection: Selection) -> float:
    """The share of what was missed beyond the noise that the effects take, of the channel in which it is largest.

    Where a weight swings, of all that was missed: while it does, samples weigh little beside the others.
    """
    noise = {name: s.noise.sigma**2 for name, s in selection.structure_after.items()}
    swings = selection.final.problem.model.roles.swings in {c.effect for c in selection.chosen}
    had, has = (
        {name: max(missed[name] / of_noise - 1.0, 0.0) for name, of_noise in noise.items()}
        for missed in (
            fitted.plain_square if swings else fitted.mean_square for fitted in (selection.calibrated, selection.final)
        )
    )
    most = max(had.values())
    return max((1.0 - has[name] / had[name] for name in had if had[name] > _PLAIN * most), default=1.0)


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

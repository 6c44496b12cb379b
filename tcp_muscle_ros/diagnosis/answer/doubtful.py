"""What is more likely absent than there is not named beside what is there, and not handed on."""

from collections.abc import Callable
from dataclasses import replace

from tcp_muscle_ros.diagnosis.answer.improvement import fitted_without
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise, structures
from tcp_muscle_ros.diagnosis.hypothesis.roles import SLIPS
from tcp_muscle_ros.diagnosis.search.holdout import held_out
from tcp_muscle_ros.diagnosis.search.selection import Chosen, Selection

_EVEN = 0.5


def named_only_if_likely(selection: Selection, probability: Callable[[Selection, Chosen], float]) -> Selection:
    """The selection without the weaker effects that are more likely absent than there, the least likely first.

    The strongest stays whatever its probability: something is missing there, and its rivals stand beside it.
    """
    while True:
        weaker = [c for c in selection.chosen[1:] if c.effect != SLIPS]
        odds = {c.effect: probability(selection, c) for c in weaker}
        least = min(odds, key=lambda effect: odds[effect], default=None)
        if least is None or odds[least] >= _EVEN:
            return selection
        selection = without(selection, least)


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

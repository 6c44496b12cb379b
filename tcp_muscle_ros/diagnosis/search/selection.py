"""Select the effects that the recordings demand: forward, with swaps and pruning, each confirmed on unseen data.

Sensors, physics and parameters compete on equal terms: every step refits all of them together. An effect is accepted
when the whitened misfit falls by more than chance gives over all that were tried, when unseen recordings improve, and
when the gain is a real share of what was unexplained.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting import draught, slips
from tcp_muscle_ros.diagnosis.fitting.generic import Structure
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.weighing import SWINGS, calmed, settle_noise, structures, with_noise
from tcp_muscle_ros.diagnosis.search.companions import companions, stand_ins
from tcp_muscle_ros.diagnosis.search.company import (
    OF_REST_AT_FIRST,
    Contest,
    confirm,
    good_company,
    largest_share,
    least_of_rest,
    revise,
    stands_apart,
)
from tcp_muscle_ros.diagnosis.search.holdout import Fold, Gain, HeldOut, confirmation, held_out, stretches
from tcp_muscle_ros.diagnosis.search.picking import NOTHING, Picked, pick
from tcp_muscle_ros.diagnosis.search.rivals import AMBIGUOUS, Rival, close_rivals, margin, penalised
from tcp_muscle_ros.muscle import EFFECTS

MOST_EFFECTS = 4
_REVISIONS = 2


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

    ``other_conditions``: these are whole recordings, not stretches of those that were fitted. ``leapt``: the calibrated
    model with changes for good that have no name. ``first``: how the first effect was picked. ``kept_back``: the
    unseen data.
    """

    calibrated: Fit
    final: Fit
    chosen: tuple[Chosen, ...]
    before: HeldOut
    after: HeldOut
    structure_before: dict[str, Structure]
    structure_after: dict[str, Structure]
    first: Picked
    other_conditions: bool = True
    leapt: Fit | None = None
    kept_back: tuple[Fold, ...] = ()

    @property
    def told(self) -> 'Selection':
        """The same with the course of the draught where one is named: what remains then calls for another effect."""
        if all(c.effect != draught.EFFECT for c in self.chosen):
            return self
        final, structure = settle_noise(draught.with_course(self.final), 1)
        return replace(self, final=final, structure_after=structure)


def select(
    calibrated: Fit, effects: Sequence[str], progress: Callable[[], None] | None = None, most: int = MOST_EFFECTS
) -> Selection:
    """Select effects on top of a calibrated fit.

    ``effects`` are the candidates by name. Returns every stage's evidence; accepting nothing is a full answer. Sudden
    slips and leaps are no matter of form: where there are any, all else is sought beside them. Those that show no more
    once it is found were its misfit: then it is sought without them.
    """
    bare, _ = settle_noise(calibrated)
    if slips.EFFECT not in effects:
        return _beside(bare, None, effects, progress, most)
    slipped = slips.slipped(bare)
    if slipped is not None:
        found = _among(bare, slipped, effects, progress, most)
        if len(found.chosen) == 1 or slips.slipped(slips.taken_out(found.final)) is not None:
            return found
    leapt = slips.leapt(bare) if slipped is None else None
    found = _beside(bare, leapt, effects, progress, most)
    clearer = None
    if leapt is not None and found.chosen:  # what was found may show that they are slips, or that they were its misfit
        without = slips.taken_out(found.final)
        clearer = slips.slipped(without)
        if clearer is None and slips.leapt(without) is None:
            leapt, found = None, _beside(bare, None, effects, progress, most)
    if found.chosen and leapt is None and not slips.slipping(found.final) and found.final.problem.work.left:
        clearer = slips.slipped(found.final)
    if clearer is not None:
        return _among(bare, _with_slips_of(clearer, bare), effects, progress, most)
    return replace(found, leapt=leapt)


def select_from(
    start: Fit, calibrated: Fit, effects: Sequence[str], progress: Callable[[], None] | None = None
) -> Selection:
    """Select effects on top of a calibrated fit, beginning with those that ``start`` has; they must hold like all."""
    return _beside(settle_noise(calibrated)[0], None, effects, progress, MOST_EFFECTS, start)


def _with_slips_of(clearer: Fit, bare: Fit) -> Fit:
    """The bare fit with the slips that show in a better one."""
    return slips.beside(bare, [e.slips for e in clearer.problem.experiments])


def _among(
    bare: Fit, slipped: Fit, effects: Sequence[str], progress: Callable[[], None] | None, most: int
) -> Selection:
    """Select effects on top of a calibrated fit, among the slips that another one has; and their own."""
    found = _beside(bare, slipped, [e for e in effects if e not in slips.INSTEAD], progress, most - 1)
    chosen = (*found.chosen, _slipping(found.calibrated, slipped))
    return replace(found, chosen=tuple(sorted(chosen, key=lambda c: -c.drop)))


def _beside(
    bare: Fit,
    beside: Fit | None,
    effects: Sequence[str],
    progress: Callable[[], None] | None,
    most: int,
    start: Fit | None = None,
) -> Selection:
    """Select effects on top of a calibrated fit, beside the slips or leaps that another one has; ``start``: the fit
    with the effects to begin with."""
    calibrated = present = beside or bare
    slipping = beside is not None and slips.EFFECT not in effects  # it is what they are
    before_structure, found_structure = structures(bare), structures(present)
    first: Picked | None = None
    accepted: list[str] = []
    contests: dict[str, Contest] = {}
    if start is not None:
        accepted = list(start.problem.parameters.effects)
        present, found_structure = settle_noise(start)
        contests = {e: (0.0, [Rival(e, present, penalised(present))]) for e in accepted}  # until they are revised
    while len(accepted) < most and present.problem.work.left:
        pool = [e for e in effects if e not in accepted]

        def good(rival: Rival, _rivals: Sequence[Rival], calibrated: Fit = calibrated, without: Fit = present) -> bool:
            apart = stands_apart(rival.effect, rival.fit, accepted)
            alone = not accepted and not slipping
            rest = least_of_rest(rival, OF_REST_AT_FIRST)
            return alone or good_company(calibrated, without, rival.fit, rest, apart=apart)

        picked = pick(present, found_structure, pool, good, progress)
        first = first or picked
        if picked.rival is None:
            break
        effect = picked.rival.effect
        accepted.append(effect)
        contests[effect] = picked.contest
        present = picked.rival.fit
        if effect == SWINGS:
            bare = calmed(bare, present)
            calibrated = bare if beside is None else calmed(calibrated, present)
            present = calmed(present, present)
            clearer = slips.slipped(present) if beside is None and slips.EFFECT in effects else None
            if clearer is not None:  # slips that the swing hid, before all else bends to them
                return _among(bare, _with_slips_of(clearer, bare), effects, progress, most)
        present, found_structure = settle_noise(present, 1)
    tried = effects
    for _ in range(_REVISIONS):
        present, accepted, contests = revise(present, accepted, tried, contests, progress)
        if accepted:
            present, found_structure = settle_noise(present, 1)
        tried = accepted
        present, accepted, standing, kept_back = confirm(present, accepted, contests, calibrated, alone=not slipping)
        if not accepted or accepted == tried:
            break  # else what was dropped may stand in the place of one that it stood beside
    if accepted:
        present = slips.further(present) if slipping else present
        found_structure = structures(present)
        # What a swing leaves of itself, all that changes a stiffness or a length bends to.
        hidden = EFFECTS[SWINGS].stage if SWINGS in accepted else None
        pool = [e for e in effects if e not in (*accepted, SWINGS) and EFFECTS[e].stage != hidden]
        found = companions(present, accepted, pool, calibrated, most, progress)
        present, contests, standing = found.fit, contests | found.contests, standing | found.standing
        refuted, without = stand_ins(present, accepted) if found.contests else ([], present)
        accepted = [*accepted, *found.contests]
        found_structure = structures(present)
        if not found.other_conditions:
            kept_back = stretches(present.problem)
        if refuted:
            present, accepted, contests = _without(refuted, without, accepted, contests, progress)
            present = settle_noise(present, 1)[0]
            present, accepted, standing, kept_back = confirm(present, accepted, contests, calibrated, not slipping)
            found_structure = structures(present)
    # Compared under one noise: the final model's.
    reference = with_noise(bare, dict(present.problem.noise)) if accepted or beside else bare
    chosen = []
    for effect in accepted:
        drop, rivals = contests[effect]
        chosen.append(Chosen(effect, drop, *standing[effect], tuple(rivals)))
    return Selection(
        reference,
        present,
        tuple(sorted(chosen, key=lambda c: -c.drop)),
        held_out(reference, kept_back),
        held_out(present, kept_back),
        before_structure,
        found_structure,
        first or NOTHING,
        kept_back[0].whole is not None,
        kept_back=kept_back,
    )


def _without(
    refuted: Sequence[str],
    without: Fit,
    accepted: Sequence[str],
    contests: dict[str, Contest],
    progress: Callable[[], None] | None,
) -> tuple[Fit, list[str], dict[str, Contest]]:
    """The fit without those that are refuted, and what the others are worth then: against whatever came close to them,
    or to those."""
    left = [e for e in accepted if e not in refuted]
    near = [r for e in refuted for r in contests[e][1]]
    close = {e: (contests[e][0], [r for r in (*contests[e][1], *near) if r.effect not in refuted]) for e in left}
    return revise(without, left, left, close, progress)


def _slipping(bare: Fit, slipped: Fit) -> Chosen:
    """The effect of sudden slips, by what a calibrated fit gains with them."""
    alone = with_noise(bare, dict(slipped.problem.noise))
    itself = Rival(slips.EFFECT, slipped, penalised(slipped))
    gain = confirmation(alone, slipped)[0]
    return Chosen(slips.EFFECT, penalised(alone) - itself.score, gain, largest_share(alone, alone, slipped), (itself,))

"""Select the effects that the recordings demand: forward, with swaps and pruning, each confirmed on unseen data.

Sensors, physics and parameters compete on equal terms: every step refits all of them together. An effect is accepted
when the whitened misfit falls by more than chance gives over all that were tried, when unseen recordings improve, and
when the gain is a real share of what was unexplained.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from tcp_muscle_ros.diagnosis.fitting import slips
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.weighing import calmed, settle_noise, structures, with_noise
from tcp_muscle_ros.diagnosis.search.companions import companions, stand_ins
from tcp_muscle_ros.diagnosis.search.company import (
    Contest,
    alone_explains,
    beside_it,
    confirm,
    disguised,
    good_company,
    largest_share,
    least_of_all,
    least_of_rest,
    revise,
    stands_apart,
)
from tcp_muscle_ros.diagnosis.search.holdout import Fold, Gain, confirmation, held_out, stretches
from tcp_muscle_ros.diagnosis.search.picking import NOTHING, Picked, pick
from tcp_muscle_ros.diagnosis.search.refitting import shrink
from tcp_muscle_ros.diagnosis.search.rivals import Rival, close_rivals, penalised, truer
from tcp_muscle_ros.diagnosis.search.selected import Chosen, Selection
from tcp_muscle_ros.diagnosis.search.unrested import unrested

_REVISIONS = 2
_REVISABLE = 0.5  # of the work: what is accepted in another's place must still be held against it


def select(calibrated: Fit, effects: Sequence[str], progress: Callable[[], None] | None = None) -> Selection:
    """Select effects on top of a calibrated fit.

    ``effects`` are the candidates by name. Returns every stage's evidence; accepting nothing is a full answer. Sudden
    slips and leaps are no matter of form: where there are any, all else is sought beside them. Leaps that a law found
    without them explains were none, and neither were those that show no more once all else is found.
    """
    bare, _ = settle_noise(calibrated)
    most = int(bare.problem.policy.most_effects)
    roles = bare.problem.model.roles
    if roles.slips not in effects:
        return _selected(bare, None, effects, progress, most)
    slipped = slips.slipped(bare)
    if slipped is not None:
        found = _among(bare, slipped, effects, progress, most)
        if len(found.chosen) == 1 or slips.slipped(slips.taken_out(found.final)) is not None:
            return found
    leapt = slips.leapt(bare) if slipped is None else None
    smooth = found = _selected(bare, None, effects, progress, most)
    if leapt is not None and _has_the_steps(smooth, leapt):
        leapt = None
    if leapt is not None:
        found = _selected(bare, leapt, effects, progress, most)
    clearer = None
    if leapt is not None and found.chosen:  # what was found may show that they are slips, or that they were its misfit
        without = slips.taken_out(found.final)
        clearer = slips.slipped(without)
        if clearer is None and slips.leapt(without) is None:
            leapt, found = None, smooth
    if found.chosen and leapt is None and not slips.slipping(found.final) and found.final.problem.work.left:
        clearer = slips.slipped(found.final)
    if clearer is not None:
        return _among(bare, _with_slips_of(clearer, bare), effects, progress, most)
    return replace(found, leapt=leapt)


def select_from(
    start: Fit, calibrated: Fit, effects: Sequence[str], progress: Callable[[], None] | None = None
) -> Selection:
    """Select effects on top of a calibrated fit, beginning with those that ``start`` has; they must hold like all."""
    most = int(calibrated.problem.policy.most_effects)
    return _selected(settle_noise(calibrated)[0], None, effects, progress, most, start)


def _has_the_steps(found: Selection, leapt: Fit) -> bool:
    """Whether what was found has all but a trifle of what leapt: a law that begins sharply, met by chance here and
    there."""
    trifle, had, has = leapt.problem.policy.still_plain, found.calibrated.mean_square, found.final.mean_square
    return bool(found.chosen) and all(has[s.channel] < trifle * had[s.channel] for s in leapt.problem.slips)


def _with_slips_of(clearer: Fit, bare: Fit) -> Fit:
    """The bare fit with the slips that show in a better one."""
    return slips.added(bare, [latent.slips for latent in clearer.problem.latents])


def _among(
    bare: Fit, slipped: Fit, effects: Sequence[str], progress: Callable[[], None] | None, most: int
) -> Selection:
    """Select effects on top of a calibrated fit, among the slips that another one has; and their own."""
    found = _selected(
        bare, slipped, [e for e in effects if e not in bare.problem.model.roles.like_slips], progress, most - 1
    )
    chosen = (*found.chosen, _slipping(found.calibrated, slipped))
    return replace(found, chosen=tuple(sorted(chosen, key=lambda c: -c.drop)))


def _selected(
    bare: Fit,
    eventful: Fit | None,
    effects: Sequence[str],
    progress: Callable[[], None] | None,
    most: int,
    start: Fit | None = None,
) -> Selection:
    """Select effects on top of a calibrated fit; ``eventful``: the one with slips or leaps, beside which they are
    sought; ``start``: the fit with the effects to begin with."""
    search = _Search(bare, eventful, effects, progress, most)
    if start is not None:
        search.begin_with(start)
    clearer = search.forward()
    if clearer is not None:  # slips that the swing hid, before all else bends to them
        return _among(search.bare, _with_slips_of(clearer, search.bare), effects, progress, most)
    search.revise()
    if search.accepted:
        search.add_companions()
    return search.outcome()


class _Search:
    """A selection under way: the fit of what is accepted so far, and what speaks for each."""

    def __init__(
        self,
        bare: Fit,
        eventful: Fit | None,
        effects: Sequence[str],
        progress: Callable[[], None] | None,
        most: int,
    ) -> None:
        self.bare, self.eventful, self.effects, self.progress, self.most = bare, eventful, effects, progress, most
        self.calibrated = self.present = eventful or bare
        self.roles = bare.problem.model.roles
        self.slipping = eventful is not None and self.roles.slips not in effects  # it is what they are
        self.structure_before, self.structure = structures(bare), structures(self.present)
        self.first: Picked | None = None
        self.accepted: list[str] = []
        self.contests: dict[str, Contest] = {}
        self.standing: dict[str, tuple[Gain, float]] = {}
        self.kept_back: tuple[Fold, ...] = ()

    def begin_with(self, start: Fit) -> None:
        """Accept what a fit has, until it is revised."""
        self.accepted = list(start.problem.parameters.effects)
        self.present, self.structure = settle_noise(start)
        self.contests = {e: (0.0, [Rival(e, self.present, penalised(self.present))]) for e in self.accepted}

    def forward(self) -> Fit | None:
        """Accept one effect after the other, until none is good; a fit with slips that show once a weight swings ends
        it early."""
        while len(self.accepted) < self.most and self.present.problem.work.left:
            pool = [e for e in self.effects if e not in self.accepted]
            picked = pick(self.present, self.structure, pool, self._good, self.progress)
            self.first = self.first or picked
            if picked.rival is None:
                picked = self._beside_a_truer_form(pool) or picked
            if picked.rival is None:
                break
            effect = picked.rival.effect
            self.accepted.append(effect)
            self.contests[effect] = picked.contest
            self.present = unrested(picked.rival.fit)
            clearer = self._calm() if effect == self.roles.swings else None
            if clearer is not None:
                return clearer
            self.present, self.structure = settle_noise(self.present, 1)
        return None

    def _beside_a_truer_form(self, pool: Sequence[str]) -> Picked | None:
        """What can be picked beside the form that fits best, where the last one was accepted for being simpler; that
        one is accepted in its place then."""
        if not self.accepted or not self.present.problem.work.within(_REVISABLE):
            return None
        simple = self.accepted[-1]
        if simple == self.roles.swings:
            return None
        drop, rivals = self.contests[simple]
        instead = truer(rivals, simple, drop)
        if instead is None:
            return None
        was = self.present, self.structure
        self.present, self.structure = settle_noise(unrested(instead.fit), 1)
        self.accepted[-1] = instead.effect
        picked = pick(self.present, self.structure, [e for e in pool if e != instead.effect], self._good, self.progress)
        if picked.rival is None:
            self.present, self.structure = was
            self.accepted[-1] = simple
            return None
        self.contests[instead.effect] = self.contests.pop(simple)
        return picked

    def _good(self, rival: Rival, rivals: Sequence[Rival]) -> bool:
        if not self.accepted and not self.slipping:
            return True
        apart = stands_apart(rival.effect, rival.fit, self.accepted)
        rest = least_of_rest(rival, rival.policy.of_rest_at_first)
        if good_company(self.calibrated, self.present, rival.fit, rest, least_of_all(rival), apart=apart):
            return True
        alike = beside_it(rival.effect, rivals, penalised(self.present))
        return alone_explains(self.calibrated, self.present, rival.fit, rival, alike)

    def _calm(self) -> Fit | None:
        """Weigh less what a swing leaves; the fit with the slips that it hid, if there are any."""
        swings = self.present
        self.bare = calmed(self.bare, swings)
        self.calibrated = self.bare if self.eventful is None else calmed(self.calibrated, swings)
        self.present = calmed(swings, swings)
        return slips.slipped(self.present) if self.eventful is None and self.roles.slips in self.effects else None

    def revise(self) -> None:
        """Hold each against its rivals and against unseen data, until nothing changes."""
        tried = self.effects
        for _ in range(_REVISIONS):
            self._revised(tried)
            if self.accepted and disguised(self.present, self.accepted):
                self._revised(tried)
            tried = self.accepted
            self._confirm()
            if not self.accepted or self.accepted == tried:
                break  # else what was dropped may stand in the place of one that it stood beside

    def _revised(self, tried: Sequence[str]) -> None:
        self.present, self.accepted, self.contests = revise(
            self.present, self.accepted, tried, self.contests, self.progress
        )
        if self.accepted:
            self.present, self.structure = settle_noise(unrested(self.present), 1)

    def _confirm(self) -> None:
        self.present, self.accepted, self.standing, self.kept_back = confirm(
            self.present, self.accepted, self.contests, self.calibrated, alone=not self.slipping
        )

    def add_companions(self) -> None:
        """Accept what stands beside those accepted, and drop those in whose place it stands."""
        present = slips.further(self.present) if self.slipping else self.present
        # What a swing leaves of itself, all that changes a stiffness or a length bends to.
        effects, swings = present.problem.model.effects, self.roles.swings
        hidden = effects[swings].stage if swings in self.accepted else None
        pool = [e for e in self.effects if e not in (*self.accepted, swings) and effects[e].stage != hidden]
        found = companions(present, self.accepted, pool, self.calibrated, self.most, self.progress)
        self.present = unrested(found.fit) if found.contests else found.fit
        self.contests, self.standing = self.contests | found.contests, self.standing | found.standing
        refuted, without = stand_ins(self.present, self.accepted) if found.contests else ([], self.present)
        for effect in sorted(self._admitted_instead(refuted) & set(found.contests)):
            refuted, without = [*refuted, effect], shrink(without, effect)
        self.accepted = [*self.accepted, *found.contests]
        if not found.other_conditions:
            self.kept_back = stretches(self.present.problem)
        if refuted:
            self.present, self.accepted, self.contests = _without(
                refuted, without, self.accepted, self.contests, self.progress
            )
            self.present = settle_noise(self.present, 1)[0]
            self._confirm()
        self.structure = structures(self.present)

    def _admitted_instead(self, refuted: Sequence[str]) -> set[str]:
        """What the data admit in the place of an accepted effect that is not refuted: beside it, it takes no more than
        that one's form leaves."""
        held = [self.contests[effect] for effect in self.accepted if effect not in refuted]
        return {r.effect for drop, rivals in held for r in close_rivals(rivals, drop)}

    def outcome(self) -> Selection:
        """All that was found, compared under one noise: the final model's."""
        seen = self.accepted or self.eventful
        reference = with_noise(self.bare, dict(self.present.problem.noise)) if seen else self.bare
        chosen = []
        for effect in self.accepted:
            drop, rivals = self.contests[effect]
            others = set(self.accepted) - {effect}  # what is there by itself stands in no place of another
            rivals = [r for r in rivals if r.effect not in others]
            chosen.append(Chosen(effect, drop, *self.standing[effect], tuple(rivals)))
        return Selection(
            reference,
            self.present,
            tuple(sorted(chosen, key=lambda c: -c.drop)),
            held_out(reference, self.kept_back),
            held_out(self.present, self.kept_back),
            self.structure_before,
            self.structure,
            self.first or NOTHING,
            self.kept_back[0].whole is not None,
            kept_back=self.kept_back,
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
    name = bare.problem.model.roles.slips
    itself = Rival(name, slipped, penalised(slipped))
    gain = confirmation(alone, slipped)[0]
    return Chosen(name, penalised(alone) - itself.score, gain, largest_share(alone, alone, slipped), (itself,))

"""What a selection of effects comes to: those accepted, what speaks for each, and the models before and after."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tcp_muscle_ros.diagnosis.fitting import draught
from tcp_muscle_ros.diagnosis.fitting.generic import Structure
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise, structures
from tcp_muscle_ros.diagnosis.search.holdout import Fold, Gain, HeldOut
from tcp_muscle_ros.diagnosis.search.location import Unexplained
from tcp_muscle_ros.diagnosis.search.picking import Picked
from tcp_muscle_ros.diagnosis.search.rivals import Rival, close_rivals, margin
from tcp_muscle_ros.muscle import Effect
from tcp_muscle_ros.muscle.arrays import Array


@dataclass(frozen=True)
class Chosen:
    """One accepted effect: its drop of the misfit, the unseen data's word on it in the company of the others, the share
    of the calibrated model's misfit that it takes away (the largest over channels), and its rivals (best first, itself
    too). ``nearest``: of a law without a name, the listed effects in whose place it stands;
    ``closest``: the listed effect that comes closest to it, and the drop that it has alone."""

    effect: str
    drop: float
    gain: Gain
    share: float
    rivals: tuple[Rival, ...]
    nearest: tuple[str, ...] = ()
    closest: tuple[str, float] | None = None

    @property
    def definition(self) -> Effect:
        """What the effect says of itself."""
        return self.rivals[0].fit.problem.model.effects[self.effect]

    @property
    def indistinguishable(self) -> tuple[str, ...]:
        """The effects that the data admit in its place."""
        return tuple(r.effect for r in close_rivals(self.rivals, self.drop) if r.effect != self.effect)

    @property
    def shares(self) -> Array:
        """The share of the likelihood that each of its rivals has, shape (rivals,)."""
        scores = np.array([r.score for r in self.rivals])
        policy = self.rivals[0].policy
        weights = np.exp(-0.5 * policy.told_apart / margin(self.drop, policy) * (scores - scores.min()))
        return np.asarray(weights / weights.sum())

    @property
    def confidence(self) -> float:
        """Its share of the likelihood among its rivals."""
        return float(next(s for s, r in zip(self.shares, self.rivals, strict=True) if r.effect == self.effect))


@dataclass(frozen=True)
class Weighed:
    """An effect that was found: how probable it is, and the ``evidence`` that this was made from."""

    effect: str
    probability: float
    evidence: Mapping[str, float]


@dataclass(frozen=True)
class Selection:
    """The outcome: the calibrated model, the selected one, and how both do on unseen data.

    ``other_conditions``: these are whole recordings, not stretches of those that were fitted. ``leapt``: the calibrated
    model with changes for good that have no name. ``first``: how the first effect was picked. ``kept_back``: the
    unseen data. ``unnamed``: what the listed effects leave, where a law without a name explains it. ``bent``: the final
    model with a listed form as the recordings bend it, where they do. ``leads``: effects that came nearest and leave
    too much to be named; ``doubtful``: weaker ones that are improbable.
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
    unnamed: Unexplained | None = None
    bent: Fit | None = None
    leads: tuple[str, ...] = ()
    doubtful: tuple[Weighed, ...] = ()

    @property
    def best(self) -> Fit:
        """The fit that is handed on."""
        return self.bent or self.followed or self.final

    @property
    def followed(self) -> Fit | None:
        """The final model with the course of the draught or the room, where one is named."""
        named = any(c.effect in self.final.problem.model.roles.inferred for c in self.chosen)
        return _followed(self.final) if named else None

    @property
    def told(self) -> 'Selection':
        """The same with the course of what is named and has one: what remains then calls for another effect."""
        followed = self.followed
        return self if followed is None else replace(self, final=followed, structure_after=structures(followed))


@lru_cache(maxsize=2)
def _followed(fitted: Fit) -> Fit:
    """The fit with the course of its draught: asked for again and again, and seconds of work."""
    return settle_noise(draught.with_course(fitted), 1)[0]

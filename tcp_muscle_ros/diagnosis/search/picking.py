"""Pick the next effect: the best of those that promise most, refitted, if it is real and unseen data confirm it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from tcp_muscle_ros.diagnosis.fitting.generic import Structure
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.search.candidates import Candidate, screen
from tcp_muscle_ros.diagnosis.search.company import Contest, foretelling, in_place_of, share
from tcp_muscle_ros.diagnosis.search.holdout import confirmation
from tcp_muscle_ros.diagnosis.search.refitting import rivals_for
from tcp_muscle_ros.diagnosis.search.rivals import CONTEST, Rival, begins, least_drop, penalised, prefer, rescored

_TRIES = 4


@dataclass(frozen=True)
class Picked:
    """The effect that was picked (None: none is good enough), with its contest; all candidates ranked, and the signal
    of each; those that were refitted, best first, and the score without any."""

    rival: Rival | None
    contest: Contest
    ranked: tuple[Candidate, ...]
    signals: Mapping[str, float]
    rivals: tuple[Rival, ...] = ()
    bare: float = 0.0

    @property
    def refitted(self) -> dict[str, float]:
        """By how much each one that was refitted lowers the score."""
        return {r.effect: self.bare - r.score for r in self.rivals}


NOTHING = Picked(None, (0.0, []), (), {})  # where none was looked for


def pick(
    present: Fit,
    structure: dict[str, Structure],
    pool: Sequence[str],
    good: Callable[[Rival, Sequence[Rival]], bool],
    progress: Callable[[], None] | None,
    least: float = 0.5,
) -> Picked:
    """Pick one of ``pool`` to go beside what ``present`` has, which leaves ``structure``; ``good`` asks for more of
    it among its rivals.

    Nothing is refitted where no candidate promises ``least`` times the drop of the misfit that an effect must bring.
    """
    ranked, signals = screen(present, pool, progress)
    policy = present.problem.policy
    if not ranked or ranked[0].gain < least * policy.least_drop:
        return Picked(None, (0.0, []), tuple(ranked), signals)
    tried = rivals_for(present, ranked, progress)
    bare = penalised(present)
    none = Picked(None, (0.0, []), tuple(ranked), signals, tuple(tried), bare)
    rivals = every = [r for r in tried if bare - r.score >= policy.least_drop and begins(r)]
    for _ in range(_TRIES):
        if not rivals:
            break
        first = rivals[0]
        if len(rivals) > 1:
            settled, close = rescored(present, rivals)
            effect = prefer(close, settled).effect
            first = next(r for r in rivals if r.effect == effect)
        chosen = first
        first = foretelling(present, chosen, tried)
        plain = bare - first.score >= least_drop(first)
        enough = plain and share(structure, present, first.fit) >= policy.least_share and good(first, every)
        if enough and confirmation(present, first.fit)[0].holds:
            drop = bare - first.score
            others = rivals if first is chosen else in_place_of(chosen, first, rivals)
            contest = drop, [r for r in others if bare - r.score > (1.0 - CONTEST) * drop]
            return replace(none, rival=first, contest=contest)
        rivals = [r for r in rivals if r is not first and r is not chosen]
    return none

"""A second start, from two effects at once, from one before the muscle has rested, or without sudden slips.

Effects that are added one at a time miss two of which neither helps much alone, and begin with a stand-in for both.
An effect whose states differ where the recordings begin explains little until each may have its own. Where the search
ends with something unexplained, it is begun anew from the best pair, or from such an effect; where it ended with slips
alone, without them.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from tcp_muscle_ros.diagnosis.fitting import slips
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.weighing import with_noise
from tcp_muscle_ros.diagnosis.search.candidates import screen
from tcp_muscle_ros.diagnosis.search.refitting import rivals_for
from tcp_muscle_ros.diagnosis.search.remaining import unexplained
from tcp_muscle_ros.diagnosis.search.rivals import Rival, begins, penalised
from tcp_muscle_ros.diagnosis.search.selected import Selection
from tcp_muscle_ros.diagnosis.search.selection import select, select_from
from tcp_muscle_ros.diagnosis.search.unrested import unrested

_SECONDS = 2  # refitted beside each first effect
_PROMISES = 2.0  # least drops, worth the time of a search
_LEFT = 0.5  # of what was unexplained: as much as may still be


def select_twice(calibrated: Fit, effects: Sequence[str], progress: Callable[[], None] | None = None) -> Selection:
    """Select effects on top of a calibrated fit, from two starts where the first one leaves something unexplained.

    The second counts if it leaves half as much, by effects that hold like all others.
    """
    found = select(calibrated, effects, progress)
    left = unexplained(found.told)
    roles = calibrated.problem.model.roles
    if left is None or found.leapt is not None or roles.swings in found.final.problem.parameters.effects:
        return found
    if not slips.slipping(found.final):
        start = _best_start(found, effects, progress)
        if start is None or penalised(found.final) - start.score < _PROMISES * calibrated.problem.policy.least_drop:
            return found
        if not calibrated.problem.work.left:  # nothing would hold it against its rivals
            return found
        again = select_from(start.fit, calibrated, effects, progress)
    elif len(found.chosen) == 1:
        again = select(calibrated, [e for e in effects if e != roles.slips], progress)
    else:
        return found
    still = unexplained(again.told)
    if not again.chosen or (still and still.share > _LEFT * left.share) or not _better(again.final, found.final):
        return found
    return replace(again, first=found.first)


def _best_start(found: Selection, effects: Sequence[str], progress: Callable[[], None] | None) -> Rival | None:
    """The pair that fits best of those that begin with an effect which competed to be the first, or that effect alone
    with its states where the recordings begin, under the noise of what was found; without those that go beside what was
    found, which the first search has tried."""
    chosen = {c.effect for c in found.chosen}

    def tried(pair: set[str]) -> bool:
        return bool(chosen) and chosen <= pair

    starts: list[Rival] = []
    swings = found.final.problem.model.roles.swings
    for first in found.first.rivals:
        if not found.final.problem.work.left:
            break
        alone = with_noise(first.fit, dict(found.final.problem.noise))
        begun = alone if chosen else unrested(alone)
        if begun is not alone:
            starts.append(Rival(first.effect, begun, penalised(begun)))
        apart = [e for e in effects if e not in (first.effect, swings) and not tried({first.effect, e})]
        if apart:
            ranked, _ = screen(alone, apart, progress)
            seconds = rivals_for(alone, ranked, progress, _SECONDS)
            starts += [r for r in seconds if begins(r) and begins(replace(r, effect=first.effect))]
    return min(starts, key=lambda start: start.score, default=None)


def _better(one: Fit, other: Fit) -> bool:
    """Whether one model fits better than another by more than chance gives, under its own noise."""
    gained = penalised(with_noise(other, dict(one.problem.noise))) - penalised(one)
    return gained >= one.problem.policy.least_drop

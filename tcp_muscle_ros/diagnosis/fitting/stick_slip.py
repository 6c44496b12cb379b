"""Does a recording rest and jump where a smooth prediction moves? Told from a coarse reading, from slips, from noise.

Stick-slip does not lower a mean square error on unseen runs, because its instants are chance. It is told by its
signature: while the prediction moves on, the recording rests; it catches up in jumps; and it does so both ways.

- A coarse reading rests too, but never while the prediction moves by several of its steps.
- Noise scatters at once: neither rests nor jumps that stay.
- Slips of the end (turns lost) are jumps without rests before them, all of one direction.
- A stop is a long rest while the prediction goes on up, without jumps.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import ks_2samp

from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.diagnosis.observation.scatter import quantum, white_sigma
from tcp_muscle_ros.muscle.arrays import Array

_QUANTA, _SIGMAS = 1.5, 4.0  # a reading that has not moved stays within so many of its steps, or of its noise
_DUST, _COMMON = 1e-6, 0.05  # of the whole motion: no motion; of the steps between neighbours: a common one
_CREEPS = 0.2  # of the predicted motion: what an end that rests may give way by
_MOVES = 6.0  # times what a reading at rest stays within: the prediction's motion that makes it a rest
_QUICK = 2.5  # times the predicted speed: a jump
_LARGE = 3.0  # times what a reading at rest stays within: a jump
_AFTER = 2  # samples between a rest and the jump that ends it
_FEWEST = 2  # jumps each way, and rests
_SHARE = 0.25  # of the motion, in jumps that end a rest
_SLIPPED = 0.02  # of the whole motion, in slips
STOP, CHANCE = 'stop', 'chance'  # kinds of signature: the other rests and jumps at instants of chance
_HIGH, _STOPPED = 0.5, 0.1  # the level of a stop, and the share of the whole motion that the prediction goes on


@dataclass(frozen=True)
class Rest:
    """A stretch in which the recording rests: its samples, how long (s), how far the prediction went (m), up positive.

    ``level``: where between the least and the largest value of the recording, 0 to 1.
    """

    first: int
    last: int
    duration: float
    missed: float
    level: float


@dataclass(frozen=True)
class Jump:
    """A quick motion: its samples, its size (m, positive up), its level as of a rest; ``released``: it ends a rest."""

    first: int
    last: int
    size: float
    level: float
    released: bool


@dataclass(frozen=True)
class Signature:
    """What a recording shows of rests and jumps.

    ``kind``: ``stick_slip``, ``one_way`` (slips of an end), ``stop`` or ``none``. ``still``: within how much (m) a
    reading counts as unmoved. ``share``: of the motion, in jumps that end a rest.
    """

    kind: str
    rests: tuple[Rest, ...]
    jumps: tuple[Jump, ...]
    still: float
    share: float

    def sizes(self, way: float = 0.0) -> Array:
        """Sizes (m, above 0) of the jumps that end a rest; up for a positive ``way``, down for a negative one."""
        return np.array([abs(j.size) for j in self.jumps if j.released and j.size * way >= 0.0])

    def durations(self) -> Array:
        """How long it rests, s."""
        return np.array([rest.duration for rest in self.rests])


def signature(time: Array, value: Array, predicted: Array) -> Signature:
    """Rests and jumps of a recording beside a smooth prediction of it.

    Args:
        time: s, increasing, shape (n,).
        value: as recorded, m (or N), shape (n,); not averaged, for a jump takes less than a sample.
        predicted: the same by a model that moves without jumps, shape (n,).
    """
    coarse = max(quantum(value), _common_step(value))
    still = max(_QUANTA * coarse, _SIGMAS * white_sigma(value), _DUST * float(np.ptp(value)))
    rests = _rests(time, value, predicted, still)
    jumps = _jumps(time, value, predicted, still, rests)
    moved = float(np.sum(np.abs(np.diff(value[_turns(value, still)])))) or 1.0
    share = min(sum(abs(j.size) for j in jumps if j.released) / moved, 1.0)
    return Signature(_kind(rests, jumps, share, float(np.ptp(value))), tuple(rests), tuple(jumps), still, share)


def seen_beside(observed: Observed, left: Array) -> Signature:
    """Rests and jumps of a channel beside the fit that leaves so much of it (SI, shape as its values)."""
    return signature(observed.time, observed.value, observed.value - left)


def _common_step(value: Array) -> float:
    """The smallest step between neighbours, where it is a common one, as of a reading with a resolution; else 0."""
    steps = np.abs(np.diff(value))
    steps = steps[steps > _DUST * float(np.ptp(value))]
    if not steps.size:
        return 0.0
    least = float(np.min(steps))
    return least if np.mean(steps < 1.05 * least) > _COMMON else 0.0


def _kind(rests: Sequence[Rest], jumps: Sequence[Jump], share: float, span: float) -> str:
    released = [j.size for j in jumps if j.released]
    up, down = sum(size > 0.0 for size in released), sum(size < 0.0 for size in released)
    if min(up, down, len(rests)) >= _FEWEST and share >= _SHARE:
        return CHANCE
    loose = [j.size for j in jumps if not j.released]
    slips = len({size > 0.0 for size in loose}) == 1 and abs(sum(loose)) > _SLIPPED * span
    if len(loose) >= _FEWEST and slips and not released:
        return 'one_way'
    stopped = any(rest.level > _HIGH and rest.missed > _STOPPED * span for rest in rests)
    return STOP if stopped and not released else 'none'


def _rests(time: Array, value: Array, predicted: Array, still: float) -> list[Rest]:
    """Longest stretches in which the value stays where it is while the prediction moves on."""
    low, span = float(np.min(value)), float(np.ptp(value)) or 1.0
    found: list[Rest] = []
    first = 0
    while first < value.size - 1:
        lowest = highest = value[first]
        least = most = predicted[first]
        last = first
        for k in range(first + 1, value.size):
            lowest, highest = min(lowest, value[k]), max(highest, value[k])
            least, most = min(least, predicted[k]), max(most, predicted[k])
            if highest - lowest > still + _CREEPS * (most - least):
                break
            last = k
        if float(np.ptp(predicted[first : last + 1])) >= _MOVES * still and last > first:
            way = predicted[first : last + 1] - predicted[first]
            missed = float(way[np.argmax(np.abs(way))])
            level = (float(np.mean(value[first : last + 1])) - low) / span
            found.append(Rest(first, last, float(time[last] - time[first]), missed, level))
            first = last + 1
        else:
            first += 1
    return found


def _jumps(time: Array, value: Array, predicted: Array, still: float, rests: Sequence[Rest]) -> list[Jump]:
    """Quick motions of one direction: far more than the prediction moves about then."""
    steps = np.diff(value)
    usual = np.abs(np.diff(predicted))
    beside = np.max(np.stack([usual, np.roll(usual, 1), np.roll(usual, -1)]), axis=0)  # a switch may come a sample off
    quick = np.abs(steps) > still + _QUICK * beside
    low, span = float(np.min(value)), float(np.ptp(value)) or 1.0
    ends = np.array([rest.last for rest in rests], dtype=int)
    found: list[Jump] = []
    k = 0
    while k < steps.size:
        if not quick[k]:
            k += 1
            continue
        last = k
        while last + 1 < steps.size and quick[last + 1] and steps[last + 1] * steps[k] > 0.0:
            last += 1
        size = float(value[last + 1] - value[k])
        stays = abs(_after(value, last + 1) - value[k]) > 0.5 * abs(size)
        if abs(size) >= _LARGE * still and stays:
            released = bool(np.any((ends <= k) & (ends >= k - _AFTER)))
            level = (0.5 * (float(value[k]) + float(value[last + 1])) - low) / span
            found.append(Jump(k, last + 1, size, level, released))
        k = last + 1
    return found


def _after(value: Array, k: int) -> float:
    """Where it is a little later: what comes back at once was no jump."""
    return float(np.median(value[k : k + 3]))


def _turns(value: Array, still: float) -> list[int]:
    """The samples between which it moves one way, by more than ``still``: its motion without its noise."""
    kept, way = [0], 0.0
    for k in range(1, value.size):
        step = value[k] - value[kept[-1]]
        if way * step > 0.0 or (abs(step) > still and way == 0.0):
            kept[-1 if len(kept) > 1 and way != 0.0 else len(kept) :] = [k]
            way = step
        elif abs(step) > still:
            kept.append(k)
            way = step
    return kept


def alike(one: Iterable[float], other: Iterable[float]) -> float:
    """The probability that two samples, as of sizes of jumps or of durations of rests, differ so much by chance.

    Two-sided Kolmogorov-Smirnov test; 1 where either has fewer than three.
    """
    first, second = np.array(list(one)), np.array(list(other))
    if min(first.size, second.size) < 3:
        return 1.0
    return float(ks_2samp(first, second).pvalue)

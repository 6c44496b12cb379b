"""How well runs of the same protocol repeat each other: what no model of one muscle can predict of them.

Runs are given on common instants, counted from the switch that all have. What they share is their mean; what each has
for itself is the rest, as it is, or after its own gain and zero are taken out (specimens differ). By moving means the
rest is divided into time scales.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.diagnosis.noise.replicates import Protocol, protocols
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle.arrays import Array

BEFORE = 2.0  # s before the switch, from which runs are compared
SCALES = (2.0, 10.0)  # s: quicker than the first, between them, slower than the last
_MOSTLY = 0.5  # of a variance
_LEAST = 10  # instants since the switch that runs have in common


@dataclass(frozen=True)
class Repeatability:
    """What runs of one protocol do not share. Root mean squares, in the unit of the channel.

    ``peak``: mean peak to peak of the runs. ``plain``: as they are. ``own_gain``: with a gain and a zero for each run.
    ``by_scale``: of ``own_gain``, what is quicker than ``SCALES[0]``, between them, and slower; NaN where a scale is
    shorter than two samples. ``foretold``: how far a run is from the mean of the others, with a gain and a zero of its
    own: the error on an unseen run that a model of all of them would have at best. Of several protocols, all but
    ``runs`` and ``peak`` are shares of the peak.
    """

    runs: int
    peak: float
    plain: float
    own_gain: float
    by_scale: tuple[float, ...]
    foretold: float

    @property
    def gains_differ(self) -> bool:
        """Whether most of what the runs do not share is their gain."""
        return self.own_gain**2 < _MOSTLY * self.plain**2


def repeatability(time: Array, values: Array) -> Repeatability | None:
    """How well runs repeat each other; None for fewer than two, and where none of them moves.

    Args:
        time: s, evenly spaced, shape (n,).
        values: of each run at these instants, shape (runs, n).
    """
    runs = values.shape[0]
    peak = float(np.mean(np.ptp(values, axis=1)))
    if runs < 2 or peak == 0.0:
        return None
    plain = values - np.mean(values, axis=0)
    own = _own_gain(values)
    pieces = _by_scale(time, own)
    free = np.sqrt(runs / (runs - 1.0))  # their mean has taken a part
    # A gain and a zero a run have taken more, of many instants: next to nothing.
    return Repeatability(
        runs,
        peak,
        free * _rms(plain),
        free * _rms(own),
        tuple(free * _rms(piece) if piece is not None else float('nan') for piece in pieces),
        _foretold(values),
    )


def between_runs(
    experiments: Sequence[Experiment], foretold: Sequence[Mapping[str, Array]] = ()
) -> dict[str, Repeatability]:
    """How well recordings of one protocol repeat each other, by channel, in shares of the peak; without those of which
    there are no two.

    ``foretold``: what a model shows at the instants of each channel, one an experiment. By what it says that they
    differ (a muscle that flows or wears, another room), they do repeat each other.
    """
    found: dict[str, list[Repeatability]] = {}
    for protocol in protocols(experiments):
        for name in sorted(set.intersection(*(set(experiments[k].observed) for k in protocol.recordings))):
            compared = side_by_side(experiments, protocol, name, foretold)
            if compared and (one := repeatability(*compared)):
                found.setdefault(name, []).append(one)
    return {name: _pooled(several) for name, several in found.items()}


def side_by_side(
    experiments: Sequence[Experiment],
    protocol: Protocol,
    channel: str,
    foretold: Sequence[Mapping[str, Array]] = (),
) -> tuple[Array, Array] | None:
    """Instants (s) from the switch on, and a channel of each run at them, shape (runs, n); a zero that is the rig's is
    what was shown before. Of what is ``foretold`` of the runs all have their mean.

    None where a run of the channel ended before the switch or hardly after it, and where none of them moves: what a
    model foretells of such runs would be taken for how they differ.
    """
    columns = [experiments[k].observed[channel] for k in protocol.recordings]
    if min(o.time.size for o in columns) < _LEAST:
        return None
    step = max(float(np.median(np.diff(o.time))) for o in columns)
    since = [o.time - begin for o, begin in zip(columns, protocol.begins, strict=True)]
    first, last = max(float(t[0]) for t in since), min(float(t[-1]) for t in since)
    if all(abs(experiments[k].imposed.drive[0]) < 1e-12 for k in protocol.recordings):
        first = max(first, -BEFORE)  # at rest before: nothing that could differ
    time = np.arange(first, last, step)
    values = np.stack([np.interp(time, t, o.value) for t, o in zip(since, columns, strict=True)])
    if np.count_nonzero(time > 0.0) < _LEAST or not np.ptp(values, axis=1).any():
        return None
    if foretold:
        shown = [foretold[k][channel] for k in protocol.recordings]
        expected = np.stack([np.interp(time, t, column) for t, column in zip(since, shown, strict=True)])
        values = values - (expected - np.mean(expected, axis=0))
    if experiments[0].model.channels[channel].floating and np.any(time <= 0.0):
        values = values - np.median(values[:, time <= 0.0], axis=1)[:, None]
    return time, values


def _pooled(found: Sequence[Repeatability]) -> Repeatability:
    """Of several protocols, each run counting alike, in shares of the peak."""
    runs = np.array([one.runs for one in found], dtype=float)

    def mean(sizes: Sequence[float]) -> float:
        shares = np.array([size / max(one.peak, 1e-300) for size, one in zip(sizes, found, strict=True)])
        known = np.isfinite(shares)
        return float(np.sqrt(np.average(shares[known] ** 2, weights=runs[known]))) if known.any() else float('nan')

    return Repeatability(
        int(runs.sum()),
        float(np.average([one.peak for one in found], weights=runs)),
        mean([one.plain for one in found]),
        mean([one.own_gain for one in found]),
        tuple(mean([one.by_scale[k] for one in found]) for k in range(len(SCALES) + 1)),
        mean([one.foretold for one in found]),
    )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _fitted(to: Array, like: Array) -> Array:
    """``like`` with the gain and zero that bring it nearest to ``to``."""
    columns = np.stack([like, np.ones_like(like)], axis=1)
    return np.asarray(columns @ np.linalg.lstsq(columns, to, rcond=None)[0])


def _own_gain(values: Array) -> Array:
    """What is left of each run beside one course that all have, with a gain and a zero for each."""
    course = np.mean(values, axis=0)
    for _ in range(20):  # the course that serves all best: alternating least squares
        gains = np.array(
            [np.linalg.lstsq(np.stack([course, np.ones_like(course)], axis=1), v, rcond=None)[0] for v in values]
        )
        size = float(np.sum(gains[:, 0] ** 2))
        if size == 0.0:  # runs that cancel each other have no course in common
            break
        better = gains[:, 0] @ (values - gains[:, 1:]) / size
        if _rms(better - course) < 1e-9 * _rms(better - np.mean(better)):
            break
        course = better
    return values - np.stack([_fitted(value, course) for value in values])


def _foretold(values: Array) -> float:
    """Each run by the mean of the others."""
    left = []
    for k, value in enumerate(values):
        others = np.mean(np.delete(values, k, axis=0), axis=0)
        left.append(value - _fitted(value, others))
    return _rms(np.stack(left))


def _by_scale(time: Array, left: Array) -> Sequence[Array | None]:
    """What is quicker than the first scale, between them, slower than the last: they add up to ``left``."""
    step = float(np.mean(np.diff(time)))
    pieces: list[Array | None] = []
    rest = left
    for scale in SCALES:
        if scale < 2.0 * step:
            pieces.append(None)
            continue
        slow = np.stack([_moving_mean(row, round(scale / step)) for row in rest])
        pieces.append(rest - slow)
        rest = slow
    return [*pieces, rest]


def _moving_mean(row: Array, width: int) -> Array:
    """The mean over so many samples about each, of fewer at the ends."""
    ones = np.ones(min(width, row.size))
    return np.asarray(np.convolve(row, ones, 'same') / np.convolve(np.ones_like(row), ones, 'same'))

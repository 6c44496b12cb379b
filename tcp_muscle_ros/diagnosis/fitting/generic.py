"""A misfit without a name: smooth functions of what drives a muscle.

Regressing a channel's residual on these answers two questions that must not depend on the catalogue of effects: is
there structure beyond noise (lack of fit), and how large and how coloured is the noise itself, once structure is out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.diagnosis.model.model import Channel
from tcp_muscle_ros.diagnosis.noise.instruments import largest_noise
from tcp_muscle_ros.diagnosis.noise.noise import Noise, estimate, slow_size, whiten
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle import Outputs
from tcp_muscle_ros.muscle.arrays import Array

_LEVELS, _MOMENTS, _ELAPSED, _LENGTHS, _DRIVES = 6, 8, 4, 24, 4


@dataclass(frozen=True)
class Drivers:
    """What a residual may go with, at one channel's instants, each shape (m,): SI."""

    level: Array
    rate: Array
    heating: Array
    since_switch: Array
    elapsed: Array
    load: Array
    place: Array
    drive: Array


def drivers(experiment: Experiment, outputs: Outputs, time: Array) -> Drivers:
    """The drivers at ``time``, from the model's state and the imposed inputs."""
    imposed = experiment.imposed
    state, motion = (getattr(outputs, name) for name in (experiment.model.state, experiment.model.motion))
    level = np.interp(time, outputs.time, state)
    rate = np.interp(time, outputs.time, np.gradient(state, outputs.time))
    at = np.clip(np.searchsorted(imposed.time, time + 1e-9, side='right') - 1, 0, imposed.time.size - 1)
    on = imposed.drive[at] > 0.05 * max(float(np.max(np.abs(imposed.drive))), 1e-12)
    driven = imposed.drive > 0.05 * max(float(np.max(np.abs(imposed.drive))), 1e-12)
    jumps = np.abs(np.diff(imposed.drive)) > 0.05 * max(float(np.ptp(imposed.drive)), 1e-12)
    edges = np.concatenate([[imposed.time[0]], imposed.time[1:][jumps | (np.diff(driven.astype(int)) != 0)]])
    last = edges[np.maximum(np.searchsorted(edges, time + 1e-9, side='right') - 1, 0)]
    return Drivers(
        level,
        rate,
        on.astype(float),
        np.maximum(time - last, 0.0),
        time - imposed.time[0],
        imposed.load[at],
        np.interp(time, outputs.time, motion),
        imposed.drive[at],
    )


def hats(x: Array, knots: Array) -> Array:
    """Piecewise linear functions that are 1 at one knot and 0 at the others, shape (m, knots)."""
    return np.column_stack([np.interp(x, knots, row) for row in np.eye(knots.size)])


def _spread_knots(x: Array, count: int) -> Array:
    return np.unique(np.quantile(x, np.linspace(0.0, 1.0, count)))


def basis(found: Sequence[Drivers], stroke: bool) -> list[Array]:
    """The columns of the generic model for each recording's channel, which shows the ``stroke`` or not.

    Functions of temperature, warming and cooling apart; of its rate; of the time since the last switch, driven and not;
    of displacement, load and drive; of the elapsed time of each recording; a stroke may change in its course.
    """
    pooled = {
        name: np.concatenate([getattr(d, name) for d in found])
        for name in ('level', 'since_switch', 'load', 'place', 'drive', 'rate')
    }
    warm = _spread_knots(pooled['level'], _LEVELS)
    moment = np.unique(
        np.concatenate([[0.0], np.geomspace(0.1, max(float(pooled['since_switch'].max()), 1.0), _MOMENTS)])
    )
    loads = _spread_knots(pooled['load'], 3)
    places = _spread_knots(pooled['place'], _LENGTHS)
    levels = _spread_knots(pooled['drive'], _DRIVES)
    quickest = max(float(np.max(np.abs(pooled['rate']))), 1e-12)
    middle, span = float(np.mean(pooled['place'])), max(float(np.ptp(pooled['place'])), 1e-12)
    columns: list[Array] = []
    for owner, d in enumerate(found):
        on, off = d.heating[:, None], 1.0 - d.heating[:, None]
        rate = d.rate[:, None] / quickest
        warming = (rate > 0.0).astype(float)
        moved = (d.place[:, None] - middle) / span
        groups = [
            hats(d.level, warm) * warming,
            hats(d.level, warm) * (1.0 - warming),
            np.hstack([rate, rate * np.abs(rate)]),
            hats(d.place, places),
            hats(d.drive, levels),
            hats(d.since_switch, moment) * on,
            hats(d.since_switch, moment) * off,
        ]
        if loads.size > 1:
            hot = (d.level - warm[0])[:, None] / max(float(np.ptp(warm)), 1e-9)
            groups += [hats(d.load, loads), hats(d.load, loads) * hot]
        knots = np.linspace(0.0, max(float(d.elapsed[-1]), 1e-9), _ELAPSED)
        course = hats(d.elapsed, knots)
        if stroke:
            course = np.hstack([course, moved * hats(d.elapsed, knots[[0, -1]])])
        groups += [course if k == owner else np.zeros_like(course) for k in range(len(found))]
        columns.append(np.hstack(groups))
    return columns


@dataclass(frozen=True)
class Structure:
    """What the generic model finds in one channel's residuals.

    ``noise``: size and colour of what it leaves; ``inflation``: how much the variance of slow sums exceeds that of the
    assumed colour (1: nothing beyond it); ``gain``: drop of the whitened sum of squares, over the columns' number
    ``terms``; ``fitted``: its prediction, one array a recording (SI, as residuals weigh); ``confirmed``: fitted without
    one part of the data, it predicts that part better than nothing does; ``own``: the size (SI, as residuals weigh) of
    what it leaves of each recording.
    """

    noise: Noise
    inflation: float
    gain: float
    terms: int
    fitted: tuple[Array, ...]
    confirmed: bool
    own: tuple[float, ...] = ()

    @property
    def significant(self) -> bool:
        """Whether the gain exceeds what noise gives (four standard deviations of its distribution)."""
        return self.gain > self.terms + 4.0 * float(np.sqrt(2.0 * self.terms))


def structure(
    residuals: Sequence[Array],
    times: Sequence[Array],
    found: Sequence[Drivers],
    floor: float,
    repeated: Noise | None = None,
    averaged: float = 1.0,
    channel: Channel | None = None,
    *,
    most_of_single: float,
    beside: Sequence[float] | None = None,
) -> Structure:
    """Regress one channel's residuals on the generic basis: first plainly to learn the noise, then whitened.

    ``floor`` is the quick noise (SI) of samples that are means of ``averaged`` readings: the noise is never taken to be
    less, nor more than such an instrument wanders: what is slow and large is misfit. ``repeated`` is the noise that
    repeated cycles show; it is taken where it is the smaller, since structure that this basis misses is not in it.
    ``most_of_single``: times the noise of single readings, which it is at most beside that wander. ``channel``: which
    it is; one that shows the stroke wears and is broken in. ``beside``: what the residuals of each recording, and so
    all that they may go with, were weighed by beside the others; default nothing.
    """
    columns = basis(found, channel is not None and channel.floating)
    if beside is not None:
        columns = [c * weighs for c, weighs in zip(columns, beside, strict=True)]
    stacked, together = np.vstack(columns), np.concatenate(residuals)
    weights = _solve(stacked, together)
    left = [r - c @ weights for r, c in zip(residuals, columns, strict=True)]
    noises = [estimate(part, 0.0) for part in left]
    sizes = [part.size for part in left]
    sigma = max(float(np.sqrt(np.average([n.sigma**2 for n in noises], weights=sizes))), floor)
    phi = float(np.average([n.phi for n in noises], weights=sizes))
    # Columns taken out of coloured noise take some of it along.
    sigma *= float(np.sqrt(1.0 / max(1.0 - stacked.shape[1] / max(together.size, 1), 0.2)))
    noise = Noise(sigma, phi)
    if repeated is not None and slow_size(repeated) < slow_size(noise):
        noise = Noise(max(repeated.sigma, floor), repeated.phi)
    most = largest_noise(channel, float(np.sqrt(averaged)) * floor, most_of_single)
    noise = Noise(min(noise.sigma, most), noise.phi)
    white = np.concatenate([whiten(r, t, noise) for r, t in zip(residuals, times, strict=True)])
    white_columns = np.vstack([whiten(c, t, noise) for c, t in zip(columns, times, strict=True)])
    coefficients = _solve(white_columns, white)
    rest = white - white_columns @ coefficients
    inflation = 1.0 if noise.sigma < sigma and noise.sigma < most else slow_variance(rest, times, sizes)
    inflation = min(inflation, max((2.0 * most / noise.sigma) ** 2, 1.0))
    gain = float(white @ white - rest @ rest) / inflation
    terms = int(np.linalg.matrix_rank(white_columns))
    fitted = tuple(c @ coefficients for c in columns)
    own = tuple(n.sigma for n in noises)
    return Structure(noise, inflation, gain, terms, fitted, _confirmed(white, white_columns, times, sizes), own)


def _confirmed(white: Array, columns: Array, times: Sequence[Array], sizes: Sequence[int]) -> bool:
    """Leave out each recording (or each quarter of a single one): does the misfit of the left out part fall?"""
    if len(sizes) > 1:
        label = np.repeat(np.arange(len(sizes)), sizes)
    else:
        label = np.minimum((4.0 * (times[0] - times[0][0]) / max(float(np.ptp(times[0])), 1e-9)).astype(int), 3)
    drops = []
    for part in range(int(label.max()) + 1):
        inside = label == part
        if not inside.any() or inside.all():
            continue
        predicted = columns[inside] @ _solve(columns[~inside], white[~inside])
        drop = white[inside] ** 2 - (white[inside] - predicted) ** 2
        drops.extend(np.add.reduceat(drop, np.arange(0, drop.size, max(1, drop.size // 12))).tolist())
    total, spread = float(np.sum(drops)), float(np.std(drops) * np.sqrt(len(drops)))
    return len(drops) > 3 and total > 2.0 * spread


def _solve(columns: Array, values: Array) -> Array:
    """Least squares with a trace of ridge: the groups overlap."""
    normal = columns.T @ columns
    ridge = 1e-8 * float(np.trace(normal)) / max(normal.shape[0], 1) + 1e-300
    return np.asarray(np.linalg.solve(normal + ridge * np.eye(normal.shape[0]), columns.T @ values))


def slow_variance(white: Array, times: Sequence[Array], sizes: Sequence[int], reach: float = 10.0) -> float:
    """Variance of sums over ``reach`` seconds of whitened residuals over what independent ones give; 1 at least."""
    total, count, start = 0.0, 0, 0
    for time, size in zip(times, sizes, strict=True):
        part = white[start : start + size]
        start += size
        label = np.floor((time - time[0]) / reach).astype(int)
        sums = np.bincount(label, part)
        number = np.bincount(label)
        full = number > 4
        total += float(np.sum(sums[full] ** 2 / number[full]))
        count += int(np.sum(full))
    variance = float(np.mean(white**2))
    return max(1.0, total / max(count, 1) / max(variance, 1e-12)) if count >= 8 else 1.0

"""The noise of a channel: its size and its colour, and the whitening that makes a misfit comparable with it.

Noise is taken as a first-order autoregression per channel: ``e_k = phi e_{k-1} + w_k``. Residuals of a thermal rig are
coloured, and tests that assume white noise raise false alarms almost always (see docs/diagnosis.md).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.muscle.arrays import Array, Mask

_LARGEST_PHI = 0.98
_ENOUGH = 50  # bends, by which a noise is known to a tenth or so
_GAP = 5.0  # intervals: after a longer pause the noise has forgotten


@dataclass(frozen=True)
class Noise:
    """``sigma`` in the channel's SI unit (of one sample), ``phi`` the correlation of neighbours."""

    sigma: float
    phi: float = 0.0


def white_sigma(value: Array, moving: Mask | None = None) -> float:
    """The quick part of the noise, from second differences, robust against edges; quantisation included.

    A channel whose second differences mostly vanish is quantised: its step over sqrt(12) is the least noise. Samples
    while something is ``moving``, as a weight that swings, tell nothing where enough others do.
    """
    if value.size < 4:
        return 0.0
    bends = np.diff(value, 2)
    if moving is not None:
        still = ~(moving[2:] | moving[1:-1] | moving[:-2])
        bends = bends[still] if np.count_nonzero(still) >= _ENOUGH else bends
    return max(sigma_of_bends(bends), quantum(value) / float(np.sqrt(12.0)))


def sigma_of_bends(second: Array) -> float:
    """Standard deviation of the white noise that has these second differences, robust against edges."""
    return float(np.median(np.abs(second)) / 0.6745 / np.sqrt(6.0))


def quantum(value: Array) -> float:
    """The smallest step between different values, 0 where values repeat too seldom to be quantised."""
    levels = np.unique(value)
    if value.size < 20 or levels.size < 2 or levels.size > 0.5 * value.size:
        return 0.0
    steps = np.diff(levels)
    real = steps[steps > 1e-9 * float(np.ptp(levels))]
    return float(np.min(real)) if real.size else 0.0


def whitening(time: Array, noise: Noise) -> Callable[[Array], Array]:
    """What removes the colour from residuals (m,) or columns (m, n) at these times: see ``whiten``."""
    sigma, phi = noise.sigma, noise.phi
    if phi == 0.0 or time.size < 2:
        return lambda residual: residual / sigma
    dt = np.diff(time)
    typical = float(np.median(dt))
    even = bool(np.ptp(dt) < 0.02 * typical)  # the common case
    before = np.full(dt.size, phi) if even else np.where(dt < _GAP * typical, phi ** (dt / typical), 0.0)
    after = np.sqrt(1.0 - before**2)

    def white(residual: Array) -> Array:
        scaled = residual / sigma
        rows = slice(None) if scaled.ndim == 1 else (slice(None), None)
        scaled[1:] = (scaled[1:] - before[rows] * scaled[:-1]) / after[rows]
        return np.asarray(scaled)

    return white


def whiten(residual: Array, time: Array, noise: Noise) -> Array:
    """Residuals (m,) or columns (m, n) with the colour removed, in units of sigma: unit variance, independent."""
    return whitening(time, noise)(residual)


def estimate(residual: Array, floor: float) -> Noise:
    """Size and colour of residuals (m,); never below ``floor``, the sensor's quick noise."""
    if residual.size < 8:
        return Noise(max(float(np.std(residual)), floor, 1e-12))
    centred = residual - residual.mean()
    power = float(centred @ centred)
    phi = float(centred[1:] @ centred[:-1]) / power if power > 0.0 else 0.0
    sigma = max(float(np.sqrt(power / residual.size)), floor, 1e-12)
    return Noise(sigma, float(np.clip(phi, 0.0, _LARGEST_PHI)))


def slow_size(noise: Noise) -> float:
    """The noise's weight at low frequencies, by which two estimates are compared."""
    return noise.sigma * float(np.sqrt((1.0 + noise.phi) / (1.0 - noise.phi)))

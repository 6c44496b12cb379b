"""The noise of a channel: its size and its colour, and the whitening that makes a misfit comparable with it.

Noise is taken as a first-order autoregression per channel: ``e_k = phi e_{k-1} + w_k``. Residuals of a thermal rig are
coloured, and tests that assume white noise raise false alarms almost always (see docs/diagnosis.md).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.diagnosis.observation.scatter import white_sigma
from tcp_muscle_ros.muscle.arrays import Array

_LARGEST_PHI = 0.98
_GAP = 5.0  # intervals: after a longer pause the noise has forgotten


@dataclass(frozen=True)
class Noise:
    """``sigma`` in the channel's SI unit (of one sample), ``phi`` the correlation of neighbours."""

    sigma: float
    phi: float = 0.0


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


def quick_noise(experiments: Sequence[Experiment]) -> dict[str, Noise]:
    """White noise of each channel, from the recordings' second differences; a small share of the span at least.

    It is that of a usual recording: values that weigh less beside it have more.
    """
    noise = {}
    for name, found in _by_channel(experiments).items():
        span = max(float(np.ptp(o.value)) for o in found)
        sigma = float(np.median([white_sigma(o.value, o.swinging) * o.beside for o in found]))
        noise[name] = Noise(max(sigma, 1e-4 * span, 1e-9))
    return noise


def over_all(experiments: Sequence[Experiment], noise: Mapping[str, Noise]) -> dict[str, float]:
    """Root mean square (SI) of the noise of all values of each channel, of which ``noise`` is that of a usual one."""
    found = {}
    for name, observed in _by_channel(experiments).items():
        variances = [o.beside**-2.0 for o in observed]
        found[name] = noise[name].sigma * float(np.sqrt(np.average(variances, weights=[o.time.size for o in observed])))
    return found


def _by_channel(experiments: Sequence[Experiment]) -> dict[str, list[Observed]]:
    """Each channel of the recordings that have it."""
    names = sorted({name for e in experiments for name in e.observed})
    return {name: [e.observed[name] for e in experiments if name in e.observed] for name in names}

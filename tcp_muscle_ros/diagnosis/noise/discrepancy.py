"""Errors that are allowed: unknown but for their size, and no noise.

A channel may err in given ways, each a column of the size that it usually has (Kennedy & O'Hagan 2001). What is made
white is made so for noise and such errors together: they weigh as little as their size says.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tcp_muscle_ros.diagnosis.noise.noise import Noise, whitening
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.muscle.arrays import Array, Mask


@dataclass(frozen=True, eq=False)
class Allowance:
    """In which ways one channel of one recording may err, each a column as large (SI) as it usually does, shape (m, n).

    ``forms``: the model, by what its forms may miss; ``readings``: what was imposed, and the instants, by what the
    instruments do not tell; ``runs``: what differs from run to run, and ``apart``: the standard deviation (SI) of that
    which is as quick as noise. ``calm``: what values weigh that were taken while a weight may swing.
    """

    forms: Array | None = None
    readings: Array | None = None
    runs: Array | None = None
    apart: float = 0.0
    calm: float = 1.0

    @property
    def ways(self) -> Array | None:
        """All in which it may err, shape (m, n); None: none."""
        known = [columns for columns in (self.forms, self.readings, self.runs) if columns is not None]
        return np.hstack(known) if known else None

    def weight(self, observed: Observed) -> Array:
        """What one value weighs beside a usual one, shape (m,)."""
        if observed.swinging is None or self.calm == 1.0:
            return observed.weight
        return np.where(observed.swinging, self.calm, 1.0) * observed.weight

    def only(self, keep: Mask) -> 'Allowance':
        """That of some of the values."""
        each = ((name, getattr(self, name)) for name in ('forms', 'readings', 'runs'))
        return replace(self, **{name: columns[keep] for name, columns in each if columns is not None})


NO_ALLOWANCE = Allowance()


@lru_cache(maxsize=24)
def whitening_of(observed: Observed, allowed: Allowance, noise: Noise) -> Callable[[Array], Array]:
    """What makes weighted residuals (m,) or columns (m, n) of a channel white, allowed errors included."""
    white = whitening(observed.time, noise)
    if allowed.ways is None:
        return white
    allowing = allowing_for(white(allowed.ways * allowed.weight(observed)[:, None]))
    return lambda weighted: allowing(white(weighted))


def allowing_for(columns: Array) -> Callable[[Array], Array]:
    """What makes white values (m,) or columns (m, n) white beside errors too, of which each of ``columns`` is one, as
    large as it usually is."""
    ways, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    beside_noise = ways * (1.0 - 1.0 / np.sqrt(1.0 + sizes**2))
    return lambda white: np.asarray(white - beside_noise @ (ways.T @ white))


def expected(observed: Observed, allowed: Allowance, noise: Noise, left: Array) -> Array:
    """Of residuals (m,), what is most likely an allowed error, given the noise and the errors' sizes."""
    if allowed.ways is None:
        return np.zeros(left.size)
    white, weight = whitening(observed.time, noise), allowed.weight(observed)
    columns = white(allowed.ways * weight[:, None])
    normal = columns.T @ columns + np.eye(columns.shape[1])
    return np.asarray(allowed.ways @ np.linalg.solve(normal, columns.T @ white(left * weight)))

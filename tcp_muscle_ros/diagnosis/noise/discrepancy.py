"""Errors of the model that are allowed: unknown but for their size, and no noise.

A channel may err in given ways, each a column of the size that it usually has (Kennedy & O'Hagan 2001). What is made
white is made so for noise and such errors together: they weigh as little as their size says.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from tcp_muscle_ros.diagnosis.noise.noise import Noise, whitening
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.muscle.arrays import Array


@lru_cache(maxsize=64)
def whitening_of(observed: Observed, noise: Noise) -> Callable[[Array], Array]:
    """What makes weighted residuals (m,) or columns (m, n) of a channel white, allowed errors included."""
    white = whitening(observed.time, noise)
    if observed.ways is None:
        return white
    ways, sizes, _ = np.linalg.svd(white(observed.ways * observed.weight[:, None]), full_matrices=False)
    beside_noise = ways * (1.0 - 1.0 / np.sqrt(1.0 + sizes**2))

    def allowing(weighted: Array) -> Array:
        whitened = white(weighted)
        return np.asarray(whitened - beside_noise @ (ways.T @ whitened))

    return allowing


def expected(observed: Observed, noise: Noise, left: Array) -> Array:
    """Of residuals (m,), what is most likely an allowed error, given the noise and the errors' sizes."""
    if observed.ways is None:
        return np.zeros(left.size)
    white = whitening(observed.time, noise)
    columns = white(observed.ways * observed.weight[:, None])
    normal = columns.T @ columns + np.eye(columns.shape[1])
    return np.asarray(observed.ways @ np.linalg.solve(normal, columns.T @ white(left * observed.weight)))

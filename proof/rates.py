"""Rates with their intervals."""

from collections.abc import Sequence

import numpy as np


def wilson(hits: int, n: int, z: float = 1.96) -> tuple[float, float]:
    """The 95 % interval of a rate."""
    if n == 0:
        return 0.0, 1.0
    p = hits / n
    centre = (p + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z / (1 + z**2 / n) * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    return float(max(0.0, centre - half)), float(min(1.0, centre + half))


def told(results: Sequence[bool]) -> str:
    """How often, out of how many, with its interval, in words."""
    low, high = wilson(sum(results), len(results))
    return f'{sum(results)}/{len(results)} ({100 * low:.0f} to {100 * high:.0f} %)' if results else '-'

"""Tables of a Plant, read between their points."""

from numba import njit

from proof.truth.plant import H_STEP, T_LOW, T_STEP, Array


@njit(cache=True)
def look(table: Array, place: float) -> float:
    """A table at a place counted in its points, straight between them, constant beyond its ends."""
    last = len(table) - 2
    if place <= 0.0:
        return table[0]
    if place >= last:
        return table[last]
    j = int(place)
    return table[j] + (place - j) * (table[j + 1] - table[j])


@njit(cache=True)
def of_T(table: Array, T: float) -> float:
    """A table over temperature, degC."""
    return look(table, (T - T_LOW) / T_STEP)


@njit(cache=True)
def of_H(table: Array, H: float) -> float:
    """A table over length, m."""
    return look(table, H / H_STEP)

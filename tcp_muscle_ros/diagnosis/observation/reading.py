"""Reading a model's output at the instants of a channel, compiled: a diagnosis does it a hundred thousand times."""

from tcp_muscle_ros.muscle.arrays import Array, Places
from tcp_muscle_ros.muscle.compiled import entry

_GROWS = 5.0  # at most, towards a step


@entry
def read(value: Array, places: Places, weights: Array, shown: Array) -> None:
    """Sum up values by the weights of their places, both shape (m, n), into ``shown``, shape (m,)."""
    for k in range(places.shape[0]):
        total = weights[k, 0] * value[places[k, 0]]
        for j in range(1, places.shape[1]):
            total += weights[k, j] * value[places[k, j]]
        shown[k] = total


@entry
def average(shown: Array, time: Array, inner: Places, first: Places, last: Places, width: Array, mean: Array) -> None:
    """The ``mean`` over blocks of squared ``width`` (s^2), where this is ``shown`` in their middles, all shape (m,).

    They differ by a 24th of the second difference over that width. ``inner``, ``first`` and ``last`` are the places of
    values between two others of their stretch, at its begin and at its end; ``mean`` holds zeros before.
    """
    bend = mean  # each second difference stands where the mean will
    for i in inner:
        after = (shown[i + 1] - shown[i]) / (time[i + 1] - time[i])
        before = (shown[i] - shown[i - 1]) / (time[i] - time[i - 1])
        bend[i] = 2.0 * (after - before) / (time[i + 1] - time[i - 1])
    for i in first:
        growth = bend[i + 1] / bend[i + 2]
        # Not a number where nothing bends.
        bend[i] = bend[i + 1] * (min(max(growth, 1.0), _GROWS) if growth == growth else 1.0)
    for i in last:
        bend[i] = bend[i - 1]
    for i in range(shown.size):
        mean[i] = shown[i] + bend[i] * width[i] / 24.0

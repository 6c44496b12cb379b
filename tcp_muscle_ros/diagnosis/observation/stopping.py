"""Does a motion end against something? Told from the recording alone, for a model bends to what it is fitted to.

A muscle that comes to its steady state slows down all the way: to the last hundredth it takes longer than to the tenth
before. What runs into coils in contact, a rail or a string goes on until it is there, and then does not move.
"""

from collections.abc import Iterator

import numpy as np

from tcp_muscle_ros.muscle.arrays import Array

_HALF, _MOST, _THERE = 0.5, 0.9, 0.99  # of the motion from where it was as the drive came on to where it ends
_ABRUPT = 0.8  # times as long from _MOST to _THERE as from _HALF to _MOST: 1.43 in a steady state, 0.22 against a wall
_LEAST, _LONGER = 5.0, 0.9  # s, and times from _HALF to _THERE, that it stays while the drive goes on: less is a rest
_STILL = 0.025  # of the motion, within which it stays
_READINGS = 4  # from _HALF to _THERE, or it was not seen to arrive
_GOES_ON = 0.985  # of the drive that it came with: 3 % of power less, and a steady state is come to that abruptly


def stops(time: Array, value: Array, drive_time: Array, drive: Array) -> Iterator[tuple[float, float, float]]:
    """(from s, to s, at which value) of each heating that a stop ends.

    Args:
        time: s, increasing, shape (n,).
        value: what moves, as recorded, shape (n,).
        drive_time: when the drive had each of its values, s, each until the next, shape (m,).
        drive: current, voltage or power, shape (m,).
    """
    on = drive > 0.5 * float(np.max(drive, initial=0.0))
    begins = drive_time[1:][on[1:] & ~on[:-1]]
    for begin in begins:
        off = drive_time[(drive_time > begin) & ~on]
        inside = (time >= begin) & (time <= (off[0] if off.size else time[-1]))
        if np.count_nonzero(inside) > 2 * _READINGS:
            driven = drive[np.maximum(np.searchsorted(drive_time, time[inside], 'right') - 1, 0)]
            largest = float(np.max(np.abs(value - value[inside][0])))
            yield from _stopped(time[inside], value[inside], driven, largest)


def _stopped(time: Array, value: Array, drive: Array, largest: float) -> Iterator[tuple[float, float, float]]:
    """The stop that ends one heating, if one does; ``drive`` at each reading, ``largest``: motion in the whole
    recording."""
    end = float(np.median(value[-_READINGS:]))
    moved = (value - value[0]) / (end - value[0]) if abs(end - value[0]) > 0.5 * largest else np.zeros(value.size)
    if moved[-1] < _THERE:
        return
    half, most, there = (int(np.argmax(moved >= share)) for share in (_HALF, _MOST, _THERE))
    arriving, stayed = time[there] - time[half], time[-1] - time[there]
    still = np.ptp(moved[there:]) < _STILL and there - half >= _READINGS
    abrupt = time[there] - time[most] < _ABRUPT * (time[most] - time[half])
    goes_on = np.median(drive[there:]) > _GOES_ON * np.median(drive[half : there + 1])  # or it is held where it is
    if still and abrupt and goes_on and stayed > max(_LEAST, _LONGER * arriving):
        yield float(time[there]), float(time[-1]), end

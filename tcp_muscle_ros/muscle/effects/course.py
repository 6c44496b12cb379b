"""The course of what changes while a recording is made: part of the effects that are no property of the muscle."""

from tcp_muscle_ros.muscle.compiled import inner


@inner
def mean_rate(z: float, bow: float, swing: float) -> float:
    """What has come by the share z of the whole time, over z: 1 along a straight line and at the end of any course."""
    rate: float = 1.0 + (1.0 - z) * (bow + swing * (1.0 - 2.0 * z))
    return rate

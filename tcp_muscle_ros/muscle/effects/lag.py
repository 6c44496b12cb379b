"""A first-order lag that stays whole down to a time constant of zero, for the effects that are one.

A state s follows its input u with tau ds/dt = u - s. Shorter than SHORTEST, the time between two samples of most
recordings, the state keeps that time constant and enters with the weight tau/SHORTEST: the mean delay is still tau,
the step size stays reasonable, and at tau = 0 there is no lag.
"""

from tcp_muscle_ros.muscle.compiled import inner

SHORTEST = 0.05  # s


@inner
def approach(tau: float, wanted: float, state: float) -> float:
    """ds/dt of the state that lags ``wanted``."""
    rate: float = (wanted - state) / max(tau, SHORTEST)
    return rate


@inner
def lagging(tau: float, wanted: float, state: float) -> float:
    """The lagging value."""
    value: float = wanted + min(tau / SHORTEST, 1.0) * (state - wanted)
    return value


def fastest(tau: float) -> float:
    """The rate (1/s) that the stepper must resolve."""
    return 1.0 / max(tau, SHORTEST)

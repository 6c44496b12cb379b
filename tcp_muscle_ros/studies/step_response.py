"""What a displacement did after its setpoint changed: settling, overshoot, errors. Pure; arrays in, numbers out.

Times count from the first entry of ``time``, which is the moment of the step. A quantity that never comes about
is NaN.
"""

from dataclasses import dataclass
from math import nan

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
BAND = 0.02  # of the step: the band in which a response counts as settled
STEADY = 5.0  # s at the end of a step, in which the steady error is taken


def entry_time(time: Array, value: Array, target: float, band: float) -> float:
    """When the value (n,) first comes within ``band`` of the target, s."""
    inside = np.abs(value - target) <= band
    return float(time[np.argmax(inside)] - time[0]) if inside.any() else nan


def settling_time(time: Array, value: Array, target: float, band: float) -> float:
    """When the value (n,) comes within ``band`` of the target to stay, s."""
    outside = np.flatnonzero(np.abs(value - target) > band)
    if outside.size == 0:
        return 0.0
    after = int(outside[-1]) + 1
    return float(time[after] - time[0]) if after < time.size else nan


def overshoot(value: Array, start: float, target: float) -> float:
    """How far the value (n,) goes beyond the target, as a share of the step; 0 where it does not."""
    step = target - start
    if step == 0.0:
        return nan
    return max(0.0, float(np.max((value - target) / step)))


def rms_error(value: Array, target: Array | float) -> float:
    """Root mean square of value (n,) minus target."""
    return float(np.sqrt(np.mean((value - target) ** 2)))


@dataclass(frozen=True)
class StepResponse:
    """One step. Times s, errors m, currents A, overshoot as a share of the step."""

    start: float
    target: float
    settling_time: float
    overshoot: float
    steady_error: float  # the largest in the last STEADY seconds
    rms_error: float
    ripple: float  # standard deviation of the current in the same seconds


def step_response(time: Array, displacement: Array, current: Array, target: float) -> StepResponse:
    """The response of a displacement (n,) with its current (n,), from where it is at the first sample."""
    start = float(displacement[0])
    late = time >= time[-1] - STEADY
    return StepResponse(
        start=start,
        target=target,
        settling_time=settling_time(time, displacement, target, BAND * abs(target - start)),
        overshoot=overshoot(displacement, start, target),
        steady_error=float(np.max(np.abs(displacement[late] - target))),
        rms_error=rms_error(displacement, target),
        ripple=float(np.std(current[late])),
    )

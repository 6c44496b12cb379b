"""A channel that is late, as a diagnosis sees it: what it shows is a mean over several samples.

Such a mean holds the kink that a delayed edge makes wherever it falls, which the value in the middle does not. So the
model is run without the delay, whose edges fall on instants that are known, and what it shows in the end, whatever else
its sensors do to it, is read late afterwards.
"""

from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.diagnosis.model.model import Model
from tcp_muscle_ros.diagnosis.observation.imposed import Imposed
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.muscle.arrays import Array

_SAMPLES = 12  # at most, by which a mean is taken


@dataclass(frozen=True)
class Late:
    """Which channel is late: by ``delay`` (s) and a share ``pace`` of the time since the start (``Effect.late``). It
    ``jumps`` with a step of the load, where it shows how the end moves."""

    channel: str
    delay: float
    pace: float
    jumps: bool = False

    def seen(self, imposed: Imposed, shown: Array, observed: Observed) -> Array:
        """What is shown at ``imposed.time``, read late where it was observed, shape as ``observed.time``.

        A mean over late samples differs from the value in the middle of present ones by as much as from their mean: so
        a delay of nothing is nothing.
        """
        middle = np.interp(observed.time, imposed.time, shown)
        time, shown = _with_both_sides(imposed, shown) if self.jumps else (imposed.time, shown)
        instants = _samples(observed)
        behind = self.delay + self.pace * (instants - imposed.time[0])
        change = np.interp(instants - behind, time, shown) - np.interp(instants, time, shown)
        return np.asarray(middle + change.mean(axis=1))


def taken_out(muscle: Parameters, model: Model) -> tuple[Parameters, Late | None]:
    """The muscle without a late channel, and which one it is."""
    for effect in muscle.effects:
        late = model.effects[effect].late
        if late is not None:
            delay, pace, channel = (f'{effect}.{name}' for name in late)
            which = model.specifications[channel].choices[round(muscle[channel])]
            prompt = muscle.only_effects(e for e in muscle.effects if e != effect)
            return prompt, Late(which, muscle[delay], muscle[pace], model.channels[which].floating)
    return muscle, None


def _samples(observed: Observed) -> Array:
    """The instants of the samples that were averaged, or of as many as do, shape (m, samples)."""
    if not observed.time.size:
        return np.zeros((0, 1))
    period = float(np.median(np.diff(observed.time) / observed.count[1:])) if observed.time.size > 1 else 0.0
    some = int(min(observed.count.max(), _SAMPLES))
    count = observed.count[:, None]
    nth = np.floor((np.arange(some) + 0.5) / some * count)  # of its own samples
    return np.asarray(observed.time[:, None] + period * (nth + 0.5 - 0.5 * count))


def _with_both_sides(imposed: Imposed, shown: Array) -> tuple[Array, Array]:
    """Time and what is shown, with what was shown just before each step of the load."""
    steps = np.flatnonzero(np.diff(imposed.load) != 0.0) + 1
    steps = steps[steps > 1]
    slope = (shown[steps - 1] - shown[steps - 2]) / np.maximum(imposed.time[steps - 1] - imposed.time[steps - 2], 1e-9)
    before = shown[steps - 1] + slope * (imposed.time[steps] - imposed.time[steps - 1])
    return np.insert(imposed.time, steps, imposed.time[steps] - 1e-9), np.insert(shown, steps, before)

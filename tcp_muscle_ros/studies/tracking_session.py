"""A recorded session of setpoints: what was asked for, how fast it can be had, and what came of it."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tcp_muscle_ros.control.inverse import Inverse
from tcp_muscle_ros.muscle import Parameters, simulate
from tcp_muscle_ros.recording.recording import Channel, Recording
from tcp_muscle_ros.studies.step_response import BAND, Array, StepResponse, entry_time, rms_error, step_response

_SHORTEST = 2.0  # s; a setpoint held for less is part of a path


@dataclass(frozen=True)
class Stretch:
    """A part of the session, s from the recording's start: one setpoint (m) held, or a path (target NaN)."""

    begin: float
    end: float
    target: float

    @property
    def is_path(self) -> bool:
        """Whether the setpoint moves."""
        return self.target != self.target


@dataclass(frozen=True)
class Step:
    """One held setpoint: the shortest time (s) in which the muscle can be within 2 % of it, and what happened."""

    stretch: Stretch
    possible_time: float
    response: StepResponse


@dataclass(frozen=True)
class Path:
    """One moving setpoint: errors in m."""

    stretch: Stretch
    rms_error: float
    largest_error: float


def stretches(setpoint: Channel) -> list[Stretch]:
    """Cut a session where a setpoint was held for 2 s or longer, and between."""
    time, value = setpoint.time, setpoint.value
    changes = np.flatnonzero(np.diff(value)) + 1
    edges = [0, *changes.tolist(), len(time)]
    ends = np.append(time, time[-1])
    found: list[Stretch] = []
    for first, after in pairwise(edges):
        begin, end = float(ends[first]), float(ends[after])
        if end - begin >= _SHORTEST:
            found.append(Stretch(begin, end, float(value[first])))
        elif found and found[-1].is_path:
            found[-1] = Stretch(found[-1].begin, end, np.nan)
        else:
            found.append(Stretch(begin, end, np.nan))
    return found


def possible_time(model: Parameters, limit: float, start: float, target: float, load: float) -> float:
    """When full current (A), or none for a release, brings the model from one displacement (m) near the other, s."""
    time = np.arange(0.0, 120.0, 0.01)
    begin = Inverse(model, load).temperature(start, load)
    out = simulate(model, time, limit if target > start else 0.0, load=load, temperature=begin)
    return entry_time(time, out.displacement, target, BAND * abs(target - start))


def judge(recording: Recording, model: Parameters, limit: float, load: float) -> tuple[list[Step], list[Path]]:
    """Every held setpoint that differs from where the muscle was, and every path, of a recorded session."""
    steps, paths = [], []
    for stretch in stretches(recording['displacement_setpoint']):
        time, displacement = _within(recording['displacement'], stretch)
        if time.size < 2:
            continue
        current = _held(recording['current'], time)
        if stretch.is_path:
            wanted = _held(recording['displacement_setpoint'], time)
            largest = float(np.max(np.abs(displacement - wanted)))
            paths.append(Path(stretch, rms_error(displacement, wanted), largest))
        elif abs(stretch.target - displacement[0]) > 1e-3:
            response = step_response(time, displacement, current, stretch.target)
            possible = possible_time(model, limit, response.start, stretch.target, load)
            steps.append(Step(stretch, possible, response))
    return steps, paths


def largest_gap(recording: Recording) -> float:
    """The longest time (s) for which the muscle was not measured or its controller was silent, while setpoints came.

    A machine that is too busy to run both nodes in real time shows here; what it records judges no controller.
    """
    setpoint = recording['displacement_setpoint'].time
    gaps = [0.0]
    for name in ('displacement', 'current_command'):
        time = recording[name].time
        inside = time[(time >= setpoint[0]) & (time <= setpoint[-1])]
        gaps.append(float(np.max(np.diff(inside), initial=0.0)))
    return max(gaps)


def _within(channel: Channel, stretch: Stretch) -> tuple[Array, Array]:
    """The samples of a stretch, preceded by one at its very beginning: times count from there."""
    inside = (channel.time > stretch.begin) & (channel.time < stretch.end)
    first = np.interp(stretch.begin, channel.time, channel.value)
    return np.append(stretch.begin, channel.time[inside]), np.append(first, channel.value[inside])


def _held(channel: Channel, time: Array) -> Array:
    """The channel's values at other times, each held until the next."""
    return channel.value[np.clip(np.searchsorted(channel.time, time, side='right') - 1, 0, None)]

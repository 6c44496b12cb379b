"""Recordings that begin while the muscle is warm, where no thermometer says so.

A muscle mostly rests before a recording, as cold as its room: that is expected of its start. One that was in use
shortly before is 40 K warmer. Were it held to its room, the muscle would have to make up for it, or physics that is not
there.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.model.unknown import START, Unknown
from tcp_muscle_ros.muscle.arrays import Array

_PULLED = 3.0  # standard deviations of what is expected
_WARMER = 10.0  # K than its room, at least: by less the runs of a muscle differ for other reasons
_ANYWHERE = 0.25  # of its bounds: the standard deviation of what may be anything


def begun_warm(
    fitted: Fit, fitting: Callable[[Problem, Array], Fit], further: Callable[[Problem], Array] | None = None
) -> Fit:
    """The fit in which those recordings may begin at any temperature that are drawn away from what is expected, where
    that explains more than chance gives.

    ``fitting`` fits a problem from a start; ``further`` is where it may begin too, beside where this one ended.
    """
    drawn = _drawn(fitted)
    if not any(drawn):
        return fitted
    problem, z = _with_free(fitted, drawn)
    starts = [z, further(problem)] if further else [z]
    warm = min((fitting(problem, z) for z in starts), key=lambda f: f.objective)
    still = [d and warm.values[u.key] - u.start > _WARMER for u, d in zip(fitted.problem.unknowns, drawn, strict=True)]
    if not any(still):
        return fitted
    if still != drawn:  # the others were drawn along by the muscle
        warm = fitting(*_with_free(warm, still, fitted.problem.unknowns))
    return warm if fitted.objective - warm.objective >= problem.policy.least_drop else fitted


def warm_at_the_start(fitted: Fit) -> dict[int, float]:
    """The recordings that begin warm without a thermometer to say so, and at which temperature (K)."""
    problem = fitted.problem
    return {
        u.recording: fitted.values[u.key]
        for u in problem.unknowns
        if u.name == START
        and u.recording is not None
        and u.spread == _wide(u)
        and problem.model.gauge not in problem.experiments[u.recording].observed
    }


def _drawn(fitted: Fit) -> list[bool]:
    return [
        u.name == START and u.spread < _wide(u) and z - u.to_fit(u.start) > _PULLED * u.prior_spread
        for u, z in zip(fitted.problem.unknowns, fitted.z, strict=True)
    ]


def _with_free(fitted: Fit, which: Sequence[bool], unknowns: Sequence[Unknown] = ()) -> tuple[Problem, Array]:
    """The fit's problem with which of its ``unknowns`` (default: as they are) free, and its values as a start."""
    unknowns = unknowns or fitted.problem.unknowns
    free = tuple(replace(u, spread=_wide(u)) if d else u for u, d in zip(unknowns, which, strict=True))
    z = np.array([u.to_fit(fitted.values[u.key]) for u in free])
    return replace(fitted.problem, unknowns=free), z


def _wide(unknown: Unknown) -> float:
    return _ANYWHERE * (unknown.high - unknown.low)

"""When the drive switched, between two samples of its record.

A logger shows a switch at its next sample: up to a period late, and each time by another part of it. What a misfit of
seconds follows every switch, in all channels at once, is no physics. Where it explains most of what a model leaves,
and every switch falls between its two samples, as it must, they are moved to where all channels see them.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import lsq_linear

from tcp_muscle_ros.diagnosis.candidates import Screen
from tcp_muscle_ros.diagnosis.experiment import Experiment, Imposed
from tcp_muscle_ros.diagnosis.fitting import Fit
from tcp_muscle_ros.diagnosis.problem import Shown
from tcp_muscle_ros.diagnosis.weighing import structures, with_noise
from tcp_muscle_ros.muscle.arrays import Array

_FEWEST, _MOST = 4, 200  # switches: fewer prove nothing, more take too long
_SURE = 4.0  # standard deviations of what chance gives
_MOSTLY = 0.5  # of what is left beyond the noise: less is something else's
_BESIDE = 0.25  # of a period: by so much a switch may seem to lie outside its own
_NEARLY_ALL = 0.8  # of the switches lie between their samples
_LATE = 0.15  # of a period, that they are at least on average


def settled(experiments: Sequence[Experiment], fitted: Fit) -> tuple[Experiment, ...] | None:
    """The experiments with the drive switched when all channels see it, or None where that is not what is left of them.

    ``fitted``: the fit that leaves it. The switches of a recording are found from all of it.
    """
    counts = [e.imposed.switches.shape[0] for e in experiments]
    if not _FEWEST <= sum(counts) <= _MOST:
        return None
    fitted = with_noise(fitted, {name: s.noise for name, s in structures(fitted).items()})
    shares = _shares(fitted, counts)
    if shares is None:
        return None
    parts = np.split(shares, np.cumsum(counts)[:-1])
    return tuple(_moved(e, mine) for e, mine in zip(experiments, parts, strict=True))


def _shares(fitted: Fit, counts: list[int]) -> Array | None:
    """By what share of its period each switch came before it was shown, shape (switches,); None where they are not
    what is left."""
    beyond = fitted.misfit - sum(part.size for part in fitted.residuals)
    if beyond <= 0.0:
        return None
    screen = Screen.of(fitted)  # what the unknowns could take up is theirs
    columns = np.zeros((screen.left.size, sum(counts)))
    row = column = 0
    for k, (count, residual) in enumerate(zip(counts, fitted.residuals, strict=True)):
        columns[row : row + residual.size, column : column + count] = _columns(fitted, k)
        row, column = row + residual.size, column + count
    columns -= screen.orthonormal @ (screen.orthonormal.T @ columns)
    seen = np.any(columns, axis=0)
    count = int(seen.sum())
    if count < _FEWEST:
        return None
    columns, target = columns[:, seen], -screen.left
    spread = np.sqrt(np.diag(np.linalg.pinv(columns.T @ columns, hermitian=True)))
    free = np.linalg.lstsq(columns, target, rcond=None)[0]
    within = float(np.mean(np.abs(free - 0.5) < 0.5 + _BESIDE + 2.0 * spread))
    bound = lsq_linear(columns, target, (0.0, 1.0)).x
    rest = target - columns @ bound
    mostly = float(target @ target - rest @ rest) > max(count + _SURE * np.sqrt(2.0 * count), _MOSTLY * beyond)
    late = float(np.average(bound, weights=spread**-2.0))
    if not (mostly and within >= _NEARLY_ALL and late >= _LATE):
        return None
    shares = np.zeros(seen.size)
    shares[seen] = bound
    return shares


def _columns(fitted: Fit, recording: int) -> Array:
    """How the whitened residuals of one recording change with each of its switches, from shown to a period earlier,
    shape (m, switches)."""
    problem, experiment = fitted.problem, fitted.problem.experiments[recording]
    switches = experiment.imposed.switches
    shown = fitted.predictions[recording]
    changes: list[Shown] = []
    for switch in switches:
        imposed, draught = _earlier(experiment.imposed, switch, 1.0), experiment.draught
        if draught is not None:
            warmer = np.interp(imposed.time, experiment.imposed.time, draught.warmer)
            draught = replace(draught, warmer=warmer)
        alone = replace(experiment, imposed=imposed, draught=draught)
        moved = replace(problem, experiments=(*problem.experiments[:recording], alone))
        predicted = moved.predict(fitted.values, recording)
        changes.append({name: predicted[name] - mine for name, mine in shown.items()})
    if not changes:
        return np.zeros((fitted.residuals[recording].size, 0))
    return problem.columns({name: np.column_stack([c[name] for c in changes]) for name in shown}, recording)


def _earlier(imposed: Imposed, switch: Array, share: float) -> Imposed:
    """The drive switched by a share of the period earlier than it was shown."""
    before, shown = switch
    at = shown - share * (shown - before)
    next_level = imposed.drive[np.searchsorted(imposed.time, shown - 1e-9)]
    if not np.any(np.abs(imposed.time - at) < 1e-6):
        k = int(np.searchsorted(imposed.time, at))
        imposed = replace(
            imposed,
            time=np.insert(imposed.time, k, at),
            drive=np.insert(imposed.drive, k, imposed.drive[k - 1]),
            load=np.insert(imposed.load, k, imposed.load[k - 1]),
            ambient=np.insert(imposed.ambient, k, imposed.ambient[k - 1]),
        )
    early = (imposed.time > at - 1e-6) & (imposed.time < shown - 1e-9)
    return replace(imposed, drive=np.where(early, next_level, imposed.drive))


def _moved(experiment: Experiment, shares: Array) -> Experiment:
    """The experiment with its switches moved, and a note of it."""
    imposed = experiment.imposed
    switches = imposed.switches
    if not len(switches):
        return experiment
    for switch, share in zip(switches, shares, strict=True):
        imposed = _earlier(imposed, switch, float(share))
    mean = 1e3 * float(np.mean(shares * np.diff(switches)[:, 0]))
    note = (
        f'the {imposed.kind} switched between two samples of its record, {mean:.0f} ms before it was shown on average: '
        f'when, was found from all channels ({len(switches)} switches)'
    )
    return replace(experiment, imposed=replace(imposed, switches=np.empty((0, 2))), notes=(*experiment.notes, note))

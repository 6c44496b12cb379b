"""When the drive switched, between two samples of its record.

A logger shows a switch at its next sample: up to a period late, and each time by another part of it. What a misfit of
seconds follows every switch, in all channels at once, is no physics. Where it explains most of what a model leaves,
and every switch falls between its two samples, as it must, they are moved to where all channels see them. So is one
beside which samples of the drive were lost, or that alone came just after a sample.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import lsq_linear

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.projection import Projection
from tcp_muscle_ros.diagnosis.fitting.weighing import structures, with_noise
from tcp_muscle_ros.diagnosis.hypothesis.latents import Latent, Switched
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem, Shown
from tcp_muscle_ros.diagnosis.observation.imposed import Earlier, Imposed
from tcp_muscle_ros.muscle.arrays import Array

_FEWEST, _MOST = 4, 200  # switches: fewer prove nothing, more take too long
_SURE = 4.0  # standard deviations of what chance gives
_MOSTLY = 0.5  # of what is left beyond the noise: less is something else's
_BESIDE = 0.25  # of a period: by so much a switch may seem to lie outside its own
_NEARLY_ALL = 0.8  # of the switches lie between their samples
_LATE = 0.15  # of a period, that they are at least on average
_ODD = 8.0  # times what others scatter by: whatever physics does at a switch, it does at each

_Judge = Callable[[Fit, Array, Array], Array | None]


def settled(fitted: Fit) -> tuple[Latent, ...] | None:
    """What is inferred of each recording: its drive switched when all channels see it; None where that is not what a
    fit leaves of them.

    The switches of a recording are found from all of it; first those beside which samples were lost.
    """
    followed = fitted.problem.followed
    wanted: list[tuple[str, int, list[Array], _Judge]] = [
        (name, fewest, spans, judge)
        for name, fewest, judge in (('lost', 1, _plain), ('switches', _FEWEST, _all_or_odd))
        for spans in [[getattr(e.imposed, name) for e in followed]]
        if fewest <= sum(map(len, spans)) <= _MOST
    ]
    if not wanted:
        return None
    fitted = with_noise(fitted, {name: s.noise for name, s in structures(fitted).items()})
    for name, fewest, spans, judge in wanted:
        columns, target = _late(fitted, spans)
        seen = np.any(columns, axis=0)
        if np.count_nonzero(seen) < fewest:
            continue
        found = judge(fitted, columns[:, seen], target)
        if found is not None:
            shares = np.zeros(seen.size)
            shares[seen] = found
            parts = np.split(shares, np.cumsum([len(mine) for mine in spans])[:-1])
            return tuple(Latent(switched=_moved(fitted.problem, k, name, mine)) for k, mine in enumerate(parts))
    return None


def _late(fitted: Fit, spans: Sequence[Array]) -> tuple[Array, Array]:
    """How the whitened residuals change with each switch, from shown to a period earlier, shape (m, switches); and what
    is to be explained, shape (m,). What the unknowns could take up is theirs."""
    base = Projection.of(fitted)
    columns = np.zeros((base.left.size, sum(map(len, spans))))
    row = column = 0
    for k, (mine, residual) in enumerate(zip(spans, fitted.residuals, strict=True)):
        columns[row : row + residual.size, column : column + len(mine)] = _columns(fitted, k, mine)
        row, column = row + residual.size, column + len(mine)
    return columns - base.orthonormal @ (base.orthonormal.T @ columns), -base.left


def _bound(columns: Array, target: Array) -> tuple[Array, bool, float]:
    """By what share of its period each came before it was shown; whether that is more than chance; and by how much the
    misfit falls."""
    bound, count = lsq_linear(columns, target, (0.0, 1.0)).x, columns.shape[1]
    rest = target - columns @ bound
    gain = float(target @ target - rest @ rest)
    return bound, gain > count + _SURE * float(np.sqrt(2.0 * count)), gain


def _plain(fitted: Fit, columns: Array, target: Array) -> Array | None:
    """Those beside which samples were lost need be no more than seen."""
    bound, sure, _ = _bound(columns, target)
    return bound if sure else None


def _all_or_odd(fitted: Fit, columns: Array, target: Array) -> Array | None:
    """Nearly all lie between their samples, and that is most of what is left; or a few do, unlike all others, which
    were sampled just after they came."""
    beyond = fitted.misfit - sum(part.size for part in fitted.residuals)
    spread = np.sqrt(np.diag(np.linalg.pinv(columns.T @ columns, hermitian=True)))
    free = np.linalg.lstsq(columns, target, rcond=None)[0]
    bound, sure, gain = _bound(columns, target)
    within = float(np.mean(np.abs(free - 0.5) < 0.5 + _BESIDE + 2.0 * spread))
    late = float(np.average(bound, weights=spread**-2.0))
    if sure and beyond > 0.0 and gain > _MOSTLY * beyond and within >= _NEARLY_ALL and late >= _LATE:
        return bound
    usual = float(np.median(free))
    scatter = 1.4826 * float(np.median(np.abs(free - usual)))
    odd = (free - usual > _ODD * np.maximum(scatter, spread)) & (free > _LATE) & (free < 1.0 + _BESIDE)
    if not odd.any():
        return None
    alone, sure, _ = _bound(columns[:, odd], target)
    shares = np.zeros(odd.size)
    shares[odd] = alone
    return shares if sure else None


def _columns(fitted: Fit, recording: int, switches: Array) -> Array:
    """The same of one recording's residuals, all that they show."""
    problem, before = fitted.problem, fitted.problem.followed[recording].imposed
    shown = fitted.predictions[recording]
    changes: list[Shown] = []
    for switch in switches:
        imposed = before.switched(Earlier(float(switch[0]), float(switch[1]), 1.0))
        latent = replace(problem.latents[recording], switched=Switched(imposed))
        if latent.draught is not None:
            warmer = np.interp(imposed.time, before.time, latent.draught.warmer)
            latent = replace(latent, draught=replace(latent.draught, warmer=warmer))
        predicted = problem.with_latent(latent, recording).predict(fitted.values, recording)
        changes.append({name: predicted[name] - mine for name, mine in shown.items()})
    if not changes:
        return np.zeros((fitted.residuals[recording].size, 0))
    return problem.columns({name: np.column_stack([c[name] for c in changes]) for name in shown}, recording)


def _moved(problem: Problem, recording: int, name: str, shares: Array) -> Switched:
    """What was imposed on one recording with its switches of this name moved, and a note of it."""
    imposed = problem.followed[recording].imposed
    before = problem.latents[recording].switched or Switched(imposed)
    switches: Array = getattr(imposed, name)
    if not len(switches):
        return before
    moved = shares > 0.0
    if not moved.any():
        return replace(before, imposed=_settled(imposed, name))
    moves = tuple(
        Earlier(float(last), float(first), float(share))
        for (last, first), share in zip(switches[moved], shares[moved], strict=True)
    )
    for move in moves:
        imposed = imposed.switched(move)
    mean = 1e3 * float(np.mean(shares[moved] * np.diff(switches[moved])[:, 0]))
    where = 'between two samples of its record' if name == 'switches' else 'where samples of its record were lost'
    note = (
        f'the {imposed.kind} switched {where}, {mean:.0f} ms before it was shown on average: '
        f'when, was found from all channels ({np.count_nonzero(moved)} of {len(switches)} switches)'
    )
    return Switched(_settled(imposed, name), (*before.notes, note), before.moves + moves)


def _settled(imposed: Imposed, name: str) -> Imposed:
    none = np.empty((0, 2))
    return replace(imposed, lost=none) if name == 'lost' else replace(imposed, switches=none)

"""Whether what a fit leaves is a draught, or a room that drifts, each in its own way in every recording.

The evidence of a course, beside none: what both explain under the noise of the instruments, in linear approximation,
with the course integrated out (a Gaussian process), so that its freedom is paid for. Heat that is lost moves
temperature, resistance and stroke alike, each in its own way: what one channel misses alone no course explains. So does
heat that an unsteady supply makes, but only while it drives: it competes, for neither of the two is named in its place.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.diagnosis.fitting.draught import COLD, excess_of
from tcp_muscle_ros.diagnosis.fitting.generic import Drivers, drivers, hats
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.room import knots_of, persisting, responses, thermal_lag
from tcp_muscle_ros.diagnosis.fitting.weighing import refitted
from tcp_muscle_ros.diagnosis.hypothesis.latents import Draught
from tcp_muscle_ros.diagnosis.noise.noise import quick_noise
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle.arrays import Array

_APART, _SHORTEST, _MOST = 0.3, 2.0, 120  # thermal time constants, and s, between knots at least; how many at most
_PACES = (6.0, 40.0)  # s over which a course is much the same
_DRAUGHT, _ROOM, _SUPPLY = 'draught', 'room', 'supply'
_SIZES = {_DRAUGHT: (0.1, 0.5), _ROOM: (0.3, 1.5), _SUPPLY: (0.05, 0.3)}  # usual: of the conductance; K; of the power
_LEVELS, _MOMENTS = 5, 6  # of the state, and since a switch of the drive, that a law may know
_LATELY = (15.0, 60.0)  # s: what a law may remember of the state
_RIDGE = 1e-2  # of the features' mean square
_PARTS = 4  # of each recording, that are left out in turn
_CLOSER = 2  # times that a fit follows a course before it is compared


@dataclass(frozen=True)
class Course:
    """The course of one ``effect`` that a fit speaks for; '': of the supply, which is none.

    ``evidence``: twice the gain of the log likelihood; ``witnessed``: how much more that is than of a course which
    moves one channel alone; ``share``: of the squared misfit beyond the noise that it takes; ``foretold``: the share of
    it (squared) that the state of the muscle foretells in parts of them that were left out, as it would if it were a
    law.
    """

    effect: str
    evidence: float
    witnessed: float
    share: float
    foretold: float


@dataclass(frozen=True)
class _Kind:
    """A course ``of`` a draught, the room or the supply: its usual ``size`` and its ``pace`` (s)."""

    of: str
    size: float
    pace: float


@dataclass(frozen=True)
class _Rows:
    """The whitened residuals r of one recording (``left``), the ``channel`` of each, by how much unknowns move them (J,
    in the priors' standard deviations) and a ``warmer`` room (A, 1 K at each of the ``knots``, s); and what a course of
    size 1 is there (``usual``: K, by whose it is)."""

    channel: NDArray[np.str_]
    left: Array
    moved: Array
    warmer: Array
    knots: Array
    usual: Mapping[str, Array]


@dataclass(frozen=True)
class _Part:
    """One recording: its knots, what a course of size 1 is there, and A'A, A'J and A'r."""

    knots: Array
    usual: Mapping[str, Array]
    own: Array
    beside: Array
    pull: Array


@dataclass(frozen=True)
class _Linear:
    """A fit in linear approximation: J'J and J'r, and each recording."""

    own: Array
    pull: Array
    parts: tuple[_Part, ...]


def courses(fitted: Fit) -> list[Course]:
    """Those of a draught, a room and the supply, the likeliest first; none where a single channel was recorded."""
    problem = fitted.problem
    fitted = as_read(fitted)
    if len({name for e in problem.experiments for name in e.observed}) < 2:
        return []
    rows = _rows(fitted)
    missed = _missed(rows)
    beyond = sum(missed.values())
    whole = _linear(rows)
    alone = [replace(whole, parts=_parts(rows, name)) for name in missed]
    found = []
    roles = problem.model.roles
    for of, effect in ((_DRAUGHT, roles.course), (_ROOM, roles.room), (_SUPPLY, '')):
        tried = _kinds(of)
        (evidence, took), kind = max(((_evidence(whole, kind), kind) for kind in tried), key=lambda one: one[0])
        likeliest = zip(whole.parts, _likeliest(whole, kind), strict=True)
        shares = [w / np.maximum(part.usual[of], COLD) for part, w in likeliest]
        weights = [part.usual[of] for part in whole.parts]
        share = took / max(beyond, 1e-300)
        witnessed = evidence - max(_evidence(one, like)[0] for one in alone for like in tried)
        found.append(Course(effect, evidence, witnessed, share, _foretold(fitted, whole, shares, weights)))
    return sorted(found, key=lambda course: -course.evidence)


def evidence_of(fitted: Fit, effect: str) -> float:
    """The evidence of the course of one effect alone."""
    return evidence_beside(as_read(fitted), effect)


def evidence_beside(read: Fit, effect: str) -> float:
    """The same, of a fit that is under the noise of the instruments (``as_read``)."""
    of = _DRAUGHT if effect == read.problem.model.roles.course else _ROOM
    whole = _linear(_rows(read))
    return max(_evidence(whole, kind)[0] for kind in _kinds(of))


def left_by(fitted: Fit, effect: str) -> float:
    """What the course of one effect ('': of the supply) leaves of the squared misfit, of the noise of the instruments.

    A fit is compared with the data where its course is on, in linear approximation about that: what is large is not
    followed from a fit without it, and what all courses miss then hides what one of them does.
    """
    roles, fitted = fitted.problem.model.roles, as_read(fitted)
    of = {roles.course: _DRAUGHT, roles.room: _ROOM}.get(effect, _SUPPLY)
    rows, left = _rows(fitted), np.inf
    knots = [mine.knots for mine in rows]
    for closer in range(_CLOSER + 1):
        whole = _linear(rows)
        (_, took), kind = max(((_evidence(whole, kind), kind) for kind in _kinds(of)), key=lambda one: one[0])
        missed = sum(float(mine.left @ mine.left) for mine in rows)
        took += float(_marginal(whole.own + np.eye(whole.pull.size), whole.pull)[0])
        left = min(left, (missed - took) / sum(mine.left.size for mine in rows))
        if closer < _CLOSER:
            blown = _likeliest(whole, kind)
            fitted = _blown(fitted, knots, blown)
            rows = [replace(r, left=r.left - r.warmer @ w) for r, w in zip(_rows(fitted, knots), blown, strict=True)]
    return left


def _blown(fitted: Fit, knots: Sequence[Array], courses: Sequence[Array]) -> Fit:
    """The fit with a course (K, at its knots in s) in each recording."""
    problem, latents = fitted.problem, []
    for k, (at, warmer) in enumerate(zip(knots, courses, strict=True)):
        course = Draught(at, np.interp(problem.followed[k].imposed.time, at, warmer))
        latents.append(replace(problem.latents[k], draught=course))
    return refitted(fitted, problem.with_latents(latents))


def _kinds(of: str) -> list[_Kind]:
    """The courses that are tried."""
    return [_Kind(of, size, pace) for size in _SIZES[of] for pace in _PACES]


def as_read(fitted: Fit) -> Fit:
    """The fit under the noise of the instruments alone: a room is none that wanders besides."""
    problem = fitted.problem.with_latents(replace(latent, together={}) for latent in fitted.problem.latents)
    return refitted(fitted, problem.with_noise(quick_noise(problem.experiments)))


def _rows(fitted: Fit, given: Sequence[Array] | None = None) -> list[_Rows]:
    """Those of all recordings, whitened; at ``given`` knots (s), where they are."""
    problem, spreads = fitted.problem, fitted.problem.spreads()
    apart, found = max(_APART * thermal_lag(fitted), _SHORTEST), []
    for k, (experiment, slopes, left) in enumerate(zip(problem.followed, fitted.slopes, fitted.residuals, strict=True)):
        knots = knots_of(experiment, apart, _MOST) if given is None else given[k]
        excess = np.maximum(np.interp(knots, experiment.imposed.time, excess_of(fitted, k)), COLD)
        usual = {_DRAUGHT: excess, _ROOM: np.ones(knots.size), _SUPPLY: excess.max() * _power(experiment, knots)}
        sizes = [observed.time.size for observed in experiment.observed.values()]
        read = slice(sum(sizes))  # what stands after them is no reading
        warmer = problem.columns(responses(fitted, k, knots), k)[read]
        moved = (problem.columns(slopes, k) * spreads)[read]
        found.append(_Rows(np.repeat([*experiment.observed], sizes), left[read], moved, warmer, knots, usual))
    return found


def _missed(rows: Sequence[_Rows]) -> dict[str, float]:
    """The squared whitened misfit beyond the noise of each channel."""
    missed: dict[str, float] = {}
    for mine in rows:
        for name in dict.fromkeys(mine.channel):
            part = mine.left[mine.channel == name]
            missed[name] = missed.get(name, 0.0) + float(part @ part) - part.size
    return missed


def _linear(rows: Sequence[_Rows]) -> _Linear:
    """The linear approximation."""
    count = rows[0].moved.shape[1]
    own, pull = np.zeros((count, count)), np.zeros(count)
    for mine in rows:
        own += mine.moved.T @ mine.moved
        pull += mine.moved.T @ mine.left
    return _Linear(own, pull, _parts(rows))


def _parts(rows: Sequence[_Rows], channel: str = '') -> tuple[_Part, ...]:
    """Each recording, where a warmer room moves all channels, or one alone."""
    parts = []
    for mine in rows:
        warmer = mine.warmer * (mine.channel == channel)[:, None] if channel else mine.warmer
        parts.append(_Part(mine.knots, mine.usual, warmer.T @ warmer, warmer.T @ mine.moved, warmer.T @ mine.left))
    return tuple(parts)


def _power(experiment: Experiment, knots: Array) -> Array:
    """The power of the drive at each knot, of its largest."""
    drive = np.abs(experiment.imposed.drive) ** (1 if experiment.imposed.kind == 'power' else 2)
    power: Array = np.interp(knots, experiment.imposed.time, drive) / max(float(drive.max()), 1e-300)
    return power


def _ways(linear: _Linear, kind: _Kind) -> list[Array]:
    """The factor L of the covariance L L' of a course, in K at each knot, by recording."""
    return [kind.size * part.usual[kind.of][:, None] * persisting(part.knots, kind.pace) for part in linear.parts]


def _evidence(linear: _Linear, kind: _Kind) -> tuple[float, float]:
    """Twice the log likelihood with the course and the unknowns integrated out, less that with the unknowns alone; and
    what of the squared misfit the course takes beyond what these do."""
    own, pull = linear.own + np.eye(linear.pull.size), linear.pull
    took, freedom = np.zeros(2) - _marginal(own, pull)
    for part, way in zip(linear.parts, _ways(linear, kind), strict=True):
        factor = np.linalg.cholesky(way.T @ part.own @ way + np.eye(part.knots.size))
        beside, mine = np.linalg.solve(factor, way.T @ part.beside), np.linalg.solve(factor, way.T @ part.pull)
        own, pull = own - beside.T @ beside, pull - beside.T @ mine
        took += float(mine @ mine)
        freedom += 2.0 * float(np.log(np.diag(factor)).sum())
    whole = np.array([took, freedom]) + _marginal(own, pull)
    return float(whole[0] - whole[1]), float(whole[0])


def _marginal(own: Array, pull: Array) -> Array:
    """What unknowns take of the squared misfit, and the price of their freedom, shape (2,)."""
    factor = np.linalg.cholesky(own)
    whole = np.linalg.solve(factor, pull)
    return np.array([whole @ whole, 2.0 * np.log(np.diag(factor)).sum()])


def _likeliest(linear: _Linear, kind: _Kind) -> list[Array]:
    """The course (K) of each recording."""
    own, pull = linear.own + np.eye(linear.pull.size), linear.pull
    known, ways = [], _ways(linear, kind)
    for part, way in zip(linear.parts, ways, strict=True):
        precision = way.T @ part.own @ way + np.eye(part.knots.size)
        beside, mine = (np.linalg.solve(precision, way.T @ x) for x in (part.beside, part.pull))
        own = own - part.beside.T @ way @ beside
        pull = pull - part.beside.T @ way @ mine
        known.append((mine, beside))
    unknowns = np.linalg.solve(own, pull)
    return [-way @ (mine - beside @ unknowns) for way, (mine, beside) in zip(ways, known, strict=True)]


def _foretold(fitted: Fit, linear: _Linear, shares: Sequence[Array], weights: Sequence[Array]) -> float:
    """The share of a course, about its mean, that the muscle's state foretells where it was left out; each value of it
    counts by its weight, as a draught about a cold muscle shows nothing."""
    problem = fitted.problem
    states = [
        drivers(experiment, outputs, part.knots)
        for experiment, outputs, part in zip(problem.followed, fitted.outputs, linear.parts, strict=True)
    ]
    if not np.any(np.concatenate(weights) > 0.0):
        return 0.0
    mean = np.average(np.concatenate(shares), weights=np.concatenate(weights))
    roots = [np.sqrt(weight) for weight in weights]
    features = [f * root[:, None] for f, root in zip(_features(states), roots, strict=True)]
    values = [(share - mean) * root for share, root in zip(shares, roots, strict=True)]
    # Parts of recordings: a whole one may go where the others never were.
    features = [piece for f in features for piece in np.array_split(f, _PARTS)]
    values = [piece for v in values for piece in np.array_split(v, _PARTS)]
    missed = 0.0
    for k, (mine, value) in enumerate(zip(features, values, strict=True)):
        others = np.vstack([f for j, f in enumerate(features) if j != k])
        known = np.concatenate([v for j, v in enumerate(values) if j != k])
        normal = others.T @ others
        ridge = (_RIDGE * np.trace(normal) / normal.shape[0] + 1e-12) * np.eye(normal.shape[0])
        missed += float(np.sum((value - mine @ np.linalg.solve(normal + ridge, others.T @ known)) ** 2))
    return 1.0 - missed / max(float(sum(v @ v for v in values)), 1e-300)


def _features(states: Sequence[Drivers]) -> list[Array]:
    """What of the muscle's state a law may know: its level, warming or cooling, and what it was lately; the time since
    a switch; the drive."""
    level = np.unique(np.quantile(np.concatenate([s.level for s in states]), np.linspace(0.0, 1.0, _LEVELS)))
    longest = max(float(max(s.since_switch.max() for s in states)), 1.0)
    moments = np.concatenate([[0.0], np.geomspace(1.0, longest + 1.0, _MOMENTS)])
    found = []
    for s in states:
        warming, on = (s.rate > 0.0)[:, None], s.heating[:, None] > 0.0
        levels, since = hats(s.level, level), hats(s.since_switch, moments)
        lately = np.column_stack([_lately(s, pace) for pace in _LATELY])
        parts = (levels * warming, levels * ~warming, since * on, since * ~on, lately, s.drive[:, None])
        found.append(np.hstack(parts))
    return found


def _lately(state: Drivers, pace: float) -> Array:
    """The mean of the level that forgets at a pace (s), over that at the start, in tens of its unit."""
    level, time = state.level - state.level[0], state.elapsed
    mean = np.zeros(level.size)
    for k, share in enumerate(np.exp(-np.diff(time) / pace)):
        mean[k + 1] = share * mean[k] + (1.0 - share) * level[k + 1]
    return 0.1 * mean

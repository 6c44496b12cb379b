"""The experiment that would decide: of what a rig can do, the protocol under which fitted models differ most.

The models were fitted to the recordings at hand and agree there. Under each protocol the difference of two is whitened,
and what the unknowns of either could still take up, given how far the recordings have fixed them, is taken out. What
remains says how probable it is that the new recording tells them apart.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, permutations

import numpy as np
from scipy.stats import norm

from tcp_muscle_ros.diagnosis.answer.findings import Proposal
from tcp_muscle_ros.diagnosis.answer.handed_on import gone_through, largest_drive, rounded_up
from tcp_muscle_ros.diagnosis.answer.protocols import Plan, Reach, plans, reach, varied
from tcp_muscle_ros.diagnosis.fitting.anchored import measured
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, slopes
from tcp_muscle_ros.diagnosis.hypothesis.latents import Latent
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem, Shown
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT, START
from tcp_muscle_ros.diagnosis.noise.noise import Noise
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import Holding, Imposed
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.diagnosis.search.rivals import Rival, margin
from tcp_muscle_ros.muscle import SPECIFICATIONS, Parameters
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.settings.rig import RigLimits

_RATE = 20.0  # Hz
_SAMPLES = 1000  # by which a difference is judged, a channel: as many as a diagnosis takes
_KEPT = np.log(2.0)  # a promise is made with the listed forms: the muscle's own keeps it within a factor of about two
# Of what the models promise so much is kept: 12 of 19 experiments told apart what they should where 17.9 were expected
# (suite `outside`, 58 cases, 2026-11-29), as often where they promised most as where they promised less.
_HELD = 0.67
LEAST_CHANCE = 0.5  # of deciding, from which an experiment is proposed
_ODDS = 3.0  # of a rival that is all but beaten: e^-3, as of one that is
_SETTLED = 0.02  # of the distance: less is no progress
_SHARES = (1.0, 0.3, 0.1, 0.03)  # of a step
_CLOSER, _ROUNDS = 4, 4  # plans that are looked at more closely, and how often models adapt there
_MEMBERS = 4  # of a set, that are to be told apart
_ENOUGH = 0.95  # of what all pairs are worth, from which a protocol is taken as it is
_VARIED = 32  # protocols that are looked at beyond the book
_ROUNDING = 1e-6
_WORTH_IT = 1.02  # times the worth of the book's best, for which another is taken


def experiment_of(plan: Plan, like: Experiment, ambient: float, kind: str = 'current') -> Experiment:
    """The plan, of a ``kind`` of drive, as an experiment that observes what was observed before, at 20 Hz; an end that
    was held is held."""
    steps = plan.steps * plan.repeat
    edges = np.concatenate([[0.0], np.cumsum([s.duration for s in steps])])
    time = np.arange(0.0, edges[-1], 1.0 / _RATE)
    at = np.minimum(np.searchsorted(edges, time + 1e-9, side='right') - 1, len(steps) - 1)
    drive = np.array([s.current for s in steps])[at]
    load = np.array([s.load for s in steps])[at]
    holding = Holding('load', float(load[0])) if like.holding.hangs else like.holding
    observed = {}
    for name in like.observed:
        if name == 'force' and like.holding.hangs:
            continue  # at a loaded end the force is the load
        kept = np.abs(drive) > 0.01 if name == 'resistance' else np.ones(time.size, dtype=bool)
        kept &= np.arange(time.size) % max(1, round(time.size / _SAMPLES)) == 0
        if np.any(kept):
            observed[name] = Observed(time[kept], np.zeros(int(kept.sum())), np.ones(int(kept.sum())))
    imposed = Imposed(kind, time, drive, load, np.full(time.size, ambient))
    return Experiment(plan.name, imposed, holding, observed)


@dataclass(frozen=True, eq=False)
class Question:
    """Rivals that explain the recordings alike, to be told apart, the named one first.

    ``bare`` is the first without its effect, ``drop`` what that explains of the recordings at hand.
    """

    members: Sequence[Rival]
    bare: Fit
    drop: float

    @property
    def names(self) -> list[str]:
        """Their effects."""
        return [rival.effect for rival in self.members]

    @cached_property
    def odds(self) -> dict[str, float]:
        """Of each."""
        best, policy = min(rival.score for rival in self.members), self.members[0].policy
        margins = {rival.effect: (rival.score - best) / margin(self.drop, policy) for rival in self.members}
        return {name: float(np.exp(-_ODDS * behind)) for name, behind in margins.items()}

    @property
    def whole(self) -> float:
        """Worth of a protocol that surely tells all pairs apart."""
        return self.worth(dict.fromkeys(combinations(self.names, 2), 1.0))

    def worth(self, told: Mapping[tuple[str, str], float]) -> float:
        """Sum over the pairs, each as probable as its two rivals are."""
        return sum(self.odds[one] * self.odds[two] * probable for (one, two), probable in told.items())


@dataclass(frozen=True, eq=False)
class Planned:
    """A protocol and its experiment, with the models of a question under it."""

    plan: Plan
    experiment: Experiment
    question: Question

    @cached_property
    def models(self) -> 'tuple[Under, list[Under]]':
        """The one without the effect, and the rivals: both looks need them."""
        members = [Under(rival.fit, self.experiment) for rival in self.question.members]
        return Under(self.question.bare, self.experiment), members

    @cached_property
    def worth(self) -> float:
        """What it tells apart as the first, linear look has it."""
        return self.question.worth(self.told(1))

    def told(self, rounds: int = _ROUNDS) -> dict[tuple[str, str], float]:
        """How probable it is that each pair is told apart: whichever of all the rivals is the muscle's, one of the two
        at least must then be far from it."""
        (without, those), question = self.models, self.question
        needed = margin(question.drop + separation(those[0], without, rounds), question.members[0].policy)
        members = dict(zip(question.names, those, strict=True))
        apart = {(one, two): separation(members[one], members[two], rounds) for one, two in permutations(members, 2)}
        weights = [question.odds[true] for true in members]
        told = {}
        for one, two in combinations(members, 2):
            each = [kept(max(apart[true, far] for far in {one, two} - {true}), needed) for true in members]
            told[one, two] = float(np.average(each, weights=weights))
        return told


def propose(alike: Sequence[Rival], bare: Fit, drop: float, limits: RigLimits | None = None) -> Proposal | None:
    """The protocol that best tells rivals apart that explain the recordings alike, the named one first; None where none
    promises anything.

    ``bare`` is the first without its effect, ``drop`` what that explains of the recordings at hand, ``limits`` what the
    rig can do, where that is known. No listed form is quite the muscle's own: two must differ by more than the share of
    what the effect does, in old recordings and new, within which they pass for alike. Best is what tells most pairs
    apart, each as probable as its two rivals are: of a book of protocols, and where none of that surely decides, of
    variations of its best.
    """
    question = Question(alike[:_MEMBERS], bare, drop)
    first = question.members[0].fit
    like = _like(first.problem.experiments)
    ambient = float(first.values.get((AMBIENT, 0), like.imposed.ambient[0]))
    if limits is not None and not limits.held_end:
        like = replace(like, holding=Holding('load', like.holding.starting_load))
    rig = reach(first.muscle, like.holding.starting_load, ambient, limits, *_most(first, like, limits))
    if not like.holding.hangs:
        rig = replace(rig, loads=(rig.base,))  # none hangs there

    def planned(plan: Plan) -> Planned:
        return Planned(plan, experiment_of(plan, like, ambient, rig.kind), question)

    book = [one for one in map(planned, plans(rig)) if one.experiment.observed]
    if not measured(first):
        rig = replace(rig, largest=limits.largest_current if limits else rig.largest)
        book = [one for one in book if _bearable(one, rig, first)]
    promising = sorted(book, key=lambda one: -one.worth)[:_CLOSER]
    if not promising:
        return None
    found = [(one.plan, one.told()) for one in promising]
    plan, told = max(found, key=lambda one: question.worth(one[1]))
    if question.worth(told) < _ENOUGH * question.whole:
        other = _optimised(promising[0], planned, rig, first)
        better = other.told() if other is not promising[0] else told
        if question.worth(better) > _WORTH_IT * question.worth(told):
            plan, told = replace(other.plan, reason=f'{other.plan.reason} (adapted to this question)'), better
    # Rather the one that is named from another than two others from each other.
    names = question.names
    promised = {pair: _HELD * probable for pair, probable in told.items()}
    pair, power = max(promised.items(), key=lambda one: (one[1] >= LEAST_CHANCE, names[0] in one[0], one[1]))
    return Proposal(
        pair, plan.name, plan.reason, plan.steps, plan.repeat, _RATE, like.holding.end, power, ambient, rig.kind
    )


def _most(first: Fit, like: Experiment, limits: RigLimits | None) -> tuple[float, str, float]:
    """The most of which kind of drive (A, W or V) may be asked for, and how hot it may become (K).

    Where nothing showed how hot the muscle was, a fit may have it cold under any drive: then no more of the drive that
    it was recorded with than it has borne, nor hotter, as the fit has it, than it has been.
    """
    experiments = first.problem.experiments
    if not measured(first):
        kind = like.imposed.kind
        hottest = max(float(outputs.fibre_temperature.max()) for outputs in first.outputs)
        return largest_drive(experiments, kind), kind, hottest
    # Of a rig of which nothing is said: what a driver allows that nobody has set, or what it was seen to give.
    unsaid = limits is None and all(e.imposed.kind == 'current' for e in experiments)
    most = max(RigLimits().largest_current, largest_drive(experiments, 'current')) if unsaid else float('inf')
    return most, 'current', float('inf')


def _like(experiments: Sequence[Experiment]) -> Experiment:
    """The recording that a further one is like: the first that shows the motion."""
    return next((e for e in experiments if e.model.motion in e.observed), experiments[0])


def allowing(seen: RigLimits, planned: Proposal, experiments: Sequence[Experiment], muscle: Parameters) -> RigLimits:
    """The limits that were seen of a rig of which nothing is said, and what the experiment needs beside: a rig that is
    run by them plays it."""
    like = _like(experiments)
    ambient = like.imposed.ambient[0] if planned.ambient is None else planned.ambient
    plan = Plan(planned.name, planned.reason, planned.steps, planned.repeat)
    outputs = experiment_of(plan, like, float(ambient), planned.kind).outputs(muscle, only=('current',))
    return replace(
        seen,
        largest_current=max(seen.largest_current, rounded_up(float(outputs.current.max()))),
        loads=tuple(sorted({*seen.loads, *(step.load for step in planned.steps)})) if seen.loads else (),
        held_end=seen.held_end or planned.end != 'load',
        longest_run=max(seen.longest_run, planned.duration),
    )


def _bearable(one: Planned, rig: Reach, first: Fit) -> bool:
    """Whether it makes a muscle no hotter than that may be, with no more current than the rig has."""
    outputs = one.experiment.outputs(first.muscle)
    hottest, current = float(outputs.fibre_temperature.max()), float(outputs.current.max())
    return hottest <= rig.hottest + _ROUNDING and current <= rig.largest * (1.0 + _ROUNDING)


def _optimised(best: Planned, planned: Callable[[Plan], Planned], rig: Reach, first: Fit) -> Planned:
    """The best of variations of a protocol, one after the other; none hotter than the muscle may be."""
    rng = np.random.default_rng(11)
    for _ in range(_VARIED):
        plan = varied(best.plan, rng, rig)
        if plan is None:
            continue
        one = planned(plan)
        if one.experiment.observed and _bearable(one, rig, first) and one.worth > best.worth:
            best = one
    return best


def kept(distance: float, needed: float) -> float:
    """How probable it is that two models of which this distance is promised come to differ by what is needed."""
    return float(norm.cdf(np.log(max(distance, 1e-12) / needed) / _KEPT))


@dataclass(frozen=True, eq=False)
class Under:
    """A fit under one planned experiment alone."""

    fitted: Fit
    experiment: Experiment

    @cached_property
    def shared(self) -> list[int]:
        """Which of its unknowns all recordings share; they come first."""
        unknowns = enumerate(self.fitted.problem.unknowns)
        return [k for k, u in unknowns if u.recording is None and u.name not in (AMBIENT, START)]

    @cached_property
    def problem(self) -> Problem:
        """The problem of the experiment, under the recorded noise."""
        problem = self.fitted.problem
        unknowns = tuple(problem.unknowns[k] for k in (*self.shared, *self._own))
        latents = (Latent(before=gone_through(self.fitted)),)  # it comes after the recordings at hand
        return replace(problem, experiments=(self.experiment,), latents=latents, unknowns=unknowns, noise=self.noise)

    @cached_property
    def noise(self) -> dict[str, Noise]:
        """That of the recordings, at the planned spacing."""
        return _noise_at(self.fitted.problem.noise, self.fitted.problem.experiments, self.experiment)

    @cached_property
    def z(self) -> Array:
        """Where the fit stands. What a recording has by itself begins as it usually is: from where it hardly acts it
        would not find back; a parameter of the muscle as it is assumed."""
        own = [self.fitted.problem.unknowns[k] for k in self._own]
        usual = [u.to_fit(SPECIFICATIONS[u.name].value if '.' in u.name else u.start) for u in own]
        return np.concatenate([self.fitted.z[self.shared], usual])

    @cached_property
    def shown(self) -> list[Shown]:
        """What it shows there."""
        return self.problem.predictions(self.z)

    @cached_property
    def slopes(self) -> list[Shown]:
        """d shown / d z."""
        return slopes(self.problem, self.z, self.shown)

    @cached_property
    def information(self) -> Array:
        """How far the recordings have fixed its unknowns, shape (n, n)."""
        information = np.diag([1.0 / u.prior_spread**2 for u in self.problem.unknowns])
        n, covariance = len(self.shared), self.fitted.covariance[np.ix_(self.shared, self.shared)]
        information[:n, :n] = np.linalg.pinv(covariance, hermitian=True)
        return information

    @property
    def _own(self) -> list[int]:
        unknowns = enumerate(self.fitted.problem.unknowns)
        return [k for k, u in unknowns if u.recording == 0 and u.name not in (AMBIENT, START)]


def separation(a: Under, b: Under, rounds: int = _ROUNDS) -> float:
    """Squared whitened distance of two models' predictions, after ``b`` has adapted as far as its data allow; 0 under a
    plan where either runs away.

    What an effect had for each recording by itself, it has anew in this one.
    """
    with np.errstate(over='ignore', invalid='ignore'):
        found = _separation(a, b, rounds)
    return found if np.isfinite(found) else 0.0


def _separation(a: Under, b: Under, rounds: int) -> float:
    problem, information = b.problem, b.information
    told = a.problem.with_noise(b.noise).residuals(a.shown)[0]

    def missed(z: Array, shown: list[Shown]) -> tuple[float, list[Shown], Array]:
        difference = problem.residuals(shown)[0] - told
        return float(difference @ difference + (z - b.z) @ information @ (z - b.z)), shown, difference

    def after(z: Array) -> tuple[Array, float, list[Shown], Array]:
        return z, *missed(z, problem.predictions(z))

    z, (least, shown, difference) = b.z, missed(b.z, b.shown)
    for _ in range(rounds):
        columns = problem.jacobian(b.slopes if z is b.z else slopes(problem, z, shown))
        step = np.linalg.solve(columns.T @ columns + information, columns.T @ difference + information @ (z - b.z))
        if not np.all(np.isfinite(step)):
            return float('nan')
        if rounds == 1:  # a first look: as the linear approximation has it
            left = difference - columns @ step
            return float(left @ left + step @ information @ step)
        best = min((after(z - share * step) for share in _SHARES), key=lambda one: one[1])
        if best[1] >= (1.0 - _SETTLED) * least:
            break
        z, least, shown, difference = best
    return least


def _noise_at(noise: Mapping[str, Noise], recorded: tuple[Experiment, ...], planned: Experiment) -> dict[str, Noise]:
    """The recorded noise at the planned spacing: colour fades with time between observations."""
    found = {}
    for name, observed in planned.observed.items():
        before = next(e.observed[name] for e in recorded if name in e.observed)
        ratio = float(np.median(np.diff(observed.time)) / max(float(np.median(np.diff(before.time))), 1e-9))
        found[name] = Noise(noise[name].sigma, noise[name].phi ** ratio if noise[name].phi > 0.0 else 0.0)
    return found

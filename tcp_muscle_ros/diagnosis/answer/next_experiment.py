"""The experiment that would decide: of feasible protocols the one under which fitted models differ most.

The models were fitted to the recordings at hand and agree there. Under each protocol the difference of two is whitened,
and what the unknowns of either could still take up, given how far the recordings have fixed them, is taken out. What
remains says how probable it is that the new recording tells them apart.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np
from scipy.stats import norm

from tcp_muscle_ros.diagnosis.answer.findings import Proposal, Step
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, slopes
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem, Shown
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT, START
from tcp_muscle_ros.diagnosis.noise.noise import Noise
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import Holding, Imposed
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.diagnosis.search.rivals import Rival, margin
from tcp_muscle_ros.muscle import SPECIFICATIONS, Parameters, steady_current
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.settings.rig import RigLimits

_RATE = 20.0  # Hz
_SAMPLES = 1000  # by which a difference is judged, a channel: as many as a diagnosis takes
_KEPT = np.log(2.0)  # a promise is made with the listed forms: the muscle's own keeps it within a factor of about two
_ODDS = 3.0  # of a rival that is all but beaten: e^-3, as of one that is
_SETTLED = 0.02  # of the distance: less is no progress
_SHARES = (1.0, 0.3, 0.1, 0.03)  # of a step
_CLOSER, _ROUNDS = 4, 4  # plans that are looked at more closely, and how often models adapt there
_MEMBERS = 4  # of a set, that are to be told apart
_BEFORE_IT_IS_OVER = 'a delay against a lag: the next edge comes before either is over'
_HOTTEST = 273.15 + 90.0
_HALF_THE_TIME = 1.25  # times the current for that


@dataclass(frozen=True)
class Plan:
    """A protocol on paper: what it asks, its steps, how often they repeat."""

    name: str
    reason: str
    steps: tuple[Step, ...]
    repeat: int = 1


def allowed(muscle: Parameters, load: float, ambient: float, limits: RigLimits) -> list[Plan]:
    """The protocols that a rig can do: with its currents, temperatures and loads, and no longer than it may run."""
    hung = limits.loads or (load,)
    base = min(hung, key=lambda one: abs(one - load))
    hottest = min(_HOTTEST, limits.highest_temperature)
    full = min(steady_current(muscle, hottest, ambient), limits.largest_current)

    def within(plan: Plan) -> Plan:
        most = limits.largest_current
        return replace(plan, steps=tuple(replace(step, current=min(step.current, most)) for step in plan.steps))

    return [
        within(plan)
        for plan in _plans(full, min(hung), base, max(hung))
        if plan.repeat * sum(step.duration for step in plan.steps) <= limits.longest_run
        and (len(hung) > 1 or len({step.load for step in plan.steps}) == 1)
    ]


def plans(muscle: Parameters, load: float, ambient: float) -> list[Plan]:
    """Feasible protocols: no hotter than 90 degC at steady state, no more than twice the load at hand."""
    base = max(load, 0.2)
    return _plans(steady_current(muscle, _HOTTEST, ambient), 0.5 * base, base, 2.0 * base)


def _plans(full: float, low: float, base: float, high: float) -> list[Plan]:
    """The protocols with so much current (A) at steady state, at these loads (N)."""

    def on(duration: float, share: float, force: float = base) -> Step:
        return Step(duration, round(full * share, 4), round(force, 4))

    def rest(duration: float, force: float = base) -> Step:
        return Step(duration, 0.0, round(force, 4))

    stairs = tuple(on(20.0, s) for s in (0.4, 0.6, 0.8, 1.0, 0.8, 0.6, 0.8, 0.6, 0.4))
    probe = round(0.05 * full, 4)
    rng = np.random.default_rng(7)

    def switching(pace: float, count: int, most: float = 1.0) -> tuple[Step, ...]:
        spans = pace * rng.choice([1.0, 2.0, 3.5, 6.0], count)
        return tuple(on(round(float(d), 3), most if k % 2 == 0 else 0.15) for k, d in enumerate(spans))

    swings = tuple(s for m in (0.4, 0.6, 0.75, 0.9) for s in (on(25.0, m), *4 * (on(3.0, 1.25 * m), on(3.0, 0.7 * m))))
    return [
        Plan(
            'long hold',
            'the steady state, without the influence of time constants',
            (rest(10.0), on(150.0, 0.95), rest(150.0)),
        ),
        Plan(
            'staircase', 'small loops: does the rate matter, or what came before?', (rest(10.0), *stairs, rest(60.0)), 2
        ),
        Plan(
            'load steps',
            'the load changes at constant current, cold and hot',
            (
                *(s for f in (base, high, low, base) for s in (rest(25.0, f),)),
                *(s for f in (base, high, low, base) for s in (on(40.0, 0.9, f),)),
                rest(60.0),
            ),
        ),
        Plan('fast switching', 'delays compared with inertia', (rest(5.0), *switching(2.0, 40), rest(30.0))),
        Plan('rapid switching', _BEFORE_IT_IS_OVER, switching(0.5, 32)),
        # On for half of the time only: with that current it stays below what it is to reach at steady state.
        Plan('very rapid switching', _BEFORE_IT_IS_OVER, switching(0.2, 160, _HALF_THE_TIME)),
        Plan('most rapid switching', _BEFORE_IT_IS_OVER, switching(0.1, 200, _HALF_THE_TIME)),
        Plan('small swings', 'the heat capacity at each temperature by itself', swings),
        Plan(
            'slow ramp of steps',
            'the same temperatures at another rate',
            tuple(on(30.0, s) for s in (0.3, 0.5, 0.7, 0.9, 1.0)),
        ),
        Plan('many cycles', 'what changes from cycle to cycle', (on(25.0, 1.0), rest(45.0)), 8),
        Plan(
            'cooling with a probe current',
            'the resistance serves as a second thermometer while the muscle cools',
            (rest(5.0), on(60.0, 1.0), Step(120.0, probe, round(base, 4))),
        ),
        Plan('at rest', 'only what instruments and surroundings do', (rest(300.0),)),
        *_at_several_loads(on, rest, low, base, high),
    ]


def _at_several_loads(
    on: Callable[[float, float, float], Step],
    rest: Callable[[float, float], Step],
    low: float,
    base: float,
    high: float,
) -> list[Plan]:
    """Heating at loads below, at and above the one at hand (N); ``on``: s, share of the current, N; ``rest``: s, N."""
    return [
        Plan(
            'three loads',
            'the same heating at three loads',
            tuple(s for f in (low, base, high) for s in (on(30.0, 1.0, f), rest(60.0, f))),
        ),
        Plan(
            'holds at three loads',
            'lasting changes: how do they grow with the load?',
            tuple(s for f in (low, base, high) for s in (on(90.0, 1.0, f), rest(40.0, f))),
        ),
        Plan(
            'holds at alternating loads',
            'lasting changes: do load and heat cause them, or do they come by themselves?',
            tuple(s for f in (low, high, low, high) for s in (on(60.0, 1.0, f), rest(40.0, f))),
        ),
    ]


def experiment_of(plan: Plan, like: Experiment, ambient: float) -> Experiment:
    """The plan as an experiment that observes what was observed before, at 20 Hz."""
    steps = plan.steps * plan.repeat
    edges = np.concatenate([[0.0], np.cumsum([s.duration for s in steps])])
    time = np.arange(0.0, edges[-1], 1.0 / _RATE)
    at = np.minimum(np.searchsorted(edges, time + 1e-9, side='right') - 1, len(steps) - 1)
    drive = np.array([s.current for s in steps])[at]
    load = np.array([s.load for s in steps])[at]
    observed = {}
    for name in like.observed:
        if name == 'force':
            continue  # at a loaded end the force is the load
        kept = np.abs(drive) > 0.01 if name == 'resistance' else np.ones(time.size, dtype=bool)
        kept &= np.arange(time.size) % max(1, round(time.size / _SAMPLES)) == 0
        if np.any(kept):
            observed[name] = Observed(time[kept], np.zeros(int(kept.sum())), np.ones(int(kept.sum())))
    imposed = Imposed('current', time, drive, load, np.full(time.size, ambient))
    return Experiment(plan.name, imposed, Holding('load', float(load[0])), observed)


def propose(alike: Sequence[Rival], bare: Fit, drop: float, limits: RigLimits | None = None) -> Proposal | None:
    """The protocol that best tells rivals apart that explain the recordings alike, the named one first; None where none
    promises anything.

    ``bare`` is the first without its effect, ``drop`` what that explains of the recordings at hand, ``limits`` what the
    rig can do, where that is known. No listed form is quite the muscle's own: two must differ by more than the share of
    what the effect does, in old recordings and new, within which they pass for alike. Best is what tells most pairs
    apart, each as probable as its two rivals are.
    """
    members = alike[:_MEMBERS]
    names = [rival.effect for rival in members]
    first = members[0].fit
    like = next((e for e in first.problem.experiments if e.model.motion in e.observed), first.problem.experiments[0])
    ambient = float(first.values.get((AMBIENT, 0), like.imposed.ambient[0]))
    load = like.holding.starting_load
    feasible = plans(first.muscle, load, ambient) if limits is None else allowed(first.muscle, load, ambient, limits)
    planned = [
        (plan, Under(bare, experiment), [Under(rival.fit, experiment) for rival in members])
        for plan in feasible
        if (experiment := experiment_of(plan, like, ambient)).observed
    ]
    best, policy = min(rival.score for rival in members), members[0].policy
    odds = {rival.effect: float(np.exp(-_ODDS * (rival.score - best) / margin(drop, policy))) for rival in members}

    def look(without: Under, those: Sequence[Under], rounds: int) -> dict[tuple[str, str], float]:
        """How probable it is that each pair is told apart, whichever of the two is the muscle's."""
        needed = margin(drop + separation(those[0], without, rounds), policy)
        told = {}
        for (one, a), (two, b) in combinations(zip(names, those, strict=True), 2):
            each = [kept(separation(a, b, rounds), needed), kept(separation(b, a, rounds), needed)]
            told[one, two] = float(np.average(each, weights=[odds[one], odds[two]]))
        return told

    def worth(told: Mapping[tuple[str, str], float]) -> float:
        return sum(odds[one] * odds[two] * probable for (one, two), probable in told.items())

    promising = sorted(planned, key=lambda one: -worth(look(one[1], one[2], 1)))[:_CLOSER]
    found = [(plan, look(without, those, _ROUNDS)) for plan, without, those in promising]
    if not found:
        return None
    plan, told = max(found, key=lambda one: worth(one[1]))
    # Rather the one that is named from another than two others from each other.
    pair, power = max(told.items(), key=lambda one: (one[1] >= 0.5, names[0] in one[0], one[1]))
    return Proposal(pair, plan.name, plan.reason, plan.steps, plan.repeat, _RATE, 'load', power)


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
        return replace(problem, experiments=(self.experiment,), latents=(), unknowns=unknowns, noise=self.noise)

    @cached_property
    def noise(self) -> dict[str, Noise]:
        """That of the recordings, at the planned spacing."""
        return _noise_at(self.fitted.problem.noise, self.fitted.problem.experiments, self.experiment)

    @cached_property
    def z(self) -> Array:
        """Where the fit stands. What a recording has by itself begins as it usually is: from where it hardly acts it
        would not find back."""
        unknowns = self.fitted.problem.unknowns
        usual = [unknowns[k].to_fit(SPECIFICATIONS[unknowns[k].name].value) for k in self._own]
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

"""How a simulation sticks and slips as recordings do: the effect's parameters, and how alike the two then are.

The instants are chance and are not predicted; the sizes of jumps and the durations of rests are, and two samples of
each are compared. They are simulated with the muscle that is handed on, for the values are used with that.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import Imitated, Sticking
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.stick_slip import CHANCE, Signature, alike, seen_beside, signature
from tcp_muscle_ros.diagnosis.model.model import floating
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle import EFFECTS, SPECIFICATIONS, Parameters
from tcp_muscle_ros.muscle.arrays import Array

_SEEDS = 3  # simulations of each recording
_ROUNDS = 4  # of adjusting the force to the jumps that it makes
_ALIKE = 0.01  # probability, above which two samples are not told apart: the parameters come from one of them
_FEWEST = 5  # jumps or rests, of which a mean and a spread are taken, or which are compared
_MOSTLY = (0.1, 0.9)  # quantiles


@dataclass(frozen=True)
class Imitation:
    """``values`` of the effect that make jumps of the recorded mean and spread.

    ``jumps`` and ``rests``: the probability that sizes and durations differ so much by chance (two-sample tests).
    """

    values: dict[str, float]
    jumps: float
    rests: float


def imitation(experiments: Sequence[Experiment], muscle: Parameters, seen: Sequence[Signature]) -> Imitation | None:
    """The effect that makes ``muscle`` stick as these recordings of a motion do; None where there are too few jumps, or
    it makes too few. ``seen``: their rests and jumps, in the same order."""
    effect = _by_chance()
    sizes = np.concatenate([s.sizes() for s in seen])
    if sizes.size < _FEWEST or effect in muscle.effects:
        return None
    spread = float(np.clip(np.std(np.log(sizes)), 0.1, SPECIFICATIONS[f'{effect}.s'].high))
    force = SPECIFICATIONS[f'{effect}.Fb'].value
    values: dict[str, float] = {}
    jumps = rests = np.empty(0)
    for _ in range(_ROUNDS):
        values = {f'{effect}.Fb': min(force, SPECIFICATIONS[f'{effect}.Fb'].high), f'{effect}.s': spread}
        jumps, rests = _simulated(experiments, muscle.replace(values).with_effects(effect), seen)
        force *= float(np.clip(np.mean(sizes) / np.mean(jumps), 0.1, 10.0)) if jumps.size else 0.5
    durations = np.concatenate([s.durations() for s in seen])
    if min(jumps.size, rests.size, durations.size) < _FEWEST:
        return None
    return Imitation(values, alike(sizes, jumps), alike(durations, rests))


@dataclass(frozen=True, eq=False)
class Rests:
    """What recordings show of rests and jumps.

    ``seen``: by recording and channel. ``muscle``: the one that is handed on. ``like``: how a simulation of it sticks
    as they do, None where none of them does.
    """

    seen: tuple[tuple[Experiment, str, Signature], ...]
    muscle: Parameters
    like: Imitation | None = None

    @property
    def stuck(self) -> list[tuple[Experiment, Signature]]:
        """The recordings whose motion sticks."""
        return [(e, s) for e, name, s in self.seen if name == e.model.motion and s.kind == CHANCE]

    @property
    def told(self) -> Sticking | None:
        """That the motion sticks, in numbers; None where it does not."""
        if not self.stuck:
            return None
        runs, found = zip(*self.stuck, strict=True)
        motion = runs[0].model.motion
        rests, jumps = (np.concatenate([of(s) for s in found]) for of in (Signature.durations, Signature.sizes))
        shown = sum(name == motion for _, name, _ in self.seen)
        told = Sticking(motion, tuple(e.name for e in runs), shown, mostly(rests), mostly(jumps))
        if self.like is None:
            return told
        return replace(told, values=self.like.values, alike_jumps=self.like.jumps, alike_rests=self.like.rests)


def mostly(sample: Array) -> tuple[float, float]:
    """From where to where most of a sample is."""
    low, high = np.quantile(sample, _MOSTLY)
    return float(low), float(high)


def rests_of(fitted: Fit, smooth: Fit | None = None, muscle: Parameters | None = None) -> Rests:
    """What is seen beside a fit, and where there are rests and jumps beside the ``smooth`` one, those: it is the same
    without what was found, which may rest itself (friction) and so explain away what is seen. ``muscle``: the one that
    is handed on, default that of the smooth fit."""
    smooth, experiments = smooth or fitted, fitted.problem.experiments
    plain = {at: s for at, s in _signatures(smooth) if s.kind == CHANCE}
    seen = tuple((experiments[k], name, plain.get((k, name), s)) for (k, name), s in _signatures(fitted))
    rests = Rests(seen, muscle or smooth.muscle)
    if not rests.stuck:
        return rests
    runs, found = zip(*rests.stuck, strict=True)
    return replace(rests, like=imitation(runs, rests.muscle, found))


def _signatures(fitted: Fit) -> Iterator[tuple[tuple[int, str], Signature]]:
    """What each recording, by its place, shows of rests and jumps in each channel that moves; not where it was
    averaged, for a jump takes less than a sample."""
    for k, (experiment, left) in enumerate(zip(fitted.problem.experiments, fitted.left, strict=True)):
        for name in floating(experiment.model):
            o = experiment.observed.get(name)
            if o is not None and o.time.size > 2 and float(o.count.max()) == 1.0:
                yield (k, name), seen_beside(o, left[name])


def imitated(rests: Rests) -> Imitated | None:
    """The recording with the most jumps beside one simulation that sticks and slips, at the same zero; None where none
    does."""
    if rests.like is None:
        return None
    most, _ = max(rests.stuck, key=lambda one: one[1].sizes().size)
    motion = most.model.motion
    o, simulated = most.observed[motion], most.predict(stuck(rests.muscle, rests.like, 0))[motion]
    time = o.time - float(most.imposed.time[0])
    return Imitated(most.name, motion, time, o.value, simulated + float(np.mean(o.value - simulated)))


def stuck(muscle: Parameters, like: Imitation, seed: int) -> Parameters:
    """The muscle with the effect, by a seed of its own."""
    effect = _by_chance()
    return muscle.replace({**like.values, f'{effect}.seed': float(seed)}).with_effects(effect)


def _by_chance() -> str:
    """The effect whose instants are chance: it has a seed."""
    return next(name for name in EFFECTS if f'{name}.seed' in SPECIFICATIONS)


def _simulated(experiments: Sequence[Experiment], muscle: Parameters, seen: Sequence[Signature]) -> tuple[Array, Array]:
    """Sizes of jumps and durations of rests of simulations, read as coarsely as the recordings, and seen like them
    beside a motion that does not rest."""
    jumps, rests = [np.empty(0)], [np.empty(0)]
    effect, model = _by_chance(), experiments[0].model
    motion = model.motion
    plain = muscle.only_effects(name for name in muscle.effects if name not in (effect, model.roles.sticks))
    for e, s in zip(experiments, seen, strict=True):
        smooth = e.predict(plain)[motion]
        for seed in range(_SEEDS):
            value = e.predict(muscle.replace({f'{effect}.seed': float(seed)}))[motion]
            found = signature(e.observed[motion].time, np.round(value / s.still) * s.still, smooth)
            jumps.append(found.sizes())
            rests.append(found.durations())
    return np.concatenate(jumps), np.concatenate(rests)


def said_of(found: Imitation | None) -> str:
    """How to simulate the same kind of motion, and how alike it is."""
    if found is None:
        return ''
    values = ' and '.join(f'{name} {value:.2g}' for name, value in found.values.items())
    jumps, rests = (f'p {"< 0.001" if p < 1e-3 else f"= {p:.2g}"}' for p in (found.jumps, found.rests))
    large = 'jumps as large' if found.jumps > _ALIKE else 'jumps of other sizes'
    long = 'rests as long' if found.rests > _ALIKE else 'rests of other durations'
    has = f'{large} ({jumps}) and {long} ({rests}, two-sample tests)'
    return f'; a simulation of improved.yaml with {values} has {has}'

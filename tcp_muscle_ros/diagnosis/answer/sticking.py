"""How a simulation sticks and slips as recordings do: the effect's parameters, and how alike the two then are.

The instants are chance and are not predicted; the sizes of jumps and the durations of rests are, and two samples of
each are compared.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import Imitated
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.stick_slip import CHANCE, Signature, alike, seen_beside, signature
from tcp_muscle_ros.diagnosis.model.model import floating
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle import EFFECTS, SPECIFICATIONS, Parameters
from tcp_muscle_ros.muscle.arrays import Array

_SEEDS = 3  # simulations of each recording
_SHARED = 10  # simulations, of whose courses the mean is what they share
_ROUNDS = 4  # of adjusting the force to the jumps that it makes
_ALIKE = 0.01  # probability, above which two samples are not told apart: the parameters come from one of them
_FEWEST = 5  # jumps, of which a mean and a spread are taken


@dataclass(frozen=True)
class Imitation:
    """``values`` of the effect that make jumps of the recorded mean and spread.

    ``jumps`` and ``rests``: the probability that sizes and durations differ so much by chance (two-sample tests).
    """

    values: dict[str, float]
    jumps: float
    rests: float


def imitation(experiments: Sequence[Experiment], muscle: Parameters, seen: Sequence[Signature]) -> Imitation | None:
    """The effect as these recordings of a motion show it; None where there are too few jumps. ``seen``: their rests and
    jumps, in the same order."""
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
    return Imitation(values, alike(sizes, jumps), alike(durations, rests))


@dataclass(frozen=True, eq=False)
class Rests:
    """What recordings show of rests and jumps.

    ``seen``: by recording and channel. ``like``: how a simulation of the ``smooth`` fit's muscle sticks as they do,
    None where none of them does.
    """

    seen: tuple[tuple[Experiment, str, Signature], ...]
    like: Imitation | None
    experiments: tuple[Experiment, ...]
    smooth: Fit

    @property
    def stuck(self) -> list[tuple[Experiment, Signature]]:
        """The recordings whose motion sticks."""
        return [(e, s) for e, name, s in self.seen if name == e.model.motion and s.kind == CHANCE]


def rests_of(fitted: Fit, smooth: Fit | None = None) -> Rests:
    """What is seen beside a fit, and where there are rests and jumps beside the ``smooth`` one, those: it is the same
    without what was found, which may rest itself (friction) and so explain away what is seen."""
    smooth, experiments = smooth or fitted, tuple(fitted.problem.experiments)
    plain = {at: s for at, s in _signatures(smooth) if s.kind == CHANCE}
    seen = tuple((experiments[k], name, plain.get((k, name), s)) for (k, name), s in _signatures(fitted))
    rests = Rests(seen, None, experiments, smooth)
    if not rests.stuck:
        return rests
    runs, found = zip(*rests.stuck, strict=True)
    return replace(rests, like=imitation(runs, smooth.muscle, found))


def _signatures(fitted: Fit) -> Iterator[tuple[tuple[int, str], Signature]]:
    """What each recording, by its place, shows of rests and jumps in each channel that moves; not where it was
    averaged, for a jump takes less than a sample."""
    for k, (experiment, left) in enumerate(zip(fitted.problem.experiments, fitted.left, strict=True)):
        for name in floating(experiment.model):
            o = experiment.observed.get(name)
            if o is not None and o.time.size > 2 and float(o.count.max()) == 1.0:
                yield (k, name), seen_beside(o, left[name])


def imitated(rests: Rests) -> Imitated | None:
    """The recording with the most jumps beside a simulation that sticks and slips; None where none does."""
    if rests.like is None:
        return None
    most, _ = max(rests.stuck, key=lambda one: one[1].sizes().size)
    motion, smooth = most.model.motion, rests.smooth
    k = next(k for k, e in enumerate(rests.experiments) if e is most)
    recorded, simulated = one_run(most, smooth.muscle, smooth.left[k][motion], rests.like)
    time = most.observed[motion].time - float(most.imposed.time[0])
    return Imitated(most.name, motion, time, recorded, simulated)


def one_run(
    experiment: Experiment, muscle: Parameters, left: Array, like: Imitation, seed: int = 0
) -> tuple[Array, Array]:
    """What was recorded and one simulation that sticks, m: about the course that was fitted, of which ``left`` (m) is
    missed, for a run has a gain of its own.

    An end that sticks follows late, both ways. The fit was to one that did, and has that already: what all seeds share
    is left out, or it would be late twice.
    """
    motion = experiment.model.motion
    one, *others = (
        experiment.predict(stuck(muscle, like, s))[motion] for s in (seed, *(n for n in range(_SHARED) if n != seed))
    )
    recorded = experiment.observed[motion].value
    return recorded, recorded - left + one - np.mean([one, *others], axis=0)


def stuck(muscle: Parameters, like: Imitation, seed: int) -> Parameters:
    """The muscle with the effect, by a seed of its own."""
    effect = _by_chance()
    return muscle.replace({**like.values, f'{effect}.seed': float(seed)}).with_effects(effect)


def _by_chance() -> str:
    """The effect whose instants are chance: it has a seed."""
    return next(name for name in EFFECTS if f'{name}.seed' in SPECIFICATIONS)


def _simulated(experiments: Sequence[Experiment], muscle: Parameters, seen: Sequence[Signature]) -> tuple[Array, Array]:
    """Sizes of jumps and durations of rests of simulations, read as coarsely as the recordings."""
    jumps, rests = [np.empty(0)], [np.empty(0)]
    effect, motion = _by_chance(), experiments[0].model.motion
    plain = muscle.only_effects(name for name in muscle.effects if name != effect)
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
    return f'; a simulation with {values} has {large} ({jumps}) and {long} ({rests}, two-sample tests)'

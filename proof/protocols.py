"""The experiments of a lab, after physics.md 2.1: what is done to a muscle in one recording."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from proof.truth.bench import Experiment
from proof.truth.body import Body, weight
from proof.truth.plant import CURRENT, POWER, VOLTAGE

PROBE = 0.012  # A, enough to read R, too little to heat (0.1 K)


@dataclass(frozen=True)
class Lab:
    """What a lab keeps the same over its recordings of one muscle."""

    body: Body
    rate: float  # Hz
    kind: int  # of the input
    ambient: float  # degC
    top: float  # A, the largest current

    def currents(self) -> list[float]:
        """Four levels in the ratio of the paper's 0.18, 0.21, 0.24 and 0.27 A."""
        return [round(self.top * share / 0.27, 3) for share in (0.18, 0.21, 0.24, 0.27)]


def draw_lab(rng: np.random.Generator, body: Body, *, plain: bool = False) -> Lab:
    """A lab: 20 Hz and currents mostly; room between 21 and 26 degC."""
    kind = CURRENT if plain else int(rng.choice([CURRENT, POWER, VOLTAGE], p=[0.86, 0.08, 0.06]))
    ambient = 23.0 if rng.random() < 0.5 else float(np.round(rng.uniform(21.0, 26.0), 1))
    hottest = float(rng.uniform(81.0, 87.0))
    rate = 20.0 if plain or rng.random() < 0.9 else 10.0
    return Lab(body, rate, kind, ambient, round(body.steady_current(hottest, ambient), 3))


@dataclass(frozen=True)
class Step:
    """A stretch of time: the current (or where it goes from and to), A, and the load, N."""

    seconds: float
    current: float | tuple[float, float]
    load: float


def build(lab: Lab, name: str, steps: Sequence[Step], rng: np.random.Generator, *, blocked: bool = False) -> Experiment:
    """Steps on jittered ticks."""
    drive, load = [], []
    for step in steps:
        n = max(1, round(step.seconds * lab.rate))
        start, end = step.current if isinstance(step.current, tuple) else (step.current, step.current)
        drive.append(np.linspace(start, end, n))
        load.append(np.full(n, step.load))
    current = np.concatenate(drive)
    period = 1.0 / lab.rate
    jitter = rng.normal(0.0, 0.0015, len(current)).clip(-0.2 * period, 0.2 * period)
    time = np.arange(len(current)) * period + jitter
    return Experiment(
        name, time - time[0], as_input(lab, current), lab.kind, np.concatenate(load), lab.ambient, blocked
    )


def as_input(lab: Lab, current: np.ndarray) -> np.ndarray:
    """The power or voltage that a lab would set for about this current; 0.1 mA, 1 mW and 1 mV fine."""
    b = lab.body
    if lab.kind == CURRENT:
        return np.round(current, 4)
    heat = current**2 * b.R0
    theta = heat / np.maximum(b.hA - heat * b.a_R, 0.2 * b.hA)
    R = b.R0 * (1.0 + b.a_R * (lab.ambient + theta - b.T0))
    return np.round(current**2 * R if lab.kind == POWER else current * R, 3)


Protocol = Callable[[Lab, np.random.Generator], list[Step]]
PROTOCOLS: dict[str, Protocol] = {}


def protocol(function: Protocol) -> Protocol:
    """Enter a protocol under its own name."""
    PROTOCOLS[function.__name__] = function
    return function


def _load(rng: np.random.Generator, grams: Sequence[float] = (30, 60, 100)) -> float:
    return weight(float(rng.choice(grams)))


def _cycles(lab: Lab, currents: Sequence[float], load: float, on: float = 25.0, off: float = 45.0) -> list[Step]:
    steps = [Step(5.0, 0.0, load)]
    for i in currents:
        steps += [Step(on, i, load), Step(off, 0.0, load)]
    return steps


@protocol
def paper(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """25 s on, 45 s off, the four currents (or each of two twice) under one load."""
    levels = lab.currents()
    chosen = levels if rng.random() < 0.6 else [levels[1], levels[1], levels[3], levels[3]]
    return _cycles(lab, chosen, _load(rng))


@protocol
def paper_light(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """The paper's cycles at the upper currents with little load."""
    levels = lab.currents()
    return _cycles(lab, [levels[2], levels[3], levels[3]], _load(rng, (15, 20, 30)))


@protocol
def paper_heavy(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """The paper's cycles with much load."""
    return _cycles(lab, lab.currents()[1:], _load(rng, (100, 150, 180)))


@protocol
def light_hot(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """Full current under little load, longer on than the paper."""
    load = _load(rng, (10, 20, 30))
    return _cycles(lab, [lab.top, lab.top, lab.currents()[2]], load, on=40.0, off=50.0)


@protocol
def repeat(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """The same cycle over and over."""
    level = lab.currents()[int(rng.integers(2, 4))]
    return _cycles(lab, [level] * int(rng.integers(6, 10)), _load(rng), on=20.0, off=30.0)


@protocol
def hold(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """A long hold, then a long cooling with a probe current, so that R is seen in both."""
    load, level = _load(rng), lab.currents()[int(rng.integers(1, 4))]
    return [Step(8.0, PROBE, load), Step(150.0, level, load), Step(70.0, PROBE, load)]


@protocol
def staircase(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """Slow steps up and down with reversals inside: minor loops."""
    load, seconds = _load(rng), 14.0
    shares = [0.45, 0.7, 0.85, 1.0, 0.85, 0.7, 0.55, 0.75, 0.9, 0.75, 0.55, 0.8, 1.0, 0.7, 0.45]
    return [Step(5.0, 0.0, load), *(Step(seconds, round(lab.top * s, 3), load) for s in shares), Step(40.0, 0.0, load)]


@protocol
def rates(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """The same range of temperature at three rates."""
    load, low = _load(rng), round(0.35 * lab.top, 3)
    steps = [Step(4.0, 0.0, load)]
    for seconds in rng.permutation([15.0, 35.0, 70.0]):
        steps += [Step(seconds, (low, lab.top), load), Step(seconds, (lab.top, low), load)]
    return [*steps, Step(30.0, 0.0, load)]


@protocol
def rates_light(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """`rates` under little load."""
    load, low = _load(rng, (10, 20, 30)), round(0.35 * lab.top, 3)
    steps = [Step(4.0, 0.0, load)]
    for seconds in rng.permutation([20.0, 50.0]):
        steps += [Step(seconds, (low, lab.top), load), Step(seconds, (lab.top, low), load)]
    return [*steps, Step(40.0, 0.0, load)]


@protocol
def prbs(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """Switching at random between levels."""
    load = _load(rng)
    levels = [0.0, PROBE, *lab.currents()[::3], round(1.15 * lab.top, 3)]
    steps, spent = [Step(3.0, 0.0, load)], 0.0
    total = float(rng.uniform(150.0, 240.0))
    while spent < total:
        seconds = float(rng.choice([2.0, 4.0, 6.0, 9.0, 14.0]))
        steps.append(Step(seconds, float(rng.choice(levels, p=[0.2, 0.2, 0.2, 0.25, 0.15])), load))
        spent += seconds
    return [*steps, Step(25.0, PROBE, load)]


def _weights(rng: np.random.Generator) -> list[float]:
    return [weight(g) for g in (30, 60, 100, 150, 100, 60, 30, 100, 30, 150, 60)][: int(rng.integers(8, 12))]


@protocol
def load_steps_cold(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """Weights added and taken off at room temperature, then one heating."""
    loads = _weights(rng)
    steps = [Step(10.0, PROBE, load) for load in loads]
    return [*steps, Step(25.0, lab.currents()[2], loads[0]), Step(40.0, PROBE, loads[0])]


@protocol
def load_steps_hot(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """Weights added and taken off at two held currents."""
    loads = _weights(rng)
    steps = [Step(5.0, PROBE, loads[0])]
    for level in (lab.currents()[0], lab.currents()[int(rng.integers(2, 4))]):
        steps += [Step(40.0, level, loads[0]), *(Step(9.0, level, load) for load in loads)]
    return [*steps, Step(40.0, PROBE, loads[0])]


@protocol
def hold_loads(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """One load after the other, each heated and cooled."""
    steps = [Step(5.0, 0.0, weight(30))]
    for grams in (30, 60, 100, 150):
        steps += [Step(30.0, lab.currents()[3], weight(grams)), Step(40.0, 0.0, weight(grams))]
    return steps


@protocol
def one_load(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """The full current over and over under 60 g: one load, one range."""
    return _cycles(lab, [lab.top] * 4, weight(60.0))


@protocol
def steady(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """One current for minutes and nothing else."""
    return [Step(240.0, lab.currents()[2], weight(60.0))]


@protocol
def rest(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """Nothing but the room for two minutes, then two cycles."""
    load = _load(rng)
    return [Step(120.0, PROBE, load), *_cycles(lab, lab.currents()[1::2], load)]


@protocol
def blocked(lab: Lab, rng: np.random.Generator) -> list[Step]:
    """The paper's cycles with both ends held: force instead of stroke."""
    return _cycles(lab, lab.currents()[1:], _load(rng, (30, 60)))


GENERAL = ('paper', 'paper', 'hold', 'prbs', 'staircase', 'rates', 'load_steps_hot', 'load_steps_cold', 'hold_loads')


def plan(lab: Lab, shown_by: Sequence[str], rng: np.random.Generator, *, count: int = 0) -> list[Experiment]:
    """Two to four recordings: at least two that can show what is concealed, the rest as labs do."""
    count = count or int(rng.choice([2, 3, 4], p=[0.25, 0.5, 0.25]))
    names = [str(rng.choice(shown_by)), str(rng.choice(shown_by))]
    names += [str(rng.choice(GENERAL)) for _ in range(count - 2)]
    if len(names) > 2 and rng.random() < 0.12:
        names[-1] = 'blocked'
    done = [experiment(lab, name, rng) for name in names]
    return [replace(e, warm=float(rng.uniform(0.5, 6.0))) if rng.random() < 0.15 else e for e in done]


def experiment(lab: Lab, name: str, rng: np.random.Generator) -> Experiment:
    """One recording by the name of its protocol."""
    return build(lab, name, PROTOCOLS[name](lab, rng), rng, blocked=name == 'blocked')


def unseen(lab: Lab, seen: Sequence[Experiment], rng: np.random.Generator) -> Experiment:
    """For held-out data: cycles, load steps hot and cold, and reversals, at currents that no other protocol uses.

    The loads lie between those of the recordings seen, so that what is asked could be learnt from them.
    """
    loads = np.concatenate([e.load for e in seen])
    least, most = float(loads.min()), float(loads.max())
    light, low, middle, high = (round(least + share * (most - least), 4) for share in (0.12, 0.35, 0.6, 0.88))
    full, held = round(0.97 * lab.top, 3), round(0.85 * lab.top, 3)
    steps = [
        *_cycles(lab, [full], light, on=30.0, off=40.0),
        *_cycles(lab, [full, round(0.74 * lab.top, 3)], middle, on=28.0, off=38.0),
        Step(35.0, held, low),
        *(Step(10.0, held, load) for load in (high, middle, low)),
        *(Step(12.0, round(share * lab.top, 3), low) for share in (0.62, 0.95, 0.66, 0.92)),
        Step(35.0, 0.0, low),
        *(Step(8.0, PROBE, load) for load in (high, light, low)),
    ]
    return build(lab, 'unseen', steps, rng)

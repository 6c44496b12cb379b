"""Protocols that a rig can do: a book of them, and variations of one in pace, currents and loads."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import Step
from tcp_muscle_ros.muscle import ZERO_CELSIUS, Parameters, steady_current
from tcp_muscle_ros.muscle.statics import resistance
from tcp_muscle_ros.settings.rig import RigLimits

_BEFORE_IT_IS_OVER = 'a delay against a lag: the next edge comes before either is over'
_HOTTEST = ZERO_CELSIUS + 90.0  # K, which an experiment heats a muscle to
_MARGIN = 2.0  # K below a rig's limit: one reading at the limit ends a run, and no model is exact
_HALF_THE_TIME = 1.25  # times the current for that
_LONGEST = 900.0  # s, where no rig says anything else
_SHORTEST = 0.1  # s, of a step
_MOST_STEPS = 240
_PACES, _CURRENTS, _LASTS = (0.4, 0.6, 1.6, 2.5), (0.5, 0.7, 0.85, 1.2), (0.3, 0.6, 1.7, 3.0)


@dataclass(frozen=True)
class Plan:
    """A protocol on paper: what it asks, its steps, how often they repeat."""

    name: str
    reason: str
    steps: tuple[Step, ...]
    repeat: int = 1

    @property
    def duration(self) -> float:
        """Of all repetitions, s."""
        return self.repeat * sum(step.duration for step in self.steps)


@dataclass(frozen=True)
class Reach:
    """What a rig can do to a muscle: the drive for the hottest that it may be at steady state and the most (A, W or V,
    as ``kind`` says), K, N, s."""

    full: float
    most: float
    hottest: float
    loads: tuple[float, ...]  # ascending
    base: float  # of the loads, the nearest to the one at hand
    longest: float
    by_person: bool  # who changes the load: not for one step among many, and each load is then played by itself
    kind: str = 'current'
    largest: float = float('inf')  # A, that the model may have flow


def reach(
    muscle: Parameters,
    load: float,
    ambient: float,
    limits: RigLimits | None = None,
    most: float = float('inf'),
    kind: str = 'current',
    hottest: float = float('inf'),
) -> Reach:
    """Within the rig's limits, where they are known; else no hotter than 90 degC at steady state, and no more than
    twice the load at hand (N); no more than ``most`` of a ``kind`` of drive (A, W or V), and no hotter than ``hottest``
    (K); ``ambient`` K."""
    bearable = min(_HOTTEST, hottest)
    if limits is None:
        base, longest, by_person = max(load, 0.2), _LONGEST, True
        loads: tuple[float, ...] = (0.5 * base, base, 2.0 * base)
    else:
        loads = tuple(sorted(limits.loads or (load,)))
        base = min(loads, key=lambda one: abs(one - load))
        longest, by_person = limits.longest_run, limits.by_person
        bearable = min(bearable, limits.highest_temperature - _MARGIN)
        most = min(most, _drive(muscle, kind, limits.largest_current, ambient))
    full = min(_drive(muscle, kind, steady_current(muscle, bearable, ambient), bearable), most)
    return Reach(full, min(_HALF_THE_TIME * full, most), bearable, loads, base, longest, by_person, kind)


def _drive(muscle: Parameters, kind: str, current: float, temperature: float) -> float:
    """The drive (A, W or V) that is a current (A) in a muscle as hot as that (K)."""
    ohms = float(resistance(muscle, temperature))
    return {'current': current, 'power': current**2 * ohms, 'voltage': current * ohms}[kind]


def plans(rig: Reach) -> list[Plan]:
    """The protocols of the book that a rig can do."""

    def within(plan: Plan) -> Plan:
        return replace(plan, steps=tuple(replace(step, current=min(step.current, rig.most)) for step in plan.steps))

    book = _book(rig.full, rig.loads[0], rig.base, rig.loads[-1])
    # Under one load those that compare loads compare nothing.
    of_loads = {plan.name for plan in _book(rig.full, 0.5, 1.0, 2.0) if len({step.load for step in plan.steps}) > 1}
    return [
        within(plan)
        for plan in book
        if plan.duration <= rig.longest and (len(rig.loads) > 1 or plan.name not in of_loads)
    ]


def varied(plan: Plan, rng: np.random.Generator, rig: Reach) -> Plan | None:
    """A protocol that differs in one respect, drawn; None where the rig cannot do it, or it is none."""
    steps, repeat = list(plan.steps), plan.repeat
    what = str(rng.choice(['pace', 'current', 'load', 'step', 'step', 'cut', 'again']))
    if what == 'pace':
        steps = [replace(s, duration=s.duration * factor) for factor in [rng.choice(_PACES)] for s in steps]
    elif what == 'current':
        steps = [replace(s, current=s.current * factor) for factor in [rng.choice(_CURRENTS)] for s in steps]
    elif what == 'load':
        steps = _at_other_loads(steps, rng, rig)
    elif what == 'step':
        k = int(rng.integers(len(steps)))
        steps[k] = _other(steps[k], rng, rig)
    elif what == 'cut':
        k, length = int(rng.integers(len(steps))), max(1, len(steps) // 3)
        steps = steps[:k] + steps[k + length :]
    else:
        repeat = repeat * 2 if repeat == 1 or rng.random() < 0.5 else repeat // 2
    found = Plan(plan.name, plan.reason, tuple(_rounded(s, rig) for s in steps), repeat)
    feasible = bool(steps) and found != plan and len(steps) * repeat <= _MOST_STEPS and found.duration <= rig.longest
    return found if feasible else None


def _at_other_loads(steps: list[Step], rng: np.random.Generator, rig: Reach) -> list[Step]:
    """The loads exchanged, or all steps at one."""
    if rng.random() < 0.5:
        one = float(rng.choice(rig.loads))
        return [replace(s, load=one) for s in steps]
    mine = sorted({s.load for s in steps})
    other = rng.permutation(rig.loads)
    return [replace(s, load=float(other[mine.index(s.load) % len(other)])) for s in steps]


def _other(step: Step, rng: np.random.Generator, rig: Reach) -> Step:
    """Longer or shorter, at another current, or under another load where the rig changes it."""
    what = int(rng.integers(2 if rig.by_person else 3))
    if what == 0:
        return replace(step, duration=step.duration * float(rng.choice(_LASTS)))
    if what == 1:
        return replace(step, current=float(rng.uniform(0.0, rig.most)))
    return replace(step, load=float(rng.choice(rig.loads)))


def _rounded(step: Step, rig: Reach) -> Step:
    duration, current = max(round(float(step.duration), 2), _SHORTEST), min(round(float(step.current), 4), rig.most)
    return Step(duration, current, float(step.load))


def _book(full: float, low: float, base: float, high: float) -> list[Plan]:
    """The protocols with so much drive (A, W or V) at steady state, at these loads (N)."""

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

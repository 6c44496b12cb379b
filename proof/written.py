"""Muscles with one law of a known form that is in no catalogue, and what is recorded of them and what is not.

The muscle is the truth generator's, whose tables take any form; what is tuned on its suites is not tuned on these. The
recordings that a method is given go up to one current and one load; those that it is not given lie within that range,
and beyond it by a fifth in current, in load, and in both.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from proof.cases import Case
from proof.protocols import PROBE, Lab, Step, build
from proof.recordings import draw_noise
from proof.truth import Bench, Body, Concealed, Experiment, conceal, draw_body
from proof.truth.plant import CURRENT, F_GRID, T_GRID, Array

CHANNELS = ('temperature', 'resistance', 'displacement')
ROOM = 23.0  # degC
HOTTEST = 72.0  # degC, at the largest current seen: a fifth more current stays within what the paper's model is of
LIGHT, MEDIUM, HEAVY = 0.3, 0.6, 0.9  # N, the loads seen
FURTHER = 1.2
SPAN = 50.0  # K above the room, over which a law has its whole size
STAGES = {'loss': 'thermal', 'capacity': 'thermal', 'free': 'mechanical', 'soft': 'mechanical', 'rho': 'electrical'}

# What a law does over v, the temperature above the room in units of SPAN; with a number of its own where it has one.
FORMS: dict[str, Callable[[Array, float], Array]] = {
    'linear': lambda v, _: v,
    'square': lambda v, _: v**2,
    'cube': lambda v, _: v**3,
    'exponential': lambda v, s: np.expm1(v / s) / np.expm1(1.0 / s),
    'threshold': lambda v, a: np.maximum(v - a, 0.0) / (1.0 - a),
    'saturation': lambda v, s: np.expm1(-v / s) / np.expm1(-1.0 / s),
}
OWN = {'exponential': (0.3, 0.6), 'threshold': (0.35, 0.7), 'saturation': (0.15, 0.35)}  # between which it is drawn
LEAST, MOST = 0.4, 2.5  # of a table, where a law would leave no muscle
# By table: the size of a law at SPAN, of the sign that no listed effect has; m for the contraction, else a share.
SIZES = {'loss': -0.25, 'capacity': -0.3, 'free': 3e-3, 'soft': 0.3}


@dataclass(frozen=True)
class Written:
    """A law: its form over the temperature, the table of the plant that it changes, its number and its size.

    ``by_load``: it is a product: as large under a load as that is in units of MEDIUM.
    """

    form: str
    table: str
    number: float
    size: float
    by_load: bool = False

    def at(self, temperature: Array) -> Array:
        """What it does at these temperatures (degC)."""
        v = np.maximum(temperature - ROOM, 0.0) / SPAN
        return np.asarray(self.size * FORMS[self.form](v, self.number))

    def change(self, bench: Bench) -> None:
        """Conceal it."""
        if self.by_load:  # the free stroke times a line over the load
            bench.set(gain=1.0 + self.size * (F_GRID / MEDIUM - 1.0))
        elif self.table == 'free':
            bench.set(free=bench.plant.free + self.at(T_GRID))
        else:  # the table of the loss is over the rise above the room
            does = self.at(T_GRID + ROOM if self.table == 'loss' else T_GRID)
            bench.scale(self.table, np.clip(1.0 + does, LEAST, MOST))


def written(form: str, table: str, rng: np.random.Generator) -> Written:
    """A law of this form in this table, of about its usual size."""
    number = float(rng.uniform(*OWN.get(form, (0.0, 0.0))))
    return Written(form, table, number, SIZES[table] * float(rng.uniform(0.8, 1.2)))


def case_of(law: Written, seed: int) -> Case:
    """A muscle with this law and its recordings, every number of it drawn."""
    rng = np.random.default_rng([seed, 23])
    hidden = Concealed('written', STAGES[law.table], law.form, 1.0, {'size': law.size}, law.change)
    return _case(f'{law.form}_{law.table}_{seed}', draw_body(rng), hidden, [seed, 23], rng)


def case_with(effect: str, seed: int, strength: float = 0.75) -> Case:
    """The same with one of the generator's own effects."""
    rng = np.random.default_rng([seed, 24])
    body = draw_body(rng)
    return _case(effect, body, conceal(effect, strength, 2, body, rng), [seed, 24], rng)


def _case(name: str, body: Body, hidden: Concealed, seed: list[int], rng: np.random.Generator) -> Case:
    lab = Lab(body, 20.0, CURRENT, ROOM, round(body.steady_current(HOTTEST, ROOM), 3))
    bench = Bench.of(body)
    hidden.change(bench)
    noise = draw_noise(rng)
    return Case(name, 'unlisted', hidden.effect, seed, lab, bench, seen(lab, rng), CHANNELS, noise, [hidden], form=2)


def _cycles(lab: Lab, shares: Sequence[float], load: float) -> list[Step]:
    steps = [Step(5.0, PROBE, load)]
    for share in shares:
        steps += [Step(28.0, round(share * lab.top, 3), load), Step(40.0, PROBE, load)]
    return steps


def seen(lab: Lab, rng: np.random.Generator) -> list[Experiment]:
    """What is recorded: cycles at four currents, steps up and down under a light load, the full current under each."""
    stairs = [0.45, 0.7, 0.85, 1.0, 0.85, 0.6, 0.9, 0.75, 0.5, 1.0, 0.45]
    loads = [LIGHT, MEDIUM, HEAVY, MEDIUM]
    each = [_cycles(lab, [1.0], load) for load in loads]
    up_and_down = (Step(14.0, round(share * lab.top, 3), LIGHT) for share in stairs)
    steps = [
        _cycles(lab, [0.67, 0.78, 0.89, 1.0], MEDIUM),
        [Step(5.0, PROBE, LIGHT), *up_and_down, Step(40.0, PROBE, LIGHT)],
        [step for one in each for step in one],
    ]
    return [build(lab, f'seen_{k}', one, rng) for k, one in enumerate(steps)]


def unseen(lab: Lab, rng: np.random.Generator) -> dict[str, Experiment]:
    """What is not: within what was seen, and a fifth beyond the largest current, the largest load, and both."""
    within = [*_cycles(lab, [0.72, 0.94], 0.5 * (LIGHT + MEDIUM)), *_cycles(lab, [0.83], 0.5 * (MEDIUM + HEAVY))]
    places = {
        'within': within,
        'current': _cycles(lab, [0.9, 1.1, FURTHER], MEDIUM),
        'load': _cycles(lab, [0.83, 0.97], FURTHER * HEAVY),
        'both': _cycles(lab, [1.1, FURTHER], FURTHER * HEAVY),
    }
    return {name: build(lab, name, steps, rng) for name, steps in places.items()}

"""What can be concealed in a muscle, and in which forms.

Each effect is one function: it draws its numbers for a strength between 0 (barely visible) and 1 (obvious), within the
ranges of the catalogue in physics.md part 2 (a little below 0: weaker than these), and says how the bench is changed.
An effect has four forms, none of them the catalogue's own: the first is for development, the second for the sealed
suite, the third for another development suite, so that what is tuned is not tuned on one form alone. The fourth
(`outside.py`, `outside_heat.py`, `outside_bench.py`) is one that nothing is tuned on: the probabilities of findings are
weighed on it. An effect that no catalogue holds has one form and belongs to one suite at most.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from proof.truth.bench import Bench
from proof.truth.body import Body, free_change, modulus_ratio

HOT = 80.0  # degC, where strengths are quoted

Change = Callable[[Bench], None]


@dataclass(frozen=True)
class Draw:
    """What an effect may look at when it draws its numbers."""

    rng: np.random.Generator
    strength: float
    form: int  # 0, 1, 2 or 3
    body: Body

    def between(self, weak: float, strong: float) -> float:
        """From weak to strong on a logarithmic scale, by strength."""
        return float(weak * (strong / weak) ** self.strength)

    def any(self, low: float, high: float) -> float:
        """A number that does not make the effect stronger or weaker."""
        return float(self.rng.uniform(low, high))

    def seed(self) -> int:
        """For what is random in time."""
        return int(self.rng.integers(2**31))


Outcome = tuple[dict[str, float], Change]


@dataclass(frozen=True)
class Effect:
    """One name of the contract (or an unlisted one), its stage and forms, and the experiments that can show it."""

    name: str
    stage: str
    forms: tuple[str, ...]
    shown_by: tuple[str, ...]
    draw: Callable[[Draw], Outcome]
    listed: bool = True


@dataclass(frozen=True)
class Concealed:
    """An effect with its numbers."""

    effect: str
    stage: str
    form: str
    strength: float
    values: dict[str, float]
    change: Change


EFFECTS: dict[str, Effect] = {}


def effect(
    name: str, stage: str, forms: tuple[str, ...], shown_by: tuple[str, ...], *, listed: bool = True
) -> Callable[[Callable[[Draw], Outcome]], Callable[[Draw], Outcome]]:
    """Enter the decorated function under its name."""

    def enter(draw: Callable[[Draw], Outcome]) -> Callable[[Draw], Outcome]:
        EFFECTS[name] = Effect(name, stage, forms, shown_by, draw, listed)
        return draw

    return enter


def fourth(name: str, form: str) -> Callable[[Callable[[Draw], Outcome]], Callable[[Draw], Outcome]]:
    """Enter the decorated function as the fourth form of an effect that has three."""

    def enter(draw: Callable[[Draw], Outcome]) -> Callable[[Draw], Outcome]:
        known = EFFECTS[name]
        EFFECTS[name] = replace(
            known, forms=(*known.forms, form), draw=lambda d: draw(d) if d.form == 3 else known.draw(d)
        )
        return draw

    return enter


def conceal(name: str, strength: float, form: int, body: Body, rng: np.random.Generator) -> Concealed:
    """Draw an effect. form is taken modulo the number of forms."""
    entry = EFFECTS[name]
    form %= len(entry.forms)
    values, change = entry.draw(Draw(rng, strength, form, body))
    return Concealed(name, entry.stage, entry.forms[form], strength, values, change)


def reached(d: Draw, load: float) -> float:
    """The length of the plain muscle at HOT under a load in N, m."""
    hot = np.array([HOT])
    return float(d.body.H0 + free_change(d.body, hot)[0] + load / (d.body.k0 * modulus_ratio(hot)[0]))

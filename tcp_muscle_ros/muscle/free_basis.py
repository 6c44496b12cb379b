"""A law without a name as a linear combination: knots over the range of its driver, and how much they may differ.

What a fit needs: the names of the values at the knots, which enter the law linearly, and a prior of them as rows of a
least-squares problem. The law says itself how wide the prior is (``Freedom`` in ``effects/effect.py``).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.edges import EDGES, EdgeValue, inside
from tcp_muscle_ros.muscle.effects import EFFECTS
from tcp_muscle_ros.muscle.parameters import Parameters

_SPACING = 0.25  # of the range of the driver: between the knots for which a law says its bend
FREE = tuple(name for name, effect in EFFECTS.items() if effect.free is not None)


@dataclass(frozen=True)
class Basis:
    """The coefficients of a free law: its values at ``at`` (in the unit of ``driver``), by their parameters' ``names``.

    ``prior``: rows R, shape (m, number of names), such that R @ values is standard normal before anything is known.
    """

    effect: str
    driver: str
    at: tuple[float, ...]
    names: tuple[str, ...]
    prior: Array

    def on(self, muscle: Parameters, values: ArrayLike) -> Parameters:
        """The muscle with this law on, with these values at the knots, in the order of ``names``."""
        given = np.asarray(values, dtype=np.float64)
        if given.shape != (len(self.names),):
            raise BadInput(f'{self.effect}: expected {len(self.names)} values, as it has names; got {given.shape}')
        table: dict[str, EdgeValue] = {f'{self.effect}.driver': self.driver, f'{self.effect}.at': self.at}
        for k, name in enumerate(_arrays(self.effect)[: len(self.names) // len(self.at)]):
            table[name] = tuple(given[k * len(self.at) : (k + 1) * len(self.at)])
        return muscle.replace(inside(table)).with_effects(self.effect)


def basis(effect: str, low: float, high: float, driver: str = '', knots: int = 5, both_ways: bool = False) -> Basis:
    """Evenly spaced knots of a free law over the range that its driver goes through.

    Args:
        effect: one of FREE.
        low: where the driver begins, in its unit.
        high: where it ends.
        driver: default the law's first.
        knots: how many, 2 to 8.
        both_ways: of a law that has values of its own for cooling: those too.

    Raises:
        BadInput: no free law, an unknown driver, an empty range, too few or too many knots.
    """
    if effect not in FREE:
        raise BadInput(f"'{effect}' is no free law{nearest(effect, FREE)}")
    free, arrays = EFFECTS[effect].free, _arrays(effect)
    assert free is not None
    driver = driver or next(iter(free.drivers))
    if driver not in free.drivers:
        raise BadInput(f"{effect}: unknown driver '{driver}'{nearest(driver, free.drivers)}")
    most = len(EDGES[arrays[0]].members)
    if not (low < high and EDGES[arrays[0]].fewest <= knots <= most):
        raise BadInput(f'{effect}: expected a range and 2 to {most} knots; got {low:g} to {high:g} and {knots}')
    chosen = arrays if both_ways else arrays[:1]
    names = tuple(member for name in chosen for member in EDGES[name].members[:knots])
    at = tuple(float(x) for x in np.linspace(low, high, knots))
    bends = np.diff(np.eye(knots), 2, axis=0)  # second differences
    spacing = 1.0 / (knots - 1) / _SPACING
    block = np.vstack([np.eye(knots) / free.width, bends / (free.bend * spacing**2)])
    return Basis(effect, driver, at, names, np.kron(np.eye(len(chosen)), block).astype(np.float64))


def _arrays(effect: str) -> list[str]:
    """The arrays of a law's values."""
    return [f'{effect}.{column.name}' for column in EFFECTS[effect].columns if not column.rising]

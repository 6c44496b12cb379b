"""The muscle's parameters: each value, unit, bound and source is written here, once.

Symbols are those of Karami & Tadesse 2017 (Smart Mater. Struct. 26 125010), Table 1, where the paper has one.
The ROS declarations, the files in ``config/``, the tables in the documents and the priors of a fit are
made from this table. SI inside, absolute temperatures in kelvin; the edge (files, ROS) speaks degC.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle.arrays import Array, Mask
from tcp_muscle_ros.muscle.effects import EFFECTS
from tcp_muscle_ros.muscle.family import FAMILY
from tcp_muscle_ros.muscle.layout import COEFFICIENTS, VECTOR_SIZE
from tcp_muscle_ros.muscle.mechanical import DOMAIN_HIGH, reference_modulus
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.points import HEATING_POINTS, POINTS
from tcp_muscle_ros.muscle.table import DERIVED, INDEX, TABLE

SETS: dict[str, dict[str, float]] = {
    # Resolved model, set A: Table 1 with hA identified from the 80 degC peak at 0.27 A.
    'karami_tadesse_2017': {},
    # The constants and signs as the paper prints them: hA = 0.15, and equations 16 to 18 taken literally
    # (pi D0^2 for (pi N D)^2, and "- D_th" with a negative coefficient, so that heating lengthens).
    'karami_tadesse_2017_as_printed': {'hA': 0.15, 'B': -(0.5**2 - np.pi * 0.75e-3**2) / 0.15},
    # Set B: the decimal-slip reading of hA with the mass (given to one digit) that restores 80 degC.
    'karami_tadesse_2017_set_b': {'hA': 0.015, 'm': 1.6e-4},
    # Other muscles.
    **{name: {symbol: stated.value for symbol, stated in muscle.items()} for name, muscle in FAMILY.items()},
}


def _specifications() -> dict[str, Parameter]:
    known = {row.name: row for row in TABLE}
    for effect in EFFECTS.values():
        known |= {f'{effect.name}.{row.name}': row for row in effect.parameters}
    return known


SPECIFICATIONS: Mapping[str, Parameter] = _specifications()
EFFECT_NAMES = tuple(EFFECTS)


def _places() -> dict[str, int]:
    """Where each parameter stands in the vector."""
    found = {row.name: INDEX[row.name] for row in TABLE}
    for effect in EFFECTS.values():
        start = COEFFICIENTS[effect.name].start
        found |= {f'{effect.name}.{row.name}': start + k for k, row in enumerate(effect.parameters)}
    return found


_PLACES = _places()
_DEFAULTS: Array = np.zeros(VECTOR_SIZE)
for _name, _place in _PLACES.items():
    _DEFAULTS[_place] = SPECIFICATIONS[_name].value


class _Built(NamedTuple):
    """What muscles with the same effects have in common: the vector as far as they decide it, which are on, and the
    functions that fill in the rest or tell how quick it is, each with its place in the vector."""

    nominal: Array
    mask: Mask
    prepared: tuple[tuple[Callable[[Any], None], slice], ...]
    quick: tuple[tuple[Callable[[Any, Any], float], slice], ...]


@lru_cache(maxsize=256)
def _built(effects: tuple[str, ...]) -> _Built:
    on = [EFFECTS[name] for name in effects]
    vector = _DEFAULTS.copy()
    vector[INDEX['hottest']] = DOMAIN_HIGH
    vector[INDEX['integrated']] = any(not HEATING_POINTS.isdisjoint(effect.hooks) for effect in on)
    for point in POINTS:
        vector[INDEX[f'at_{point}']] = any(point in effect.hooks for effect in on)
    vector[INDEX['motion']] = any(effect.motion for effect in on)
    mask = np.array([name in effects for name in EFFECT_NAMES], dtype=np.bool_)
    mask.setflags(write=False)
    return _Built(
        vector,
        mask,
        tuple((effect.prepare, COEFFICIENTS[effect.name]) for effect in on if effect.prepare is not None),
        tuple((effect.fastest_rate, COEFFICIENTS[effect.name]) for effect in on),
    )


@dataclass(frozen=True)
class Parameters(Mapping[str, float]):
    """Every parameter of a muscle and the effects that are on. Immutable; SI, absolute temperatures in K.

    A mapping from ``'hA'`` or ``'creep.J'`` to its value. A derived parameter (``C``, ``B``) that was not
    given answers with the value it derives.

    Raises:
        BadInput: for an unknown name or effect (with the nearest one) or a value outside its bounds.
    """

    given: Mapping[str, float]
    effects: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, 'given', dict(self.given))  # what is done to the caller's later is not done to this
        for name, value in self.given.items():
            self._check(name, value)
        for effect in self.effects:
            if effect not in EFFECTS:
                raise BadInput(f"unknown effect '{effect}'{nearest(effect, EFFECTS)}")
        # Order and repetition carry no meaning; the registry's order is the one order.
        wanted = set(self.effects)
        object.__setattr__(self, 'effects', tuple(e for e in EFFECT_NAMES if e in wanted))
        for effect in self.effects:
            self._check_columns(effect)

    def _check_columns(self, effect: str) -> None:
        for column in EFFECTS[effect].columns:
            if column.rising:
                used = self.column(f'{effect}.{column.name}')
                for k, (before, after) in enumerate(pairwise(used)):
                    if not after > before:
                        raise BadInput(
                            f"parameter '{effect}.{column.name}': expected rising numbers; number {k + 2}, {after:g}, "
                            f'is not above {before:g} before it'
                        )

    @staticmethod
    def _check(name: str, value: object) -> None:
        row = SPECIFICATIONS.get(name)
        if row is None:
            raise BadInput(f"unknown parameter '{name}'{nearest(name, SPECIFICATIONS)}")
        if not isinstance(value, (int, float, np.integer, np.floating)):
            raise BadInput(f"parameter '{name}' = {value!r}: expected a number in {row.edge_unit}")
        if name in DERIVED and value == 0.0:
            return
        if not (isfinite(value) and row.low <= value <= row.high):
            raise BadInput(
                f"parameter '{name}' = {row.to_edge(float(value)):g} {row.edge_unit} is outside "
                f'{row.edge_low:g} to {row.edge_high:g} {row.edge_unit}'
            )

    @classmethod
    def named(cls, name: str) -> 'Parameters':
        """A shipped parameter set, by its name in SETS."""
        if name not in SETS:
            raise BadInput(f"unknown parameter set '{name}'{nearest(name, SETS)}")
        return cls(SETS[name])

    def replace(self, values: Mapping[str, float] | None = None, /, **more: float) -> 'Parameters':
        """The same muscle with some values changed (names with a dot go in the mapping)."""
        return Parameters({**self.given, **(values or {}), **more}, self.effects)

    def with_effects(self, *effects: str) -> 'Parameters':
        """The same muscle with these effects on, besides those that are on already."""
        return Parameters(self.given, (*self.effects, *effects))

    def only_effects(self, effects: Iterable[str] = ()) -> 'Parameters':
        """The same muscle with exactly these effects on."""
        return Parameters(self.given, tuple(effects))

    def __getitem__(self, name: str) -> float:
        row = SPECIFICATIONS.get(name)
        if row is None:
            raise BadInput(f"unknown parameter '{name}'{nearest(name, SPECIFICATIONS)}")
        value = self.given.get(name, row.value)
        if name in DERIVED and value == 0.0:
            return DERIVED[name](self)
        return value

    def __contains__(self, name: Any) -> bool:
        return name in SPECIFICATIONS

    def __iter__(self) -> Iterator[str]:
        return iter(SPECIFICATIONS)

    def __len__(self) -> int:
        return len(SPECIFICATIONS)

    def __hash__(self) -> int:
        return hash((tuple(sorted(self.given.items())), self.effects))

    def column(self, name: str) -> tuple[float, ...]:
        """The numbers in use of an array, by its name (``free_stroke.value``)."""
        effect, _, short = name.partition('.')
        for column in EFFECTS[effect].columns if effect in EFFECTS else ():
            if column.name == short:
                return tuple(self[f'{effect}.{m}'] for m in column.members[: int(self[f'{effect}.{column.count}'])])
        raise BadInput(f"unknown array '{name}'")

    def stage(self, effect: str) -> str:
        """The stage of an effect, which may be a choice of its parameters."""
        definition = EFFECTS[effect]
        if not definition.stage_by:
            return definition.stage
        name = f'{effect}.{definition.stage_by}'
        return SPECIFICATIONS[name].choices[round(self[name])]

    @cached_property
    def vector(self) -> Array:
        """What the compiled model reads, shape (VECTOR_SIZE,): the table, constants made from it, effects."""
        built = _built(self.effects)
        vector: Array = built.nominal.copy()
        for name, value in self.given.items():
            vector[_PLACES[name]] = value
        for name in DERIVED:
            vector[_PLACES[name]] = self[name]
        for prepare, own in built.prepared:
            prepare(vector[own])
        vector[INDEX['modulus_at_T0']] = reference_modulus(vector)
        vector[INDEX['fastest_rate']] = self._fastest_rate(vector)
        vector.setflags(write=False)
        return vector

    def followed(self, resolution: float, hottest: float | None = None) -> Array:
        """``vector`` for a coarser look: with this share of the substeps, and with what heat quickens followed up to
        ``hottest`` (K) only.
        """
        if resolution == 1.0 and hottest is None:
            return self.vector
        if (resolution, hottest) in self._coarser:
            return self._coarser[resolution, hottest]
        vector: Array = self.vector.copy()
        if hottest is not None:
            vector[INDEX['hottest']] = min(vector[INDEX['hottest']], hottest)
        vector[INDEX['fastest_rate']] = resolution * self._fastest_rate(vector)
        vector.setflags(write=False)  # numba compiles anew for an array that may be written
        self._coarser[resolution, hottest] = vector
        return vector

    @cached_property
    def _coarser(self) -> dict[tuple[float, float | None], Array]:
        """What ``followed`` has made."""
        return {}

    def _fastest_rate(self, vector: Array) -> float:
        """1/s: the quickest process that the step must resolve. The factor 4 leaves room for a hotter surface."""
        rates = [4.0 * vector[INDEX['hA']] / vector[INDEX['C']]]
        rates += [fastest_rate(vector[own], vector) for fastest_rate, own in _built(self.effects).quick]
        return float(max(rates))

    @cached_property
    def mask(self) -> Mask:
        """Which effects are on, in the registry's order, shape (number of effects,)."""
        return _built(self.effects).mask

"""The muscle's parameters as files and ROS name them: numbers, words, and arrays whose members are numbers inside.

Absolute temperatures of single numbers are in degC here, K inside; arrays are SI on both sides.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle.effects import EFFECTS
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.parameters import SPECIFICATIONS, Parameters
from tcp_muscle_ros.muscle.table import TABLE

EdgeValue = float | str | tuple[float, ...]


@dataclass(frozen=True)
class Edge:
    """One name of a file or of ROS, and the parameters behind it: one, or the ``members`` of an array."""

    name: str
    unit: str
    meaning: str
    source: str
    members: tuple[str, ...]
    count: str = ''
    follows: str = ''

    @property
    def row(self) -> Parameter:
        """The parameter behind it; of an array the first."""
        return SPECIFICATIONS[self.members[0]]

    @property
    def fewest(self) -> int:
        """How many numbers an array has at least."""
        return int(SPECIFICATIONS[self.count].low)

    @property
    def default(self) -> EdgeValue:
        """Its default."""
        return of(self, {name: SPECIFICATIONS[name].value for name in (*self.members, self.count) if name})


def of(edge: Edge, values: Mapping[str, float]) -> EdgeValue:
    """What stands outside for the values inside."""
    if edge.count:
        return tuple(values[name] for name in edge.members[: int(values[edge.count])])
    value = values[edge.name]
    return edge.row.choices[round(value)] if edge.row.spelled else edge.row.to_edge(value)


def _edges() -> dict[str, Edge]:
    found = {row.name: Edge(row.name, row.edge_unit, row.meaning, row.source, (row.name,)) for row in TABLE}
    for effect in EFFECTS.values():
        prefix = f'{effect.name}.'
        inside = {m for column in effect.columns for m in (*column.members, column.count)}
        for row in effect.parameters:
            if row.name not in inside:
                name = prefix + row.name
                unit = '' if row.spelled else row.edge_unit
                found[name] = Edge(name, unit, row.meaning, row.source, (name,))
        for column in effect.columns:
            name = prefix + column.name
            found[name] = Edge(
                name, column.unit, column.meaning, 'a table', tuple(prefix + m for m in column.members),
                prefix + column.count, f'{prefix}{column.follows}' if column.follows else '',
            )  # fmt: skip
    return found


EDGES: Mapping[str, Edge] = _edges()


def names(effect: str) -> list[str]:
    """What files and ROS have of an effect."""
    return [name for name in EDGES if name.startswith(f'{effect}.')]


def inside(given: Mapping[str, EdgeValue]) -> dict[str, float]:
    """The model's parameters for values from outside.

    Raises:
        BadInput: a word that is no choice, an array too short, too long, or not as long as the others of its effect.
    """
    values: dict[str, float] = {}
    lengths: dict[str, tuple[str, int]] = {}
    for name, value in given.items():
        edge = EDGES[name]
        if edge.count:
            numbers = read_numbers(name, value, edge.row.low, edge.row.high, edge.fewest, len(edge.members), edge.unit)
            other, length = lengths.setdefault(edge.count, (name, len(numbers)))
            if length != len(numbers):
                raise BadInput(
                    f"parameter '{name}' has {len(numbers)} numbers and '{other}' {length}; expected as many"
                )
            values |= dict(zip(edge.members, numbers, strict=False)) | {edge.count: float(length)}
        elif edge.row.spelled:
            if value not in edge.row.choices:
                raise BadInput(f"parameter '{name}' is '{value}'{nearest(str(value), edge.row.choices)}")
            values[name] = float(edge.row.choices.index(str(value)))
        else:
            assert isinstance(value, int | float)
            values[name] = edge.row.from_edge(float(value))
    check_whole(given)
    return values | _following(given, values)


def check_whole(given: Iterable[str]) -> None:
    """Raise BadInput where one array of a table is given and another, without which it is none, is not."""
    names = set(given)
    for name in names & EDGES.keys():
        for other in _together(name):
            if other not in names:
                raise BadInput(f"parameter '{name}' stands without '{other}'; expected both, or neither")


def _together(name: str) -> list[str]:
    """The arrays that an array is no table without."""
    count = EDGES[name].count
    return [edge.name for edge in EDGES.values() if count and edge.count == count and not edge.follows]


def _following(given: Mapping[str, EdgeValue], values: Mapping[str, float]) -> dict[str, float]:
    """Arrays that were not given and have the values of another that was."""
    taken: dict[str, float] = {}
    for edge in EDGES.values():
        if edge.follows in given and edge.name not in given:
            leader = EDGES[edge.follows].members
            taken |= {mine: values[his] for mine, his in zip(edge.members, leader, strict=True) if his in values}
    return taken


def read_numbers(
    name: str, value: object, low: float, high: float, fewest: int, most: int, unit: str = ''
) -> tuple[float, ...]:
    """An array from a file or from ROS.

    Raises:
        BadInput: it is none, has too few or too many numbers, or one is outside ``low`` to ``high``.
    """
    expected = f'expected {fewest} to {most} numbers, each {low:g} to {high:g} {unit}'.rstrip()
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise BadInput(f"parameter '{name}' is {value!r}; {expected}")
    numbers = list(value)
    if not fewest <= len(numbers) <= most:
        raise BadInput(f"parameter '{name}' has {len(numbers)} numbers; {expected}")
    for k, number in enumerate(numbers):
        if isinstance(number, bool) or not isinstance(number, int | float) or not low <= number <= high:
            raise BadInput(f"parameter '{name}': number {k + 1} is {number!r}; {expected}")
    return tuple(float(number) for number in numbers)


def outside(parameters: Parameters, name: str) -> EdgeValue:
    """A parameter as files and ROS see it. A derived one that was not given stays "derived"."""
    edge = EDGES[name]
    members = (*edge.members, *([edge.count] if edge.count else []))
    return of(edge, {m: parameters.given.get(m, SPECIFICATIONS[m].value) for m in members})

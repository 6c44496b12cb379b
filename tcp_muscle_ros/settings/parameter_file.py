"""ROS parameter YAML of a muscle, read and written without ROS.

The format is that of ``ros2 run ... --params-file``: a node pattern (``/**:``), ``ros__parameters:``, then names and
values. Effects' parameters may stand flat (``creep.J: 0.1``) or nested (``creep: {J: 0.1}``). Absolute temperatures
are in degC.
"""

import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import combinations
from math import isfinite
from pathlib import Path

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.files.inputs import read_text, why_unread
from tcp_muscle_ros.files.yaml_text import NotYaml, parse, quoted
from tcp_muscle_ros.muscle import EFFECTS, SETS, TABLE, Parameters
from tcp_muscle_ros.muscle.edges import EDGES, EdgeValue, inside, names, outside
from tcp_muscle_ros.settings.operating import MUSCLES, OPERATING, read_value

Value = float | int | bool | str | list[str] | tuple[float, ...]
Sections = dict[str, dict[str, object]]  # parameters by the pattern of the nodes that they are for


@dataclass(frozen=True)
class ParameterFile:
    """A parameter file: the muscle, and what else stood in it (operating parameters of the nodes, as written)."""

    parameters: Parameters
    operating: Mapping[str, Value] = field(default_factory=dict)

    def number(self, name: str) -> float:
        """An operating parameter that is a number, or its default."""
        row = OPERATING[name]
        if name not in self.operating and row.same_as:
            return self.number(row.same_as)
        return float(self.operating.get(name, row.default))  # type: ignore[arg-type]

    def text(self, name: str) -> str:
        """An operating parameter that is a word, or its default."""
        return str(self.operating.get(name, OPERATING[name].default))


def read(path: str | Path) -> ParameterFile:
    """Read a parameter file. Every name must be one that the package knows.

    Raises:
        BadInput: the file is missing or does not parse, a name is unknown, a value is no number or out of bounds.
    """
    if str(path) in SETS and not Path(path).exists():
        return ParameterFile(Parameters.named(str(path)))
    flat = _flatten(load(Path(path)), str(path))
    try:
        return from_names(flat)
    except BadInput as mistake:
        raise BadInput(f'{path}: ', *mistake.args) from None


def from_names(flat: Mapping[str, object]) -> ParameterFile:
    """A muscle from ROS names and edge values (degC for absolute temperatures). Raises BadInput as ``read``."""
    values: dict[str, EdgeValue] = {}
    operating: dict[str, Value] = {}
    effects: tuple[str, ...] = ()
    several = flat.get(MUSCLES) or []
    if several not in ([], ['']):
        raise BadInput(f"parameter '{MUSCLES}' = {several}: expected the parameters of one muscle, without '{MUSCLES}'")
    for name, value in flat.items():
        if name == 'effects':
            effects = _effects(value)
        elif name in EDGES:
            values[name] = _edge(name, value)
        elif name in OPERATING:
            operating[name] = _operating(name, value)
        else:
            raise BadInput(f"unknown parameter '{name}'{nearest(name, [*EDGES, *OPERATING, 'effects'])}")
    return ParameterFile(Parameters(inside(values), effects), operating)


def idle(given: Iterable[str], effects: Collection[str]) -> list[str]:
    """A sentence for each effect that has parameters among the names ``given`` and is not on: they do nothing."""
    unused: dict[str, list[str]] = {}
    for name in given:
        effect, dot, _ = name.partition('.')
        if dot and effect in EFFECTS and effect not in effects:
            unused.setdefault(effect, []).append(name)
    on = ', '.join(effects)
    return [
        f'{", ".join(names)} {"has" if len(names) == 1 else "have"} no effect: {effect} is not among effects: [{on}]'
        for effect, names in unused.items()
    ]


def given_names(parameters: Parameters) -> list[str]:
    """What a file stated of a muscle, as files name it."""
    return [name for name, edge in EDGES.items() if edge.members[0] in parameters.given]


def write(
    path: str | Path,
    parameters: Parameters,
    *,
    names: Iterable[str] | None = None,
    operating: Mapping[str, Value] | None = None,
    heading: Iterable[str] = (),
    note: Callable[[str], str] | None = None,
) -> None:
    """Write a parameter file that nodes and tools load.

    Args:
        path: the file; its folder exists.
        parameters: the muscle.
        names: which parameters to write; default all of the table that are set, and those of the effects that are on.
        operating: operating parameters to write as they are.
        heading: comment lines at the top.
        note: the comment behind a parameter; default its unit, meaning and source.
    """
    text = render(parameters, names=names, operating=operating, heading=heading, note=note)
    Path(path).write_text(text, encoding='utf-8')


def render(
    parameters: Parameters,
    *,
    names: Iterable[str] | None = None,
    operating: Mapping[str, Value] | None = None,
    heading: Iterable[str] = (),
    note: Callable[[str], str] | None = None,
) -> str:
    """The text that ``write`` writes."""
    chosen = default_names(parameters) if names is None else list(names)
    note = note or describe
    lines = [f'# {line}'.rstrip() for line in heading]
    lines += ['/**:', '  ros__parameters:', f'    effects: [{", ".join(parameters.effects)}]']
    if not parameters.effects:
        lines[-1] = "    effects: ['']  # none (ROS has no empty list of strings in YAML)"
    for name in chosen:
        lines.append(f'    {f"{name}: {_text(outside(parameters, name))}":<34} # {note(name)}')
    for name, setting in (operating or {}).items():
        lines.append(f'    {name}: {_text(setting)}')
    return '\n'.join(lines) + '\n'


def default_names(parameters: Parameters) -> list[str]:
    """The table's rows, then the parameters of the effects that are on."""
    return [row.name for row in TABLE] + [name for effect in parameters.effects for name in names(effect)]


def describe(name: str) -> str:
    """Unit, meaning and source of a parameter in one line."""
    edge = EDGES[name]
    return '; '.join(part for part in (edge.unit, edge.meaning, edge.source) if part)


def number_text(value: float) -> str:
    """A number as both ROS and YAML 1.1 read it as a float: always a point, before any exponent."""
    text = repr(float(value))
    mantissa, e, exponent = text.partition('e')
    return f'{mantissa if "." in mantissa else mantissa + ".0"}{e}{exponent}'


def _text(value: Value) -> str:
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if isinstance(value, float):
        return number_text(value)
    if isinstance(value, tuple):
        return f'[{", ".join(number_text(number) for number in value)}]'
    return _word(value) if isinstance(value, str) else str(value)


def _word(text: str) -> str:
    """A plain word bare, as people write it; quoted is what might be anything else: 7, on, null, nan, y (in ROS)."""
    plain = re.fullmatch('[A-Za-z_]{2,}', text) and as_ros_reads(parse(text)) == text
    return text if plain else quoted(text)


def load(path: Path) -> object:
    """The YAML in a file, whatever it holds. Raises BadInput where the file is missing or does not parse."""
    try:
        text = read_text(path)
    except (OSError, UnicodeDecodeError) as error:
        hint = nearest(str(path), SETS) if isinstance(error, FileNotFoundError) and not path.suffix else ''
        raise BadInput(f'{path}: cannot read the parameter file: {why_unread(error)}{hint}') from None
    try:
        return parse(text)
    except NotYaml as error:
        where = f' in line {error.at[0]}, column {error.at[1]}' if error.at else ''
        raise BadInput(f'{path}: does not parse as YAML{where}: {error}') from None


_EXPECTED = "expected '/**:', below it 'ros__parameters:', below that names and values"


def _flatten(content: object, path: str) -> dict[str, object]:
    if not isinstance(content, dict) or not content:
        raise BadInput(f'{path}: no parameters; {_EXPECTED}')
    flat: dict[str, object] = {}
    said: dict[str, list[tuple[str, object]]] = {}
    for node, body in content.items():
        if not isinstance(body, dict) or not isinstance(body.get('ros__parameters'), dict):
            raise BadInput(f"{path}: no 'ros__parameters' below '{node}'; {_EXPECTED}")
        values = _dotted(body['ros__parameters'])
        for name, value in values.items():
            said.setdefault(name, []).append((str(node), value))
        flat |= values
    for name, values_of in said.items():
        if name in EDGES or name == 'effects':
            _refuse_two_muscles(name, values_of, path)
    return flat


def _refuse_two_muscles(name: str, said: list[tuple[str, object]], path: str) -> None:
    """BadInput where two nodes have unlike values of a muscle's parameter. What is said for all nodes, as by ``/**``,
    may be said otherwise for one of them."""
    for (one, first), (other, second) in combinations(said, 2):
        patterns = f'/{one.strip("/")}', f'/{other.strip("/")}'
        one_of_all = fits(*patterns) or fits(*reversed(patterns))
        if not one_of_all and as_ros_reads(first) != as_ros_reads(second):
            raise BadInput(
                f"{path}: parameter '{name}' = {first} below '{one}' and {second} below '{other}': expected the "
                "parameters of one muscle; make a file of each muscle's"
            )


def _dotted(branch: Mapping[object, object], prefix: str = '') -> dict[str, object]:
    flat: dict[str, object] = {}
    for key, value in branch.items():
        if isinstance(value, dict):
            flat |= _dotted(value, f'{prefix}{key}.')
        else:
            flat[f'{prefix}{key}'] = value
    return flat


def values_for(path: Path, node: str) -> dict[str, object]:
    """What a file says to the node of this name, in whatever namespace: names with dots, values as ROS reads them.

    The file may hold sections of other nodes, and namespaces above them.

    Raises:
        BadInput: as ``load``, or a file without any parameters.
    """
    return values_in(sections(path), node)


def values_in(found: Sections, node: str) -> dict[str, object]:
    """What sections say to the node of this name, in whatever namespace."""
    return {name: value for values in sections_of(found, node).values() for name, value in values.items()}


def sections_of(found: Sections, node: str) -> Sections:
    """Those of the sections that may be for the node of this name, in whatever namespace."""
    return {pattern: values for pattern, values in found.items() if pattern.rpartition('/')[2] in ('**', '*', node)}


def sections(path: Path) -> Sections:
    """The parameters in a file by the pattern of the nodes that they are for, as ``/finger/sim_node`` or ``/**``.

    Patterns are as written, with or without a slash before them: to rcl, which keeps them in this order, they are two.

    Raises:
        BadInput: as ``load``, or a file without any parameters.
    """
    found: Sections = {}

    def search(branch: object, above: str) -> None:
        for key, below in branch.items() if isinstance(branch, dict) else ():
            if key == 'ros__parameters' and isinstance(below, dict):
                found[above[1:]] = {name: as_ros_reads(value) for name, value in _dotted(below).items()}
            else:
                search(below, f'{above}/{key}')

    search(load(path), '')
    if not found:
        raise BadInput(f'{path}: no parameters; {_EXPECTED}')
    return found


def fits(pattern: str, full_name: str) -> bool:
    """Whether a section is for the node of this full name; ``*`` stands for one part of it, ``**`` for any."""
    written = pattern.removeprefix('/').split('/')
    parts = [{'**': '(/[^/]+)*', '*': '/[^/]+'}.get(part, '/' + re.escape(part)) for part in written]
    return re.fullmatch(''.join(parts), full_name) is not None


def as_ros_reads(value: object) -> object:
    """YAML 1.1 takes 1e-4 for a word; ROS takes it for a number."""
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value


def _edge(name: str, value: object) -> EdgeValue:
    edge = EDGES[name]
    if edge.count and isinstance(value, list):
        return tuple(_number(name, number, edge.unit) for number in value)
    if edge.count:
        raise BadInput(f"parameter '{name}' = {value}: expected a list of numbers, such as {_text(edge.default)}")
    return str(value) if edge.row.spelled else _number(name, value, edge.row.edge_unit)


def _number(name: str, value: object, unit: str) -> float:
    if isinstance(value, str):  # YAML 1.1 takes 1e-4 for a word; ROS takes it for a number
        try:
            value = float(value)
        except ValueError:
            raise BadInput(f"parameter '{name}' = '{value}': expected a number in {unit}") from None
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise BadInput(f"parameter '{name}' = {value}: expected a finite number in {unit}")
    return float(value)


def _effects(value: object) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
        raise BadInput(f"parameter 'effects' = {value}: expected a list of names, such as [creep, thermocouple_lag]")
    return tuple(item for item in value if item)


def _operating(name: str, value: object) -> Value:
    row = OPERATING[name]
    return read_value(row, value if isinstance(row.default, str) else as_ros_reads(value))

"""What stands behind a node's name on the command line: nothing that is not understood goes by in silence."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path

from rclpy.utilities import remove_ros_args

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.yaml_text import NotYaml, parse
from tcp_muscle_ros.settings import parameter_file
from tcp_muscle_ros.settings.operating import OPERATING, TWIN, TWIN_NODE

_HELP = ('-h', '--help')
_Source = tuple[str, parameter_file.Sections]  # as people name it, and what it holds


def asks_for_help(arguments: Sequence[str]) -> bool:
    """Whether --help stands among them; the first is the program's name."""
    return any(argument in _HELP for argument in arguments[1:])


def usage(name: str) -> str:
    """What --help says of the node ``name``: how it is started, and its operating parameters with their defaults."""
    of_the_muscle = (
        '' if name == TWIN_NODE else ' (beside those of the muscle, `ros2 param describe` or docs/effects.md)'
    )
    lines = [
        f'usage: {name} [--ros-args [-r __ns:=/NAMESPACE] [--params-file FILE] [-p NAME:=VALUE ...]]',
        '',
        f'Parameters{of_the_muscle}:',
    ]
    for row in (*OPERATING.values(), *TWIN.values()):
        if name in row.owners:
            unit = '' if row.unit in ('', '1') else f' {row.unit}'
            lines.append(f'  {row.name:<26} {row.meaning} ({_default(row.default)}{unit})')
    return '\n'.join(lines)


def _default(value: object) -> str:
    """A default as people type it: no last bits of a product."""
    if isinstance(value, float):
        return str(float(f'{value:.9g}'))
    return repr(value) if isinstance(value, str) else str(value).lower()


def check_arguments(arguments: Sequence[str], name: str) -> None:
    """Refuse what rcl would read with fewer words, or read wrongly.

    Raises:
        BadInput: a ``--params-file`` that is missing, is no YAML or holds no parameters; a parameter of node ``name``
            given both as a whole number and as a decimal, or given last where it does not count.
    """
    given = list(_given(arguments))
    _refuse_two_kinds(given, name)
    _refuse_beaten(given, _full_name(arguments, name))


def _given(arguments: Sequence[str]) -> Iterator[_Source]:
    for flag, argument in pairwise(arguments):
        if flag == '--params-file':
            yield argument, parameter_file.sections(Path(argument))
        elif flag in ('-p', '--param'):
            yield f'-p {argument}', _on_the_command_line(argument)


def _refuse_two_kinds(given: Iterable[_Source], name: str) -> None:
    """Given a whole number in one place and a decimal in another, rcl takes the whole one whatever the order: a current
    limit of 0.1 A after a file that says 1 would be 1 A.
    """
    first: dict[str, tuple[type, str]] = {}
    for source, found in given:
        for key, value in parameter_file.values_in(found, name).items():
            if isinstance(value, int | float) and not isinstance(value, bool):
                kind, before = first.setdefault(key, (type(value), source))
                if kind is not type(value):
                    raise BadInput(
                        f"parameter '{key}' is given both as a whole number and as a decimal ({before}, {source}), and "
                        f'ROS would use the whole number: write both with a decimal point'
                    )


def _refuse_beaten(given: Iterable[_Source], full_name: str) -> None:
    """What is given last is meant to count, but rcl keeps one place for each pattern, in the order in which they first
    came, and takes a value from the last place: after a file with ``/**:`` and then ``sim_node:``, neither the ``/**:``
    of another file nor a ``-p`` (which is ``/**``) changes what ``sim_node:`` says.
    """
    places: dict[str, dict[str, tuple[object, str]]] = {}  # by pattern: each parameter's value and source
    last: dict[str, tuple[object, str]] = {}
    for source, found in given:
        for pattern, values in found.items():
            place = places.setdefault(pattern, {})
            if parameter_file.fits(pattern, full_name):
                said = {key: (value, source) for key, value in values.items()}
                place |= said
                last |= said
    taken = {key: (pattern, *said) for pattern, place in places.items() for key, said in place.items()}
    for key, (pattern, value, source) in taken.items():
        meant, by = last[key]
        if source != by and value != meant:
            name = full_name.strip('/')
            # A -p knows no namespaces.
            instead = f', or write -p {name}:{by[3:]}' if by.startswith('-p ') and '/' not in name else ''
            raise BadInput(
                f"parameter '{key}' = {_default(meant)} ({by}) would not count: ROS takes {_default(value)}, which is "
                f"below '{pattern}' ({source}); take it out there{instead}"
            )


def idle_files(arguments: Sequence[str], name: str) -> list[str]:
    """A sentence for each ``--params-file`` of which ROS takes nothing for this node: perhaps its limits stand there.

    Raises:
        BadInput: as ``check_arguments``.
    """
    full_name, sentences = _full_name(arguments, name), []
    for path in (Path(argument) for flag, argument in pairwise(arguments) if flag == '--params-file'):
        found = parameter_file.sections(path)
        if not any(parameter_file.fits(pattern, full_name) for pattern in found):
            sentences.append(
                f"{path}: nothing in it is for {full_name} ('/**:' would be); it is for {', '.join(found)}"
            )
    return sentences


def _full_name(arguments: Sequence[str], name: str) -> str:
    """The node's name in its namespace, as it is started: of two, rcl takes the first."""
    remapped: dict[str, str] = {}
    for argument in arguments:
        key, _, value = argument.removeprefix(f'{name}:').partition(':=')
        remapped.setdefault('__node' if key == '__name' else key, value)
    namespace = remapped.get('__ns', '').strip('/')
    return f'/{namespace}/{remapped.get("__node", name)}' if namespace else f'/{remapped.get("__node", name)}'


def _on_the_command_line(argument: str) -> parameter_file.Sections:
    key, _, text = argument.partition(':=')
    node, _, parameter = key.rpartition(':')
    try:
        return {node or '/**': {parameter: parameter_file.as_ros_reads(parse(text))}}
    except NotYaml:
        return {}  # rcl says so


def refuse_leftover(arguments: Sequence[str], name: str) -> None:
    """Raise BadInput for what rcl would leave alone: `sim_node -p current_limit_a:=0.1` would start with 0.27 A."""
    leftover = remove_ros_args(list(arguments))[1:]
    if leftover:
        hint = f'{name} --ros-args {" ".join(leftover)}' if leftover[0].startswith('-') else f'{name} --help'
        raise BadInput(f"argument '{leftover[0]}' is not understood; expected arguments of ROS: {hint}")

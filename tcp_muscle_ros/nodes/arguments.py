"""What stands behind a node's name on the command line: nothing that is not understood goes by in silence."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from rclpy.utilities import remove_ros_args

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.yaml_text import NotYaml, parse
from tcp_muscle_ros.settings import parameter_file
from tcp_muscle_ros.settings.operating import OPERATING, TWIN, TWIN_NODE

_HELP = ('-h', '--help')


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

    Given a whole number in one place and a decimal in another, rcl takes the whole one whatever the order: a current
    limit of 0.1 A after a file that says 1 would be 1 A.

    Raises:
        BadInput: a ``--params-file`` that is missing, is no YAML or holds no parameters; a parameter of node ``name``
            given both ways.
    """
    first: dict[str, tuple[type, str]] = {}
    for flag, argument in pairwise(arguments):
        if flag == '--params-file':
            given = parameter_file.values_for(Path(argument), name)
            source = argument
        elif flag in ('-p', '--param'):
            given = _on_the_command_line(argument, name)
            source = f'-p {argument}'
        else:
            continue
        for key, value in given.items():
            if isinstance(value, int | float) and not isinstance(value, bool):
                kind, before = first.setdefault(key, (type(value), source))
                if kind is not type(value):
                    raise BadInput(
                        f"parameter '{key}' is given both as a whole number and as a decimal ({before}, {source}), and "
                        f'ROS would use the whole number: write both with a decimal point'
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
    """The node's name in its namespace, as it is started."""
    remapped = dict(argument.split(':=', 1) for argument in arguments if argument.startswith(('__ns:=', '__node:=')))
    namespace = remapped.get('__ns', '').strip('/')
    return f'/{namespace}/{remapped.get("__node", name)}' if namespace else f'/{remapped.get("__node", name)}'


def _on_the_command_line(argument: str, name: str) -> dict[str, object]:
    key, _, text = argument.partition(':=')
    node, _, parameter = key.rpartition(':')
    if node not in ('', name):
        return {}
    try:
        return {parameter: parameter_file.as_ros_reads(parse(text))}
    except NotYaml:
        return {}  # rcl says so


def refuse_leftover(arguments: Sequence[str], name: str) -> None:
    """Raise BadInput for what rcl would leave alone: `sim_node -p current_limit_a:=0.1` would start with 0.27 A."""
    leftover = remove_ros_args(list(arguments))[1:]
    if leftover:
        hint = f'{name} --ros-args {" ".join(leftover)}' if leftover[0].startswith('-') else f'{name} --help'
        raise BadInput(f"argument '{leftover[0]}' is not understood; expected arguments of ROS: {hint}")

"""Arguments of launch files, checked before anything starts: launch itself lets a mistake in them go by in silence."""

import sys
from collections.abc import Collection, Iterable, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.files.inputs import read_text, why_unread
from tcp_muscle_ros.settings.operating import joint_in
from tcp_muscle_ros.settings.parameter_file import sections, sections_of, values_for

Row = tuple[str, str, str]  # name, default, meaning

FILE = 'params_file'
_NUMBERS = ('rate_hz', 'real_time_factor', 'current_limit_a', 'duration_s')
_SWITCHES = ('controller', 'auto_diagnose', 'auto_adopt')


def read_arguments(
    launch_file: str,
    rows: Iterable[Row],
    configurations: Mapping[str, str],
    argv: Sequence[str] | None = None,
    reads: Mapping[str, Iterable[str]] | None = None,
) -> dict[str, str]:
    """The values of a launch file's arguments, by name.

    Args:
        launch_file: the file's own path. Where it is the one that was launched, each NAME:=VALUE must be one of its
            arguments; within another launch file the names may be that one's.
        rows: what it declares.
        configurations: launch's, by name.
        argv: the command line; default the process's.
        reads: of each argument that is a parameter file, the names of the nodes that read it. Any other argument
            ``*_file`` has to be a file that can be read.

    Raises:
        BadInput: an unknown name, a file that cannot be read, a parameter file that holds nothing, no number where one
            belongs.
    """
    argv = sys.argv if argv is None else argv
    names = [name for name, _, _ in rows]
    if Path(launch_file).name in {Path(word).name for word in argv}:
        for word in argv:
            name, given, _ = word.partition(':=')
            if given and name not in names:
                raise BadInput(f"unknown launch argument '{name}'{nearest(name, names)}")
    values = {name: configurations[name] for name in names}
    for name in _NUMBERS:
        if values.get(name):
            number(name, values[name])
    for name in _SWITCHES:
        if name in values:
            switch(name, values[name])
    for name in names:
        if name.endswith('_file') and values[name]:
            _check_file(name, Path(values[name]), (reads or {}).get(name, ()))
    return values


def _check_file(name: str, path: Path, nodes: Iterable[str]) -> None:
    for node in nodes:
        values_for(path, node)
    if nodes:
        return
    try:
        read_text(path)
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f'{path}: cannot read the {name}: {why_unread(error)}') from None


def config_file(name: str) -> Path:
    """A file of config/ as this package has it."""
    return Path(__file__).resolve().parent.parent / 'config' / name


def parameters_of(values: Mapping[str, str], own: str = '') -> list[Any]:
    """The parameters that a node is started with, of which later ones win: its file, the rate, the joint's name.

    ``own`` is the file of config/ where the user gave none. An argument that the launch file does not declare says
    nothing; neither does an empty one.
    """
    file = values[FILE] or (str(config_file(own)) if own else '')
    parameters: list[Any] = [file] if file else []
    if values.get('rate_hz'):
        parameters.append({'rate_hz': number('rate_hz', values['rate_hz'])})
    if values.get('joint_name'):
        parameters.append({'joint_name': values['joint_name']})
    return parameters


def only_for_all_nodes(path: Path, node: str, names: Collection[str]) -> None:
    """Raise BadInput where a section other than ``/**`` says one of these to the node, or to one of its muscles.

    What a launch file says is ``/**``, and ROS may take such a section's values all the same.
    """
    for pattern, values in sections_of(sections(path), node).items():
        for name in values:
            if pattern != '/**' and name.rpartition('.')[2] in names:
                raise BadInput(f"{path}: '{name}' stands below '{pattern}': expected it below '/**' or not at all")


def joint_of(values: Mapping[str, str], node: str) -> str:
    """The joint of a node with one muscle, before it starts: the argument, else what the node will find by itself."""
    given = values_for(Path(values[FILE]), node) if values[FILE] else {}
    return values['joint_name'] or str(given.get('joint_name') or joint_in(values['namespace']))


def number(name: str, text: str) -> float:
    """The number that an argument is. Raises BadInput where it is none."""
    try:
        value = float(text)
    except ValueError:
        value = float('nan')
    if not isfinite(value):
        raise BadInput(f"launch argument '{name}' is '{text}'; expected a number")
    return value


def switch(name: str, text: str) -> bool:
    """Whether an argument is on. Raises BadInput where it is neither true nor false."""
    if text.lower() not in ('true', 'false', '1', '0'):
        raise BadInput(f"launch argument '{name}' is '{text}'; expected true or false")
    return text.lower() in ('true', '1')

"""Simulating, calibrating, diagnosing and drawing, as the commands of ``tcp_muscle`` do it."""

import os
import tempfile
import warnings
from argparse import Namespace
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import yaml

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.interface.results import Calibrated, Diagnosed, Picture
from tcp_muscle_ros.interface.sources import Source, recording_of
from tcp_muscle_ros.interface.wording import in_python
from tcp_muscle_ros.process.threads import with_one_of_linear_algebra
from tcp_muscle_ros.recording.frames import to_frame
from tcp_muscle_ros.recording.recording import Recording
from tcp_muscle_ros.settings.operating import DEFAULT_SET
from tcp_muscle_ros.settings.parameter_file import ParameterFile, from_names, given_names, idle, read, write
from tcp_muscle_ros.settings.rig import read_rig

if TYPE_CHECKING:
    import pandas as pd

Params: TypeAlias = str | Path | Mapping[str, object] | Calibrated | Diagnosed
Protocol: TypeAlias = str | Path | Mapping[str, object]


@in_python
def simulate(protocol: Protocol, params: Params = DEFAULT_SET, rig: str | Path | None = None) -> 'pd.DataFrame':
    """Run a protocol on a simulated muscle, as ``tcp_muscle simulate``.

    Args:
        protocol: a protocol file, or its content as a dict: ``rate_hz``, ``input``, ``segments`` ...
        params: a parameter file, a shipped set, what ``calibrate`` or ``diagnose`` returned, or names and values as in
            a file: ``{'hA': 0.02, 'effects': ['creep']}``; what is not given is as in the default set.
        rig: a ``rig.yaml``: what its instruments show is in the frame.

    Returns:
        A frame with all channels, sensor noise and quantisation as the parameters say.

    Raises:
        BadInput: the protocol, the parameters or the rig are not what they must be.

    Warns:
        UserWarning: what is not to be believed of it, or which parameters do nothing.
    """
    from tcp_muscle_ros.commands import simulate as command
    from tcp_muscle_ros.recording.bag import read_bag

    notes = _idle(params)
    with tempfile.TemporaryDirectory() as folder, _protocol_file(protocol, Path(folder)) as path:
        given = {'params': str(_params_file(params, Path(folder))), 'output': str(Path(folder) / 'simulated')}
        with redirect_stdout(StringIO()):
            command.run(Namespace(protocol=str(path), force=False, seed=None, rig=rig, **given), notes.append)
        for note in notes:
            warnings.warn(note, stacklevel=3)  # of who called it, past the words of the interface
        return to_frame(read_bag(given['output']))


@in_python
def calibrate(*recordings: Source, params: Params = DEFAULT_SET, separate: tuple[str, ...] = ()) -> Calibrated:
    """Fit the paper's parameters to recordings of one muscle, as ``tcp_muscle calibrate``.

    Args:
        recordings: frames, bags or lab files.
        params: where to start.
        separate: parameters that each recording has for itself (``B`` where every run is another specimen).

    Raises:
        BadInput: a recording is not what its channels are called, or nothing moves in it.
    """
    from tcp_muscle_ros.commands.calibrate import MOST, calibrated
    from tcp_muscle_ros.commands.progress import Progress
    from tcp_muscle_ros.process.compiling import tell_of_compiling

    tell_of_compiling()
    nominal = _parameters(params)
    with Progress('calibrating') as progress, with_one_of_linear_algebra():
        found = calibrated(_all(recordings), nominal, separate, MOST, progress.beat)
    return Calibrated(found, nominal.operating)


@in_python
def diagnose(
    *recordings: Source, params: Params = DEFAULT_SET, separate: tuple[str, ...] = (), rig: str | Path | None = None
) -> Diagnosed:
    """Say which physics recordings show that the model lacks, as ``tcp_muscle diagnose``.

    Args:
        recordings: frames, bags or lab files, of one muscle.
        params: the muscle as it is believed to be.
        separate: parameters that each recording has for itself, as of ``calibrate``.
        rig: a ``rig.yaml``: what is known of the instruments, and what the rig can do.

    Raises:
        BadInput: a recording is not what its channels are called.
    """
    from tcp_muscle_ros.commands.calibrate import refuse_unknown
    from tcp_muscle_ros.commands.one_diagnosis import diagnosed
    from tcp_muscle_ros.commands.progress import Progress
    from tcp_muscle_ros.process.compiling import tell_of_compiling

    tell_of_compiling()
    refuse_unknown(separate)
    nominal = _parameters(params)
    known = read_rig(rig) if rig else None
    with Progress('diagnosing') as progress, with_one_of_linear_algebra():
        found, experiments = diagnosed(_all(recordings), nominal, progress, separate, known)
    return Diagnosed(found, tuple(experiments), nominal.operating)


@in_python
def plot(*recordings: Source) -> Picture:
    """Draw recordings, channel above channel, as ``tcp_muscle plot``. BadInput: there is nothing to draw."""
    from tcp_muscle_ros.report.recording_figure import draw_recordings

    return Picture(draw_recordings(_all(recordings)))


def _all(recordings: tuple[Source, ...]) -> list[Recording]:
    if not recordings:
        raise BadInput('no recording; expected at least one frame, bag or file')
    if len({os.path.realpath(one) if isinstance(one, str | Path) else id(one) for one in recordings}) < len(recordings):
        raise BadInput(
            'a recording is given twice, and would count as how well the muscle repeats itself; give it once'
        )
    return [recording_of(source) for source in recordings]


def _parameters(params: Params) -> ParameterFile:
    if isinstance(params, Calibrated | Diagnosed):
        return params.file
    if isinstance(params, Mapping):
        try:
            return from_names(params)
        except BadInput as mistake:
            raise BadInput('params: ', *mistake.args) from None
    if not isinstance(params, str | Path):
        raise BadInput(
            f'params is {params!r:.60}; expected a parameter file, a shipped set, a dict of names and values, or what '
            'calibrate or diagnose returned'
        )
    return read(params)


@contextmanager
def _protocol_file(protocol: Protocol, folder: Path) -> Iterator[Path]:
    """A protocol as a file; what is wrong with one that is no file is said without the file's name."""
    if isinstance(protocol, str | Path):
        yield Path(protocol)
        return
    if not isinstance(protocol, Mapping):
        raise BadInput(f'protocol is {protocol!r:.60}; expected a file, or its content as a dict')
    path = folder / 'protocol'
    try:
        path.write_text(yaml.safe_dump(_plain(protocol)), encoding='utf-8')
    except yaml.YAMLError as error:
        raise BadInput(f'protocol: expected numbers, texts, lists and dicts ({error})') from None
    try:
        yield path
    except BadInput as mistake:
        raise mistake.replaced(str(path), 'protocol') from None


def _idle(params: Params) -> list[str]:
    """Which of the names that were given do nothing: a file that is made of them no longer has those."""
    if not isinstance(params, Mapping):
        return []
    muscle = _parameters(params).parameters
    return idle(given_names(muscle), muscle.effects)


def _plain(given: object) -> object:
    """What YAML can write of it: numbers of numpy are numbers."""
    if isinstance(given, Mapping):
        return {key: _plain(value) for key, value in given.items()}
    if isinstance(given, list | tuple):
        return [_plain(value) for value in given]
    return given.tolist() if isinstance(given, np.generic | np.ndarray) else given


def _params_file(params: Params, folder: Path) -> str | Path:
    if isinstance(params, str | Path):
        return params
    path = folder / 'params.yaml'
    if isinstance(params, Calibrated | Diagnosed):
        params.save(path)
    else:
        given = _parameters(params)
        write(path, given.parameters, operating=given.operating)
    return path

"""Where recordings come from: a bag, a lab's file, a DataFrame."""

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias, Union, cast

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.interface.wording import in_python
from tcp_muscle_ros.recording import options
from tcp_muscle_ros.recording.frames import of_frame, to_frame
from tcp_muscle_ros.recording.recording import Recording, channel_kind
from tcp_muscle_ros.recording.units import UNITS, unit_of

if TYPE_CHECKING:
    import pandas as pd

Source: TypeAlias = Union[str, Path, 'pd.DataFrame', Recording]

_BAGS = ('.mcap', '.db3', '.zstd')


@in_python
def load(
    source: Source,
    run: str | None = None,
    *,
    channels: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    namespace: str | None = None,
) -> 'pd.DataFrame':
    """A recording as a DataFrame.

    Args:
        source: a bag, a lab's file (CSV, text, .xlsx, .mat, .parquet), understood as by ``tcp_muscle import``, or a
            frame.
        run: the name of one run, where the file holds several.
        channels: which topic (``'/laser/range.range'``) or column of a frame is which channel, where its name does not
            say it: ``{'displacement': 'laser'}``.
        units: in which unit the numbers of a channel are, where that is another than they were taken to be in:
            ``{'displacement': 'mm'}``; a minus turns the sign, ``'-mm'``.
        namespace: where the muscle's topics are, if several namespaces of a bag have some.

    Returns:
        A frame with the index ``time_s``, a column a channel with its unit, and what is known of the run in ``attrs``.

    Raises:
        BadInput: it cannot be read or understood, its clock was set back, or it holds several runs and none was named.
    """
    if isinstance(source, str | Path) and _is_bag(Path(source)):
        from tcp_muscle_ros.recording.bag import read_bag

        return _to_frame(read_bag(source, namespace=namespace, channels=channels, units=units))
    if not isinstance(source, str | Path | Recording):
        for what, given in (('run', run), ('namespace', namespace)):
            if given is not None:
                raise BadInput(f'{what}={given!r}: a frame is one run of one muscle; expected it without {what}')
        return _to_frame(_taken_as(_of_frame(source, channels), units or {}))
    recording = recording_of(source, run)
    if channels:
        mend = 'a file has a map for it (tcp_muscle import --map)'
        raise BadInput(f'{recording.path}: channels name those of bags and frames; {mend}')
    return _to_frame(_taken_as(recording, units or {}))


def _to_frame(recording: Recording) -> 'pd.DataFrame':
    """A recording as a frame. BadInput where no model can follow it, which a frame could not tell."""
    if recording.broken:
        raise BadInput(f'{recording.path}: {recording.broken[0]}')
    return to_frame(recording)


def recording_of(source: Source, run: str | None = None) -> Recording:
    """A recording from wherever it is; otherwise as ``load``."""
    if isinstance(source, Recording):
        return source
    if not isinstance(source, str | Path):
        return _of_frame(source)
    path = Path(source)
    if _is_bag(path):
        from tcp_muscle_ros.recording.bag import read_bag

        return read_bag(path)
    runs = _runs_of(path)
    if run is None and len(runs) == 1:
        return next(iter(runs.values()))
    if run not in runs:
        what = f'holds {len(runs)} runs' if run is None else f"has no run '{run}'"
        raise BadInput(f"{path}: {what}; expected run='...'{nearest(run or '', runs)}")
    return runs[run]


def _of_frame(source: object, channels: Mapping[str, str] | None = None) -> Recording:
    if not (hasattr(source, 'columns') and hasattr(source, 'index')):
        raise BadInput(f'{source!r:.60} is no recording; expected a DataFrame, or the path of a bag or of a file')
    return of_frame(cast('pd.DataFrame', source), channels=channels)


def _is_bag(path: Path) -> bool:
    return path.is_dir() or path.suffix in _BAGS or not (path.exists() or path.suffix)


def _taken_as(recording: Recording, units: Mapping[str, str]) -> Recording:
    """The recording with a channel's numbers taken in another unit."""
    channels = dict(recording.channels)
    for name, unit in units.items():
        kind = channel_kind(name, options.UNIT)
        if kind.name not in channels:
            raise BadInput(
                options.unit(name), f': {recording.path} has no channel of this name{nearest(name, channels)}'
            )
        quantity, channel = UNITS[kind.unit].quantity, channels[kind.name]
        was = unit_of(recording.unit(kind.name), quantity, recording.path)
        right = unit_of(unit, quantity, options.unit(name))
        channels[kind.name] = replace(channel, value=right.to_si(was.from_si(channel.value)))
    return replace(recording, channels=channels)


def _runs_of(path: Path) -> dict[str, Recording]:
    """The runs of a lab's file by name."""
    from tcp_muscle_ros.files.outputs import IMPORT_MAP
    from tcp_muscle_ros.recording.csv_import import import_runs, lab_files
    from tcp_muscle_ros.recording.import_map import read_import_map
    from tcp_muscle_ros.recording.lab.draft_map import map_text
    from tcp_muscle_ros.recording.lab.guess import guess

    (path,) = lab_files([path])
    with tempfile.TemporaryDirectory() as folder:
        import_map = Path(folder) / IMPORT_MAP
        import_map.write_text(map_text({path: guess(path)}, import_map), encoding='utf-8')
        return {each.name: each.recording for each in import_runs(read_import_map(import_map), [path])}

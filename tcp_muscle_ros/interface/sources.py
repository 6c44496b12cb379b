"""Where recordings come from: a bag, a lab's file, a DataFrame."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias, Union

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.recording.frames import of_frame, to_frame
from tcp_muscle_ros.recording.recording import Recording

if TYPE_CHECKING:
    import pandas as pd

Source: TypeAlias = Union[str, Path, 'pd.DataFrame', Recording]

_BAGS = ('.mcap', '.db3', '.zstd')


def load(source: Source, run: str | None = None) -> 'pd.DataFrame':
    """A recording as a DataFrame.

    Args:
        source: a bag, or a lab's file (CSV, text, .xlsx, .mat, .parquet), understood as by ``tcp_muscle import``.
        run: the name of one run, where the file holds several.

    Returns:
        A frame with the index ``time_s``, a column a channel with its unit, and what is known of the run in ``attrs``.

    Raises:
        BadInput: it cannot be read or understood, or holds several runs and none was named.
    """
    return to_frame(recording_of(source, run))


def recording_of(source: Source, run: str | None = None) -> Recording:
    """A recording from wherever it is; otherwise as ``load``."""
    if isinstance(source, Recording):
        return source
    if not isinstance(source, str | Path):
        return of_frame(source)
    path = Path(source)
    if path.is_dir() or path.suffix in _BAGS or not path.exists():
        from tcp_muscle_ros.recording.bag import read_bag

        return read_bag(path)
    runs = _runs_of(path)
    if run is None and len(runs) == 1:
        return next(iter(runs.values()))
    if run not in runs:
        what = f'holds {len(runs)} runs' if run is None else f"has no run '{run}'"
        raise BadInput(f"{path}: {what}; expected run='...'{nearest(run or '', runs)}")
    return runs[run]


def _runs_of(path: Path) -> dict[str, Recording]:
    """The runs of a lab's file by name."""
    from tcp_muscle_ros.files.outputs import IMPORT_MAP
    from tcp_muscle_ros.recording.csv_import import import_runs
    from tcp_muscle_ros.recording.import_map import read_import_map
    from tcp_muscle_ros.recording.lab.draft_map import map_text
    from tcp_muscle_ros.recording.lab.guess import guess

    with tempfile.TemporaryDirectory() as folder:
        import_map = Path(folder) / IMPORT_MAP
        import_map.write_text(map_text({path: guess(path)}, import_map), encoding='utf-8')
        return {each.name: each.recording for each in import_runs(read_import_map(import_map), [path])}

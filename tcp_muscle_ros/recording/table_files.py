"""A table of channels as CSV or Parquet, which ``tcp_muscle import`` reads back without a map."""

import csv
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tcp_muscle_ros.errors import BadInput, install
from tcp_muscle_ros.recording.frames import TIME
from tcp_muscle_ros.recording.recording import Array

_DIGITS = 9  # significant ones; more than any instrument has, but not than the time of a long recording


def write_csv(path: Path, time: Array, columns: Mapping[str, Array]) -> None:
    """The columns below their names, ``time_s`` first; a cell is empty where a channel has no sample."""
    with path.open('w', encoding='utf-8', newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow([TIME, *columns])
        for at, *row in zip(time, *columns.values(), strict=True):
            cells = (f'{cell:.{_DIGITS}g}' if np.isfinite(cell) else '' for cell in row)
            writer.writerow([_to_the_nanosecond(at), *cells])


def _to_the_nanosecond(time: float) -> str:
    """As a bag has it: of fewer digits the rows of several topics would come to share a time."""
    return f'{time:.9f}'.rstrip('0').rstrip('.')


def write_parquet(path: Path, time: Array, columns: Mapping[str, Array]) -> None:
    """The same as float64 columns, null where a channel has no sample. BadInput: pyarrow is not installed."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ModuleNotFoundError:
        raise BadInput(f'Parquet needs pyarrow: {install("labs")}') from None
    arrays = {name: pyarrow.array(values, mask=~np.isfinite(values)) for name, values in columns.items()}
    pyarrow.parquet.write_table(pyarrow.table({TIME: time, **arrays}), path)

"""Spreadsheets (.xlsx), MATLAB files (.mat, version 7 and older) and Parquet as rows of text cells."""

import datetime
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from tcp_muscle_ros.errors import BadInput, install
from tcp_muscle_ros.recording.lab.grid import Grid, Row
from tcp_muscle_ros.recording.lab.headings import meaning

KINDS = ('.xlsx', '.xlsm', '.mat', '.parquet')
_UNITS = ('units', 'unit', 'einheiten', 'einheit')
_EXTRA = f'which is not installed: {install("labs")}'


def is_binary(path: Path) -> bool:
    """Is it of these kinds, whose cells nothing can part in another way? Any other is a text file."""
    return path.suffix.lower() in KINDS


def read_sheets(path: Path) -> list[Grid]:
    """Every sheet, struct or table of a binary file.

    BadInput: the file is not what its name says, or the library for its kind is not installed.
    """
    kind = path.suffix.lower()
    try:
        return _matlab(path) if kind == '.mat' else _parquet(path) if kind == '.parquet' else _excel(path)
    except ModuleNotFoundError as error:
        raise BadInput(f"{path}: {kind} files need the Python package '{error.name}', {_EXTRA}") from None
    except BadInput:
        raise
    except Exception as error:  # a damaged file makes each library stumble in another way
        why = str(getattr(error, 'strerror', None) or error or type(error).__name__).partition('\n')[0]
        raise BadInput(f'{path}: cannot be read as {kind} ({why})') from None


def _text(value: object) -> str:
    """A cell as text that reads back as the same number."""
    if value is None:
        return ''
    if isinstance(value, bool | np.bool_):
        return str(int(value))
    if isinstance(value, float | np.floating):
        text = repr(float(value)) if np.isfinite(value) else ''
        return f'{text}0' if re.fullmatch(r'-?\d+\.\d{3}', text) else text  # 1.2340: no thousands beside any text
    if isinstance(value, np.datetime64):
        return str(value).replace('T', ' ')
    if isinstance(value, datetime.datetime):
        return value.isoformat(' ')
    if isinstance(value, datetime.timedelta):
        return repr(value.total_seconds())
    return str(value).strip()


def _excel(path: Path) -> list[Grid]:
    from zipfile import BadZipFile

    import openpyxl

    try:
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
    except (BadZipFile, KeyError, ValueError, openpyxl.utils.exceptions.InvalidFileException):
        raise BadInput(f'{path}: is no .xlsx workbook; if it is text, rename it to .csv') from None
    grids = []
    for sheet in book.worksheets:
        rows = (Row(k, tuple(map(_text, cells))) for k, cells in enumerate(sheet.iter_rows(values_only=True), 1))
        grids.append(Grid(tuple(rows), sheet.title))
    book.close()
    return grids


def _parquet(path: Path) -> list[Grid]:
    import pyarrow
    import pyarrow.parquet

    try:
        table = pyarrow.parquet.read_table(path)
    except pyarrow.ArrowInvalid:
        raise BadInput(f'{path}: is no .parquet file; if it is text, rename it to .csv') from None
    return [_of_columns({name: table.column(name).to_numpy(zero_copy_only=False) for name in table.column_names}, '')]


def _of_columns(columns: Mapping[str, Any], sheet: str, units: Sequence[str] = ()) -> Grid:
    """Columns as a sheet, the headings in row 1, and in row 2 what the units are. A shorter one ends in empty cells."""
    kept, notes = _timed(columns)
    rows = [Row(1, tuple(kept))]
    if units:
        of = dict(zip(columns, units, strict=True))
        rows.append(Row(2, tuple(of[name] for name in kept)))
    cells = zip_longest(*([_text(each) for each in column] for column in kept.values()), fillvalue='')
    rows += [Row(k, row) for k, row in enumerate(cells, len(rows) + 1)]
    return Grid(tuple(rows), sheet, tuple(notes))


def _timed(columns: Mapping[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """The columns that go by a time of their own length, and a note on the others.

    Those beside the time with the most channels come first. Of another length is kept what is not yet among them, its
    time before it. Where nothing is a time those are kept that are as long as the longest.
    """
    means = {name: meaning(name).kind for name in columns}
    by_length: dict[int, list[str]] = {}
    for name in sorted(columns, key=lambda name: -len(columns[name])):  # stable
        by_length.setdefault(len(columns[name]), []).append(name)
    timed = [group for group in by_length.values() if any(means[name] == 'time' for name in group)]
    timed.sort(key=lambda group: -len({means[name] for name in group} - {''}))
    kept = timed[0] if timed else next(iter(by_length.values()), [])
    for group in timed[1:]:
        time = next(name for name in group if means[name] == 'time')
        known = {'', 'time', *(means[name] for name in kept)}
        if new := [name for name in group if means[name] not in known]:
            kept = [*kept, time, *new]
    others = [f'{name} ({len(column)})' for name, column in columns.items() if name not in kept]
    told = f'left out, being of another length than the times, or there already: {", ".join(others)}'
    return {name: columns[name] for name in kept}, [told] if others else []


def _matlab(path: Path) -> list[Grid]:
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    _refuse_deadly(path)
    try:
        content = loadmat(path, simplify_cells=True)
    except NotImplementedError:
        raise BadInput(f"{path}: is a MATLAB file of version 7.3; save it with '-v7' in MATLAB") from None
    except (MatReadError, ValueError, TypeError):
        raise BadInput(f'{path}: is no MATLAB file of version 7 or older') from None
    content = {name: value for name, value in content.items() if not name.startswith('__')}
    return list(_tables(content, ''))


def _refuse_deadly(path: Path) -> None:
    """BadInput for a damaged file that scipy's compiled reader does not survive: another process tries it first."""
    about = path.stat()
    if not _survives(str(path), about.st_mtime_ns, about.st_size):
        raise BadInput(f'{path}: is a damaged MATLAB file; save it again')


@lru_cache
def _survives(path: str, changed_ns: int, size: int) -> bool:
    """Does a process that reads a MATLAB file live on? ``changed_ns`` and ``size`` tell its states apart."""
    program = 'import sys; from scipy.io import loadmat; loadmat(sys.argv[1])'
    return subprocess.run([sys.executable, '-c', program, path], capture_output=True, check=False).returncode >= 0


def _tables(content: Mapping[str, Any], name: str, units: Sequence[object] = ()) -> Iterator[Grid]:
    """The tables in a struct: its own columns, those of the structs in it, and those of arrays of structs.

    ``units`` are those of the columns, where a list of texts beside them has as many.
    """
    columns = dict(_columns(content))
    units = next((value for key, value in content.items() if key.lower() in _UNITS and _is_texts(value)), units)
    if columns:
        yield _of_columns(columns, name, [str(unit) for unit in units] if len(units) == len(columns) else [])
    for key, value in content.items():
        full = f'{name}.{key}' if name else key
        if isinstance(value, dict):
            yield from _tables(value, full, units)
        elif key != 'signals' and _is_structs(value):
            for k, each in enumerate(value, 1):
                yield from _tables(each, f'{full}({k})', units)


def _is_texts(value: object) -> bool:
    return isinstance(value, list | np.ndarray) and len(value) > 0 and all(isinstance(each, str) for each in value)


def _is_structs(value: object) -> bool:
    return isinstance(value, list | np.ndarray) and len(value) > 0 and all(isinstance(each, dict) for each in value)


def _columns(content: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """The vectors of a struct; a matrix column by column; Simulink's signals by their labels."""
    for name, value in content.items():
        if name == 'signals':
            for signal in [value] if isinstance(value, dict) else value:
                values = np.atleast_1d(np.squeeze(np.asarray(signal.get('values', []))))
                yield str(signal.get('label') or name), values
        elif isinstance(value, np.ndarray) and value.dtype.kind in 'fiu' and value.size > 1:
            if value.ndim == 1:
                yield name, value
            elif value.ndim == 2:
                matrix = value if value.shape[0] >= value.shape[1] else value.T
                yield from ((f'{name}({k + 1})', column) for k, column in enumerate(matrix.T))

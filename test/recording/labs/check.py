"""What an import without a map makes of one lab file, beside what it must find."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from recording.labs.bench import Expected, LabFile

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.csv_import import import_runs
from tcp_muscle_ros.recording.import_map import read_import_map
from tcp_muscle_ros.recording.lab.draft_map import map_text
from tcp_muscle_ros.recording.lab.guess import guess
from tcp_muscle_ros.recording.recording import CHANNELS, Recording
from tcp_muscle_ros.recording.units import UNITS


def imported(path: Path, folder: Path) -> list[Recording]:
    """The runs of a file, by the map that was made of it."""
    import_map = folder / 'import_map.yaml'
    import_map.write_text(map_text({path: guess(path)}, import_map), encoding='utf-8')
    return [run.recording for run in import_runs(read_import_map(import_map), [path])]


def wrong(file: LabFile, folder: Path) -> str:
    """What is wrong with the import of a lab file; '' where it is as it must be."""
    content, expected = file.make()
    path = folder / file.name
    path.write_bytes(content)
    try:
        runs = imported(path, folder)
    except BadInput as error:
        said = str(error)
        if not file.missing:
            return f'refused: {said}'
        if '\n' in said or not all(word in said for word in file.missing):
            return f'the line does not say {file.missing}: {said}'
        return ''
    if file.missing:
        return f'imported {len(runs)} run(s), but {file.missing} cannot be known'
    if len(runs) != len(expected):
        return f'{len(runs)} run(s), expected {len(expected)}'
    return '; '.join(filter(None, map(_differs, runs, expected)))


def _differs(run: Recording, expected: Expected) -> str:
    if set(run.channels) != set(expected.channels):
        return f'channels {sorted(run.channels)}, expected {sorted(expected.channels)}'
    rows = len(np.unique(np.concatenate([channel.time for channel in run.channels.values()])))
    if rows != expected.rows or abs(run.duration - expected.duration) > 1e-6:
        return f'{rows} rows over {run.duration:.7g} s, expected {expected.rows} over {expected.duration:.7g} s'
    for name, ends in expected.channels.items():
        value = UNITS[CHANNELS[name].unit].from_si(run[name].value)
        if not np.allclose((value[0], value[-1]), ends, rtol=1e-9, atol=1e-9):
            return f'{name} from {value[0]:.7g} to {value[-1]:.7g}, expected {ends[0]:.7g} to {ends[1]:.7g}'
    return ''


# What only the lab knows, and the line with which a file must therefore be refused.
UNKNOWN = {
    'COM5_log3.csv': 'no headings above row 1',
    'scope_12.csv': "voltage: 2 columns could be it ('Volt' (1) in V, 'Volt' (2) in V)",
    'NewFile3.csv': "voltage: 2 columns could be it ('CH1 Volt' in V, 'CH2 Volt' in V)",
    'data.mat': "no time: none of the columns 'data(1)', 'data(2)', 'data(3)' is one",
    'tracker_massA.txt': "displacement: 2 columns could be it ('x' in ?, 'y' in ?)",
}
# A channel that cannot be scaled is left out and said to be; a logger's cold junction is not the room's thermometer.
LEFT_OUT = {'230412-130215.CSV': 'displacement', 'tek0004ALL.csv': 'displacement', 'PicoLog6-export.csv': 'ambient'}


def wrong_by_another(path: Path, entry: Mapping[str, Any], folder: Path) -> str:
    """What is wrong with the import of a file of ``by_another``; '' where it is as its author reads it."""
    try:
        runs = imported(path, folder)
    except BadInput as error:
        said = str(error)
        return '' if '\n' not in said and UNKNOWN.get(path.name, '?') in said else f'refused: {said}'
    if path.name in UNKNOWN:
        return f'imported, but nobody can know: {entry["missing"]}'
    channels = {name: of for name, of in entry['channels'].items() if name != LEFT_OUT.get(path.name)}
    found = {'load' if name == 'force' else name: run for name, run in runs[0].channels.items()}  # its author's word
    if len(runs) != entry['runs'] or set(found) != set(channels):
        return f'{len(runs)} run(s) of {sorted(found)}, expected {entry["runs"]} of {sorted(channels)}'
    said = [f'{name}: {what}' for name in channels if (what := _values(found[name].value, channels[name]))]
    for run, rows, duration in zip(runs, entry['rows'], entry['duration_s'], strict=True):
        count = len(np.unique(np.concatenate([channel.time for channel in run.channels.values()])))
        if path.name not in LEFT_OUT and count != rows:
            said.append(f'{count} rows, expected {rows}')
        if abs(run.duration - duration) > 1e-3:
            said.append(f'lasts {run.duration} s, expected {duration}')
    return '; '.join(said)


def _values(value: Any, expected: Mapping[str, Any]) -> str:
    """First, largest, least and last value and their number; of a distance, the contraction from the first on."""
    first, high, low, last = (expected[f'{which}_si'] for which in ('first', 'max', 'min', 'last'))
    if 'distance' in expected.get('note', ''):
        first, high, low, last = 0.0, first - low, first - high, first - last
    shown = (value[0], value.max(), value.min(), value[-1])
    if len(value) == expected['valid_rows'] and np.allclose(shown, (first, high, low, last), rtol=2e-6, atol=2e-9):
        return ''
    return f'{shown} in {len(value)} rows, expected {(first, high, low, last)} in {expected["valid_rows"]}'

"""What an import without a map makes of one lab file, beside what it must find."""

from pathlib import Path

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

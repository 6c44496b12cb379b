"""What the gate of `diagnose`, `replay` and `calibrate` refuses: sound recordings (it must not), and damaged ones.

    python -m proof.gate [--cases 43] [--seed 31] [--data ../shared/data] [--write]

Sound are those of all suites of the truth generator (every kind of case, every lab), and every run of the public rigs
where they are at hand. Each of the generator's is then damaged in each way of the table. Prints the table of
docs/recording.md; with --write puts it there.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from proof.cases import SUITES
from proof.generate import generate
from tcp_muscle_ros.diagnosis.observation.observe import prepared
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.csv_import import import_runs, lab_files
from tcp_muscle_ros.recording.import_map import read_import_map
from tcp_muscle_ros.recording.recording import CHANNELS, DRIVES, Recording
from tcp_muscle_ros.recording.units import UNITS
from tcp_muscle_ros.report.marked import replace_marked
from tcp_muscle_ros.report.tables import table
from tcp_muscle_ros.settings.parameter_file import ParameterFile, read

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / 'docs' / 'recording.md'
Damage = Callable[[Recording], Recording]


def refusal(recording: Recording, file: ParameterFile) -> str | None:
    """The line with which the gate refuses a recording, or None."""
    try:
        prepared([recording], file)
    except BadInput as error:
        return str(error)
    return None


def changed(name: str, change: Callable[[np.ndarray], np.ndarray]) -> Damage:
    """The channel's values (SI) changed; the recording as it is where it has none."""

    def damage(recording: Recording) -> Recording:
        channel = recording.channels.get(name)
        if channel is None:
            return recording
        return replace(recording, channels={**recording.channels, name: replace(channel, value=change(channel.value))})

    return damage


def in_unit(name: str, unit: str) -> Damage:
    """Recorded in that unit and taken for the contract's."""
    said = UNITS[CHANNELS[name].unit]
    return changed(name, lambda value: said.to_si(UNITS[unit].from_si(value)))


def without_rest(recording: Recording) -> Recording:
    """From the first heating on."""
    drive = next(recording[name] for name in DRIVES if name in recording)
    on = float(drive.time[int(np.argmax(np.abs(drive.value) > 0.1 * np.max(np.abs(drive.value))))])
    kept = {}
    for name, c in recording.channels.items():
        later = c.time >= on
        if later.any():
            kept[name] = replace(c, time=c.time[later] - on, value=c.value[later])
    return replace(recording, channels=kept)


DAMAGES: dict[str, tuple[str, Damage]] = {
    'current in mA': ('current', in_unit('current', 'mA')),
    'power in mW': ('power', in_unit('power', 'mW')),
    'voltage in mV': ('voltage', in_unit('voltage', 'mV')),
    'temperature in degF': ('temperature', in_unit('temperature', 'degF')),
    'temperature in degF, no rest': ('temperature', lambda r: in_unit('temperature', 'degF')(without_rest(r))),
    'temperature in K': ('temperature', in_unit('temperature', 'K')),
    'displacement in mm': ('displacement', in_unit('displacement', 'mm')),
    'displacement as length': ('displacement', changed('displacement', lambda value: 0.1 - value)),
    'load in g': ('load', in_unit('load', 'g')),
    'resistance in mohm': ('resistance', in_unit('resistance', 'mohm')),
    'force in g': ('force', in_unit('force', 'g')),
    'force as compression': ('force', changed('force', np.negative)),
}


def sound(cases: int, seed: int) -> Iterator[tuple[str, Recording, ParameterFile]]:
    """Every recording of suites drawn anew: (suite, recording, parameters)."""
    for suite in SUITES:
        with tempfile.TemporaryDirectory() as folder:
            made = Path(folder) / 'bags'
            generate(suite, cases, seed, made, Path(folder) / 'labels.json', jobs=1)
            for case in sorted(made.glob('case_*')):
                own = case / 'parameters.yaml'
                file = read(own if own.exists() else 'karami_tadesse_2017')
                for bag in sorted(case.glob('recording_*')):
                    yield suite, read_bag(bag), file


def rigs(data: Path) -> Iterator[tuple[str, Recording, ParameterFile]]:
    """Every run of the public rigs."""
    file = read('karami_tadesse_2017')
    for rig in ('bench', 'video'):
        import_map = read_import_map(ROOT / 'config' / f'import_tca_{rig}_rig.yaml')
        for run in import_runs(import_map, lab_files([data / f'tca_{rig}_rig'])):
            yield f'{rig} rig', run.recording, file


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--cases', type=int, default=43, help='of each suite')
    parser.add_argument('--seed', type=int, default=31)
    parser.add_argument('--data', type=Path, default=ROOT.parent / 'shared' / 'data')
    parser.add_argument('--write', action='store_true', help='put the table into docs/recording.md')
    chosen = parser.parse_args()
    counts: dict[str, list[int]] = {}
    sources = [sound(chosen.cases, chosen.seed)] + ([rigs(chosen.data)] if chosen.data.is_dir() else [])
    for source in sources:
        for group, recording, file in source:
            _count(counts, f'sound, {group}', refusal(recording, file))
            for name, (channel, damage) in DAMAGES.items() if group in SUITES else ():
                if channel in recording:
                    _count(counts, name, refusal(damage(recording), file), quiet=True)
    today = datetime.now(UTC).date()
    rows = [[name, str(total), str(refused)] for name, (total, refused) in counts.items()]
    text = table(['recordings', 'looked at', 'refused'], rows)
    command = f'`python -m proof.gate --cases {chosen.cases} --seed {chosen.seed}` ({today})'
    print(f'{command}\n{text}')
    if chosen.write:
        lines = ['| recordings | looked at | refused |', '|---|---|---|', *(f'| {" | ".join(row)} |' for row in rows)]
        replace_marked(PAGE, 'gate', '\n'.join([f'{command}:', '', *lines]))
    return int(any(refused for name, (_, refused) in counts.items() if name.startswith('sound')))


def _count(counts: dict[str, list[int]], name: str, line: str | None, *, quiet: bool = False) -> None:
    entry = counts.setdefault(name, [0, 0])
    entry[0] += 1
    entry[1] += line is not None
    if line is not None and not quiet:
        print(f'{name}: {line}', flush=True)


if __name__ == '__main__':
    sys.exit(main())

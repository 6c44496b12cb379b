"""Damaged inputs for every command of the tool, and what it does with them up to the end of its gate.

    python -m proof.mutate [--count 1000] [--first 0] [--write]

Each trial takes good inputs (a bag, a lab's CSV with its map, a protocol, parameters with intervals, a manifest,
options), damages one or two of them, and runs the command in this process until its inputs are admitted. It must end
with exit code 0 or 2, say what is wrong in one line, and leave every file that was there as it was. Prints the table of
docs/recording.md; with --write puts its rows there.
"""

import argparse
import contextlib
import hashlib
import io
import os
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from tcp_muscle_ros.recording.bag_writer import write_recording
from tcp_muscle_ros.recording.recording import Channel, Recording
from tcp_muscle_ros.report.marked import replace_marked
from tcp_muscle_ros.tool import main as tool

PAGE = Path(__file__).resolve().parent.parent / 'docs' / 'recording.md'
START = 1_700_000_000_000_000_000
PROTOCOL = """rate_hz: 20
input: current
end: load
repeat: 2
load_n: 0.6
segments:
  - {duration_s: 10, value: 0.25, load_n: 0.5884, ambient_c: 23}
  - {duration_s: 5, value: [0.25, 0]}
"""
PARAMETERS = """/**:
  ros__parameters:
    effects: [creep, natural_convection]
    hA: 0.022
    R0: 13.0
    creep.J: 0.1
    load_n: 0.5884
    ambient_temperature_c: 23.0
    temperature_noise_k: 0.2
"""
INTERVALS = """{"schema": "tcp_muscle_ros/calibration-1", "parameters": [],
 "coordinates": [{"name": "hA", "log": true, "spread": 1.5}, {"name": "c2", "log": false, "spread": 4e-4}],
 "covariance": [[0.01, 0.0], [0.0, 1e-6]]}
"""
CSV = 'time (s),I (mA),T (degC),stroke (mm)\n' + ''.join(
    f'{k / 5:.1f},{250 * (k % 60 > 20)},{23 + k % 60 * 0.4:.2f},{k % 60 * 0.05:.3f}\n' for k in range(240)
)
MAP = """time: {column: time (s), unit: s}
columns:
  temperature: {column: T (degC), unit: degC}
  displacement: {column: stroke (mm), unit: mm, offset: first}
input:
  current: {column: I (mA), unit: mA}
known: {load_n: 0.5884}
runs:
  - {file: '*.csv', name: '{stem}'}
"""
RIG = """instruments:
  temperature: {lag_s: {value: 1.2, low: 1.0, high: 1.5}, gain: 0.96}
  displacement: {delay_s: 0.1}
limits: {largest_current_a: 0.27, loads_n: [0.5884, 0.6], loads_by: rig, longest_run_s: 900}
"""
MANIFEST = """runs:
  - {name: thumb_0, bags: [bag], params: muscle.yaml, muscle: thumb, cycles: 12, day: 2026-03-01}
  - {name: thumb_1, bags: [bag, bag]}
"""
ANSWERS = '500\n150\n14.2\n'
FILES = {
    'protocol.yaml': PROTOCOL,
    'muscle.yaml': PARAMETERS,
    'muscle.intervals.json': INTERVALS,
    'run.csv': CSV,
    'map.yaml': MAP,
    'rig.yaml': RIG,
    'runs.yaml': MANIFEST,
    'answers.txt': ANSWERS,
}
# Command lines on good inputs, with the inputs that matter to each.
COMMANDS: dict[str, tuple[list[str], list[str]]] = {
    'simulate': (
        ['protocol.yaml', '--params', 'muscle.yaml', '--output', 'new', '--seed', '3'],
        ['protocol.yaml', 'muscle.yaml'],
    ),
    'run': (
        ['protocol.yaml', '--params', 'muscle.yaml', '--rig', 'rig.yaml', '--output', 'new', '--yes'],
        ['protocol.yaml', 'muscle.yaml', 'rig.yaml'],
    ),
    'investigate': (
        ['--simulated', 'muscle.yaml', '--rig', 'rig.yaml', '--first', 'protocol.yaml', '--output', 'new'],
        ['muscle.yaml', 'rig.yaml', 'protocol.yaml'],
    ),
    'import': (['run.csv', '--map', 'map.yaml', '--output', 'new'], ['run.csv', 'map.yaml']),
    'calibrate': (['bag', '--params', 'muscle.yaml', '--output', 'new.yaml'], ['bag', 'muscle.yaml']),
    'replay': (
        ['bag', '--params', 'muscle.yaml', '--rig', 'rig.yaml', '--output', 'new', '--figure', 'new.png'],
        ['bag', 'muscle.yaml', 'muscle.intervals.json', 'rig.yaml'],
    ),
    'diagnose': (['bag', '--params', 'muscle.yaml', '--output', 'new'], ['bag', 'muscle.yaml']),
    'diagnose --manifest': (['--manifest', 'runs.yaml', '--output', 'new'], ['runs.yaml', 'muscle.yaml']),
    'record': (['--output', 'new', '--duration', '3'], []),
    'import without a map': (['run.csv', '--output', 'new'], ['run.csv']),
    'info': (['bag'], ['bag']),
    'export': (['bag', '--csv', 'new.csv'], ['bag']),
    'plot': (['bag', '--output', 'new.png'], ['bag']),
    'new-muscle': (['--fibre-diameter-mm', '0.2', '--turns', '280', '--output', 'new.yaml'], ['answers.txt']),
}
_ODD = [
    'nan', '.nan', 'inf', '-.inf', '-1', '0', '1e308', '1e-308', '1' + '0' * 400, '3.7', 'null', '~', '', 'yes', 'text',
    '[]', '{}', '[1, 2, 3]', '[[1]]', '{a: 1}', '2026-13-45', '0x1f', '1_000', '!!binary x', '!!python/object:os.x x',
    '&a [*a]', '*b', '"', "'", '|', '- -', '%', '\t', '\0', 'ä', '漢', '\u202e', '../../x', '/dev/null', '${HOME}',
    '{stem}', '{stem.x}', '{0}', '*', '1,5', '1;5', 'degC', 'mA', 'current', 'NaN', '#REF!', '1e', '--', '9' * 30,
]  # fmt: skip
_OPTIONS = [
    *(f'--unit {unit}' for unit in (
        'temperature=degF', 'temperature', 'x=y', 'current=-A', '=mm', 'displacement=mm --unit displacement=m',
    )),
    *(f'--channel {channel}' for channel in (
        'force=/displacement', 'temperature=/temperature.header.stamp.sec', 'current=/nowhere', 'a=b=c', 'load=/load.',
        'displacement=/joint_states.position[99999999999999999999]',
    )),
    *(f'--output {output}' for output in ('.', '/', 'bag', 'run.csv', 'run.csv/x', 'deep/down/new')),
    *(f'--output {output} --force' for output in ('muscle.yaml', 'bag', 'protocol.yaml', '.', 'bag/metadata.yaml')),
    '--csv bag/metadata.yaml --force', '--figure bag/new.png', '--separate x --manifest runs.yaml',
    *(f'--params {params}' for params in (
        'nowhere.yaml', 'bag', '/dev/null', '/dev/zero', 'run.csv', 'bag/metadata.yaml',
    )),
    *(f'--seed {seed}' for seed in ('', '-1', 'x', '9' * 40)),
    *(f'--duration {duration}' for duration in ('nan', '-1', '1e400', '')),
    '--output ' + 'a' * 300, '--namespace /x/y', '--namespace', '--separate B', '--separate x',
    '--jobs 0', '--force', '--resume', '--resume --force',
    '--figure x.xyz', '--figure bag', '--figure run.csv', '--map protocol.yaml',
    '--scheduler nowhere', '--bogus', 'nowhere', '--', '-h', '--version',
]  # fmt: skip
_MORE_OPTIONS = {
    'new-muscle': [
        f'--{name} {value}'
        for name in ('fibre-diameter-mm', 'fibre-length-mm', 'coil-length-mm', 'turns', 'resistance-ohm', 'mass-g')
        for value in ('', '0', '-3', 'nan', 'inf', '1e308', '1e-308', '1e400', '1,5', '2mm', '0x1f', '٣', '7', '1e6')
    ]
}


def good_inputs(folder: Path) -> None:
    """One of each, sound and small."""
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding='utf-8')
    time_s = np.arange(600) / 10.0
    rng = np.random.default_rng(1)
    on = (time_s % 30.0 > 5.0) & (time_s % 30.0 < 18.0)
    warm = np.zeros(600)
    for k in range(1, 600):
        warm[k] = warm[k - 1] + 0.1 * (3.0 * on[k - 1] - warm[k - 1] / 9.0)
    values = {
        'current': 0.25 * on,
        'temperature': 296.0 + warm + 0.1 * rng.standard_normal(600),
        'resistance': 13.0 * (1.0 + 0.002 * warm) + 0.01 * rng.standard_normal(600),
        'displacement': 2e-4 * warm + 2e-5 * rng.standard_normal(600),
        'load': np.full(600, 0.5884),
    }
    channels = {name: Channel(name, time_s, value, name) for name, value in values.items()}
    write_recording(folder / 'bag', Recording('', channels, START, {'load_n': 0.5884}))


# --- damages ----------------------------------------------------------------------------------------------------------


def _damage_text(path: Path, rng: np.random.Generator) -> str:
    text = path.read_text(encoding='utf-8', errors='replace') or '\n'
    start, stop = sorted(int(at) for at in rng.integers(0, len(text) + 1, 2))
    stop = min(stop, start + int(rng.integers(1, 60)))
    lines = text.splitlines(keepends=True)
    line = int(rng.integers(0, len(lines)))
    odd = str(rng.choice(np.array(_ODD, dtype=object)))
    cells = [k for k, part in enumerate(_parts(text)) if any(c.isalnum() for c in part)] or [0]
    kinds: dict[str, Callable[[], str]] = {
        'cut off': lambda: text[:start],
        'a stretch is missing': lambda: text[:start] + text[stop:],
        'a stretch stands twice': lambda: text[:stop] + text[start:],
        'a line is missing': lambda: ''.join(lines[:line] + lines[line + 1 :]),
        'a line stands twice': lambda: ''.join([*lines[: line + 1], *lines[line:]]),
        'a line is elsewhere': lambda: ''.join([lines[line], *lines[:line], *lines[line + 1 :]]),
        'something odd is put in': lambda: text[:start] + odd + text[start:],
        'a word is something odd': lambda: _with_part(text, int(rng.choice(cells)), odd),
        'a word is another': lambda: _with_part(text, int(rng.choice(cells)), _parts(text)[int(rng.choice(cells))]),
    }
    kind = str(rng.choice(list(kinds)))
    path.write_bytes(kinds[kind]().encode('utf-8', errors='replace'))
    return f'{path.name}: {kind}'


def _parts(text: str) -> list[str]:
    """Words and what stands between them."""
    found, word = [''], False
    for char in text:
        if (char.isalnum() or char in '._-+') != word:
            found.append('')
            word = not word
        found[-1] += char
    return found


def _with_part(text: str, k: int, instead: str) -> str:
    parts = _parts(text)
    parts[k] = instead
    return ''.join(parts)


_OTHER = ('empty', 'is a folder', 'is gone', 'a text')


def _damage_bytes(path: Path, rng: np.random.Generator) -> str:
    content = bytearray(path.read_bytes())
    kind = str(rng.choice(['bytes are others', 'cut off', 'a stretch is missing', *_OTHER]))
    at = int(rng.integers(0, max(len(content), 1)))
    if kind == 'bytes are others':
        for place in rng.integers(0, len(content) or 1, int(rng.integers(1, 30))) if content else ():
            content[int(place)] = int(rng.integers(0, 256))
    elif kind == 'cut off':
        del content[at:]
    elif kind == 'a stretch is missing':
        del content[at : at + int(rng.integers(1, 500))]
    path.unlink()
    if kind == 'is a folder':
        path.mkdir()
    elif kind != 'is gone':
        path.write_bytes({'empty': b'', 'a text': b'no such thing\n'}.get(kind, bytes(content)))
    return f'{path.name}: {kind}'


def _damage_values(bag: Path, rng: np.random.Generator) -> str:
    """The bag written anew with a channel that says something odd."""
    from tcp_muscle_ros.recording.bag import read_bag

    recording = read_bag(bag)
    channels = dict(recording.channels)
    name = str(rng.choice(list(channels)))
    time_s, value = channels[name].time.copy(), channels[name].value.copy()
    some = rng.random(value.size) < rng.choice([0.01, 0.3, 1.0])
    changes: dict[str, Callable[[], None]] = {
        'is not finite': lambda: value.__setitem__(some, rng.choice([np.nan, np.inf, -np.inf])),
        'is huge': lambda: value.__setitem__(some, 10.0 ** rng.uniform(3, 300)),
        'is tiny': lambda: value.__imul__(10.0 ** -rng.uniform(1, 300)),
        'is turned': lambda: value.__imul__(-1.0),
        'is constant': lambda: value.fill(value[0]),
        'is noise': lambda: value.__setitem__(slice(None), rng.standard_normal(value.size)),
        'is in another order': lambda: rng.shuffle(value),
        'is early': lambda: time_s.__imul__(float(rng.choice([1e-6, 0.1, 3.0]))),
        'is late': lambda: time_s.__iadd__(float(rng.choice([5.0, 1e3, 1e7]))),
    }
    kind = str(rng.choice([*changes, 'is missing', 'has one sample', 'has two samples', 'is another']))
    if kind in changes:
        changes[kind]()
    kept = {'is missing': 0, 'has one sample': 1, 'has two samples': 2}.get(kind, value.size)
    channels[name] = Channel(name, time_s[:kept], value[:kept], name)
    if kind == 'is another':
        channels[name] = Channel(name, time_s, recording[str(rng.choice(list(channels)))].value[: time_s.size], name)
    shutil.rmtree(bag)
    write_recording(bag, Recording('', {n: c for n, c in channels.items() if len(c)}, START, recording.known))
    return f'{name} {kind}'


def damage(folder: Path, name: str, rng: np.random.Generator) -> str:
    """Damage one input in place; what was done, in words."""
    path = folder / name
    if name != 'bag':
        if not path.is_file():
            return 'as it is'
        return _damage_text(path, rng) if rng.random() < 0.85 else _damage_bytes(path, rng)
    if rng.random() < 0.5:
        with contextlib.suppress(Exception), np.errstate(all='ignore'):
            return _damage_values(path, rng)
    file = path / str(rng.choice(['bag_0.mcap', 'metadata.yaml']))
    return _damage_bytes(file, rng) if file.is_file() else 'as it is'


# --- trials -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Trial:
    """What one damaged input came to: ``wrong`` says what must not be, '' where all is well."""

    words: list[str]
    damages: list[str]
    code: int
    said: str
    wrong: str


def trial(command: str, seed: int, good: Path) -> Trial:
    """Run a command on good inputs of which some are damaged."""
    rng = np.random.default_rng([seed, *command.encode()])
    line, inputs = COMMANDS[command]
    words = [*line]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        shutil.copytree(good, folder, dirs_exist_ok=True)
        damages = [damage(folder, str(rng.choice(inputs)), rng) for _ in range(int(rng.integers(1, 3))) if inputs]
        if rng.random() < 0.35 or not inputs:
            options = _OPTIONS + _MORE_OPTIONS.get(command, [])
            extra = options[int(rng.integers(0, len(options)))]
            words += extra.split()
            damages.append(extra)
        if rng.random() < 0.05:
            words = [word for k, word in enumerate(words) if k != int(rng.integers(0, len(words)))]
        before = _state(folder)
        out, err = io.StringIO(), io.StringIO()
        back = os.getcwd()
        os.chdir(folder)
        try:
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), answering(folder / 'answers.txt'):
                code = tool([command.split(maxsplit=1)[0], *words], until_admitted=True)
        finally:
            os.chdir(back)
        after = _state(folder)
    said = err.getvalue()
    if {'--force', '--output'} <= {*words} and code == 0:  # to replace what is no input is what was asked for
        asked = words[len(words) - 1 - words[::-1].index('--output') + 1]
        before = {name: digest for name, digest in before.items() if not name.startswith(asked)}
    return Trial(words, damages, code, said, _wrong(code, out.getvalue(), said, before, after))


@contextlib.contextmanager
def answering(answers: Path) -> Iterator[None]:
    """Standard input is that file, as a shell's `<` would have it; nothing where it is none."""
    before = sys.stdin
    with open(answers if answers.is_file() else os.devnull, encoding='utf-8') as sys.stdin:
        try:
            yield
        finally:
            sys.stdin = before


def _state(folder: Path) -> dict[str, str]:
    """A digest of every file, '' for a folder."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ''
        for path in sorted(folder.rglob('*'))
    }


def _wrong(code: int, out: str, said: str, before: dict[str, str], after: dict[str, str]) -> str:
    """What must not be of how a trial ended."""
    changed = sorted(name for name, digest in before.items() if after.get(name) != digest)
    lines = [line for line in said.splitlines() if line.strip()]
    if code not in (0, 2):
        return f'exit code {code}: {lines[-1] if lines else out}'
    if 'Traceback' in said + out or 'Warning' in said:
        return f'a traceback or warning: {said[-300:]}'
    if code == 2 and len(lines) != 1:
        return f'{len(lines)} lines instead of one: {said[-300:]}'
    if changed:
        return f'changed: {", ".join(changed)}'
    if code == 2 and before.keys() != after.keys():
        return f'left behind: {", ".join(sorted(after.keys() - before.keys()))}'
    return ''


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--count', type=int, default=1000, help='trials of each command')
    parser.add_argument('--first', type=int, default=0, help='seed of the first')
    parser.add_argument('--commands', nargs='+', default=list(COMMANDS), choices=list(COMMANDS))
    parser.add_argument('--write', action='store_true', help='put the table into docs/recording.md')
    chosen = parser.parse_args()
    rows, begun = [], time.monotonic()
    with tempfile.TemporaryDirectory() as place:
        good = Path(place)
        good_inputs(good)
        for command in chosen.commands:
            counts: Counter[str] = Counter()
            for seed in range(chosen.first, chosen.first + chosen.count):
                ended = trial(command, seed, good)
                counts['wrong' if ended.wrong else 'admitted' if ended.code == 0 else 'refused'] += 1
                if ended.wrong:
                    print(f'{command} {seed}: {ended.damages} {ended.words}\n    {ended.wrong}', flush=True)
            rows.append((command, chosen.count, counts['refused'], counts['admitted'], counts['wrong']))
            print(*rows[-1], f'{time.monotonic() - begun:.0f} s', flush=True)
    if chosen.write:
        _write(rows)
    return int(any(row[-1] for row in rows))


def _write(rows: Sequence[tuple[str, int, int, int, int]]) -> None:
    """Put the rows into the document's table; commands that were not tried keep theirs."""
    lines = PAGE.read_text(encoding='utf-8').splitlines()
    table = {name: line for name in COMMANDS for line in lines if line.startswith(f'| `{name}` |')}
    for name, *counts in rows:
        table[name] = f'| `{name}` | {" | ".join(map(str, counts))} | {datetime.now(UTC).date()} |'
    heads = '| command | trials | refused in one line | admitted | anything else | date |\n|---|---|---|---|---|---|'
    ordered = '\n'.join(table[name] for name in COMMANDS if name in table)
    replace_marked(PAGE, 'mutations', f'`python -m proof.mutate --count 1000`:\n\n{heads}\n{ordered}')


if __name__ == '__main__':
    sys.exit(main())

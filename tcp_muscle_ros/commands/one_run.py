"""One run of a campaign, done in whichever process: a whole report in its folder, or nothing."""

from __future__ import annotations

import argparse
import hashlib
import json
import shutil
import threading
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tcp_muscle_ros import __version__
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import added_to_report

UNFINISHED = '.unfinished'  # in the campaign's folder: reports being written
_STAMP = 'run.json'  # in a report: the digest of what it was made from
_BLOCK = 1 << 20
_FIGURES = threading.Lock()  # a worker may have threads, figures are drawn by one at a time


@dataclass(frozen=True)
class Task:
    """One run to be done into ``folder/name``; ``options`` as of ``diagnose_bags``, ``digest`` of all that goes in."""

    name: str
    bags: tuple[str, ...]
    params: str
    folder: str
    options: argparse.Namespace
    digest: str

    @property
    def report(self) -> Path:
        """Where its report goes."""
        return Path(self.folder) / self.name


@dataclass(frozen=True)
class Outcome:
    """What became of a run: ``reason`` is None where its report is there; ``bad_input`` where the user can mend it."""

    name: str
    reason: str | None = None
    bad_input: bool = False


def digest_of(bags: tuple[str, ...], params: str, options: argparse.Namespace) -> str:
    """A digest of the bags' names and content, the parameters, the rig, the options and the version of the package.

    Empty where something cannot be read: such a run is never taken as done, and says itself why it fails.
    """
    said = hashlib.sha256()
    reading = dict(sorted(vars(options).items()))
    said.update(json.dumps([__version__, reading, [Path(bag).name for bag in bags]]).encode())
    try:
        for bag in bags:
            for path in _files(Path(bag)):
                said.update(f'\0{path.name}\0'.encode())
                _add(said, path)
        said.update(f'\0{Path(params).name}\0'.encode())
        known = (params, getattr(options, 'rig', None) or '')
        for file in (Path(name) for name in known if name and Path(name).exists()):
            _add(said, file)
    except OSError:
        return ''
    return said.hexdigest()


def _files(bag: Path) -> Iterator[Path]:
    if bag.is_dir():
        yield from sorted(path for path in bag.rglob('*') if path.is_file())
    else:
        yield bag


def _add(said: hashlib._Hash, path: Path) -> None:
    if not path.is_file():  # opening a pipe may take for ever
        raise OSError(f'{path} is no regular file')
    with path.open('rb') as file:
        while block := file.read(_BLOCK):
            said.update(block)


def is_done(task: Task) -> bool:
    """Whether its report is there, whole, and made from the same."""
    try:
        stamp = json.loads((task.report / _STAMP).read_text(encoding='utf-8'))
        report = json.loads((task.report / 'report.json').read_text(encoding='utf-8'))
        return bool(task.digest and stamp['digest'] == task.digest and report['partial'] is False)
    except (OSError, ValueError, KeyError, TypeError):
        return False


def work(task: Task) -> Outcome:
    """Diagnose one run. Never raises: what went wrong is in the outcome, in one line."""
    try:
        with _FIGURES:
            _work(task)
    except BadInput as error:
        return Outcome(task.name, ' '.join(str(error).split()), bad_input=True)
    except Exception as error:
        return Outcome(task.name, ' '.join(f'internal error: {type(error).__name__}: {error}'.split()))
    return Outcome(task.name)


def _work(task: Task) -> None:
    from tcp_muscle_ros.commands.one_diagnosis import diagnose_bags

    if task.report.exists() and not (task.report / _STAMP).is_file():
        raise BadInput(f'{task.report}: is there already and no report of a manifest; give another --output')
    if added := added_to_report(task.report):
        raise BadInput(f'{task.report}: holds {added}, which no report writes; move it away, or give another --output')
    draft = Path(task.folder) / UNFINISHED / f'{task.name}-{uuid.uuid4().hex}'
    draft.parent.mkdir(exist_ok=True)
    try:
        if diagnose_bags(task.options, task.bags, task.params, draft, place=task.report).partial:
            raise RuntimeError('interrupted')
        (draft / _STAMP).write_text(json.dumps({'run': task.name, 'digest': task.digest}) + '\n', encoding='utf-8')
        _publish(task, draft)
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _publish(task: Task, draft: Path) -> None:
    """The draft takes its place at once; an older report goes. Where a twin was faster, its report stays."""
    if is_done(task):
        return
    if task.report.exists():
        task.report.rename(draft.with_name(draft.name + '-old'))
    draft.rename(task.report)
    shutil.rmtree(draft.with_name(draft.name + '-old'), ignore_errors=True)

"""Where a command writes: looked at before the work, written beside, and put in its place when it is whole.

What stood there before is replaced only under ``--force``, and only by something that is complete: a full disk, an
error or Ctrl-C leaves it as it was.
"""

import argparse
import json
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from tcp_muscle_ros.errors import BadInput, Option

OUTPUT, FORCE = Option('--output', 'path'), Option('--force', 'force=True')
_HOLDER = '.unfinished-'  # begins the name of the folder beside an output in which it is made
_OF_A_BAG = ('.mcap', '.db3', '.zstd')
IMPORT_MAP = 'import_map.yaml'  # that `tcp_muscle import` was given or made, beside the bags
_REPORT, _SCHEMA = 'report.json', 'tcp_muscle_ros/'
# All that a report may hold, run.json of a campaign among it; whatever else is there, a person put there.
_OF_A_REPORT = frozenset(
    {_REPORT, 'report.html', 'figures', 'overlay', 'rig.yaml', 'next_protocol.yaml', 'run.json'}
    | {'improved.yaml', 'improved.intervals.json', 'improved.ages.json'}
)


def add_force_argument(parser: argparse.ArgumentParser) -> None:
    """Add --force."""
    parser.add_argument('--force', action='store_true', help='replace existing output, once the new output is complete')


def writable_folder(path: str | Path, *, force: bool = False, option: str | Option = OUTPUT) -> Path:
    """The path of a folder that is still to be made. BadInput where that is not possible, or something is there.

    ``force`` allows to replace a folder that this tool wrote: a bag, bags, or a report. ``option`` gave the path.
    """
    path = Path(path)
    if os.path.lexists(path):
        if not force:
            raise BadInput(f'{path}: exists already and is not overwritten; give another ', option, ', or ', FORCE)
        if not _is_ours(path):
            added = added_to_report(path)
            found = f'holds {added}, which no report writes' if added else 'is no bag, folder of bags or report'
            raise BadInput(f'{path}: {found}; ', FORCE, ' replaces nothing else')
    above = next(folder for folder in path.absolute().parents if folder.exists())
    if not above.is_dir():
        raise BadInput(f'{path}: {above} is a file; expected a folder')
    if not os.access(above, os.W_OK | os.X_OK):
        raise BadInput(f'{path}: nothing can be written in {above}; give another ', option)
    return path


def _is_ours(path: Path) -> bool:
    """Whether a path is a folder that holds nothing but what this tool writes: a bag, bags, a report; or nothing."""
    if path.is_symlink() or not path.is_dir():
        return False
    names = [entry.name for entry in path.iterdir()]
    if _REPORT in names:
        with suppress(OSError, ValueError, AttributeError):
            ours = str(json.loads((path / _REPORT).read_text('utf-8')).get('schema')).startswith(_SCHEMA)
            return ours and not added_to_report(path)
        return False
    return _is_bag(path) or all(_is_bag(path / name) for name in names if name != IMPORT_MAP)


def added_to_report(folder: Path) -> str:
    """The name of something in a report's folder that no report writes, '' where there is none, or it is no report."""
    if not (folder / _REPORT).is_file():
        return ''
    return min((entry.name for entry in folder.iterdir() if entry.name not in _OF_A_REPORT), default='')


def _is_bag(path: Path) -> bool:
    """Whether a path is a folder with the files of a bag and nothing else."""
    if path.is_symlink() or not path.is_dir():
        return False
    names = [entry.name for entry in path.iterdir()]
    return any(name.endswith(_OF_A_BAG) for name in names) and all(
        name.endswith((*_OF_A_BAG, 'metadata.yaml')) for name in names
    )


def writable_file(path: str | Path, *, force: bool = False, option: str | Option = OUTPUT) -> Path:
    """The path of a file that is still to be written. BadInput where that is not possible, or something is there.

    ``force`` allows to replace a regular file. ``option`` gave the path.
    """
    path = Path(path)
    if path.is_dir():
        raise BadInput(f'{path}: is a folder; expected the name of a file')
    if not path.parent.is_dir():
        raise BadInput(f'{path}: its folder does not exist')
    if os.path.lexists(path):
        if not force:
            raise BadInput(f'{path}: exists already and is not overwritten; give another ', option, ', or ', FORCE)
        if not path.is_file():
            raise BadInput(f'{path}: is no regular file; give another ', option)
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise BadInput(f'{path}: cannot be written')
    return path


def refuse_among(path: str | Path, inputs: Iterable[str | Path]) -> None:
    """BadInput where an output would take the place of an input, or of a folder that holds one, or be inside a bag."""
    place = Path(path).resolve()
    for given in inputs:
        read = Path(given).resolve()
        inside = read in place.parents and read.is_dir()
        if inside and any(name.endswith(_OF_A_BAG) for name in os.listdir(read)):
            raise BadInput(f'{path}: is inside {given}, which is read; give another path')
        if read.exists() and (place == read or place in read.parents):
            is_it = 'is' if place == read else f'holds {given}, which is'
            raise BadInput(f'{path}: {is_it} read, and nothing that is read is overwritten; give another path')


@contextmanager
def in_place_of(path: Path) -> Iterator[Path]:
    """A path beside ``path``, of the same name, to write a file or folder to; in the end it takes the place of
    ``path``. Where the body fails, what it wrote goes and ``path`` stays as it was. What the system says against
    writing is BadInput.
    """
    place = path.resolve() if path.is_symlink() else path.absolute()
    missing = [folder for folder in place.parents if not folder.exists()]
    with ExitStack() as undo, writing(path):
        for folder in reversed(missing):
            folder.mkdir()
            undo.callback(_remove_empty, folder)
        holder = Path(tempfile.mkdtemp(prefix=_HOLDER, dir=place.parent))
        undo.callback(shutil.rmtree, holder, ignore_errors=True)
        draft = holder / place.name
        try:
            yield draft
        except BadInput as error:
            raise error.replaced(str(draft), str(path)) from None
        if draft.exists():
            _take_place(draft, place)


def _take_place(draft: Path, path: Path) -> None:
    """Move a file at once; a folder in two steps, the first of which is taken back where the second fails."""
    if not (draft.is_dir() and path.exists()):
        draft.replace(path)
        return
    old = draft.with_name(draft.name + '.replaced')
    path.rename(old)
    try:
        draft.rename(path)
    except OSError:
        old.rename(path)
        raise


def set_aside(path: Path, why: str) -> Path | None:
    """Rename what is there to ``NAME_why_1``, or the first number that is free; None where nothing is there."""
    if not os.path.lexists(path):
        return None
    tries = 1
    while os.path.lexists(aside := path.with_name(f'{path.name}_{why}_{tries}')):
        tries += 1
    return path.rename(aside)


def remove(path: Path) -> None:
    """Remove a file, or a folder with all that is in it; nothing where it is gone."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def _remove_empty(folder: Path) -> None:
    with suppress(OSError):  # by now something is in it
        folder.rmdir()


@contextmanager
def writing(path: str | Path, kept: str = '') -> Iterator[None]:
    """What the system says against writing there, as BadInput; ``kept`` is what is not lost for all that."""
    try:
        yield
    except OSError as error:
        raise BadInput(f'{path}: cannot be written ({error.strerror or error}){kept}') from None

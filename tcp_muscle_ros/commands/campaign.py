"""``tcp_muscle diagnose --manifest RUNS.yaml --output DIR``: every run of a list, each as ``diagnose`` does one.

DIR/NAME/ is the report of a run; DIR/summary.csv, summary.json and trends.png are over all of them. What is done
stays done: a run is repeated only when its bags, parameters or options, or the package, have changed.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from tcp_muscle_ros.commands.calibrate import refuse_unknown
from tcp_muscle_ros.commands.exit_codes import BAD_INPUT, DONE, INTERNAL, INTERRUPTED
from tcp_muscle_ros.commands.one_run import UNFINISHED, Outcome, Task, digest_of, is_done
from tcp_muscle_ros.commands.progress import Progress
from tcp_muscle_ros.errors import BadInput

if TYPE_CHECKING:
    from tcp_muscle_ros.commands.manifest import Run
    from tcp_muscle_ros.report.campaign_summary import Row

_LOCK = '.lock'  # in the folder of a campaign


def admit_campaign(args: argparse.Namespace) -> list[Run]:
    """The runs of a manifest. BadInput for what stands in it, and for options that do not go with it."""
    from tcp_muscle_ros.commands.manifest import read_manifest

    if args.bags:
        raise BadInput(f'{args.bags[0]}: either bags or --manifest, not both; name the bags in the manifest')
    if args.force:
        raise BadInput('--force goes with BAG...; a --manifest replaces its own reports where something has changed')
    if args.jobs is not None and args.jobs < 1:
        raise BadInput(f'--jobs {args.jobs}: expected 1 or more')
    if args.jobs is not None and args.scheduler is not None:
        raise BadInput('--jobs is for processes of this machine; --scheduler has its own workers')
    refuse_unknown(args.separate)
    return read_manifest(args.manifest, args.params)


def run_campaign(args: argparse.Namespace) -> int:
    """Do what is not done, list what failed, summarise all. Ctrl-C stops, and what is done stays."""
    runs = admit_campaign(args)
    folder = Path(args.output).absolute()
    outcomes: dict[str, Outcome] = {}
    interrupted = False
    with _alone_in(folder), Progress('diagnosing') as progress:
        try:
            _do(runs, folder, args, outcomes, progress)
        except KeyboardInterrupt:
            interrupted = True
        shutil.rmtree(folder / UNFINISHED, ignore_errors=True)
        progress.stage('summing up')
        rows = [_row(run, folder, outcomes.get(run.name)) for run in runs]
        _summarise(folder, rows)
    if interrupted:
        print('INTERRUPTED: the same command goes on where it stopped')
        return INTERRUPTED
    if any(outcome.reason is None for outcome in outcomes.values()):
        return DONE
    return BAD_INPUT if all(outcome.bad_input for outcome in outcomes.values()) else INTERNAL


def _do(
    runs: Sequence[Run], folder: Path, args: argparse.Namespace, outcomes: dict[str, Outcome], progress: Progress
) -> None:
    """Fill in the outcome of each run, those first that are done already."""
    from tcp_muscle_ros.commands.engines import cluster, local

    kept = ('namespace', 'channel', 'unit', 'separate')
    options = argparse.Namespace(**{name: getattr(args, name) for name in kept})
    options.rig = os.path.abspath(args.rig) if args.rig else None
    tasks = []
    for run in runs:
        bags, params = tuple(map(os.path.abspath, run.bags)), _absolute(run.params)
        task = Task(run.name, bags, params, str(folder), options, digest_of(bags, params, options))
        if is_done(task):
            outcomes[run.name] = Outcome(run.name)
        else:
            tasks.append(task)
        progress.tell(f'{len(outcomes) + len(tasks)} of {len(runs)} runs looked at')
    if outcomes:
        print(f'{len(outcomes)} of {len(runs)} runs were done already')
    if not tasks:
        return
    engine = cluster(tasks, args.scheduler) if args.scheduler else local(tasks, args.jobs or _cores())
    try:
        for outcome in engine:
            if outcome is not None:
                outcomes[outcome.name] = outcome
            failed = sum(each.reason is not None for each in outcomes.values())
            progress.tell(f'{len(outcomes)} of {len(runs)} runs' + (f', {failed} failed' if failed else ''))
    finally:
        engine.close()
        for task in tasks:  # finished, but Ctrl-C came before it could say so
            if task.name not in outcomes and is_done(task):
                outcomes[task.name] = Outcome(task.name)


def _absolute(params: str) -> str:
    return os.path.abspath(params) if Path(params).exists() else params


def _cores() -> int:
    if hasattr(os, 'sched_getaffinity'):  # Linux alone tells those that this process may use
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _lock(file: TextIO) -> None:
    """Hold the file against other processes. Raises BlockingIOError where one holds it."""
    try:
        import fcntl
    except ImportError:  # not on this system: two at once are then not told apart
        return
    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def _alone_in(folder: Path) -> Iterator[None]:
    """The folder, made where it is missing, for this campaign alone: two would take each other's work for left over."""
    if folder.exists() and not folder.is_dir():
        raise BadInput(f'{folder}: is a file; expected a folder')
    if not folder.parent.is_dir():
        raise BadInput(f'{folder}: the folder {folder.parent} does not exist')
    from tcp_muscle_ros.commands.manifest import TAKEN

    own = next((name for name in TAKEN if (folder / name).exists()), None)
    if own and not (folder / _LOCK).exists():
        raise BadInput(f'{folder}: has a {own} that no diagnose --manifest wrote; give another --output')
    try:
        folder.mkdir(exist_ok=True)
        with (folder / _LOCK).open('w') as lock:
            _lock(lock)
            shutil.rmtree(folder / UNFINISHED, ignore_errors=True)
            yield
    except BlockingIOError:
        raise BadInput(f'{folder}: another diagnose --manifest is at work there') from None
    except PermissionError as error:
        raise BadInput(f'{folder}: cannot be written: {error.strerror}') from None


def _row(run: Run, folder: Path, outcome: Outcome | None) -> Row:
    from tcp_muscle_ros.report.campaign_summary import NOT_DONE, Row

    report = None
    if outcome is not None and outcome.reason is None:
        report = json.loads((folder / run.name / 'report.json').read_text(encoding='utf-8'))
    reason = NOT_DONE if outcome is None else outcome.reason
    return Row(run.name, run.muscle, run.cycles, run.day, report, reason)


def _summarise(folder: Path, rows: Sequence[Row]) -> None:
    from tcp_muscle_ros.report.campaign_summary import terminal_table, write_csv, write_json
    from tcp_muscle_ros.report.trends import draw_trends

    write_csv(folder / 'summary.csv', rows)
    write_json(folder / 'summary.json', rows)
    (folder / 'trends.png').unlink(missing_ok=True)
    drawn = draw_trends(folder / 'trends.png', rows)
    print(terminal_table(rows))
    print(f'summary: {folder / "summary.csv"}' + (f', trends: {folder / "trends.png"}' if drawn else ''))

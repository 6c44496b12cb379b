"""``tcp_muscle diagnose BAG... [--params P.yaml] --output DIR``: which physics the recordings show that is missing.

``--manifest RUNS.yaml`` instead of bags: many runs, each as above (``campaign.py``).
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tcp_muscle_ros.commands.bag_arguments import add_bag_arguments
from tcp_muscle_ros.commands.model_arguments import add_parameter_argument
from tcp_muscle_ros.outputs import add_force_argument

if TYPE_CHECKING:
    from tcp_muscle_ros.commands.progress import Progress
    from tcp_muscle_ros.diagnosis.experiment import Experiment
    from tcp_muscle_ros.diagnosis.findings import Diagnosis
    from tcp_muscle_ros.parameter_file import ParameterFile, Value
    from tcp_muscle_ros.recording.mending import Mended
    from tcp_muscle_ros.recording.recording import Recording

# More observations a channel than this are averaged in blocks: a muscle is slow, and time and memory stay bounded.
MOST = 1000
_INTERRUPTED = 130


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``diagnose``."""
    parser.add_argument('bags', nargs='*', metavar='BAG', help='recordings of one muscle')
    add_parameter_argument(parser)
    parser.add_argument('--output', required=True, metavar='DIR', help='a new folder for the report')
    add_force_argument(parser)
    parser.add_argument('--seed', type=int, default=0, metavar='N', help='the same seed gives the same report (0)')
    add_bag_arguments(parser)
    many = parser.add_argument_group('many runs')
    many.add_argument('--manifest', metavar='RUNS.yaml', help='diagnose each run of this list to DIR/NAME, not BAG...')
    many.add_argument('--jobs', type=int, metavar='N', help='how many processes at once (one for each core)')
    many.add_argument('--scheduler', metavar='HOST:PORT', help='run on the workers of this dask scheduler instead')


def run(args: argparse.Namespace) -> int:
    """Diagnose, write the report, print its summary. An interrupted diagnosis writes what it knows by then."""
    from tcp_muscle_ros.commands.progress import Progress
    from tcp_muscle_ros.errors import BadInput
    from tcp_muscle_ros.outputs import refuse_among
    from tcp_muscle_ros.report.terminal import summary
    from tcp_muscle_ros.report.write import refuse_report

    if args.manifest is not None:
        from tcp_muscle_ros.commands.campaign import run_campaign

        return run_campaign(args)
    if not args.bags:
        raise BadInput('nothing to diagnose: expected BAG..., or --manifest RUNS.yaml')
    for option in ('jobs', 'scheduler'):
        if getattr(args, option) is not None:
            raise BadInput(f'--{option} goes with --manifest RUNS.yaml only')
    refuse_among(args.output, [*args.bags, args.params])
    output = refuse_report(args.output, force=args.force)
    with Progress('diagnosing') as progress:
        diagnosis = diagnose_bags(args, args.bags, args.params, output, progress, force=args.force)
    print(summary(diagnosis, output / 'report.html'))
    return _INTERRUPTED if diagnosis.partial else 0


def diagnose_bags(
    options: argparse.Namespace,
    bags: Sequence[str],
    params: str,
    output: Path,
    progress: Progress | None = None,
    *,
    force: bool = False,
) -> Diagnosis:
    """Diagnose bags of one muscle and write the report; partial where it was interrupted.

    ``options``: the seed and how bags are read (``add_bag_arguments``). ``force``: an older report is replaced.
    Raises BadInput.
    """
    from dataclasses import replace

    from tcp_muscle_ros.commands.bag_arguments import read_bags
    from tcp_muscle_ros.diagnosis.diagnose import Interrupted, diagnose
    from tcp_muscle_ros.parameter_file import read
    from tcp_muscle_ros.report.write import write_report

    nominal = read(params)
    recordings = read_bags(options, *bags)
    mended, experiments = prepared(recordings, nominal)
    beat = progress.beat if progress else None
    try:
        diagnosis = diagnose(experiments, nominal.parameters, seed=options.seed, progress=beat)
    except Interrupted as stop:
        diagnosis = replace(stop.partial, partial=True)
    diagnosis = with_faults(with_issues(diagnosis, recordings, mended, experiments), mended)
    del mended
    diagnosis = with_replay(diagnosis, recordings, nominal.operating)
    if progress:
        progress.stage('writing the report')
    write_report(output, diagnosis, experiments, nominal.operating, force=force)
    return diagnosis


def prepared(
    recordings: Sequence[Recording], nominal: ParameterFile, most: int = MOST
) -> tuple[list[Mended], list[Experiment]]:
    """What a model can follow of each recording, and all its parts as experiments of at most so many observations."""
    from tcp_muscle_ros.commands.model_arguments import conditions
    from tcp_muscle_ros.diagnosis.prepare import prepare

    given = conditions(nominal)
    mended = [_mended(recording, given.ambient) for recording in recordings]
    return mended, [prepare(part, nominal.parameters, given, most) for m in mended for part in m.parts]


def _mended(recording: Recording, ambient: float | None) -> Mended:
    """What a model can follow of a recording. BadInput where it is not what it says it is, or nothing is left."""
    from tcp_muscle_ros.errors import BadInput
    from tcp_muscle_ros.recording.mending import mend
    from tcp_muscle_ros.recording.plausibility import refuse_implausible
    from tcp_muscle_ros.recording.recording import OUTPUTS

    refuse_implausible(recording, ambient)
    mended = mend(recording)
    if mended.faults and not any(name in part for part in mended.parts for name in OUTPUTS):
        raise BadInput(f'{recording.path}: {mended.faults[0].sentence}, and nothing else was recorded')
    return mended


def with_issues(
    diagnosis: Diagnosis, recordings: Sequence[Recording], mended: Sequence[Mended], experiments: Sequence[Experiment]
) -> Diagnosis:
    """The diagnosis with what the checks, the reader and the preparation say of each recording.

    What the checks say of a recording that was cut stands with its first part.
    """
    from dataclasses import replace

    from tcp_muscle_ros.recording.checks import check

    found = []
    for recording, parts in zip(recordings, mended, strict=True):
        dead = {fault.channel for fault in parts.faults}
        checked = [i for i in check(recording) if not (i.channel in dead and i.kind in ('stuck', 'saturation'))]
        found += [[issue.sentence for issue in checked], *([] for _ in parts.parts[1:])]
    told = []
    for summary, issues, experiment in zip(diagnosis.recordings, found, experiments, strict=True):
        issues = [*summary.issues, *issues, *experiment.notes, *_averaged(experiment)]
        told.append(replace(summary, issues=_once(issues)))
    return replace(diagnosis, recordings=tuple(told))


def with_replay(diagnosis: Diagnosis, recordings: list[Recording], operating: Mapping[str, Value]) -> Diagnosis:
    """The diagnosis with the errors that ``tcp_muscle replay`` of its improved.yaml shows on the same bags.

    Empties ``recordings``: a long one is let go before it is replayed.
    """
    from dataclasses import replace

    from tcp_muscle_ros.commands.model_arguments import conditions
    from tcp_muscle_ros.diagnosis.prepare import prepare
    from tcp_muscle_ros.diagnosis.replaying import replayed_rmse
    from tcp_muscle_ros.parameter_file import ParameterFile
    from tcp_muscle_ros.report.protocol_file import operating_with_room, physics_only

    if not diagnosis.fit:
        return diagnosis
    muscle = physics_only(diagnosis.improved)
    given = conditions(ParameterFile(muscle, operating_with_room(diagnosis, operating)))
    errors = replayed_rmse((prepare(recordings.pop(0), muscle, given) for _ in range(len(recordings))), muscle)
    fit = {name: replace(f, replayed=errors.get(name, float('nan'))) for name, f in diagnosis.fit.items()}
    return replace(diagnosis, fit=fit)


def _once(issues: Sequence[str]) -> tuple[str, ...]:
    """Each sentence once; what is said of several channels in the same words, with all their names before it."""
    from tcp_muscle_ros.recording.recording import CHANNELS

    names: dict[str, list[str]] = {}
    for issue in issues:
        channel, colon, rest = issue.partition(': ')
        of_channel = bool(colon) and channel in CHANNELS
        found = names.setdefault(rest if of_channel else issue, [])
        if of_channel and channel not in found:
            found.append(channel)
    return tuple(f'{", ".join(channels)}: {said}' if channels else said for said, channels in names.items())


def with_faults(diagnosis: Diagnosis, mended: Sequence[Mended]) -> Diagnosis:
    """The diagnosis with the sensors that stood still: a fault of the set-up, where nothing stronger was found."""
    from dataclasses import replace

    many = len(mended) > 1
    faults = [
        fault.sentence + (f' in recording {Path(m.parts[0].path).name}' if many else '')
        for m in mended
        for fault in m.faults
    ]
    if not faults:
        return diagnosis
    verdict = 'sensor_or_setup' if diagnosis.verdict in ('match', 'wrong_parameters') else diagnosis.verdict
    told = f'{faults[0][0].upper()}{faults[0][1:]}'
    more = f' ({len(faults) - 1} more in the report)' if len(faults) > 1 else ''
    headline = f'{told}{more}; that was left out. {diagnosis.headline}'
    return replace(diagnosis, verdict=verdict, headline=headline, notes=(*diagnosis.notes, *faults))


def _averaged(experiment: Experiment) -> list[str]:
    """Which channels were averaged in blocks, and in how long ones."""
    widest = {name: int(o.count.max()) for name, o in experiment.observed.items() if o.count.max() > 1}
    told = ', '.join(f'{name} ({width})' for name, width in widest.items())
    return [f'averaged in blocks of up to so many samples: {told}'] if told else []

"""``tcp_muscle calibrate BAG... [--params P.yaml] --output MUSCLE.yaml``: the paper's parameters of a given muscle."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tcp_muscle_ros.commands.bag_arguments import Bags, add_bag_arguments
from tcp_muscle_ros.commands.model_arguments import add_parameter_argument
from tcp_muscle_ros.files.outputs import add_force_argument

if TYPE_CHECKING:
    from tcp_muscle_ros.diagnosis.fitting.calibration import Calibration
    from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
    from tcp_muscle_ros.recording.recording import Recording
    from tcp_muscle_ros.settings.parameter_file import ParameterFile
    from tcp_muscle_ros.settings.parameter_file import Value as Setting

# More observations a channel than this are averaged in blocks: a muscle is slow, and the fit stays within seconds.
MOST = 4000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``calibrate``."""
    parser.add_argument('bags', action=Bags, nargs='+', metavar='BAG', help='recordings of one muscle')
    add_parameter_argument(parser)
    parser.add_argument('--output', required=True, metavar='MUSCLE.yaml', help='the parameter file to write')
    add_separate_argument(parser)
    add_force_argument(parser)
    add_bag_arguments(parser)


def admit(args: argparse.Namespace) -> tuple[Path, ParameterFile, list[Experiment]]:
    """All that can be refused before the fit; the file to write, the muscle as assumed, and the recordings."""
    from tcp_muscle_ros.commands.bag_arguments import read_bags
    from tcp_muscle_ros.files.outputs import refuse_among, writable_file
    from tcp_muscle_ros.settings.intervals import path_beside
    from tcp_muscle_ros.settings.parameter_file import read

    refuse_unknown(args.separate)
    refuse_among(args.output, [*args.bags, args.params])
    output = writable_file(args.output, force=args.force)
    writable_file(path_beside(output), force=args.force)
    nominal = read(args.params)
    return output, nominal, admitted(read_bags(args, *args.bags), nominal, MOST)


def run(args: argparse.Namespace) -> int:
    """Fit, print the table, write the parameter file and its intervals."""
    from tcp_muscle_ros.commands.progress import Progress
    from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
    from tcp_muscle_ros.process.compiling import tell_of_compiling
    from tcp_muscle_ros.report.tables import calibration_table

    tell_of_compiling()
    output, nominal, experiments = admit(args)
    with Progress('calibrating') as progress:
        calibration = calibrate(experiments, nominal.parameters, separate=args.separate, progress=progress.beat)
    for experiment in calibration.fit.problem.experiments:
        for note in experiment.notes:
            print(f'note: {experiment.name}: {note}')
    print(calibration_table(calibration))
    write_muscle(output, calibration, nominal.operating, 'tcp_muscle calibrate', args.params, force=args.force)
    print(f'{output}: loads into sim_node and replay; its intervals are beside it')
    return 0


def add_separate_argument(parser: argparse.ArgumentParser) -> None:
    """Add ``--separate``."""
    parser.add_argument(
        '--separate',
        action='append',
        default=[],
        metavar='NAME',
        help='a parameter that is fitted to each recording alone, e.g. B for runs of several specimens (repeatable)',
    )


def refuse_unknown(separate: Sequence[str]) -> None:
    """BadInput for the name of what no recording can have for itself."""
    from tcp_muscle_ros.diagnosis.model.tcp_muscle import SEPARABLE
    from tcp_muscle_ros.errors import BadInput, Option

    for name in separate:
        if name not in SEPARABLE:
            named = Option(f'--separate {name}', f"separate=('{name}',)")
            raise BadInput(named, f': expected one of {", ".join(SEPARABLE)}')


def admitted(recordings: Sequence[Recording], nominal: ParameterFile, most: int) -> list[Experiment]:
    """Recordings that a calibration can use, averaged to at most so many observations. BadInput as the gate says."""
    from tcp_muscle_ros.diagnosis.observation.admission import refuse_still
    from tcp_muscle_ros.diagnosis.observation.observe import whole
    from tcp_muscle_ros.recording.leaps import as_made

    experiments = whole(as_made(recordings), nominal, most)
    refuse_still(experiments)
    return experiments


def calibrated(
    recordings: Sequence[Recording],
    nominal: ParameterFile,
    separate: Sequence[str],
    most: int,
    progress: Callable[[], None],
) -> Calibration:
    """A calibration on recordings, averaged to at most so many observations. BadInput as the gate says."""
    from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate

    refuse_unknown(separate)
    return calibrate(admitted(recordings, nominal, most), nominal.parameters, separate=separate, progress=progress)


def write_muscle(
    path: str | Path,
    calibration: Calibration,
    operating: Mapping[str, Setting],
    by: str,
    params: object = '',
    *,
    force: bool = False,
) -> None:
    """Write a calibrated muscle and its intervals beside it, both or neither; ``by`` and ``params``: made by, from."""
    from tcp_muscle_ros.files.outputs import in_place_of, writable_file
    from tcp_muscle_ros.report.intervals_file import write_intervals
    from tcp_muscle_ros.report.tables import calibration_note
    from tcp_muscle_ros.settings.ages import write_ages
    from tcp_muscle_ros.settings.intervals import path_beside
    from tcp_muscle_ros.settings.parameter_file import write

    output = writable_file(path, force=force)
    intervals = writable_file(path_beside(output), force=force)
    recordings = len(calibration.fit.problem.experiments)
    heading = f'Calibrated by {by} on {recordings} recording(s){f", from {params}" if params else ""}.'
    says = calibration_note(calibration)
    with in_place_of(intervals) as beside, in_place_of(output) as draft:
        write(draft, calibration.parameters, operating=operating, heading=(heading,), note=says)
        write_intervals(beside, calibration.known)
    write_ages(output, ())

"""One diagnosis from bags to report, as ``diagnose`` and each run of a campaign do it."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tcp_muscle_ros.commands.progress import Progress
    from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis
    from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
    from tcp_muscle_ros.recording.recording import Recording
    from tcp_muscle_ros.settings.parameter_file import ParameterFile
    from tcp_muscle_ros.settings.rig import Rig


def diagnose_bags(
    options: argparse.Namespace,
    bags: Sequence[str],
    params: str,
    output: Path,
    progress: Progress | None = None,
    *,
    place: Path | None = None,
    force: bool = False,
) -> Diagnosis:
    """Diagnose bags of one muscle and write the report; partial where it was interrupted.

    ``options``: how bags are read (``add_bag_arguments``). ``place``: where the report will stand in the end, if that
    is not ``output``. ``force``: an older report is replaced.
    Raises BadInput.
    """
    from tcp_muscle_ros.commands.bag_arguments import other_topics, read_bags, reading_options
    from tcp_muscle_ros.report.next_steps import Asked
    from tcp_muscle_ros.report.write import write_report
    from tcp_muscle_ros.settings.parameter_file import read
    from tcp_muscle_ros.settings.rig import read_rig

    nominal = read(params)
    separate = tuple(getattr(options, 'separate', ()))
    known = getattr(options, 'rig', None) or ''
    rig = read_rig(known) if known else None
    diagnosis, experiments = diagnosed(read_bags(options, *bags), nominal, progress, separate, rig)
    if progress:
        progress.stage('writing the report')
    asked = Asked(
        tuple(bags),
        params,
        str(place or output),
        reading_options(options),
        rig=known,
        separate=separate,
        namespace=options.namespace or '',
        topics=other_topics(options),
    )
    write_report(output, diagnosis, experiments, nominal.operating, asked=asked, force=force)
    return diagnosis


def diagnosed(
    recordings: list[Recording],
    nominal: ParameterFile,
    progress: Progress | None = None,
    separate: Sequence[str] = (),
    rig: Rig | None = None,
) -> tuple[Diagnosis, list[Experiment]]:
    """Diagnose recordings of one muscle, partial where it was interrupted; and what of them the model followed.

    ``separate``: the parameters that each recording has for itself. ``rig``: what is known of the rig.

    Empties ``recordings``: a long one is let go before it is replayed. Raises BadInput.
    """
    from dataclasses import replace

    from tcp_muscle_ros.diagnosis.answer.improved import with_replay
    from tcp_muscle_ros.diagnosis.answer.issues import faults_of, with_faults, with_issues
    from tcp_muscle_ros.diagnosis.diagnose import Interrupted, diagnose
    from tcp_muscle_ros.diagnosis.observation.observe import prepared
    from tcp_muscle_ros.process.memory import give_back
    from tcp_muscle_ros.recording.leaps import as_made

    recordings[:] = as_made(recordings)  # a muscle wears from one to the next, in whichever order they are named
    mended, experiments = prepared(recordings, nominal)
    beat = progress.beat if progress else None
    try:
        diagnosis = diagnose(experiments, nominal.parameters, separate=separate, rig=rig, progress=beat)
    except Interrupted as stop:
        diagnosis = replace(stop.partial, partial=True)
    give_back()
    diagnosis = with_issues(diagnosis, recordings, mended, experiments)
    faults = faults_of(mended)
    del mended
    return with_faults(with_replay(diagnosis, recordings, nominal.operating), faults), experiments

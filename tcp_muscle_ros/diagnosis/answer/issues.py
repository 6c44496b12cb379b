"""What the checks, the reader and the preparation say of each recording, told with what was found in it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.recording.checks import check
from tcp_muscle_ros.recording.mending import Mended
from tcp_muscle_ros.recording.recording import CHANNELS, Recording


def with_issues(
    diagnosis: Diagnosis, recordings: Sequence[Recording], mended: Sequence[Mended], experiments: Sequence[Experiment]
) -> Diagnosis:
    """The diagnosis with what the checks, the reader and the preparation say of each recording.

    What the checks say of a recording that was cut stands with its first part.
    """
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


def _once(issues: Sequence[str]) -> tuple[str, ...]:
    """Each sentence once; what is said of several channels in the same words, with all their names before it."""
    names: dict[str, list[str]] = {}
    for issue in issues:
        channel, colon, rest = issue.partition(': ')
        of_channel = bool(colon) and channel in CHANNELS
        found = names.setdefault(rest if of_channel else issue, [])
        if of_channel and channel not in found:
            found.append(channel)
    return tuple(f'{", ".join(channels)}: {said}' if channels else said for said, channels in names.items())


def faults_of(mended: Sequence[Mended]) -> list[str]:
    """The sensors that stood still, a sentence each."""
    many = len(mended) > 1
    return [
        fault.sentence + (f' in recording {Path(m.parts[0].path).name}' if many else '')
        for m in mended
        for fault in m.faults
    ]


def with_faults(diagnosis: Diagnosis, faults: Sequence[str]) -> Diagnosis:
    """The diagnosis with the sensors that stood still: a fault of the set-up, where nothing stronger was found."""
    if not faults:
        return diagnosis
    weaker = diagnosis.verdict in ('match', 'wrong_parameters', 'not_repeatable')
    verdict = 'sensor_or_setup' if weaker else diagnosis.verdict
    told = f'{faults[0][0].upper()}{faults[0][1:]}'
    more = f' ({len(faults) - 1} more in the report)' if len(faults) > 1 else ''
    headline = f'{told}{more}; that was left out. {diagnosis.headline}'
    return replace(diagnosis, verdict=verdict, headline=headline, notes=(*diagnosis.notes, *faults))


def _averaged(experiment: Experiment) -> list[str]:
    """Which channels were averaged in blocks, and in how long ones."""
    widest = {name: int(o.count.max()) for name, o in experiment.observed.items() if o.count.max() > 1}
    told = ', '.join(f'{name} ({width})' for name, width in widest.items())
    return [f'averaged in blocks of up to so many samples: {told}'] if told else []

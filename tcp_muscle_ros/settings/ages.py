"""How old a muscle was when it was recorded, kept beside the parameter file that holds it as it is now.

A muscle that wears (``fatigue.n0`` cycles, ``resistance_drift.w0`` seconds before) is written as it is after the last
recording. ``MUSCLE.ages.json`` has its age at the beginning of each recording, which is known by the stamp of its
start, and where that is no date by its readings: a replay of one of them runs the muscle as old as it was then, a
replay of anything else as old as it is now. A simulation's clock begins at 0, so the stamps of its bags are no dates.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording.leaps import dated
from tcp_muscle_ros.recording.mending import mend
from tcp_muscle_ros.recording.recording import Recording
from tcp_muscle_ros.settings.rig import Rig, on_rig

_SAME = 1.0  # s, by which the ends of one recording may differ

SCHEMA = 'tcp_muscle_ros/ages-1'


@dataclass(frozen=True)
class Age:
    """The parameters that count what went before, as they were when a recording began (``start_ns``, of its clock) that
    ended ``end`` s later and has this ``fingerprint``; None and empty where that is not known."""

    start_ns: int
    values: Mapping[str, float]
    end: float | None = None
    fingerprint: str = ''


def path_beside(parameter_file: str | Path) -> Path:
    """Where the ages of a parameter file are."""
    return Path(parameter_file).with_suffix('.ages.json')


def write_ages(parameter_file: str | Path, ages: Sequence[Age]) -> None:
    """Write them beside a parameter file; for a muscle that does not age, those of another that was there go."""
    if not any(age.values for age in ages):
        path_beside(parameter_file).unlink(missing_ok=True)
    else:
        recordings = [
            {'start_ns': age.start_ns, 'end_s': age.end, 'fingerprint': age.fingerprint, 'values': dict(age.values)}
            for age in ages
        ]
        content = {'schema': SCHEMA, 'recordings': recordings}
        path_beside(parameter_file).write_text(json.dumps(content, indent=1) + '\n', encoding='utf-8')


def read_ages(parameter_file: str | Path) -> tuple[Age, ...]:
    """Those beside a parameter file; none where there are none that this version knows."""
    path = path_beside(parameter_file)
    if not path.is_file():
        return ()
    try:
        content = json.loads(path.read_text(encoding='utf-8'))
        if content['schema'] != SCHEMA:
            return ()
        return tuple(
            Age(int(entry['start_ns']), dict(entry['values']), entry.get('end_s'), entry.get('fingerprint', ''))
            for entry in content['recordings']
        )
    except (ValueError, KeyError, TypeError):
        return ()


def as_old_as_then(muscle: Parameters, ages: Sequence[Age], recording: Recording) -> Parameters:
    """The muscle as it was when the recording was made, where that is surely one of those; else as it is."""
    age = _begun(ages, recording.start_ns) if dated(recording) else _undated(ages, recording)
    return muscle.replace(age.values) if age else muscle


def _begun(ages: Sequence[Age], start_ns: int) -> Age | None:
    return next((age for age in ages if age.start_ns == start_ns), None)


def _undated(ages: Sequence[Age], recording: Recording) -> Age | None:
    """The age in a recording without a date: they may all begin at the same instant, and those of one protocol are
    equally long. Files written before fingerprints were go by the length, where only one has it."""
    if any(age.fingerprint for age in ages):
        fingerprint = mend(recording).parts[0].fingerprint  # a diagnosis saw what can be followed of it
        return next((age for age in ages if age.fingerprint == fingerprint), None)
    alike = [
        age
        for age in ages
        if age.start_ns == recording.start_ns and (age.end is None or abs(age.end - recording.end) <= _SAME)
    ]
    return alike[0] if len(alike) == 1 else None


def as_recorded(muscle: Parameters, parameter_file: str | Path, rig: Rig | None, recording: Recording) -> Parameters:
    """The muscle of a parameter file as a rig's instruments show it, and as old as it was in the recording."""
    return as_old_as_then(on_rig(muscle, rig), read_ages(parameter_file), recording)

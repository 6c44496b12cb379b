"""From recordings as they were read to experiments: what is none is refused, what no model can follow is cut out."""

from collections.abc import Sequence

from tcp_muscle_ros.diagnosis.observation.admission import admit, refuse_other_scale
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.holding import Conditions
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import ZERO_CELSIUS
from tcp_muscle_ros.recording.mending import Mended, mend
from tcp_muscle_ros.recording.recording import OUTPUTS, Recording
from tcp_muscle_ros.settings.parameter_file import ParameterFile

# More observations a channel than this are averaged in blocks: a muscle is slow, and time and memory stay bounded.
MOST = 1000


def prepared(
    recordings: Sequence[Recording], nominal: ParameterFile, most: int = MOST
) -> tuple[list[Mended], list[Experiment]]:
    """What a model can follow of each recording, and all its parts as experiments of at most so many observations."""
    _admit(recordings, nominal)
    mended = [_mended(recording) for recording in recordings]
    return mended, _experiments([part for m in mended for part in m.parts], nominal, most)


def whole(recordings: Sequence[Recording], nominal: ParameterFile, most: int | None = None) -> list[Experiment]:
    """Recordings as they are, through the same gate but not mended, as experiments of at most so many observations."""
    _admit(recordings, nominal)
    return _experiments(recordings, nominal, most)


def _admit(recordings: Sequence[Recording], nominal: ParameterFile) -> None:
    given = conditions(nominal)
    for recording in recordings:
        admit(recording, nominal.parameters, ambient=given.ambient, load=given.load)


def _experiments(recordings: Sequence[Recording], nominal: ParameterFile, most: int | None) -> list[Experiment]:
    given = conditions(nominal)
    experiments = [prepare(recording, nominal.parameters, given, most) for recording in recordings]
    for experiment, recording in zip(experiments, recordings, strict=True):
        refuse_other_scale(experiment, nominal.parameters, recording)
    return experiments


def _mended(recording: Recording) -> Mended:
    """What a model can follow of a recording. BadInput where nothing is left."""
    mended = mend(recording)
    if mended.faults and not any(name in part for part in mended.parts for name in OUTPUTS):
        raise BadInput(f'{recording.path}: {mended.faults[0].sentence}, and nothing else was recorded')
    return mended


def conditions(file: ParameterFile) -> Conditions:
    """What the parameter file says of the run: load, ambient, end. Only what stands in it."""
    given = file.operating
    return Conditions(
        load=file.number('load_n') if 'load_n' in given else None,
        ambient=file.number('ambient_temperature_c') + ZERO_CELSIUS if 'ambient_temperature_c' in given else None,
        end=file.text('end') if 'end' in given else None,
        held_length=file.number('held_length_m'),
        spring_rate=file.number('spring_rate_n_per_m'),
        spring_rest_length=file.number('spring_rest_length_m'),
    )

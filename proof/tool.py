"""The package under test, as the proof uses it: read the bags of a case, diagnose it, replay what came out of it.

This and the alternatives are all of the proof that knows the package; what makes recordings and labels does not.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis
from tcp_muscle_ros.diagnosis.answer.replaying import ReplayedErrors, own_of
from tcp_muscle_ros.diagnosis.diagnose import diagnose
from tcp_muscle_ros.diagnosis.fitting.calibration import Calibration, ages, calibrate, in_turn
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.hypothesis.latents import Latent
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.hypothesis.unknowns import own_unknowns
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT
from tcp_muscle_ros.diagnosis.noise.noise import quick_noise
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.observe import MOST, conditions, prepared
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.muscle import Outputs, Parameters
from tcp_muscle_ros.process.memory import give_back
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.report.protocol_file import write_improved, write_protocol
from tcp_muscle_ros.report.report_json import IMPROVED, PROTOCOL, RIG, write_json
from tcp_muscle_ros.settings.ages import as_recorded, write_ages
from tcp_muscle_ros.settings.operating import DEFAULT_SET
from tcp_muscle_ros.settings.parameter_file import ParameterFile, read, write
from tcp_muscle_ros.settings.rig import read_rig, render_rig

REPORT, HELD_OUT, FAILED = 'report.json', 'held_out.json', 'failed'
QUICK = 500  # samples a channel of a held-out recording, for the diagnosis and all others
ROUNDS = 12  # of fitting the start of a held-out recording


@dataclass
class Case:
    """The recordings of one case, with what every alternative begins from."""

    folder: Path
    most: int = MOST  # samples a channel, as the diagnosis has

    @property
    def name(self) -> str:
        """Of its folder."""
        return self.folder.name

    @cached_property
    def file(self) -> ParameterFile:
        """The parameter file of the case, or the package's default."""
        path = self.folder / 'parameters.yaml'
        return read(str(path) if path.is_file() else DEFAULT_SET)

    @property
    def nominal(self) -> Parameters:
        """The muscle as the lab believes it to be."""
        return self.file.parameters

    @cached_property
    def experiments(self) -> list[Experiment]:
        """All recordings, ready for the model."""
        return experiments_of(self.folder, self.nominal, self.most)

    @cached_property
    def calibration(self) -> Calibration:
        """The paper's parameters fitted to them, one after the other."""
        found = calibrate(self.experiments, self.nominal)
        return replace(found, fit=in_turn(found.fit))


def experiments_of(folder: Path, nominal: Parameters, most: int) -> list[Experiment]:
    """The recordings in a folder, ready for the model."""
    return [prepare(read_bag(str(path)), nominal, None, most) for path in bags(folder)]


def bags(folder: Path) -> list[Path]:
    """The recordings in a folder in their order."""
    return sorted(folder.glob('recording_*'), key=lambda path: int(path.name.rpartition('_')[2]))


def guarded(name: str, out: Path, work: Callable[[], None]) -> str | None:
    """Work on a case, whose answer goes to the folder ``out``. What went wrong is noted there, and returned."""
    (out / FAILED).unlink(missing_ok=True)
    try:
        work()
    except Exception as error:  # a case must not stop the other 429
        out.mkdir(parents=True, exist_ok=True)
        (out / FAILED).write_text(f'{type(error).__name__}: {error}\n', encoding='utf-8')
        return f'{name}: {type(error).__name__}: {error}'
    return None


def tried(out: Path) -> bool:
    """Is an answer in this folder, or the note that there is none?"""
    return (out / REPORT).is_file() or (out / FAILED).is_file()


def diagnose_case(folder: Path, reports: Path, most: int, progress: Callable[[], None] | None = None) -> Diagnosis:
    """What `tcp_muscle diagnose` says, without figures: improved.yaml, next_protocol.yaml, and report.json last."""
    nominal = Case(folder).file
    _, experiments = prepared([read_bag(str(path)) for path in bags(folder)], nominal, most)
    give_back()  # what the case before left
    found = diagnose(experiments, nominal.parameters, progress=progress)
    out = reports / folder.name
    out.mkdir(parents=True, exist_ok=True)
    write_improved(out / IMPROVED, found, nominal.operating)
    write_ages(out / IMPROVED, found.ages)
    (out / RIG).write_text(render_rig(found.rig), encoding='utf-8')
    if found.next_experiment is not None:
        write_protocol(out / PROTOCOL, found.next_experiment, experiments[0].holding)
    write_json(out / REPORT, found)
    return found


def write_muscle(path: Path, muscle: Parameters) -> None:
    """A parameter file that `improved` reads again."""
    write(path, muscle)


def improved(folder: Path) -> Parameters:
    """The muscle that a report ends with."""
    return read(str(folder / IMPROVED)).parameters


@dataclass(frozen=True)
class Replayed:
    """A free run beside a recording: the model's outputs, and by channel recorded minus predicted (SI)."""

    experiment: Experiment
    outputs: Outputs
    left: dict[str, np.ndarray]


def users_errors(report: Path, folder: Path) -> dict[str, float]:
    """What `tcp_muscle replay` of improved.yaml and rig.yaml shows on the recordings in a folder: RMSE by channel."""
    file, rig = read(str(report / IMPROVED)), read_rig(report / RIG)
    errors = ReplayedErrors()
    for path in bags(folder):
        recording = read_bag(str(path))
        muscle = as_recorded(file.parameters, report / IMPROVED, rig, recording)
        experiment = prepare(recording, file.parameters, conditions(file), QUICK)
        errors.add(experiment, muscle, own_of(experiment, muscle))
    return errors.rmse()


def replay(experiment: Experiment, muscle: Parameters, before: Sequence[Experiment] = ()) -> Replayed:
    """Run a muscle freely under the recorded inputs, as old as it is after the recordings ``before``.

    Fitted is only what the recording brings of its own: the room, the temperature and other states at the start, the
    zero of displacement and force. They are no property of a muscle.
    """
    earlier = ages([*before, experiment], [e.outputs(muscle) for e in before])[-1]
    own = own_unknowns(experiment, muscle)
    problem = Problem((experiment,), muscle, own, quick_noise([experiment]), (Latent(earlier),))
    return replayed(fit(problem, rounds=ROUNDS, tolerance=1e-5), 0)


def replayed(fitted: Fit, k: int) -> Replayed:
    """Recording k of a fit, with the room as it was fitted."""
    experiment, values = fitted.problem.experiments[k], fitted.values
    if (AMBIENT, k) in values:
        room = np.full(experiment.imposed.time.size, values[AMBIENT, k])
        experiment = replace(experiment, imposed=replace(experiment.imposed, ambient=room))
    return Replayed(experiment, fitted.outputs[k], fitted.left[k])


def errors(runs: list[Replayed]) -> dict[str, float]:
    """Root mean square by channel over all recordings (SI)."""
    found: dict[str, list[np.ndarray]] = {}
    for one in runs:
        for name, left in one.left.items():
            found.setdefault(name, []).append(left)
    return {name: float(np.sqrt(np.mean(np.concatenate(parts) ** 2))) for name, parts in found.items()}

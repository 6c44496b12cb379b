"""Everything that a diagnosis leaves behind, in one new folder."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import FORCE, OUTPUT, in_place_of, writable_folder
from tcp_muscle_ros.report.diagnosis_figures import draw_all
from tcp_muscle_ros.report.intervals_file import write_intervals
from tcp_muscle_ros.report.next_steps import Asked
from tcp_muscle_ros.report.overlay import write_diagnosis_overlay
from tcp_muscle_ros.report.page import write_html
from tcp_muscle_ros.report.protocol_file import write_improved, write_protocol
from tcp_muscle_ros.report.report_json import IMPROVED, PROTOCOL, RIG, write_json
from tcp_muscle_ros.settings.ages import write_ages
from tcp_muscle_ros.settings.intervals import path_beside
from tcp_muscle_ros.settings.parameter_file import Value as Setting
from tcp_muscle_ros.settings.rig import render_rig

_RIG_HEADING = (
    'What the instruments do, by tcp_muscle diagnose. For --rig, and rig_file of sim_node.\n'
    'The limits are those of the rig that was given by --rig. Without one, loads_n and held_end are what was\n'
    'recorded, and so is largest_current_a where a current was; of a power or a voltage it is by the resistance of\n'
    'improved.yaml. Where next_protocol.yaml needs more, that is added. All else is usual, and was not measured:\n'
    'check highest_temperature_c, loads_by and longest_run_s (an hour, or the longest recording where that is\n'
    'longer) before a protocol is played by them.'
)


def refuse_report(directory: str | Path, *, force: bool = False) -> Path:
    """The folder of a new report. BadInput unless it is empty or can be made, or may be replaced by ``force``."""
    path = Path(directory)
    if not path.absolute().parent.is_dir():
        raise BadInput(f'{path}: the folder {path.absolute().parent} does not exist')
    if path.is_dir() and not any(path.iterdir()):
        return path
    if path.exists() and not path.is_dir():
        raise BadInput(f'{path}: is a file; expected a folder that does not exist yet')
    if path.is_dir() and not force:
        raise BadInput(f'{path}: is not empty and is not overwritten; give another ', OUTPUT, ', or ', FORCE)
    return writable_folder(path, force=force)


def write_report(
    directory: str | Path,
    diagnosis: Diagnosis,
    experiments: Sequence[Experiment],
    operating: Mapping[str, Setting] | None = None,
    *,
    asked: Asked | None = None,
    force: bool = False,
) -> None:
    """Write report.json, report.html, figures/, improved.yaml and what stands beside it, rig.yaml, overlay/ and, if
    there is one, next_protocol.yaml.

    The folder is there once all of it is; an older report goes only then, and only under ``force``.

    ``operating``: what else stood in the parameter file that the diagnosis began with; goes into improved.yaml.
    ``asked``: which bags were diagnosed and how, for commands that can be pasted.

    Raises:
        BadInput: the folder holds something already, or cannot be written.
    """
    with in_place_of(refuse_report(directory, force=force)) as path:
        (path / 'figures').mkdir(parents=True)
        figures = draw_all(path / 'figures', diagnosis)
        write_html(path / 'report.html', diagnosis, figures, path / 'figures', asked)
        write_improved(path / IMPROVED, diagnosis, operating)
        if diagnosis.known is not None:
            write_intervals(path_beside(path / IMPROVED), diagnosis.known)
        write_ages(path / IMPROVED, diagnosis.ages)
        (path / RIG).write_text(render_rig(diagnosis.rig, _RIG_HEADING), encoding='utf-8')
        if diagnosis.next_experiment is not None:
            end = diagnosis.next_experiment.end
            holding = next((e.holding for e in experiments if e.holding.end == end), None)
            write_protocol(path / PROTOCOL, diagnosis.next_experiment, holding)
        if experiments:
            write_diagnosis_overlay(path / 'overlay', experiments, diagnosis.series)
        write_json(path / 'report.json', diagnosis)

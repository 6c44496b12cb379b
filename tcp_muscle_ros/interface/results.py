"""What a calibration, a diagnosis and a plot give back: tables, files, and a display of their own in a notebook."""

from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis, Value
from tcp_muscle_ros.diagnosis.answer.improved import operating_with_room, physics_only
from tcp_muscle_ros.diagnosis.fitting.calibration import Calibration
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.interface.wording import in_python
from tcp_muscle_ros.muscle import SPECIFICATIONS
from tcp_muscle_ros.settings.parameter_file import ParameterFile
from tcp_muscle_ros.settings.parameter_file import Value as Setting

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Calibrated:
    """A calibrated muscle; may be given as ``params``."""

    calibration: Calibration
    operating: Mapping[str, Setting]

    @property
    def file(self) -> ParameterFile:
        """The muscle as a parameter file has it."""
        return ParameterFile(self.calibration.parameters, self.operating)

    @property
    def table(self) -> 'pd.DataFrame':
        """A row a parameter: nominal, value, low and high (90 %), unit, and whether the data fix it."""
        import pandas as pd

        rows = []
        for e in self.calibration.estimates:
            row = SPECIFICATIONS.get(e.name)
            edge = row.to_edge if row is not None else float
            unit = row.edge_unit if row is not None else e.unit
            name = e.name if e.recording is None else f'{e.name} [{e.recording + 1}]'
            rows.append((name, edge(e.nominal), edge(e.value), edge(e.low), edge(e.high), unit, e.fixed))
        heads = ['parameter', 'nominal', 'value', 'low', 'high', 'unit', 'fixed']
        return pd.DataFrame(rows, columns=heads).set_index('parameter')

    def value(self, name: str, digits: int = 2) -> float:
        """One parameter in the unit of parameter files, to so many significant digits."""
        try:
            found = SPECIFICATIONS[name].to_edge(self.calibration.parameters[name])
        except KeyError:
            raise BadInput(f"unknown parameter '{name}'{nearest(name, SPECIFICATIONS)}") from None
        return float(f'{found:.{digits}g}')

    @in_python
    def save(self, path: str | Path, *, force: bool = False) -> None:
        """Write the parameter file, and its intervals beside it. BadInput: something is there, and not ``force``."""
        from tcp_muscle_ros.commands.calibrate import write_muscle

        write_muscle(path, self.calibration, self.operating, 'tcp_muscle_ros.calibrate', force=force)

    def __repr__(self) -> str:
        from tcp_muscle_ros.report.tables import calibration_table

        return calibration_table(self.calibration)

    def _repr_html_(self) -> str:
        return f'<pre>{escape(repr(self))}</pre>'


@dataclass(frozen=True, repr=False)
class Diagnosed:
    """A diagnosis; as ``params`` it is the improved muscle."""

    diagnosis: Diagnosis
    experiments: tuple[Experiment, ...]
    operating: Mapping[str, Setting]

    @property
    def verdict(self) -> str:
        """``match``, ``wrong_parameters``, ``missing_physics`` ... (see docs/reading_a_report.md)."""
        return self.diagnosis.verdict

    @property
    def headline(self) -> str:
        """The outcome in a sentence."""
        return self.diagnosis.headline

    @property
    def file(self) -> ParameterFile:
        """The improved muscle as ``improved.yaml`` has it: its physics, without what belongs to sensors."""
        return ParameterFile(physics_only(self.diagnosis.improved), operating_with_room(self.diagnosis, self.operating))

    @property
    def findings(self) -> 'pd.DataFrame':
        """A row a finding: effect, stage, probability, and what the data do not tell it from."""
        import pandas as pd

        rows = [
            (f.effect, f.stage, f.probability, ', '.join(f.indistinguishable_from)) for f in self.diagnosis.findings
        ]
        return pd.DataFrame(rows, columns=['effect', 'stage', 'probability', 'indistinguishable_from'])

    @property
    def calibration(self) -> 'pd.DataFrame':
        """A row a parameter of the muscle: nominal, value, low and high (90 %), in SI."""
        import pandas as pd

        values: Mapping[str, Value] = self.diagnosis.calibration
        rows = {name: (v.nominal, v.value, v.low, v.high, v.unit) for name, v in values.items()}
        return pd.DataFrame.from_dict(rows, orient='index', columns=['nominal', 'value', 'low', 'high', 'unit'])

    @in_python
    def save(self, path: str | Path, *, force: bool = False) -> None:
        """Write the improved muscle as a parameter file, and its intervals beside it. BadInput: something is there, and
        not ``force``."""
        from tcp_muscle_ros.files.outputs import in_place_of, remove, writable_file
        from tcp_muscle_ros.report.intervals_file import write_intervals
        from tcp_muscle_ros.report.protocol_file import write_improved
        from tcp_muscle_ros.settings import ages
        from tcp_muscle_ros.settings.intervals import path_beside

        output = writable_file(path, force=force)
        intervals = writable_file(path_beside(output), force=force)
        writable_file(ages.path_beside(output), force=force)
        with in_place_of(intervals) as beside, in_place_of(output) as draft:
            write_improved(draft, self.diagnosis, self.operating)
            if self.diagnosis.known is not None:
                write_intervals(beside, self.diagnosis.known)
        if self.diagnosis.known is None:  # those of another muscle
            remove(intervals)
        ages.write_ages(output, self.diagnosis.ages)

    @in_python
    def report(self, folder: str | Path, *, force: bool = False) -> Path:
        """Write the whole report, as ``tcp_muscle diagnose``; returns the path of its page."""
        from tcp_muscle_ros.report.write import write_report

        write_report(folder, self.diagnosis, self.experiments, self.operating, force=force)
        return Path(folder) / 'report.html'

    def __repr__(self) -> str:
        from tcp_muscle_ros.report.terminal import summary

        return summary(self.diagnosis)

    def _repr_html_(self) -> str:
        """Headline, findings with their sentences, errors before and after."""
        from tcp_muscle_ros.report.words import chance, fit_texts, plain, verdict_words

        d = self.diagnosis
        rows = ''.join(
            f'<tr><td>{escape(plain(f.effect))}</td><td>{escape(f.stage)}</td><td>{escape(chance(f.probability))}</td>'
            f'<td>{escape(f.sentence)}</td></tr>'
            for f in d.findings
        )
        heads = '<tr><th>effect</th><th>stage</th><th>probability</th><th></th></tr>'
        found = f'<table><thead>{heads}</thead><tbody>{rows}</tbody></table>' if d.findings else ''
        errors = ''.join(
            f'<tr><td>{escape(plain(name))}</td>'
            + ''.join(f'<td>{escape(text)}</td>' for text in fit_texts(name, f))
            + '</tr>'
            for name, f in d.fit.items()
        )
        heads = '<tr><th>RMSE</th><th>nominal</th><th>recalibrated</th><th>improved</th><th>noise</th></tr>'
        fit = f'<table><thead>{heads}</thead><tbody>{errors}</tbody></table>' if d.fit else ''
        verdict = f'verdict: {verdict_words(d)} ({d.verdict})'
        return f'<div><p><b>{escape(d.headline)}</b></p><p>{escape(verdict)}</p>{found}{fit}</div>'


@dataclass(frozen=True, repr=False)
class Picture:
    """A drawing; shown by a notebook, or saved."""

    figure: 'Figure'

    @in_python
    def save(self, path: str | Path, *, force: bool = False) -> None:
        """Write a .png, .pdf or .svg. BadInput: something is there, and not ``force``."""
        from tcp_muscle_ros.files.outputs import in_place_of
        from tcp_muscle_ros.report.style import picture_path, save

        with in_place_of(picture_path(path, force=force)) as draft:
            save(self.figure, draft)

    def __repr__(self) -> str:
        return f'Picture with {len(self.figure.axes)} panels'

    def _repr_png_(self) -> bytes:
        page = BytesIO()
        self.figure.savefig(page, format='png', dpi=110)
        return page.getvalue()

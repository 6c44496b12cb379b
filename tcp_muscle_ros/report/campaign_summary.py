"""Many diagnoses in one table: for the terminal, for a spreadsheet, for programs."""

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from io import StringIO
from pathlib import Path
from typing import Any

from tcp_muscle_ros.report.tables import table
from tcp_muscle_ros.report.words import error_text, plain

SCHEMA = 'tcp_muscle_ros/campaign-1'
NOT_DONE = 'not done yet'  # the reason of a run that Ctrl-C came before
_CHANNELS = ('displacement', 'force', 'temperature', 'resistance')  # whose error is told where no misfit was located


@dataclass(frozen=True)
class Row:
    """One run: its place among the others, and the content of its report.json or why there is none."""

    name: str
    muscle: str | None
    cycles: float | None
    day: date | None
    report: Mapping[str, Any] | None
    reason: str | None

    @property
    def parameters(self) -> dict[str, Mapping[str, Any]]:
        """The muscle's calibrated parameters that the data fix, as in the report."""
        if self.report is None:
            return {}
        sensors = set(self.report['sensors'])
        found = self.report['calibration'].items()
        return {name: value for name, value in found if name not in sensors and value['fixed_by_data']}

    @property
    def channel(self) -> str | None:
        """The channel whose error is told: where the misfit is, else the first that was recorded."""
        if self.report is None or not self.report['fit']:
            return None
        if self.report['location'] and self.report['location']['channel'] in self.report['fit']:
            return str(self.report['location']['channel'])
        return next(name for name in _CHANNELS if name in self.report['fit'])


def terminal_table(rows: Sequence[Row]) -> str:
    """Run, verdict, first finding, probability, error before and after; then what failed, one line each."""
    body = []
    for row in rows:
        if row.report is None:
            body.append([row.name, 'failed' if row.reason != NOT_DONE else 'not done', '-', '-', '-'])
            continue
        first = row.report['findings'][0] if row.report['findings'] else None
        found = [plain(first['effect']), _probability(first['probability'])] if first else ['-', '-']
        body.append([row.name, row.report['verdict'], *found, _errors(row)])
    lines = [table(['run', 'verdict', 'first finding', 'probability', 'held-out error'], body)]
    failed = [row for row in rows if row.report is None and row.reason != NOT_DONE]
    if failed:
        lines += ['', f'{len(failed)} of {len(rows)} runs failed:']
        lines += [f'  {row.name}: {row.reason}' for row in failed]
    return '\n'.join(lines)


def _probability(value: float | None) -> str:
    return '-' if value is None else f'{value:.2f}'


def _errors(row: Row) -> str:
    if row.report is None or row.channel is None:
        return '-'
    before, after = _before_after(row.report['fit'][row.channel])
    return f'{row.channel} {error_text(row.channel, before, unit=False)} to {error_text(row.channel, after)}'


def _before_after(fit: Mapping[str, Any]) -> tuple[float, float]:
    """Of the recalibrated muscle without and with what was found, on data left out of the fit."""
    nothing, unseen = float('nan'), fit['held_out'] or {}
    before, after = unseen.get('rmse_without'), unseen.get('rmse_with')
    return nothing if before is None else before, nothing if after is None else after


def write_csv(path: Path, rows: Sequence[Row]) -> None:
    """One line a run, SI units in the heads where they do not depend on the channel; parameters with intervals."""
    names = list(dict.fromkeys(name for row in rows for name in row.parameters))
    text = StringIO()
    writer = csv.writer(text, lineterminator='\n')
    heads = ['run', 'muscle', 'cycles', 'day', 'verdict', 'first_finding', 'probability']
    heads += ['channel', 'held_out_rmse_before', 'held_out_rmse_after']
    writer.writerow([*heads, *(f'{name}{end}' for name in names for end in ('', '_low', '_high')), 'failed'])
    for row in rows:
        line: list[Any] = [row.name, row.muscle, row.cycles, row.day]
        if row.report is None:
            line += [None] * 6
        else:
            first = row.report['findings'][0] if row.report['findings'] else {}
            fit = row.report['fit'].get(row.channel, {}).get('held_out') or {}
            line += [row.report['verdict'], first.get('effect'), first.get('probability')]
            line += [row.channel, fit.get('rmse_without'), fit.get('rmse_with')]
        for name in names:
            value = row.parameters.get(name, {})
            line += [value.get('value'), value.get('low'), value.get('high')]
        writer.writerow([*line, row.reason])
    _replace(path, text.getvalue())


def write_json(path: Path, rows: Sequence[Row]) -> None:
    """What trends are made of, by run, in the units of report.json."""
    runs = []
    for row in rows:
        run: dict[str, Any] = {
            'name': row.name,
            'muscle': row.muscle,
            'cycles': row.cycles,
            'day': row.day.isoformat() if row.day else None,
            'failed': row.reason,
        }
        if row.report is not None:
            run |= {key: row.report[key] for key in ('verdict', 'headline', 'findings', 'fit', 'calibration')}
            run['report'] = f'{row.name}/report.json'
        runs.append(run)
    _replace(path, json.dumps({'schema': SCHEMA, 'runs': runs}, indent=1, ensure_ascii=False) + '\n')


def _replace(path: Path, text: str) -> None:
    """Whole or not at all."""
    draft = path.with_name(f'.{path.name}')
    draft.write_text(text, encoding='utf-8')
    draft.replace(path)

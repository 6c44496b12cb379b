"""``report.html``: one self-contained page that opens with the outcome in a sentence. Nothing is fetched.

The page itself is ``templates/report.html.j2``; this module says what stands in it.
"""

from base64 import b64encode
from collections.abc import Mapping, Sequence
from importlib import resources
from math import isfinite
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis, Finding, Value
from tcp_muscle_ros.diagnosis.answer.sentences import none_explains
from tcp_muscle_ros.report.curve import curve_picture
from tcp_muscle_ros.report.diagnosis_figures import Figure
from tcp_muscle_ros.report.next_steps import Asked, steps
from tcp_muscle_ros.report.ranking import ranking_words
from tcp_muscle_ros.report.report_json import IMPROVED, PROTOCOL, RIG
from tcp_muscle_ros.report.rig_checks import check_on_rig
from tcp_muscle_ros.report.tables import unfixed
from tcp_muscle_ros.report.telling import compared
from tcp_muscle_ros.report.viewer import embedded, viewer_data
from tcp_muscle_ros.report.words import (
    at_edge,
    chance,
    change_text,
    cluster_text,
    digits_text,
    error_text,
    fit_texts,
    interval_text,
    left_by_listed,
    listed,
    meaning,
    number,
    own_parameters,
    parameter_text,
    percent,
    plain,
    probability_text,
    range_text,
    told_apart,
    verdict_words,
)

_STILL = 'channels.png'  # for who has no scripts; the viewer shows all of it
_WORSE = 1.2  # of an error: by how much a replay of improved.yaml is clearly worse than the fit
Table = tuple[list[str], list[list[str]]]


def render(
    diagnosis: Diagnosis, figures: Sequence[Figure] = (), folder: str | Path = '.', asked: Asked | None = None
) -> str:
    """The page; ``figures`` are PNGs in ``folder``, which are put into it; ``asked``: for commands with real paths."""
    loader = PackageLoader('tcp_muscle_ros', 'report/templates')
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    pictures = {figure.file.removesuffix('.png'): _picture(figure, Path(folder)) for figure in figures}
    data = viewer_data(diagnosis)
    return environment.get_template('report.html.j2').render(
        **_told(diagnosis),
        steps=steps(diagnosis, asked),
        figures={name: pictures.get(name) for name in ('driver', 'loop', 'ranking', 'experiment', 'sticking')},
        still=pictures.get(_STILL.removesuffix('.png')),
        data=embedded(data) if data else None,
        models=[model.label for model in compared(diagnosis)],
        style=_shipped('report.css'),
        script=_shipped('viewer.js'),
    )


def write_html(
    path: str | Path, diagnosis: Diagnosis, figures: Sequence[Figure], folder: str | Path, asked: Asked | None = None
) -> None:
    """Write ``report.html``."""
    Path(path).write_text(render(diagnosis, figures, folder, asked), encoding='utf-8')


def _shipped(name: str) -> str:
    return resources.files('tcp_muscle_ros').joinpath(f'report/templates/{name}').read_text(encoding='utf-8')


def _picture(figure: Figure, folder: Path) -> dict[str, str]:
    data = b64encode((folder / figure.file).read_bytes()).decode('ascii')
    return {'png': data, 'caption': figure.said.caption, 'alternative': figure.said.alternative}


def _told(d: Diagnosis) -> dict[str, Any]:
    """Everything that the page says in words and numbers."""
    probability = d.verdict_probability
    return {
        'd': d,
        'verdict': plain(d.verdict),
        'verdict_words': verdict_words(d),
        'verdict_probability': None if probability is None else chance(probability),
        'findings': [_finding(f) for f in d.findings],
        'unexplained': _unexplained(d),
        'left': left_by_listed(d.findings),
        'ranking': ranking_words(d),
        'location': _location(d),
        'experiment': _experiment(d),
        'fit': _fit(d),
        'unseen': _unseen(d),
        'left_out': _left_out(d),
        'values': _values(d),
        'not_testable': _not_testable(d),
        'recordings': _recordings(d),
        'repeatability': ', '.join(
            f'{name} {error_text(name, value)}' for name, value in d.repeatability.items() if value is not None
        ),
        'runs': _runs(d),
        'improved': IMPROVED,
        'rig': RIG,
        'seconds': f'{sum(d.seconds.values()):.0f}' if d.seconds else '',
    }


def _finding(f: Finding) -> dict[str, Any]:
    told = told_apart(f)
    heads, rows = _without_empty(
        ['parameter', 'value (90 % interval)', 'meaning', 'remark'],
        [
            [name, parameter_text(f.effect, name, v), meaning(f.effect, name), _remark(v)]
            for name, v in own_parameters(f).items()
        ],
    )
    nearest = f.unlisted.nearest if f.unlisted is not None else None
    name = f'a law without a name: {plain(f.effect)}' if f.unlisted is not None else plain(f.effect)
    return {
        'name': name + (f', nearest to {plain(nearest)}' if nearest else ''),
        'stage': f.stage,
        'probability': probability_text(f),
        'sentence': f.sentence,
        'told': f'{told[0].upper()}{told[1:]}',
        'cluster': cluster_text(f),
        'better': '; '.join(f'{channel} {change_text(channel, change)}' for channel, change in f.improvement.items()),
        'check': check_on_rig(f.effect),
        'curve': curve_picture(f.unlisted) if f.unlisted is not None else None,
        'equation': f.equation,
        'heads': heads,
        'parameters': rows,
    }


def _without_empty(heads: list[str], rows: list[list[str]]) -> Table:
    """The same without the last column where it is empty."""
    if any(cells[-1] for cells in rows):
        return heads, rows
    return heads[:-1], [cells[:-1] for cells in rows]


def _remark(v: Value) -> str:
    if not v.fixed:
        return f'not fixed by the data; {unfixed(v.value, v.nominal, "this")}'
    return 'at its bound' if v.at_bound else ''


def _location(d: Diagnosis) -> str:
    if d.location is None:
        return ''
    where = d.location
    said = f'{where.stage[0].upper()}{where.stage[1:]} stage; the error is largest in the {where.channel}'
    if where.phases:
        said += f', in {listed(where.phases)}'
    said += '.'
    if where.drivers:
        largest = ', '.join(f'{range_text(driver)} ({percent(driver.share)} of it)' for driver in where.drivers)
        said += f' The misfit is largest at {largest}.'
    if isfinite(where.size):
        said += f' The root mean square in these ranges is {error_text(where.channel, where.size)}.'
    return said


def _unexplained(d: Diagnosis) -> str:
    if d.unexplained is None:
        return ''
    u = d.unexplained
    k, start, end = u.interval
    return (
        f'{none_explains(d.tried)} {percent(u.share)} of the misfit of the {u.channel} beyond its noise: '
        f'{u.stage} stage, depending on {range_text(u)}, strongest from {start:.0f} s to {end:.0f} s of recording '
        f'{k + 1}.'
    )


def _experiment(d: Diagnosis) -> str:
    if d.next_experiment is None:
        return ''
    p = d.next_experiment
    first, second = (plain(name) for name in p.separates)
    length = p.duration
    said = f'{plain(p.name)}, {length:.0f} s: {p.reason.rstrip(".")}.'
    said = f'{said[0].upper()}{said[1:]} It separates {first} from {second} with probability {chance(p.power)}.'
    return f'{said} It is in {PROTOCOL}.'


def _fit(d: Diagnosis) -> list[list[str]]:
    return [[channel, *fit_texts(channel, f)] for channel, f in d.fit.items()]


def _unseen(d: Diagnosis) -> str:
    told = [f'{name} {change_text(name, f.held_out)}' for name, f in d.fit.items() if f.held_out is not None]
    return f'recalibrated, then with all findings: {", ".join(told)}' if told and d.findings else ''


def _left_out(d: Diagnosis) -> str:
    """The errors of the fit where improved.yaml, which leaves something of it out, is clearly worse."""
    clearly = {name: f.fitted for name, f in d.fit.items() if f.fitted is not None and f.improved > _WORSE * f.fitted}
    return ', '.join(f'{name} {error_text(name, error)}' for name, error in clearly.items())


def _values(d: Diagnosis) -> list[tuple[str, str, list[str], list[list[str]]]]:
    """Tables of parameters: title, remark, heads, rows."""
    tables: Sequence[tuple[str, str, Mapping[str, Value]]] = (
        ('Parameters of the muscle', 'Fitted to the recordings.', d.calibration),
        (
            'Sensors and set-up',
            f'Differences of the rig; {RIG} has what the instruments do, {IMPROVED} a room that all recordings share.',
            d.sensors,
        ),
    )
    found = []
    for title, remark, values in tables:
        rows = []
        for name, inside in values.items():
            v = at_edge(name, inside)
            rows.append([name, number(v.nominal), digits_text(v)[0], interval_text(v), v.unit, _remark(v)])
        if rows:
            heads = ['name', 'nominal', 'value', '90 % interval', 'unit', 'remark']
            found.append((title, remark, *_without_empty(heads, rows)))
    return found


def _not_testable(d: Diagnosis) -> list[list[str]]:
    by_reason: dict[str, list[str]] = {}
    for n in d.not_testable:
        by_reason.setdefault(n.why, []).append(plain(n.effect))
    return [[', '.join(effects), why] for why, effects in by_reason.items()]


def _runs(d: Diagnosis) -> list[list[str]]:
    """What each run has for itself."""
    return [
        [
            r.name,
            '-' if r.protocol is None else str(r.protocol),
            number(r.gain),
            f'{number(r.time_constant)} s',
            f'{100.0 * r.error:.1f} %',
        ]
        for r in d.runs
    ]


def _recordings(d: Diagnosis) -> list[list[str]]:
    return [
        [
            f'{k}. {r.path}',
            f'{number(r.duration)} s',
            f'{number(r.rate)} Hz',
            ', '.join(r.channels),
            '; '.join(r.issues) or 'none',
        ]
        for k, r in enumerate(d.recordings, 1)
    ]

"""``report.html``: one self-contained page that opens with the outcome in a sentence. No script, nothing fetched."""

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from math import isfinite
from pathlib import Path

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis, Finding, Value
from tcp_muscle_ros.report.diagnosis_figures import Figure
from tcp_muscle_ros.report.report_json import IMPROVED, PROTOCOL
from tcp_muscle_ros.report.rig_checks import check_on_rig
from tcp_muscle_ros.report.words import (
    VERDICTS,
    at_edge,
    chance,
    change_text,
    digits_text,
    error_text,
    interval_text,
    meaning,
    number,
    own_parameters,
    parameter_text,
    percent,
    plain,
    probability_text,
    range_text,
    told_apart,
)

_STYLE = """
:root { color-scheme: light dark; --ink: #1b1b1b; --soft: #595959; --line: #d8d8d8; --page: #fff; --card: #f5f6f8; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #ececec; --soft: #adadad; --line: #414141; --page: #16181b; --card: #202327; }
}
body { margin: 0 auto; padding: 1rem; max-width: 62rem; background: var(--page); color: var(--ink);
  font: 1rem/1.5 system-ui, sans-serif; }
h1 { font-size: 1.35rem; line-height: 1.4; font-weight: 600; margin: .5rem 0; }
h2 { font-size: 1.1rem; margin: 2rem 0 .5rem; }
h3 { font-size: 1rem; margin: 0 0 .25rem; }
p { margin: .4rem 0; }
.soft, figcaption { color: var(--soft); font-size: .9rem; }
.card { background: var(--card); border-radius: .5rem; padding: .8rem 1rem; margin: .8rem 0; }
.verdict { display: inline-block; background: #0072B2; color: #fff; border-radius: 1rem; padding: .1rem .8rem; }
.partial { background: #D55E00; color: #fff; border-radius: .5rem; padding: .5rem 1rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; min-width: 60%; }
th, td { text-align: left; padding: .25rem .8rem .25rem 0; border-bottom: 1px solid var(--line); vertical-align: top; }
td.n, th.n { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
figure { margin: 1rem 0; }
img { max-width: 100%; background: #fff; border-radius: .5rem; }
code { font-size: .9em; overflow-wrap: anywhere; }
"""


_IF_ANY = ('remark',)  # columns that are left out where they are empty


def render(diagnosis: Diagnosis, figures: Sequence[Figure] = (), folder: str | Path = '.') -> str:
    """The page; ``figures`` are PNGs in ``folder``, which are put into it."""
    d = diagnosis
    parts = [
        f'<h1>{escape(d.headline)}</h1>',
        '<p class="partial">Partial: the diagnosis was interrupted, this is what was known by then.</p>'
        if d.partial
        else '',
        f'<p><span class="verdict">{escape(plain(d.verdict))}</span> {escape(VERDICTS[d.verdict])}.</p>',
        _location(d),
        *(_figure(figure, Path(folder)) for figure in figures),
        _findings(d),
        _fit(d),
        _values('Parameters of the muscle', d.calibration, 'Fitted to the recordings.'),
        _values(
            'Sensors and set-up',
            d.sensors,
            f'Differences of the rig; but for a room that all recordings share, they stay out of {IMPROVED}.',
        ),
        _not_testable(d),
        _unexplained(d),
        _next(d),
        _recordings(d),
        _files(d),
    ]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<title>Diagnosis: {escape(plain(d.verdict))}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n'
        + '\n'.join(part for part in parts if part)
        + '\n</body>\n</html>\n'
    )


def write_html(path: str | Path, diagnosis: Diagnosis, figures: Sequence[Figure], folder: str | Path) -> None:
    """Write ``report.html``."""
    Path(path).write_text(render(diagnosis, figures, folder), encoding='utf-8')


def _section(title: str, *content: str) -> str:
    return '\n'.join([f'<h2>{escape(title)}</h2>', *content])


def _soft(text: str) -> str:
    return f'<p class="soft">{escape(text)}</p>'


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]], text_columns: Sequence[int] = (0,)) -> str:
    """A table; columns other than ``text_columns`` hold numbers. Cells are escaped here."""

    def row(tag: str, cells: Sequence[str]) -> str:
        numeric = ('' if k in text_columns else ' class="n"' for k in range(len(cells)))
        return ''.join(f'<{tag}{n}>{escape(cell)}</{tag}>' for n, cell in zip(numeric, cells, strict=True))

    rows = [list(cells) for cells in rows]
    if heads[-1] in _IF_ANY and not any(cells[-1] for cells in rows):
        heads, rows = heads[:-1], [cells[:-1] for cells in rows]
    body = ''.join(f'<tr>{row("td", cells)}</tr>\n' for cells in rows)
    return f'<div class="wide"><table>\n<tr>{row("th", heads)}</tr>\n{body}</table></div>'


def _figure(figure: Figure, folder: Path) -> str:
    data = b64encode((folder / figure.file).read_bytes()).decode('ascii')
    caption, alternative = escape(figure.said.caption), escape(figure.said.alternative)
    return (
        f'<figure><img alt="{alternative}" src="data:image/png;base64,{data}">'
        f'<figcaption>{caption}</figcaption></figure>'
    )


def _location(d: Diagnosis) -> str:
    if d.location is None:
        return ''
    where = d.location
    said = f'Where: {where.stage} stage, seen in {where.channel}'
    if where.phases:
        said += f', in {" and ".join(where.phases)}'
    said += '.'
    if where.drivers:
        shares = ', '.join(f'{percent(driver.share)} at {range_text(driver)}' for driver in where.drivers)
        said += f' Of the misfit, {shares}.'
    if isfinite(where.size):
        said += f' There the model is off by {error_text(where.channel, where.size)} (root mean square).'
    return f'<p>{escape(said)}</p>'


def _findings(d: Diagnosis) -> str:
    if not d.findings:
        return ''
    return _section('Findings', *(_finding(finding) for finding in d.findings))


def _finding(f: Finding) -> str:
    told = told_apart(f)
    parameters = own_parameters(f)
    better = '; '.join(f'{channel} {change_text(channel, change)}' for channel, change in f.improvement.items())
    parts = [
        f'<h3>{escape(plain(f.effect))} <span class="soft">{escape(f.stage)} stage, '
        f'{probability_text(f)}</span></h3>',
        f'<p>{escape(f.sentence)}</p>',
        f'<p><code>{escape(f.equation)}</code></p>',
    ]
    if parameters:
        rows = [
            [name, parameter_text(f.effect, name, v), meaning(f.effect, name), _remark(v)]
            for name, v in parameters.items()
        ]
        parts.append(_table(['parameter', 'value (90 % interval)', 'meaning', 'remark'], rows, (0, 2, 3)))
    parts.append(f'<p>{escape(f"{told[0].upper()}{told[1:]}.")}</p>')
    if better:
        said = f'Error on unseen data, all findings without this one and with it: {better}.'
        parts.append(f'<p>{escape(said)}</p>')
    parts.append(f'<p>Check on the rig: {escape(check_on_rig(f.effect))}</p>')
    return f'<div class="card">{"".join(parts)}</div>'


def _remark(v: Value) -> str:
    if not v.fixed:
        return 'not fixed by the data; kept near its nominal value'
    return 'at its bound' if v.at_bound else ''


def _fit(d: Diagnosis) -> str:
    if not d.fit:
        return ''
    rows = [
        [
            channel,
            *(error_text(channel, e) for e in (f.nominal, f.calibrated, f.improved, f.noise)),
            change_text(channel, f.held_out) if f.held_out else '-',
        ]
        for channel, f in d.fit.items()
    ]
    heads = ['channel', 'nominal', 'recalibrated', IMPROVED, 'noise', 'unseen data: recalibrated to improved']
    return _section(
        'Fit',
        _soft(
            'Root mean square error of single samples, free-running from the recorded inputs, as tcp_muscle replay '
            'prints it: without what belongs to sensors. Unseen data were kept out of the fit.'
        ),
        _table(heads, rows),
    )


def _values(title: str, values: Mapping[str, Value], remark: str) -> str:
    if not values:
        return ''
    rows = []
    for name, inside in values.items():
        v = at_edge(name, inside)
        rows.append([name, number(v.nominal), digits_text(v)[0], interval_text(v), v.unit, _remark(v)])
    return _section(
        title, _soft(remark), _table(['name', 'nominal', 'value', '90 % interval', 'unit', 'remark'], rows, (0, 4, 5))
    )


def _not_testable(d: Diagnosis) -> str:
    if not d.not_testable:
        return ''
    by_reason: dict[str, list[str]] = {}
    for n in d.not_testable:
        by_reason.setdefault(n.why, []).append(plain(n.effect))
    rows = [[', '.join(effects), why] for why, effects in by_reason.items()]
    return _section('What these recordings could not have shown', _table(['effect', 'why'], rows, (0, 1)))


def _unexplained(d: Diagnosis) -> str:
    if d.unexplained is None:
        return ''
    u = d.unexplained
    k, start, end = u.interval
    said = (
        f'{percent(u.share)} of the misfit is explained by nothing in the catalogue: {u.stage} stage, seen in '
        f'{u.channel}, going with {range_text(u)}, strongest from {start:.0f} s to {end:.0f} s of recording {k + 1}.'
    )
    return _section('Unexplained', f'<p>{escape(said)}</p>')


def _next(d: Diagnosis) -> str:
    if d.next_experiment is None:
        return ''
    p = d.next_experiment
    first, second = (plain(name) for name in p.separates)
    length = p.repeat * sum(step.duration for step in p.steps)
    said = f'{plain(p.name)}, {length:.0f} s: {p.reason.rstrip(".")}.'
    said = f'{said[0].upper()}{said[1:]} It separates {first} from {second} with probability {chance(p.power)}.'
    return _section('Next experiment', f'<p>{escape(said)} It is in <code>{PROTOCOL}</code>.</p>')


def _recordings(d: Diagnosis) -> str:
    heads = ['recording', 'duration', 'rate', 'channels', 'remarks']
    rows = [
        [
            f'{k}. {r.path}',
            f'{number(r.duration)} s',
            f'{number(r.rate)} Hz',
            ', '.join(r.channels),
            '; '.join(r.issues) or 'none',
        ]
        for k, r in enumerate(d.recordings, 1)
    ]
    notes = [f'<p>{escape(note)}</p>' for note in d.notes]
    return _section('Recordings', _table(heads, rows, (0, 3, 4)), *notes)


def _files(d: Diagnosis) -> str:
    told = f'<code>{IMPROVED}</code> loads into sim_node and replay; <code>report.json</code> has all numbers; '
    told += '<code>overlay</code> is a bag with the recordings and the models before and after.'
    spent = sum(d.seconds.values())
    return _section('Files', f'<p>{told}</p>', _soft(f'Took {spent:.0f} s.') if spent else '')

"""A diagnosis in the terminal: lines that are too long go on below, and none is cut before its numbers."""

from textwrap import wrap

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis, Finding
from tcp_muscle_ros.muscle import SPECIFICATIONS
from tcp_muscle_ros.report.report_json import IMPROVED, PROTOCOL
from tcp_muscle_ros.report.tables import table
from tcp_muscle_ros.report.words import (
    at_edge,
    chance,
    digits_text,
    error_text,
    fit_texts,
    left_by_listed,
    listed,
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

WIDTH = 100  # characters
_FINDINGS = 4  # told with their numbers
_CHANGED = 3  # parameters named
_NAMED = 6  # effects in a list whose rest is in the report


def summary(diagnosis: Diagnosis, report: object = None) -> str:
    """The outcome for the terminal, in lines of WIDTH characters; ``report``: where all of it is."""
    d = diagnosis
    partial = 'INTERRUPTED, partial ' if d.partial else ''
    lines = [f'{partial}verdict: {verdict_words(d)} ({d.verdict})']
    lines += [_recordings(d), *_repeatability(d), *_location(d), *_findings(d)]
    lines += [*_calibration(d), *_fit(d), *_unexplained(d), *_not_testable(d)]
    if d.next_experiment:
        first, second = (plain(name) for name in d.next_experiment.separates)
        power = chance(d.next_experiment.power)
        lines.append(f'next: {PROTOCOL} separates {first} from {second} with probability {power}')
    elif d.would_help:
        lines.append(f'would help: {d.would_help[0]}')
    lines += [f'note: {note}' for note in d.notes]
    told = [*wrap(d.headline, WIDTH), *(part for line in lines for part in _wrapped(line))]
    return '\n'.join([*told, *([] if report is None else [f'report: {report}'])])  # a path stays in one piece


def _wrapped(line: str) -> list[str]:
    """A line, and what of it goes on below, set in."""
    indent = ' ' * (len(line) - len(line.lstrip()))
    below = f'{indent}  '
    return [line] if len(line) <= WIDTH else wrap(line, WIDTH, subsequent_indent=below, break_on_hyphens=False)


def _recordings(d: Diagnosis) -> str:
    channels = sorted({name for r in d.recordings for name in r.channels})
    issues = sum(len(r.issues) for r in d.recordings)
    total = sum(r.duration for r in d.recordings)
    count = f'{len(d.recordings)} recording{"s" if len(d.recordings) != 1 else ""}'
    remarks = f'; {issues} remark{"s" if issues != 1 else ""} on their quality in the report' if issues else ''
    return f'{count}, {total:.0f} s: {", ".join(channels)}{remarks}'


def _repeatability(d: Diagnosis) -> list[str]:
    told = [f'{name} {error_text(name, size)}' for name, size in d.repeatability.items() if size is not None]
    return [f'runs of one protocol differ by: {", ".join(told)}'] if told else []


def _location(d: Diagnosis) -> list[str]:
    if d.location is None:
        return []
    where = f'where: {d.location.stage} stage, {d.location.channel}'
    if d.location.phases:
        where += f', {listed(d.location.phases)}'
    largest = ' and '.join(range_text(driver) for driver in d.location.drivers)
    return [f'{where}; largest at {largest}' if largest else where]


def _findings(d: Diagnosis) -> list[str]:
    lines = []
    for place, finding in enumerate(d.findings[:_FINDINGS], 1):
        name = f'{place}. {plain(finding.effect)} ({finding.stage})'
        name = ', '.join(filter(None, [name, probability_text(finding)]))
        numbers = _parameters(finding)
        lines += [f'{name}; {told_apart(finding)}', *([f'   {numbers}'] if numbers else [])]
    more = len(d.findings) - _FINDINGS
    return [*lines, f'and {more} more in the report'] if more > 0 else lines


def _not_testable(d: Diagnosis) -> list[str]:
    names = [plain(n.effect) for n in d.not_testable]
    if not names:
        return []
    more = f' and {len(names) - _NAMED} more, in the report' if len(names) > _NAMED else ''
    return [f'not testable here: {", ".join(names[:_NAMED])}{more}']


def _parameters(finding: Finding) -> str:
    law = finding.unlisted
    if law is not None:
        first, last = (number(float(law.value[k]), 2) for k in (0, -1))
        share = '' if law.nearest_share is None else f' ({percent(law.nearest_share)} of it)'
        nearest = f'; nearest is {plain(law.nearest)}{share}' if law.nearest else ''
        return f'{first} to {last} {law.unit} over the {plain(law.driver)}, a curve in the report{nearest}'
    return ', '.join(f'{name} {parameter_text(finding.effect, name, v)}' for name, v in own_parameters(finding).items())


def _calibration(d: Diagnosis) -> list[str]:
    """The parameters of the muscle that moved most, in units of what their intervals allow."""

    def moved(name: str) -> float:
        v = d.calibration[name]
        width = max(v.high - v.low, 1e-12 * max(abs(v.value), 1e-30))
        return abs(v.value - v.nominal) / width if v.fixed and v.nominal == v.nominal else 0.0

    muscle = [name for name in d.calibration if name in SPECIFICATIONS and moved(name) > 0.5]
    names = sorted(muscle, key=moved, reverse=True)[:_CHANGED]
    found = {name: at_edge(name, d.calibration[name]) for name in names}
    told = [f'{name} {number(v.nominal)} -> {digits_text(v)[0]}' for name, v in found.items()]
    return [f'recalibrated: {", ".join(told)}'] if told else []


def _fit(d: Diagnosis) -> list[str]:
    if not d.fit:
        return []
    rows = [[channel, *fit_texts(channel, f)] for channel, f in d.fit.items()]
    lines = table(['RMSE', 'nominal', 'recalibrated', IMPROVED, 'noise'], rows).splitlines()
    return [lines[0], *lines[2:]]  # without the rule: lines are dear here


def _unexplained(d: Diagnosis) -> list[str]:
    if d.unexplained is None:
        return []
    u, what = d.unexplained, left_by_listed(d.findings)
    return [f'{what}: {percent(u.share)} of the misfit, {u.stage} stage, {u.channel}, with {range_text(u)}']

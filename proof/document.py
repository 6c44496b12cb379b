"""docs/proof.md: tables and figures of one run, made from its scores.json and ambiguous.json and nothing else."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from proof.rates import told
from tcp_muscle_ros.report.style import AFTER, BEFORE, OTHER, SETPOINT, canvas

Row = dict[str, Any]

HEADINGS = {
    'diagnosis': 'diagnosis',
    'recalibration': 'recalibration alone',
    'whiteness_bic': 'whiteness + BIC',
    'sparse_regression': 'sparse regression',
    'black_box': 'black box',
    'oracle': 'oracle',
}
# Scores in which the methods are compared: is more better? A method that names nothing is silent on nulls by nature.
COMPARED = {
    'false physics on nulls': False,
    'nulls: any alarm (physics, sensor, unexplained)': False,
    'decoys named as physics': False,
    'stage right, singles': True,
    'single named first': True,
    'single in the reported set': True,
    'single, nothing else named': True,
    'two effects, exactly': True,
    'three effects, exactly': True,
    'unlisted flagged': True,
    'unlisted given a false name': False,
    'held-out gap closed, median': True,
    'held-out gap closed, 10th percentile': True,
    'held-out error left, of the recalibrated, median': False,
    'held-out error made worse by a tenth': False,
}
SILENT = ('recalibration', 'black_box')  # name nothing, by nature
NAMING = {name for name in COMPARED if 'held-out' not in name}
INTRODUCTION = """\
The recordings are made by a separate generator (`proof/truth/`). It shares neither the form of the equations nor code
with the package. For example it has relays where the catalogue has a play operator, a correlation with the Rayleigh
number where it has a power law, and five shells where it has two nodes. The base parameters differ from the nominal
ones, the noise is coloured, the time stamps are irregular, and samples are lost and quantised.

A *null* is a muscle without missing physics. A *decoy* has a fault of a sensor, coloured noise or wrong parameters, and
no missing physics. An *unlisted* effect is not in the catalogue. The *sealed* suite is used for no tuning: the
SHA-256 of its labels is printed and logged (`proof/sealed_runs.jsonl`) before anything is diagnosed. The diagnosis is
tuned on the suites `development` and `varied`, which have other seeds and two of the other forms of each effect.

A rate is given with its 95 % interval after Wilson. An effect is *detectable* if it remains above the noise after the
paper's parameters are fitted again (in its strongest 10 s as large as the noise, root mean square, and over all
recordings a signal of ten times the noise, by the noise's own colour). Rates of naming count detectable effects only.
A case whose diagnosis failed is a failure wherever something was to be found or said. Where restraint is asked it is
not counted, for silence without a report is no proof of it.

*Held-out gap closed* compares errors on a recording that no method was given. Its currents are in no other recording,
and its loads lie between those of the others. 0 is the error of the recalibrated muscle, 1 that of the oracle, which
is told the true effect and fits it in the form of the catalogue. All methods are fitted to the same number of samples,
and compared on at most 500 a channel of that recording. What a recording brings of its own is fitted on it: the room
temperature, the temperature at the start, the states of all effects at the start, and the zeros of displacement and
force. The muscles of the diagnosis are replayed as `tcp_muscle replay` does it. That may also move when the drive
switched between two samples, and takes the recording as it was read where all this gains no more than chance. Errors
are root mean squares over the channels in units of their noise. Cases count if the recalibrated error is more than 1.1
times the oracle's. A diagnosis that failed closes nothing of the gap and leaves all of the error. It is not asked
whether it made the error worse.

*90 % intervals that cover* counts every interval that a report states of a parameter of the paper's model, whatever
the report names: one that misses because the answer is wrong has missed. Left out is only a parameter that means
something else in the generator: the conductance of a muscle that loses heat by radiation or to a rail too, and what
shares its size with a law without a name. *Where the answer is right* counts the intervals of nulls, of decoys with
wrong parameters or coloured noise, and of single effects that are in the reported set. It says whether intervals are
as wide as they should be once the model is right.
"""
_PROBABILITIES = '[How often findings were right, over the probability that was stated for them](probabilities.md).'


def write_document(page: Path, images: Path, scores: Mapping[str, Any], pairs: Row | None, command: str) -> None:
    """The page, with its figures in `images`."""
    images.mkdir(parents=True, exist_ok=True)
    methods, compared = scores['methods'], scores['compared']
    own = methods['diagnosis']
    relative = Path(images.name) if images.parent == page.parent and images != page.parent else Path()
    figures = draw(images, methods, compared)
    lines = ['# The proof', '', *_heading(scores, command), '', INTRODUCTION]
    lines += ['## The diagnosis', '', *score_table(own['scores'])]
    lines += ['', *_pairs(pairs), *_promises(pairs)]
    lines += [f'![How often a single effect is found]({relative / figures[0]})', '']
    if compared:
        lines += ['## Compared with other methods', '', *_which(scores), *comparison(compared), '', *wins(compared), '']
        lines += [f'![Held-out gap closed, by method]({relative / figures[1]})', '']
    if (page.parent / 'probabilities.md').is_file():
        image = relative / 'probabilities.png'
        lines += ['## Are the stated probabilities right?', '', _PROBABILITIES, '']
        lines += [f'![Share of findings that are right, over the probability stated]({image})', '']
    lines += ['## Effect by effect', '', *effect_table(own['confusions']), '']
    lines += [f'![What was named first for each concealed effect]({relative / figures[2]})', '']
    lines += ['## Decoys', '', *decoy_table(own['decoys']), '']
    page.write_text('\n'.join(lines), encoding='utf-8')


def _heading(scores: Mapping[str, Any], command: str) -> list[str]:
    cases, full = scores['cases'], scores['full']
    told = [
        f'Made by `{command}` on {scores["date"]}, at revision {scores["commit"]}, on {scores["machine"]}; '
        f'recordings averaged to at most {scores["samples"]} samples a channel'
        + (f'; {scores["seconds"]:.0f} s of CPU a diagnosis.' if scores.get('seconds') else '.'),
        f'Suite: {scores["suite"]}, {cases} cases, seed {scores["seed"]}, SHA-256 of the labels `{scores["seal"]}`.',
    ]
    if scores['suite'] != 'sealed':
        told.append(
            f'**This is a sample of suite `{scores["suite"]}`, on which the diagnosis was tuned: it proves nothing.**'
        )
    elif cases != full:
        told.append(
            f'**These are {cases} cases, not the {full} of the full suite: the intervals are as wide as that.**'
        )
    return ['  \n'.join(told)]


def _which(scores: Mapping[str, Any]) -> list[str]:
    """Which cases were compared, where they are not all."""
    some = scores['compared_cases']
    return [f'All methods on the same cases, the first {some}.', ''] if some < scores['cases'] else []


def cell(row: Row) -> str:
    """Value and interval of a score."""
    if row['value'] is None:
        return '-'
    if row.get('hits') is None:
        return f'{row["value"]:.2f}'
    return f'{100 * row["value"]:.1f} % [{100 * row["low"]:.1f}, {100 * row["high"]:.1f}]'


def met(row: Row) -> str:
    """Whether a score reaches its aim; nothing where it has none."""
    aim, value = row['aim'], row['value']
    if not aim or value is None:
        return ''
    words = aim.replace('%', '').split()
    scale = 100.0 if '%' in aim else 1.0
    if 'to' in words:
        reached = float(words[0]) <= scale * value <= float(words[2])
    elif words[0] == '<=':
        reached = scale * value <= float(words[1])
    else:
        reached = scale * value >= float(words[-1])
    return 'yes' if reached else '**no**'


def score_table(rows: Sequence[Row]) -> list[str]:
    """All scores with their aims."""
    lines = ['| score | aim | reached | of | aim met |', '|---|---|---|---|---|']
    for row in rows:
        count = f'{row["hits"]}/{row["n"]}' if row.get('hits') is not None else str(row['n'])
        lines.append(f'| {row["score"]} | {row["aim"]} | {cell(row)} | {count} | {met(row)} |')
    return lines


def _pairs(pairs: Row | None) -> list[str]:
    if not pairs or not pairs['n']:
        return []
    lines = [
        '### Does the proposed experiment decide?',
        '',
        'These are pairs of effects that the recordings cannot tell apart, reported as a set with an experiment. The '
        'generator ran the proposed protocol, the recording was added, and the diagnosis was run again. A pair is '
        'decided if the true effect is then named first and its partner is no longer in the set: '
        f'{cell(pairs)}, {pairs["hits"]} of {pairs["n"]} (aim {pairs["aim"]}).',
        '',
        '| concealed | partner | experiment | expected to tell apart, probability | named afterwards | decided |',
        '|---|---|---|---|---|---|',
    ]
    for row in pairs['cases']:
        then = '; '.join(' or '.join(found) for found in row['after']) or 'nothing'
        promised = '-' if row['power'] is None else f'{100 * row["power"]:.0f} %'
        if row.get('separates'):  # the pair that was expected to be told apart, of what may be a larger set
            promised = f'{" from ".join(row["separates"])} {promised}'
        decided = 'yes' if row['resolved'] else 'no'
        lines.append(f'| {row["effect"]} | {row["partner"]} | {row["experiment"]} | {promised} | {then} | {decided} |')
    return [*lines, '']


def _promises(pairs: Row | None) -> list[str]:
    """Promises in tenths, beside how often they were kept."""
    rows = (pairs or {}).get('promises') or []
    if not rows:
        return []
    lines = [
        '### Is the promise of an experiment kept?',
        '',
        'Every experiment that a report of this suite proposes was done, whatever is concealed, and the case diagnosed '
        'again. An experiment promises, with a probability, to tell two effects apart. They are told apart if no '
        'finding is left that could be either. *Right*: the muscle has one of the two, and that one is left.',
        '',
        '| promised | experiments | promised, mean | told apart | right, where the muscle has one of the two |',
        '|---|---|---|---|---|',
    ]
    for tenth in range(10):
        mine = [row for row in rows if min(int(10 * row['promised']), 9) == tenth]
        if mine:
            mean = 100 * float(np.mean([row['promised'] for row in mine]))
            right = told([row['right'] for row in mine if row['concealed']])
            apart = told([row['told_apart'] for row in mine])
            lines.append(f'| {10 * tenth} to {10 * tenth + 10} % | {len(mine)} | {mean:.0f} % | {apart} | {right} |')
    return [*lines, '']


def _by_name(method: Mapping[str, Any]) -> dict[str, Row]:
    return {row['score']: row for row in method['scores']}


def judged(name: str, score: str) -> bool:
    """Whether a method is compared in a score: one that names nothing is not, nor is the oracle but as a limit."""
    return name != 'oracle' and not (name in SILENT and score in NAMING)


def comparison(methods: Mapping[str, Any]) -> list[str]:
    """Scores by method, the best in bold."""
    present = [name for name in HEADINGS if name in methods]
    rows = {name: _by_name(methods[name]) for name in present}
    lines = [
        f'| score | {" | ".join(HEADINGS[name] for name in present)} |',
        '|---|' + '---|' * len(present),
    ]
    for score, more in COMPARED.items():
        able = {n: rows[n][score]['value'] for n in present if judged(n, score) and rows[n][score]['value'] is not None}
        best = (max if more else min)(able.values()) if able else None
        cells = []
        for name in present:
            row = rows[name][score]
            if name in SILENT and score in NAMING:
                cells.append('names nothing')
            elif name == 'oracle' and score in NAMING:
                cells.append('told')
            else:
                value = cell(row)
                cells.append(f'**{value}**' if name in able and able[name] == best else value)
        lines.append(f'| {score} | {" | ".join(cells)} |')
    return lines


def wins(methods: Mapping[str, Any]) -> list[str]:
    """The scores in which an alternative is better than the diagnosis."""
    own = _by_name(methods['diagnosis'])
    found = []
    for score, more in COMPARED.items():
        mine = own[score]['value']
        for name, method in methods.items():
            theirs = _by_name(method)[score]['value']
            if name == 'diagnosis' or not judged(name, score) or mine is None or theirs is None:
                continue
            if (theirs > mine) if more else (theirs < mine):
                found.append(f'* {HEADINGS[name]} is better in "{score}": {cell(_by_name(method)[score])}, '
                             f'the diagnosis {cell(own[score])}.')  # fmt: skip
    return found or ['No alternative is better than the diagnosis in any of these scores.']


def effect_table(rows: Sequence[Row]) -> list[str]:
    """Per effect what was said."""
    lines = ['| concealed | cases | named first | in the set | reported instead |', '|---|---|---|---|---|']
    for row in rows:
        instead = ', '.join(f'{name} {n}' for name, n in sorted(row['instead'].items(), key=lambda item: -item[1]))
        lines.append(f'| {row["effect"]} | {row["n"]} | {row["first"]} | {row["in_set"]} | {instead} |')
    return lines


def decoy_table(rows: Sequence[Row]) -> list[str]:
    """Per decoy the verdicts, and physics that was named."""
    lines = ['| decoy | cases | verdicts | physics named |', '|---|---|---|---|']
    for row in rows:
        verdicts, physics = (', '.join(f'{k} {n}' for k, n in row[key].items()) for key in ('verdicts', 'physics'))
        lines.append(f'| {row["decoy"]} | {row["n"]} | {verdicts} | {physics} |')
    return lines


def draw(images: Path, methods: Mapping[str, Any], compared: Mapping[str, Any]) -> list[str]:
    """The figures; their file names."""
    own = methods['diagnosis']
    drawn: list[tuple[str, Callable[[Path], None]]] = [
        ('proof_power.png', lambda path: power_figure(path, own['power_curve'], own['strength_curve'])),
        ('proof_gap.png', lambda path: gap_figure(path, {name: m['gaps'] for name, m in compared.items()})),
        ('proof_confusion.png', lambda path: confusion_figure(path, own['confusions'])),
    ]
    for name, make in drawn:
        make(images / name)
    return [name for name, _ in drawn]


def power_figure(path: Path, peaks: Sequence[Row], strengths: Sequence[Row]) -> None:
    """How often a single effect is noticed, in the set, and named first: by its size and by its strength."""
    figure, axes = canvas(1, 2, height=3.4, sharey=True)
    for axis, every, by in ((axes[0], peaks, 'peak'), (axes[1], strengths, 'strength')):
        rows = [row for row in every if row['n']]
        if not rows:
            continue
        at, n = np.arange(len(rows)), np.array([row['n'] for row in rows])
        for key, label, colour in (('anything', 'noticed', OTHER), ('in_set', 'in the set', SETPOINT)):
            axis.plot(at, 100.0 * np.array([row[key] for row in rows]) / n, 'o--', color=colour, label=label)
        first = np.array([row['first'] for row in rows]) / n
        low, high = np.array([row['first_interval'] for row in rows]).T
        spread = 100.0 * np.abs(np.array([first - low, high - first]))
        axis.errorbar(at, 100.0 * first, spread, fmt='o-', color=AFTER, capsize=3, label='named first, 95 %')
        axis.set_xticks(at, [f'{row[by]}\nn = {row["n"]}' for row in rows], fontsize=7)
    axes[0].set_xlabel('strongest 10 s left by a refit, in noise units')
    axes[1].set_xlabel('strength: 0 barely visible, 1 obvious')
    axes[0].set_ylabel('single effects (%)')
    if axes[0].get_legend_handles_labels()[0]:
        axes[0].legend(loc='lower left', bbox_to_anchor=(0.0, 1.0), fontsize=8, ncols=3, frameon=False)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def gap_figure(path: Path, gaps: Mapping[str, Mapping[str, float]]) -> None:
    """The share of the held-out gap that each method closes, case by case in order."""
    figure, (axis,) = canvas(1, height=3.4)
    colours = {'diagnosis': AFTER, 'whiteness_bic': BEFORE, 'sparse_regression': SETPOINT, 'black_box': OTHER}
    for name, colour in colours.items():
        values = np.sort(list(gaps.get(name, {}).values()))
        if values.size:
            axis.plot(
                100.0 * (np.arange(values.size) + 0.5) / values.size, values.clip(-1.0, 1.5), color=colour,
                label=HEADINGS[name],
            )  # fmt: skip
    for level, label in ((0.0, 'recalibrated'), (1.0, 'oracle')):
        axis.axhline(level, color='black', linewidth=0.6)
        axis.annotate(label, (1.0, level), fontsize=8, va='bottom')
    axis.set_ylim(-1.05, 1.55)
    axis.set_xlabel('cases, in the order of each method (%)')
    axis.set_ylabel('held-out gap closed')
    if axis.get_legend_handles_labels()[0]:
        axis.legend(loc='lower right', fontsize=8)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def confusion_figure(path: Path, rows: Sequence[Row]) -> None:
    """What was named first (columns) for what was there (rows), as a share of the row."""
    there = [row['effect'] for row in rows]
    others = sorted({name for row in rows for name in row['instead']} - set(there))
    said = [name for name in there if any(row['first'] for row in rows if row['effect'] == name)]
    said += [n for n in there if n not in said and any(n in row['instead'] for row in rows)] + others
    if not rows or not said:
        there, said = there or ['nothing'], said or ['nothing']
    shares = np.zeros((len(there), len(said)))
    for i, row in enumerate(rows):
        for name, count in {row['effect']: row['first'], **row['instead']}.items():
            if name in said:
                shares[i, said.index(name)] += count / row['n']
    figure, (axis,) = canvas(1, height=max(3.0, 0.2 * len(there) + 2.0))
    axis.imshow(100.0 * shares, cmap='Blues', vmin=0.0, vmax=100.0, aspect='auto')
    axis.set_xticks(range(len(said)), said, rotation=90, fontsize=7)
    axis.set_yticks(range(len(there)), there, fontsize=7)
    axis.set_xlabel('named first, or the verdict where nothing was named')
    axis.set_ylabel('concealed effect')
    figure.savefig(path, dpi=110)
    plt.close(figure)

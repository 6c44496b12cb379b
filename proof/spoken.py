"""How often the form that is said of a law without a name is that of the law that was concealed.

python -m proof.spoken [--seeds 1 2] [--forms square threshold] [--tables loss soft]

The muscles are those of proof.written, which no suite has. To see the words alone, one listed effect is tried and the
free laws, instead of a whole diagnosis. Prints a line a muscle and, of those in which a law was found, the table.
"""

import argparse
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from proof.generate import write_recording
from proof.tool import QUICK, experiments_of
from proof.truth import observe
from proof.written import FORMS, SIZES, case_of, written
from tcp_muscle_ros.diagnosis.answer.in_words import Told, told_by_form
from tcp_muscle_ros.diagnosis.answer.law_forms import Said
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.search.free_laws import with_free_law
from tcp_muscle_ros.diagnosis.search.selected import Selection
from tcp_muscle_ros.diagnosis.search.selection import select
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.process.threads import one_of_linear_algebra
from tcp_muscle_ros.settings.operating import DEFAULT_SET

SAID = ('right', 'beside another', 'wrong', 'nothing', 'no law found')
AS_POWERS = {'linear': (0.85, 1.15), 'square': (1.6, 2.4), 'cube': (2.5, 3.6)}  # that count as the same


def selection_of(form: str, table: str, seed: int) -> Selection:
    """What is found of a muscle with such a law."""
    rng = np.random.default_rng([seed, list(FORMS).index(form), list(SIZES).index(table)])
    case, nominal = case_of(written(form, table, rng), seed), Parameters.named(DEFAULT_SET)
    with tempfile.TemporaryDirectory() as folder:
        for k, experiment in enumerate(case.experiments):
            write_recording(case, k, experiment, observe(case.bench, experiment, k), Path(folder))
        experiments = experiments_of(Path(folder) / case.name, nominal, QUICK)
    return with_free_law(select(in_turn(calibrate(experiments, nominal).fit), ['friction']))


def is_form(said: Said, form: str) -> bool:
    """Whether what is said is a form; a power near it is."""
    low, high = AS_POWERS.get(form, (np.inf, -np.inf))
    return said.form.name == form or (said.form.name == 'power' and low < said.number < high)


def judged(told: Told | None, form: str) -> str:
    """Which of SAID it is."""
    if told is None:
        return 'nothing'
    if is_form(told.said, form):
        return 'right'
    return 'beside another' if any(is_form(other, form) for other in told.others) else 'wrong'


def table(counts: Counter[tuple[str, str]]) -> str:
    """As Markdown."""
    head = [f'| concealed | {" | ".join(SAID)} |', '|---' * (1 + len(SAID)) + '|']
    rows = [f'| {form} | {" | ".join(str(counts[form, what]) for what in SAID)} |' for form, _ in counts]
    return '\n'.join([*head, *dict.fromkeys(rows)])


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog='python -m proof.spoken', description=__doc__.splitlines()[0])
    parser.add_argument('--seeds', type=int, nargs='+', default=[1, 2])
    parser.add_argument('--forms', nargs='+', choices=list(FORMS), default=list(FORMS))
    parser.add_argument('--tables', nargs='+', choices=list(SIZES), default=list(SIZES))
    chosen = parser.parse_args(arguments)
    one_of_linear_algebra()
    counts: Counter[tuple[str, str]] = Counter()
    for seed in chosen.seeds:
        for form in chosen.forms:
            for name in chosen.tables:
                found = selection_of(form, name, seed)
                law = next((c.effect for c in found.chosen if c.definition.free is not None), None)
                told = told_by_form(found, law) if law else None
                said = judged(told, form) if law else 'no law found'
                counts[form, said] += 1
                words = [one.form.name for one in (told.said, *told.others)] if told else []
                print(f'{form} in {name}, seed {seed}: {law}: {" or ".join(words) or "-"}: {said}', flush=True)
    print(table(counts))
    return 0


if __name__ == '__main__':
    sys.exit(main())

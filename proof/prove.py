"""The proof from end to end: cases, labels sealed, diagnosed, compared with alternatives, opened, scored, told.

./scripts/prove                   the sealed suite of 430 cases, written to docs/proof.md
./scripts/prove --cases 20        a sample of the development suite, whose forms may be looked at
./scripts/prove --cases 20 --suite varied   the same with the third form of each effect, which may be looked at too
./scripts/prove --cases 20 --suite outside  with the fourth forms, on which nothing is tuned (the weights are fitted)
./scripts/prove --phase diagnose  one of the phases; every phase goes on where it was stopped

The seed of a sealed suite is drawn when it is generated and stands nowhere but in its labels. Their SHA-256 is printed
and logged before anything is diagnosed; only `alternatives` (its oracle), `score` and what follows open them.
"""

import argparse
import json
import os
import platform
import secrets
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from datetime import datetime, timezone
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from proof import alternatives, ambiguous
from proof.answers import read
from proof.cases import FULL, SUITES
from proof.document import write_document
from proof.generate import generate
from proof.score import LOG, brief, note, tables, text
from proof.tool import HELD_OUT, REPORT, diagnose_case, guarded, tried, users_errors
from tcp_muscle_ros.diagnosis.observation.observe import MOST
from tcp_muscle_ros.process.threads import one_of_linear_algebra

ROOT = Path(__file__).parents[1]
DIAGNOSIS = 'diagnosis'


class Proof:
    """The folders of one run, and its phases."""

    def __init__(self, suite: str, cases: int, seed: int | None, folder: Path, jobs: int, most: int) -> None:
        self.suite, self.cases, self.seed, self.folder = suite, cases, seed, folder
        self.jobs, self.most = jobs, most
        self.bags, self.unseen, self.labels = folder / 'cases', folder / 'held_out', folder / 'labels.json'
        self.reports = folder / 'reports'

    @property
    def names(self) -> list[str]:
        """The cases, found without a look at the labels."""
        return sorted(path.name for path in self.bags.iterdir() if path.is_dir())

    @property
    def sealed(self) -> bool:
        """Whether this run is one for the record."""
        return self.suite == 'sealed'

    def generate(self) -> None:
        """Write the recordings; print and log the hash of the labels."""
        if (self.bags / 'SEAL').is_file():
            print(f'cases are in {self.bags}, labels sealed: {self.seal}')
            return
        for begun in (self.bags, self.unseen):  # and not finished: no seal
            shutil.rmtree(begun, ignore_errors=True)
        seed = secrets.randbelow(2**31) if self.seed is None else self.seed
        seal = generate(self.suite, self.cases, seed, self.bags, self.labels, self.jobs, self.unseen)
        print(f'{len(self.names)} cases in {self.bags}; SHA-256 of the sealed labels: {seal}')
        if self.sealed:
            note(LOG, 'generated', seal=seal, cases=len(self.names), seed='drawn' if self.seed is None else self.seed)

    @property
    def seal(self) -> str:
        """SHA-256 of the labels."""
        return (self.bags / 'SEAL').read_text(encoding='utf-8').split()[0]

    def diagnose(self) -> None:
        """The package under test; then its muscles on the recordings that it was not given."""
        reports = self.reports / DIAGNOSIS
        left = [name for name in self.names if not (reports / name / REPORT).is_file()]
        if left and self.sealed:
            note(LOG, 'diagnosing', seal=self.seal, cases=len(left), samples=self.most, commit=commit())
        self._each('diagnose', left, partial(_diagnose, self.bags, reports, self.most))
        done = [n for n in self.names if (reports / n / REPORT).is_file() and not (reports / n / HELD_OUT).is_file()]
        self._each('held out', done, partial(_held_out, self.bags, self.unseen, reports))

    def alternatives(self, names: Sequence[str] = tuple(alternatives.RUNNERS)) -> None:
        """The other ways on the same cases."""
        wanted = [
            label
            for label in json.loads(self.labels.read_text(encoding='utf-8'))['cases']
            if not all(alternatives.answered(self.reports / name / label['case'], self.most) for name in names)
        ]
        work = partial(_alternatives, self.bags, self.reports, self.unseen, names, self.most)
        self._each('alternatives', wanted, work)

    def score(self) -> None:
        """Open the labels: scores.json, and the tables of the diagnosis on the terminal."""
        head, answers = read(self.bags, self.reports / DIAGNOSIS, self.labels, self.reports)
        done = self.answered(DIAGNOSIS)
        result: dict[str, Any] = {**head, 'methods': {DIAGNOSIS: tables(answers[:done])}, 'compared': {}}
        # All methods on the same cases: the first ones, as far as the alternatives have come.
        common = self.answered(DIAGNOSIS, *alternatives.RUNNERS)
        for name in (DIAGNOSIS, *alternatives.RUNNERS) if common else ():
            _, answers = read(self.bags, self.reports / name, self.labels, self.reports)
            result['compared'][name] = tables(answers[:common])
        result |= {
            'cases': done,
            'compared_cases': common,
            'full': sum(FULL.values()),
            'date': datetime.now(timezone.utc).date().isoformat(),
            'commit': commit(),
            'machine': machine(),
            'samples': self.most,
            'seconds': self._seconds(),
        }
        self._keep('scores.json', result)
        print(text(result['methods'][DIAGNOSIS]))
        if self.sealed:
            note(LOG, 'scored', seal=self.seal, cases=done, commit=result['commit'],
                 scores=brief(result['methods'][DIAGNOSIS]))  # fmt: skip

    def answered(self, *methods: str) -> int:
        """How many of the first cases these methods have tried; a run that was stopped is scored on those.

        A case without a report is among them, and a failure, where it is noted that it failed or, as runs had no such
        notes, where the run went on after it.
        """
        there = [all(tried(self.reports / name / case) for name in methods) for case in self.names]
        for k, answered in enumerate(there):
            if not answered and sum(there[k + 1 :]) < self.jobs:  # it was under way, or its turn had not come
                return k
        return len(there)

    def ambiguous(self) -> None:
        """Run the experiments that were proposed, and diagnose again."""
        _, answers = read(self.bags, self.reports / DIAGNOSIS, self.labels)
        wanted = [answer for answer in answers if answer.proposal is not None]
        extended, reports = self.folder / 'extended', self.reports / 'extended'
        left = [a.label['case'] for a in wanted if not (reports / a.label['case'] / REPORT).is_file()]
        work = partial(_extend, self.bags, self.reports / DIAGNOSIS, self.labels, extended, reports, self.most)
        self._each('ambiguous', left, work)
        found = ambiguous.summary([answer for answer in wanted if ambiguous.asked(answer)], reports)
        found['promises'] = ambiguous.promises(wanted, reports)
        self._keep('ambiguous.json', found)
        rate = '-' if found['value'] is None else f'{100 * found["value"]:.0f} %'
        print(f'{found["score"]}: {found["hits"]} of {found["n"]} ({rate}, {found["low"]:.2f} to {found["high"]:.2f})')
        if self.sealed:
            note(LOG, 'ambiguous', seal=self.seal, hits=found['hits'], n=found['n'])

    def document(self) -> None:
        """docs/proof.md of a sealed suite; of a sample the same in the folder of the run."""
        page = ROOT / 'docs' / 'proof.md' if self.sealed else self.folder / 'proof.md'
        images = ROOT / 'docs' / 'images' if self.sealed else self.folder
        scores = json.loads((self.folder / 'scores.json').read_text(encoding='utf-8'))
        pairs = self.folder / 'ambiguous.json'
        found = json.loads(pairs.read_text(encoding='utf-8')) if pairs.is_file() else None
        write_document(page, images, scores, found, command(self))
        print(page)

    def _keep(self, name: str, content: dict[str, Any]) -> None:
        (self.folder / name).write_text(json.dumps(content, indent=1) + '\n', encoding='utf-8')

    def _seconds(self) -> float | None:
        """CPU time of a diagnosis, mean of all cases."""
        spent = []
        for name in self.names:
            path = self.reports / DIAGNOSIS / name / 'seconds'
            if path.is_file():
                spent.append(float(path.read_text(encoding='utf-8')))
        return sum(spent) / len(spent) if spent else None

    def _each(self, title: str, items: Iterable[Any], work: Callable[[Any], str | None]) -> None:
        """Work on each item in a pool; what fails is told and left for the next time."""
        wanted = list(items)
        if not wanted:
            return
        start, failed = time.monotonic(), 0
        pool = ProcessPoolExecutor(self.jobs, mp_context=get_context('spawn'), initializer=_gentle)
        try:
            for done, future in enumerate(as_completed([pool.submit(work, item) for item in wanted]), 1):
                problem = future.result()
                if problem:
                    failed += 1
                    print(f'\r{problem}', file=sys.stderr)
                _progress(title, done, len(wanted), time.monotonic() - start)
        finally:  # also when interrupted: what is under way ends, what waits does not begin
            pool.shutdown(cancel_futures=True)
        if failed:
            print(f'{title}: {failed} of {len(wanted)} failed', file=sys.stderr)


PHASES = ('generate', 'diagnose', 'alternatives', 'score', 'ambiguous', 'document')


def _gentle() -> None:
    """A process of the pool gives way to whoever works at the machine."""
    os.nice(5)


def _progress(title: str, done: int, of: int, seconds: float) -> None:
    """One line that is written over on a terminal; elsewhere a line now and then."""
    last = done == of
    if sys.stdout.isatty() or done % 10 == 0 or last:
        left = seconds / done * (of - done) / 60.0
        end = '\n' if last or not sys.stdout.isatty() else ''
        print(f'\r{title}: {done} of {of}, {seconds / done:.1f} s each, {left:.0f} min left ', end=end, flush=True)


def _diagnose(bags: Path, reports: Path, most: int, name: str) -> str | None:
    def work() -> None:
        start = time.process_time()
        diagnose_case(bags / name, reports, most)
        (reports / name / 'seconds').write_text(f'{time.process_time() - start:.2f}\n', encoding='utf-8')

    return guarded(name, reports / name, work)


def _held_out(bags: Path, unseen: Path, reports: Path, name: str) -> str | None:
    def work() -> None:
        found = users_errors(reports / name, unseen / name)
        (reports / name / HELD_OUT).write_text(json.dumps(found) + '\n', encoding='utf-8')

    return guarded(name, reports / name, work)


def _alternatives(
    bags: Path, reports: Path, unseen: Path, names: Sequence[str], most: int, label: dict[str, Any]
) -> str | None:
    return alternatives.run(bags / label['case'], reports, label, unseen, names, most)


def _extend(bags: Path, before: Path, labels: Path, extended: Path, reports: Path, most: int, name: str) -> str | None:
    def work() -> None:
        diagnose_case(ambiguous.add_recording(name, bags, before, labels, extended), reports, most)

    return guarded(name, reports / name, work)


def commit() -> str:
    """The state of the repository, with a + where files were changed."""
    try:
        done = subprocess.run(
            ['git', 'describe', '--always', '--dirty=+'], cwd=ROOT, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return 'unknown'
    return done.stdout.strip()


def machine() -> str:
    """Its size, for the record."""
    memory = os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') / 2**30
    return f'{os.cpu_count()} cores, {memory:.0f} GB, Python {platform.python_version()}'


def default_suite(cases: int) -> str:
    """Of a sample, or of all."""
    return 'development' if cases else 'sealed'


def command(proof: Proof) -> str:
    """How to make the document."""
    words = ['./scripts/prove']
    if proof.cases:
        words += ['--cases', str(proof.cases)]
    if proof.suite != default_suite(proof.cases):
        words += ['--suite', proof.suite]
    if proof.seed is not None:
        words += ['--seed', str(proof.seed)]
    if proof.most != MOST:
        words += ['--samples', str(proof.most)]
    return shlex.join(words)


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog='./scripts/prove', description=__doc__.splitlines()[0])
    parser.add_argument('--cases', type=int, default=0, help='a sample of so many, spread over the kinds of cases')
    parser.add_argument('--seed', type=int, help='of a sample (1); that of a sealed suite is drawn unless given here')
    parser.add_argument('--suite', choices=list(SUITES), help='sealed without --cases, else development')
    parser.add_argument('--output', type=Path, help='default: build/proof/SUITE-CASES-SEED')
    parser.add_argument('--phase', choices=PHASES, action='append', help='only this one (repeatable; default all)')
    parser.add_argument(
        '--samples', type=int, default=MOST, help=f'observations a channel ({MOST}, as the tool has it)'
    )
    parser.add_argument('--jobs', type=int, default=2)
    chosen = parser.parse_args(arguments)
    suite = chosen.suite or default_suite(chosen.cases)
    seed = chosen.seed if chosen.seed is not None or suite == 'sealed' else 1
    name = f'{suite}-{chosen.cases or sum(FULL.values())}' + (f'-{seed}' if seed is not None else '')
    folder = chosen.output or ROOT / 'build' / 'proof' / name
    folder.mkdir(parents=True, exist_ok=True)
    one_of_linear_algebra()  # before the processes of the pool begin; a case is one process's work
    proof = Proof(suite, chosen.cases, seed, folder, chosen.jobs, chosen.samples)
    try:
        for phase in chosen.phase or PHASES:
            getattr(proof, phase)()
    except KeyboardInterrupt:
        print(f'\ninterrupted; the same command goes on from here ({folder})', file=sys.stderr)
        return 130
    return 0


if __name__ == '__main__':
    sys.exit(main())

"""Run the tests that are marked `long`, and write to docs/long_checks.md what came of them.

Usage: ./scripts/long_checks [arguments for pytest]; with arguments only those tests run, and nothing is written. Exit
code 1 where a test failed.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections import Counter
from collections.abc import Sequence
from datetime import date
from pathlib import Path

from proof.prove import commit, machine

ROOT = Path(__file__).parents[1]
PAGE = ROOT / 'docs' / 'long_checks.md'
HEAD = """# The longest tests

`./scripts/test` leaves out the tests that compute longest, so that it ends within twenty minutes.
`./scripts/long_checks` runs them and writes this page: on {date},
revision {revision}, {machine}, in {minutes:.0f} min.

| file | tests | passed | skipped | failed | s |
|---|---|---|---|---|---|
"""


def main(arguments: Sequence[str]) -> int:
    with tempfile.TemporaryDirectory() as folder:
        told = Path(folder) / 'told.xml'
        revision = commit()  # as it is when the tests begin
        spread = [] if arguments else [f'--numprocesses={os.cpu_count()}', '--dist=load', f'--junitxml={told}']
        pytest = [sys.executable, '-m', 'pytest', '-m', 'long', *spread, *arguments]
        code = subprocess.run(pytest, cwd=ROOT, check=False).returncode
        if not arguments and told.is_file():
            PAGE.write_text(page(ElementTree.parse(told).getroot()[0], revision), encoding='utf-8')
            print(PAGE)
    return int(code != 0)


def page(suite: ElementTree.Element, revision: str) -> str:
    """docs/long_checks.md, from what pytest says of each test."""
    rows: dict[str, Counter[str]] = {}
    for case in suite.iter('testcase'):
        # test.folder.test_file[.Class]: as pytest writes a path.
        file = case.get('classname', '').replace('.', '/') + '.py'
        came = {child.tag for child in case} & {'failure', 'error', 'skipped'}
        mine = rows.setdefault(file, Counter())
        mine['skipped' if came == {'skipped'} else 'failed' if came else 'passed'] += 1
        mine['s'] += round(float(case.get('time', 0.0)))
    minutes = float(suite.get('time', 0.0)) / 60.0
    text = HEAD.format(date=date.today().isoformat(), revision=revision, machine=machine(), minutes=minutes)
    for file, mine in sorted(rows.items()):
        tests = mine['passed'] + mine['skipped'] + mine['failed']
        text += f'| {file} | {tests} | {mine["passed"]} | {mine["skipped"]} | {mine["failed"]} | {mine["s"]} |\n'
    return text


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))

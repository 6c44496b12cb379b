"""What a diagnosis has to be better than: other ways to answer the same cases, scored by the same proof.score.

A runner reads the bags of one case and returns a report in the schema of the diagnosis (at least verdict, findings and
fit). It is entered under its name with @runner and run with

python -m proof.alternatives NAME DIR REPORTS
"""

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

Runner = Callable[[Path], dict[str, Any]]

# Wanted: recalibration (parameters only), whiteness_bic (forward selection), pysindy (sparse regression on the
# residual), black_box (a free correction), oracle (the true effect refitted; it alone may read the labels).
RUNNERS: dict[str, Runner] = {}


def runner(name: str) -> Callable[[Runner], Runner]:
    """Enter the decorated function under its name."""

    def enter(function: Runner) -> Runner:
        RUNNERS[name] = function
        return function

    return enter


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog='python -m proof.alternatives', description=__doc__.splitlines()[0])
    parser.add_argument('name', choices=sorted(RUNNERS))
    parser.add_argument('directory', type=Path)
    parser.add_argument('reports', type=Path)
    chosen = parser.parse_args(arguments)
    for case in sorted(path for path in chosen.directory.iterdir() if path.is_dir()):
        report = RUNNERS[chosen.name](case)
        folder = chosen.reports / case.name
        folder.mkdir(parents=True, exist_ok=True)
        (folder / 'report.json').write_text(json.dumps(report, indent=1) + '\n', encoding='utf-8')
    return 0


if __name__ == '__main__':
    sys.exit(main())

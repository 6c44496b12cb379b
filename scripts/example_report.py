#!/usr/bin/env python3
"""The worked example of docs/reading_a_report.md: a muscle that creeps is recorded under two loads, and diagnosed.

python scripts/example_report.py [--output FOLDER] [--update]

Everything is done by `tcp_muscle`, as a user would. With --update the document's blocks are written from what came out,
and, where Chromium is installed, the picture of the first screen is taken anew.
"""

import argparse
import io
import json
import os
import shutil
import sys
import tempfile
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.report.marked import replace_marked
from tcp_muscle_ros.settings.parameter_file import write
from tcp_muscle_ros.tool import main as tcp_muscle

ROOT = Path(__file__).resolve().parents[1]
DOCUMENT, PICTURE = ROOT / 'docs' / 'reading_a_report.md', ROOT / 'docs' / 'images' / 'report_first_screen.png'
LOADS = {'light': 0.5, 'heavy': 1.2}  # N
NOISE = {'temperature_noise_k': 0.15, 'resistance_noise_ohm': 0.02, 'displacement_noise_m': 4e-5}
PROTOCOL = """rate_hz: 4
input: current
end: load
load_n: {load}
repeat: 4
segments:
  - {{duration_s: 30, value: 0.27}}
  - {{duration_s: 40, value: 0.02}}
"""


def make(folder: Path) -> tuple[str, dict[str, Any]]:
    """Record and diagnose in ``folder``; what the terminal shows, and the content of report.json."""
    muscle = Parameters.named('karami_tadesse_2017').with_effects('creep').replace({'creep.J': 0.25, 'hA': 0.0203})
    before = Path.cwd()
    os.chdir(folder)
    try:
        for k, (name, load) in enumerate(LOADS.items()):
            write('muscle.yaml', muscle, operating={'load_n': load, 'seed': k, **NOISE})
            Path(f'{name}.yaml').write_text(PROTOCOL.format(load=load))
            run('simulate', f'{name}.yaml', '--params', 'muscle.yaml', '--output', name)
        text = run('diagnose', *LOADS, '--output', 'report')
        return text, json.loads(Path('report/report.json').read_text())
    finally:
        os.chdir(before)


def run(*words: str) -> str:
    """One command of the tool; what it prints."""
    said = io.StringIO()
    with redirect_stdout(said):
        code = tcp_muscle(list(words))
    if code:
        raise RuntimeError(f'tcp_muscle {" ".join(words)}: exit code {code}')
    return said.getvalue().rstrip('\n')


def picture(page: Path) -> None:
    """The first screen of the page, in a browser."""
    sys.path.insert(0, str(ROOT / 'test'))
    from report.browser import PROGRAM, browser

    if PROGRAM is None:
        print('no Chromium here: the picture stays as it was')
        return
    folder = page.parent.parent  # where the example is made says nothing
    text = page.read_text(encoding='utf-8').replace(f'{folder}{os.sep}', f'lab{os.sep}')
    with tempfile.TemporaryDirectory() as profile, browser(profile) as found:
        page.write_text(text, encoding='utf-8')
        found.show(page, 1100, height=795)
        found.picture(PICTURE)


def finding(report: dict[str, Any]) -> str:
    """The first finding in report.json, without its sentence and equation."""
    first = report['findings'][0]
    kept = ('effect', 'stage', 'probability', 'singled_out', 'indistinguishable_from', 'improvement')
    return json.dumps({key: first[key] for key in kept}, indent=1)


def main() -> int:
    """Make the example; --update writes it into the document."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--output', type=Path, help='where the recordings and the report stay')
    parser.add_argument('--update', action='store_true', help='write the document and the picture')
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        text, report = make(Path(folder))
        print(text)
        if args.update:
            replace_marked(DOCUMENT, 'terminal', f'```\n{text}\n```')
            replace_marked(DOCUMENT, 'finding', f'```json\n{finding(report)}\n```')
            picture(Path(folder) / 'report' / 'report.html')
        if args.output:
            shutil.copytree(folder, args.output)
            print(f'{args.output}: two recordings, and report{os.sep}report.html')
    return 0


if __name__ == '__main__':
    sys.exit(main())

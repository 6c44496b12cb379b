"""The list of runs that ``tcp_muscle diagnose --manifest`` works through.

```yaml
runs:
  - name: thumb_0                # the folder of its report
    bags: [bags/a, bags/b]       # recordings of one muscle; paths are relative to this file
    params: thumb.yaml           # optional: a parameter file or a shipped set; default --params
    muscle: thumb                # optional, as are the next two: what the trends are drawn over
    cycles: 12000
    day: 2026-03-01
```
"""

import re
from dataclasses import dataclass
from datetime import date
from pathlib import Path

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import SETS
from tcp_muscle_ros.recording.yaml_input import Section, load_yaml

_KEYS = ('name', 'bags', 'params', 'muscle', 'cycles', 'day')
_NAME = re.compile(r'[A-Za-z0-9_][\w.+-]*', re.ASCII)
TAKEN = ('summary.csv', 'summary.json', 'trends.png')  # names of files beside the runs


@dataclass(frozen=True)
class Run:
    """One run: its bags and parameters, and where it stands among the others."""

    name: str
    bags: tuple[str, ...]
    params: str
    muscle: str | None = None
    cycles: float | None = None
    day: date | None = None


def read_manifest(path: str | Path, params: str) -> list[Run]:
    """The runs of a manifest; ``params`` is for those that name none.

    Raises:
        BadInput: no YAML, an unknown key (with the nearest), a value of the wrong kind, a name used twice.
    """
    found: dict[str, Run] = {}
    for section in load_yaml(path).only('runs').sections('runs'):
        run = _run(section.only(*_KEYS), Path(path).parent, params)
        twin = next((name for name in found if name.lower() == run.name.lower()), None)
        if twin is not None:
            raise BadInput(f"{section.where}: name is '{run.name}', as of another run; each run needs its own")
        found[run.name] = run
    return list(found.values())


def _run(section: Section, folder: Path, params: str) -> Run:
    name = section.text('name')
    if not _NAME.fullmatch(name) or name in TAKEN:
        raise BadInput(f"{section.where}: name is '{name}', expected a name for a folder, as in thumb_0")
    return Run(
        name,
        _bags(section, folder),
        _params(section.text('params'), folder) if 'params' in section else params,
        section.text('muscle') if 'muscle' in section else None,
        section.number('cycles', least=0.0) if 'cycles' in section else None,
        _day(section) if 'day' in section else None,
    )


def _bags(section: Section, folder: Path) -> tuple[str, ...]:
    section.require('bags')
    bags = section['bags']
    if not isinstance(bags, list) or not bags or not all(isinstance(bag, str) for bag in bags):
        raise BadInput(f'{section.where}: bags is {bags!r}, expected a list of paths, as in [bags/a, bags/b]')
    return tuple(str(folder / bag) for bag in bags)


def _params(value: str, folder: Path) -> str:
    path = folder / value
    return value if value in SETS and not path.exists() else str(path)


def _day(section: Section) -> date:
    value = section['day']
    try:
        return value if type(value) is date else date.fromisoformat(str(value))
    except ValueError:
        raise BadInput(f"{section.where}: day is '{value}', expected a date, as in 2026-03-01") from None

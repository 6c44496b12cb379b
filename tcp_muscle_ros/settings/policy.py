"""The numbers that decide what a diagnosis names, read from one file (config/policy.yaml).

Each stands there with its meaning, its unit, and how it was set. Numerical tolerances are not among them: they stay
with their algorithm, and what is known of instruments with the instruments.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.files import yaml_text

SHIPPED = Path(__file__).resolve().parent.parent / 'config' / 'policy.yaml'
ODDS = 'odds'  # the one entry that is a table
SAID = ('value', 'unit', 'meaning', 'set_by')  # of each number
FITTED = 'fitted'  # of the table: its weights before they were scaled


@dataclass(frozen=True)
class Policy:
    """What decides, by name; config/policy.yaml says what each means.

    ``odds``: the weights of what speaks for a finding, by term.
    """

    least_drop: float
    per_parameter: float
    told_apart: float
    alike: float
    least_share: float
    beaten: float
    bending: float
    trace_of_circumstance: float
    trace_of_physics: float
    faint: float
    far: float
    beyond_use: float
    most_effects: float
    of_all: float
    of_rest: float
    of_rest_at_first: float
    faint_beside: float
    nearly_all: float
    companion_of_all: float
    still: float
    still_plain: float
    single_readings: float
    form: float
    helps: float
    odds: Mapping[str, float]


def read_policy(path: Path) -> Policy:
    """The policy of a file.

    Raises:
        BadInput: it is no YAML, or a number is missing, is none, or has a name that is not known.
    """
    try:
        content = yaml_text.parse(path.read_text(encoding='utf-8'))
    except (OSError, ValueError) as error:
        raise BadInput(f'{path}: {error}; expected a policy such as {SHIPPED.name}') from None
    names = [field.name for field in fields(Policy)]
    if not isinstance(content, dict):
        raise BadInput(f'{path}: expected the numbers {", ".join(names)}')
    for name in content:
        if name not in names:
            raise BadInput(f"{path}: '{name}' is no number of a policy{nearest(str(name), names)}")
    entries = {name: content.get(name) for name in names}
    values = {name: entry.get('value') if isinstance(entry, dict) else None for name, entry in entries.items()}
    numbers = {name: _number(path, name, value) for name, value in values.items() if name != ODDS}
    weights = values[ODDS]
    if not isinstance(weights, dict):
        raise BadInput(f'{path}: {ODDS}.value is {weights!r}, expected a weight for each term')
    return Policy(**numbers, odds={term: _number(path, f'{ODDS}.{term}', w) for term, w in weights.items()})


def _number(path: Path, name: str, value: object) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise BadInput(f'{path}: {name} is {value!r}, expected a number')
    return float(value)


@cache
def shipped() -> Policy:
    """The policy that comes with the package."""
    return read_policy(SHIPPED)

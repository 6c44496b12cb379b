"""YAML that people write, read with errors that name the file, the key and the nearest valid one."""

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.files.inputs import read_text
from tcp_muscle_ros.files.yaml_text import NotYaml, parse


class Section:
    """One mapping of a YAML file. ``where`` begins every error: file and path of keys.

    Every accessor raises BadInput for a value that is not what was asked for.
    """

    def __init__(self, content: object, where: str) -> None:
        if not isinstance(content, dict):
            raise BadInput(f'{where}: expected keys with values, got {_shown(content)}')
        self.where = where
        self.content: Mapping[str, object] = {str(key): value for key, value in content.items()}

    def __contains__(self, key: str) -> bool:
        return self.content.get(key) is not None

    def __getitem__(self, key: str) -> object:
        return self.content[key]

    def names(self) -> list[str]:
        """Its keys, in the order of the file."""
        return list(self.content)

    def only(self, *known: str) -> 'Section':
        """This section, once it is sure to have no key but `known`."""
        for key in self.content:
            if key not in known:
                raise BadInput(f"{self.where}: unknown key '{key}'{nearest(key, known)}")
        return self

    def require(self, *keys: str) -> None:
        """BadInput unless all `keys` are there."""
        for key in keys:
            if key not in self:
                raise BadInput(f"{self.where}: the key '{key}' is missing")

    def number(
        self, key: str, default: float | None = None, *, above: float = -math.inf, least: float = -math.inf
    ) -> float:
        """A finite number > `above` and >= `least`."""
        if key not in self and default is not None:
            return default
        self.require(key)
        value = as_number(self.content[key], f'{self.where}: {key}')
        if value <= above or value < least:
            bound = f'> {above:g}' if value <= above else f'>= {least:g}'
            raise BadInput(f'{self.where}: {key} is {value:g}, expected a number {bound}')
        return value

    def count(self, key: str, default: int) -> int:
        """A whole number >= 1."""
        value = self.number(key, float(default))
        if value < 1 or value != round(value):
            raise BadInput(f'{self.where}: {key} is {value:g}, expected a whole number of 1 or more')
        return int(value)

    def text(self, key: str, default: str | None = None) -> str:
        """A text (a number is taken as it is written)."""
        if key not in self and default is not None:
            return default
        self.require(key)
        value = self.content[key]
        if isinstance(value, (dict, list, bool)):
            raise BadInput(f'{self.where}: {key} is {_shown(value)}, expected a text')
        return str(value)

    def choice(self, key: str, choices: Collection[str], default: str | None = None) -> str:
        """One of `choices`."""
        value = self.text(key, default)
        if value not in choices:
            raise BadInput(f"{self.where}: {key} is '{value}'{nearest(value, choices)}")
        return value

    def section(self, key: str) -> 'Section':
        """A mapping inside this one; empty where it is not given."""
        return Section(self.content.get(key) or {}, f'{self.where}: {key}')

    def sections(self, key: str) -> Iterator['Section']:
        """The mappings of a list; at least one."""
        self.require(key)
        items = self.content[key]
        if not isinstance(items, Sequence) or isinstance(items, str) or not items:
            raise BadInput(f'{self.where}: {key} is {_shown(items)}, expected a list with at least one entry')
        for k, item in enumerate(items, 1):
            yield Section(item, f'{self.where}: {key} {k}')


def as_number(value: object, where: str) -> float:
    """A finite float. YAML reads ``1e-3`` as a text, people do not."""
    try:
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            raise ValueError
        number = float(value)
    except (OverflowError, ValueError):
        raise BadInput(f'{where} is {_shown(value)}, expected a number') from None
    if not math.isfinite(number):
        raise BadInput(f'{where} is {number}, expected a finite number')
    return number


def number_or_none(value: object, offset: float = 0.0) -> float | None:
    """A number that was written down, also as YAML's word ``5e-1``, else None."""
    try:
        return as_number(value, '') + offset
    except BadInput:
        return None


def load_yaml(path: str | Path, shipped: Iterable[Path] = ()) -> Section:
    """A YAML file whose content is a mapping. BadInput: missing, unreadable, or no YAML (with line and column).

    ``shipped``: files of its kind that come along, named where the path is not like any that is beside it.
    """
    path = Path(path)
    try:
        content = parse(read_text(path))
    except OSError as error:
        siblings = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
        files = [name for name in siblings if name.endswith(('.yaml', '.yml'))]
        hint = nearest(path.name, files, key=lambda name: Path(name).stem.lower())  # the suffix makes any two alike
        if shipped and 'did you mean' not in hint:
            hint = f'; known: {", ".join(map(str, shipped))}'
        raise BadInput(f'{path}: cannot be read ({error.strerror}){hint}') from None
    except UnicodeDecodeError:
        raise BadInput(f'{path}: not UTF-8 text, expected YAML') from None
    except NotYaml as error:
        at = f':{error.at[0]}:{error.at[1]}' if error.at else ''
        raise BadInput(f'{path}{at}: not valid YAML: {error}') from None
    return Section(content, str(path))


def _shown(value: object) -> str:
    if value is None:
        return 'nothing'
    text = repr(value)
    return text if len(text) < 60 else text[:56] + ' ...'

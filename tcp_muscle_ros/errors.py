"""What a user got wrong, said in one line."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from difflib import get_close_matches

_SHORT = 3  # letters


@dataclass(frozen=True)
class Option:
    """What a message names for its reader to give or to change: an option of a command, an argument in Python.

    As text it is the option.
    """

    command: str
    python: str

    def __str__(self) -> str:
        return self.command


class BadInput(ValueError):
    """A user's mistake: one line that says what was wrong, where, and what was expected.

    Its ``args`` are the parts of that line, texts and Options, so that whoever shows it has the words for its reader
    (see ``interface/wording.py``). Programs turn it into exit code 2 without a traceback.
    """

    def __str__(self) -> str:
        return ''.join(map(str, self.args))

    def replaced(self, old: str, new: str) -> BadInput:
        """The same with other words in its texts: a path that the user gave for one that was made in its place."""
        return BadInput(*(part.replace(old, new) if isinstance(part, str) else part for part in self.args))


def install(extra: str) -> str:
    """How an extra of this package is installed: it is in no index, so from its checkout."""
    return f"pip install '.[{extra}]' in the checkout of tcp_muscle_ros"


def needs_ros(error: ImportError) -> BadInput:
    """What is told where a command finds no ROS 2."""
    return BadInput(f"needs ROS 2's rclpy ({error}); source a ROS 2, or {install('ros')}")


def nearest(name: str, choices: Iterable[str], key: Callable[[str], str] = str.lower) -> str:
    """The clause that ends an error about an unknown name; ``key``: by which names are compared.

    ``"; did you mean 'hA'?"`` where a known name is close, else the whole (short) list, else nothing.
    """
    known = sorted(set(choices))
    by_key = {key(choice): choice for choice in known}
    asked = key(name)
    cutoff = 0.6 if len(asked) > _SHORT else 0.5  # one of two letters is right: 'ko' for 'k0'
    close = get_close_matches(asked, by_key, n=1, cutoff=cutoff)
    if close:
        return f"; did you mean '{by_key[close[0]]}'?"
    if 0 < len(known) <= 12:
        return '; known: ' + ', '.join(known)
    return ''

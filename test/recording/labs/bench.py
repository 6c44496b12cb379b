"""What every lab file of the corpus shows: a muscle that rests, is heated and cools, and what an import must find.

A file is a function that returns its bytes and its runs; the numbers that it must be read as come from the same rounded
arrays, never from the importer.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FILES: dict[str, 'LabFile'] = {}


@dataclass(frozen=True)
class Expected:
    """One run: how long it lasts (s), its rows, and by channel its first and last value in the unit of its topic."""

    duration: float
    rows: int
    channels: Mapping[str, tuple[float, float]]


Made = tuple[bytes, list[Expected]]


@dataclass(frozen=True)
class LabFile:
    """One odd file. One that cannot be understood has no runs; the line that says so has the words of `missing`."""

    name: str
    make: Callable[[], Made]
    missing: tuple[str, ...]
    odd: str


def lab_file(name: str, missing: tuple[str, ...] = ()) -> Callable[[Callable[[], Made]], LabFile]:
    """Enter a file; its docstring says what is odd about it."""

    def enter(make: Callable[[], Made]) -> LabFile:
        assert name not in FILES and make.__doc__
        FILES[name] = LabFile(name, make, missing, make.__doc__)
        return FILES[name]

    return enter


@dataclass(frozen=True)
class Muscle:
    """A run on the bench, SI but degC, by names: t i v p T R x F load amb."""

    of: Mapping[str, Array] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Array:
        return self.of[name]


def muscle(n: int = 30, dt: float = 0.5, current: float = 0.27, load: float = 1.47, seed: int = 1) -> Muscle:
    """Rest for a fifth, heating for two fifths, cooling for the rest; a little noise on what is measured."""
    rng = np.random.default_rng(seed)
    t = dt * np.arange(n)
    on = (np.arange(n) >= n // 5) & (np.arange(n) < 3 * n // 5)
    i = np.where(on, current, 0.0)
    tau, rise = 0.25 * n * dt, 55.0 * (current / 0.27) ** 2
    warm = np.zeros(n)
    for k in range(1, n):
        warm[k] = warm[k - 1] + dt / tau * (np.where(on[k - 1], rise, 0.0) - warm[k - 1])
    R = 7.8 * (1 + 1.2e-3 * warm)
    T = 23.4 + warm + 0.05 * rng.standard_normal(n)
    x = 9e-5 * warm**1.2 + 4e-6 * rng.standard_normal(n)
    F = load + 0.012 * warm + 0.002 * rng.standard_normal(n)
    amb = 23.4 + 0.02 * rng.standard_normal(n)
    R = R + 0.004 * rng.standard_normal(n)
    return Muscle(
        {
            't': t,
            'i': i,
            'v': i * R,
            'p': i * i * R,
            'T': T,
            'R': R,
            'x': x,
            'F': F,
            'load': np.full(n, load),
            'amb': amb,
        }
    )


def run(t: Array, **channels: Array | tuple[float, float]) -> Expected:
    """What must be found: time in s, each channel as an array (or first and last) in the unit of its topic."""
    found = {
        name: value if isinstance(value, tuple) else (float(value[0]), float(value[-1]))
        for name, value in channels.items()
    }
    return Expected(float(t[-1] - t[0]), len(t), found)


def table(columns: list[Array | list[str]], formats: list[str], sep: str = ',', comma: bool = False) -> list[str]:
    """Lines of a table; with decimal commas where `comma` says so."""
    lines = []
    for row in zip(*columns, strict=True):
        cells = [cell if isinstance(cell, str) else format(cell, how) for cell, how in zip(row, formats, strict=True)]
        if comma:
            cells = [
                cell if isinstance(was, str) else cell.replace('.', ',') for cell, was in zip(cells, row, strict=True)
            ]
        lines.append(sep.join(cells))
    return lines


def text(lines: list[str], encoding: str = 'utf-8', newline: str = '\n') -> bytes:
    """The bytes of a text file."""
    return (newline.join(lines) + newline).encode(encoding)

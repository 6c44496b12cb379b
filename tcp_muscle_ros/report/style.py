"""One look for every figure: colour-blind-safe colours (Okabe & Ito 2008), units on every axis.

Figures are made without pyplot: no display is needed, and the backend of a notebook stays what it is.
"""

from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backend_bases import FigureCanvasBase
from matplotlib.figure import Figure

from tcp_muscle_ros.errors import BadInput, Option
from tcp_muscle_ros.files.outputs import writable_file

FIGURE = Option('--figure', 'path')
RECORDED, PREDICTED, IMPROVED, SETPOINT, DRIVE = '#000000', '#D55E00', '#0072B2', '#009E73', '#CC79A7'
BEFORE, AFTER, HEATING, COOLING, LOAD, OTHER = PREDICTED, IMPROVED, '#D55E00', '#56B4E9', '#009E73', '#888888'


def canvas(
    rows: int,
    columns: int = 1,
    *,
    width: float = 9.0,
    height: float = 2.2,
    figure: Figure | None = None,
    **options: Any,
) -> tuple[Figure, list[Axes]]:
    """A figure (a new one, unless it is given) with its axes as a flat list."""
    figure = figure or Figure(figsize=(width, height * rows), layout='constrained')
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    flat = [axis for row in axes for axis in row]
    _plain(flat)
    return figure, flat


def stacked(channels: int, *, width: float = 9.0) -> tuple[Figure, Axes, list[tuple[Axes, Axes]]]:
    """A figure over one time: a low panel on top, then for each channel a panel with a low one below it."""
    heights = [1.0, *[2.0, 0.9] * channels]
    figure = Figure(figsize=(width, 0.95 * sum(heights)), layout='constrained')
    axes = figure.subplots(len(heights), 1, sharex=True, gridspec_kw={'height_ratios': heights})
    _plain(list(axes))
    return figure, axes[0], [(axes[1 + 2 * k], axes[2 + 2 * k]) for k in range(channels)]


def _plain(axes: list[Axes]) -> None:
    for axis in axes:
        axis.grid(alpha=0.25, linewidth=0.6)
        axis.spines[['top', 'right']].set_visible(False)


def picture_path(path: str | Path, *, force: bool = False, option: str | Option = FIGURE) -> Path:
    """The path of a picture that is still to be drawn. BadInput where that is not possible, or something is there.

    ``option`` gave the path.
    """
    path = writable_file(path, force=force, option=option)
    if path.suffix.lower()[1:] not in FigureCanvasBase.get_supported_filetypes():
        raise BadInput(f'{path}: no kind of picture; expected {path.with_suffix(".png").name}, or .pdf, .svg, .jpg')
    return path


def literal(name: str) -> str:
    """A name that somebody gave, as it is: between two dollars stands no formula."""
    return name.replace('$', r'\$')


def save(figure: Figure, path: object) -> None:
    """Write a picture."""
    figure.savefig(str(path), dpi=110)

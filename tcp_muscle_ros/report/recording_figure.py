"""The channels of recordings, one above the other over one time."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.tails import tail_of
from tcp_muscle_ros.recording.recording import CHANNELS, Channel, Recording
from tcp_muscle_ros.report.as_read import CHANNEL_AXIS, shown
from tcp_muscle_ros.report.style import COOLING, DRIVE, IMPROVED, PREDICTED, RECORDED, SETPOINT, canvas, literal

_COLOURS = (RECORDED, PREDICTED, IMPROVED, SETPOINT, DRIVE, COOLING)
_COMMANDED = {'displacement_setpoint': 'displacement'}  # is drawn with, dashed


def draw_recordings(recordings: Sequence[Recording], figure: Figure | None = None) -> Figure:
    """A panel a channel, inputs on top; a colour a recording, what is commanded dashed. BadInput: nothing to draw."""
    recorded = {_panel(name) for recording in recordings for name in recording}
    panels = [name for name in CHANNELS if name in recorded]
    if not panels:
        raise BadInput(f'{recordings[0].path if recordings else "nothing"}: no channel to draw')
    drawn, axes = canvas(len(panels), figure=figure, sharex=True)
    for k, recording in enumerate(recordings):
        for channel in recording.channels.values():
            if len(channel):
                _draw(axes[panels.index(_panel(channel.name))], channel, _colour(k))
    for axis, name in zip(axes, panels, strict=True):
        axis.set_ylabel(CHANNEL_AXIS[name])
    if len(recordings) > 1:
        lines = [Line2D([], [], color=_colour(k)) for k in range(len(recordings))]
        legend = axes[0].legend(lines, [*map(str, range(len(lines)))], loc='best', fontsize=8, frameon=False)
        for text, name in zip(legend.get_texts(), _names([r.path for r in recordings]), strict=True):
            text.set_text(literal(name))  # as a label, a name that begins with _ would be left out
    else:
        axes[0].set_title(literal(Path(recordings[0].path).name), fontsize=10)
    axes[-1].set_xlabel('time (s)')
    return drawn


def _panel(name: str) -> str:
    return _COMMANDED.get(name, name.removesuffix('_command'))


def _colour(k: int) -> str:
    return _COLOURS[k] if k < len(_COLOURS) else f'C{k - len(_COLOURS)}'


def _names(paths: Sequence[str]) -> list[str]:
    """The ends of paths, as short as tells them apart; numbered where nothing does."""
    given = [Path(path) for path in paths]
    names = ['/'.join(tail_of(path, given)) for path in given]
    if len(set(names)) == len(names):
        return names
    return [f'{path.name} ({number})' for number, path in enumerate(given, 1)]


def _draw(axis: Axes, channel: Channel, colour: str) -> None:
    kind = CHANNELS[channel.name]
    axis.plot(
        channel.time,
        shown(_panel(channel.name), channel.value),
        color=colour,
        linewidth=1.0,
        linestyle='--' if kind.role == 'commanded' else '-',
        drawstyle='default' if kind.role == 'output' else 'steps-post',
    )

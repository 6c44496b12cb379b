"""The channels of recordings, one above the other over one time."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.recording import CHANNELS, Channel, Recording
from tcp_muscle_ros.report.as_read import CHANNEL_AXIS, shown
from tcp_muscle_ros.report.style import COOLING, DRIVE, IMPROVED, PREDICTED, RECORDED, SETPOINT, canvas

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
                _draw(axes[panels.index(_panel(channel.name))], channel, _COLOURS[k % len(_COLOURS)], recording)
    for axis, name in zip(axes, panels, strict=True):
        axis.set_ylabel(CHANNEL_AXIS[name])
    if len(recordings) > 1:
        axes[0].legend(*_first_of_each(axes), loc='best', fontsize=8, frameon=False)
    else:
        axes[0].set_title(Path(recordings[0].path).name, fontsize=10)
    axes[-1].set_xlabel('time (s)')
    return drawn


def _panel(name: str) -> str:
    return _COMMANDED.get(name, name.removesuffix('_command'))


def _draw(axis: Axes, channel: Channel, colour: str, recording: Recording) -> None:
    kind = CHANNELS[channel.name]
    axis.plot(
        channel.time,
        shown(_panel(channel.name), channel.value),
        color=colour,
        linewidth=1.0,
        linestyle='--' if kind.role == 'commanded' else '-',
        drawstyle='default' if kind.role == 'output' else 'steps-post',
        label=Path(recording.path).name,
    )


def _first_of_each(axes: Sequence[Axes]) -> tuple[list[Artist], list[str]]:
    """One entry a recording, whichever panels it is in."""
    found: dict[str, Artist] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            found.setdefault(str(label), handle)
    return list(found.values()), list(found)

"""Pictures of a muscle that follows a setpoint: the controllers side by side, and a recorded demonstration."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from tcp_muscle_ros.control.offline import Run
from tcp_muscle_ros.recording.recording import Recording
from tcp_muscle_ros.report.as_read import CHANNEL_AXIS, shown
from tcp_muscle_ros.report.style import DRIVE, IMPROVED, PREDICTED, RECORDED, SETPOINT, canvas, save
from tcp_muscle_ros.studies.control_study import Figures, Step

_COLOUR = {'model': IMPROVED, 'pid': PREDICTED}
_NAME = {'model': 'model inverse with observer', 'pid': 'plain PID'}


def draw_control(
    runs: Mapping[str, Run], others: Mapping[Step, Sequence[tuple[str, Figures]]], path: str | Path
) -> None:
    """Both modes on one profile (``runs``, by mode), and beside it how muscles that are not the model take a step
    (``others``: by current limit and target, the mode and what happened, muscle after muscle)."""
    figure, axes = canvas(3, 2, width=11.0, height=2.5)
    followed, error, current = axes[0], axes[2], axes[4]
    first = runs['model']
    followed.plot(first.time, 1e3 * first.setpoint, color=RECORDED, lw=1.2, ls='--', label='setpoint')
    for mode, happened in runs.items():
        style: dict[str, Any] = {'color': _COLOUR[mode], 'lw': 1.3, 'label': _NAME[mode]}
        followed.plot(happened.time, 1e3 * happened.displacement, **style)
        error.plot(happened.time, 1e3 * (happened.displacement - happened.setpoint), **style)
        below = 0 if mode == 'model' else -1
        current.plot(happened.time, happened.current, **{**style, 'lw': 0.8, 'zorder': 2 + below})
    error.set_ylim(-1.0, 1.0)
    followed.set(title='0.27 A, 60 g, sensor noise 0.02 mm', ylabel='contraction (mm)')
    error.set_ylabel('error (mm)')
    current.set(ylabel='current (A)', xlabel='time (s)')
    followed.legend(loc='lower right', fontsize=8)

    for axis, ((limit, target), steps) in zip(axes[1::2], others.items(), strict=True):
        for number, (mode, figures) in enumerate(steps):
            since = figures.run.time / figures.physical_time
            share = 100.0 * figures.run.displacement / target
            label = _NAME[mode] if number < len(_NAME) else None
            axis.plot(since, share, color=_COLOUR[mode], lw=0.7, alpha=0.7, label=label)
        axis.axhspan(98.0, 102.0, color=SETPOINT, alpha=0.2, lw=0, label='2 % band')
        axis.axvline(1.0, color=RECORDED, lw=0.8, ls=':', label='full current enters the band')
        axis.set(xlim=(0.8, 2.0), ylim=(90.0, 104.0), ylabel='contraction (%)')
        axis.set_title(
            f'{len(steps) // len(_NAME)} muscles within 20 % of the model: {1e3 * target:.0f} mm at {limit:.2f} A',
            fontsize=9,
        )
    axes[5].set_xlabel('time / time that full current needs')
    axes[1].legend(loc='lower right', fontsize=8)
    save(figure, path)


def draw_followed(recording: Recording, path: str | Path, *, title: str, current_limit: float, until: float) -> None:
    """A recorded session up to ``until`` (s): setpoint and displacement, temperature, current with its limit (A)."""
    figure, (followed, warm, driven) = canvas(3, height=2.3, sharex=True)

    def line(axis: Axes, name: str, **style: Any) -> None:
        channel = recording[name]
        kind = 'displacement' if name == 'displacement_setpoint' else name
        axis.plot(channel.time, shown(kind, channel.value), **style)
        axis.set_ylabel(CHANNEL_AXIS[kind])

    line(followed, 'displacement', color=IMPROVED, lw=2.0, label='measured')
    line(followed, 'displacement_setpoint', color=RECORDED, lw=1.2, ls='--', label='setpoint')
    line(warm, 'temperature', color=PREDICTED, lw=1.0)
    line(driven, 'current', color=DRIVE, lw=1.0, drawstyle='steps-post')
    driven.axhline(current_limit, color=RECORDED, lw=0.9, ls=':')
    beside: dict[str, Any] = {'xytext': (-4, 2), 'textcoords': 'offset points', 'ha': 'right', 'fontsize': 8}
    driven.annotate('current limit', (until, current_limit), **beside)
    driven.set(xlabel='time (s)', xlim=(0.0, until), ylim=(-0.01, 1.15 * current_limit))
    followed.set_title(title, loc='left', fontsize=11)
    followed.legend(loc='upper right', fontsize=9, frameon=False)
    save(figure, path)

"""Pictures of a muscle that follows a setpoint: the controllers side by side, and a recorded demonstration."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from tcp_muscle_ros.control.offline import Run, Sensors, run
from tcp_muscle_ros.muscle import Muscle, Parameters
from tcp_muscle_ros.recording.recording import Recording
from tcp_muscle_ros.report.style import (
    CHANNEL_AXIS,
    DRIVE,
    IMPROVED,
    PREDICTED,
    RECORDED,
    SETPOINT,
    canvas,
    save,
    shown,
)
from tcp_muscle_ros.studies import control_study as study

_COLOUR = {'model': IMPROVED, 'pid': PREDICTED}
_NAME = {'model': 'model inverse with observer', 'pid': 'plain PID'}


def _profile(time: np.ndarray) -> np.ndarray:
    wanted = np.select([time < 15.0, time < 30.0, time < 45.0], [0.020, 0.040, 0.030], 0.0)
    sine = 0.025 + 0.005 * np.sin(2.0 * np.pi * (time - 45.0) / 20.0)
    return np.where(time >= 45.0, sine, wanted)


def _with_noise(model: Parameters, mode: str) -> Run:
    time = np.arange(0.0, 85.0, study.PERIOD)
    return run(
        study.controller(model, 0.27, mode=mode),
        Muscle(model, load=study.LOAD),
        study.PERIOD,
        _profile(time),
        sensors=Sensors(displacement_noise=2e-5, seed=3),
    )


def draw_control(model: Parameters, path: str | Path) -> None:
    """Both modes on one profile with 0.02 mm of sensor noise, and beside it 20 muscles that are not the model."""
    figure, axes = canvas(3, 2, width=11.0, height=2.5)
    runs: Mapping[str, Run] = {mode: _with_noise(model, mode) for mode in _COLOUR}
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

    for axis, (limit, target) in zip(axes[1::2], ((0.27, 0.040), (0.40, 0.020), (0.40, 0.040)), strict=True):
        for number, (plant, _) in enumerate(study.draws(model, 20, seed=1)):
            for mode in ('pid', 'model'):
                figures = study.heating(plant, model, limit, target, mode=mode)
                since = figures.run.time / figures.physical_time
                share = 100.0 * figures.run.displacement / target
                label = _NAME[mode] if number == 0 else None
                axis.plot(since, share, color=_COLOUR[mode], lw=0.7, alpha=0.7, label=label)
        axis.axhspan(98.0, 102.0, color=SETPOINT, alpha=0.2, lw=0, label='2 % band')
        axis.axvline(1.0, color=RECORDED, lw=0.8, ls=':', label='full current enters the band')
        axis.set(xlim=(0.8, 2.0), ylim=(90.0, 104.0), ylabel='contraction (%)')
        axis.set_title(f'20 muscles within 20 % of the model: {1e3 * target:.0f} mm at {limit:.2f} A', fontsize=9)
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

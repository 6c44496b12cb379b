"""Pictures of a muscle that follows a setpoint: the controllers side by side, and a recorded demonstration."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tcp_muscle_ros.control.offline import Run, Sensors, run
from tcp_muscle_ros.muscle import ZERO_CELSIUS, Muscle, Parameters
from tcp_muscle_ros.report import control_study as study
from tcp_muscle_ros.report.style import DRIVE, IMPROVED, PREDICTED, RECORDED, SETPOINT, canvas, save

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


def draw_followed(
    time: np.ndarray,
    setpoint: np.ndarray,
    displacement: np.ndarray,
    temperature: np.ndarray,
    current: np.ndarray,
    path: str | Path,
    *,
    title: str,
    current_limit: float,
) -> None:
    """Setpoint and displacement (m), temperature (K), current (A) over time (s), all of shape (n,)."""
    figure, (followed, warm, driven) = canvas(3, height=2.3, sharex=True)
    followed.plot(time, 1e3 * setpoint, color=RECORDED, lw=1.4, ls='--', label='setpoint')
    followed.plot(time, 1e3 * displacement, color=IMPROVED, lw=1.8, label='measured')
    followed.set_ylabel('contraction (mm)')
    followed.set_title(title, loc='left', fontsize=11)
    followed.legend(loc='upper right', ncols=2, fontsize=9, frameon=False)
    warm.plot(time, temperature - ZERO_CELSIUS, color=PREDICTED, lw=1.6)
    warm.set_ylabel('temperature (degC)')
    driven.axhline(current_limit, color=RECORDED, lw=0.9, ls=':')
    driven.annotate(
        'limit', (time[-1], current_limit), xytext=(0, 2), textcoords='offset points', ha='right', fontsize=8
    )
    driven.plot(time, current, color=DRIVE, lw=1.4, drawstyle='steps-post')
    driven.set(ylabel='current (A)', xlabel='time (s)', xlim=(float(time[0]), float(time[-1])))
    save(figure, path)

"""Recorded against predicted, channel under channel."""

from collections.abc import Mapping
from pathlib import Path

from tcp_muscle_ros.diagnosis.answer.replaying import Comparison
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.report.as_read import CHANNEL_AXIS, shown
from tcp_muscle_ros.report.style import DRIVE, PREDICTED, RECORDED, canvas, literal, save


def draw_comparison(
    path: str | Path, experiment: Experiment, compared: Mapping[str, Comparison], title: str = ''
) -> None:
    """A PNG: the input on top, then each channel as recorded and as predicted, with its band where there is one."""
    figure, axes = canvas(1 + len(compared), sharex=True)
    imposed = experiment.imposed
    axes[0].step(imposed.time, imposed.drive, where='post', color=DRIVE, linewidth=1.2)
    axes[0].set_ylabel(CHANNEL_AXIS[imposed.kind])
    axes[0].set_title(literal(title or Path(experiment.name).name), fontsize=10)
    for axis, (name, c) in zip(axes[1:], compared.items(), strict=True):
        if c.low is not None and c.high is not None:
            axis.fill_between(
                c.time,
                shown(name, c.low),
                shown(name, c.high),
                color=PREDICTED,
                alpha=0.2,
                linewidth=0,
                label='90 % band',
            )
        axis.plot(c.time, shown(name, c.recorded), color=RECORDED, linewidth=1.0, label='recorded')
        axis.plot(c.time, shown(name, c.predicted), color=PREDICTED, linewidth=1.2, label='predicted')
        axis.set_ylabel(CHANNEL_AXIS[name])
        axis.text(
            0.995, 0.95, f'NRMSE {100 * c.nrmse:.1f} %', transform=axis.transAxes, ha='right', va='top', fontsize=9
        )
    axes[1].legend(loc='upper left', fontsize=8, ncols=3, frameon=False)
    axes[-1].set_xlabel('time (s)')
    save(figure, path)

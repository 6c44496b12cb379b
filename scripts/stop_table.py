#!/usr/bin/env python3
"""What a stop explains in the bench rig's strokes that end against one: each run fitted without it and with it.

    python scripts/stop_table.py [--data ../shared/data] [--write]

A run that ends against a stop (found from the recording alone) is calibrated with the paper's model, and with
`coil_contact` at the length at which it stands; then another such run of its power is foretold, with its own stop, gain
and zero. With --write the table goes into docs/real_recordings.md. Without the data it says so and ends.
"""

from pathlib import Path

from public_table import made_today, show
from real_diagnoses import missed, power_of
from real_recordings import NOMINAL, experiments

from tcp_muscle_ros.diagnosis.answer.notes import stop_of
from tcp_muscle_ros.diagnosis.fitting.calibration import Calibration, calibrate
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle import Parameters

SOFT = 1e-3  # m, over which the stop sets in


def with_stop(muscle: Parameters, plain: Calibration, at: float) -> Parameters:
    """The muscle with a stop where the run's contraction stands, ``at`` (m); ``plain``: its fit without."""
    length = float(plain.fit.outputs[0].length[0]) - at
    values = {'coil_contact.Hc': length, 'coil_contact.s': 1.0, 'coil_contact.w': SOFT}
    return muscle.with_effects('coil_contact').replace(values)


def table(data: Path) -> list[str]:
    """The lines of the table, one a run that ends against a stop."""
    fits: dict[str, tuple[Experiment, float, Calibration, Calibration]] = {}
    for name, run in sorted(experiments(data).items()):
        stop = stop_of(run) if name.startswith('stroke_') else None
        if stop is not None:
            plain = calibrate([run], NOMINAL)
            fits[name] = run, stop[2], plain, calibrate([run], with_stop(plain.fit.muscle, plain, stop[2]))
    heading = '| run | stands at | without a stop | with it | foretold by | without a stop | with it |'
    rows = [heading, '|---|---|---|---|---|---|---|']
    for name, (run, at, plain, stopped) in fits.items():
        other = next((n for n in fits if n != name and power_of(n) == power_of(name)), '')
        cells = [f'{100 * missed(run, found.fit.muscle):.1f} %' for found in (plain, stopped)]
        if other:
            _, _, without, having = fits[other]
            foretold = with_stop(having.fit.muscle, having, at)
            cells += [other, *(f'{100 * missed(run, muscle):.1f} %' for muscle in (without.fit.muscle, foretold))]
        else:
            cells += ['-'] * 3
        rows.append(f'| {name} | {1e3 * at:.1f} mm | {" | ".join(cells)} |')
    return [*made_today(), *rows]


if __name__ == '__main__':
    show(__doc__, 'stops', table)

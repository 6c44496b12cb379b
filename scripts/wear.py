"""A muscle wears in the loop: the alarm, the diagnosis, the adopted model, and the tracking error with each.

Offline, with the controller, the twin and the diagnosis that the nodes have: a position controller follows steps, and
after five minutes the resistance begins to fall, as where turns short.
Usage: scripts/wear.py [--output docs/images/wear.png]
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use('Agg')
import matplotlib.pyplot as plt
import numpy as np

from tcp_muscle_ros.control.memory import Memory
from tcp_muscle_ros.control.predictor import Predictor
from tcp_muscle_ros.control.tracking import TrackingController
from tcp_muscle_ros.control.twin import State, Twin
from tcp_muscle_ros.muscle import Muscle, Parameters
from tcp_muscle_ros.nodes.twin_alarm import save
from tcp_muscle_ros.settings.parameter_file import read, write

PERIOD = 0.05  # s
LOAD = 0.5884  # N
LIMIT = 0.27  # A
LENGTH = 1500.0  # s
BEGINS, LASTS = 300.0, 200.0  # s: when the wear begins, and how long it goes on
WORN = {'R0': 0.7}  # times what it was
COLLECT = 150.0  # s, recorded once the twin has alarmed
STEP = 12.0  # s, of a setpoint
NOISE = {'temperature': 0.1, 'resistance': 0.01, 'displacement': 2e-5}  # K, ohm, m
NEW = Parameters.named('karami_tadesse_2017')


def worn(time: float) -> Parameters:
    """The muscle as it is at this time."""
    share = float(np.clip((time - BEGINS) / LASTS, 0.0, 1.0))
    return NEW.replace({name: NEW[name] * (1.0 + share * (factor - 1.0)) for name, factor in WORN.items()})


def diagnosed(folder: Path, memory: Memory, since: float) -> Parameters:
    """What ``tcp_muscle diagnose`` finds in what was kept since then."""
    save(folder / 'differs', memory.columns(), since, LOAD)
    write(folder / 'model.yaml', NEW, operating={'load_n': LOAD})
    command = ['diagnose', str(folder / 'differs'), '--params', str(folder / 'model.yaml')]
    done = subprocess.run(
        [sys.executable, '-m', 'tcp_muscle_ros.tool', *command, '--output', str(folder / 'report')],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    print(done.stdout.splitlines()[0])
    return read(folder / 'report' / 'improved.yaml').parameters


def controller(model: Parameters) -> TrackingController:
    """A controller that believes in this muscle."""
    return TrackingController(model, PERIOD, LIMIT, LOAD, NEW['T0'])


def run(folder: Path) -> tuple[np.ndarray, dict[str, float]]:
    """The whole story: rows of time (s), setpoint, displacement (m) and residual (m), and when what happened (s)."""
    random = np.random.default_rng(0)
    muscle, twin, control = (
        Muscle(NEW, load=LOAD),
        Twin(Predictor(NEW, load=LOAD, ambient=NEW['T0']), PERIOD),
        controller(NEW),
    )
    memory = Memory((*NOISE, 'current'), round(600.0 / PERIOD))
    rows, events, current = [], dict[str, float](), 0.0
    for k in range(round(LENGTH / PERIOD)):
        time = k * PERIOD
        if BEGINS <= time <= BEGINS + LASTS + 1.0 and k % 20 == 0:
            state = muscle.state
            muscle = Muscle(worn(time), load=LOAD)
            muscle.state[:] = state
        reading = muscle.step(PERIOD, current)
        shown = {name: getattr(reading, name) + s * random.standard_normal() for name, s in NOISE.items()}
        tick = twin.tick(time, PERIOD, current, LOAD, NEW['T0'], shown)
        setpoint = 0.004 + 0.003 * (int(time / STEP) % 3)
        command = control.update(setpoint, displacement=shown['displacement'], applied_current=current)
        current = command.current
        memory.add(time, [*shown.values(), current])
        rows.append((time, setpoint, reading.displacement, tick.residual[2]))
        if twin.state is State.DIFFERS and 'alarm' not in events:
            events['alarm'] = time
            print(f'{time:.0f} s: {twin.difference}')
        if 'alarm' in events and 'diagnosed' not in events and time > max(events['alarm'], BEGINS + LASTS) + COLLECT:
            events['diagnosed'] = time
            twin.propose(Predictor(diagnosed(folder, memory, time - COLLECT), load=LOAD, ambient=NEW['T0']), time)
        for event in twin.events:
            print(f'{time:.0f} s: {event}')
            events.setdefault('adopted', time)
            control = controller(twin.predictor.model)
        twin.events.clear()
    return np.array(rows), events


def tracking_error(rows: np.ndarray, begin: float, end: float) -> float:
    """Root mean square of setpoint minus displacement between two times, m."""
    chosen = rows[(rows[:, 0] >= begin) & (rows[:, 0] < end)]
    return float(np.sqrt(np.mean((chosen[:, 1] - chosen[:, 2]) ** 2)))


def draw(path: Path, rows: np.ndarray, events: dict[str, float]) -> None:
    """Tracking error and residual over time."""
    figure, (above, below) = plt.subplots(2, 1, figsize=(9, 5.5), sharex=True, layout='constrained')
    window = round(3 * STEP / PERIOD)
    squared = np.convolve((rows[:, 1] - rows[:, 2]) ** 2, np.ones(window) / window, mode='valid')
    above.plot(rows[window - 1 :, 0], 1e3 * np.sqrt(squared), color='#1f77b4')
    above.set_ylim(0.0, None)
    above.set_ylabel('tracking error, mm\n(rms over 36 s)')
    below.plot(rows[:, 0], 1e3 * rows[:, 3], color='#d62728', linewidth=0.6)
    below.set_ylabel('measured minus\npredicted, mm')
    below.set_xlabel('time, s')
    for axis in (above, below):
        axis.axvspan(BEGINS, BEGINS + LASTS, color='0.9')
        for name, when in events.items():
            axis.axvline(when, color='0.3', linewidth=0.8)
            if axis is above:
                axis.annotate(name, (when, 1.0), xycoords=('data', 'axes fraction'), rotation=90, va='top', ha='right')
    above.annotate('wears', (BEGINS, 0.02), xycoords=('data', 'axes fraction'))
    figure.savefig(path, dpi=110)


def main() -> None:
    """Run, print, draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--output', type=Path, default=Path('docs/images/wear.png'))
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows, events = run(Path(folder))
    adopted = events.get('adopted', LENGTH - 200.0)
    for name, begin, end in (
        ('before', 60.0, BEGINS),
        ('worn, not yet adopted', BEGINS + LASTS, adopted),
        ('adopted', adopted + 60.0, LENGTH),
    ):
        print(f'tracking error {name}: {1e3 * tracking_error(rows, begin, end):.3f} mm')
    print(events)
    draw(args.output, rows, events)


if __name__ == '__main__':
    main()

"""A muscle wears in the loop: the alarm, the diagnosis, the adopted model, and the tracking error with each.

Offline, with the controller, the twin and the diagnosis that the nodes have: a position controller follows steps, and
after five minutes its resistance begins to fall (as where turns short), its stiffness to fall, or its friction to grow.
Usage: scripts/wear.py [--only resistance stiffness friction] [--output docs/images/wear.png]
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use('Agg')
import matplotlib.pyplot as plt
import numpy as np

from tcp_muscle_ros.control.handover import FADE, Handover
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
# Of each kind of wear: the parameter, what it was, what it becomes.
NEW = Parameters.named('karami_tadesse_2017')
WEARS = {
    'resistance': ('R0', NEW['R0'], 0.7 * NEW['R0']),
    'stiffness': ('k0', NEW['k0'], 0.9 * NEW['k0']),
    'friction': ('friction.Ff', 0.0, 0.03),
}
COLLECT = 150.0  # s, recorded once the twin has alarmed
STEP = 12.0  # s, of a setpoint
NOISE = {'temperature': 0.1, 'resistance': 0.01, 'displacement': 2e-5}  # K, ohm, m
SETTLED = 6.0  # s of a setpoint, after which the step itself is over


def worn(wear: str, time: float) -> Parameters:
    """The muscle as it is at this time."""
    name, before, after = WEARS[wear]
    share = float(np.clip((time - BEGINS) / LASTS, 0.0, 1.0))
    effect = name.partition('.')[0]
    return (NEW.with_effects(effect) if '.' in name else NEW).replace({name: before + share * (after - before)})


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


class Story:
    """A muscle that wears, its controller and its twin. Rows: time (s), setpoint, displacement, residual (m), A."""

    def __init__(self, wear: str, folder: Path) -> None:
        self.wear, self.folder = wear, folder
        self.random = np.random.default_rng(0)
        self.muscle = Muscle(worn(wear, 0.0), load=LOAD)
        self.twin = Twin(Predictor(NEW, load=LOAD, ambient=NEW['T0']), PERIOD)
        self.control = Handover(controller(NEW), PERIOD)
        self.memory = Memory((*NOISE, 'current'), round(600.0 / PERIOD))
        self.rows = np.zeros((round(LENGTH / PERIOD), 5))
        self.events: dict[str, float] = {}

    def run(self) -> None:
        """From new to worn, diagnosed and adopted."""
        current = 0.0
        for k in range(len(self.rows)):
            time = k * PERIOD
            if BEGINS <= time <= BEGINS + LASTS + 1.0 and k % 20 == 0:
                self._wear(time)
            reading = self.muscle.step(PERIOD, current)
            shown = {name: getattr(reading, name) + s * self.random.standard_normal() for name, s in NOISE.items()}
            shown['displacement'] += self._lower(time)
            tick = self.twin.tick(time, PERIOD, current, LOAD, NEW['T0'], shown)
            setpoint = 0.004 + 0.003 * (int(time / STEP) % 3)
            self.memory.add(time, [*shown.values(), current])
            command = self.control.update(setpoint, displacement=shown['displacement'], applied_current=current)
            current = command.current
            self.rows[k] = time, setpoint, reading.displacement + self._lower(time), tick.residual[2], current
            self._notice(time)

    def _wear(self, time: float) -> None:
        state = self.muscle.state
        self.muscle = Muscle(worn(self.wear, time), load=LOAD)
        self.muscle.state[:] = state

    def _lower(self, time: float) -> float:
        """How much lower the load hangs at rest than when the muscle was new and the ruler was zeroed, m (negative)."""
        return LOAD / NEW['k0'] - LOAD / worn(self.wear, time)['k0']

    def _notice(self, time: float) -> None:
        twin, events = self.twin, self.events
        if twin.state is State.DIFFERS and 'alarm' not in events:
            events['alarm'] = time
            print(f'{time:.0f} s: {twin.difference}')
        if 'alarm' in events and 'diagnosed' not in events and time > max(events['alarm'], BEGINS + LASTS) + COLLECT:
            events['diagnosed'] = time
            model = diagnosed(self.folder, self.memory, time - COLLECT)
            twin.propose(Predictor(model, load=LOAD, ambient=NEW['T0']), time)
        for event in twin.events:
            print(f'{time:.0f} s: {event}')
            if 'adopted' not in events and event.startswith('adopted'):
                events['adopted'] = time
            back = twin.predictor.model is NEW
            self.control.adopt(None if back else controller(twin.predictor.model))
        twin.events.clear()

    def told(self) -> list[tuple[str, float, float, float]]:
        """By epoch: rms of the tracking error, of it once a step is over, and of the twin's residual, m."""
        adopted = self.events.get('adopted', LENGTH - 200.0)
        epochs = (
            ('before', 60.0, BEGINS),
            ('while it wears', BEGINS, BEGINS + LASTS),
            ('worn', BEGINS + LASTS, adopted),
            ('adopted', adopted + FADE, LENGTH),
        )
        return [(name, *self._errors(begin, end)) for name, begin, end in epochs]

    def _errors(self, begin: float, end: float) -> tuple[float, float, float]:
        time, setpoint, x, residual, _ = self.rows[(self.rows[:, 0] >= begin) & (self.rows[:, 0] < end)].T
        over = time % STEP >= SETTLED

        def rms(values: np.ndarray) -> float:
            return float(np.sqrt(np.mean(values**2)))

        return rms(setpoint - x), rms((setpoint - x)[over]), rms(residual)

    def step(self) -> tuple[float, float]:
        """The change of the current (A) from tick to tick: the largest once a step is over, and that on adopting."""
        time, change = self.rows[:, 0], np.abs(np.diff(self.rows[:, 4], prepend=self.rows[0, 4]))
        adopting = int(np.searchsorted(time, self.events.get('adopted', LENGTH - PERIOD))) + 1
        return float(change[time % STEP >= SETTLED].max()), float(change[adopting : adopting + 2].max(initial=0.0))


def draw(path: Path, stories: Sequence[Story]) -> None:
    """Tracking error and residual over time, a column a kind of wear."""
    figure, axes = plt.subplots(2, len(stories), figsize=(4.2 * len(stories), 5.5), sharex=True, layout='constrained',
                                squeeze=False)  # fmt: skip
    for (above, below), story in zip(axes.T, stories, strict=True):
        time, setpoint, x, residual, _ = story.rows.T
        over = time % STEP >= SETTLED
        held = (time // STEP).astype(int)
        error = np.array([np.sqrt(np.mean((setpoint - x)[over & (held == k)] ** 2)) for k in range(held[-1])])
        above.plot(STEP * (np.arange(held[-1]) + 1), 1e3 * error, '.', markersize=3, color='#1f77b4')
        above.set_ylim(0.0, None)
        above.set_title(story.wear)
        below.plot(time, 1e3 * residual, color='#d62728', linewidth=0.6)
        below.set_xlabel('time, s')
        for axis in (above, below):
            axis.axvspan(BEGINS, BEGINS + LASTS, color='0.9')
            for name, when in story.events.items():
                axis.axvline(when, color='0.3', linewidth=0.8)
                if axis is below:
                    axis.annotate(
                        name, (when, 1.0), xycoords=('data', 'axes fraction'), rotation=90, va='top', ha='right'
                    )
        above.annotate('wears', (BEGINS, 0.93), xycoords=('data', 'axes fraction'))
    axes[0, 0].set_ylabel('tracking error, mm\n(rms of the last 6 s of a setpoint)')
    axes[1, 0].set_ylabel('measured minus\npredicted, mm')
    figure.savefig(path, dpi=110)


def main() -> None:
    """Run, print, draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--only', nargs='+', choices=list(WEARS), default=list(WEARS))
    parser.add_argument('--output', type=Path, default=Path('docs/images/wear.png'))
    args = parser.parse_args()
    stories = []
    print('| wear | epoch | tracking error, mm | once a step is over, mm | residual, mm |\n|---|---|---|---|---|')
    for wear in args.only:
        with tempfile.TemporaryDirectory() as folder:
            story = Story(wear, Path(folder))
            story.run()
        stories.append(story)
        for epoch, *errors in story.told():
            print(f'| {wear} | {epoch} | ' + ' | '.join(f'{1e3 * error:.3f}' for error in errors) + ' |')
        usual, adopting = story.step()
        print(f'{wear}: the current changes by up to {usual:.4f} A a tick, on adopting by {adopting:.4f} A', flush=True)
    draw(args.output, stories)


if __name__ == '__main__':
    main()

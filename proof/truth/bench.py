"""A muscle on its bench: the plant, the room around it, the instruments on it; and what one experiment gives there."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from proof.truth.body import Body, plain
from proof.truth.integrate import run
from proof.truth.plant import AMPERE, FORCE, LENGTH, MEAN, RESISTANCE, SKIN, Array, Plant

# What the room or an instrument does: f(time, signal, number of the recording) -> signal, all arrays of one length.
Alter = Callable[[Array, Array, int], Array]


@dataclass
class Bench:
    """Everything that an effect can change. Effects are applied one after the other, before anything is measured."""

    body: Body
    plant: Plant
    room: list[Alter] = field(default_factory=list)  # on the ambient temperature, degC
    wind: list[Alter] = field(default_factory=list)  # on the factor of hA
    slip: list[Alter] = field(default_factory=list)  # on the length added at each tick, m
    thermometer: list[Alter] = field(default_factory=list)  # on (T - ambient at the start), K
    link: list[Callable[[Array, Array], Array]] = field(
        default_factory=list
    )  # f(displacement m, force N) -> displacement
    ruler: list[Alter] = field(default_factory=list)  # on the displacement, m
    meter: list[Alter] = field(default_factory=list)  # on the input as it is written down
    pickup: list[Callable[[Array, Array, Array], Array]] = field(
        default_factory=list
    )  # f(time s, current A, voltage V) -> what the thermometer shows beside the temperature, K
    loosening: float = 0.0  # 1/m, share of (T - ambient) that it misses per length beyond that at rest
    seebeck: float = 0.0  # V/K, in what the ohmmeter takes for the muscle's voltage
    delay: dict[str, float] = field(default_factory=dict)  # s, per channel
    stretch: dict[str, float] = field(default_factory=dict)  # relative error of a channel's clock

    @classmethod
    def of(cls, body: Body) -> 'Bench':
        """A bench with nothing concealed."""
        return cls(body, plain(body))

    def set(self, **numbers: Any) -> None:
        """Replace numbers of the plant."""
        self.plant = self.plant._replace(**numbers)

    def scale(self, table: str, factor: Array) -> None:
        """Multiply a table of the plant."""
        self.plant = self.plant._replace(**{table: getattr(self.plant, table) * factor})


@dataclass(frozen=True)
class Experiment:
    """What is done to the muscle in one recording. Inputs hold from their tick to the next."""

    name: str
    time: Array  # s, ticks
    drive: Array  # A, W or V
    kind: int  # plant.CURRENT, POWER, VOLTAGE
    load: Array  # N
    ambient: float  # degC
    blocked: bool = False
    warm: float = 0.0  # K above the room at the start: the last run is not quite forgotten


@dataclass(frozen=True)
class Signals:
    """What ideal instruments (no noise) show, one array a channel on the ticks; degC, ohm, m, N, A."""

    temperature: Array
    resistance: Array
    displacement: Array
    force: Array
    current: Array
    drive: Array  # the input as written down
    ambient: Array
    fibre: Array  # mean temperature of what drives the stroke, for the labels
    dose: float


def observe(
    bench: Bench, experiment: Experiment, recording: int = 0, dose: float = 0.0, step: float = 0.005
) -> Signals:
    """Run the experiment. Noise, stamps and losses are added later, when it is written down."""
    time = experiment.time
    ambient, wind, slip = around(bench, time, experiment.ambient, recording)
    out, zero, dose = run(
        bench.plant, time, experiment.drive, experiment.kind, experiment.load, ambient, wind, slip,
        substeps(bench, float(np.median(np.diff(time))), step), experiment.blocked, dose, experiment.warm,
    )  # fmt: skip
    return shown(bench, experiment, recording, out, zero, ambient, dose)


def around(bench: Bench, time: Array, ambient: float, recording: int) -> tuple[Array, Array, Array]:
    """What the room does at each tick: temperature (degC), factor of hA, length that slips (m)."""
    room, wind, slip = np.full_like(time, ambient), np.ones_like(time), np.zeros_like(time)
    for alter in bench.room:
        room = alter(time, room, recording)
    for alter in bench.wind:
        wind = alter(time, wind, recording)
    for alter in bench.slip:
        slip = alter(time, slip, recording)
    return room, wind, slip


def substeps(bench: Bench, period: float, step: float = 0.005) -> int:
    """Into how many steps of about ``step`` s a tick is divided; a weight that swings needs more."""
    return max(1, round(period / (step / 2 if bench.plant.mass > 0 else step)))


def shown(
    bench: Bench, experiment: Experiment, recording: int, out: Array, zero: float, ambient: Array, dose: float
) -> Signals:
    """What the instruments make of the columns that ``run`` returns."""
    time = experiment.time
    T = out[:, SKIN] - experiment.ambient
    for alter in bench.thermometer:
        T = alter(time, T, recording)
    T = T * (1.0 - bench.loosening * (out[:, LENGTH] - bench.plant.H0))
    for electric in bench.pickup:
        T = T + electric(time, out[:, AMPERE], out[:, AMPERE] * out[:, RESISTANCE])
    # it reads nothing where no current flows
    added = bench.seebeck * (out[:, SKIN] - experiment.ambient) / np.where(out[:, 5] > 0.003, out[:, 5], np.inf)
    x = np.zeros_like(time) if experiment.blocked else zero - out[:, LENGTH]
    for yielding in bench.link:
        x = yielding(x, out[:, FORCE])
    for alter in bench.ruler:
        x = alter(time, x, recording)
    drive = experiment.drive
    for alter in bench.meter:
        drive = alter(time, drive, recording)
    channels = {
        'temperature': T + experiment.ambient,
        'resistance': out[:, RESISTANCE] + added,
        'displacement': x,
        'force': out[:, FORCE],
    }
    for name in bench.delay.keys() | bench.stretch.keys():
        late = time * (1.0 - bench.stretch.get(name, 0.0)) - bench.delay.get(name, 0.0)
        channels[name] = np.interp(late, time, channels[name])
    return Signals(**channels, current=out[:, 5], drive=drive, ambient=ambient, fibre=out[:, MEAN], dose=dose)

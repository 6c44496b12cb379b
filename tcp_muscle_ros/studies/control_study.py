"""The controller against the simulated muscle, offline: what docs/control.md tables and the tests hold.

Every figure stands beside what the muscle can do at all: a heating step beside the time that the full current
needs to enter the band, a release beside passive cooling.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.control.offline import PERFECT, Run, Sensors, run
from tcp_muscle_ros.control.tracking import MODES, TrackingController
from tcp_muscle_ros.muscle import Muscle, Parameters, simulate
from tcp_muscle_ros.muscle.parameter import GRAVITY
from tcp_muscle_ros.studies.step_response import BAND, StepResponse, entry_time, step_response

LOAD = 0.060 * GRAVITY  # N: 60 g
PERIOD = 0.01  # s
UNCERTAIN = ('R0', 'a_R', 'C', 'hA', 'k0', 'B')  # each within 20 % of the controller's model
_LONGEST = 90.0  # s; what takes the full current longer counts as out of reach

Step = tuple[float, float]  # current limit (A) and target (m)


@dataclass(frozen=True)
class Figures:
    """One row: a step, and the shortest time (s) in which the muscle can be in the band."""

    physical_time: float
    response: StepResponse
    run: Run

    @property
    def ratio(self) -> float:
        """Settling time over the physical one."""
        return self.response.settling_time / self.physical_time


def controller(
    model: Parameters, limit: float, *, period: float = PERIOD, load: float = LOAD, **settings: Any
) -> TrackingController:
    """A controller for this model at a current limit (A)."""
    return TrackingController(model, period, limit, load, model['T0'], **settings)


def full_current_time(plant: Parameters, limit: float, target: float, load: float = LOAD) -> float:
    """When full current from rest first brings the plant within 2 % of the target (m), s; NaN: never."""
    time = np.arange(0.0, _LONGEST, PERIOD)
    out = simulate(plant, time, limit, load=load)
    return entry_time(time, out.displacement, target, BAND * target)


def heating(
    plant: Parameters, model: Parameters, limit: float, target: float, sensors: Sensors = PERFECT, **settings: Any
) -> Figures:
    """A step from rest to the target (m) under 60 g at a current limit (A)."""
    physical = full_current_time(plant, limit, target)
    duration = 20.0 + (3.0 * physical if physical > 0.0 else 0.0)
    happened = run(
        controller(model, limit, **settings),
        Muscle(plant, load=LOAD),
        PERIOD,
        np.full(int(duration / PERIOD), target),
        sensors=sensors,
    )
    return Figures(physical, step_response(happened.time, happened.displacement, happened.current, target), happened)


def release(plant: Parameters, model: Parameters, begin: float, end: float, limit: float, **settings: Any) -> Figures:
    """From ``begin`` (m), held for 25 s, down to ``end`` (m); beside passive cooling from the same state."""
    held, total = round(25.0 / PERIOD), round(85.0 / PERIOD)
    wanted = np.where(np.arange(total) < held, begin, end)
    happened = run(controller(model, limit, **settings), Muscle(plant, load=LOAD), PERIOD, wanted)
    after = _from(happened, held)
    cooling = simulate(plant, after.time, 0.0, load=LOAD, temperature=float(after.temperature[0]))
    physical = entry_time(after.time, cooling.displacement, end, BAND * abs(end - begin))
    return Figures(physical, step_response(after.time, after.displacement, after.current, end), after)


def load_step(
    plant: Parameters, model: Parameters, target: float, extra: float, limit: float, told: bool, **settings: Any
) -> Figures:
    """The setpoint (m) is held and the load grows by ``extra`` (N); beside full current from the same state."""
    before, total = round(25.0 / PERIOD), round(65.0 / PERIOD)
    loads = np.where(np.arange(total) < before, LOAD, LOAD + extra)
    happened = run(
        controller(model, limit, **settings),
        Muscle(plant, load=LOAD),
        PERIOD,
        np.full(total, target),
        load=loads,
        sensors=Sensors(load_is_told=told),
    )
    # The first sample that shows the new load is the one after it came.
    after = _from(happened, before + 1)
    full = simulate(plant, after.time, limit, load=LOAD + extra, starting_load=LOAD, temperature=after.temperature[0])
    band = BAND * abs(float(after.displacement[0]) - target)
    return Figures(
        entry_time(after.time, full.displacement, target, band),
        step_response(after.time, after.displacement, after.current, target),
        after,
    )


def side_by_side(model: Parameters) -> dict[str, Run]:
    """Each mode on one profile of steps and a sine, at 0.27 A and with 0.02 mm of sensor noise, by its name."""
    time = np.arange(0.0, 85.0, PERIOD)
    wanted = np.select([time < 15.0, time < 30.0, time < 45.0], [0.020, 0.040, 0.030], 0.0)
    sine = 0.025 + 0.005 * np.sin(2.0 * np.pi * (time - 45.0) / 20.0)
    profile = np.where(time >= 45.0, sine, wanted)
    sensors = Sensors(displacement_noise=2e-5, seed=3)
    return {
        mode: run(controller(model, 0.27, mode=mode), Muscle(model, load=LOAD), PERIOD, profile, sensors=sensors)
        for mode in MODES
    }


def of_others(model: Parameters, step: Step, count: int, seed: int) -> list[tuple[str, Figures]]:
    """A step (limit in A, target in m) of so many muscles that are not the model: mode and what happened, muscle after
    muscle."""
    limit, target = step
    return [
        (mode, heating(plant, model, limit, target, mode=mode))
        for plant, _ in draws(model, count, seed)
        for mode in reversed(MODES)
    ]


def draws(model: Parameters, count: int, seed: int) -> Iterator[tuple[Parameters, NDArray[np.float64]]]:
    """Muscles whose uncertain parameters are each within 20 % of the model's, and the factors (6,)."""
    chance = np.random.default_rng(seed)
    for _ in range(count):
        factors = chance.uniform(0.8, 1.2, len(UNCERTAIN))
        yield model.replace({name: model[name] * f for name, f in zip(UNCERTAIN, factors, strict=True)}), factors


def reachable(plant: Parameters, limit: float, target: float, highest: float = 373.15) -> bool:
    """Whether full current brings the plant to the target (m) itself, not above ``highest`` (K), in 90 s."""
    out = simulate(plant, np.arange(0.0, _LONGEST, PERIOD), limit, load=LOAD)
    there = out.displacement >= target
    return bool(there.any() and out.fibre_temperature[np.argmax(there)] < highest)


def _from(happened: Run, k: int) -> Run:
    return Run(*(getattr(happened, name)[k:] for name in Run.__dataclass_fields__))

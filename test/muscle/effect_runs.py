"""Runs of the muscle with an effect, and the same equations solved by another integrator.

E0 is the paper's protocol: 25 s on, 45 s off, three cycles, 0.18 to 0.27 A, 30 to 100 g.
"""

from functools import cache

import numpy as np
import pytest
from muscle.reference import Sample
from scipy.integrate import solve_ivp

from tcp_muscle_ros.muscle import Outputs, Parameters, simulate

NOMINAL = Parameters.named('karami_tadesse_2017')
LOADS = (0.2942, 0.5884, 0.9807)
PAPER = Sample()
STEP = 0.01  # s
PULSE = ((12.0, 0.27, 0.5884), (10.0, 0.0, 0.5884), (5.0, 0.2, 0.5884))
PULSE_AND_LOAD = ((8.0, 0.27, 0.5884), (6.0, 0.27, 0.2942), (8.0, 0.0, 0.5884))


def protocol(rate_hz: float = 20.0, duration: float = 210.0, cycle: float = 70.0) -> tuple[np.ndarray, np.ndarray]:
    """Time and whether the current is on."""
    time = np.arange(round(duration * rate_hz) + 1) / rate_hz
    return time, np.mod(np.arange(time.size), round(cycle * rate_hz)) < round(25 / 70 * cycle * rate_hz)


def e0(parameters: Parameters, load: float, current: float) -> Outputs:
    time, on = protocol()
    return simulate(parameters, time, current * on, load=load)


@cache
def baseline(load: float, current: float) -> Outputs:
    return e0(NOMINAL, load, current)


def expand(kelvin: np.ndarray | float) -> np.ndarray | float:
    return PAPER.thermal(kelvin - 273.15)


def stiffness(kelvin: np.ndarray | float) -> np.ndarray | float:
    return PAPER.stiffness(kelvin - 273.15)


def ohms(kelvin: float) -> float:
    return 14.0 * (1.0 + 0.003 * (kelvin - 296.15))


def solve(rates, start, segments, method: str = 'DOP853') -> np.ndarray:
    """States every STEP over segments (seconds, current A, load N) of constant input; shape (states, samples)."""
    states, columns, begin = np.array(start, dtype=float), [], 0.0
    for seconds, current, load in segments:
        at = np.arange(round(seconds / STEP) + 1) * STEP
        done = solve_ivp(
            lambda t, y, i=current, f=load, t0=begin: rates(t0 + t, y, i, f),
            (0.0, at[-1]),
            states,
            method=method,
            t_eval=at,
            rtol=1e-12,
            atol=1e-13,
        )
        assert done.success
        columns.append(done.y[:, :-1])
        states, begin = done.y[:, -1], begin + seconds
    return np.hstack([*columns, states[:, None]])


def model(name: str, segments, values=None, **options) -> Outputs:
    time, currents, loads = [], [], []
    for seconds, current, load in segments:
        n = round(seconds / STEP)
        currents += [current] * n
        loads += [load] * n
    time = np.arange(len(currents) + 1) * STEP
    p = NOMINAL.replace({f'{name}.{key}': value for key, value in (values or {}).items()}).with_effects(name)
    return simulate(p, time, [*currents, currents[-1]], load=[*loads, loads[-1]], **options)


def assert_same(run: Outputs, kelvin, displacement, shown=None) -> None:
    assert run.fibre_temperature == pytest.approx(kelvin, abs=1e-6, rel=0.0)
    assert run.temperature == pytest.approx(kelvin if shown is None else shown, abs=1e-6, rel=0.0)
    assert run.displacement == pytest.approx(displacement, abs=1e-9, rel=0.0)


def contraction(kelvin, load=0.5884):
    return load / 23.0 - expand(kelvin) - load / stiffness(kelvin)

"""How fast the model is: one hour at 100 Hz, every output, beside what else one could write.

    python benchmarks/model_speed.py [--samples 360000]

All rows are taken in one run: processor time, the best of several. The ratio is to a hand-written C loop that gives the
same columns (to ours without a C compiler). Two inputs: the paper's protocol, 25 s on and 45 s off, which is kind to
adaptive solvers, and a current that is new with every sample, as a controller gives it: there they start anew at every
sample, and are given a hundredth of the samples.
"""

import argparse
import ctypes
import math
import platform
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from time import thread_time

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import odeint, solve_ivp

from tcp_muscle_ros.muscle import Parameters, simulate

Array = NDArray[np.float64]
P = Parameters.named('karami_tadesse_2017')
CONSTANTS = ('R0', 'a_R', 'T0', 'hA', 'C', 'k0', 'H0', 'B', 'c1', 'c2', 'a1', 'a2', 'a3')
PERIOD, LOAD, AMBIENT = 0.01, 0.588399, P['T0']
COLUMNS = 11  # T, R, x, F, H, i, V, P, in domain, heated, lost

C_SOURCE = r"""
#include <math.h>
void run(const double *p, long n, double dt, const double *i, double F, double Tinf, double T, double *y) {
    const double R0 = p[0], aR = p[1], T0 = p[2], hA = p[3], C = p[4], k0 = p[5], H0 = p[6], B = p[7];
    const double c1 = p[8], c2 = p[9], a1 = p[10], a2 = p[11], a3 = p[12];
    const double E0 = a1 * pow(T0 - 273.15, a2) + a3, zero = H0 + F / k0;
    double heated = 0, lost = 0;
    for (long k = 0; k < n; k++, y += 11) {
        double t = T - 273.15, in = t < 0 ? 0 : t > 120 ? 120 : t;
        double R = R0 * (1 + aR * (T - T0));
        double K = k0 * (a1 * pow(in, a2) + a3) / E0;
        double H = H0 + B * (c1 * T + c2) * (T - T0) + F / K;
        y[0] = T; y[1] = R; y[2] = zero - H; y[3] = F; y[4] = H; y[5] = i[k]; y[6] = i[k] * R; y[7] = i[k] * i[k] * R;
        y[8] = t >= 0 && t <= 120; y[9] = heated; y[10] = lost;
        double cold = i[k] * i[k] * R0, slope = cold * aR, P = cold * (1 + aR * (Tinf - T0));
        double z = (slope - hA) * dt / C, theta = T - Tinf, e = expm1(z);
        double f1 = fabs(z) < 1e-8 ? 1 + z / 2 : e / z;
        double f2 = fabs(z) < 1e-2 ? 0.5 + z * (1.0 / 6 + z * (1.0 / 24 + z * (1.0 / 120 + z / 720))) : (f1 - 1) / z;
        double area = dt * (theta * f1 + P * dt / C * f2);
        T = Tinf + theta * (1 + e) + P * dt / C * f1;
        heated += P * dt + slope * area;
        lost += hA * area;
    }
}
"""


def compiled() -> tuple[Callable[..., Array] | None, str]:
    """The C loop as a function of the current, or why there is none."""
    compiler = shutil.which('gcc') or shutil.which('cc') or shutil.which('clang')
    if compiler is None:
        return None, 'no C compiler found (gcc, cc, clang)'
    folder = Path(tempfile.mkdtemp(prefix='model_speed_'))
    try:
        (folder / 'loop.c').write_text(C_SOURCE)
        command = [compiler, '-O3', '-march=native', '-shared', '-fPIC', '-o', 'loop.so', 'loop.c', '-lm']
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            return None, f'{Path(compiler).name} failed: {done.stderr.strip().splitlines()[-1]}'
        loop = ctypes.CDLL(str(folder / 'loop.so')).run
    finally:
        shutil.rmtree(folder)
    pointer = np.ctypeslib.ndpointer(dtype=np.float64, flags='C_CONTIGUOUS')
    loop.argtypes = [pointer, ctypes.c_long, ctypes.c_double, pointer, *[ctypes.c_double] * 3, pointer]
    loop.restype = None
    constants = np.array([P[name] for name in CONSTANTS])

    def run(current: Array) -> Array:
        y = np.empty((current.size, COLUMNS))
        loop(constants, current.size, PERIOD, current, LOAD, AMBIENT, AMBIENT, y)
        return y[:, 0]

    return run, Path(compiler).name


def ours(current: Array) -> Array:
    """The package."""
    return simulate(P, np.arange(current.size) * PERIOD, current, load=LOAD, ambient=AMBIENT).fibre_temperature


def outputs(temperature: Array, current: Array) -> tuple[Array, ...]:
    """What follows from the temperature, by numpy: resistance, displacement, length, voltage, power, in domain."""
    celsius = np.clip(temperature - 273.15, 0.0, 120.0)
    resistance = P['R0'] * (1 + P['a_R'] * (temperature - P['T0']))
    modulus = P['a1'] * celsius ** P['a2'] + P['a3']
    rate = P['k0'] * modulus / (P['a1'] * (P['T0'] - 273.15) ** P['a2'] + P['a3'])
    thermal = P['B'] * (P['c1'] * temperature + P['c2']) * (temperature - P['T0'])
    length = P['H0'] + thermal + LOAD / rate
    rest = P['H0'] + LOAD / P['k0']
    return resistance, rest - length, length, current * resistance, current**2 * resistance, celsius == temperature


def python_loop(current: Array) -> Array:
    """The exact step in plain Python, the rest by numpy."""
    r0, a_r, t0, ha, c = (P[name] for name in ('R0', 'a_R', 'T0', 'hA', 'C'))
    temperature = np.empty(current.size)
    t = AMBIENT
    for k, i in enumerate(current.tolist()):
        temperature[k] = t
        cold = i * i * r0
        lam = cold * a_r - ha
        weight = math.expm1(lam * PERIOD / c) / lam
        theta = t - AMBIENT
        t = t + (theta * lam + cold * (1 + a_r * (AMBIENT - t0))) * weight
    outputs(temperature, current)
    return temperature


def rate(t: float, y: Array, i: float) -> Array:
    """dT/dt, K/s."""
    return (i * i * P['R0'] * (1 + P['a_R'] * (y - P['T0'])) - P['hA'] * (y - AMBIENT)) / P['C']


def by_pieces(solve: Callable[[float, Array, float], Array]) -> Callable[[Array], Array]:
    """An adaptive solver on every stretch of constant current, the outputs by numpy."""

    def run(current: Array) -> Array:
        edges = [0, *(np.flatnonzero(np.diff(current)) + 1).tolist(), current.size]
        temperature = np.empty(current.size + 1)
        temperature[0] = AMBIENT
        for a, b in pairwise(edges):
            ticks = np.arange(b - a + 1) * PERIOD
            temperature[a : b + 1] = solve(temperature[a], ticks, float(current[a]))
        outputs(temperature[:-1], current)
        return temperature[:-1]

    return run


def lsoda(start: float, ticks: Array, i: float) -> Array:
    """Temperatures at the ticks of one stretch."""
    done = solve_ivp(rate, (0.0, ticks[-1]), [start], 'LSODA', t_eval=ticks, args=(i,), rtol=1e-8, atol=1e-8)
    return done.y[0]


def classic_odeint(start: float, ticks: Array, i: float) -> Array:
    """Temperatures at the ticks of one stretch."""
    return odeint(rate, [start], ticks, args=(i,), tfirst=True, rtol=1e-8, atol=1e-8)[:, 0]


def best(run: Callable[[Array], Array], current: Array, repeats: int) -> tuple[float, Array]:
    """Shortest processor time (s) of several, and the temperatures."""
    temperature = run(current)  # compiles, and warms the caches
    shortest = math.inf
    for _ in range(repeats):
        start = thread_time()
        temperature = run(current)
        shortest = min(shortest, thread_time() - start)
    return shortest, temperature


def main() -> None:
    """Time every row for both inputs, print them."""
    parser = argparse.ArgumentParser(description='How fast the model is, beside what else one could write.')
    parser.add_argument('--samples', type=int, default=360_000)
    parser.add_argument('--repeats', type=int, default=7)
    arguments = parser.parse_args()
    n = arguments.samples
    protocol = np.where(np.mod(np.arange(n) * PERIOD, 70.0) < 25.0, 0.27, 0.0)
    controller = 0.2 + 0.05 * np.sin(np.arange(n) * 0.01) + np.random.default_rng(1).uniform(-0.01, 0.01, n)
    c_loop, compiler = compiled()
    few = max(1, n // 100)
    print(f'{platform.machine()}, Python {platform.python_version()}, numpy {np.__version__}, C: {compiler}')
    for title, current, adaptive in (
        (f"the paper's protocol, {n} samples", protocol, n),
        (f'a new current every sample, {n} samples', controller, few),
    ):
        rows = [
            ('C loop, -O3', c_loop, n, arguments.repeats),
            ('tcp_muscle_ros simulate()', ours, n, arguments.repeats),
            ('Python loop, exact step', python_loop, n, 1),
            ('scipy odeint, 1e-8', by_pieces(classic_odeint), adaptive, 1),
            ('scipy solve_ivp LSODA, 1e-8', by_pieces(lsoda), adaptive, 1),
        ]
        reference = ours(current)
        print(f'\n{title}\n{"":30s} {"ns/sample":>10} {"hour, s":>9} {"ratio":>9} {"|dT| max, K":>12}')
        base = 0.0
        for name, run, count, repeats in rows:
            if run is None:
                print(f'{name:30s} skipped: {compiler}')
                continue
            seconds, temperature = best(run, current[:count], repeats)
            each = seconds / count
            base = base or each
            error = float(np.max(np.abs(temperature - reference[:count])))
            note = '' if count == n else f'   (on {count} samples)'
            print(f'{name:30s} {1e9 * each:10.1f} {360_000 * each:9.4f} {each / base:9.2f} {error:12.1e}{note}')


if __name__ == '__main__':
    main()

"""How fast the model is: one hour at 100 Hz, every output, beside what else one could write.

    python benchmarks/model.py [--samples 360000]

The paper's model alone, and with five effects. Two inputs each: the paper's protocol as a record holds it, 25 s on and
45 s off with the noise of an ammeter, so that the current is new with every sample (as a controller's is); and the bare
protocol, in 103 stretches of constant current, over which an adaptive solver can take long steps and interpolate.
"""

import argparse
import ctypes
import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
from c_compiler import compile_c
from numpy.typing import NDArray
from scipy.integrate import odeint, solve_ivp
from side_by_side import Contender, in_turns, show

from tcp_muscle_ros.muscle import Outputs, Parameters, simulate

Array = NDArray[np.float64]
Rates = Callable[..., Array]
EFFECTS = ('natural_convection', 'radiation', 'creep', 'hysteresis', 'thermocouple_lag')
PAPER = Parameters.named('karami_tadesse_2017')
FIVE = PAPER.with_effects(*EFFECTS)
CONSTANTS = ('R0', 'a_R', 'T0', 'hA', 'C', 'k0', 'H0', 'B', 'c1', 'c2', 'a1', 'a2', 'a3')
MORE = (
    'D0', 'natural_convection.n', 'radiation.eps', 'creep.J', 'creep.tau50', 'creep.aT', 'hysteresis.w', 'hysteresis.r',
    'thermocouple_lag.tau',
)  # fmt: skip
PERIOD, LOAD, AMBIENT = 0.01, 0.588399, PAPER['T0']
COLUMNS = 13  # shown T, T, R, x, F, H, i, V, P, in domain, slack, heated, lost

C_SOURCE = r"""
#include <math.h>
#define PARAMETERS const double R0 = p[0], aR = p[1], T0 = p[2], hA = p[3], C = p[4], k0 = p[5], H0 = p[6], B = p[7], \
    c1 = p[8], c2 = p[9], a1 = p[10], a2 = p[11], a3 = p[12], E0 = a1 * pow(T0 - 273.15, a2) + a3, zero = H0 + F / k0
#define SHOW(seen, driving, more) do { \
    double t = T - 273.15, in = t < 0 ? 0 : t > 120 ? 120 : t, R = R0 * (1 + aR * (T - T0)); \
    double H = H0 + B * (c1 * (driving) + c2) * ((driving) - T0) + F / (k0 * (a1 * pow(in, a2) + a3) / E0) + (more); \
    y[0] = seen; y[1] = T; y[2] = R; y[3] = zero - H; y[4] = F; y[5] = H; y[6] = i[k]; y[7] = i[k] * R; \
    y[8] = i[k] * i[k] * R; y[9] = t >= 0 && t <= 120; y[10] = 0; y[11] = heated; y[12] = lost; } while (0)

void paper(const double *p, long n, double dt, const double *i, double F, double Tinf, double T, double *y) {
    PARAMETERS;
    double heated = 0, lost = 0;
    for (long k = 0; k < n; k++, y += 13) {
        SHOW(T, T, 0);
        double cold = i[k] * i[k] * R0, slope = cold * aR, W = cold * (1 + aR * (Tinf - T0));
        double z = (slope - hA) * dt / C, theta = T - Tinf, e = expm1(z);
        double f1 = fabs(z) < 1e-8 ? 1 + z / 2 : e / z;
        double f2 = fabs(z) < 1e-2 ? 0.5 + z * (1.0 / 6 + z * (1.0 / 24 + z * (1.0 / 120 + z / 720))) : (f1 - 1) / z;
        double area = dt * (theta * f1 + W * dt / C * f2);
        T = Tinf + theta * (1 + e) + W * dt / C * f1;
        heated += W * dt + slope * area;
        lost += hA * area;
    }
}

void five(const double *p, long n, double dt, const double *i, double F, double Tinf, double T, double *y) {
    PARAMETERS;
    const double area = M_PI * p[13] * H0, nn = p[14], sigma = p[15] * 5.670374419e-8 * area, J = p[16], tau50 = p[17];
    const double aT = p[18], w = p[19], r = p[20], tau = p[21], Tinf4 = Tinf * Tinf * Tinf * Tinf;
    double heated = 0, lost = 0, play[3] = {T, T, T};
    double x[5] = {T, 0, 0, 0, T};   // temperature, heated, lost, creep, bead
    double in0 = T - 273.15; in0 = in0 < 0 ? 0 : in0 > 120 ? 120 : in0;
    x[3] = J * F / (k0 * (a1 * pow(in0, a2) + a3) / E0);
    const double zero5 = zero + J * F / k0;
    for (long k = 0; k < n; k++, y += 13) {
        T = x[0];
        double behind = 0;
        for (int j = 0; j < 3; j++) behind += fmin(fmax(play[j], T - r * (j + 1) / 3), T + r * (j + 1) / 3) - T;
        SHOW(x[4], T + w * behind / 3, x[3]);
        y[3] += zero5 - zero;
        double d[4][5], s[5];
        for (int stage = 0; stage < 4; stage++) {
            double reach = stage == 0 ? 0 : stage == 3 ? dt : dt / 2;
            for (int j = 0; j < 5; j++) s[j] = stage ? x[j] + reach * d[stage - 1][j] : x[j];
            double t = s[0] - 273.15, in = t < 0 ? 0 : t > 120 ? 120 : t;
            double K = k0 * (a1 * pow(in, a2) + a3) / E0, W = i[k] * i[k] * R0 * (1 + aR * (s[0] - T0));
            double out = hA * pow(fabs(s[0] - Tinf) / 40, nn) * (s[0] - Tinf)
                       + sigma * (s[0] * s[0] * s[0] * s[0] - Tinf4);
            double hot = s[0] < 393.15 ? s[0] : 393.15, quick = exp(aT * (hot - 323.15)) / tau50;
            d[stage][0] = (W - out) / C; d[stage][1] = W; d[stage][2] = out;
            d[stage][3] = (J * F / K - s[3]) * (quick < 20 ? quick : 20);
            d[stage][4] = (s[0] - s[4]) / tau;
        }
        for (int j = 0; j < 5; j++) x[j] += dt / 6 * (d[0][j] + 2 * (d[1][j] + d[2][j]) + d[3][j]);
        for (int j = 0; j < 3; j++) play[j] = fmin(fmax(play[j], x[0] - r * (j + 1) / 3), x[0] + r * (j + 1) / 3);
        heated = x[1]; lost = x[2];
    }
}
"""


def c_loop(library: ctypes.CDLL | None, name: str, model: Parameters, current: Array) -> Callable[[], Array] | None:
    """The C loop as a call; shape (n, COLUMNS)."""
    if library is None:
        return None
    loop = getattr(library, name)
    pointer = np.ctypeslib.ndpointer(dtype=np.float64, flags='C_CONTIGUOUS')
    loop.argtypes = [pointer, ctypes.c_long, ctypes.c_double, pointer, *[ctypes.c_double] * 3, pointer]
    loop.restype = None
    constants = np.array([model[each] for each in CONSTANTS + MORE])

    def run() -> Array:
        y = np.empty((current.size, COLUMNS))
        loop(constants, current.size, PERIOD, current, LOAD, AMBIENT, AMBIENT, y)
        return y[:, 1]

    return run


def ours(model: Parameters, current: Array) -> Outputs:
    """The package."""
    return simulate(model, np.arange(current.size) * PERIOD, current, load=LOAD, ambient=AMBIENT)


def copied(current: Array) -> Array:
    """As many arrays as there are columns, read once and written once."""
    y = np.empty((COLUMNS, current.size))
    for column in y:
        np.copyto(column, current)
    return y[0]


def modulus(temperature: Array | float) -> Array | float:
    """E(T), Pa."""
    return PAPER['a1'] * np.clip(temperature - 273.15, 0.0, 120.0) ** PAPER['a2'] + PAPER['a3']


def outputs(temperature: Array, current: Array, driving: Array | None = None, more: Array | float = 0.0) -> object:
    """What follows from the temperature, by numpy: every column that the C loop has."""
    p = PAPER
    seen = temperature if driving is None else driving
    resistance = p['R0'] * (1 + p['a_R'] * (temperature - p['T0']))
    rate = p['k0'] * modulus(temperature) / modulus(p['T0'])
    length = p['H0'] + p['B'] * (p['c1'] * seen + p['c2']) * (seen - p['T0']) + LOAD / rate + more
    in_domain = (temperature >= 273.15) & (temperature <= 393.15)
    return resistance, length[0] - length, length, current * resistance, current**2 * resistance, in_domain


def python_loop(current: Array) -> Array:
    """The exact step in plain Python, the outputs by numpy."""
    r0, a_r, t0, ha, c = (PAPER[name] for name in ('R0', 'a_R', 'T0', 'hA', 'C'))
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


_R0, _A_R, _T0, _HA, _C = (PAPER[name] for name in ('R0', 'a_R', 'T0', 'hA', 'C'))
_K0, _A1, _A2, _A3 = (PAPER[name] for name in ('k0', 'a1', 'a2', 'a3'))
_E0 = float(modulus(_T0))
_N, _EPS, _J, _TAU50, _A_T = (FIVE[name] for name in MORE[1:6])
_W, _R, _TAU = (FIVE[name] for name in MORE[6:])
_SIGMA = _EPS * 5.670374419e-8 * math.pi * PAPER['D0'] * PAPER['H0']


def paper_rates(t: float, y: Array, i: float) -> list[float]:
    """dT/dt, K/s, and the rates of heat given and lost, W."""
    heating = i * i * _R0 * (1 + _A_R * (y[0] - _T0))
    lost = _HA * (y[0] - AMBIENT)
    return [(heating - lost) / _C, heating, lost]


def five_rates(t: float, y: Array, i: float) -> list[float]:
    """The same with natural convection and radiation, then creep (m/s) and bead (K/s)."""
    temperature = float(y[0])
    heating = i * i * _R0 * (1 + _A_R * (temperature - _T0))
    excess = temperature - AMBIENT
    lost = _HA * (abs(excess) / 40.0) ** _N * excess + _SIGMA * (temperature**4 - AMBIENT**4)
    inside = min(max(temperature - 273.15, 0.0), 120.0)
    stiffness = _K0 * (_A1 * inside**_A2 + _A3) / _E0
    quick = min(math.exp(_A_T * (min(temperature, 393.15) - 323.15)) / _TAU50, 20.0)
    return [
        (heating - lost) / _C, heating, lost, (_J * LOAD / stiffness - y[3]) * quick, (temperature - y[4]) / _TAU,
    ]  # fmt: skip


def driving_temperature(temperature: Array) -> Array:
    """The play operators, sample by sample."""
    driving = np.empty(temperature.size)
    halves = [_R * (j + 1) / 3 for j in range(3)]
    plays = [float(temperature[0])] * 3
    for k, t in enumerate(temperature.tolist()):
        plays = [min(max(play, t - half), t + half) for play, half in zip(plays, halves, strict=True)]
        driving[k] = t + _W * (sum(plays) / 3 - t)
    return driving


def by_pieces(solve: Callable[..., Array], rates: Rates, current: Array) -> Callable[[], Array]:
    """An adaptive solver on every stretch of constant current, the outputs by numpy."""
    start = [AMBIENT, 0.0, 0.0]
    if rates is five_rates:
        start += [_J * LOAD / _K0, AMBIENT]

    def run() -> Array:
        edges = [0, *(np.flatnonzero(np.diff(current)) + 1).tolist(), current.size]
        states = np.empty((len(start), current.size + 1))
        states[:, 0] = start
        for a, b in pairwise(edges):
            states[:, a : b + 1] = solve(rates, states[:, a], np.arange(b - a + 1) * PERIOD, float(current[a]))
        temperature = states[0, :-1]
        if rates is five_rates:
            outputs(temperature, current, driving_temperature(temperature), states[3, :-1])
        else:
            outputs(temperature, current)
        return temperature

    return run


def lsoda(rates: Rates, start: Array, ticks: Array, i: float) -> Array:
    """States at the ticks of one stretch."""
    return solve_ivp(rates, (0.0, ticks[-1]), start, 'LSODA', t_eval=ticks, args=(i,), rtol=1e-8, atol=1e-8).y


def classic_odeint(rates: Rates, start: Array, ticks: Array, i: float) -> Array:
    """States at the ticks of one stretch."""
    return odeint(rates, start, ticks, args=(i,), tfirst=True, rtol=1e-8, atol=1e-8).T


def main() -> None:
    """Time every row for both models and both inputs."""
    parser = argparse.ArgumentParser(description='How fast the model is, beside what else one could write.')
    parser.add_argument('--samples', type=int, default=360_000)
    n = parser.parse_args().samples
    bare = np.where(np.mod(np.arange(n) * PERIOD, 70.0) < 25.0, 0.27, 0.0)
    recorded = np.abs(bare + np.random.default_rng(1).normal(0.0, 1e-4, n))
    library, compiler = compile_c(C_SOURCE)
    for model, name, rates in ((PAPER, 'paper', paper_rates), (FIVE, 'five', five_rates)):
        for current, kind, share in ((recorded, 'as recorded, a new current every sample', 0.005), (bare, 'bare', 1.0)):
            few = current[: max(1, round(n * share))]
            rows = [
                Contender('least: 13 arrays read and written', lambda c=current: copied(c)),
                Contender(
                    f'C loop by hand, {compiler} -O3', c_loop(library, name, model, current), reason=compiler
                ),
                Contender('ours: `simulate()`', lambda c=current, m=model: ours(m, c).fibre_temperature),
                Contender('scipy `odeint`, 1e-8', by_pieces(classic_odeint, rates, few), share, 1),
                Contender('scipy `solve_ivp` LSODA, 1e-8', by_pieces(lsoda, rates, few), share, 1),
            ]  # fmt: skip
            if model is PAPER:
                rows.insert(3, Contender('Python loop, exact step', lambda c=current: python_loop(c), repeats=1))
            measured = in_turns(rows)
            base = next(row for row in measured if row.name.startswith('ours'))
            show(
                f"{'The paper’s model' if model is PAPER else 'With ' + ', '.join(EFFECTS)}; protocol {kind}",
                ('', 'ns a sample', 'time over ours', 'largest dT, K'),
                [
                    (
                        row.name, f'{1e9 * row.seconds / n:.0f}', f'{row.seconds / base.seconds:.2f}',
                        '' if 'least' in row.name
                        else f'{np.max(np.abs(row.result - base.result[: row.result.size])):.0e}',
                    )
                    for row in measured
                ],
            )  # fmt: skip


if __name__ == '__main__':
    main()

"""How much of a concealed effect is left once the resolved model has been refitted: can the case be solved at all?

The refit is of the resolved model written a second time, as one lumped temperature on the ticks; its seven parameters,
the ambient temperature and the zero of displacement of each recording may move. What they cannot absorb is compared
with the noise: as rms, in the 10 s where it is largest, and whitened as a matched filter would see it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit

from proof.cases import Case, signals_of
from proof.truth import Body, Experiment, Signals, conceal
from proof.truth.bench import Bench
from proof.truth.plant import KELVIN, Array

CHANNELS = ('temperature', 'resistance', 'displacement', 'force')
SHARED = 7  # ln R0, a_R, ln C, ln hA, ln k0, ln B, slope of alpha
WINDOW_S = 10.0
DETECTABLE_PEAK = 1.0  # in noise units, over WINDOW_S
DETECTABLE_ENERGY = 10.0  # whitened


@njit(cache=True)
def lumped(
    p: Array, ambient: float, warm: float, x0: float, time: Array, drive: Array, kind: int, load: Array, blocked: bool
) -> Array:
    """The resolved model of physics.md 1.3 on the ticks; a column for each of CHANNELS. p as SHARED, then T0."""
    R0, a_R, C, hA, k0, B = np.exp(p[0]), p[1], np.exp(p[2]), np.exp(p[3]), np.exp(p[4]), np.exp(p[5])
    T0 = p[7]
    cold = 536.0 - 0.4655 * T0**1.381
    n = len(time)
    out = np.empty((n, 4))
    T = ambient + warm
    F = load[0]
    for k in range(n):
        ratio = (536.0 - 0.4655 * max(T, 0.0) ** 1.381) / cold
        # alpha turns about its value at 60 degC
        alpha = (-3.5e-6 * (60.0 + KELVIN) + 4.2e-4) + (-3.5e-6 + p[6]) * (T - 60.0)
        free = B * alpha * (T - T0)
        out[k, 0] = T
        out[k, 1] = R0 * (1.0 + a_R * (T - T0))
        out[k, 2] = x0 + load[0] / k0 - free - F / (k0 * ratio)
        out[k, 3] = max(0.0, k0 * ratio * (load[0] / k0 - free)) + x0 if blocked else F
        if k == n - 1:
            break
        F = load[k]
        h = time[k + 1] - time[k]
        first = 0.0
        warm = T
        for half in range(2):
            R = R0 * (1.0 + a_R * (warm - T0))
            heat = drive[k] ** 2 * R if kind == 0 else (drive[k] if kind == 1 else drive[k] ** 2 / R)
            rate = (heat - hA * (warm - ambient)) / C
            if half == 0:
                first = rate
                warm = T + h * rate
        T += 0.5 * h * (first + rate)
    return out


def start(body: Body, experiments: Sequence[Experiment]) -> Array:
    """The parameters of the truth's body."""
    shared = [np.log(body.R0), body.a_R, np.log(body.C), np.log(body.hA), np.log(body.k0), np.log(body.B), 0.0]
    return np.array([*shared, *(value for e in experiments for value in (e.ambient, 0.0))])


SCALE = np.array([0.02, 1e-4, 0.02, 0.02, 0.02, 0.02, 1e-7])


class Refit:
    """The resolved model fitted to noise-free signals of one case."""

    def __init__(self, case: Case) -> None:
        self.case = case
        self.columns = []
        for experiment in case.experiments:
            names = [c for c in case.channels if not (experiment.blocked and c == 'displacement')]
            names += ['force'] if experiment.blocked else []
            self.columns.append([CHANNELS.index(name) for name in names])
        self.origin = start(case.lab.body, case.experiments)
        self.scale = np.concatenate([SCALE, np.tile([0.1, 1e-3], len(case.experiments))])
        self.sigma = np.array([case.noise[name].sigma for name in CHANNELS])

    def model(self, p: Array) -> list[Array]:
        """The columns of CHANNELS in each recording."""
        shared = np.append(p[:SHARED], self.case.lab.body.T0)
        return [self._one(shared, p, k) for k in range(len(self.case.experiments))]

    def _one(self, shared: Array, p: Array, k: int) -> Array:
        e = self.case.experiments[k]
        x0 = p[SHARED + 2 * k + 1] * (40.0 if e.blocked else 1.0)
        return np.asarray(lumped(shared, p[SHARED + 2 * k], e.warm, x0, e.time, e.drive, e.kind, e.load, e.blocked))

    def left(self, wanted: list[Array], rounds: int = 5) -> list[Array]:
        """What a refit leaves of the wanted signals, in noise units; zero where nothing was recorded."""
        p = self.origin.copy()
        heated = [experiment.drive > 0.003 for experiment in self.case.experiments]

        def rest(q: Array) -> list[Array]:
            found = []
            for k, (model, want) in enumerate(zip(self.model(q), wanted, strict=True)):
                r = np.zeros_like(model)
                r[:, self.columns[k]] = ((want - model) / self.sigma)[:, self.columns[k]]
                r[~heated[k], 1] = 0.0
                found.append(r)
            return found

        r = rest(p)
        cost = _square(r)
        for _ in range(rounds):
            flat = _flat(r)
            slopes = np.empty((len(flat), len(p)))
            for j, width in enumerate(self.scale):
                q = p.copy()
                q[j] += width
                slopes[:, j] = _flat(rest(q)) - flat
            step = np.linalg.lstsq(slopes, -flat, rcond=1e-9)[0].clip(-15.0, 15.0) * self.scale
            for shorter in (1.0, 0.3, 0.1):
                trial = rest(p + shorter * step)
                if _square(trial) < cost:
                    break
            else:
                break
            p, r = p + shorter * step, trial
            gain, cost = cost - _square(r), _square(r)
            if gain < 1e-3 * cost:
                break
        return r

    def measure(self, left: list[Array]) -> dict[str, Any]:
        """rms, peak and whitened energy of what is left, and whether it can be seen."""
        rms, peak, energy = {}, {}, 0.0
        for c, name in enumerate(CHANNELS):
            values = [r[:, c] for k, r in enumerate(left) if c in self.columns[k]]
            if not values:
                continue
            rms[name] = float(np.sqrt(np.mean(np.concatenate(values) ** 2)))
            width = int(WINDOW_S * self.case.lab.rate)
            peak[name] = max(float(np.sqrt(_moving(v**2, width).max())) for v in values)
            energy += sum(float(np.sum(whitened(v, self.case.noise[name], name) ** 2)) for v in values)
        seen = max(peak.values())
        return {
            'rms': rms,
            'peak': peak,
            'energy': float(np.sqrt(energy)),
            'detectable': bool(seen >= DETECTABLE_PEAK and np.sqrt(energy) >= DETECTABLE_ENERGY),
        }

    def likeness(self, one: list[Array], other: list[Array]) -> float:
        """Cosine of two whitened remainders."""
        a, b = (
            np.concatenate(
                [
                    whitened(r[:, c], self.case.noise[CHANNELS[c]], CHANNELS[c])
                    for k, r in enumerate(left)
                    for c in self.columns[k]
                ]
            )
            for left in (one, other)
        )
        return float(a @ b / max(np.linalg.norm(a) * np.linalg.norm(b), 1e-30))


def whitened(v: Array, noise: Any, name: str) -> Array:
    """A remainder in noise units with the colour of its channel's noise taken out."""
    spectrum = np.fft.rfft(v) / np.sqrt(noise.density(len(v)) / noise.sigma**2)
    return np.asarray(np.fft.irfft(spectrum, len(v)))


def stack(signals: list[Signals]) -> list[Array]:
    """The columns of CHANNELS in each recording."""
    return [np.column_stack([getattr(s, name) for name in CHANNELS]) for s in signals]


def visibility(case: Case, signals: list[Signals]) -> list[dict[str, Any]]:
    """For each concealed effect of a case: what a refit leaves of it beside the others."""
    if not case.concealed:
        return []
    refit = Refit(case)
    full = stack(signals)
    base = refit.model(refit.origin)
    found = []
    for concealed in case.concealed:
        if len(case.concealed) == 1:
            wanted = full
        else:
            rest = stack(signals_of(case, case.without(concealed.effect)))
            wanted = [b + f - r for b, f, r in zip(base, full, rest, strict=True)]
        found.append(refit.measure(refit.left(wanted)))
    if case.partner:
        found[0]['likeness'] = _likeness(case, refit, refit.left(full))
    return found


def _likeness(case: Case, refit: Refit, left: list[Array]) -> float:
    """The best cosine with what the partner leaves, over a few draws of it."""
    best = 0.0
    # a case of the third or fourth form is compared with the partner's third or fourth as well
    for k, form in enumerate((0, 1, 0, 1, *((case.form, case.form) if case.form > 1 else ()))):
        rng = case.rng(500 + k)
        bench = Bench.of(case.lab.body)
        conceal(case.partner, float(rng.uniform(0.3, 0.8)), form, case.lab.body, rng).change(bench)
        best = max(best, abs(refit.likeness(left, refit.left(stack(signals_of(case, bench))))))
    return best


def _flat(r: list[Array]) -> Array:
    return np.concatenate([part[::5].ravel() for part in r])


def _square(r: list[Array]) -> float:
    return float(sum(np.sum(part[::5] ** 2) for part in r))


def _moving(v: Array, width: int) -> Array:
    width = min(width, len(v))
    total = np.cumsum(np.concatenate([[0.0], v]))
    return (total[width:] - total[:-width]) / width

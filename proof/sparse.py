"""Sparse regression on the residual (pysindy): a library of terms a stage, thresholded least squares, terms as names.

Each stage is regressed by itself: resistance and displacement at the measured temperature where one was recorded, the
temperature by the rate of what the calibrated model leaves. The threshold is the one with the least error on recordings
left out; leaving everything out is one of the choices. The tables of terms say which effect a term stands for; they
were written before any result was seen and are not tuned.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from warnings import catch_warnings, simplefilter

import numpy as np
from pysindy import STLSQ, SmoothedFiniteDifference
from scipy.signal import lfilter, savgol_filter

from proof.tool import Case, Replayed, replayed
from tcp_muscle_ros.diagnosis.model.tcp_muscle import STROKE
from tcp_muscle_ros.muscle import Parameters, length, resistance

STEP = 0.5  # s, of the grid
THRESHOLDS = (0.03, 0.06, 0.1, 0.2, 0.4, 0.8, np.inf)  # of the target's standard deviation
RIDGE = 1e-3


@dataclass(frozen=True)
class State:
    """What terms are made of, on an even grid of one recording; SI, temperatures in K."""

    t: np.ndarray
    T: np.ndarray
    theta: np.ndarray  # above the room
    rate: np.ndarray  # dT/dt
    F: np.ndarray
    H: np.ndarray  # length
    x: np.ndarray  # contraction
    P: np.ndarray
    cycle: np.ndarray  # heatings begun so far


def state(run: Replayed, muscle: Parameters, T: np.ndarray | None = None) -> State:
    """From a free run; with a temperature in place of the model's where one is given."""
    out, imposed = run.outputs, run.experiment.imposed
    t = np.arange(imposed.time[0], imposed.time[-1], STEP)

    def on(signal: np.ndarray) -> np.ndarray:
        return np.interp(t, imposed.time, signal)

    T = on(out.fibre_temperature) if T is None else T
    F = on(imposed.load if run.experiment.holding.end == 'load' else out.force)
    H = length(muscle, T, F)
    drive = on(imposed.drive) > 0.3 * imposed.drive.max()
    cycle = np.cumsum(np.diff(drive.astype(int), prepend=0) > 0)
    return State(t - t[0], T, T - on(imposed.ambient), np.gradient(T, STEP), F, H, H[0] - H, on(out.power), cycle)


def lagged(signal: np.ndarray, tau: float) -> np.ndarray:
    """A first-order lag that starts settled."""
    keep = np.exp(-STEP / tau)
    return np.asarray(lfilter([1.0 - keep], [1.0, -keep], signal, zi=[keep * signal[0]])[0])


def play(signal: np.ndarray, width: float) -> np.ndarray:
    """A play operator of this full width."""
    found, at = np.empty_like(signal), signal[0]
    for k, value in enumerate(signal):
        at = min(max(at, value - width / 2.0), value + width / 2.0)
        found[k] = at
    return found


# term: (made from the state, the effect of a positive coefficient, of a negative one); '' = no effect, but parameters
Terms = Mapping[str, tuple[Callable[[State], np.ndarray], str, str]]
THERMAL: Terms = {
    '1': (lambda s: np.ones_like(s.t), 'temperature_offset', 'temperature_offset'),
    'P': (lambda s: s.P, '', ''),
    'theta': (lambda s: s.theta, '', ''),
    'theta |theta|^0.25': (
        lambda s: s.theta * np.abs(s.theta) ** 0.25, 'natural_convection', 'natural_convection'),
    'T^4 - Ta^4': (lambda s: s.T**4 - (s.T - s.theta) ** 4, 'radiation', 'radiation'),
    'theta (H - H0)': (lambda s: s.theta * (s.H - s.H[0]), 'exposed_area', 'exposed_area'),
    'theta |v|': (lambda s: s.theta * np.abs(np.gradient(s.H, STEP)), 'motion_convection', 'motion_convection'),
    'theta t': (lambda s: s.theta * s.t, 'airflow', 'airflow'),
    't': (lambda s: s.t, 'ambient_drift', 'ambient_drift'),
    'theta exp(-t/60 s)': (lambda s: s.theta * np.exp(-s.t / 60.0), 'moisture', 'moisture'),
    'theta dT/dt': (lambda s: s.theta * s.rate, 'heat_capacity', 'heat_capacity'),
    'dT/dt near 55 degC': (
        lambda s: s.rate * np.exp(-(((s.T - 328.0) / 6.0) ** 2)), 'latent_heat', 'latent_heat'),
    'd2T/dt2': (lambda s: np.gradient(s.rate, STEP), 'two_node', 'thermocouple_lag'),
    'theta - theta 30 s ago': (lambda s: s.theta - lagged(s.theta, 30.0), 'end_conduction', 'end_conduction'),
    'P - P 0.5 s ago': (lambda s: s.P - lagged(s.P, 0.5), 'supply_lag', 'supply_lag'),
    'dF/dt': (lambda s: np.gradient(s.F, STEP), 'elastocaloric', 'elastocaloric'),
}  # fmt: skip
ELECTRICAL: Terms = {
    '1': (lambda s: np.ones_like(s.t), '', ''),
    'T': (lambda s: s.T - s.T[0], '', ''),
    'H/H0': (lambda s: s.H / s.H[0] - 1.0, 'resistance_strain', 'resistance_strain'),
    'T^2': (lambda s: (s.T - s.T[0]) ** 2, 'tcr_curvature', 'tcr_curvature'),
    'coils touch': (lambda s: 1.0 / (1.0 + np.exp((s.H - 0.1) / 0.004)), 'contact_shorting', 'contact_shorting'),
    't': (lambda s: s.t, 'resistance_drift', 'resistance_drift'),
    'dT/dt': (lambda s: s.rate, 'thermocouple_lag', 'two_node'),
}
MECHANICAL: Terms = {
    '1': (lambda s: np.ones_like(s.t), '', ''),
    'x': (lambda s: s.x, '', ''),
    'F': (lambda s: s.F, '', ''),
    'F 20 s ago - F': (lambda s: lagged(s.F, 20.0) - s.F, 'creep', 'creep'),
    'flow of F': (
        lambda s: np.cumsum(s.F * np.exp(0.05 * (s.T - 333.0))) * STEP, 'viscous_flow', 'viscous_flow'),
    'play of T - T': (lambda s: play(s.T, 10.0) - s.T, 'hysteresis', 'hysteresis'),
    'sign of dx/dt': (lambda s: np.tanh(np.gradient(s.x, STEP) / 2e-4), 'friction', 'friction'),
    '(T - 50 degC)+ cooling': (
        lambda s: np.maximum(s.T - 323.0, 0.0) * (s.rate < 0.0), 'branch_cte', 'branch_cte'),
    'F (1/k(T) - 1/k0)': (
        lambda s: s.F * (1.0 / (536.0 - 0.4655 * np.maximum(s.T - 273.15, 0.0) ** 1.381) - 1.0 / 500.6),
        'shear_softening', 'shear_softening'),
    'F (T - T0)': (lambda s: s.F * (s.T - s.T[0]), 'load_stroke', 'load_stroke'),
    'F^2': (lambda s: s.F**2, 'geometric_stiffening', 'geometric_stiffening'),
    '(T - 50 degC)+': (lambda s: np.maximum(s.T - 323.0, 0.0), 'cte_kink', 'cte_kink'),
    '(100 mm - H)+': (lambda s: np.maximum(0.1 - s.H, 0.0), 'coil_contact', 'coil_contact'),
    'first 3 mm of x': (lambda s: np.clip(s.x, 0.0, 3e-3), 'slack', 'slack'),
    'exp(-t/60 s)': (lambda s: np.exp(-s.t / 60.0), 'first_cycle', 'first_cycle'),
    'x at cycle': (lambda s: s.x * s.cycle, 'fatigue', 'fatigue'),
    'd2x/dt2': (lambda s: np.gradient(np.gradient(s.x, STEP), STEP), 'inertia', 'inertia'),
    'cycle': (lambda s: s.cycle.astype(float), 'torsional_leakage', 'torsional_leakage'),
    't': (lambda s: s.t, 'displacement_drift', 'displacement_drift'),
    'dT/dt': (lambda s: s.rate, 'thermocouple_lag', 'two_node'),
}  # fmt: skip
TERMS = {'temperature': THERMAL, 'resistance': ELECTRICAL, 'displacement': MECHANICAL}


@dataclass(frozen=True)
class Stage:
    """A regression: coefficients of the terms (and of the misfit itself, where it is a rate), and what they explain."""

    terms: Terms
    weights: np.ndarray
    decay: float
    size: np.ndarray  # of each term's part, relative to the target, times the share that is explained

    def names(self) -> list[tuple[float, str]]:
        """(size, effect) of each term that stands for an effect."""
        found = []
        for (_, plus, minus), weight, size in zip(self.terms.values(), self.weights, self.size, strict=True):
            effect = plus if weight > 0.0 else minus
            if weight != 0.0 and effect:
                found.append((float(size), effect))
        return found

    def drive(self, s: State) -> np.ndarray:
        """The weighted sum of the terms."""
        return columns(self.terms, s) @ self.weights


def columns(terms: Terms, s: State) -> np.ndarray:
    """The terms of a state, shape (n, terms)."""
    return np.column_stack([make(s) for make, _, _ in terms.values()])


def regress(case: Case) -> tuple[tuple[str, ...], Callable[[Replayed], dict[str, np.ndarray]]]:
    """The effects that the terms stand for, largest first, and the correction of a free run."""
    fitted = case.calibration.fit
    muscle = fitted.muscle
    examples: dict[str, list[tuple[State, np.ndarray, np.ndarray]]] = {}
    for k in range(len(fitted.problem.experiments)):
        run = replayed(fitted, k)
        for name, example in _examples(run, muscle).items():
            examples.setdefault(name, []).append(example)
    stages = {
        name: stage(TERMS[name], rows, rate=name == 'temperature', floating=name in STROKE)
        for name, rows in examples.items()
    }
    found = sorted((pair for s in stages.values() for pair in s.names()), reverse=True)
    return tuple(dict.fromkeys(effect for _, effect in found)), lambda run: _correction(stages, run, muscle)


def _examples(run: Replayed, muscle: Parameters) -> dict[str, tuple[State, np.ndarray, np.ndarray]]:
    """By channel: the state, the target, and the misfit itself (what a rate decays with)."""
    experiment = run.experiment
    model = state(run, muscle)
    t = model.t + experiment.imposed.time[0]
    found = {}
    seen = model
    if 'temperature' in experiment.observed:
        o = experiment.observed['temperature']
        left = _smooth(np.interp(t, o.time, run.left['temperature']))
        rate = SmoothedFiniteDifference(smoother_kws={'window_length': 9, 'polyorder': 2})
        found['temperature'] = (model, np.asarray(rate(left, t)).ravel(), left)
        seen = state(run, muscle, _smooth(np.interp(t, o.time, o.value)))
    if 'resistance' in experiment.observed and experiment.observed['resistance'].time.size > 20:
        o = experiment.observed['resistance']
        read = np.abs(t - o.time[np.searchsorted(o.time, t).clip(0, o.time.size - 1)]) < 1.0
        left = np.interp(t, o.time, o.value) - resistance(muscle, seen.T)
        found['resistance'] = (_cut(seen, read), left[read], np.zeros(int(read.sum())))
    if 'displacement' in experiment.observed and experiment.holding.end == 'load':
        o = experiment.observed['displacement']
        left = np.interp(t, o.time, o.value) + seen.H
        found['displacement'] = (seen, left - left.mean(), np.zeros(t.size))
    return {name: example for name, example in found.items() if example[1].size > 20}


def _smooth(signal: np.ndarray) -> np.ndarray:
    return np.asarray(savgol_filter(signal, 7, 2)) if signal.size > 7 else signal


def _cut(s: State, kept: np.ndarray) -> State:
    return State(*(getattr(s, name)[kept] for name in State.__dataclass_fields__))


def stage(
    terms: Terms, examples: list[tuple[State, np.ndarray, np.ndarray]], *, rate: bool = False, floating: bool = False
) -> Stage:
    """Regress one stage over all recordings.

    rate: the misfit itself is a term beside the others. floating: each recording has a zero of its own.
    """
    parts = []
    for s, _, left in examples:
        made = columns(terms, s)
        if floating:
            made = made - made.mean(axis=0)
        parts.append(np.column_stack([made, left]) if rate else made)
    targets = [target for _, target, _ in examples]
    X, y = np.vstack(parts), np.concatenate(targets)
    scale, size = np.maximum(np.sqrt(np.mean(X**2, axis=0)), 1e-300), max(float(y.std()), 1e-300)
    means = {t: float(np.mean(_left_out(parts, targets, scale, size, t))) for t in THRESHOLDS}
    chosen = max(means, key=lambda threshold: (-means[threshold], threshold))
    weights = _fit(X / scale, y / size, chosen)
    explained = 1.0 - float(np.mean((y / size - X / scale @ weights) ** 2) / max(np.mean((y / size) ** 2), 1e-300))
    parts_size = np.abs(weights) * max(explained, 0.0)
    natural = weights * size / scale
    decay = float(natural[-1]) if rate else 0.0
    return Stage(terms, natural[: len(terms)], decay, parts_size[: len(terms)])


def _fit(X: np.ndarray, y: np.ndarray, threshold: float) -> np.ndarray:
    if not np.isfinite(threshold):
        return np.zeros(X.shape[1])
    # STLSQ's ridge is on the sum of squares, so it grows with the samples
    with catch_warnings():
        simplefilter('ignore')  # nothing left is an answer
        found = STLSQ(threshold=threshold, alpha=RIDGE * len(y), max_iter=20).fit(X, y[:, None]).coef_
    return np.asarray(found).ravel()


def _left_out(
    parts: list[np.ndarray], targets: list[np.ndarray], scale: np.ndarray, size: float, threshold: float
) -> list[float]:
    """Mean square error on each recording, fitted to the others (halves of a single one)."""
    if len(parts) == 1:
        half = len(targets[0]) // 2
        parts, targets = [parts[0][:half], parts[0][half:]], [targets[0][:half], targets[0][half:]]
    found = []
    for k in range(len(parts)):
        X = np.vstack([part for j, part in enumerate(parts) if j != k]) / scale
        y = np.concatenate([target for j, target in enumerate(targets) if j != k]) / size
        weights = _fit(X, y, threshold)
        found.append(float(np.mean((targets[k] / size - parts[k] / scale @ weights) ** 2)))
    return found


def _correction(stages: Mapping[str, Stage], run: Replayed, muscle: Parameters) -> dict[str, np.ndarray]:
    """What the regressions add to a free run: the temperature first, then what follows from it."""
    model = state(run, muscle)
    t = model.t + run.experiment.imposed.time[0]
    warmer = np.zeros(t.size)
    if 'temperature' in stages:
        s = stages['temperature']
        drive = s.drive(model)
        for k in range(1, t.size):
            rate = drive[k - 1] + s.decay * warmer[k - 1]
            warmer[k] = np.clip(warmer[k - 1] + STEP * rate, -100.0, 100.0)
    moved = state(run, muscle, model.T + warmer)
    added = {'temperature': warmer, 'resistance': resistance(muscle, moved.T) - resistance(muscle, model.T)}
    added['displacement'] = model.H - moved.H
    for name in ('resistance', 'displacement'):
        if name in stages:
            added[name] = added[name] + stages[name].drive(moved)
    observed = run.experiment.observed
    return {name: np.interp(observed[name].time, t, add) for name, add in added.items() if name in observed}

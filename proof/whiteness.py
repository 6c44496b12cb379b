"""The textbook's way: is the residual white? If not, add effects while the Bayesian information criterion falls.

The catalogue is the package's own, and so are simulation and refit; noise is taken as white, as both tests do.
"""

import numpy as np
from scipy.stats import chi2

from proof.tool import Case
from tcp_muscle_ros.diagnosis.diagnose import skipped
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.noise.noise import quick_noise
from tcp_muscle_ros.diagnosis.search.candidates import screen
from tcp_muscle_ros.diagnosis.search.refitting import grow
from tcp_muscle_ros.muscle import LISTED

LEVEL, LAGS = 0.01, 20
TRIED, MOST = 2, 3  # refits at each step; effects at most


def select(case: Case) -> tuple[tuple[str, ...], Fit, bool]:
    """The effects in the order of their gain, the last fit, and whether it leaves nothing but white noise."""
    problem = case.calibration.fit.problem.with_noise(quick_noise(case.experiments))
    fitted = fit(problem, case.calibration.fit.z, rounds=6, tolerance=1e-5)
    untried = skipped(case.experiments)
    tried = [e for e in LISTED if e not in untried]
    named: list[str] = []
    while not white(fitted) and len(named) < MOST:
        ranked, _ = screen(fitted, [e for e in tried if e not in named])
        grown = [(candidate.effect, grow(fitted, candidate, 6)) for candidate in ranked[:TRIED]]
        if not grown:
            break
        effect, best = min(grown, key=lambda pair: criterion(pair[1]))
        if criterion(best) >= criterion(fitted):
            break
        named.append(effect)
        fitted = best
    return tuple(named), fitted, white(fitted)


def residuals(fitted: Fit) -> dict[str, list[np.ndarray]]:
    """Recorded minus fitted by channel, one array a recording."""
    found: dict[str, list[np.ndarray]] = {}
    for k in range(len(fitted.problem.experiments)):
        for name, left in fitted.left[k].items():
            found.setdefault(name, []).append(left)
    return found


def criterion(fitted: Fit) -> float:
    """BIC of independent noise whose size each channel's residual gives."""
    left = {name: np.concatenate(parts) for name, parts in residuals(fitted).items()}
    n = sum(values.size for values in left.values())
    fit_term = sum(values.size * np.log(np.mean(values**2)) for values in left.values())
    return float(fit_term + len(fitted.problem.unknowns) * np.log(n))


def white(fitted: Fit) -> bool:
    """Whether no recording's residual is correlated: Ljung and Box, the level shared among all that are tested."""
    p = [ljung_box(left) for parts in residuals(fitted).values() for left in parts if left.size > 2 * LAGS]
    return min(p, default=1.0) > LEVEL / max(len(p), 1)


def ljung_box(residual: np.ndarray, lags: int = LAGS) -> float:
    """The p-value that a residual is white (Ljung and Box 1978)."""
    centred = residual - residual.mean()
    n = centred.size
    power = float(centred @ centred)
    r = np.array([centred[k:] @ centred[:-k] for k in range(1, lags + 1)]) / power
    return float(chi2.sf(n * (n + 2) * np.sum(r**2 / (n - np.arange(1, lags + 1))), lags))

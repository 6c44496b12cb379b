"""A free correction: boosted trees that predict what the calibrated model leaves, from what the model knows.

It names nothing. What counts is how far its free run comes on recordings that it has not seen.
"""

from collections.abc import Callable

import numpy as np
from sklearn.ensemble import HistGradientBoostingRegressor

from proof.tool import Case, Replayed, replayed

LAGS_S = (2.0, 8.0, 30.0)


def features(replayed: Replayed, at: np.ndarray) -> np.ndarray:
    """Temperature, its rate, load, current, elapsed time, and temperature and current of a while ago, shape (m, 11)."""
    out, time = replayed.outputs, replayed.outputs.time
    rate = np.gradient(out.temperature, time)
    load = replayed.experiment.imposed.load
    columns = [np.interp(at, time, signal) for signal in (out.temperature, rate, load, out.current)]
    past = [np.interp(at - lag, time, signal) for lag in LAGS_S for signal in (out.temperature, out.current)]
    return np.column_stack([*columns, at, *past])


def learn(case: Case) -> Callable[[Replayed], dict[str, np.ndarray]]:
    """Train one model a channel on all recordings of the case; returns the correction of a free run."""
    fitted = case.calibration.fit
    inputs: dict[str, list[np.ndarray]] = {}
    wanted: dict[str, list[np.ndarray]] = {}
    for k in range(len(fitted.problem.experiments)):
        run = replayed(fitted, k)
        for name, left in run.left.items():
            inputs.setdefault(name, []).append(features(run, run.experiment.observed[name].time))
            wanted.setdefault(name, []).append(left)
    models = {
        name: HistGradientBoostingRegressor(
            max_iter=120, learning_rate=0.08, max_leaf_nodes=15, min_samples_leaf=25, l2_regularization=1.0
        ).fit(np.vstack(inputs[name]), np.concatenate(wanted[name]))
        for name in inputs
    }

    def correction(run: Replayed) -> dict[str, np.ndarray]:
        return {
            name: models[name].predict(features(run, run.experiment.observed[name].time))
            for name in run.left
            if name in models
        }

    return correction

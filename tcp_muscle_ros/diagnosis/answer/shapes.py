"""What the recordings do not tell of an effect's shape stays as it was assumed."""

from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.search.rivals import penalised

_ADMITTED = 1.645  # standard deviations: within the interval of 90 %


def as_assumed(final: Fit) -> Fit:
    """The fit with those shapes of its effects as assumed that the recordings admit so.

    How strong an effect is, the recordings tell; how it goes on at another load or in another heat they often do not.
    Fitted all the same, such a shape follows the noise, and at another load the muscle is far off. All are held at
    once, the least known goes on alone where they are needed together; none is where the fit says that it is.
    """
    admitted = _admitted(final)
    while admitted:
        held = _held(final, admitted)
        if penalised(held) <= penalised(final):
            return held
        admitted = admitted[1:]
    return final


def _admitted(fitted: Fit) -> list[int]:
    """The unknowns that are shapes of effects and may be what was assumed; those that are known best first."""
    problem, found = fitted.problem, {}
    for k, unknown in enumerate(problem.unknowns):
        effect, _, name = unknown.name.partition('.')
        if not name or unknown.state or unknown.recording is not None or name == problem.model.effects[effect].strength:
            continue
        off = abs(float(fitted.z[k]) - unknown.to_fit(_assumed(fitted, unknown.name)))
        spread = float(np.sqrt(fitted.covariance[k, k]))
        if 0.0 < off <= _ADMITTED * spread:
            found[k] = spread / unknown.prior_spread
    return sorted(found, key=lambda k: found[k])


def _assumed(fitted: Fit, name: str) -> float:
    return float(fitted.problem.model.specifications[name].value)


def _held(fitted: Fit, which: list[int]) -> Fit:
    """The fit without these unknowns: they are as assumed."""
    problem, kept = fitted.problem, [k for k in range(len(fitted.z)) if k not in which]
    values = {name: _assumed(fitted, name) for name in (problem.unknowns[k].name for k in which)}
    held = replace(
        problem,
        parameters=problem.parameters.replace(values),
        unknowns=tuple(problem.unknowns[k] for k in kept),
    )
    return fit(held, fitted.z[kept], rounds=30, tolerance=1e-5)

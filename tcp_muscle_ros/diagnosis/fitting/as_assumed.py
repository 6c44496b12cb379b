"""What the recordings do not tell stays as it was assumed."""

from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit


def as_assumed(final: Fit) -> Fit:
    """The fit with those parameters as assumed that the recordings do not fix, and those shapes of its effects that
    they admit so.

    How strong an effect is, the recordings tell; how it goes on at another load or in another heat they often do not.
    Fitted all the same, such a shape follows the noise, and at another load the muscle is far off. All are held at
    once; where they are needed together, those that are known best go free again, one after the other.
    """
    admitted, price = _admitted(final), final.problem.policy.per_parameter
    while admitted:
        held = _held(final, admitted)
        if held.objective <= final.objective + price * len(admitted):
            return held
        admitted = admitted[1:]
    return final


def _admitted(fitted: Fit) -> list[int]:
    """The unknowns that may be what was assumed, those that are known best first; what each recording has for itself,
    and how strong an effect is, are none of them."""
    problem, found = fitted.problem, {}
    for k, unknown in enumerate(problem.unknowns):
        if unknown.state or unknown.recording is not None:
            continue
        spread = float(np.sqrt(fitted.covariance[k, k]))
        effect, _, shape = unknown.name.partition('.')
        told = shape == problem.model.effects[effect].strength if shape else unknown.fixed_by(spread)
        assumed, (low, high) = _assumed(fitted, k), fitted.interval(k)
        if not told and low <= assumed <= high and fitted.values[unknown.key] != assumed:
            found[k] = spread / unknown.prior_spread
    return sorted(found, key=lambda k: found[k])


def _assumed(fitted: Fit, k: int) -> float:
    """What was assumed of an unknown: of a shape its usual value, of the muscle itself what the fit began with."""
    unknown = fitted.problem.unknowns[k]
    return float(fitted.problem.model.specifications[unknown.name].value) if '.' in unknown.name else unknown.start


def _held(fitted: Fit, which: list[int]) -> Fit:
    """The fit without these unknowns: they are as assumed."""
    problem, kept = fitted.problem, [k for k in range(len(fitted.z)) if k not in which]
    held = replace(
        problem,
        parameters=problem.parameters.replace({problem.unknowns[k].name: _assumed(fitted, k) for k in which}),
        unknowns=tuple(problem.unknowns[k] for k in kept),
    )
    return fit(held, fitted.z[kept], rounds=30, tolerance=1e-5)

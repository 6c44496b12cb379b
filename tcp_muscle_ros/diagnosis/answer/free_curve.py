"""The curve of a law without a name, with the band that the recordings leave to it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from tcp_muscle_ros.diagnosis.answer.findings import FreeLaw
from tcp_muscle_ros.diagnosis.answer.form_words import in_words
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.search.selected import Chosen, Selection
from tcp_muscle_ros.muscle import EFFECTS
from tcp_muscle_ros.muscle.edges import EDGES, of

_POINTS = 41
_NINETY = 1.645  # standard deviations either way of a 90 % interval


def found_law(selection: Selection, chosen: Chosen) -> FreeLaw:
    """What is said of a law that was chosen: its curve, in words where a form is as good, how far the catalogue is."""
    law = free_law(selection.final, chosen.effect, chosen.nearest)
    said = in_words(selection, chosen.effect, law.driver, law.at)
    if chosen.closest is None:
        return replace(law, in_words=said)
    name, drop = chosen.closest
    return replace(law, nearest=name, nearest_share=max(drop, 0.0) / chosen.drop, in_words=said)


def free_law(fitted: Fit, effect: str, nearest: Sequence[str] = ()) -> FreeLaw:
    """The natural cubic spline through the fitted table, its band from the covariance of the values at the knots."""
    at = np.array(_array(fitted, f'{effect}.at'))
    places = [k for k, u in enumerate(fitted.problem.unknowns) if u.name.startswith(f'{effect}.value_')]
    values = np.array([fitted.problem.unknowns[k].from_fit(float(fitted.z[k])) for k in places])
    spreads = np.array([fitted.problem.unknowns[k].spread for k in places])
    covariance = fitted.covariance[np.ix_(places, places)] * np.outer(spreads, spreads)
    x = np.linspace(at[0], at[-1], _POINTS)
    weights = np.column_stack([CubicSpline(at, one, bc_type='natural')(x) for one in np.eye(at.size)])
    curve = weights @ values
    beside = _NINETY * np.sqrt(np.maximum(np.sum((weights @ covariance) * weights, axis=1), 0.0))
    driver = driver_of(fitted, effect)
    unit = next(column.unit for column in EFFECTS[effect].columns if column.name == 'value')
    return FreeLaw(driver, unit, x, curve, curve - beside, curve + beside, nearest[0] if nearest else None)


def driver_of(fitted: Fit, effect: str) -> str:
    """Over what a fitted law is a table."""
    free = EFFECTS[effect].free
    assert free is not None
    return tuple(free.drivers)[round(fitted.muscle[f'{effect}.driver'])]


def _array(fitted: Fit, name: str) -> tuple[float, ...]:
    found = of(EDGES[name], fitted.muscle)
    assert isinstance(found, tuple)
    return found

"""The curve of a law without a name, with the band that the recordings leave to it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from tcp_muscle_ros.diagnosis.answer.findings import FreeLaw
from tcp_muscle_ros.diagnosis.answer.form_words import in_words
from tcp_muscle_ros.diagnosis.answer.in_words import driver_of, places_of, unit_of
from tcp_muscle_ros.diagnosis.fitting.least_squares import WIDTH, Fit
from tcp_muscle_ros.diagnosis.search.selected import Chosen, Selection

_POINTS = 41


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
    places = places_of(fitted, effect)[0]
    unknowns = [fitted.problem.unknowns[k] for k in places]
    at = np.array([fitted.muscle[f'{effect}.at_{k + 1}'] for k in range(len(places))])
    values = np.array([u.from_fit(float(fitted.z[k])) for u, k in zip(unknowns, places, strict=True)])
    spreads = np.array([u.spread for u in unknowns])
    x = np.linspace(at[0], at[-1], _POINTS)
    weights = np.column_stack([CubicSpline(at, one, bc_type='natural')(x) for one in np.eye(at.size)])
    curve = weights @ values
    covariance = fitted.covariance[np.ix_(places, places)] * np.outer(spreads, spreads)
    beside = WIDTH * np.sqrt(np.maximum(np.sum((weights @ covariance) * weights, axis=1), 0.0))
    driver, unit = driver_of(fitted, effect), unit_of(effect)
    return FreeLaw(driver, unit, x, curve, curve - beside, curve + beside, nearest[0] if nearest else None)

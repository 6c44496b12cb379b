"""How well the muscle that a diagnosis hands on is known: a replay of improved.yaml draws its band from it."""

from collections.abc import Sequence

import numpy as np

from tcp_muscle_ros.diagnosis.answer.handed_on import (
    leakage_of,
    of_form,
    of_instrument,
    stiffness_of_one_load,
    unsure_of_stiffness,
)
from tcp_muscle_ros.diagnosis.answer.improved import physics_only
from tcp_muscle_ros.diagnosis.fitting.calibration import Known, estimates, in_one
from tcp_muscle_ros.diagnosis.model.unknown import Unknown
from tcp_muscle_ros.diagnosis.search.selected import Selection
from tcp_muscle_ros.muscle import SPECIFICATIONS, Parameters
from tcp_muscle_ros.muscle.arrays import Array


def known_of(selection: Selection, muscle: Parameters) -> Known:
    """How well ``muscle``, the improved one, is known: its own parameters and those of its effects.

    What stays as assumed, for the recordings do not tell it, is as uncertain as they leave it; the stiffness of one
    load is known by what was assumed of it too, for so it was handed on (``foretelling``). What belongs to sensors
    or to single recordings is not in the muscle, and not here. The intervals are those of the report; the covariance
    is that of the muscle on its rig, which a replay takes as it is: what only both together fix is fixed then. It is
    without what the form of the effects adds to the intervals: that moves all parameters at once, each for the other,
    and taken for errors of each alone it would make a band a hundred times as wide as the errors.
    """
    final, calibrated = selection.best, selection.calibrated
    covariance, one = final.covariance, stiffness_of_one_load(final, calibrated)
    if one is not None:
        covariance = known_to(covariance, one, unsure_of_stiffness(final, calibrated, one))
    effects = physics_only(muscle).effects
    forms: dict[str, float] = {}
    for k, u in enumerate(final.problem.unknowns):
        if k != one and '.' not in u.name and u.name not in forms:
            forms[u.name] = of_form(final, calibrated, k)
    every, whole = in_one(final, covariance)
    held = [k for k, u in enumerate(every) if _of_muscle(u.name, effects)]
    unknowns, mine = [every[k] for k in held], whole[np.ix_(held, held)]
    beside = [forms.get(u.name, 0.0) for u in unknowns]
    on_rig = given(whole, held, [k for k, u in enumerate(every) if of_instrument(u.name)])
    leakage = leakage_of(selection, final)
    if leakage is not None:  # the mean of slips at their own instants is in no fit: it is as unsure as they vary
        rate = _free(final.problem.model.roles.rate, leakage.rate)
        unknowns, beside = [*unknowns, rate], [*beside, 0.0]
        mine, on_rig = np.pad(mine, (0, 1)), np.pad(on_rig, (0, 1))
        mine[-1, -1] = on_rig[-1, -1] = (leakage.unsure / rate.spread) ** 2
    z = np.array([u.to_fit(min(max(muscle[u.name], u.low), u.high)) for u in unknowns])
    found = estimates(final.problem.model, unknowns, z, mine, np.array(beside))
    return Known(tuple(found), tuple(unknowns), on_rig)


def known_to(covariance: Array, k: int, variance: float) -> Array:
    """The covariance with another variance of one unknown, which all others follow as the recordings have it."""
    follows = covariance[:, k] / covariance[k, k]
    moved: Array = covariance + (variance - covariance[k, k]) * np.outer(follows, follows)
    return moved


def given(covariance: Array, held: Sequence[int], known: Sequence[int]) -> Array:
    """The covariance of some unknowns where others are known to be as they are, shape (held, held)."""
    mine = covariance[np.ix_(held, held)]
    if not known:
        return mine
    across = covariance[np.ix_(held, known)]
    told: Array = mine - across @ np.linalg.pinv(covariance[np.ix_(known, known)], hermitian=True) @ across.T
    return told


def _of_muscle(name: str, effects: tuple[str, ...]) -> bool:
    """Whether a parameter is the muscle's own or of one of these effects."""
    effect, _, shape = name.partition('.')
    return not shape or effect in effects


def _free(name: str, value: float) -> Unknown:
    """A parameter as an unknown that may be anything within its bounds."""
    row = SPECIFICATIONS[name]
    return Unknown(name, value, row.low, row.high, row.high - row.low)

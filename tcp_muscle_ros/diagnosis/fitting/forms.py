"""What the listed form of an effect may miss of the muscle's own.

The difference is smooth in the muscle's state and as large as the effect is strong. Allowed for, it neither drowns a
weaker effect beside a strong one nor passes for one.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting import draught
from tcp_muscle_ros.diagnosis.fitting.generic import Drivers, drivers, hats
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.weighing import refitted
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem, Shown, without_effect
from tcp_muscle_ros.muscle.arrays import Array

_SHARES = np.linspace(0.0, 1.0, 5)  # of all temperatures, warming and cooling
_MOMENTS = 24  # of a recording, for what is a circumstance of each
_NOTHING = 0.05  # of the noise


def allowing_forms(fitted: Fit, effects: Collection[str]) -> Fit:
    """The same fit with what the forms of these effects may miss allowed for, and of no others."""
    had = any(a.forms is not None for latent in fitted.problem.latents for a in latent.allowances.values())
    roles = fitted.problem.model.roles
    inferred = roles.inferred & set(effects)
    if inferred:
        fitted = draught.with_course(refitted(fitted, _with(fitted.problem)) if had else fitted, inferred)
    else:
        fitted = draught.without_course(fitted)
    plain = _with(fitted.problem)
    ways: list[dict[str, list[Array]]] = [{} for _ in plain.experiments]
    found = [_unsure(plain)] if inferred else []
    # What is left of a swing has its own weight (see weighing.calmed).
    found += [_bent(fitted, plain, effect) for effect in effects if effect not in {*inferred, roles.swings}]
    for one in found:
        for mine, more in zip(ways, one, strict=True):
            for name, columns in more.items():
                mine.setdefault(name, []).append(columns)
    if not had and not any(ways):
        return fitted
    return refitted(fitted, _with(plain, [{name: np.hstack(found) for name, found in mine.items()} for mine in ways]))


def _unsure(problem: Problem) -> list[Shown]:
    """What stays unknown of the course of a draught or a room, by recording and channel."""
    return [
        {} if latent.draught is None else {name: latent.draught.unsure[name] for name in e.observed}
        for e, latent in zip(problem.experiments, problem.latents, strict=True)
    ]


def _bent(fitted: Fit, plain: Problem, effect: str) -> list[Shown]:
    """Ways in which a form may miss what an effect does, by recording and channel: its signature bent by what the state
    is, and all that is smooth in the state and of its size."""
    knots = np.unique(np.quantile(np.concatenate([getattr(o, plain.model.state) for o in fitted.outputs]), _SHARES))
    found: list[Shown] = []
    for own, experiment, outputs in zip(_signature(fitted, plain, effect), plain.followed, fitted.outputs, strict=True):
        ways: Shown = {}
        for name, observed in experiment.observed.items():
            signature = own[name] - np.mean(own[name]) if plain.model.channels[name].floating else own[name]
            size = float(np.sqrt(np.mean(signature**2)))
            if size * observed.beside > _NOTHING * plain.noise[name].sigma:
                smooth = _smooth(drivers(experiment, outputs, observed.time), knots)
                bent = [signature[:, None] * smooth, size * smooth]
                if plain.model.effects[effect].whole or plain.model.effects[effect].moments:
                    bent.append(size * _moments(observed.time))
                ways[name] = plain.policy.form * np.hstack(bent)
        found.append(ways)
    return found


def _smooth(state: Drivers, knots: Array) -> Array:
    """Functions of temperature, warming and cooling apart, that add up to one, shape (m, n)."""
    levels, warming = hats(state.level, knots), (state.rate > 0.0)[:, None]
    return np.hstack([levels * warming, levels * ~warming])


def _moments(time: Array) -> Array:
    """Functions of the elapsed time that add up to one, shape (m, n)."""
    return hats(time, np.linspace(time[0], time[-1], _MOMENTS))


def _signature(fitted: Fit, plain: Problem, effect: str) -> list[Shown]:
    """What an effect shows in every recording (SI) that the other unknowns could not."""
    lacking, kept = without_effect(plain, effect)
    without = lacking.predictions(fitted.z[kept])
    change = [
        {name: shown - less[name] for name, shown in mine.items()}
        for mine, less in zip(fitted.predictions, without, strict=True)
    ]
    slopes = [{name: columns[:, kept] for name, columns in mine.items()} for mine in fitted.slopes]
    white = np.concatenate(
        [plain.columns({n: c[:, None] for n, c in mine.items()}, k)[:, 0] for k, mine in enumerate(change)]
    )
    scale = lacking.spreads()
    mimic, *_ = np.linalg.lstsq(
        np.vstack([plain.jacobian(slopes), np.diag(1.0 / scale)]), np.append(white, np.zeros(scale.size)), rcond=None
    )
    return [
        {name: shown - mine[name] @ mimic for name, shown in found.items()}
        for found, mine in zip(change, slopes, strict=True)
    ]


def _with(problem: Problem, ways: Sequence[Shown] = ()) -> Problem:
    """The problem with errors of the model allowed in these ways, by recording and channel, and in no others."""
    latents = []
    for latent, mine in zip(problem.latents, ways or [{}] * len(problem.latents), strict=True):
        names = dict.fromkeys((*latent.allowances, *mine))
        allowed = {name: replace(latent.allowance(name), forms=mine.get(name)) for name in names}
        latents.append(replace(latent, allowances=allowed))
    return problem.with_latents(latents)

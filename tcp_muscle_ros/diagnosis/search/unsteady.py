"""A draught that is no single gust: found by what several channels see at once, whatever its course.

Where the air comes and goes, no gust fits, and none is accepted. But its course is the same in every channel: what one
shows of it must foretell what another sees. And it cools as hard while nothing heats, which no unstable supply does.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting import draught
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.fitting.weighing import refitted, settle_noise
from tcp_muscle_ros.diagnosis.noise.noise import quick_noise
from tcp_muscle_ros.diagnosis.search.candidates import screen
from tcp_muscle_ros.diagnosis.search.rivals import grow
from tcp_muscle_ros.diagnosis.search.shared import shared_misfit
from tcp_muscle_ros.muscle.arrays import Mask

_ROUNDS = 20
_AS_HARD = 0.5  # of its strength while the drive is on: what it has at least while it is off


@dataclass(frozen=True)
class Unsteady:
    """The fit with a draught by its name (one gust a recording), and the one that has its course; the share of the
    misfit that the course takes, of the channel in which that is largest."""

    named: Fit
    followed: Fit
    share: float


def unsteady(present: Fit, progress: Callable[[], None] | None = None) -> Unsteady | None:
    """The draught that explains what several channels see at once; None where they see nothing, or it is another."""
    shared, effect = shared_misfit(present), present.problem.model.roles.course
    if shared is None or any(present.problem.model.effects[e].circumstance for e in present.problem.parameters.effects):
        return None
    ranked, _ = screen(present, [effect], progress)
    named = grow(present, ranked[0], _ROUNDS) if ranked else None
    if named is None:
        return None
    shown, foretold = sorted(shared.channels, key=lambda name: -_missed(present, name))
    seen = draught.with_course(_only(named, shown))
    courses = [
        replace(mine, draught=latent.draught and replace(latent.draught, unsure={}))
        for mine, latent in zip(named.problem.latents, seen.problem.latents, strict=True)
    ]
    predicted = refitted(named, named.problem.with_latents(courses))
    if progress:
        progress()
    if _taken(present, predicted, foretold) < present.problem.policy.of_rest or not _blows_on(predicted):
        return None
    followed, _ = settle_noise(draught.with_course(named), 1)
    return Unsteady(named, followed, max(_taken(present, followed, name) for name in shared.channels))


def _missed(fitted: Fit, channel: str) -> float:
    """In noises, squared."""
    return fitted.mean_square[channel] / fitted.problem.noise[channel].sigma ** 2


def _taken(before: Fit, after: Fit, channel: str) -> float:
    """The share of a channel's squared error beyond the quick noise that went."""
    floor = quick_noise(before.problem.experiments)[channel].sigma ** 2
    return 1.0 - (after.mean_square[channel] - floor) / (before.mean_square[channel] - floor)


def _only(fitted: Fit, channel: str) -> Fit:
    """The fit of what one channel shows."""
    keep: list[dict[str, Mask]] = [
        {channel: np.ones(e.observed[channel].time.size, dtype=bool)} if channel in e.observed else {}
        for e in fitted.problem.experiments
    ]
    return fit(fitted.problem.only(keep), fitted.z, rounds=_ROUNDS, tolerance=1e-5)


def _blows_on(fitted: Fit) -> bool:
    """Whether it blows about as hard while the drive is off and the muscle still warm as while it is on."""
    on, off = draught.strength(fitted)
    return off >= _AS_HARD * on

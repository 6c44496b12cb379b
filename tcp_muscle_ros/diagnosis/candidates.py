"""Candidates: how far each effect could explain what is left over, before any is fitted in full.

An effect's direction is the change of all whitened residuals when it is switched on at a plausible strength. What
the unknowns of the present model could mimic is projected out of it; the rest, set against the residual, says how much
the misfit would drop. All in linear approximation: it ranks, refits decide.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting import Fit, Problem
from tcp_muscle_ros.diagnosis.unknowns import effect_unknowns
from tcp_muscle_ros.muscle import EFFECTS
from tcp_muscle_ros.muscle.arrays import Array

# Present in no recording of one muscle: an exact null direction of R0, a_R, hA and C (see docs/effects.md).
NEVER_TESTABLE = {
    'contact_resistance': 'a constant resistance in series acts on one muscle exactly as other R0, a_R, hA and C do; '
    'measure with four wires, or two lengths'
}
_WORKERS = 2
_MOST_VARIANTS = 5


@dataclass(frozen=True)
class Candidate:
    """An effect at one set of its secondary parameters.

    ``gain``: expected drop of the misfit; ``signal``: norm of what remains of its direction at full plausible strength
    once the unknowns have mimicked what they can, in units of the noise; ``values``: where a refit should start.
    """

    effect: str
    values: dict[str, float]
    gain: float
    signal: float
    direction: Array

    @property
    def stage(self) -> str:
        """The stage that the effect belongs to."""
        return EFFECTS[self.effect].stage


def with_effect(problem: Problem, effect: str, values: dict[str, float]) -> Problem:
    """The problem with one more effect on, its parameters unknown and starting from ``values``."""
    parameters = problem.parameters.with_effects(effect).replace(values)
    added = effect_unknowns(effect, parameters)
    return replace(problem, parameters=parameters, unknowns=(*problem.unknowns, *added))


def without_effect(problem: Problem, effect: str) -> Problem:
    """The problem with one effect taken out."""
    kept = tuple(u for u in problem.unknowns if not u.name.startswith(f'{effect}.'))
    effects = tuple(e for e in problem.parameters.effects if e != effect)
    return replace(problem, parameters=problem.parameters.only_effects(effects), unknowns=kept)


def variants(effect: str) -> list[dict[str, float]]:
    """Sets of an effect's parameters to try: the usual one, then each secondary parameter low and high."""
    definition = EFFECTS[effect]
    usual = {f'{effect}.{row.name}': row.value for row in definition.parameters}
    found = [usual]
    for row in definition.parameters:
        if row.name == definition.strength:
            continue
        for share in (0.2, 0.8):
            if row.low > 0.0 and row.high / row.low > 10.0:
                value = row.low * (row.high / row.low) ** share
            else:
                value = row.low + share * (row.high - row.low)
            found.append({**usual, f'{effect}.{row.name}': value})
    return found[: 1 + _MOST_VARIANTS]


@dataclass(frozen=True)
class Screen:
    """The projection of a fitted problem: everything that screening an effect needs."""

    fit: Fit
    base: tuple[Array, ...]
    orthonormal: Array
    left: Array

    @classmethod
    def of(cls, fitted: Fit) -> 'Screen':
        """From a fit: its residuals with the part that its own unknowns could still move taken out."""
        scale = np.array([u.prior_spread for u in fitted.problem.unknowns])
        augmented = np.vstack([fitted.jacobian, np.diag(1.0 / scale)])
        orthonormal, _ = np.linalg.qr(augmented)
        residual = np.concatenate([*fitted.residuals, (fitted.z - fitted.problem.start()) / scale])
        left = residual - orthonormal @ (orthonormal.T @ residual)
        return cls(fitted, fitted.residuals, orthonormal, left)

    def direction(self, effect: str, values: dict[str, float]) -> Array | None:
        """What switching the effect on adds to the predictions, whitened, what unknowns mimic taken out."""
        problem = self.fit.problem
        changed = replace(problem, parameters=problem.parameters.with_effects(effect).replace(values))
        fitted = self.fit.values
        try:
            moved = [changed.residual(fitted, k) for k in range(len(problem.experiments))]
        except (ValueError, ArithmeticError):
            return None
        change = np.concatenate([*self.base, np.zeros(self.fit.z.size)])
        change -= np.concatenate([*moved, np.zeros(self.fit.z.size)])
        if not np.all(np.isfinite(change)):
            return None
        return np.asarray(change - self.orthonormal @ (self.orthonormal.T @ change))

    def candidate(self, effect: str, values: dict[str, float]) -> Candidate | None:
        """How much this effect with these parameters would improve the fit."""
        direction = self.direction(effect, values)
        if direction is None:
            return None
        power = float(direction @ direction)
        definition = EFFECTS[effect]
        strength = next(row for row in definition.parameters if row.name == definition.strength)
        typical = values[f'{effect}.{strength.name}'] - definition.none
        if power < 1e-12 or typical == 0.0:
            return Candidate(effect, values, 0.0, 0.0, direction)
        low, high = (strength.low - definition.none) / typical, (strength.high - definition.none) / typical
        amount = float(np.clip(float(direction @ self.left) / power, min(low, high), max(low, high)))
        gain = 2.0 * amount * float(direction @ self.left) - amount**2 * power
        start = dict(values)
        # A start at exactly nothing has no slope in the secondary parameters.
        start[f'{effect}.{strength.name}'] = definition.none + typical * (amount if abs(amount) > 0.05 else 0.05)
        return Candidate(effect, start, max(gain, 0.0), float(np.sqrt(power)), direction)


def screen(
    fitted: Fit, effects: Sequence[str], progress: Callable[[], None] | None = None
) -> tuple[list[Candidate], dict[str, float]]:
    """Rank effects by the drop of the misfit that they promise.

    Returns the best variant of each effect, best first, and for each effect the largest signal of its variants.
    """
    base = Screen.of(fitted)

    def best(effect: str) -> tuple[Candidate | None, float]:
        if progress:
            progress()
        tried = [base.candidate(effect, values) for values in variants(effect)]
        found = [c for c in tried if c is not None]
        if not found:
            return None, 0.0
        return max(found, key=lambda c: c.gain), max(c.signal for c in found)

    with ThreadPoolExecutor(_WORKERS) as pool:
        results = list(pool.map(best, effects))
    ranked = sorted((c for c, _ in results if c is not None), key=lambda c: -c.gain)
    return ranked, {effect: signal for effect, (_, signal) in zip(effects, results, strict=True)}

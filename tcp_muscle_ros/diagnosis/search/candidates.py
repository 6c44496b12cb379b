"""Candidates: how far each effect could explain what is left over, before any is fitted in full.

An effect's direction is the change of all whitened residuals when it is switched on at a plausible strength. What
the unknowns of the present model could mimic is projected out of it; the rest, set against the residual, says how much
the misfit would drop. All in linear approximation: it ranks, refits decide.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit, ran_away
from tcp_muscle_ros.diagnosis.fitting.projection import Projection
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.hypothesis.unknowns import effect_unknowns
from tcp_muscle_ros.diagnosis.model.model import Model
from tcp_muscle_ros.diagnosis.model.tcp_muscle import TCP_MUSCLE
from tcp_muscle_ros.diagnosis.model.unknown import Unknown
from tcp_muscle_ros.muscle import Effect
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.parameter import Parameter

_WORKERS = 2
_DIFFERS = 0.05  # of the largest: what is imposed is not the same throughout
_WEAK, _APART = 0.1, 2.5
_CROSSED = (0.15, 0.4, 0.6, 0.85)  # shares of an output's span
_OTHERS, _ALSO = 3, 0.4  # further sets to start from, and the share of the best one's gain that they promise at least
_RETURNED = 2  # sets that are tried with the muscle brought back, too, where it went far
_FAR, _HELD = 1.0, 1e-6  # of the prior's spread: what has gone far, and by how little what is held may move
_BEGINS, _SPANS = (0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.88), (0.06, 0.2, 2.0)  # shares of a recording


@dataclass(frozen=True)
class Candidate:
    """An effect at one set of its secondary parameters.

    ``gain``: expected drop of the misfit; ``signal``: norm of what remains of its direction at full plausible strength
    once the unknowns have mimicked what they can, in units of the noise; ``values``: where a refit should start;
    ``own``: the same for each recording, where every recording has its own, else empty; ``others``: where else to
    start, the best of the other sets, best first; ``begun``: where the unknowns of the muscle should start, if not
    where they are; ``by_choice``: what promises most by each of its choices; ``model``: what it is an effect of.
    """

    effect: str
    values: dict[str, float]
    gain: float
    signal: float
    own: tuple[dict[str, float], ...] = ()
    others: 'tuple[Candidate, ...]' = ()
    begun: Array | None = None
    by_choice: 'tuple[Candidate, ...]' = ()
    model: Model = TCP_MUSCLE

    @property
    def definition(self) -> Effect:
        """What the effect says of itself."""
        return self.model.effects[self.effect]

    @property
    def stage(self) -> str:
        """The stage that the effect belongs to."""
        return self.definition.stage

    def worth(self, price: float) -> float:
        """The gain less the ``price`` of each of its parameters, and of a choice that is not the usual one."""
        rows = self.definition.parameters
        chosen = sum(bool(row.choices) and self.values[f'{self.effect}.{row.name}'] != row.value for row in rows)
        return self.gain - price * (chosen + len(self.definition.moved(self.values)) * max(len(self.own), 1))

    def starts(self) -> 'list[Candidate]':
        """Where a refit may start: as far as the linear approximation goes, and less far; at the usual strength and
        beyond.

        A weight that swings has no other mass than its own: half of it fits worse than none.
        """
        definition = self.definition
        key = f'{self.effect}.{definition.strength}'
        row = self.model.specifications[key]
        usual, low, high = abs(row.value - definition.none), row.low, row.high

        def moved(values: dict[str, float], share: float, of_usual: bool) -> dict[str, float]:
            reached = values[key] - definition.none
            change = share * (float(np.copysign(usual, reached)) if of_usual else reached)
            return {**values, key: min(max(definition.none + change, low), high)}

        return [
            replace(
                self,
                values=moved(values, share, of_usual),
                own=tuple(moved(own, share, of_usual) for own in self.own),
            )
            for values in (self.values, *(other.values for other in self.others[:1]))
            for share, of_usual in ((1.0, False), (0.4, False), (0.1, False), (1.0, True), (_APART, True))
        ]


def best_of(found: Sequence[Candidate], price: float) -> Candidate:
    """The variant of an effect that is worth most at this ``price`` of a parameter, with what else it may be."""
    first = max(found, key=lambda c: c.worth(price))
    alike = sorted((c for c in found if not c.own), key=lambda c: -c.worth(price))
    rest = [c for c in alike if c is not first and c.begun is first.begun and not first.own]
    others = [*rest[:1], *(c for c in rest[1:_OTHERS] if c.gain > _ALSO * first.gain)]
    choices = [f'{first.effect}.{row.name}' for row in first.definition.parameters if row.choices]
    by_choice: dict[tuple[float, ...], Candidate] = {}
    for candidate in sorted(alike, key=lambda c: -c.gain):
        by_choice.setdefault(tuple(candidate.values[key] for key in choices), candidate)
    return replace(first, others=tuple(others), by_choice=tuple(by_choice.values()))


def with_effect(problem: Problem, candidate: Candidate) -> Problem:
    """The problem with one more effect on, its parameters unknown and starting from the candidate's."""
    parameters = problem.parameters.with_effects(candidate.effect).replace(candidate.values)
    if candidate.own:
        added = [
            unknown
            for k, values in enumerate(candidate.own)
            for unknown in effect_unknowns(problem.model, candidate.effect, parameters.replace(values), k)
        ]
    else:
        added = effect_unknowns(problem.model, candidate.effect, parameters)
    return replace(problem, parameters=parameters, unknowns=(*problem.unknowns, *added))


def variants(
    model: Model, effect: str, duration: float, spans: Mapping[str, tuple[float, float]] | None = None
) -> list[dict[str, float]]:
    """Sets of an effect's parameters to try: the usual one, a weak one, each secondary parameter low and high; for each
    choice.

    Instants and spans are tried all over the recording, whose ``duration`` (s) is given; what an output has to cross,
    all over the span of that output (``spans``, by its name).
    """
    definition = model.effects[effect]
    usual = {f'{effect}.{row.name}': row.value for row in definition.parameters}
    if definition.whole:
        key = f'{effect}.{definition.whole}'
        usual[key] = min(max(duration, model.specifications[key].low), model.specifications[key].high)
    if definition.moments:
        begin, span = (f'{effect}.{name}' for name in definition.moments)
        return [{**usual, begin: at * duration, span: long * duration} for at in _BEGINS for long in _SPANS]
    # From a tenth of the usual strength the linear approximation reaches what from the usual one it does not.
    key = f'{effect}.{definition.strength}'
    found = [usual, {**usual, key: definition.none + _WEAK * (usual[key] - definition.none)}]
    for row in definition.fitted:
        if row.name == definition.strength or row.bends:
            continue
        if row.crossed and spans:
            low, high = spans[row.crossed]
            reached = [min(max(low + share * (high - low), row.low), row.high) for share in _CROSSED]
            found += [{**usual, f'{effect}.{row.name}': value} for value in reached]
            continue
        if row.low == 0.0 < row.value < 0.1 * row.high:  # its bound says little
            between = float(np.sqrt(row.value * row.high))
            found += [{**usual, f'{effect}.{row.name}': v} for v in (row.value / _APART, _APART * row.value, between)]
            continue
        for share in (0.2, 0.8):
            if row.low > 0.0 and row.high / row.low > 10.0:
                value = row.low * (row.high / row.low) ** share
            else:
                value = row.low + share * (row.high - row.low)
            found.append({**usual, f'{effect}.{row.name}': value})
    return _by_choice(definition, usual, found)


def _by_choice(definition: Effect, usual: Mapping[str, float], found: list[dict[str, float]]) -> list[dict[str, float]]:
    """The sets for each choice; none that changes what its choice leaves idle, nor those that recordings never show."""
    choices = {f'{definition.name}.{row.name}': row for row in definition.parameters if row.choices}
    for name, row in choices.items():
        found = [{**one, name: float(k)} for k in range(len(row.choices)) for one in found]
    if definition.hidden:
        found = [one for one in found if any(one[name] != row.value for name, row in choices.items())]

    def idle(one: dict[str, float]) -> list[str]:
        moved = definition.moved(one)
        return [f'{definition.name}.{row.name}' for row in definition.fitted if row not in moved]

    return [one for one in found if all(one[name] == usual[name] for name in idle(one))]


def told(problem: Problem, row: Parameter) -> bool:
    """Whether recordings can tell the choices of a parameter apart: what has to differ for that does."""
    if not row.told_by:
        return True
    given = np.concatenate([np.ravel(getattr(e.imposed, row.told_by)) for e in problem.experiments])
    return bool(np.ptp(given) > _DIFFERS * np.max(np.abs(given)))


@dataclass(frozen=True)
class Screen:
    """The projection of a fitted problem: everything that screening an effect needs."""

    fit: Fit
    orthonormal: Array
    left: Array
    spans: dict[str, tuple[float, float]]

    @classmethod
    def of(cls, fitted: Fit) -> 'Screen':
        """From a fit: its residuals with the part that its own unknowns could still move taken out."""
        projection = Projection.of(fitted)
        spans = {}
        for name in {row.crossed for row in fitted.problem.model.specifications.values()} - {''}:
            shown = np.concatenate([getattr(o, name) for o in fitted.outputs])
            spans[name] = float(shown.min()), float(shown.max())
        return cls(fitted, projection.orthonormal, projection.left, spans)

    def change(self, effect: str, values: dict[str, float]) -> list[Array] | None:
        """What switching the effect on adds to the predictions of each recording, whitened."""
        problem = self.fit.problem
        changed = replace(problem, parameters=problem.parameters.with_effects(effect).replace(values))
        try:
            moved = changed.predictions(self.fit.z)
        except (ValueError, ArithmeticError):
            return None
        found = []
        for k, (before, after) in enumerate(zip(self.fit.predictions, moved, strict=True)):
            added = {name: (after[name] - shown)[:, None] for name, shown in before.items()}
            found.append(-problem.columns(added, k)[:, 0])
        return None if ran_away(found) else found

    @property
    def misfit(self) -> float:
        """What the unknowns could not take away, in linear approximation."""
        return float(self.left @ self.left)

    def judge(self, effect: str, values: dict[str, float], change: list[Array]) -> Candidate:
        """How much this effect, which changes the predictions so, would improve the fit."""
        whole = np.concatenate([*change, np.zeros(self.fit.z.size)])
        direction = whole - self.orthonormal @ (self.orthonormal.T @ whole)
        power = float(direction @ direction)
        definition, model = self.fit.problem.model.effects[effect], self.fit.problem.model
        strength = next(row for row in definition.parameters if row.name == definition.strength)
        typical = values[f'{effect}.{strength.name}'] - definition.none
        if power < 1e-12 or typical == 0.0:
            return Candidate(effect, values, 0.0, 0.0, model=model)
        low, high = (strength.low - definition.none) / typical, (strength.high - definition.none) / typical
        amount = float(np.clip(float(direction @ self.left) / power, min(low, high), max(low, high)))
        gain = 2.0 * amount * float(direction @ self.left) - amount**2 * power
        start = dict(values)
        # A start at exactly nothing has no slope in the secondary parameters.
        start[f'{effect}.{strength.name}'] = definition.none + typical * (amount if abs(amount) > 0.05 else 0.05)
        return Candidate(effect, start, max(gain, 0.0), float(np.sqrt(power)), model=model)

    def candidates(self, effect: str) -> list[Candidate]:
        """The effect in each of its variants; a circumstance also with each recording's own best variant."""
        experiments, model = self.fit.problem.experiments, self.fit.problem.model
        usual = {
            f'{effect}.{r.name}': r.value for r in model.effects[effect].parameters if not told(self.fit.problem, r)
        }
        tried = []
        for values in variants(model, effect, max(e.duration for e in experiments), self.spans):
            change = self.change(effect, values) if usual.items() <= values.items() else None
            if change is not None:
                tried.append((values, change))
        found = [self.judge(effect, values, change) for values, change in tried]
        if found and model.effects[effect].circumstance and len(experiments) > 1:
            own = []
            for k in range(len(experiments)):
                alone = [
                    self.judge(effect, values, [part * (j == k) for j, part in enumerate(change)])
                    for values, change in tried
                ]
                own.append(max(alone, key=lambda c: c.gain))
            gain, signal = sum(c.gain for c in own), float(np.sqrt(sum(c.signal**2 for c in own)))
            found.append(Candidate(effect, own[0].values, gain, signal, tuple(c.values for c in own), model=model))
        return found


def _brought_back(fitted: Fit) -> Fit | None:
    """The fit with what of the muscle went far put where it began; None where nothing did.

    A muscle makes up for physics that it lacks, and may go where that physics does nothing: a coil that became as
    stiff as a rod does not soften.
    """
    problem, began = fitted.problem, fitted.problem.start()
    far = [
        u.recording is None and '.' not in u.name and abs(z - z0) > _FAR * u.prior_spread
        for u, z, z0 in zip(problem.unknowns, fitted.z, began, strict=True)
    ]
    if not any(far):
        return None
    held = tuple(_held(u) if f else u for u, f in zip(problem.unknowns, far, strict=True))
    back = fit(replace(problem, unknowns=held), np.where(far, began, fitted.z), tolerance=1e-5)
    return fit(problem, back.z, rounds=0)


def _held(unknown: Unknown) -> Unknown:
    """It, hardly free to move."""
    start = unknown.to_fit(unknown.start)
    ends = (start - _HELD * unknown.prior_spread, start + _HELD * unknown.prior_spread)
    low, high = (float(np.exp(e)) if unknown.log else e * unknown.spread for e in ends)
    return replace(unknown, low=low, high=high)


def screen(
    fitted: Fit, effects: Sequence[str], progress: Callable[[], None] | None = None
) -> tuple[list[Candidate], dict[str, float]]:
    """Rank effects by the drop of the misfit that they promise.

    Returns the best variant of each effect, best first, and for each effect the largest signal of its variants.
    """
    base, price = Screen.of(fitted), fitted.problem.policy.per_parameter
    back = _brought_back(fitted)
    other = None if back is None else Screen.of(back)
    worse = 0.0 if other is None else other.misfit - base.misfit

    def best(effect: str) -> tuple[Candidate | None, float]:
        if progress:
            progress()
        found, returned = base.candidates(effect), []
        if other is not None:
            returned = [replace(c, begun=other.fit.z) for c in other.candidates(effect)]
            found += [replace(c, gain=max(c.gain - worse, 0.0)) for c in returned]
        if not found:
            return None, 0.0
        first = best_of(found, price)
        if returned and first.begun is None:
            # From where the muscle went, a fit may not find back to where the effect is: tried if it does not.
            best = sorted(returned, key=lambda c: -c.worth(price))[:_RETURNED]
            first = replace(first, others=(*first.others, *best))
        return first, max(c.signal for c in found)

    with ThreadPoolExecutor(_WORKERS) as pool:
        results = list(pool.map(best, effects))
    ranked = sorted((c for c, _ in results if c is not None), key=lambda c: -c.gain)
    return ranked, {effect: signal for effect, (_, signal) in zip(effects, results, strict=True)}

"""A law without a name in words: the simplest of a few physical forms that predicts unseen data best.

A table of few knots hides what tells forms apart, so it is fitted again on more of them, some close to where a law may
begin, end or step. Each form is fitted to the recordings without stretches that are kept back, and judged on these, in
linear approximation around that table: what it does between what was seen, for beyond it a poor form may be lucky. Of
forms that they do not tell apart the one with the fewest numbers is said, the others beside it; none is, where a table
made from it predicts unseen data worse than the fitted one.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from tcp_muscle_ros.diagnosis.answer.law_forms import FORMS, Form, Said, Table, fitted_form
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.model.unknown import Unknown
from tcp_muscle_ros.diagnosis.search.bending import as_well
from tcp_muscle_ros.diagnosis.search.holdout import Fold, held_out, held_out_as, improvement, stretches
from tcp_muscle_ros.diagnosis.search.selected import Selection
from tcp_muscle_ros.muscle import EFFECTS
from tcp_muscle_ros.muscle.arrays import Array, Mask
from tcp_muscle_ros.muscle.edges import inside
from tcp_muscle_ros.muscle.effects.free_law import KELVIN, KNOTS, METRE, UNITS

_FEW = 4  # knots of a table that was fitted, which may have more where its driver was seen everywhere
_CLOSE = 0.03  # of the range: from one knot to the next where a law may begin, end or step
_ROUNDS, _FINER = 8, 10  # in which all else follows a table that is held; in which a finer one is fitted
_WEAK = 1e-3  # of a law's prior, that is kept where recordings say nothing
_CLUSTER = 15.0  # s: stretches over which errors are summed before their scatter is judged
_JUDGED = 3  # forms whose table is run on unseen data, at most
BEYOND = 0.2  # of the range: where a further measurement would tell forms apart
_DENSE = 101  # places over the range, at which levels are compared
_SAME = 0.05  # of what a law does: forms that differ by less there are one


@dataclass(frozen=True)
class Told:
    """The form that is said of a law, the table that it was fitted beside, and the forms that predict as well."""

    said: Said
    table: Table
    others: tuple[Said, ...]


@dataclass(frozen=True)
class _Foretold:
    """What a form, fitted to the rest, misses of unseen data: whitened residuals, and the stretch of each."""

    form: Form
    white: Array
    stretch: Array

    @property
    def misfit(self) -> float:
        return float(np.sum(self.white**2))

    def beaten_by(self, best: '_Foretold', odds: float) -> bool:
        """Whether unseen data tell it from the best: by more than ``odds``, and in more than a few stretches."""
        drops = np.bincount(self.stretch, self.white**2 - best.white**2)
        return bool(drops.sum() > max(odds, float(np.std(drops)) * np.sqrt(drops.size)))


@dataclass(frozen=True)
class _Tried:
    """A form, fitted to all data beside the table that it suits, and what it misses of unseen data."""

    fine: Fit
    table: Table
    said: Said
    left: _Foretold


def told_by_form(selection: Selection, effect: str) -> Told | None:
    """The form of a law that predicts unseen data as well as its table and as any other does; None where none does."""
    if not selection.kept_back:
        return None
    odds = selection.final.problem.policy.told_apart
    found: list[_Tried] = []
    for fine, forms in refined(selection.final, effect):
        table = table_of(fine, effect)
        said = [law for form in forms if (law := fitted_form(form, table)) is not None]
        missed = foretold(fine, effect, stretches(fine.problem), [law.form for law in said])
        found += [_Tried(fine, table, law, left) for law, left in zip(said, missed, strict=True)]
    best = min((one.left for one in found), key=lambda left: left.misfit, default=None)
    if best is None:
        return None
    near = _without_twin([one for one in found if not one.left.beaten_by(best, odds)])
    near.sort(key=lambda one: (one.said.count, one.left.misfit))
    for one in near[:_JUDGED]:
        if _as_good(selection, one.fine, effect, one.said.form):
            others = (other.said for other in near if other is not one)
            beside = tuple(o for o in others if _differ(one.said, o, one.table))
            there = _level_with(selection.final, effect, one.table)
            return Told(there(one.said), one.table, tuple(map(there, beside)))
    return None


def _level_with(fitted: Fit, effect: str, table: Table) -> Callable[[Said], Said]:
    """What puts a form at the level of the fitted table, where the recordings know none: a parameter of the muscle
    takes up a factor, and a floating zero a length."""
    coarse = table_of(fitted, effect)
    x = np.linspace(table.at[0], table.at[-1], _DENSE)
    curves = (np.array([CubicSpline(t.at, mine, bc_type='natural')(x) for mine in t.values]) for t in (coarse, table))
    wanted, has = (float(np.mean(values)) for values in curves)
    factor = (1.0 + wanted) / (1.0 + has) if table.relative else 1.0
    added = factor - 1.0 if table.relative else (wanted - has) * (unit_of(effect) == METRE)

    def level(said: Said) -> Said:
        first = np.arange(said.coefficients.shape[1]) == 0
        return replace(said, coefficients=factor * said.coefficients + added * first)

    return level


def _without_twin(near: list[_Tried]) -> list[_Tried]:
    """Without the limit that is a threshold: where a parameter of the muscle takes up a straight line, a law that ends
    at a place is one that begins there."""
    at = {one.said.form.name: one.said.number for one in near if one.said.form.inside}
    twins = {'threshold', 'until'} <= set(at) and abs(at['threshold'] - at['until']) < _CLOSE
    return [one for one in near if not twins or one.said.form.name != 'until']


def _differ(said: Said, other: Said, table: Table) -> bool:
    """Whether two forms differ where nobody has measured yet."""
    return apart(said, other, table)[1] > _SAME * float(np.ptp(said.values(table, table.at)))


def apart(said: Said, other: Said, table: Table) -> tuple[float, float]:
    """Where two forms differ the most a little beyond the range, and by how much."""
    beyond = BEYOND * table.span
    where = np.array([table.at[-1] + beyond, table.at[0] - beyond])
    if table.at[0] - beyond < table.origin:  # where there is no law, or the room is colder than it is
        where = where[:1]
    gaps = np.max(np.abs(said.values(table, where) - other.values(table, where)), axis=0)
    return float(where[np.argmax(gaps)]), float(gaps.max())


def _as_good(selection: Selection, fine: Fit, effect: str, form: Form) -> bool:
    """Whether a form predicts unseen data as well as the table that was fitted does."""
    kept_back = selection.kept_back
    by_table = held_out(selection.final, kept_back)
    by_form = held_out_as(fine, kept_back, lambda trained: held_to(trained, effect, form))
    # Nor may unseen data confirm the table over the form, as they confirm an effect.
    better = improvement(by_form, by_table, whole=kept_back[0].whole is not None)
    return as_well(by_table, by_form) and not better.holds


def driver_of(fitted: Fit, effect: str) -> str:
    """Over what a fitted law is a table."""
    free = EFFECTS[effect].free
    assert free is not None
    return tuple(free.drivers)[round(fitted.muscle[f'{effect}.driver'])]


def unit_of(effect: str) -> str:
    """Of the values of a law."""
    return next(column.unit for column in EFFECTS[effect].columns if column.name == 'value')


def places_of(fitted: Fit, effect: str) -> list[list[int]]:
    """Where the values of a law are among the unknowns, curve by curve."""
    unknowns = fitted.problem.unknowns
    curves = [
        [k for k, u in enumerate(unknowns) if u.name.startswith(f'{effect}.{column.name}_')]
        for column in EFFECTS[effect].columns
        if not column.rising
    ]
    return [mine for mine in curves if mine]


def table_of(fitted: Fit, effect: str) -> Table:
    """The table of a law as it was fitted, and what all data say of it."""
    count = fitted.jacobian.shape[0]
    return _Linear.of(fitted, effect).table(np.ones(count, dtype=bool))


def refined(fitted: Fit, effect: str) -> list[tuple[Fit, list[Form]]]:
    """The fit with as many knots as a table may have, and the forms that suit these: even ones, and some close to where
    the best of those forms that begin, end or step does so. As it is where its driver was seen at few levels."""
    at, smooth, sudden = _knots(fitted, effect), [f for f in FORMS if not f.inside], [f for f in FORMS if f.inside]
    if at.size < _FEW:
        return [(fitted, [*smooth, *sudden])]
    even = _on(fitted, effect, np.linspace(at[0], at[-1], KNOTS))
    table = table_of(even, effect)
    best = min((s for form in sudden if (s := fitted_form(form, table)) is not None), key=lambda said: said.misfit)
    place, close = table.origin + best.number * table.span, _CLOSE * table.span
    coarse = np.linspace(at[0], at[-1], KNOTS - 3)
    around = place + close * np.array([-1.0, 0.0, 1.0])
    kept = coarse[np.abs(coarse - place) > 2.0 * close]
    inner = around[(around > at[0] + 0.5 * close) & (around < at[-1] - 0.5 * close)]
    uneven = np.unique(np.concatenate([kept, inner, at[[0, -1]]]))
    return [(even, smooth), (_on(even, effect, uneven), sudden)]


def _knots(fitted: Fit, effect: str) -> Array:
    count = len(places_of(fitted, effect)[0])
    return np.array([fitted.muscle[f'{effect}.at_{k + 1}'] for k in range(count)])


def _on(fitted: Fit, effect: str, at: Array) -> Fit:
    """The fit with a law's table on other knots."""
    problem, before, z = fitted.problem, _knots(fitted, effect), fitted.z
    given: dict[str, tuple[float, ...]] = {f'{effect}.at': tuple(map(float, at))}
    added: list[Unknown] = []
    begun: list[float] = []
    curves = places_of(fitted, effect)
    for places in curves:
        old = [problem.unknowns[k] for k in places]
        values = [u.from_fit(float(z[k])) for u, k in zip(old, places, strict=True)]
        there = CubicSpline(before, values, bc_type='natural')(at)
        array = old[0].name.rpartition('_')[0]
        given[array] = tuple(float(y) for y in there)
        fresh = [replace(old[0], name=f'{array}_{k + 1}') for k in range(at.size)]
        added += fresh
        begun += [u.to_fit(min(max(float(y), u.low), u.high)) for u, y in zip(fresh, there, strict=True)]
    rest = np.setdiff1d(np.arange(z.size), np.concatenate(curves))
    unknowns = (*(problem.unknowns[k] for k in rest), *added)
    parameters = problem.parameters.replace(inside(given))
    start = np.concatenate([z[rest], begun])
    return fit(replace(problem, parameters=parameters, unknowns=unknowns), start, rounds=_FINER, tolerance=1e-5)


@dataclass(frozen=True)
class _Linear:
    """A fit in linear approximation: residual (m,) and its slopes by the table (``own``) and by all else (``rest``),
    per unit of the fit's coordinates; ``spreads`` and ``z`` of both."""

    residual: Array
    own: Array
    rest: Array
    own_spreads: Array
    rest_spreads: Array
    rest_away: Array  # from where the priors have it
    blank: Table

    @classmethod
    def of(cls, fitted: Fit, effect: str, held: Sequence[int] = ()) -> '_Linear':
        """``held``: the unknowns that stay as they are."""
        problem, curves = fitted.problem, places_of(fitted, effect)
        places = np.concatenate(curves).astype(int)
        rest = np.setdiff1d(np.arange(fitted.z.size), [*places, *held]).astype(int)
        values = np.array([[problem.unknowns[k].from_fit(float(fitted.z[k])) for k in mine] for mine in curves])
        at = _knots(fitted, effect)
        room = float(np.mean([np.mean(e.imposed.ambient) for e in problem.experiments]))
        # A temperature counts from the room; what stays far from nothing, as a length does, from where it begins.
        zero = 0.0 if at[0] < at[-1] - at[0] else float(at[0])
        origin = room if UNITS[driver_of(fitted, effect)] == KELVIN else zero
        size = places.size
        blank = Table(at, values, np.zeros((size, size)), np.zeros(size), origin, unit_of(effect) == '1')
        spreads = problem.spreads()
        scale = np.array([problem.unknowns[k].spread for k in places])
        return cls(
            np.concatenate(fitted.residuals),
            fitted.jacobian[:, places] / scale,
            fitted.jacobian[:, rest],
            scale,
            spreads[rest],
            (fitted.z - problem.start())[rest],
            blank,
        )

    def following(self, rows: Mask) -> tuple[Array, Array]:
        """How all else, fitted to these rows, follows the values of a table: where it goes by itself, and by how much a
        value moves it."""
        rest, weights = self.rest[rows], self.rest_spreads**-2.0
        normal = rest.T @ rest + np.diag(weights)
        pulls = np.column_stack([rest.T @ self.residual[rows] + weights * self.rest_away, rest.T @ self.own[rows]])
        moved = -np.linalg.solve(normal, pulls)
        return moved[:, 0], moved[:, 1:]

    def table(self, rows: Mask) -> Table:
        """What these rows say of the table, all else following."""
        itself, moved = self.following(rows)
        left = self.residual[rows] + self.rest[rows] @ itself
        shown = self.own[rows] + self.rest[rows] @ moved
        weights = self.rest_spreads**-2.0
        firm = _WEAK * self.own_spreads**-2.0
        information = shown.T @ shown + moved.T @ (weights[:, None] * moved) + np.diag(firm)
        pull = shown.T @ left + moved.T @ (weights * (self.rest_away + itself)) + firm * self.blank.values.ravel()
        return replace(self.blank, information=information, pull=pull)

    def missed(self, rows: Mask, seen: Mask, values: Array) -> Array:
        """The residuals of these rows by a table with other values, all else fitted to the rows that were ``seen``."""
        itself, moved = self.following(seen)
        off = values.ravel() - self.blank.values.ravel()
        return np.asarray(self.residual[rows] + self.own[rows] @ off + self.rest[rows] @ (itself + moved @ off))


def foretold(fine: Fit, effect: str, kept_back: tuple[Fold, ...], forms: Sequence[Form]) -> list[_Foretold]:
    """What each form misses of unseen data."""
    white: dict[str, list[Array]] = {form.name: [] for form in forms}
    stretch = []
    used = 0
    for fold in kept_back:
        rows, labels = _rows(fine, fold)
        # What belongs to the recording that is kept back whole, and where each begins, is no property of the muscle.
        held = [
            k
            for k, u in enumerate(fine.problem.unknowns)
            if u.state or (u.recording is not None and u.recording == fold.whole)
        ]
        linear = _Linear.of(fine, effect, held)
        table = linear.table(~rows)
        for form in forms:
            said = fitted_form(form, table)
            assert said is not None
            white[form.name].append(linear.missed(rows, ~rows, said.tabled(table)))
        stretch.append(np.unique(labels[rows], return_inverse=True)[1] + used)
        used = int(stretch[-1].max(initial=used - 1)) + 1
    return [_Foretold(form, np.concatenate(white[form.name]), np.concatenate(stretch)) for form in forms]


def _rows(fine: Fit, fold: Fold) -> tuple[Mask, Array]:
    """Which residuals a fold keeps back, and of each the stretch of time that it is of."""
    kept: list[Mask] = []
    labels: list[Array] = []
    for k, experiment in enumerate(fine.problem.experiments):
        mine = [(a, b) for recording, a, b in fold.stretches if recording == k]
        for number, observed in enumerate(experiment.observed.values()):
            within = [(observed.time >= a) & (observed.time <= b) for a, b in mine]
            kept.append(np.any(within, axis=0) if within else np.zeros(observed.time.size, dtype=bool))
            label = np.floor((observed.time - observed.time[0]) / _CLUSTER).astype(int)
            labels.append(label + 100_000 * (number + 100 * k))
        kept.append(np.array([False]))  # what keeps the muscle within what it survives is no data
        labels.append(np.array([-1]))
    return np.concatenate(kept), np.concatenate(labels)


def held_to(fitted: Fit, effect: str, form: Form) -> Array:
    """The unknowns of a fit with its table held to a form (its numbers as that table has them), all else following."""
    linear = _Linear.of(fitted, effect)
    every = np.ones(linear.residual.size, dtype=bool)
    said = fitted_form(form, table := linear.table(every))
    assert said is not None
    problem, z = fitted.problem, np.array(fitted.z)
    places = np.concatenate(places_of(fitted, effect)).astype(int)
    held: dict[str, float] = {}
    for k, value in zip(places, said.tabled(table).ravel(), strict=True):
        unknown = problem.unknowns[k]
        held[unknown.name] = min(max(float(value), unknown.low), unknown.high)
        z[k] = unknown.to_fit(held[unknown.name])
    kept = np.setdiff1d(np.arange(z.size), places)
    itself, moved = linear.following(every)
    begun = z[kept] + itself + moved @ (said.tabled(table) - table.values).ravel()
    unknowns = tuple(problem.unknowns[k] for k in kept)
    rest = replace(problem, parameters=problem.parameters.replace(held), unknowns=unknowns)
    known = fitted.rough_slopes
    left = None if known is None else [{name: mine[:, kept] for name, mine in shown.items()} for shown in known]
    z[kept] = fit(rest, _within(unknowns, begun), rounds=_ROUNDS, tolerance=1e-4, known=left).z
    return np.asarray(z)


def _within(unknowns: Sequence[Unknown], z: Array) -> Array:
    """Coordinates inside the bounds of their unknowns."""
    return np.array([u.to_fit(u.from_fit(float(at))) for u, at in zip(unknowns, z, strict=True)])

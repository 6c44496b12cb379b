"""A law without a name in words: the sparsest of a few physical forms that predicts unseen data as well as its table.

Each form is c + b g(x), with one number of its own in g at most, so that it is found by weighted linear least squares
(the covariance of the values at the knots) along that number. Heating and cooling share it. A form is said only where a
table made from it, its numbers fitted without the unseen data as those of the fitted table are, is as good on these.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.search.bending import as_well
from tcp_muscle_ros.diagnosis.search.holdout import held_out, held_out_as, improvement
from tcp_muscle_ros.diagnosis.search.selected import Selection
from tcp_muscle_ros.muscle import EFFECTS
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.free_law import KELVIN, UNITS
from tcp_muscle_ros.settings.policy import Policy

STEP = 0.06  # of the range: a step's, narrower than which a table of four knots shows none
_INSIDE = 0.05  # of the range, from its ends: where a law may begin, end or step
_TRIED = 61  # numbers of a form, before the best is refined
_ANY_SCALE = 10.0  # standard deviation of a factor that a parameter of the muscle takes up
_FIRM = 1e6  # how firmly a form has the mean of a relative table, in its values
_ROUNDS = 8  # in which all else follows a table that is held


@dataclass(frozen=True)
class Form:
    """A shape g(v, number) over the driver in units of its range, counted from where it is nothing (``origin``);
    ``between``: where the number lies: ``inside`` the range, or between two; None where there is none."""

    name: str
    shape: Callable[[Array, float], Array] | None
    between: tuple[float, float] | None = None
    inside: bool = False

    @property
    def own(self) -> bool:
        """Whether there is a number in it."""
        return self.inside or self.between is not None

    def columns(self, v: Array, number: float) -> Array:
        """What b and c are multiplied by, shape (m, 1 or 2)."""
        parts = [np.ones(v.size)] if self.shape is None else [np.ones(v.size), self.shape(v, number)]
        return np.column_stack(parts)


FORMS = (
    Form('constant', None),
    Form('linear', lambda v, _: v),
    Form('square', lambda v, _: v**2),
    Form('power', lambda v, p: np.sign(v) * np.abs(v) ** p, (0.3, 4.0)),
    Form('exponential', lambda v, s: np.exp((v - v.max()) / s), (0.1, 1.0)),
    Form('saturation', lambda v, s: -np.exp((v.min() - v) / s), (0.1, 1.0)),
    Form('threshold', lambda v, a: np.maximum(v - a, 0.0), inside=True),
    Form('until', np.minimum, inside=True),
    Form('step', lambda v, a: 0.5 + 0.5 * np.tanh(0.5 * (v - a) / STEP), inside=True),
)


@dataclass(frozen=True)
class Table:
    """A fitted table: ``at`` (m,), ``values`` (curves, m) and their ``covariance``; ``places`` of these among the
    unknowns, in that order; the driver counts from ``origin``; ``relative``: it multiplies a parameter, by 1 + f."""

    at: Array
    values: Array
    covariance: Array
    places: tuple[int, ...]
    origin: float
    relative: bool

    @property
    def span(self) -> float:
        """How far the driver goes."""
        return float(self.at[-1] - self.at[0])

    def scaled(self, x: Array) -> Array:
        """The driver from its origin, in units of its range."""
        return np.asarray((x - self.origin) / self.span)


@dataclass(frozen=True)
class Said:
    """A form that was fitted to a table: its number, its coefficients (curves, 1 or 2), what it misses, its score."""

    form: Form
    number: float
    coefficients: Array
    misfit: float
    score: float

    @property
    def count(self) -> int:
        """How many numbers it has."""
        return self.coefficients.size + self.form.own

    def values(self, table: Table, x: Array) -> Array:
        """The law at ``x``, shape (curves, x)."""
        ends = table.scaled(np.concatenate([table.at[[0, -1]], x]))  # some shapes count from the ends
        return np.asarray(self.coefficients @ self.form.columns(ends, self.number)[2:].T)


def told_by_form(selection: Selection, effect: str) -> tuple[Said, Table] | None:
    """The form that predicts unseen data as well as the fitted table of a law does; None where none does."""
    final = selection.final
    table, policy = table_of(final, effect), final.problem.policy
    most = sparsest(table, policy)
    if most is None or not selection.kept_back:
        return None
    found = sorted(_fitted(table, policy), key=lambda said: said.score)
    # Of as many numbers the best: how a curve between few knots misses a form may be more than the recordings tell.
    for count in range(2, most.count):
        simpler = next((said for said in found if said.count == count), None)
        if simpler is not None and _as_good(selection, effect, simpler.form):
            return simpler, table
    return (most, table) if _as_good(selection, effect, most.form) else None


def _as_good(selection: Selection, effect: str, form: Form) -> bool:
    """Whether a form predicts unseen data as well as the table does."""
    by_table = held_out(selection.final, selection.kept_back)
    by_form = held_out_as(selection.final, selection.kept_back, lambda trained: held_to(trained, effect, form))
    # Nor may unseen data confirm the table over the form, as they confirm an effect.
    better = improvement(by_form, by_table, whole=selection.kept_back[0].whole is not None)
    return as_well(by_table, by_form) and not better.holds


def table_of(fitted: Fit, effect: str) -> Table:
    """The table of a law as it was fitted."""
    unknowns = fitted.problem.unknowns
    places: list[int] = []
    curves = 0
    for column in EFFECTS[effect].columns:
        mine = [k for k, u in enumerate(unknowns) if u.name.startswith(f'{effect}.{column.name}_')]
        if mine:
            places, curves = [*places, *mine], curves + 1
    count = len(places) // curves
    at = np.array([fitted.muscle[f'{effect}.at_{k + 1}'] for k in range(count)])
    spreads = np.array([unknowns[k].spread for k in places])
    values = np.array([unknowns[k].from_fit(float(fitted.z[k])) for k in places]).reshape(curves, count)
    covariance = fitted.covariance[np.ix_(places, places)] * np.outer(spreads, spreads)
    room = float(np.mean([np.mean(e.imposed.ambient) for e in fitted.problem.experiments]))
    # A temperature counts from the room; what stays far from nothing, as a length does, from where it begins.
    zero = 0.0 if at[0] < at[-1] - at[0] else float(at[0])
    origin = room if UNITS[driver_of(fitted, effect)] == KELVIN else zero
    return Table(at, values, covariance, tuple(places), origin, unit_of(effect) == '1')


def driver_of(fitted: Fit, effect: str) -> str:
    """Over what a fitted law is a table."""
    free = EFFECTS[effect].free
    assert free is not None
    return tuple(free.drivers)[round(fitted.muscle[f'{effect}.driver'])]


def unit_of(effect: str) -> str:
    """Of the values of a law."""
    return next(column.unit for column in EFFECTS[effect].columns if column.name == 'value')


def sparsest(table: Table, policy: Policy) -> Said | None:
    """The form with the fewest numbers: a further one lowers the misfit by as much as an effect does at least. None
    where the table has too few knots to tell any."""
    found = _fitted(table, policy)
    best = min((said.score for said in found), default=0.0)
    near = [said for said in found if said.score <= best + policy.least_drop]
    return min(near, key=lambda said: (said.count, said.score), default=None)


def alike(said: Said, table: Table, policy: Policy) -> tuple[str, ...]:
    """The other forms that the table does not tell from this one."""
    near = [other for other in _fitted(table, policy) if other.score < said.score + policy.told_apart]
    return tuple(other.form.name for other in near if other.form.name != said.form.name)


def _fitted(table: Table, policy: Policy) -> list[Said]:
    return [said for form in FORMS if (said := fitted_form(form, table, policy.per_parameter)) is not None]


def fitted_form(form: Form, table: Table, price: float = 0.0) -> Said | None:
    """A form through a table; None where it has as many numbers as the table has knots."""
    v, (curves, knots) = table.scaled(table.at), table.values.shape
    whiten = _whitening(table)
    seen = whiten @ table.values.ravel()

    def solved(number: float) -> tuple[float, Array]:
        design = whiten @ np.kron(np.eye(curves), form.columns(v, number))
        coefficients: Array = np.linalg.lstsq(design, seen, rcond=None)[0].astype(np.float64)
        return float(np.sum((seen - design @ coefficients) ** 2)), coefficients.reshape(curves, -1)

    number = 0.0
    if form.columns(v, 0.5).shape[1] + form.own >= knots:
        return None
    if form.own:
        low, high = form.between or (v[0] + _INSIDE, v[-1] - _INSIDE)
        numbers = np.linspace(low, high, _TRIED)
        k = int(np.argmin([solved(n)[0] for n in numbers]))
        around = numbers[max(k - 1, 0)], numbers[min(k + 1, _TRIED - 1)]
        number = float(minimize_scalar(lambda n: solved(n)[0], bounds=around, method='bounded').x)
    misfit, coefficients = solved(number)
    return Said(form, number, coefficients, misfit, misfit + price * (coefficients.size + form.own))


def _whitening(table: Table) -> Array:
    """What makes the errors of the values independent and of size one, shape (m, values).

    Of 1 + f the recordings know no factor: a parameter takes it up. A form that were free in it would shrink to no
    law at all, where nothing misses; so it has the mean of the table, and may miss it by any factor.
    """
    covariance, size = table.covariance, table.values.size
    if table.relative:
        whole = 1.0 + table.values.ravel()
        covariance = covariance + _ANY_SCALE**2 * np.outer(whole, whole)
    white = np.linalg.inv(np.linalg.cholesky(covariance))
    return np.vstack([white, np.full((1, size), _FIRM / size)]) if table.relative else white


def held_to(fitted: Fit, effect: str, form: Form) -> Array:
    """The unknowns of a fit with its table held to a form (its numbers as that table has them), all else following."""
    table = table_of(fitted, effect)
    said = fitted_form(form, table)
    assert said is not None
    problem, z = fitted.problem, np.array(fitted.z)
    held: dict[str, float] = {}
    for k, value in zip(table.places, said.values(table, table.at).ravel(), strict=True):
        unknown = problem.unknowns[k]
        held[unknown.name] = min(max(float(value), unknown.low), unknown.high)
        z[k] = unknown.to_fit(held[unknown.name])
    kept = np.setdiff1d(np.arange(z.size), table.places)
    rest = replace(
        problem, parameters=problem.parameters.replace(held), unknowns=tuple(problem.unknowns[k] for k in kept)
    )
    known = fitted.rough_slopes
    left = None if known is None else [{name: mine[:, kept] for name, mine in shown.items()} for shown in known]
    z[kept] = fit(rest, z[kept], rounds=_ROUNDS, tolerance=1e-4, known=left).z
    return np.asarray(z)

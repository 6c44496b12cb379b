"""The forms that a law without a name may have, and their fit to what recordings say of its table.

Each form is c + b g(x), with one number of its own in g at most, so that it is found by linear least squares along that
number. Near the fitted table the misfit of the recordings is quadratic in its values, all else following: that is what
a form is fitted to, and so to the recordings themselves. Heating and cooling share a form.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from tcp_muscle_ros.muscle.arrays import Array

STEP = 0.06  # of the range: a step's, narrower than which a table shows none
_INSIDE = 0.05  # of the range, from its ends: where a law may begin, end or step
_TRIED = 61  # numbers of a form, before the best is refined
_FIRM = 1e6  # how firmly a form has the mean of a relative table, in its values
_DENSE = 201  # places over the range, over which a table follows a form


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
    Form('cube', lambda v, _: v**3),
    Form('power', lambda v, p: np.sign(v) * np.abs(v) ** p, (0.3, 4.0)),
    Form('exponential', lambda v, s: np.exp((v - v.max()) / s), (0.1, 1.0)),
    Form('saturation', lambda v, s: -np.exp((v.min() - v) / s), (0.1, 1.0)),
    Form('threshold', lambda v, a: np.maximum(v - a, 0.0), inside=True),
    Form('until', np.minimum, inside=True),
    Form('step', lambda v, a: 0.5 + 0.5 * np.tanh(0.5 * (v - a) / STEP), inside=True),
)


@dataclass(frozen=True)
class Table:
    """A fitted table and what the recordings say of it: ``at`` (m,), ``values`` (curves, m); the misfit that other
    values add is d' ``information`` d + 2 ``pull``' d, where they differ by d. The driver counts from ``origin``;
    ``relative``: the law multiplies a parameter, by 1 + f."""

    at: Array
    values: Array
    information: Array
    pull: Array
    origin: float
    relative: bool

    @property
    def span(self) -> float:
        """How far the driver goes."""
        return float(self.at[-1] - self.at[0])

    def scaled(self, x: Array) -> Array:
        """The driver from its origin, in units of its range."""
        return np.asarray((x - self.origin) / self.span)

    @cached_property
    def _dense(self) -> Array:
        """The range, in units of itself."""
        return self.scaled(np.linspace(self.at[0], self.at[-1], _DENSE))

    @cached_property
    def _nearest(self) -> Array:
        """What makes of a curve over the range the values of the natural spline that is nearest to it."""
        x = np.linspace(self.at[0], self.at[-1], _DENSE)
        splines = [CubicSpline(self.at, one, bc_type='natural')(x) for one in np.eye(self.at.size)]
        return np.asarray(np.linalg.pinv(np.column_stack(splines)))

    def columns(self, form: Form, number: float) -> Array:
        """A form's columns as a table has them: as near to it over the range as its spline goes."""
        return np.asarray(self._nearest @ form.columns(self._dense, number))


@dataclass(frozen=True)
class Said:
    """A form that was fitted: its number, its coefficients (curves, 1 or 2), and what it misses more than the table
    does."""

    form: Form
    number: float
    coefficients: Array
    misfit: float

    @property
    def count(self) -> int:
        """How many numbers it has."""
        return self.coefficients.size + self.form.own

    def values(self, table: Table, x: Array) -> Array:
        """The law at ``x``, shape (curves, x)."""
        ends, own = table.scaled(table.at[[0, -1]]), table.scaled(x)
        if self.form.name in ('exponential', 'saturation'):  # which count from the ends, also beyond them
            end = ends.max() if self.form.name == 'exponential' else ends.min()
            sign = 1.0 if self.form.name == 'exponential' else -1.0
            shape = np.column_stack([np.ones(own.size), sign * np.exp(sign * (own - end) / self.number)])
        else:
            shape = self.form.columns(own, self.number)
        return np.asarray(self.coefficients @ shape.T)

    def tabled(self, table: Table) -> Array:
        """The values of a table that is nearest to it, shape (curves, m)."""
        return np.asarray(self.coefficients @ table.columns(self.form, self.number).T)


def fitted_form(form: Form, table: Table) -> Said | None:
    """A form through a table; None where it has as many numbers as the table has knots.

    Of 1 + f the recordings know no factor: a parameter takes it up. A form that were free in it would shrink to no law
    at all, where nothing misses; so it has the mean of the table.
    """
    v, (curves, knots) = table.scaled(table.at), table.values.shape
    seen, information = table.values.ravel(), table.information
    if table.relative:
        information = information + (_FIRM / seen.size) ** 2
    wanted = information @ seen - table.pull

    def solved(number: float) -> tuple[float, Array]:
        design = np.kron(np.eye(curves), table.columns(form, number))
        normal = design.T @ information @ design
        coefficients: Array = np.linalg.lstsq(normal, design.T @ wanted, rcond=None)[0].astype(np.float64)
        off = design @ coefficients - seen
        return float(off @ information @ off + 2.0 * table.pull @ off), coefficients.reshape(curves, -1)

    number = 0.0
    if (2 if form.shape else 1) + form.own >= knots:
        return None
    if form.own:
        low, high = form.between or (v[0] + _INSIDE, v[-1] - _INSIDE)
        numbers = np.linspace(low, high, _TRIED)
        k = int(np.argmin([solved(n)[0] for n in numbers]))
        around = numbers[max(k - 1, 0)], numbers[min(k + 1, _TRIED - 1)]
        number = float(minimize_scalar(lambda n: solved(n)[0], bounds=around, method='bounded').x)
    misfit, coefficients = solved(number)
    return Said(form, number, coefficients, misfit)

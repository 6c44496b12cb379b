"""Step the muscle: the paper's model by its exact solution, with effects by Runge-Kutta over all states together.

The same compiled functions step one tick, a recording, many muscles and many parameter variants.
Arrays: ``x`` state, ``u`` imposed, ``p`` parameters (``Parameters.vector``), ``on`` effects (``Parameters.mask``),
``y`` what is shown; ``q``, ``work`` scratch. Their places are named in ``quantities.py``.
"""

from math import ceil

import numpy as np

from tcp_muscle_ros.muscle.arrays import Array, Mask
from tcp_muscle_ros.muscle.compiled import entry, inner
from tcp_muscle_ros.muscle.composition import hooks_at
from tcp_muscle_ros.muscle.effects import EFFECTS
from tcp_muscle_ros.muscle.electrical import VOLTAGE, joule_heating, resistance_at, source_current
from tcp_muscle_ros.muscle.mechanical import DOMAIN_HIGH, DOMAIN_LOW, contraction_coefficient, modulus_ratio
from tcp_muscle_ros.muscle.quantities import (
    AMBIENT,
    CAPACITY,
    CONDUCTANCE,
    CURRENT,
    DRIVE,
    DRIVING_TEMPERATURE,
    ELASTIC,
    EXTRA,
    FORCE,
    GAIN,
    HEAT,
    HEATING,
    IN_AMBIENT,
    IN_COMPLIANCE,
    IN_DRIVE,
    IN_HELD,
    IN_KIND,
    IN_LOAD,
    IN_WALL,
    IN_ZERO,
    LENGTH,
    N_OUTPUTS,
    N_QUANTITIES,
    N_STATES,
    RATIO,
    RESISTANCE,
    SHOWN_FORCE,
    SHOWN_LENGTH,
    SHOWN_RESISTANCE,
    SHOWN_TEMPERATURE,
    SLACK,
    STIFFNESS,
    TEMPERATURE,
    TIME,
    X_HEATED,
    X_LOST,
    X_TEMPERATURE,
    X_TIME,
    Y_CURRENT,
    Y_DISPLACEMENT,
    Y_FIBRE_TEMPERATURE,
    Y_FORCE,
    Y_IN_DOMAIN,
    Y_LENGTH,
    Y_POWER,
    Y_RESISTANCE,
    Y_SLACK,
    Y_TEMPERATURE,
    Y_VOLTAGE,
)
from tcp_muscle_ros.muscle.table import INDEX
from tcp_muscle_ros.muscle.thermal import exact_step

_K0, _H0, _B, _T0, _HA, _C, _FASTEST = (INDEX[name] for name in ('k0', 'H0', 'B', 'T0', 'hA', 'C', 'fastest_rate'))
_SWITCHING = np.array(['commit' in effect.hooks for effect in EFFECTS.values()], dtype=np.bool_)
# A substep resolves a tenth of the quickest time constant: the Runge-Kutta error is then below 1e-6 of a change.
_SUBSTEP = 0.1
STATE_SIZE = N_STATES + sum(len(effect.states) for effect in EFFECTS.values())

_surroundings = hooks_at('surroundings')
_softening = hooks_at('softening')
_contraction = hooks_at('contraction')
_extra = hooks_at('extra')
_elasticity = hooks_at('elasticity')
_resistance = hooks_at('resistance')
_drive = hooks_at('drive')
_heat = hooks_at('heat')
_rates = hooks_at('rates')
_sensor = hooks_at('sensor')
_initial = hooks_at('initial')
_commit = hooks_at('commit')


@inner
def _length_under(force: float, p: Array, on: Mask, q: Array, x: Array, dx: Array) -> float:
    """The length (m) under a tension (N): H0 + thermal + elastic + extra. Equation 17, corrected."""
    q[FORCE] = force
    q[DRIVING_TEMPERATURE] = q[TEMPERATURE]
    q[GAIN] = p[_B]
    _contraction(q, p, on, x, dx)
    q[EXTRA] = 0.0
    _extra(q, p, on, x, dx)
    q[ELASTIC] = force / q[STIFFNESS]
    _elasticity(q, p, on, x, dx)
    driving = q[DRIVING_TEMPERATURE]
    thermal = q[GAIN] * contraction_coefficient(p, driving) * (driving - p[_T0])
    total: float = p[_H0] + thermal + q[ELASTIC] + q[EXTRA]
    return total


@inner
def _hold(wall: float, compliance: float, p: Array, on: Mask, q: Array, x: Array, dx: Array) -> None:
    """The tension at which muscle plus spring fill the distance: length(F) + F * compliance = wall, F >= 0.

    A muscle cannot push: where it is longer than the distance it hangs slack with F = 0.
    """
    low, below = 0.0, _length_under(0.0, p, on, q, x, dx) - wall
    if below >= 0.0:
        q[SLACK] = 1.0
        q[LENGTH] = wall
        return
    slope = 1.0 / q[STIFFNESS] + compliance
    high = -below / slope
    above = _length_under(high, p, on, q, x, dx) + high * compliance - wall
    for _ in range(60):  # widen until the root is enclosed; the linear muscle is there at once
        if above >= -1e-15:
            break
        low, below = high, above
        high *= 2.0
        above = _length_under(high, p, on, q, x, dx) + high * compliance - wall
    force, error = high, above
    for _ in range(100):  # false position (Illinois)
        if abs(error) <= 1e-15 or high - low <= 1e-15 * high:
            break
        force = (low * above - high * below) / (above - below)
        error = _length_under(force, p, on, q, x, dx) + force * compliance - wall
        if error > 0.0:
            high, above = force, error
            below *= 0.5
        else:
            low, below = force, error
            above *= 0.5
    q[LENGTH] = wall - force * compliance


@inner
def _evaluate(x: Array, u: Array, p: Array, on: Mask, q: Array, dx: Array) -> None:
    """Fill ``q`` from the surroundings to the heating, for the present state and input."""
    temperature = x[X_TEMPERATURE]
    q[TIME] = x[X_TIME]
    q[TEMPERATURE] = temperature
    q[AMBIENT] = u[IN_AMBIENT]
    _surroundings(q, p, on, x, dx)
    q[RATIO] = modulus_ratio(p, temperature)
    _softening(q, p, on, x, dx)
    q[STIFFNESS] = p[_K0] * q[RATIO]
    q[SLACK] = 0.0
    if u[IN_HELD] > 0.0:
        _hold(u[IN_WALL], u[IN_COMPLIANCE], p, on, q, x, dx)
    else:
        q[LENGTH] = _length_under(u[IN_LOAD], p, on, q, x, dx)
    q[RESISTANCE] = resistance_at(p, temperature)
    _resistance(q, p, on, x, dx)
    q[DRIVE] = u[IN_DRIVE]
    _drive(q, p, on, x, dx)
    q[CURRENT] = source_current(u[IN_KIND], q[DRIVE], q[RESISTANCE])
    q[HEATING] = joule_heating(u[IN_KIND], q[DRIVE], q[RESISTANCE])


@inner
def _derivative(x: Array, u: Array, p: Array, on: Mask, q: Array, dx: Array) -> None:
    """dx/dt of all states. Equation 1 with whatever the effects add."""
    _evaluate(x, u, p, on, q, dx)
    q[CONDUCTANCE] = p[_HA]
    q[CAPACITY] = p[_C]
    q[HEAT] = 0.0
    _heat(q, p, on, x, dx)
    lost = q[CONDUCTANCE] * (q[TEMPERATURE] - q[AMBIENT]) - q[HEAT]
    dx[X_TIME] = 1.0
    dx[X_TEMPERATURE] = (q[HEATING] - lost) / q[CAPACITY]
    dx[X_HEATED] = q[HEATING]
    dx[X_LOST] = lost
    _rates(q, p, on, x, dx)


@inner
def _runge_kutta(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array, dt: float) -> None:
    """One classical fourth-order step of all states."""
    k1, k2, k3, k4, middle = work[0], work[1], work[2], work[3], work[4]
    n = x.size
    _derivative(x, u, p, on, q, k1)
    for j in range(n):
        middle[j] = x[j] + 0.5 * dt * k1[j]
    _derivative(middle, u, p, on, q, k2)
    for j in range(n):
        middle[j] = x[j] + 0.5 * dt * k2[j]
    _derivative(middle, u, p, on, q, k3)
    for j in range(n):
        middle[j] = x[j] + dt * k3[j]
    _derivative(middle, u, p, on, q, k4)
    for j in range(n):
        x[j] += dt / 6.0 * (k1[j] + 2.0 * (k2[j] + k3[j]) + k4[j])


@inner
def _advance(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array, dt: float) -> None:
    """Advance the state by ``dt`` (s) under the imposed ``u``, constant over the step."""
    plain, switching = True, False
    for k in range(on.size):
        if on[k]:
            plain = False
            switching = switching or _SWITCHING[k]
    if plain and u[IN_KIND] != VOLTAGE:
        after, heated, lost = exact_step(p, u[IN_KIND], u[IN_DRIVE], u[IN_AMBIENT], x[X_TEMPERATURE], dt)
        x[X_TIME] += dt
        x[X_TEMPERATURE] = after
        x[X_HEATED] += heated
        x[X_LOST] += lost
        return
    substeps = max(1, ceil(dt * p[_FASTEST] / _SUBSTEP))
    for _ in range(substeps):
        _runge_kutta(x, u, p, on, q, work, dt / substeps)
        if switching:
            _evaluate(x, u, p, on, q, work[0])
            _commit(q, p, on, x, work[0])


@inner
def _observe(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array, y: Array) -> None:
    """What is shown at this instant with this drive applied. No time passes."""
    dx = work[0]
    _evaluate(x, u, p, on, q, dx)
    q[SHOWN_TEMPERATURE] = q[TEMPERATURE]
    q[SHOWN_RESISTANCE] = q[RESISTANCE]
    q[SHOWN_LENGTH] = q[LENGTH]
    q[SHOWN_FORCE] = q[FORCE]
    _sensor(q, p, on, x, dx)
    y[Y_TEMPERATURE] = q[SHOWN_TEMPERATURE]
    y[Y_FIBRE_TEMPERATURE] = q[TEMPERATURE]
    y[Y_RESISTANCE] = q[SHOWN_RESISTANCE]
    y[Y_DISPLACEMENT] = u[IN_ZERO] - q[SHOWN_LENGTH]
    y[Y_FORCE] = q[SHOWN_FORCE]
    y[Y_LENGTH] = q[LENGTH]
    y[Y_CURRENT] = q[CURRENT]
    y[Y_VOLTAGE] = q[CURRENT] * q[RESISTANCE]
    y[Y_POWER] = q[HEATING]
    y[Y_IN_DOMAIN] = 1.0 if DOMAIN_LOW <= q[TEMPERATURE] <= DOMAIN_HIGH else 0.0
    y[Y_SLACK] = q[SLACK]


@entry
def settle(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array, temperature: float) -> float:
    """Set ``x`` to a muscle that has long rested at ``temperature`` (K) without current; returns its length (m)."""
    dx = work[0]
    for j in range(x.size):
        x[j] = 0.0
    x[X_TEMPERATURE] = temperature
    drive, u[IN_DRIVE] = u[IN_DRIVE], 0.0
    for _ in range(100):  # held ends: force and creep find each other within a few rounds
        before = q[LENGTH]
        _evaluate(x, u, p, on, q, dx)
        _initial(q, p, on, x, dx)
        if q[LENGTH] == before:
            break
    u[IN_DRIVE] = drive
    _evaluate(x, u, p, on, q, dx)
    length: float = q[LENGTH]
    return length


@entry
def advance(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array, dt: float, y: Array) -> None:
    """One tick: advance ``dt`` (s), then show. A ``dt`` of 0 only shows."""
    if dt > 0.0:
        _advance(x, u, p, on, q, work, dt)
    _observe(x, u, p, on, q, work, y)


@entry
def advance_many(x: Array, u: Array, p: Array, on: Mask, dt: float, y: Array) -> None:
    """One tick of many muscles: every array has a leading axis of muscles."""
    q = np.empty(N_QUANTITIES)
    work = np.zeros((5, x.shape[1]))
    for k in range(x.shape[0]):
        if dt > 0.0:
            _advance(x[k], u[k], p[k], on[k], q, work, dt)
        _observe(x[k], u[k], p[k], on[k], q, work, y[k])


@entry
def run(
    x: Array, u: Array, p: Array, on: Mask, time: Array, drive: Array, load: Array, ambient: Array, y: Array
) -> None:
    """A whole recording: show at ``time[k]``, then hold input k until ``time[k + 1]``.

    ``time``, ``drive``, ``load``, ``ambient`` have shape (n,); ``y`` is filled, shape (n, N_OUTPUTS).
    """
    q = np.empty(N_QUANTITIES)
    work = np.zeros((5, x.size))
    for k in range(time.size):
        u[IN_DRIVE], u[IN_LOAD], u[IN_AMBIENT] = drive[k], load[k], ambient[k]
        _observe(x, u, p, on, q, work, y[k])
        if k + 1 < time.size:
            _advance(x, u, p, on, q, work, time[k + 1] - time[k])


def scratch() -> tuple[Array, Array]:
    """Fresh ``q`` and ``work`` for one muscle."""
    return np.zeros(N_QUANTITIES), np.zeros((5, STATE_SIZE))


def blank_outputs(*shape: int) -> Array:
    """An array for what is shown, shape (*shape, N_OUTPUTS)."""
    return np.empty((*shape, N_OUTPUTS))

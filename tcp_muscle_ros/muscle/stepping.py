"""Step the muscle: the paper's heat balance by its exact solution, one that effects change by Runge-Kutta over all
states together.

The same compiled functions step one tick, a recording, many muscles and many parameter variants.
Arrays: ``x`` state, ``u`` imposed, ``p`` parameters (``Parameters.vector``), ``on`` effects (``Parameters.mask``),
``y`` what is shown; ``q``, ``work`` scratch. Their places are named in ``quantities.py``.
"""

from math import ceil

import numpy as np

from tcp_muscle_ros.muscle import layout
from tcp_muscle_ros.muscle.arrays import Array, Mask
from tcp_muscle_ros.muscle.compiled import entry, inlined, inner
from tcp_muscle_ros.muscle.composition import hooks_at
from tcp_muscle_ros.muscle.electrical import VOLTAGE, joule_heating, resistance_at, source_current
from tcp_muscle_ros.muscle.mechanical import DOMAIN_HIGH, DOMAIN_LOW, contraction_coefficient, modulus_ratio
from tcp_muscle_ros.muscle.quantities import (
    AMBIENT,
    BEYOND,
    CAPACITY,
    COMMAND,
    COMPLIANCE,
    CONDUCTANCE,
    CORE_TEMPERATURE,
    CURRENT,
    DRIVE,
    DRIVING_TEMPERATURE,
    ELASTIC,
    EQUILIBRIUM_LENGTH,
    EXCHANGE,
    EXTRA,
    FORCE,
    FORCE_RATE,
    GAIN,
    HEAT,
    HEATING,
    HELD,
    IN_AMBIENT,
    IN_COMPLIANCE,
    IN_DRIVE,
    IN_HELD,
    IN_KIND,
    IN_LOAD,
    IN_WALL,
    IN_ZERO,
    KIND,
    LENGTH,
    N_OUTPUTS,
    N_QUANTITIES,
    POWER,
    RATIO,
    RESISTANCE,
    SERIES,
    SHOWN_CURRENT,
    SHOWN_FORCE,
    SHOWN_LENGTH,
    SHOWN_POWER,
    SHOWN_RESISTANCE,
    SHOWN_TEMPERATURE,
    SHOWN_VOLTAGE,
    SLACK,
    STIFFNESS,
    TEMPERATURE,
    TEMPERATURE_RATE,
    THERMAL,
    TIME,
    UNSTUCK_LENGTH,
    VELOCITY,
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

_K0, _H0, _B, _T0, _HA, _C = (INDEX[name] for name in ('k0', 'H0', 'B', 'T0', 'hA', 'C'))
_FASTEST, _INTEGRATED, _MOTION = INDEX['fastest_rate'], INDEX['integrated'], INDEX['motion']
_BEGIN, _POSITION, _COMMIT = INDEX['at_begin'], INDEX['at_position'], INDEX['at_commit']
STATE_SIZE, N_INTEGRATED = layout.STATE_SIZE, layout.N_INTEGRATED
# A substep resolves a tenth of the quickest time constant: the Runge-Kutta error is then below 1e-6 of a change.
SUBSTEP = 0.1
_INSTANT = 1e-6  # s: over which velocity and force rate are taken
_FED = 0.9  # of a motion: more than that it is not taken to cause of itself, while it is sought

_begin = hooks_at('begin')
_surroundings = hooks_at('surroundings')
_softening = hooks_at('softening')
_contraction = hooks_at('contraction')
_extra = hooks_at('extra')
_elasticity = hooks_at('elasticity')
_limit = hooks_at('limit')
_position = hooks_at('position')
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
    q[DRIVING_TEMPERATURE] = q[CORE_TEMPERATURE]
    q[GAIN] = p[_B]
    _contraction(q, p, on, x, dx)
    driving = q[DRIVING_TEMPERATURE]
    q[THERMAL] = q[GAIN] * contraction_coefficient(p, driving) * (driving - p[_T0])
    q[EXTRA] = 0.0
    _extra(q, p, on, x, dx)
    q[ELASTIC] = force / q[STIFFNESS]
    _elasticity(q, p, on, x, dx)
    q[LENGTH] = p[_H0] + q[THERMAL] + q[ELASTIC] + q[EXTRA]
    _limit(q, p, on, x, dx)
    total: float = q[LENGTH]
    return total


@inner
def _hold(wall: float, compliance: float, p: Array, on: Mask, q: Array, x: Array, dx: Array) -> None:
    """The tension at which muscle plus spring fill the distance: length(F) + F * compliance = wall, F >= 0.

    A muscle cannot push: where it is longer than the distance it hangs slack with F = 0.
    """
    # One loop, so that the machine code of the length is there once. First F = 0, then the linear muscle's answer
    # (twice as much until the root is enclosed), then false position (Illinois).
    low = high = below = above = force = 0.0
    enclosed = False
    for attempt in range(160):
        error = _length_under(force, p, on, q, x, dx) + force * compliance - wall
        if attempt == 0:
            if error >= 0.0:
                q[SLACK] = 1.0
                q[LENGTH] = wall
                return
            below = error
            force = -error / (1.0 / q[STIFFNESS] + compliance)
            continue
        if error >= -1e-15 or enclosed:
            if error > 0.0 or not enclosed:
                high, above = force, error
                if enclosed:
                    below *= 0.5
            else:
                low, below = force, error
                above *= 0.5
            enclosed = True
            if abs(error) <= 1e-15 or high - low <= 1e-15 * high:
                break
            force = (low * above - high * below) / (above - below)
        elif attempt < 60:
            low, below = force, error
            force *= 2.0
        else:
            break
    q[LENGTH] = wall - force * compliance


@inner
def _evaluate(x: Array, u: Array, p: Array, on: Mask, q: Array, dx: Array) -> None:
    """Fill ``q`` from the surroundings to the heating, for the present state and input."""
    temperature = x[X_TEMPERATURE]
    q[TIME] = x[X_TIME]
    q[KIND] = u[IN_KIND]
    q[HELD] = u[IN_HELD]
    q[COMPLIANCE] = u[IN_COMPLIANCE]
    q[COMMAND] = u[IN_DRIVE]
    q[TEMPERATURE] = temperature
    q[CORE_TEMPERATURE] = temperature
    q[AMBIENT] = u[IN_AMBIENT]
    _surroundings(q, p, on, x, dx)
    q[RATIO] = modulus_ratio(p, q[CORE_TEMPERATURE])
    _softening(q, p, on, x, dx)
    q[STIFFNESS] = p[_K0] * q[RATIO]
    q[SLACK] = 0.0
    compliance = u[IN_COMPLIANCE]
    held = u[IN_HELD] > 0.0
    if held:
        _hold(u[IN_WALL], compliance, p, on, q, x, dx)
    else:
        q[LENGTH] = _length_under(u[IN_LOAD], p, on, q, x, dx)
    q[EQUILIBRIUM_LENGTH] = q[UNSTUCK_LENGTH] = q[LENGTH]
    if p[_POSITION] > 0.0 and q[SLACK] == 0.0 and (compliance > 0.0 or not held):
        _position(q, p, on, x, dx)
        if held and q[LENGTH] != q[EQUILIBRIUM_LENGTH]:
            q[FORCE] = max(0.0, (u[IN_WALL] - q[LENGTH]) / compliance)
    q[RESISTANCE] = resistance_at(p, temperature)
    q[SERIES] = 0.0
    _resistance(q, p, on, x, dx)
    q[DRIVE] = q[COMMAND]
    _drive(q, p, on, x, dx)
    total = q[RESISTANCE] + q[SERIES]
    q[CURRENT] = source_current(u[IN_KIND], q[DRIVE], total)
    q[POWER] = joule_heating(u[IN_KIND], q[DRIVE], total)
    q[HEATING] = q[POWER] * (q[RESISTANCE] / total)


@inner
def _heat_balance(x: Array, p: Array, on: Mask, q: Array, dx: Array) -> None:
    """dx/dt of all states for known velocity and force rate. Equation 1 with whatever the effects add."""
    q[CONDUCTANCE] = p[_HA]
    q[CAPACITY] = p[_C]
    q[HEAT] = 0.0
    q[EXCHANGE] = 0.0
    _heat(q, p, on, x, dx)
    lost = q[CONDUCTANCE] * (q[TEMPERATURE] - q[AMBIENT]) - q[HEAT]
    q[TEMPERATURE_RATE] = (q[HEATING] - lost + q[EXCHANGE]) / q[CAPACITY]
    dx[X_TIME] = 1.0
    dx[X_TEMPERATURE] = q[TEMPERATURE_RATE]
    dx[X_HEATED] = q[HEATING]
    dx[X_LOST] = lost
    _rates(q, p, on, x, dx)


@inner
def _derivative(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array, dx: Array, known: bool) -> None:
    """dx/dt of all states; ``known``: ``q`` is already that of this state and input.

    An effect may need the velocity of the end (or, held, the rate of the force), which follow from dx/dt itself:
    that loop is closed by secants on ``m``, the motion that is assumed against the motion that results.
    """
    compliance, held = u[IN_COMPLIANCE], u[IN_HELD] > 0.0
    ahead, q_ahead = work[5], q[N_QUANTITIES:]
    rounds = 20 if p[_MOTION] > 0.0 else 1
    q[VELOCITY] = q[FORCE_RATE] = 0.0
    m_before = gap_before = m = 0.0
    if not known:
        _evaluate(x, u, p, on, q, dx)
    for attempt in range(rounds):
        _heat_balance(x, p, on, q, dx)
        if rounds == 1:
            break
        for j in range(x.size):
            ahead[j] = x[j] + _INSTANT * dx[j]
        _evaluate(ahead, u, p, on, q_ahead, dx)
        if held:
            gap = (q_ahead[FORCE] - q[FORCE]) / _INSTANT - m
        else:
            gap = (q_ahead[LENGTH] - q[LENGTH]) / _INSTANT - m
        if abs(gap) <= 1e-10 or gap == gap_before:
            break
        # Motion that feeds itself has other solutions than the first, and near them secants lead anywhere.
        fed = 0.0 if attempt == 0 else 1.0 + (gap - gap_before) / (m - m_before)
        step = gap / (1.0 - min(fed, _FED))
        m_before, gap_before = m, gap
        m += step
        q[VELOCITY] = -compliance * m if held else m
        q[FORCE_RATE] = m if held else 0.0


@inner
def _runge_kutta(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array, dt: float, known: bool) -> None:
    """One classical fourth-order step of all states that have rates; ``known``: ``q`` is that of its beginning."""
    k1, k2, k3, k4, middle = work[0], work[1], work[2], work[3], work[4]
    for j in range(x.size):
        middle[j] = x[j]
    for stage in range(4):  # a loop, so that the machine code of the derivative is there once
        if stage > 0:
            reach = dt if stage == 3 else 0.5 * dt
            for j in range(N_INTEGRATED):
                middle[j] = x[j] + reach * work[stage - 1, j]
        _derivative(middle, u, p, on, q, work, work[stage], known and stage == 0)
    for j in range(N_INTEGRATED):
        x[j] += dt / 6.0 * (k1[j] + 2.0 * (k2[j] + k3[j]) + k4[j])


@inlined
def _start(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array) -> None:
    """Take up a jump of the inputs. Heat that work leaves in the muscle is booked as taken from the ambient."""
    if p[_BEGIN] == 0.0:
        return
    _evaluate(x, u, p, on, q, work[0])
    _begin(q, p, on, x, work[0])
    x[X_LOST] -= p[_C] * (q[TEMPERATURE] - x[X_TEMPERATURE])
    x[X_TEMPERATURE] = q[TEMPERATURE]


@inlined
def _advance(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array, dt: float, known: bool) -> None:
    """Advance the state by ``dt`` (s) under the imposed ``u``, constant over the step; ``known``: ``q`` is that of its
    beginning, as ``_show`` leaves it.
    """
    if p[_INTEGRATED] == 0.0 and u[IN_KIND] != VOLTAGE:
        after, heated, lost = exact_step(p, u[IN_KIND], u[IN_DRIVE], u[IN_AMBIENT], x[X_TEMPERATURE], dt)
        x[X_TIME] += dt
        x[X_TEMPERATURE] = after
        x[X_HEATED] += heated
        x[X_LOST] += lost
        if p[_COMMIT] > 0.0:
            _show(x, u, p, on, q, work)
            _commit(q, p, on, x, work[0])
        return
    substeps = max(1, ceil(dt * p[_FASTEST] / SUBSTEP))
    for k in range(substeps):
        # What moves depends on its own motion, and is found anew.
        _runge_kutta(x, u, p, on, q, work, dt / substeps, known and k == 0 and p[_MOTION] == 0.0)
        if p[_COMMIT] > 0.0:
            _show(x, u, p, on, q, work)
            _commit(q, p, on, x, work[0])


@inlined
def _show(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array) -> None:
    """Fill ``q`` to what the sensors show."""
    _evaluate(x, u, p, on, q, work[0])
    q[SHOWN_TEMPERATURE] = q[TEMPERATURE]
    q[SHOWN_RESISTANCE] = q[RESISTANCE] + q[SERIES]
    q[SHOWN_LENGTH] = q[LENGTH]
    q[SHOWN_FORCE] = q[FORCE]
    q[SHOWN_CURRENT] = q[CURRENT]
    q[SHOWN_VOLTAGE] = q[CURRENT] * (q[RESISTANCE] + q[SERIES])
    q[SHOWN_POWER] = q[POWER]
    q[BEYOND] = 0.0
    _sensor(q, p, on, x, work[0])


@inlined
def _observe(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array, y: Array) -> None:
    """What is shown at this instant with this drive applied. No time passes."""
    _show(x, u, p, on, q, work)
    y[Y_TEMPERATURE] = q[SHOWN_TEMPERATURE]
    y[Y_FIBRE_TEMPERATURE] = q[TEMPERATURE]
    y[Y_RESISTANCE] = q[SHOWN_RESISTANCE]
    y[Y_DISPLACEMENT] = u[IN_ZERO] - q[SHOWN_LENGTH]
    y[Y_FORCE] = q[SHOWN_FORCE]
    y[Y_LENGTH] = q[LENGTH]
    y[Y_CURRENT] = q[SHOWN_CURRENT]
    y[Y_VOLTAGE] = q[SHOWN_VOLTAGE]
    y[Y_POWER] = q[SHOWN_POWER]
    y[Y_IN_DOMAIN] = 1.0 if DOMAIN_LOW <= q[TEMPERATURE] <= DOMAIN_HIGH and q[BEYOND] == 0.0 else 0.0
    y[Y_SLACK] = q[SLACK]


@entry
def settle(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array, temperature: float) -> float:
    """Set ``x`` to a muscle that has long rested at ``temperature`` (K) without current; returns its length (m)."""
    for j in range(x.size):
        x[j] = 0.0
    x[X_TEMPERATURE] = temperature
    drive, u[IN_DRIVE] = u[IN_DRIVE], 0.0
    before, pulled = -1.0, -1.0
    for k in range(100):  # held ends: force and creep find each other within a few rounds, a blocked one by the force
        _show(x, u, p, on, q, work)
        still = q[LENGTH] == before and abs(q[FORCE] - pulled) <= 1e-12 * q[FORCE]
        if k > 1 and still:  # a late clock has long shown what a bead shows once it is at rest
            break
        before, pulled = q[LENGTH], q[FORCE]
        _initial(q, p, on, x, work[0])
    u[IN_DRIVE] = drive
    return before


@entry
def advance(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array, dt: float, y: Array) -> None:
    """One tick: advance ``dt`` (s), then show. A ``dt`` of 0 only shows."""
    _start(x, u, p, on, q, work)
    if dt > 0.0:
        _advance(x, u, p, on, q, work, dt, False)
    _observe(x, u, p, on, q, work, y)


@entry
def advance_many(x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array, dt: float, y: Array) -> None:
    """One tick of many muscles: every array but the scratch has a leading axis of muscles."""
    for k in range(x.shape[0]):
        _start(x[k], u[k], p[k], on[k], q, work)
        if dt > 0.0:
            _advance(x[k], u[k], p[k], on[k], q, work, dt, False)
        _observe(x[k], u[k], p[k], on[k], q, work, y[k])


@entry
def run(
    x: Array, u: Array, p: Array, on: Mask, q: Array, work: Array,
    time: Array, drive: Array, load: Array, ambient: Array, y: Array, shown: Array,
) -> None:  # fmt: skip
    """A whole recording: show at ``time[k]``, then hold input k until ``time[k + 1]``.

    ``time``, ``drive``, ``load``, ``ambient`` have shape (n,); ``shown`` is filled, shape (N_OUTPUTS, n).
    """
    for k in range(time.size):
        u[IN_DRIVE], u[IN_LOAD], u[IN_AMBIENT] = drive[k], load[k], ambient[k]
        _start(x, u, p, on, q, work)
        _observe(x, u, p, on, q, work, y)
        for j in range(N_OUTPUTS):
            shown[j, k] = y[j]
        if k + 1 < time.size:
            _advance(x, u, p, on, q, work, time[k + 1] - time[k], True)


def scratch() -> tuple[Array, Array]:
    """Fresh ``q`` and ``work`` for one muscle."""
    return np.zeros(2 * N_QUANTITIES), np.zeros((6, STATE_SIZE))


def blank_outputs(*shape: int) -> Array:
    """An array for what is shown, shape (N_OUTPUTS, *shape)."""
    return np.empty((N_OUTPUTS, *shape))

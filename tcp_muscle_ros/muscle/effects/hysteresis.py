"""M-03 hysteresis: part of the contraction follows the temperature with backlash, at every rate.

    T_drive = T + w (mean_j P_j[T] - T),   P_j a play of half width r/3, 2r/3, r
    H -> H + w y dH/dT(T0),   dy = -(dT + |dT| y / Y)/2,   Y = 2 r/3

Either three play operators of a Prandtl-Ishlinskii model, whose loop is as wide in temperature everywhere, or the law
of Bouc and Wen (with gamma = 0, n = 1), which adds to the output, so that the loop is as wide in length everywhere,
and lets go little by little. They start as after cooling. Contraction lags the temperature: the heating branch lies
below the cooling branch, at every rate. Published fits of these muscles use the generalised form of the first; the
second stands beside it in the literature of hysteresis.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.mechanical import contraction_coefficient
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import CORE_TEMPERATURE, DRIVING_TEMPERATURE, EXTRA, GAIN
from tcp_muscle_ros.muscle.table import INDEX

_PLAYS = 3
_T0 = INDEX['T0']


@inner
def _half(c: Array, j: int) -> float:
    """Half the width of play j, K."""
    width: float = c[1] * (j + 1) / _PLAYS
    return width


@inner
def _play(c: Array, s: Array, temperature: float, j: int) -> float:
    """Play j at this temperature."""
    half = _half(c, j)
    value: float = min(max(s[j], temperature - half), temperature + half)
    return value


@inner
def _furthest(c: Array) -> float:
    """How far it is behind in the end, K, for a share of one: the mean of the half widths."""
    return 0.5 * (_half(c, 0) + _half(c, _PLAYS - 1))


@inner
def _behind(c: Array, s: Array, temperature: float) -> float:
    """The state of Bouc and Wen's law at this temperature, K: y."""
    way = temperature - s[1]
    end = -_furthest(c) if way > 0.0 else _furthest(c)
    behind: float = end + (s[0] - end) * exp(-0.5 * abs(way) / _furthest(c))
    return behind


def contraction(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Mix the plays into the temperature that drives the contraction."""
    if c[2] < 0.5:
        behind = 0.0
        for j in range(_PLAYS):
            behind += _play(c, s, q[CORE_TEMPERATURE], j) - q[CORE_TEMPERATURE]
        q[DRIVING_TEMPERATURE] += c[0] * behind / _PLAYS


def extra(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Add what Bouc and Wen's law is behind."""
    if c[2] > 0.5:
        per_kelvin = q[GAIN] * contraction_coefficient(p, p[_T0])
        q[EXTRA] += c[0] * _behind(c, s, q[CORE_TEMPERATURE]) * per_kelvin


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """As after cooling: a muscle in use was hotter before."""
    if c[2] < 0.5:
        for j in range(_PLAYS):
            s[j] = q[CORE_TEMPERATURE] + _half(c, j)
    else:
        s[0], s[1] = _furthest(c), q[CORE_TEMPERATURE]


def commit(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The plays move, or what lags behind."""
    if c[2] < 0.5:
        for j in range(_PLAYS):
            s[j] = _play(c, s, q[CORE_TEMPERATURE], j)
    else:
        s[0] = _behind(c, s, q[CORE_TEMPERATURE])
        s[1] = q[CORE_TEMPERATURE]


EFFECT = Effect(
    name='hysteresis',
    row='M-03',
    stage='mechanical',
    equation='T_drive = T + w (mean_j P_j[T] - T), plays of half width r/3, 2r/3, r; or Bouc and Wen',
    source='Prandtl-Ishlinskii play operators; Bouc 1967 and Wen 1976',
    parameters=(
        Parameter('w', 0.15, '1', 0.0, 0.9, 'share of the contraction that has play', 'loop of 3 to 8 % of stroke'),
        Parameter('r', 10.0, 'K', 0.5, 40.0, 'half width of the widest play', 'estimated: 5 to 15 K'),
        Parameter(
            'law', 0.0, '1', 0.0, 1.0, 'how it lets go where the temperature turns: 0 play by play, 1 little by little',
            'a free choice', choices=('play by play', 'little by little'), fitted=False,
        ),
    ),
    hooks={'contraction': contraction, 'extra': extra, 'initial': initial, 'commit': commit},
    strength='w',
    states=('memory_1', 'memory_2', 'memory_3'),
)  # fmt: skip

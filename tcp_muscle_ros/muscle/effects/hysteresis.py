"""M-03 hysteresis: part of the contraction follows the temperature with backlash, at every rate.

    T_drive = T + w (mean_j P_j[T] - T),   P_j a play of half width r/3, 2r/3, r

Three play operators of a Prandtl-Ishlinskii model, which start as after cooling. Contraction lags the
temperature: the heating branch lies below the cooling branch, at every rate. Published fits of these muscles use the
generalised form of the model.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import CORE_TEMPERATURE, DRIVING_TEMPERATURE

_PLAYS = 3


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


def contraction(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Mix the plays into the temperature that drives the contraction."""
    behind = 0.0
    for j in range(_PLAYS):
        behind += _play(c, s, q[CORE_TEMPERATURE], j) - q[CORE_TEMPERATURE]
    q[DRIVING_TEMPERATURE] += c[0] * behind / _PLAYS


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """As after cooling: a muscle in use was hotter before."""
    for j in range(_PLAYS):
        s[j] = q[CORE_TEMPERATURE] + _half(c, j)


def commit(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The plays move."""
    for j in range(_PLAYS):
        s[j] = _play(c, s, q[CORE_TEMPERATURE], j)


EFFECT = Effect(
    name='hysteresis',
    row='M-03',
    stage='mechanical',
    equation='T_drive = T + w (mean_j P_j[T] - T), plays of half width r/3, 2r/3, r',
    source='Prandtl-Ishlinskii play operators',
    parameters=(
        Parameter('w', 0.15, '1', 0.0, 0.9, 'share of the contraction that has play', 'loop of 3 to 8 % of stroke'),
        Parameter('r', 10.0, 'K', 0.5, 40.0, 'half width of the widest play', 'estimated: 5 to 15 K'),
    ),
    hooks={'contraction': contraction, 'initial': initial, 'commit': commit},
    strength='w',
    states=('play_1', 'play_2', 'play_3'),
)

"""T-11 end conduction: the clamps cool the ends, so the mean temperature is below that of the middle.

A fin of length l at each end of the coil, in the middle theta_m = T_m - Tinf, in the mean theta = theta_m - delta:

    d delta/dt = 2 (eta theta_m - delta) / tau,   eta = 2 l/H0,  tau = C/hA
    C dT/dt = i^2 R - hA (T - Tinf) - hA (2 eta theta_m - delta)

T is the mean, which sets the resistance and the contraction. The thermometer is in the middle and shows T + delta. The
heat equation of a half-infinite rod gives delta = eta theta_m / sqrt(1 + s tau); one state reproduces its steady value
and its delay tau/2. l is 0.84 mm for the muscle alone and 5 to 10 mm with crimped tubes.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import AMBIENT, HEAT, SHOWN_TEMPERATURE, TEMPERATURE
from tcp_muscle_ros.muscle.table import INDEX

_H0, _C, _HA = INDEX['H0'], INDEX['C'], INDEX['hA']


@inner
def _wanted(q: Array, c: Array, p: Array, deficit: float) -> float:
    """The deficit (K) in the steady state of this middle temperature."""
    middle = q[TEMPERATURE] + deficit - q[AMBIENT]
    value: float = min(2.0 * c[0] / p[_H0], 1.0) * middle
    return value


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The clamps draw heat."""
    q[HEAT] -= p[_HA] * (2.0 * _wanted(q, c, p, s[0]) - s[0])


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The deficit of the ends develops."""
    ds[0] = 2.0 * (_wanted(q, c, p, s[0]) - s[0]) * p[_HA] / p[_C]


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The thermometer sits in the middle."""
    q[SHOWN_TEMPERATURE] += s[0]


EFFECT = Effect(
    name='end_conduction',
    row='T-11',
    stage='thermal',
    equation='d delta/dt = 2 (eta theta_m - delta) / tau, eta = 2 l/H0, shown T + delta',
    source='fin at each end, one state',
    parameters=(
        Parameter('l', 0.005, 'm', 0.0, 0.05, 'length of the cold end', 'estimated: 0.8 mm, crimped 5 to 10 mm'),
    ),
    hooks={'heat': heat, 'rates': rates, 'sensor': sensor},
    strength='l',
    states=('end_deficit',),
)

"""E-04 TCR curvature: the resistance of a thin coating is not linear in temperature.

    R = R0 (1 + a_R theta + b theta^2),   theta = T - T0

Outside 0 to 120 degC its ratio to the straight line is held constant.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.mechanical import DOMAIN_HIGH, DOMAIN_LOW
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import RESISTANCE, TEMPERATURE
from tcp_muscle_ros.muscle.table import INDEX

_A_R, _T0 = INDEX['a_R'], INDEX['T0']


def resistance(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the resistance by the curved over the straight line."""
    theta = min(max(q[TEMPERATURE], DOMAIN_LOW), DOMAIN_HIGH) - p[_T0]
    q[RESISTANCE] *= 1.0 + c[0] * theta * theta / (1.0 + p[_A_R] * theta)


EFFECT = Effect(
    name='tcr_curvature',
    row='E-04',
    stage='electrical',
    equation='R0 (1 + a_R theta + b theta^2), theta = T - T0',
    source='second-order temperature coefficient of silver coatings',
    parameters=(Parameter('b', -4e-6, '1/K^2', -4e-5, 4e-5, 'curvature of R(T)', 'estimated: -1e-5 to 1e-6 1/K^2'),),
    hooks={'resistance': resistance},
    strength='b',
)

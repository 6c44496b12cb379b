"""M-02 viscous flow: the hot fibre yields under load and does not come back.

    dxf/dt = m F (F / 0.5 N)^(n - 1) exp(a (T - 60 degC)),   H -> H + xf

The dashpot of a Burgers solid, n = 1. Polymers under much stress flow faster than in proportion to it (Eyring 1936):
n = 2 or 3, as Norton's law has it. The rate is held beyond 0 to 120 degC.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.mechanical import DOMAIN_HIGH, DOMAIN_LOW
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.quantities import CORE_TEMPERATURE, EXTRA, FORCE

_REFERENCE, _FORCE = ZERO_CELSIUS + 60.0, 0.5


def extra(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The elongation so far."""
    q[EXTRA] += s[0]


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """It flows."""
    within = min(max(q[CORE_TEMPERATURE], DOMAIN_LOW), DOMAIN_HIGH)
    stressed = (abs(q[FORCE]) / _FORCE) ** c[2]
    ds[0] = c[0] * q[FORCE] * stressed * exp(c[1] * (within - _REFERENCE))


EFFECT = Effect(
    name='viscous_flow',
    row='M-02',
    stage='mechanical',
    equation='dxf/dt = m F (F / 0.5 N)^(n - 1) exp(a (T - 60 degC)), H + xf',
    source='dashpot of a Burgers solid, Norton flow',
    parameters=(
        Parameter(
            'm', 1e-5, 'm/(N s)', 0.0, 1e-3, 'flow per force at 60 degC, 0.5 N', 'estimated: 0.1 to 1 mm in 200 s'
        ),
        Parameter('a', 0.05, '1/K', 0.0, 0.15, 'rise of the rate with temperature', 'estimated: 0.04 to 0.1 1/K'),
        Parameter(
            'law', 0.0, '1', 0.0, 2.0, 'n - 1: how it grows with the force', 'a free choice',
            choices=('in proportion', 'by its square', 'by its cube'), fitted=False,
        ),
    ),
    hooks={'extra': extra, 'rates': rates},
    strength='m',
    states=('flow',),
)  # fmt: skip

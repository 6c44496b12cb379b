"""E-05 resistance drift: the silver cracks and oxidises, and the resistance grows with use.

    dw/dt = exp(a (T - 60 degC)),   R -> R (1 + r w (w/100 s)^(n-1)),   held at twice the first resistance

Published: 0.1 to 2 % per 100 cycles; up to 2 % within one run of a new coating. w is the time in use; with a > 0, time
at high temperature counts more. Cracking grows with the cycles, n = 1; a protective oxide grows as the square root of
time, n = 0.5. In several recordings w either begins anew in each (the coating was repaired, or R0 measured again) or
continues.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.mechanical import DOMAIN_HIGH, DOMAIN_LOW
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.quantities import RESISTANCE, TEMPERATURE

_SCALE = 100.0  # s
_REFERENCE = ZERO_CELSIUS + 60.0


def resistance(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the resistance by the time in use."""
    grown = c[0] * _SCALE * (max(s[0], 0.0) / _SCALE) ** c[1]
    q[RESISTANCE] *= 1.0 + min(max(grown, -0.5), 1.0)


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """It ages, the hotter the quicker."""
    within = min(max(q[TEMPERATURE], DOMAIN_LOW), DOMAIN_HIGH)
    ds[0] = exp(c[2] * (within - _REFERENCE))


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """As much in use as before."""
    s[0] = c[3] if c[4] > 0.5 else 0.0


EFFECT = Effect(
    name='resistance_drift',
    row='E-05',
    stage='electrical',
    equation='R (1 + r w (w/100 s)^(n-1)), dw/dt = exp(a (T - 60 degC))',
    source='cracking and oxidation of silver coatings',
    parameters=(
        Parameter('r', 1e-4, '1/s', -1e-3, 1e-3, 'relative drift of R', 'estimated: 2 % in a run of 210 s'),
        Parameter('n', 1.0, '1', 0.3, 1.5, 'power of the time in use', 'cracking 1, a protecting oxide 0.5'),
        Parameter('a', 0.0, '1/K', 0.0, 0.1, 'rise of the ageing rate with temperature', 'oxidation: 0.03 to 0.1 1/K'),
        Parameter(
            'w0', 0.0, 's', 0.0, 1e9, 'time in use before (with course = 1)', 'a new muscle; earlier recordings',
            fitted=False,
        ),
        Parameter(
            'course', 0.0, '1', 0.0, 1.0, 'of a recording after others: 0 anew, 1 goes on', 'a free choice',
            choices=('anew', 'goes on'), fitted=False,
        ),
    ),
    hooks={'resistance': resistance, 'rates': rates, 'initial': initial},
    strength='r',
    age='w0',
    states=('use',),
)  # fmt: skip

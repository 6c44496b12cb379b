"""T-08 latent heat: a transition absorbs heat within a range of temperatures, and gives it back below that.

    C -> C + c exp(-((T - Tm) / w)^2 / 2),   Tm -> Tm - u while it cools

The heat of the transition is c w sqrt(2 pi). What melted freezes lower by the undercooling u; between the two bands
nothing changes, so that no heat is made of nothing by turning round. Nylon 6,6 melts near 260 degC and none is reported
below 120 degC; other fibres, additives and moisture have one.
"""

from math import erfc, exp, sqrt

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.quantities import AMBIENT, CAPACITY, CONDUCTANCE, HEAT, HEATING, TEMPERATURE


@inner
def _molten(c: Array, above: float) -> float:
    """The molten share at so many K above the middle of a band."""
    share: float = 0.5 * erfc(-above / (c[2] * sqrt(2.0)))
    return share


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Raise the capacity within the band that the muscle goes through."""
    above = q[TEMPERATURE] - c[1]
    if c[3] > 0.0:
        if q[HEATING] + q[HEAT] > q[CONDUCTANCE] * (q[TEMPERATURE] - q[AMBIENT]):
            going = _molten(c, above) >= s[0]
        else:
            above += c[3]
            going = _molten(c, above) <= s[0]
        if not going:
            return
    z = above / c[2]
    q[CAPACITY] += c[0] * exp(-0.5 * z * z)


def commit(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Melt up to the upper band, freeze down to the lower."""
    above = q[TEMPERATURE] - c[1]
    s[0] = min(max(s[0], _molten(c, above)), _molten(c, above + c[3]))


EFFECT = Effect(
    name='latent_heat',
    row='T-08',
    stage='thermal',
    equation='C + c exp(-((T - Tm)/w)^2 / 2), Tm - u while it cools',
    source='apparent heat capacity of a transition with undercooling',
    parameters=(
        Parameter('c', 0.04, 'J/K', 0.0, 1.0, 'height of the peak', 'estimated: a quarter of C'),
        Parameter(
            'Tm',
            60.0 + ZERO_CELSIUS,
            'K',
            20.0 + ZERO_CELSIUS,
            150.0 + ZERO_CELSIUS,
            'middle of the band',
            'a free choice',
            absolute=True,
            crossed='fibre_temperature',
        ),
        Parameter('w', 6.0, 'K', 1.0, 40.0, 'standard width of the band', 'a free choice'),
        Parameter('u', 0.0, 'K', 0.0, 40.0, 'undercooling', 'a free choice'),
    ),
    hooks={'heat': heat, 'commit': commit, 'initial': commit},
    strength='c',
    unexpected=True,
    states=('molten',),
    fastest_rate=lambda c, p: float(6.0 / c[2]),
)

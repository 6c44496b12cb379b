"""T-12 thermo-elastic coupling: pulling the muscle warms it, letting go cools it.

    C dT/dt = ... - g T (dH/dT)_F dF/dt

From dS = 0 and (dS/dF)_T = (dH/dT)_F, which is negative here: g = 1 is thermodynamics of the paper's own H(T, F). A
load step makes a temperature step (+1.8 K for 0.69 N at 70 degC). Under a constant force the term vanishes, because C
was measured under a constant force. In a held muscle its own force acts.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.mechanical import DOMAIN_HIGH, DOMAIN_LOW, modulus_ratio
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import FORCE, FORCE_RATE, HEAT, TEMPERATURE
from tcp_muscle_ros.muscle.table import INDEX

_B, _C, _C1, _C2, _K0, _T0 = (INDEX[name] for name in ('B', 'C', 'c1', 'c2', 'k0', 'T0'))
_SPAN = 0.01  # K


@inner
def _expansion(p: Array, temperature: float, force: float) -> float:
    """(dH/dT)_F, m/K, of the paper's model."""
    within = min(max(temperature, DOMAIN_LOW), DOMAIN_HIGH)
    thermal = p[_B] * (p[_C1] * (2.0 * within - p[_T0]) + p[_C2])
    soft = 1.0 / modulus_ratio(p, within + _SPAN) - 1.0 / modulus_ratio(p, within - _SPAN)
    slope: float = thermal + force / p[_K0] * soft / (2.0 * _SPAN)
    return slope


def begin(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The load has jumped: the temperature follows. The middle of the jump makes it the same back and forth."""
    jump = q[FORCE] - s[0]
    before = after = q[TEMPERATURE]
    if jump != 0.0:
        for _ in range(8):
            middle = 0.5 * (before + after)
            after = before - c[0] * middle / p[_C] * _expansion(p, middle, s[0] + 0.5 * jump) * jump
        q[TEMPERATURE] = after
        s[0] = q[FORCE]


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Heat by the force's rate."""
    q[HEAT] -= c[0] * q[TEMPERATURE] * _expansion(p, q[TEMPERATURE], q[FORCE]) * q[FORCE_RATE]


def remember(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Keep the force of this instant."""
    s[0] = q[FORCE]


EFFECT = Effect(
    name='elastocaloric',
    row='T-12',
    stage='thermal',
    equation='C dT/dt = ... - g T (dH/dT)_F dF/dt',
    source='Maxwell relation of (T, F)',
    parameters=(Parameter('g', 1.0, '1', -3.0, 20.0, 'share of the thermodynamic value', 'dS = 0 gives 1'),),
    hooks={'begin': begin, 'heat': heat, 'initial': remember, 'commit': remember},
    strength='g',
    states=('last_force',),
    motion=True,
)

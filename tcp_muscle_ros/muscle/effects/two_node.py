"""T-10 two nodes: the coating is heated, cooled and measured; the core that contracts follows through a resistance.

    (1 - f) C dTs/dt = i^2 R(Ts) - hA (Ts - Tinf) - G (Ts - T),   f C dT/dt = G (Ts - T)

The thermometer and the resistance see the sheath Ts. Contraction and modulus follow the core T, or, where the sheath
is fibre too, the mean of both by their capacities. The core's delay f C/G is kept at 0.05 s or more by a larger
resistance, and the contraction then follows the core in part (see ``lag.py``): at f = 0 the muscle is one node again.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.effects.lag import SHORTEST, approach, lagging
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import CAPACITY, CORE_TEMPERATURE, EXCHANGE, TEMPERATURE
from tcp_muscle_ros.muscle.table import INDEX

_C = INDEX['C']


@inner
def _delay(c: Array, p: Array) -> float:
    """f C/G, s."""
    delay: float = c[0] * p[_C] / c[1]
    return delay


def surroundings(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Contraction and modulus follow the core, or all of the fibre."""
    core = lagging(_delay(c, p), q[TEMPERATURE], s[0])
    q[CORE_TEMPERATURE] = core if c[2] < 0.5 else q[TEMPERATURE] + c[0] * (core - q[TEMPERATURE])


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The sheath keeps its part of the capacity and heats the core."""
    core = c[0] * q[CAPACITY]
    q[EXCHANGE] -= core * approach(_delay(c, p), q[TEMPERATURE], s[0])
    q[CAPACITY] -= core


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The core approaches the sheath."""
    ds[0] = approach(_delay(c, p), q[TEMPERATURE], s[0])


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """At rest both have one temperature."""
    s[0] = q[TEMPERATURE]


EFFECT = Effect(
    name='two_node',
    row='T-10',
    stage='thermal',
    equation='(1 - f) C dTs/dt = i^2 R - hA (Ts - Tinf) - G (Ts - T), f C dT/dt = G (Ts - T)',
    source='sheath and core in series',
    parameters=(
        Parameter('f', 0.5, '1', 0.0, 0.8, 'share of the capacity in the core', 'estimated'),
        Parameter('G', 0.12, 'W/K', 0.005, 10.0, 'conductance from sheath to core', 'estimated: 0.05 to 1 W/K'),
        Parameter(
            'pull', 0.0, '1', 0.0, 1.0, 'what contracts: 0 the core, 1 core and sheath', 'a free choice',
            choices=('core', 'core and sheath'), fitted=False,
        ),
    ),
    hooks={'surroundings': surroundings, 'heat': heat, 'rates': rates, 'initial': initial},
    strength='f',
    states=('core_temperature',),
    delay=lambda muscle: muscle['two_node.f'] * muscle['C'] / muscle['two_node.G'],
    fastest_rate=lambda c, p: float(
        (4.0 * p[INDEX['hA']] / p[_C] + 1.0 / max(c[0] * p[_C] / c[1], SHORTEST)) / (1.0 - c[0])
    ),
)  # fmt: skip

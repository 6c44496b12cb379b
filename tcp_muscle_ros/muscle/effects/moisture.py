"""T-09 moisture: water evaporates from the hot fibre, which takes heat, and returns slowly when cold.

    dw/dt = -(w - weq(T)) / tau(T),   heat m Lv dw/dt
    weq = w0 exp(-0.055 (T - T0)/K),   tau = tau60 exp(-0.065 (T - 60 degC)/K)

w is the mass of water per mass of fibre. The vapour pressure of water doubles every 12 K, so in air of a given humidity
the equilibrium content halves; diffusion in nylon is eleven times as fast at 60 as at 23 degC. 1 % is 2.4 J.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.quantities import HEAT, TEMPERATURE
from tcp_muscle_ros.muscle.table import INDEX

EVAPORATION = 2.4e6  # J/kg
_M, _T0 = INDEX['m'], INDEX['T0']
_SORPTION, _DIFFUSION = 0.055, 0.065  # 1/K
_REFERENCE, _COLD, _HOT = 60.0 + ZERO_CELSIUS, ZERO_CELSIUS, 120.0 + ZERO_CELSIUS


@inner
def _uptake(c: Array, p: Array, temperature: float, water: float) -> float:
    """dw/dt, 1/s."""
    within = min(max(temperature, _COLD), _HOT)
    equilibrium = c[0] * exp(-_SORPTION * (within - p[_T0]))
    rate: float = (equilibrium - water) / c[1] * exp(_DIFFUSION * (within - _REFERENCE))
    return rate


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Evaporation cools."""
    q[HEAT] += p[_M] * EVAPORATION * _uptake(c, p, q[TEMPERATURE], s[0])


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The water content follows its equilibrium."""
    ds[0] = _uptake(c, p, q[TEMPERATURE], s[0])


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """A muscle that rested in the room, at T0, holds w0 however it was warmed since; one that did not rest, less."""
    s[0] = c[0] * (1.0 + c[2])


EFFECT = Effect(
    name='moisture',
    row='T-09',
    stage='thermal',
    equation='dw/dt = (weq(T) - w) / tau(T), heat m Lv dw/dt',
    source='sorption of water in nylon 6,6; evaporation 2.4 MJ/kg',
    parameters=(
        Parameter('w0', 0.015, '1', 0.0, 0.10, 'water content at rest in the room', 'estimated: 1 to 3 %'),
        Parameter('tau60', 15.0, 's', 1.0, 2000.0, 'drying time at 60 degC', 'estimated: 4 s (fine) to 900 s (solid)'),
        Parameter(
            'start', 0.0, '1', -1.0, 1.0, 'how much more it holds at the start: -1 dry, 0 at rest',
            'rest since the last run', state=True,
        ),
    ),
    hooks={'heat': heat, 'rates': rates, 'initial': initial},
    strength='w0',
    states=('water_content',),
    fastest_rate=lambda c, p: float(exp(_DIFFUSION * (_HOT - _REFERENCE)) / c[1]),
)  # fmt: skip

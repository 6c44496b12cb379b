"""S-01 thermocouple lag: the bead follows the fibre with a first-order delay.

    tau dTm/dt = T - Tm

A bead of 127 um wire lags 0.5 s to 3.4 s, of 254 um wire 1 s to 6.8 s (contact conductance 60 to 400 W/(m^2 K)).
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.effects.lag import approach, fastest, lagging
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import SHOWN_TEMPERATURE, TEMPERATURE


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The bead approaches the fibre."""
    ds[0] = approach(c[0], q[TEMPERATURE], s[0])


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """What is shown is the bead."""
    q[SHOWN_TEMPERATURE] += lagging(c[0], q[TEMPERATURE], s[0]) - q[TEMPERATURE]


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """At rest the bead has the fibre's temperature."""
    s[0] = q[TEMPERATURE]


EFFECT = Effect(
    name='thermocouple_lag',
    row='S-01',
    stage='sensor',
    equation='tau dTm/dt = T - Tm',
    source='lumped bead, contact conductance 60 to 400 W/(m^2 K)',
    parameters=(Parameter('tau', 2.0, 's', 0.0, 30.0, 'time constant of the bead', 'estimated: 0.5 to 6.8 s'),),
    hooks={'rates': rates, 'sensor': sensor, 'initial': initial},
    strength='tau',
    delay=lambda muscle: muscle['thermocouple_lag.tau'],
    states=('bead_temperature',),
    fastest_rate=lambda c, p: fastest(float(c[0])),
)

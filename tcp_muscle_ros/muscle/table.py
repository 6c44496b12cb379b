"""The paper's parameters, row by row, and those identified from its text (sources: the paper, and docs/paper.md)."""

from collections.abc import Callable, Mapping

from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.points import POINTS

_TABLE_1 = 'Table 1, measured'
_COOLING = 'identified: 80 degC, 25 s, 0.27 A; printed 0.15'

# fmt: off
TABLE: tuple[Parameter, ...] = (
    Parameter('L0', 0.5, 'm', 1e-3, 50.0, 'fibre length', _TABLE_1),
    Parameter('H0', 0.15, 'm', 1e-3, 10.0, 'length at T0, no load', _TABLE_1),
    Parameter('D0', 0.75e-3, 'm', 1e-5, 0.1, 'outer coil diameter', _TABLE_1),
    Parameter('cp', 1700.0, 'J/(kg K)', 100.0, 1e4, 'specific heat', 'Table 1, handbook'),
    Parameter('m', 1e-4, 'kg', 1e-7, 1.0, 'mass (one digit: 0.05 g to 0.15 g)', _TABLE_1),
    Parameter('k0', 23.0, 'N/m', 0.01, 1e6, 'stiffness at T0 (printed as k)', _TABLE_1),
    Parameter('R0', 14.0, 'ohm', 1e-3, 1e5, 'resistance at T0', _TABLE_1),
    Parameter('T0', 23.0 + ZERO_CELSIUS, 'K', 250.0, 350.0, 'reference temperature', _TABLE_1, absolute=True),
    Parameter('a_R', 0.003, '1/K', -0.01, 0.05, 'resistance per kelvin', 'Table 1 (alpha), handbook'),
    Parameter('hA', 0.01933, 'W/K', 1e-5, 10.0, 'convection conductance', _COOLING),
    Parameter('c1', -3.50e-6, '1/K^2', -1e-3, 1e-3, 'slope of the contraction coefficient, T in K', 'equation 26'),
    Parameter('c2', 4.20e-4, '1/K', -0.5, 0.5, 'contraction coefficient extrapolated to 0 K', 'equation 26'),
    Parameter('a1', -0.4655e6, 'Pa/K^a2', -1e9, 1e9, 'modulus: factor of (T in degC)^a2', 'equations 8 and 27'),
    Parameter('a2', 1.381, '1', 0.1, 5.0, 'modulus: exponent', 'equations 8 and 27'),
    Parameter('a3', 536e6, 'Pa', 1e3, 1e12, 'modulus at 0 degC', 'equations 8 and 27'),
    Parameter('C', 0.0, 'J/K', 1e-4, 1e3, 'heat capacity; 0 = m cp', 'derived: m cp'),
    Parameter('B', 0.0, 'm', -1e3, 1e3, 'stroke gain; 0 = L0^2/H0', 'derived: L0^2/H0, equation 16 corrected'),
)
# fmt: on

DERIVED: Mapping[str, Callable[[Mapping[str, float]], float]] = {
    'C': lambda p: p['m'] * p['cp'],
    'B': lambda p: p['L0'] ** 2 / p['H0'],
}

# The compiled model reads a flat vector: the table's rows, then constants made from them and from the effects that
# are on: the quickest process (1/s), and the temperature (K) up to which it is; does one change the heat or bring
# states with rates; is one asked at a point; does one need velocity or force rate.
_CONSTANTS = ('modulus_at_T0', 'fastest_rate', 'hottest', 'integrated', *(f'at_{point}' for point in POINTS), 'motion')
_NAMES = (*(row.name for row in TABLE), *_CONSTANTS)
INDEX: Mapping[str, int] = {name: index for index, name in enumerate(_NAMES)}
SIZE = len(_NAMES)

"""A muscle from its geometry: what fibre, coil and resistance say of the model's parameters, with how far they carry.

The formulas are those of Karami & Tadesse 2017 as corrected in docs/paper.md: L^2 = H^2 + (pi N D)^2 (22), the spring
of torsion k = G d^4/(8 D^3 N) (9 and 10), m cp, and a cylinder in still air. For the paper's own muscle the spring rate
is too small by a factor of 29: measure it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi, sqrt

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle.effects.radiation import STEFAN_BOLTZMANN
from tcp_muscle_ros.muscle.mechanical import reference_modulus
from tcp_muscle_ros.muscle.parameter import GRAVITY
from tcp_muscle_ros.muscle.parameters import Parameters

POISSON = 0.4  # nylon
DENSITY = 1140.0  # kg/m^3, nylon
STIFFEST = 1.13e9  # Pa, shear modulus of a drawn nylon fibre, axial (Choy 1984)
EMISSIVITY = 0.9  # of a polymer's surface
EXCESS = (37.0, 57.0)  # K above the air at which a cylinder is looked at: 60 and 80 degC in a room of 23 degC
# The most that a muscle of known parameters is over what this module says. The paper's: 23 over 0.80 N/m, 0.1 over
# 0.018 g. Sun & Zhao's: 0.0159 over 0.0088 W/K, of turns that do not touch.
STIFFER, HEAVIER, LOSSIER = 29.0, 5.6, 1.82
# Of the heat capacity with the paper's cp. The least: McGinty's 0.357 J/K, measured, over 0.677 of its design's nylon.
# The most with a weighed mass: 2400 J/(kg K), which Sun & Zhao give for silver-coated nylon, over 1700.
SMALLER, LARGER = 0.52, 1.42

Law = Callable[[float, float], float]  # Nusselt number from the Rayleigh and the Prandtl number


@dataclass(frozen=True)
class Coil:
    """A coiled fibre at rest: lengths in m, resistance in ohm; ``mass`` in kg, or None for that of a round nylon fibre.

    Raises:
        BadInput: the coil is as long as its fibre or longer, or its turns are narrower than the fibre is thick.
    """

    fibre_diameter: float
    fibre_length: float
    length: float
    turns: float
    resistance: float
    mass: float | None = None

    def __post_init__(self) -> None:
        for name in ('fibre_diameter', 'fibre_length', 'length', 'turns', 'resistance', 'mass'):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < 1e6:
                raise BadInput(f'{name.replace("_", " ")} = {value:g}: expected a number above 0')
        if self.length >= self.fibre_length:
            raise BadInput(
                f'coil length {1e3 * self.length:g} mm: expected less than the fibre length, '
                f'{1e3 * self.fibre_length:g} mm'
            )
        if self.diameter <= self.fibre_diameter:
            raise BadInput(
                f'{self.turns:g} turns leave a coil of {1e3 * self.diameter:.3g} mm mean diameter, which is not wider '
                f'than the fibre, {1e3 * self.fibre_diameter:g} mm; expected fewer turns'
            )

    @property
    def diameter(self) -> float:
        """The mean diameter of the turns, m. Equation 22."""
        return sqrt(self.fibre_length**2 - self.length**2) / (pi * self.turns)

    @property
    def outer_diameter(self) -> float:
        """What a caliper measures, m."""
        return self.diameter + self.fibre_diameter

    @property
    def fibre_mass(self) -> float:
        """The mass of a round nylon fibre, kg, without coating or wire."""
        return DENSITY * pi / 4 * self.fibre_diameter**2 * self.fibre_length


def spring_rate(shear_modulus: float, fibre_diameter: float, coil_diameter: float, turns: float) -> float:
    """The stiffness (N/m) of a close-coiled spring in torsion. Equation 9, corrected."""
    return shear_modulus * fibre_diameter**4 / (8 * coil_diameter**3 * turns)


def churchill_chu(rayleigh: float, prandtl: float) -> float:
    """The Nusselt number of a horizontal cylinder in still air. Churchill & Chu 1975."""
    bracket = (1 + (0.559 / prandtl) ** (9 / 16)) ** (8 / 27)
    return float((0.60 + 0.387 * rayleigh ** (1 / 6) / bracket) ** 2)


def morgan(rayleigh: float, prandtl: float) -> float:
    """The same after Morgan 1975."""
    for upper, factor, power in ((1e-2, 0.675, 0.058), (1e2, 1.02, 0.148), (1e4, 0.850, 0.188)):
        if rayleigh < upper:
            return float(factor * rayleigh**power)
    return float(0.480 * rayleigh**0.250)


def convection(diameter: float, surface: float, air: float, excess: float, law: Law) -> float:
    """The conductance (W/K) of a cylinder in still air of temperature ``air`` (K), ``excess`` (K) warmer."""
    film = air + excess / 2
    conductivity = 0.0241 * (film / 273.15) ** 0.9
    viscosity, prandtl = 1.33e-5 * (film / 273.15) ** 1.75, 0.71
    rayleigh = GRAVITY / film * excess * diameter**3 / viscosity**2 * prandtl
    loss: float = law(rayleigh, prandtl) * conductivity / diameter * surface  # h A, of h = Nu k / D
    return loss


def radiation(surface: float, air: float, excess: float) -> float:
    """The conductance (W/K) by radiation of a polymer's surface."""
    warm = air + excess
    return EMISSIVITY * STEFAN_BOLTZMANN * (warm**2 + air**2) * (warm + air) * surface


@dataclass(frozen=True)
class Estimate:
    """A value in SI, between what bounds it is likely to lie, and why."""

    value: float
    low: float
    high: float
    why: str


def _exactly(value: float, why: str = 'as given') -> Estimate:
    return Estimate(value, value, value, why)


def estimates(coil: Coil) -> Mapping[str, Estimate]:
    """What the geometry says of the model's parameters, by their names."""
    return {
        'L0': _exactly(coil.fibre_length),
        'H0': _exactly(coil.length),
        'D0': _exactly(coil.outer_diameter, 'D + d, with D from L^2 = H^2 + (pi N D)^2'),
        'm': _mass(coil),
        'k0': _stiffness(coil),
        'R0': _exactly(coil.resistance),
        'hA': _conductance(coil),
        'C': _capacity(coil),
    }


def _mass(coil: Coil) -> Estimate:
    if coil.mass is not None:
        return _exactly(coil.mass)
    mass = coil.fibre_mass
    return Estimate(mass, mass, HEAVIER * mass, 'round nylon fibre; coating, plies and wire come on top: weigh it')


def _stiffness(coil: Coil) -> Estimate:
    soft = reference_modulus(Parameters({}).vector) / (2 * (1 + POISSON))
    rate, stiff = (spring_rate(shear, coil.fibre_diameter, coil.diameter, coil.turns) for shear in (soft, STIFFEST))
    why = f"G d^4/(8 D^3 N); the paper's own muscle is {STIFFER:g} times as stiff as that: measure yours"
    return Estimate(rate, rate, max(stiff, STIFFER * rate), why)


def _conductance(coil: Coil) -> Estimate:
    surface, air = pi * coil.outer_diameter * coil.length, Parameters({})['T0']
    low, high = (
        convection(coil.outer_diameter, surface, air, excess, law) + radiation(surface, air, excess)
        for excess, law in zip(EXCESS, (churchill_chu, morgan), strict=True)
    )
    middle = (low + high) / 2
    why = 'smooth cylinder in still air, Churchill & Chu to Morgan, and radiation; open turns and draught add'
    return Estimate(middle, low, max(high, LOSSIER * middle), why)


def _capacity(coil: Coil) -> Estimate:
    mass, cp = _mass(coil), Parameters({})['cp']
    high = LARGER if mass.low == mass.high else HEAVIER
    return Estimate(
        cp * mass.value, SMALLER * cp * mass.value, high * cp * mass.value, 'm cp, with the cp of the paper'
    )

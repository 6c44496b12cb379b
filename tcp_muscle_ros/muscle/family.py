"""Other twisted and coiled muscles from published sources: each value with the place where it stands.

What a source does not state is that of the paper's muscle (set A), and the file in ``config/`` says so. Distances
between a source and what the model makes of it are in ``docs/parameter_sets.md``.
"""

from collections.abc import Mapping
from math import cos, isclose, pi, radians, sqrt, tan
from typing import NamedTuple

from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS
from tcp_muscle_ros.muscle.table import INDEX, TABLE


class Stated(NamedTuple):
    """A value in SI, and where it stands or how it follows from what is stated there."""

    value: float
    source: str


def _sun_zhao() -> dict[str, Stated]:
    """Silver-coated nylon thread, mandrel-coiled with free stroke: 175 mm of fibre on 66.75 mm.

    Sun & Zhao 2021, Physics-based modeling of twisted-and-coiled actuators using Cosserat rod theory, IEEE Trans.
    Robotics; numbers of the code that its authors publish with it (TCA_TRO: TCA_geo, thermal_model, rod_const_EG,
    TCA_moduli_creeped). Love's rod gives the spring rate at the rest pitch a,

        k0 = cos^2 a (G J + E I tan^2 a) / (r^2 l),

    and the untwist t = (G(T) - 1) 2 pi 720/0.96 per metre, G(T) = p2 T^2 + p1 T + 1 (T in degC), shortens by
    l (r / cos a) t, which has the form of equation 26 with a coefficient linear in T.
    """
    length, fibre, coil, pitch = 0.175, 0.21e-3, 0.406e-3, radians(22.42)
    cold = 25.0
    thick = 0.22e-3  # of rod_const_EG, to which its moduli belong
    bending, torsion = 1.198e9 * pi * thick**4 / 4, 2.2177e8 * pi * thick**4 / 2
    rate = cos(pitch) ** 2 * (torsion + bending * tan(pitch) ** 2) / (coil**2 * length)
    shortening = length * coil / cos(pitch) * 2 * pi * 720 / 0.96  # m, times G(T) - 1
    p2, p1 = 3.54e-6, -6.7e-5
    rest = 66.75e-3
    gain = length**2 / rest
    return {
        'L0': Stated(length, 'TCA_geo: l_t'),
        'H0': Stated(rest, 'TCA_geo: l_m, measured'),
        'D0': Stated(2 * (coil + fibre), 'TCA_geo: 2 (r_m + r_t)'),
        'cp': Stated(2000.0, 'thermal_model: between nylon 1700 and silver-coated 2400'),
        'm': Stated(1127.0**2 / 1000 * length * pi * fibre**2, 'thermal_model: mt as computed there, 1.127 rho V'),
        'k0': Stated(rate, 'rod_const_EG: Love rod with E = 1.198 GPa, G = 0.22177 GPa, r_t = 0.22 mm'),
        'T0': Stated(cold + ZERO_CELSIUS, 'thermal_model: T0'),
        'hA': Stated(23.0 * 3 * 2 * pi * fibre * length, 'thermal_model: h = 23 W/(m^2 K) on 3 x 2 pi r_t l_t'),
        'c1': Stated(-shortening * p2 / gain, 'rod_const_EG: p_Gamma; 1 - 1/Gamma to first order'),
        'c2': Stated(-shortening / gain * (p2 * (cold - ZERO_CELSIUS) + p1), 'rod_const_EG: p_Gamma'),
        'a1': Stated(-1.2 * 1.1e6, 'TCA_moduli_creeped: slope of E_f without load'),
        'a2': Stated(1.0, 'TCA_moduli_creeped: E_f falls in proportion'),
        'a3': Stated(3.9e9 + 1.2 * 1.1e6 * cold, 'TCA_moduli_creeped: E_f at 0 degC'),
    }


def _mcginty() -> dict[str, Stated]:
    """Nylon monofilament of 0.8 mm with an iron wire of 0.25 mm around it, heated by the wire.

    I. McGinty, Redundant actuation of twisted and coiled polymer muscles to improve tracking performance, MSc thesis,
    TU Delft; numbers of its code (TCPM-Optimal-Force-Tracking: initializeTCPAs, getElectrothermalParam, getForce,
    getBlockedTorque). Heat: that of its muscle HV_C as measured; geometry: that of its first design. By Castigliano
    with b = asin(H/L), the spring rate is 1 / f11,

        f11 = 8 L^3/(pi^3 d^4 N^2) (cos^4 b / G + 2 sin^2 b cos^2 b / E) + 4 L/(pi d^2) (cos^2 b / G + sin^2 b / E).
    """
    fibre, index, rest, turns = 0.8e-3, 6.0, 49e-3, 46
    length = sqrt(rest**2 + (pi * turns * index * fibre) ** 2)
    shear, axial = 0.43e9, 2.2e9
    up = (rest / length) ** 2
    torsion = 8 * length**3 / (pi**3 * fibre**4 * turns**2) * ((1 - up) ** 2 / shear + 2 * up * (1 - up) / axial)
    rate = 1 / (torsion + 4 * length / (pi * fibre**2) * ((1 - up) / shear + up / axial))
    gain = length**2 / rest
    # getBlockedTorque and getForce, evaluated from 20 degC: contraction at 40 and at 80 degC.
    (first, less), (second, more) = (40.0, 8.0617e-3), (80.0, 29.1395e-3)
    cold = 20.0
    low, high = -less / gain / (first - cold), -more / gain / (second - cold)
    slope = (high - low) / (second - first)
    wire = 6.41e-3  # 1/K, iron, of the resistance at 20 degC
    return {
        'L0': Stated(length, 'initializeTCPAs: l0 of L0, N = 46, spring index 6'),
        'H0': Stated(rest, 'initializeTCPAs: L0, fully contracted'),
        'D0': Stated((index + 1) * fibre, 'initializeTCPAs: (C + 1) d'),
        'cp': Stated(1310.0, 'getElectrothermalParam: c of nylon'),
        'm': Stated(1140.0 * pi / 4 * fibre**2 * length, 'getElectrothermalParam: rho of nylon, without the wire'),
        'k0': Stated(rate, 'getForce: 1 / f11 at rest with G = 0.43 GPa, E = 2.2 GPa'),
        'R0': Stated(3.6 / (1 + wire * (23 - cold)), 'getElectrothermalParam: 3.6 ohm at 23 degC'),
        'T0': Stated(cold + ZERO_CELSIUS, 'getT_amb'),
        'a_R': Stated(wire, 'getElectrothermalParam: iron, at 20 degC'),
        'hA': Stated(10.4 * pi * fibre * length, 'getElectrothermalParam: h = 10.4 W/(m^2 K) of HV_C on pi d l'),
        'c1': Stated(slope, 'getBlockedTorque, getForce: contraction at 40 and 80 degC'),
        'c2': Stated(low - slope * (first + ZERO_CELSIUS), 'getBlockedTorque, getForce'),
        'a1': Stated(0.0, 'getMaterialProperties: moduli without temperature'),
        'a2': Stated(1.0, 'no meaning while a1 = 0'),
        'a3': Stated(axial, 'getForce: Ez_bar'),
        'C': Stated(0.357, 'getElectrothermalParam: C_th of HV_C, with the iron'),
    }


FAMILY: Mapping[str, Mapping[str, Stated]] = {'sun_zhao_2021': _sun_zhao(), 'mcginty_iron_wire': _mcginty()}

GEOMETRY = ('L0', 'H0', 'D0')  # what makes a coil that coil


def not_stated(name: str, muscle: Mapping[str, float]) -> str:
    """The set of another source whose coil a muscle has, where that does not state ``name`` and nobody else has: its
    value is still that of the paper's muscle. Else ''.
    """

    def same(one: str, value: float) -> bool:
        return isclose(muscle[one], value, rel_tol=1e-6)

    if not same(name, TABLE[INDEX[name]].value):
        return ''
    for known, stated in FAMILY.items():
        if name not in stated and all(same(one, stated[one].value) for one in GEOMETRY):
            return known
    return ''

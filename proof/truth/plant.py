"""The truth's muscle as numbers.

Whatever is a function of one variable is a table (resistivity, heat loss, stiffness ... over temperature;
piezoresistance, exposed area, contact force over length; the spring over extension), so any form can be concealed
without a line in the integration. What has memory is numbers of it. Temperatures in degC, otherwise SI.
"""

from typing import Any, NamedTuple

import numpy as np

CURRENT, POWER, VOLTAGE = 0, 1, 2

T_LOW, T_STEP, T_COUNT = -20.0, 0.05, 5200  # degC, to 240
H_STEP, H_COUNT = 1e-4, 6000  # m, 0 to 0.6
D_LOW, D_STEP, D_COUNT = -0.3, 1e-4, 8000  # extension, m
F_STEP, F_COUNT = 1e-3, 5000  # N

SIGMA = 5.670374e-8
KELVIN = 273.15
GRAVITY = 9.80665

Array = np.ndarray[Any, Any]

T_GRID: Array = T_LOW + T_STEP * np.arange(T_COUNT)
H_GRID: Array = H_STEP * np.arange(H_COUNT)
D_GRID: Array = D_LOW + D_STEP * np.arange(D_COUNT)
F_GRID: Array = F_STEP * np.arange(F_COUNT)
NONE: Array = np.zeros(0)


class Plant(NamedTuple):
    """All numbers of one muscle. Every default is "this physics is absent"."""

    R0: float
    C: float  # J/K
    hA: float  # W/K
    k0: float  # N/m
    H0: float  # m
    T0: float  # degC
    # over temperature
    rho: Array  # R/R0
    loss: Array  # hA factor over T - ambient
    capacity: Array  # C factor
    free: Array  # m, thermal change of length (negative: contraction)
    soft: Array  # k/k0
    shift: Array  # how much faster creep runs than at 50 degC
    loop_centre: Array  # middle of the hysteresis loop, 0..1
    # over length, extension and load
    piezo: Array  # R factor over H
    area: Array  # hA factor over H
    stop: Array  # N over H, pushing the coils apart
    spring: Array  # (force / k0) over extension, m
    gain: Array  # free-stroke factor over load
    # grid
    shell_share: Array  # share of C per shell, skin first
    shell_link: Array  # W/K between neighbouring shells
    shell_pull: Array  # share of each shell in what drives the stroke
    shell_beside: int = 0  # 1: every link goes to the skin, none from shell to shell
    axial_nodes: int = 1
    axial_link: float = 0.0  # W/K between neighbouring axial nodes
    clamp_link: float = 0.0  # W/K from an end node to a clamp at ambient
    clamp_mass: float = 0.0  # J/K of a clamp (0: it stays at ambient)
    profile: Array = NONE  # hA factor along the coil (empty: 1)
    # electrical
    contact: float = 0.0  # ohm in the crimps
    supply: int = 0  # 1: two poles, 2: slew limit, 3: a loop that overshoots, 4: it gives sooner than it takes
    supply_rate: float = 0.0  # 1/s; slew: full scale per second; loop: rad/s
    supply_damping: float = 0.5  # of the loop
    # 1: parabolic oxidation, 2: cracks per stretch, 3: electromigration, 4: thermal cycling, 5: heals under current
    ageing: int = 0
    ageing_rate: float = 0.0
    ageing_tau: float = 30.0  # s, of what heals
    # thermal
    emission: float = 0.0  # eps A, m2, at 60 degC
    emission_rise: float = 0.0  # 1/K
    wall_offset: float = 0.0  # K
    motion: int = 0  # 1: power of still and moving air, 2: square root, 3: mixed convection, 4: air that goes along
    motion_gain: float = 0.0  # at 10 mm/s
    latent: float = 0.0  # J, kinetic order-disorder
    latent_at: float = 60.0
    latent_width: float = 3.0
    latent_tau: float = 1.0
    latent_cooler: float = 0.0  # K, how much lower the way back lies
    water: int = 0  # 1: two populations, 2: diffusion through rings, 3: vapour pressure at the surface, 4: Elovich
    water_share: float = 0.0  # kg/kg at the start
    water_tau: float = 10.0  # s at 60 degC
    water_mass: float = 1e-4  # kg of polymer
    elastocaloric: float = 0.0  # 1 = thermodynamics
    elastocaloric_loss: float = 0.0  # share that does not come back on unloading
    elastocaloric_late: float = 0.0  # share of the heat that comes late
    elastocaloric_tau: float = 1.0  # s, how late
    elastocaloric_power: float = 0.0  # of the load relative to 0.6 N
    load_loss: float = 0.0  # share of hA that 0.6 N more add
    # mechanical
    creep: Array = NONE  # compliances relative to 1/k
    creep_tau: Array = NONE  # s at 50 degC
    flow: int = 0  # 1: Eyring, 2: power law with hardening, 3: Bingham, 4: Norton's power, above the glass alone
    flow_rate: float = 0.0  # m/s at 0.6 N and 60 degC
    flow_heat: float = 0.05  # 1/K
    flow_scale: float = 0.4  # N (Bingham: the yield load), or the exponent
    relay_up: Array = NONE
    relay_down: Array = NONE
    relay_weight: Array = NONE
    relay_stroke: float = 0.0  # m
    relay_cooled: int = 0  # 1: they have come down from the heat, else up from the cold
    wall_stroke: float = 0.0  # m, of domains whose walls are held up where they are
    wall_at: float = 55.0  # degC, where as many have turned as have not
    wall_half: float = 5.0  # K, by how much held walls put it off at most
    wall_lean: float = 17.0  # K from there to where all would have turned, if they resisted no more than at first
    wall_grip: float = 6.0  # after how short a way they are held as firmly as they can be
    wall_rest: float = 0.1  # K, no turn of the temperature that is smaller is one
    phase_stroke: float = 0.0  # m, of a phase that comes at one temperature and goes at a lower one
    phase_at: float = 55.0
    phase_half: float = 5.0  # K, from the middle to either
    phase_width: float = 7.0  # K
    branch: int = 0  # 1: exponential approach, 2: saturating, 3: play between two curves, 4: a lens from the turn
    branch_share: float = 0.0
    branch_from: float = 50.0
    branch_path: float = 6.0  # K
    frozen: Array = NONE  # m per element
    frozen_at: Array = NONE  # degC
    frozen_tau: float = 3.0
    frozen_sharp: float = 1.0  # 1/K
    fixed: float = 0.0  # m, set free by the highest temperature so far
    fixed_span: float = 15.0  # K
    fixed_way: float = 0.0  # K of warming, all of it added up, that leave one part in e (0: the highest counts)
    fatigue: int = 0  # 1: power of the dose, 2: saturating, 3: a dose that counts hot ways more, 4: growing cracks
    fatigue_share: float = 0.0
    fatigue_shape: float = 0.3
    mass: int = 0  # 1: linear damping, 2: drag on top, 3: a damper that relaxes, 4: a part of it hangs loose
    mass_damping: float = 0.05
    mass_drag: float = 0.0  # N s2/m2
    loose_share: float = 0.0  # of the mass
    loose_pace: float = 1.0  # of its own swing relative to that of all
    rub: int = 0  # 1: Dahl, 2: Maxwell slip elements, 3: a pulley, whose limits go with the load, 4: Bouc and Wen
    rub_limit: Array = NONE  # N (pulley: under 0.6 N)
    rub_reach: Array = NONE  # m
    twist: float = 0.0  # m at 0.6 N, 70 degC
    twist_tau: float = 60.0
    twist_grip: float = 0.0  # share of that torque below which the end holds
    twist_power: float = 0.0  # of time, with which the grip relaxes (0: it does not)
    twist_heat: float = 0.05  # 1/K, by how much faster when hotter
    twist_soft: float = 0.7  # logarithm by which the grip falls from T0 to 70 degC
    twist_back: float = 0.6  # share of that torque that a turn of `twist` gives back
    twist_clamp: float = 0.25  # share of the grip under 0.6 N that is the clamp's, whatever hangs on it
    twist_uphill: float = 2.0  # how much more the grip resists turning back
    twist_rested: float = 3.0  # s at 70 degC by which it has relaxed before anything is measured
    twist_log: float = 0.0  # turns of `twist` that make the next harder by one part in e (0: none does)
    # in no catalogue
    peltier: float = 0.0  # V
    varistor: float = 0.0  # share at 0.27 A
    switch_time: float = 1e9  # s
    switch_resistance: float = 0.0
    switch_stiffness: float = 0.0
    rate_stroke: float = 0.0
    current_stroke: float = 0.0  # m/A2
    resonance: float = 0.0
    resonance_rate: float = 2.5  # rad/s
    resonance_damping: float = 0.05
    hunting: float = 0.0  # share of the input
    hunting_rate: float = 1.0  # rad/s
    rail_link: float = 0.0  # W/K from the muscle to a rail that it touches
    rail_mass: float = 1.0  # J/K
    rail_loss: float = 0.01  # W/K from the rail to the room
    surge: float = 0.0  # m/K, contraction with a change of temperature that is soon forgotten
    surge_tau: float = 20.0  # s
    worked_soft: float = 0.0  # share of the stiffness that motion takes away
    worked_tau: float = 20.0  # s in which rest gives it back
    overload: float = 0.0  # share of the stroke that a load 1 N above 0.3 N costs from then on


# The columns of what `run` returns.
SKIN, MEAN, RESISTANCE, LENGTH, FORCE, AMPERE, WATT, WATER = range(8)

"""Concealed physics of the electrical stage."""

import numpy as np
from scipy.stats import norm

from proof.truth.concealed import Draw, Outcome, effect, reached
from proof.truth.plant import H_GRID, T_GRID


@effect(
    'resistance_strain',
    'electrical',
    ('power_of_length', 'saturating', 'pitch_of_helix'),
    ('paper', 'load_steps_cold', 'load_steps_hot'),
)
def resistance_strain(d: Draw) -> Outcome:
    """Piezoresistance: R grows with the coil's length: as a power of it, saturating, or with the pitch of the helix."""
    gauge = d.between(0.04, 1.2)
    H0 = d.body.H0
    strain = H_GRID / H0 - 1.0
    if d.form == 0:
        factor = np.maximum(H_GRID / H0, 0.05) ** gauge
    elif d.form == 1:
        limit = d.any(0.5, 0.9)
        factor = 1.0 + gauge * limit * np.tanh(strain / limit)
    else:  # the wire on the skin is strained as the square of the sine of the pitch angle, H/L
        factor = 1.0 + gauge * ((H_GRID / H0) ** 2 - 1.0) / 2.0
    return {'gauge_factor': gauge}, lambda b: b.scale('piezo', np.maximum(factor, 0.1))


@effect(
    'contact_shorting',
    'electrical',
    ('normal_gaps', 'weibull_gaps', 'hertz_bridges'),
    ('light_hot', 'paper_light', 'rates_light'),
)
def contact_shorting(d: Draw) -> Outcome:
    """Coils that touch bridge the wire: as their gaps are distributed, or all at one length, better when pressed."""
    share, width = d.between(0.015, 0.30), d.any(0.003, 0.008)
    at = float(np.clip(reached(d, 0.2) + d.any(0.002, 0.010), 0.084, 0.130))
    if d.form == 0:
        touching = norm.cdf((at - H_GRID) / width)
    elif d.form == 1:
        touching = 1.0 - np.exp(-((np.maximum(at + width - H_GRID, 0.0) / (1.6 * width)) ** 1.7))
    else:  # the spot of contact of two cylinders grows as the square root of the way; beside the wire
        spot = np.sqrt(np.maximum(at + 0.5 * width - H_GRID, 0.0) / (1.7 * width))
        touching = spot / (1.0 + share * spot)
    return {'share': share, 'length': at, 'width': width}, lambda b: b.scale('piezo', 1.0 - share * touching)


@effect('contact_resistance', 'electrical', ('crimps',), ('paper',))
def contact_resistance(d: Draw) -> Outcome:
    """A constant resistance in the crimps: invisible on one muscle."""
    ohm = d.between(0.1, 1.0)
    return {'ohm': ohm}, lambda b: b.set(contact=ohm)


@effect('tcr_curvature', 'electrical', ('saturating', 'leak_path', 'bend_at_glass'), ('paper', 'hold', 'paper'))
def tcr_curvature(d: Draw) -> Outcome:
    """R(T) is not straight: its slope saturates, a path beside the silver opens when hot, or the soft nylon lets go."""
    curvature = d.between(1.2e-6, 1.0e-5)
    theta = T_GRID - d.body.T0
    a_R = d.body.a_R
    if d.form == 0:
        rho = 1.0 + a_R * theta / (1.0 + theta.clip(-30.0) * curvature / a_R)
    elif d.form == 1:
        straight = 1.0 + a_R * theta
        beside = curvature * 57.0**2 * np.expm1(theta.clip(-30.0, 120.0) / 35.0) / np.expm1(57.0 / 35.0)
        rho = straight / (1.0 + beside)
    else:  # above the glass transition the fibre strains its coat less
        at, width = d.any(40.0, 54.0), 4.0
        above = np.logaddexp(0.0, (T_GRID - at) / width)
        rho = 1.0 + a_R * theta - curvature * 57.0**2 * above / np.logaddexp(0.0, (80.0 - at) / width)
    return {'curvature': -curvature}, lambda b: b.set(rho=rho)


@effect(
    'resistance_drift',
    'electrical',
    ('parabolic_oxide', 'stretch_cracks', 'electromigration'),
    ('paper', 'repeat', 'hold'),
)
def resistance_drift(d: Draw) -> Outcome:
    """R0 grows: with an oxide as the square root of (hot) time, with every stretch, or where current and heat flow."""
    rate = d.between(0.002, 0.02)
    return {'rate': rate}, lambda b: b.set(ageing=1 + d.form, ageing_rate=rate)


@effect('supply_lag', 'electrical', ('two_poles', 'slew_limit', 'overshooting_loop'), ('prbs', 'paper', 'prbs'))
def supply_lag(d: Draw) -> Outcome:
    """The supply follows late: two equal poles, no faster than its slew rate, or a loop that overshoots."""
    lag = d.between(0.1, 0.6)
    if d.form == 0:
        return {'lag': lag}, lambda b: b.set(supply=1, supply_rate=2.0 / lag)
    if d.form == 1:
        return {'lag': lag}, lambda b: b.set(supply=2, supply_rate=0.13 / lag)
    damping = d.any(0.4, 0.65)
    return {'lag': lag, 'damping': damping}, lambda b: b.set(
        supply=3, supply_rate=2.0 * damping / lag, supply_damping=damping
    )

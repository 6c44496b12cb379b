"""Concealed physics of the electrical stage."""

import numpy as np
from scipy.stats import norm

from proof.truth.bench import Bench
from proof.truth.concealed import Draw, Outcome, effect, reached
from proof.truth.plant import H_GRID, T_GRID


@effect(
    'resistance_strain', 'electrical', ('power_of_length', 'saturating'), ('paper', 'load_steps_cold', 'load_steps_hot')
)
def resistance_strain(d: Draw) -> Outcome:
    """Piezoresistance: R grows with the coil's length, as a power of it or saturating."""
    gauge = d.between(0.04, 1.2)
    H0 = d.body.H0
    strain = H_GRID / H0 - 1.0
    if d.form == 0:
        factor = np.maximum(H_GRID / H0, 0.05) ** gauge
    else:
        limit = d.any(0.5, 0.9)
        factor = 1.0 + gauge * limit * np.tanh(strain / limit)
    return {'gauge_factor': gauge}, lambda b: b.scale('piezo', np.maximum(factor, 0.1))


@effect('contact_shorting', 'electrical', ('normal_gaps', 'weibull_gaps'), ('light_hot', 'paper_light', 'rates_light'))
def contact_shorting(d: Draw) -> Outcome:
    """Coils that touch bridge the wire: the share that touches follows the distribution of the gaps."""
    share, width = d.between(0.015, 0.30), d.any(0.003, 0.008)
    at = float(np.clip(reached(d, 0.2) + d.any(0.002, 0.010), 0.084, 0.130))
    if d.form == 0:
        touching = norm.cdf((at - H_GRID) / width)
    else:
        touching = 1.0 - np.exp(-((np.maximum(at + width - H_GRID, 0.0) / (1.6 * width)) ** 1.7))
    return {'share': share, 'length': at, 'width': width}, lambda b: b.scale('piezo', 1.0 - share * touching)


@effect('contact_resistance', 'electrical', ('crimps',), ('paper',))
def contact_resistance(d: Draw) -> Outcome:
    """A constant resistance in the crimps: invisible on one muscle."""
    ohm = d.between(0.1, 1.0)
    return {'ohm': ohm}, lambda b: b.set(contact=ohm)


@effect('tcr_curvature', 'electrical', ('saturating', 'leak_path'), ('paper', 'hold', 'paper'))
def tcr_curvature(d: Draw) -> Outcome:
    """R(T) is not straight: a slope that saturates, or a path beside the silver that opens when hot."""
    curvature = d.between(1.2e-6, 1.0e-5)
    theta = T_GRID - d.body.T0
    a_R = d.body.a_R
    if d.form == 0:
        rho = 1.0 + a_R * theta / (1.0 + theta.clip(-30.0) * curvature / a_R)
    else:
        straight = 1.0 + a_R * theta
        beside = curvature * 57.0**2 * np.expm1(theta.clip(-30.0, 120.0) / 35.0) / np.expm1(57.0 / 35.0)
        rho = straight / (1.0 + beside)
    return {'curvature': -curvature}, lambda b: b.set(rho=rho)


@effect('resistance_drift', 'electrical', ('parabolic_oxide', 'stretch_cracks'), ('paper', 'repeat', 'hold'))
def resistance_drift(d: Draw) -> Outcome:
    """R0 grows: with an oxide as the square root of (hot) time, or with every stretch of the coil."""
    rate = d.between(0.002, 0.02)
    if d.form == 0:
        return {'rate': rate}, lambda b: b.set(ageing=1, ageing_rate=rate)
    return {'rate': rate}, lambda b: b.set(ageing=2, ageing_rate=rate)


@effect('supply_lag', 'electrical', ('two_poles', 'slew_limit'), ('prbs', 'paper', 'prbs'))
def supply_lag(d: Draw) -> Outcome:
    """The supply follows late: two equal poles, or no faster than its slew rate."""
    lag = d.between(0.1, 0.6)
    if d.form == 0:
        return {'lag': lag}, lambda b: b.set(supply=1, supply_rate=2.0 / lag)
    return {'lag': lag}, lambda b: b.set(supply=2, supply_rate=0.13 / lag)


# --- in no catalogue --------------------------------------------------------------------------------------------------


@effect('varistor', 'electrical', ('current_squared',), ('paper', 'prbs'), listed=False)
def varistor(d: Draw) -> Outcome:
    """A contact whose resistance falls with current."""
    share = -d.between(0.01, 0.06)
    return {'share': share}, lambda b: b.set(varistor=share)


@effect('resistance_jump', 'electrical', ('sudden',), ('paper', 'hold'), listed=False)
def resistance_jump(d: Draw) -> Outcome:
    """A strand breaks once."""
    share, at = d.between(0.008, 0.06), d.any(60.0, 160.0)

    def change(b: Bench) -> None:
        b.set(switch_resistance=share, switch_time=at)

    return {'share': share, 'time': at}, change

"""What changes while a Plant is integrated: numbers by name, and arrays."""

import math
from typing import Any, NamedTuple

import numpy as np

from proof.truth.plant import Array, Plant

_NUMBERS = (
    # of the step: its end and length (s), the room (degC), the heat loss factor of the wind, the stiffness (N/m)
    *('now', 'h', 'outside', 'wind', 'stiff'),
    # the end of the muscle: length (m), speed (m/s), where it is held, its zero, load now and a step ago (N)
    *('H', 'V', 'held', 'zero', 'F', 'F_prev'),
    # temperatures (degC): mean over the muscle now and a step ago, of the clamp, of a rail that it touches
    *('mean', 'before', 'clamp', 'rail'),
    # smoothed: |dH/dt| (m/s), dT/dt (K/s)
    *('speed', 'warming'),
    # electrical: the input behind its supply and the supply's own state, current (A), age (factor of R)
    *('pole1', 'pole2', 'i', 'aged', 'oxide', 'cracked', 'longest'),
    # thermal: ordered share, water (kg/kg), heat that comes late (K)
    *('order', 'wet', 'heat_to_come'),
    # what the length remembers (m, or shares)
    *('slipped', 'flowed', 'turned', 'relaxed', 'phase', 'branch', 'leaning', 'peak', 'fixed_from', 'dose'),
    # held walls: which way (1: warmer), the order (-1 to 1) now and at the last turn, how much of their hold was left
    # there, and the temperature at its furthest since
    *('way', 'aligned', 'aligned_turned', 'holding', 'furthest'),
    # a stroke that rings, a damper that relaxes, and the changes of temperature that are not yet forgotten (K)
    *('ring', 'ring_v', 'damped', 'surge'),
    # where it turned to cool (degC), all of its warming so far (K), a part that hangs loose (m, m/s), how much motion
    # has worked it (share), the largest load so far (N)
    *('crest', 'freed', 'loose', 'loose_v', 'worked', 'heaviest'),
)
STATE = np.dtype([*((name, np.float64) for name in _NUMBERS), ('first', np.bool_), ('ring_on', np.bool_)])
State = Any  # a record of STATE


class Arrays(NamedTuple):
    """``T`` (degC) of all nodes with its rates and the point ahead, shape (axial, shells); and by element: friction,
    relays, creep (m), what is still frozen (share), water (kg/kg)."""

    T: Array
    rate: Array
    rate2: Array
    ahead: Array
    rubbing: Array
    relays: Array
    left: Array
    z: Array
    water: Array


def begin(p: Plant, ambient: float, warm: float, load: float, dose: float) -> tuple[State, Arrays]:
    """At the first tick: ``warm`` K above the room, under the first load (N), ``dose`` cycles behind it."""
    nodes, shells = p.axial_nodes, len(p.shell_share)
    T = np.full((nodes, shells), ambient + warm)
    arrays = Arrays(
        T,
        *(np.empty_like(T) for _ in range(3)),
        np.zeros(len(p.rub_limit)),
        np.full(len(p.relay_up), 1.0 if p.relay_cooled > 0 else 0.0),
        np.ones(len(p.frozen)),
        np.zeros(len(p.creep)),
        np.full(6, p.water_share),
    )
    s = np.zeros(1, STATE).view(np.recarray)[0]
    s.clamp = s.rail = ambient
    s.F = s.F_prev = load
    s.mean = s.peak = s.fixed_from = ambient + warm
    s.phase = 1.0 / (1.0 + math.exp(-(s.peak - p.phase_at - p.phase_half) / p.phase_width))
    s.way, s.aligned_turned, s.holding = -1.0, 1.0, 2.0  # it has cooled down, from where all had turned
    s.aligned, s.furthest = -0.9, s.peak  # the order itself is found in the first step
    s.relaxed = p.twist_rested
    s.aged = 1.0
    s.wet = p.water_share
    s.dose = dose
    s.first = True
    return s, arrays

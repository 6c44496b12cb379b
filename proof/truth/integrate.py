"""The integration of a Plant in time.

The muscle is a grid: axial nodes along the coil, radial shells in the fibre (0 = skin). Steps of about 5 ms: Heun for
heat, exact exponentials for relaxations, a balance of forces for the length.
"""

import math

import numpy as np
from numba import njit

from proof.truth.length import begin_length, pull
from proof.truth.memory import remembered
from proof.truth.plant import Array, Plant
from proof.truth.state import Arrays, State, begin
from proof.truth.stroke import drive_stroke
from proof.truth.supplying import age, ampere, resistance, supply
from proof.truth.warming import warm_up


def run(
    p: Plant,
    time: Array,
    drive: Array,
    kind: int,
    load: Array,
    ambient: Array,
    wind: Array,
    slip: Array,
    substeps: int,
    blocked: bool,
    dose: float,
    warm: float,
) -> tuple[Array, float, float]:
    """Integrate over the ticks `time`; inputs hold from their tick to the next.

    ambient, wind (hA factor) and slip (m added to the length at that tick) are the environment's. dose: cycles of 57 K
    that the muscle has behind it; warm: how far above the room it starts, K. Returns a column for each of SKIN..WATER,
    the zero of displacement (the length at rest at T0 under the first load), and the new dose.
    """
    s, m = begin(p, ambient[0], warm, load[0], dose)
    out = np.empty((len(time), 8))
    integrate(p, s, m, False, time, drive, kind, load, ambient, wind, slip, substeps, blocked, out)
    return out, float(s.zero), float(s.dose)


@njit(cache=True)
def integrate(
    p: Plant,
    s: State,
    m: Arrays,
    begun: bool,
    time: Array,
    drive: Array,
    kind: int,
    load: Array,
    ambient: Array,
    wind: Array,
    slip: Array,
    substeps: int,
    blocked: bool,
    out: Array,
) -> None:
    """Every tick into its row of ``out``; with ``begun`` it goes on from the first, whose row is left as it is.

    Pass -1 settles the length; pass k goes from tick k to k + 1 and then writes the state of tick k + 1: a state is
    what was before the inputs of its own tick act.
    """
    if not begun:
        begin_length(p, s, m, ambient[0])
    for k in range(0 if begun else -1, len(time) - 1):
        settling, held = k < 0, max(k, 0)
        steps = 1 if settling else substeps
        s.now = time[held]
        s.h = 1e-9 if settling else (time[k + 1] - s.now) / steps
        s.slipped += slip[held]
        if not blocked:
            s.F = load[held]
        s.outside, s.wind = ambient[held], wind[held]
        for _s in range(steps):
            _step(p, s, m, 0.0 if settling else drive[k], kind, settling, blocked)
        _show(p, s, m, kind, drive[k + 1], out[k + 1])


@njit(cache=True, inline='always')
def _step(p: Plant, s: State, m: Arrays, asked: float, kind: int, settling: bool, blocked: bool) -> None:
    s.now += s.h
    if p.hunting != 0.0 and not settling:
        asked = asked * (1.0 + p.hunting * math.sin(p.hunting_rate * s.now))
    supply(p, s, asked)
    age(p, s)
    ohm, R = resistance(p, m.T, s.H, s.aged)
    s.i = ampere(p, kind, s.pole2, R)
    ohm *= 1.0 + p.varistor * (s.i / 0.27) ** 2
    warm_up(p, s, m, ohm, settling)
    thermal = drive_stroke(p, s, m)
    inside = remembered(p, s, m)
    pull(p, s, m, p.H0 + thermal + inside, blocked)
    s.first = False


@njit(cache=True, inline='always')
def _show(p: Plant, s: State, m: Arrays, kind: int, next_drive: float, row: Array) -> None:
    """The columns SKIN..WATER of a tick."""
    _, R = resistance(p, m.T, s.H, s.aged)
    s.i = ampere(p, kind, s.pole2 if p.supply > 0 else next_drive, R)
    R *= 1.0 + p.varistor * (s.i / 0.27) ** 2
    nodes = m.T.shape[0]
    row[0] = m.T[0 if nodes == 1 else nodes - 1, 0]  # the thermometer is far from the clamp (the middle)
    row[1] = s.mean
    row[2] = R + p.contact
    row[3] = s.H
    row[4] = s.F
    row[5] = s.i
    row[6] = s.i * s.i * R
    row[7] = s.wet

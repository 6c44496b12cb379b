#!/usr/bin/env python3
"""The signature of every effect, drawn by the model: docs/images/effects/NAME.png (names as arguments draw only those).

Each shows what the effect adds to the resolved model under the paper's protocol (25 s on and 45 s off at 0.27 A, three
cycles, 30, 60 and 100 g), and the stroke over the temperature with and without it. Two effects answer to the load and
not to the current: theirs are load steps.
"""

import sys
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

from tcp_muscle_ros.muscle import EFFECTS, Outputs, Parameters, length, simulate
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.report.style import AFTER, COOLING, HEATING, canvas

FOLDER = Path(__file__).parents[1] / 'docs' / 'images' / 'effects'
NOMINAL = Parameters.named('karami_tadesse_2017')
GRAMS = {30: COOLING, 60: AFTER, 100: HEATING}
NEWTON = 9.80665e-3  # a gram
LOAD_STEPS = {'elastocaloric': (20.0, 120.0), 'inertia': (0.02, 6.0)}  # sampling and duration, s


def paper_protocol() -> tuple[Array, Array, dict[str, Array]]:
    """Time, current and the loads of E0."""
    time = np.arange(0.0, 210.0, 0.05)
    current = 0.27 * (np.mod(time, 70.0) < 25.0)
    return time, current, {f'{grams} g': np.full(time.size, grams * NEWTON) for grams in GRAMS}


def load_steps(step: float, duration: float) -> tuple[Array, Array, dict[str, Array]]:
    """A warm muscle whose load goes from 30 g to the label's and back."""
    time = np.arange(0.0, duration, min(step, 0.05))
    middle = np.abs(time / duration - 0.5) < 0.17
    loads = {f'{grams} g': np.where(middle, grams, 30) * NEWTON for grams in (60, 100)}
    return time, np.full(time.size, 0.2), loads


def draw(name: str) -> None:
    """Draw one effect."""
    time, current, loads = load_steps(*LOAD_STEPS[name]) if name in LOAD_STEPS else paper_protocol()
    figure, (dT, dR, dx, loop) = canvas(1, 4, width=11.0, height=2.1)
    colours = dict(zip(('30 g', '60 g', '100 g'), GRAMS.values(), strict=True))

    def run(p: Parameters, load: Array) -> Outputs:
        warm = {'temperature': 335.0} if name in LOAD_STEPS else {}
        return simulate(p, time, current, load=load, **warm)

    for label, load in loads.items():
        plain, real = run(NOMINAL, load), run(NOMINAL.with_effects(name), load)
        colour = colours[label]
        flows = np.where(current > 0.0, 1.0, np.nan)
        dT.plot(time, real.temperature - plain.temperature, color=colour, linewidth=1.0, label=label)
        dR.plot(time, (real.resistance - plain.resistance) * flows, color=colour, linewidth=1.0)
        dx.plot(time, 1e3 * (real.displacement - plain.displacement), color=colour, linewidth=1.0)
        if label == '60 g':
            rest = length(NOMINAL, NOMINAL['T0'], load[0])
            beside = 1e3 * (real.displacement - (rest - length(NOMINAL, real.temperature, load)))
            warming = np.gradient(real.temperature) > 0.0
            for rising, shade in ((True, HEATING), (False, COOLING)):
                branch = np.where(warming == rising, beside, np.nan)
                loop.plot(real.temperature - 273.15, branch, color=shade, linewidth=1.0)
    titles = (
        'added temperature (K)',
        'added resistance (ohm)',
        'added stroke (mm)',
        'stroke beside its model (mm), 60 g',
    )
    for axis, title, least in zip((dT, dR, dx, loop), titles, (0.2, 0.02, 0.05, 0.05), strict=True):
        low, high = axis.get_ylim()
        low, high = min(low, -least), max(high, least)  # no panel is filled by less than noise
        axis.set_ylim(low, high + 0.05 * (high - low))
        axis.set_title(title, fontsize=8)
        axis.set_xlabel('time (s)', fontsize=7)
    loop.set_xlabel('temperature (degC), orange: rising', fontsize=7)
    dT.legend(fontsize=6, frameon=False, handlelength=1.0)
    for axis in (dT, dR, dx, loop):
        axis.tick_params(labelsize=6)
    page = BytesIO()
    figure.savefig(page, dpi=80)
    with Image.open(page) as image:  # a palette of 32 colours: a third of the size
        image.convert('RGB').quantize(32).save(FOLDER / f'{name}.png', optimize=True)


if __name__ == '__main__':
    FOLDER.mkdir(parents=True, exist_ok=True)
    for effect in sys.argv[1:] or EFFECTS:
        draw(effect)
        print(FOLDER / f'{effect}.png')

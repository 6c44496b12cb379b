#!/usr/bin/env python3
"""The tables of docs/paper.md, computed by the package.

Prints them; with --update writes them into the document between their markers, and draws docs/images/paper.png.
"""

import argparse
import re
from collections.abc import Callable, Iterable
from math import pi, sqrt
from pathlib import Path

import numpy as np
from scipy.optimize import brentq, curve_fit

from tcp_muscle_ros.muscle import (
    SETS,
    ZERO_CELSIUS,
    Muscle,
    Parameters,
    critical_current,
    length,
    simulate,
    steady_current,
    steady_temperature,
    stiffness,
)

DOCUMENT = Path(__file__).parents[1] / 'docs' / 'paper.md'
FIGURE = DOCUMENT.parent / 'images' / 'paper.png'

A = Parameters.named('karami_tadesse_2017')
B = Parameters.named('karami_tadesse_2017_set_b')
PRINTED = Parameters.named('karami_tadesse_2017_as_printed')

# What the paper gives besides its table: turns, fibre, silver coating; currents, loads, times. Nylon's Poisson ratio.
TURNS, FIBRE, COATING, POISSON = 280, 0.2e-3, 100e-9, 0.4
CURRENTS, GRAMS, ON, OFF = (0.18, 0.21, 0.24, 0.27), (30, 60, 100), 25.0, 45.0
# From handbooks.
SILVER_RESISTIVITY, NYLON_DENSITY, MU0, STEFAN_BOLTZMANN, GRAVITY = 1.59e-8, 1140.0, 4e-7 * pi, 5.670e-8, 9.80665
LOADS = tuple(1e-3 * grams * GRAVITY for grams in GRAMS)


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    head = list(head)
    return '\n'.join('| ' + ' | '.join(cells) + ' |' for cells in (head, ['---'] * len(head), *rows))


def modulus(celsius: float) -> float:
    """Equation 27 as it stands, MPa; the temperature's unit is the caller's reading."""
    return 1e-6 * (A['a1'] * celsius ** A['a2'] + A['a3'])


def softening(celsius: float) -> float:
    """E(T)/E(T0)."""
    return float(stiffness(A, celsius + ZERO_CELSIUS)) / A['k0']


def cycles(p: Parameters, current: float, count: int = 3, on: float = ON) -> list[tuple[float, float]]:
    """Peak and trough (degC) of each cycle."""
    muscle = Muscle(p)
    found = []
    for _ in range(count):
        peak = muscle.step(on, current).temperature
        found.append((peak - ZERO_CELSIUS, muscle.step(OFF, 0.0).temperature - ZERO_CELSIUS))
    return found


def peak(p: Parameters, current: float, on: float = ON) -> float:
    """First peak, degC."""
    return cycles(p, current, 1, on)[0][0]


def identified(target: float, on: float = ON) -> float:
    """The hA (W/K) that gives this first peak (degC) at the highest current."""
    return brentq(lambda hA: peak(A.replace(hA=hA), CURRENTS[-1], on) - target, 0.005, 0.05, xtol=1e-12)


def contact(turn_height: float) -> float:
    """The temperature (degC) at which the coils touch under the lightest load, by the height of one turn (m)."""
    return brentq(lambda t: float(length(A, t + ZERO_CELSIUS, LOADS[0])) - TURNS * turn_height, 23.0, 120.0)


def power_law_error(celsius: bool) -> tuple[float, float]:
    """Exponent of the least-squares power law for E(T)/E(T0) on 23 to 100 degC, and its largest error, %."""
    t = np.linspace(23.0, 100.0, 2001)
    ratio = np.array([modulus(value) for value in t]) / modulus(23.0)
    scaled = (t if celsius else t + ZERO_CELSIUS) / 60.0
    (factor, exponent), _ = curve_fit(lambda x, g, b: g * x**b, scaled, ratio, p0=(0.8, -1.0))
    return float(exponent), 100.0 * float(np.max(np.abs(factor * scaled**exponent / ratio - 1.0)))


# The geometry, as equation 22 closes it.
L0, H0, D0 = A['L0'], A['H0'], A['D0']
WOUND = L0**2 - H0**2  # (pi N D)^2
COLD, HOT = 23.0, 80.0  # degC
Row = tuple[str, str, str]


def coefficient(temperature: float) -> float:
    """Equation 26 as it stands, 1e-6 /K; the temperature's unit is the caller's reading."""
    return 1e6 * (A['c1'] * temperature + A['c2'])


def thermal_findings() -> list[Row]:
    envelope = pi * D0 * H0
    film = A['hA'] / envelope
    warm, cold = 60.0 + ZERO_CELSIUS, COLD + ZERO_CELSIUS
    radiation = 0.9 * STEFAN_BOLTZMANN * (warm**2 + cold**2) * (warm + cold)
    share = 100 * radiation / film
    silver = SILVER_RESISTIVITY * L0 / (pi * FIBRE * COATING)
    return [
        ('1', "film coefficient of set A on the coil's envelope", f'{film:.0f} W/(m² K)'),
        ('1', 'the same if hA were 0.15 W/K', f'{PRINTED["hA"] / envelope:.0f} W/(m² K)'),
        ('1', 'radiation at 60 °C with emissivity 0.9', f'{radiation:.1f} W/(m² K), {share:.0f} % of that of set A'),
        ('2', '100 nm of silver on one 0.2 mm fibre', f'{silver:.0f} Ω; measured {A["R0"]:.0f} Ω'),
        ('4', 'rise of R at 80 °C', f'{100 * A["a_R"] * (HOT - COLD):.1f} %'),
        ('6', 'first peak at 0.27 A if R did not rise', f'{peak(A.replace(a_R=0.0), 0.27):.1f} °C'),
    ]


def stiffness_findings() -> list[Row]:
    shear = 1e6 * modulus(COLD) / (2.0 * (1.0 + POISSON))
    printed, corrected = (a**4 * shear / (8.0 * b**3 * TURNS) for a, b in ((D0, FIBRE), (FIBRE, D0)))
    by_celsius, by_kelvin = power_law_error(True), power_law_error(False)
    return [
        ('9', 'k with D and d as printed', f'{printed:.0f} N/m'),
        ('9', 'k with D and d exchanged back', f'{corrected:.2f} N/m; measured {A["k0"]:.0f} N/m'),
        ('12', 'fitted power law, °C, 23 to 100 °C', f'exponent {by_celsius[0]:.2f}, up to {by_celsius[1]:.1f} % off'),
        ('12', 'fitted power law, K, 23 to 100 °C', f'exponent {by_kelvin[0]:.2f}, up to {by_kelvin[1]:.1f} % off'),
        ('27', 'E at 23, 80, 100 °C', ', '.join(f'{modulus(t):.0f}' for t in (COLD, HOT, 100.0)) + ' MPa'),
        ('27', 'E/E(T0) at 80, 100, 120 °C', ', '.join(f'{softening(t):.3f}' for t in (HOT, 100.0, 120.0))),
        ('27', 'E at 23 °C if T were in K', f'{modulus(COLD + ZERO_CELSIUS):.0f} MPa'),
        ('27', 'temperature at which E would be 0', f'{(-A["a3"] / A["a1"]) ** (1.0 / A["a2"]):.1f} °C'),
    ]


def contraction_findings() -> list[Row]:
    printed_gain = pi * D0**2 / H0
    strain = 1e-6 * coefficient(HOT + ZERO_CELSIUS) * (HOT - COLD)
    helix = ((L0 * (1.0 + strain)) ** 2 - WOUND) / L0**2
    mean = sqrt(WOUND) / (pi * TURNS)
    less_fibre = sqrt(L0**2 - (pi * TURNS * (D0 - FIBRE)) ** 2)
    in_kelvin = ' and '.join(f'{coefficient(t + ZERO_CELSIUS):.0f}' for t in (COLD, HOT))
    in_celsius = ' and '.join(f'{coefficient(t):+.0f}' for t in (COLD, HOT))
    ours, theirs = ((L0**2 - wound) / H0**2 for wound in (WOUND, pi * D0**2))
    return [
        ('15', 'H from π N² D²', f'{1e3 * sqrt(L0**2 - pi * (TURNS * D0) ** 2):.0f} mm; measured {1e3 * H0:.0f} mm'),
        ('15', 'π N D with D = 0.75 mm, against L', f'{1e3 * pi * TURNS * D0:.0f} mm against {1e3 * L0:.0f} mm'),
        ('16', 'gains on the two strains, corrected', f'{L0**2 / H0:.3f} m and {WOUND / H0:.3f} m'),
        ('16', 'gain on the second strain, as printed', f'{printed_gain:.1e} m'),
        ('16', 'dH/H over an isotropic strain; must be 1', f'corrected {ours:.1f}, as printed {theirs:.1f}'),
        ('16', 'contraction at 80 °C from 1e-4 /K across the fibre', f'{0.1 * (HOT - COLD) * WOUND / H0:.1f} mm'),
        ('17', 'contraction at 80 °C without load, sign as printed', f'{1e3 * A["B"] * strain:.1f} mm'),
        ('22', 'mean coil diameter', f'{1e3 * mean:.3f} mm'),
        ('22', 'H if the mean were 0.75 mm less the fibre', f'{1e3 * less_fibre:.0f} mm'),
        ('24', 'spurious factor N²', f'{TURNS**2}'),
        ('26', 'coefficient at 23 and 80 °C, T in K', f'{in_kelvin} × 1e-6 /K'),
        ('26', 'coefficient at 23 and 80 °C, T in °C', f'{in_celsius} × 1e-6 /K'),
        ('26', 'fibre strain at 80 °C, T in K', f'{100 * strain:.2f} %'),
        ('26', '(H/L)² of the exact helix at that strain', f'{helix:.4f}'),
    ]


def other_findings() -> list[Row]:
    inductance = MU0 * TURNS**2 * pi * (D0 / 2.0) ** 2 / H0
    weight = pi / 4.0 * FIBRE**2 * L0 * NYLON_DENSITY
    heavy = sqrt(A['m'] / L0 / NYLON_DENSITY * 4.0 / pi)
    runs = {name: cycles(p, 0.27) for name, p in (('set A', A), ('set B', B))}
    drift = ', '.join(f'{name} {run[2][0] - run[0][0]:.2f} K' for name, run in runs.items())
    left = ', '.join(f'{name} {run[0][1] - COLD:.2f} K' for name, run in runs.items())
    weak, full = (Muscle(A, load=LOADS[0]).step(ON, current).displacement for current in (0.18, 0.27))
    turn = float(length(A, HOT + ZERO_CELSIUS, LOADS[0])) / TURNS
    loaded = float(length(A, COLD + ZERO_CELSIUS, LOADS[0]))
    return [
        ('28', 'inductance with D the diameter', f'{1e6 * inductance:.2f} µH, {1e9 * inductance / A["R0"]:.0f} ns'),
        ('28', 'inductance with D taken for the radius', f'{4e6 * inductance:.2f} µH'),
        ('Table 1', 'mass of 0.5 m of one 0.2 mm fibre', f'{1e3 * weight:.3f} g'),
        ('Table 1', 'fibre diameter that weighs 0.1 g', f'{1e3 * heavy:.2f} mm'),
        ('text', 'load for 10 and 40 mm', f'{0.010 * A["k0"]:.2f} and {0.040 * A["k0"]:.2f} N'),
        ('text', 'third peak above the first at 0.27 A', drift),
        ('text', 'left after 45 s of cooling from 0.27 A', left),
        ('text', 'height of a turn at 80 °C, 30 g', f'{1e3 * turn:.3f} mm'),
        ('text', 'turns of 0.30 mm touch, 30 g, at', f'{contact(0.30e-3):.1f} °C'),
        ('text', 'contraction at 0.18 A over that at 0.27 A, 30 g', f'{100 * weak / full:.0f} %'),
        ('text', 'contraction at 0.27 A, 30 g, over the loaded length', f'{100 * full / loaded:.0f} %'),
    ]


def findings() -> str:
    """The arithmetic behind the errata."""
    rows = [*thermal_findings(), *stiffness_findings(), *contraction_findings(), *other_findings()]
    return table(('eq.', 'quantity', 'our code prints'), rows)


def conductances() -> str:
    """What "hA = 0.15" may have meant."""
    readings = [
        ('as printed, W/K', 0.15, A['C']),
        ('a decimal slip: 0.015 W/K', 0.015, A['C']),
        ('a decimal slip, and a mass of 0.16 g (set B)', B['hA'], B['C']),
        ('a rate, hA/(m cp) = 0.15 1/s', 0.15 * A['C'], A['C']),
        ('per metre of coil, 0.15 W/(m K)', 0.15 * A['H0'], A['C']),
        ('**identified from 80 °C after 25 s (set A)**', A['hA'], A['C']),
    ]
    rows = []
    for name, conductance, capacity in readings:
        p = A.replace(hA=conductance, C=capacity)
        peaks = ' / '.join(f'{peak(p, current):.1f}' for current in CURRENTS)
        rows.append((name, f'{conductance:.4f}', f'{capacity / conductance:.1f}', peaks))
    return table(('reading', 'hA, W/K', 'cooling time constant, s', 'peaks at 0.18 / 0.21 / 0.24 / 0.27 A, °C'), rows)


def identification() -> str:
    """How far the one temperature in the text fixes hA."""
    targets = ((80.0, 25.0), (80.0, 30.0), (75.0, 25.0), (78.0, 25.0), (82.0, 25.0), (85.0, 25.0))
    by_target = [
        (f'peak {target:.0f} °C after {on:.0f} s', f'{identified(target, on):.5f}', f'{A["C"]:.3f}')
        for target, on in targets
    ]
    along = []
    for conductance in (0.0125, 0.0150, 0.0175, 0.0205):
        capacity = brentq(lambda c, h=conductance: peak(A.replace(hA=h, C=c), 0.27) - 80.0, 0.02, 1.0)
        along.append(('peak 80 °C after 25 s, C free', f'{conductance:.5f}', f'{capacity:.3f}'))
    bound = 0.27**2 * A['R0'] * (1.0 / 57.0 + A['a_R'])
    last = ('80 °C is reached at all, any C: hA below', f'{bound:.5f}', '–')
    return table(('condition at 0.27 A', 'hA, W/K', 'C, J/K'), [*by_target, *along, last])


def peaks() -> str:
    """The four currents: first cycle, and the plateau of a longer one."""
    rows = []
    for current in CURRENTS:
        muscle = Muscle(A)
        cold, hot = muscle.reading(current), muscle.step(ON, current)
        constant = A['C'] / (A['hA'] - current**2 * A['R0'] * A['a_R'])
        rows.append((
            f'{current:.2f}',
            f'{cold.power:.3f}',
            f'{hot.temperature - ZERO_CELSIUS:.1f}',
            f'{steady_temperature(A, current) - ZERO_CELSIUS:.1f}',
            f'{constant:.2f}',
            f'{hot.resistance:.3f}',
            f'{hot.voltage:.2f}',
            f'{peak(B, current):.1f}',
            f'{peak(PRINTED, current):.1f}',
        ))  # fmt: skip
    return table(
        ('i, A', 'cold power, W', 'peak, °C', 'plateau, °C', 'time constant, s', 'R at the peak, Ω', 'V at the peak',
         'peak of set B, °C', 'peak with hA = 0.15, °C'),
        rows,
    )  # fmt: skip


def displacements() -> str:
    """Twelve contractions (mm) after 25 s, and what the printed constants and signs make of them."""
    rows = [
        (f'{current:.2f}', *(f'{1e3 * Muscle(p, load=load).step(ON, current).displacement:.1f}'
                             for p in (A, PRINTED) for load in LOADS))
        for current in CURRENTS
    ]  # fmt: skip
    head = ('i, A', *(f'{grams} g' for grams in GRAMS), *(f'as printed, {grams} g' for grams in GRAMS))
    return table(head, rows)


def readings() -> str:
    """Contraction by each reading of equation 26, at set A's four peaks."""
    c1, c2, t0 = A['c1'], A['c2'], 23.0
    k0 = t0 + ZERO_CELSIUS
    strains: list[tuple[str, Callable[[float], float]]] = [
        ('**K, secant from T0, sign corrected (ours)**', lambda t: -(c1 * (t + ZERO_CELSIUS) + c2) * (t - t0)),
        ('K, tangent integrated, sign corrected',
         lambda t: -(0.5 * c1 * ((t + ZERO_CELSIUS) ** 2 - k0**2) + c2 * (t - t0))),
        ('°C, secant, sign as printed', lambda t: (c1 * t + c2) * (t - t0)),
        ('°C, tangent integrated, sign as printed', lambda t: 0.5 * c1 * (t**2 - t0**2) + c2 * (t - t0)),
        ('T means T - T0, sign as printed', lambda t: (c1 * (t - t0) + c2) * (t - t0)),
        ('expression of the cited work, +1.35e-6 T + 4.2e-4, °C, sign as printed',
         lambda t: (1.35e-6 * t + 4.2e-4) * (t - t0)),
    ]  # fmt: skip
    hot = [peak(A, current) for current in CURRENTS]
    rows = []
    for name, strain in strains:
        cells = []
        for load in LOADS:
            net = [A['B'] * strain(t) - load / A['k0'] * (1.0 / softening(t) - 1.0) for t in hot]
            cells.append(' '.join(f'{1e3 * x:.1f}' for x in net))
        rows.append((name, f'{1e3 * A["B"] * strain(80.0):.1f}', *cells))
    return table(('reading', 'thermal part at 80 °C', *(f'{grams} g' for grams in GRAMS)), rows)


def quartic(load: float, bending: bool) -> float:
    """Elongation (m) by equation 24 corrected (torsion, and bending if asked), its stiffness set to k0 at rest."""
    fibre, height = A['L0'], A['H0']

    def compliance(h: float) -> float:
        wound = fibre**2 - h**2
        return wound**2 + bending * wound * h**2 / (1.0 + POISSON)

    return brentq(lambda x: load / A['k0'] * compliance(height + x) / compliance(height) - x, 0.0, fibre - height)


def elongations() -> str:
    """Cold elongation under load by four models."""
    rod = A.with_effects('geometric_stiffening')
    rows = []
    for load in (*LOADS, 1.0, 2.0, 5.0):
        linear = load / A['k0']
        others = (quartic(load, False), quartic(load, True), Muscle(rod, load=load).reading().length - A['H0'])
        cells = (f'{1e3 * x:.1f} ({100 * (x / linear - 1):+.1f} %)' for x in others)
        rows.append((f'{load:.3f}', f'{1e3 * linear:.1f}', *cells))
    return table(
        ('F, N', 'spring, mm', 'eq. 24 corrected, torsion, mm', 'eq. 24 corrected, torsion and bending, mm',
         'Love rod (`geometric_stiffening`), mm'),
        rows,
    )  # fmt: skip


def runaway() -> str:
    """The currents beyond which there is no steady state, and the practical ones."""
    rows = []
    for name in SETS:
        if not name.startswith('karami_tadesse'):
            continue
        p = Parameters.named(name)
        critical = critical_current(p)
        warmest = steady_current(p, 120.0 + ZERO_CELSIUS)
        rows.append((f'`{name}`', f'{critical:.3f}', f'{critical**2 * p["R0"] / p["C"]:.1f}', f'{warmest:.3f}'))
    return table(('set', 'critical current, A', 'heating there, K/s', 'settles at 120 °C, A'), rows)


TABLES: dict[str, Callable[[], str]] = {
    'findings': findings,
    'conductances': conductances,
    'identification': identification,
    'peaks': peaks,
    'displacements': displacements,
    'readings': readings,
    'elongations': elongations,
    'runaway': runaway,
}


def updated(text: str) -> str:
    """The document with each table between its markers computed anew."""
    for name, make in TABLES.items():
        block = re.compile(rf'(<!-- table: {name} -->\n).*?(<!-- end -->)', re.DOTALL)
        text, count = block.subn(lambda found, make=make: f'{found[1]}{make()}\n{found[2]}', text)
        if count != 1:
            raise SystemExit(f'{DOCUMENT.name}: expected one block "table: {name}", found {count}')
    return text


def draw() -> None:
    """The paper's protocol, three cycles of four currents under 60 g, resolved beside as printed."""
    import matplotlib

    matplotlib.use('Agg')
    from matplotlib import pyplot

    time = np.arange(0.0, 3 * (ON + OFF), 0.05)
    heating = np.mod(time, ON + OFF) < ON
    figure, axes = pyplot.subplots(3, 2, figsize=(10, 8), sharex=True, sharey='row', layout='constrained')
    titles = ('Resolved model, set A (hA = 0.0193 W/K)', 'As printed (hA = 0.15 W/K, signs of eq. 17)')
    names = ('temperature, °C', 'resistance, Ω', 'contraction under 60 g, mm')
    colours = pyplot.get_cmap('plasma')(np.linspace(0.78, 0.1, len(CURRENTS)))
    for column, p, title in zip(axes.T, (A, PRINTED), titles, strict=True):
        for current, colour in zip(CURRENTS, colours, strict=True):
            shown = simulate(p, time, np.where(heating, current, 0.0), load=LOADS[1])
            for axis, values in zip(
                column, (shown.temperature - ZERO_CELSIUS, shown.resistance, 1e3 * shown.displacement), strict=True
            ):
                axis.plot(time, values, color=colour, label=f'{current:.2f} A')
        column[0].set_title(title)
    for axis, name in zip(axes[:, 0], names, strict=True):
        axis.set_ylabel(name)
    for axis in axes.flat:
        for start in range(3):
            axis.axvspan(start * (ON + OFF), start * (ON + OFF) + ON, color='0.94', zorder=0)
        axis.spines[['top', 'right']].set_visible(False)
    axes[2, 1].axhline(0.0, color='0.6', linewidth=0.8, zorder=1)
    axes[0, 0].axhline(80.0, color='0.5', linewidth=0.8, linestyle=':')
    axes[0, 1].axhline(80.0, color='0.5', linewidth=0.8, linestyle=':')
    axes[0, 1].text(time[-1], 78.5, 'the paper: about 80 °C at 0.27 A', ha='right', va='top', color='0.3', fontsize=9)
    axes[2, 1].text(time[-1], 3.0, 'below zero: heating lengthens', ha='right', va='bottom', color='0.3', fontsize=9)
    axes[0, 0].legend(loc='upper right', frameon=False, ncols=4, fontsize=8, bbox_to_anchor=(1.0, 1.01))
    axes[0, 0].set_ylim(15.0, 95.0)
    for axis in axes[-1]:
        axis.set_xlabel('time, s (grey: current on)')
        axis.set_xlim(0.0, time[-1])
    FIGURE.parent.mkdir(exist_ok=True)
    figure.savefig(FIGURE, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--update', action='store_true', help='write the tables into docs/paper.md and draw its figure')
    if parser.parse_args().update:
        DOCUMENT.write_text(updated(DOCUMENT.read_text(encoding='utf-8')), encoding='utf-8')
        draw()
        return
    for name, make in TABLES.items():
        print(f'{name}\n\n{make()}\n')


if __name__ == '__main__':
    main()

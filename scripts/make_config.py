#!/usr/bin/env python3
"""Write the parameter files of config/ from the one table in tcp_muscle_ros/muscle/table.py."""

from functools import partial
from math import floor
from pathlib import Path

from tcp_muscle_ros.muscle import SETS, ZERO_CELSIUS, Parameters, steady_current
from tcp_muscle_ros.muscle.edges import EDGES
from tcp_muscle_ros.muscle.family import FAMILY, not_stated
from tcp_muscle_ros.muscle.table import DERIVED
from tcp_muscle_ros.settings.parameter_file import describe, number_text, render

CONFIG = Path(__file__).resolve().parent.parent / 'config'
HEADINGS = {
    'karami_tadesse_2017': (
        'The muscle of Karami & Tadesse 2017, Smart Mater. Struct. 26 125010: Table 1 row by row (L0 to a_R), then',
        'the rows identified from its text and equations 26 and 27. This is the default set (A); see docs/paper.md.',
    ),
    'karami_tadesse_2017_as_printed': (
        'The same muscle with the constants and signs as printed: hA = 0.15 W/K ends at 29.9 degC after 25 s at',
        '0.27 A, and equations 16 to 18 taken literally make it longer when heated. For comparison; see docs/paper.md.',
    ),
    'karami_tadesse_2017_set_b': (
        'Set B: hA read as 0.015 W/K (a slipped decimal) with the mass of 0.16 g that restores the peak of 80 degC.',
        'It cools twice as slowly as set A; see docs/paper.md.',
    ),
    'sun_zhao_2021': (
        'Silver-coated nylon thread with free stroke: 175 mm of fibre on 66.75 mm. Sun & Zhao 2021, Physics-based',
        'modeling of twisted-and-coiled actuators using Cosserat rod theory, IEEE Trans. Robotics: the code published',
        'with it (github.com/jiefengsun/TCA_TRO). Its resistance is not stated: drive it by power. See',
        'docs/parameter_sets.md.',
    ),
    'mcginty_iron_wire': (
        'Nylon monofilament of 0.8 mm wrapped with iron wire of 0.25 mm. I. McGinty, MSc thesis, TU Delft, Redundant',
        'actuation of twisted and coiled polymer muscles to improve tracking performance: its code',
        '(github.com/imcginty/TCPM-Optimal-Force-Tracking). Heat measured on one muscle, geometry of another; see',
        'docs/parameter_sets.md.',
    ),
}

LOADS = {  # N, to begin with, and why
    'sun_zhao_2021': (0.294, '30 g; above 0.3 N the strained fibre softens more than this set knows'),
    'mcginty_iron_wire': (0.064, 'stretches it by 15 mm, as the author does: its turns touch at rest'),
}
WARM = 80.0  # degC, at which the paper's muscle peaks at the 0.27 A that are its limit


def note(muscle: str, name: str) -> str:
    """The comment behind a value: for another muscle than the paper's, where it stands in its source."""
    if muscle not in FAMILY:
        return describe(name)
    if name in FAMILY[muscle]:
        return f'{EDGES[name].unit}; {FAMILY[muscle][name].source}'
    if name in DERIVED:
        return describe(name)
    return f"{EDGES[name].unit}; not stated: that of the paper's muscle"


def running(name: str) -> str:
    """How a muscle of another source is run: its own limit and load in place of those of the paper's muscle."""
    muscle, (load, why) = Parameters.named(name), LOADS[name]
    limit = floor(100 * steady_current(muscle, WARM + ZERO_CELSIUS)) / 100
    given = ", with the paper's resistance: measure yours first" if not_stated('R0', muscle) else ''
    rows = (('current_limit_a', limit, f'A; settles below {WARM:g} degC{given}'), ('load_n', load, f'N; {why}'))
    return ''.join(f'    {f"{row}: {number_text(value)}":<34} # {text}\n' for row, value, text in rows)


def files() -> dict[Path, str]:
    """Each file of config/ that is made here, and its text."""
    return {
        CONFIG / f'{name}.yaml': render(
            Parameters.named(name),
            heading=(*HEADINGS[name], '', 'Made by scripts/make_config.py: name: value  # unit; meaning; source'),
            note=partial(note, name),
        )
        + (running(name) if name in FAMILY else '')
        for name in SETS
    }


if __name__ == '__main__':
    for path, text in files().items():
        path.write_text(text)
        print(path.relative_to(CONFIG.parent))

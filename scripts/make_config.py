#!/usr/bin/env python3
"""Write the parameter files of config/ from the one table in tcp_muscle_ros/muscle/table.py."""

from pathlib import Path

from tcp_muscle_ros.muscle import SETS, Parameters
from tcp_muscle_ros.settings.parameter_file import render

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
}


def files() -> dict[Path, str]:
    """Each file of config/ that is made here, and its text."""
    return {
        CONFIG / f'{name}.yaml': render(
            Parameters.named(name),
            heading=(*HEADINGS[name], '', 'Made by scripts/make_config.py: name: value  # unit; meaning; source'),
        )
        for name in SETS
    }


if __name__ == '__main__':
    for path, text in files().items():
        path.write_text(text)
        print(path.relative_to(CONFIG.parent))

"""``tcp_muscle new-muscle --output MUSCLE.yaml``: a parameter file from fibre, coil and resistance."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import add_force_argument

if TYPE_CHECKING:
    from tcp_muscle_ros.muscle.geometry import Coil, Estimate

# Option, unit, SI per unit, what is asked.
_QUESTIONS = (
    ('fibre-diameter', 'mm', 1e-3, 'diameter of the fibre'),
    ('fibre-length', 'mm', 1e-3, 'length of the fibre before it was coiled, twisted'),
    ('coil-length', 'mm', 1e-3, 'length of the coiled muscle at rest, without load'),
    ('turns', '', 1.0, 'number of turns of the coil'),
    ('resistance', 'ohm', 1.0, 'resistance at room temperature'),
)
_MASS = ('mass', 'g', 1e-3, 'mass, where it was weighed; else that of a round nylon fibre')
# Least and most in the units asked for: wider than any coil of a thread, and narrower than a slip of the unit.
_RANGE = {
    'fibre-diameter': (0.01, 10.0),
    'fibre-length': (5.0, 5e4),
    'coil-length': (2.0, 2e4),
    'turns': (1.0, 1e5),
    'resistance': (0.01, 5e3),
    'mass': (1e-3, 1e3),
}
_HEADING = (
    'A muscle from its geometry (tcp_muscle new-muscle): a place to start from, before `tcp_muscle calibrate`.',
    'Behind each value: unit; between what bounds it is likely to lie; where it comes from.',
    "The stiffness is the least certain: for Karami & Tadesse's own muscle the formula is 29 times too small.",
    'Stroke (c1, c2), softening (a1 to a3), a_R, cp and T0 are theirs: geometry says nothing of them.',
)


def _option(name: str, unit: str) -> str:
    return f'{name}-{unit}' if unit else name


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``new-muscle``."""
    for name, unit, _, meaning in (*_QUESTIONS, _MASS):
        parser.add_argument(f'--{_option(name, unit)}', metavar=(unit or 'N').upper(), help=meaning)
    parser.add_argument('--output', required=True, metavar='MUSCLE.yaml', help='the parameter file to write')
    add_force_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Ask for what no option says, and write the file."""
    from tcp_muscle_ros.files.outputs import in_place_of, writable_file
    from tcp_muscle_ros.muscle.geometry import estimates
    from tcp_muscle_ros.muscle.parameters import Parameters
    from tcp_muscle_ros.muscle.table import DERIVED
    from tcp_muscle_ros.settings.parameter_file import describe, write

    output = writable_file(args.output, force=args.force)
    found = estimates(_coil(args))
    muscle = Parameters({name: estimate.value for name, estimate in found.items() if name not in DERIVED})

    def note(name: str) -> str:
        return _note(name, found[name]) if name in found else describe(name)

    with in_place_of(output) as draft:
        write(draft, muscle, heading=_HEADING, note=note)
    stiffness = found['k0']
    print(
        f'wrote {output}; stiffness by geometry {stiffness.value:.3g} N/m, likely up to {stiffness.high:.3g} N/m: '
        'measure it, then tcp_muscle calibrate'
    )
    return 0


def _note(name: str, estimate: Estimate) -> str:
    from tcp_muscle_ros.muscle.edges import EDGES
    from tcp_muscle_ros.muscle.table import DERIVED

    bounds = '' if estimate.low == estimate.high else f'{estimate.low:.3g} to {estimate.high:.3g}; '
    if name in DERIVED:
        bounds = f'0 = {estimate.value:.3g}; {bounds}'
    return f'{EDGES[name].unit}; {bounds}{estimate.why}'


def _coil(args: argparse.Namespace) -> Coil:
    from tcp_muscle_ros.muscle.geometry import Coil

    diameter, fibre, length, turns, resistance = (_answer(args, *question) for question in _QUESTIONS)
    mass = None if args.mass_g is None else _number(args.mass_g, *_MASS)
    return Coil(diameter, fibre, length, turns, resistance, mass)


def _answer(args: argparse.Namespace, name: str, unit: str, factor: float, meaning: str) -> float:
    """What an option says, or else the user."""
    option = _option(name, unit)
    given = getattr(args, option.replace('-', '_'))
    if given is None:
        try:
            given = input(f'{meaning[0].upper()}{meaning[1:]}{f", {unit}" if unit else ""}: ')
        except EOFError:
            raise BadInput(f'--{option} is missing ({meaning}), and nobody answers') from None
        except UnicodeDecodeError:
            raise BadInput(f'--{option}: the answer ({meaning}) is not text') from None
    return _number(given, name, unit, factor, meaning)


def _number(text: str, name: str, unit: str, factor: float, meaning: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float('nan')
    least, most = _RANGE[name]
    if not least <= value <= most:  # nor nan
        raise BadInput(
            f"--{_option(name, unit)} '{text.strip()}': expected a number{f' in {unit}' if unit else ''}, "
            f'from {least:g} to {most:g}'
        )
    return factor * value

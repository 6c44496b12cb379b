#!/usr/bin/env python3
"""docs/effects.md, written from the registry of effects. Prints it; with --update writes it."""

import argparse
from importlib import import_module
from pathlib import Path

from tcp_muscle_ros.muscle import EFFECTS
from tcp_muscle_ros.muscle.edges import EDGES, Edge
from tcp_muscle_ros.muscle.effects.effect import STAGES, Effect
from tcp_muscle_ros.muscle.parameter import Parameter

DOCUMENT = Path(__file__).parents[1] / 'docs' / 'effects.md'

HEAD = """# Physics that the paper leaves out

The resolved model ([paper.md](paper.md)) has one temperature, one stiffness and ideal sensors. Each effect below adds
one piece of physics to it. All are off by default, and off means the resolved model, bit for bit. Any subset may be on:

```yaml
/**:
  ros__parameters:
    effects: [natural_convection, creep]
    creep.J: 0.15
```

The same names and parameters hold in `sim_node`, `tcp_muscle simulate`, `replay` and `diagnose`. Each effect has an
amplitude (**bold**) that fades it out without a jump; at the value given there it is the resolved model (of clock_skew
with r = 0, of current_gain with z = 0). Values marked *estimated* come from the geometry and material of this muscle,
not from a measurement of it.

*Contraction* is how much shorter the muscle is than at the start (topic `displacement`), *stroke* how far it contracts
in a heating, *elongation* how much longer it is.

The figures show what an effect, at its default values, adds to the resolved model under the paper's protocol (25 s
on, 45 s off at 0.27 A, three cycles, set A): the channels as the sensors show them, resistance while current flows.
Axes reach at least the noise of a good rig (0.2 K, 0.02 ohm, 0.05 mm). Nothing is fitted in them: a change of hA, k0
or a_R would absorb part of most effects. The last panel is the loop: by how much the contraction lies above the
resolved model's at the temperature shown, orange while it rises and blue while it falls. elastocaloric and inertia show
load steps from 30 g.

**What looks alike.** Recordings of the paper's protocol hardly separate these groups: heat_capacity, latent_heat (and
the first cycle of moisture); natural_convection, radiation, exposed_area; load_stroke and thermocouple_gain;
displacement_drift, viscous_flow, fatigue; a constant contact_resistance is nearly an exact change of R0, a_R, hA and C.
The direction of the loop of contraction over temperature helps: heating lies on top for thermocouple_lag,
clock_skew, creep, branch_cte and end_conduction, cooling for two_node, hysteresis and friction. A slower cycle makes
the loop smaller for all of these but branch_cte, hysteresis and friction.

**Unlisted laws.** `free_conductance`, `free_capacity`, `free_surroundings`, `free_resistance`, `free_stroke`,
`free_stiffness`, `free_slow_state` and `free_delay` stand for physics that is not in this list. Each is a table (`at`,
`value`, in SI, so temperatures in K) over a quantity (`driver`), interpolated by a natural cubic spline. Beyond its
table a law is extended in a straight line, and the muscle is reported to be outside the model's domain. The default
tables are examples. In a ROS parameter file write the numbers of an array all with a decimal point, or all without. The
controller inverts the tables of stroke and stiffness. If a table makes the stroke turn back, it uses the branch up to
the turn, and setpoints beyond it are refused. `stick_slip` moves at random instants, the same for the same seed.
Where the listed effects leave an error,
`diagnose` tries the free laws, and reports one that unseen data confirm as `unlisted`, with its curve. It does not fit
`stick_slip`, whose random instants have no derivative: where a stroke sticks and slips, a note says with which values a
simulation has such jumps and rests, and a figure shows one beside the recording.

```yaml
/**:
  ros__parameters:
    effects: [free_stroke]
    free_stroke.driver: temperature
    free_stroke.at: [296.0, 320.0, 350.0]     # K
    free_stroke.value: [0.0, -0.002, -0.003]  # m
```

**Out of scope.** Rows of the catalogue without a name: E-07 inductance (0.3 to 1.2 uH, 20 to 80 ns: invisible below
100 kHz), E-08 uneven current along the muscle (seen as thermocouple_gain), M-15 acceleration of the load as a force
(below 0.01 N; the swing itself is inertia), X-01 humidity, pressure and orientation of the air from day to day (seen
as a change of hA and k0).

Written by `scripts/effect_document.py`, figures by `scripts/effect_figures.py`.
"""


def number(value: float) -> str:
    """Short, and without the dust of binary fractions."""
    return f'{value:.6g}'


def row(effect: Effect, parameter: Parameter) -> str:
    """One parameter as a table row, as people see it: absolute temperatures in degC."""
    name = f'{effect.name}.{parameter.name}'
    if parameter.name == effect.strength:
        name = f'**{name}** (none: {number(effect.none)})'
    bounds = f'{number(parameter.edge_low)} to {number(parameter.edge_high)}'
    if parameter.spelled:
        default, bounds = parameter.choices[round(parameter.value)], ', '.join(parameter.choices)
        return f'| {name} | {default} | | {bounds} | {parameter.meaning} | {parameter.source} |'
    return (
        f'| {name} | {number(parameter.edge_value)} | {parameter.edge_unit} | {bounds} | {parameter.meaning} '
        f'| {parameter.source} |'
    )


def array(edge: Edge) -> str:
    """One array as a table row: its default, the bounds of each number."""
    default = ', '.join(number(value) for value in edge.default)
    bounds = f'{edge.fewest} to {len(edge.members)} numbers, each {number(edge.row.low)} to {number(edge.row.high)}'
    unit = edge.unit or '1'
    return f'| {edge.name} | [{default}] | {unit} | {bounds} | {edge.meaning} | {edge.source} |'


def section(effect: Effect) -> str:
    """One effect: what its module says of it, its parameters, its figure."""
    text = import_module(f'tcp_muscle_ros.muscle.effects.{effect.name}').__doc__ or ''
    first, _, rest = text.strip().partition('\n')
    _, _, sentence = first.partition(': ')
    mark = f' ({effect.row})' if effect.row else ''
    arrays = {m for column in effect.columns for m in (*column.members, column.count)}
    rows = '\n'.join(row(effect, parameter) for parameter in effect.parameters if parameter.name not in arrays)
    rows += ''.join('\n' + array(EDGES[f'{effect.name}.{column.name}']) for column in effect.columns)
    if effect.free is not None:
        of = ', '.join(f'{name} ({unit})' for name, unit in effect.free.drivers.items())
        rows += f'\n\nDrivers: {of}.'
    return (
        f'### {effect.name}{mark}\n\n{sentence[0].upper()}{sentence[1:]}\n{rest}\n\nSource: {effect.source}.\n\n'
        '| parameter | default | unit | bounds | meaning | source |\n|---|---|---|---|---|---|\n'
        f'{rows}\n\n![{effect.name}](images/effects/{effect.name}.png)\n'
    )


def document() -> str:
    """The whole document."""
    parts = [HEAD]
    for stage in STAGES:
        members = [effect for effect in EFFECTS.values() if effect.stage == stage]
        parts.append(f'## {stage.capitalize()}\n')
        parts += [section(effect) for effect in members]
    return '\n'.join(parts)


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--update', action='store_true', help='write docs/effects.md')
    if parser.parse_args().update:
        DOCUMENT.write_text(document(), encoding='utf-8')
    else:
        print(document(), end='')

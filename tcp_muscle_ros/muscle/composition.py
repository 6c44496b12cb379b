"""Compose the hooks of all effects into one compiled function a point."""

from collections.abc import Callable
from typing import Any

from tcp_muscle_ros.muscle.arrays import Array, Mask
from tcp_muscle_ros.muscle.compiled import inlined, inner
from tcp_muscle_ros.muscle.effects import EFFECTS
from tcp_muscle_ros.muscle.layout import COEFFICIENTS, STATES
from tcp_muscle_ros.muscle.table import INDEX

Hooks = Callable[..., None]


def hooks_at(point: str) -> Hooks:
    """A compiled ``f(q, p, on, x, dx)`` that calls, in the registry's order, this hook of every effect that is on.

    The calls are written out one after the other, because numba compiles a flat function far more quickly than a chain
    of closures. Where no effect is asked it is one comparison.
    """
    names: dict[str, Any] = {}
    lines = ['def every(q, p, on, x, dx):', '    pass']
    for number, effect in enumerate(EFFECTS.values()):
        if point in effect.hooks:
            names[effect.name] = inner(effect.hooks[point])
            c, s = COEFFICIENTS[effect.name], STATES[effect.name]
            # A slice takes long to compile: an effect without states is given all of them, and reads none.
            state = f'x[{s.start}:{s.stop}], dx[{s.start}:{s.stop}]' if effect.states else 'x, dx'
            lines += [f'    if on[{number}]:', f'        {effect.name}(q, p[{c.start}:{c.stop}], p, {state})']
    exec('\n'.join(lines), names)
    every = inner(names['every'])
    asked = INDEX[f'at_{point}']

    @inlined
    def run(q: Array, p: Array, on: Mask, x: Array, dx: Array) -> None:
        if p[asked] > 0.0:
            every(q, p, on, x, dx)

    return run

"""Compose the hooks of all effects into one compiled function a point."""

from collections.abc import Callable
from typing import Any

from tcp_muscle_ros.muscle.arrays import Array, Mask
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects import EFFECTS
from tcp_muscle_ros.muscle.quantities import N_STATES
from tcp_muscle_ros.muscle.table import SIZE

Hooks = Callable[..., None]


@inner
def _nothing(q: Array, p: Array, on: Mask, x: Array, dx: Array) -> None:
    """The end of every chain."""


def _link(hook: Any, number: int, c: slice, s: slice, rest: Hooks) -> Hooks:
    c0, c1, s0, s1 = c.start, c.stop, s.start, s.stop

    @inner
    def run(q: Array, p: Array, on: Mask, x: Array, dx: Array) -> None:
        if on[number]:
            hook(q, p[c0:c1], p, x[s0:s1], dx[s0:s1])
        rest(q, p, on, x, dx)

    return run


def hooks_at(point: str) -> Hooks:
    """A compiled ``f(q, p, on, x, dx)`` that calls, in the registry's order, this hook of every effect that is on."""
    links = []
    coefficient, state = SIZE, N_STATES
    for number, effect in enumerate(EFFECTS.values()):
        c = slice(coefficient, coefficient + len(effect.parameters))
        s = slice(state, state + len(effect.states))
        coefficient, state = c.stop, s.stop
        if point in effect.hooks:
            links.append((inner(effect.hooks[point]), number, c, s))
    chain: Hooks = _nothing
    for hook, number, c, s in reversed(links):
        chain = _link(hook, number, c, s, chain)
    return chain

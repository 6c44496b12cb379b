"""Compile the model ahead of its first use, and know whether that was done."""

import hashlib
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numba.core.registry import cpu_target

from tcp_muscle_ros.muscle import (
    Joint,
    Link,
    Muscle,
    Muscles,
    Parameters,
    length,
    length_at,
    shortening,
    simulate,
    temperature_for_length,
    tension,
)
from tcp_muscle_ros.muscle.compiled import CACHE, SHIPPED


def _mark() -> Path | None:
    """The file that says that all is compiled: for this place of the package and this kind of processor."""
    if CACHE is None:
        return None
    processor = cpu_target.target_context.codegen().magic_tuple()  # as numba tells machine code of one from another's
    here = f'{Path(__file__).parent} {processor}'
    return CACHE / f'complete_{hashlib.sha256(here.encode()).hexdigest()[:16]}'


def is_compiled() -> bool:
    """Whether a start finds its machine code, as far as was noted."""
    mark = _mark()
    return mark is not None and mark.exists()


def compile_ahead(say: Callable[[str], None] = lambda _: None) -> None:
    """Call every entry into the compiled model once, with the types of arguments that the package calls it with.

    Args:
        say: told what is compiled next, such as ``2 of 5: one muscle``.
    """
    model = Parameters.named('karami_tadesse_2017')
    steps = {'several muscles and a joint': _together, 'one muscle': _one, 'a simulation': _simulation}
    steps |= {'lengths': _lengths, 'tensions': _tensions}
    for place, (name, compile_) in enumerate(steps.items(), 1):
        say(f'{place} of {len(steps)}: {name}')
        compile_(model)
    mark = _mark()
    if mark is not None:
        mark.touch()


def ship() -> Path:
    """Put what is compiled into the package's own folder, where every user's first start finds it; returns where.

    Raises:
        OSError: the folder cannot be written, or there is no cache to take it from.
    """
    if CACHE is None:
        raise OSError('nowhere to compile to: neither the cache folder nor the temporary one can be written')
    target = SHIPPED / CACHE.name
    shutil.rmtree(SHIPPED, ignore_errors=True)  # that of an older version
    shutil.copytree(CACHE, target)
    return target


def _together(model: Parameters) -> None:
    one, two = (Muscle(model, load=0.5, end='blocked') for _ in range(2))
    joint = Joint(Link(radius=0.01, inertia=1e-5, damping=1e-4, low=-0.5, high=0.5), one, two)
    Muscles([one, two], [joint]).step(0.01, [0.1, 0.1])


def _one(model: Parameters) -> None:
    Muscle(model).step(0.01, 0.1)


def _simulation(model: Parameters) -> None:
    simulate(model, np.arange(3.0), 0.1)


def _lengths(model: Parameters) -> None:
    length(model, [model['T0']], 0.5)
    length_at(model, model['T0'], 0.5)
    shortening(model, 0.5)


def _tensions(model: Parameters) -> None:
    height = length_at(model, model['T0'], 0.5)
    temperature_for_length(model, height, tension(model, height, model['T0']))

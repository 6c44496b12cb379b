"""Compile the model ahead of its first use: ``python -m tcp_muscle_ros.muscle``, once after an installation.

Otherwise the first start of a node or of the tool does it, and takes as long. The machine code is kept in the user's
cache (see ``compiled.py``), for this version of the package on this machine.
"""

import sys
import time

import numpy as np

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
from tcp_muscle_ros.muscle.compiled import CACHE


def compile_ahead() -> None:
    """Call every entry into the compiled model once, with the types of arguments that the package calls it with."""
    model = Parameters.named('karami_tadesse_2017')
    one, two = (Muscle(model, load=0.5, end='blocked') for _ in range(2))
    joint = Joint(Link(radius=0.01, inertia=1e-5, damping=1e-4, low=-0.5, high=0.5), one, two)
    Muscles([one, two], [joint]).step(0.01, [0.1, 0.1])
    Muscle(model).step(0.01, 0.1)
    simulate(model, np.arange(3.0), 0.1)
    length(model, [model['T0']], 0.5)
    height = length_at(model, model['T0'], 0.5)
    shortening(model, 0.5)
    temperature_for_length(model, height, tension(model, height, model['T0']))


if __name__ == '__main__':
    if CACHE is None:
        sys.exit('nowhere to keep compiled code: neither ~/.cache nor the temporary folder can be written')
    begin = time.monotonic()
    compile_ahead()
    print(f'compiled the model in {time.monotonic() - begin:.0f} s')

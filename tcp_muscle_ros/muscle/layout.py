"""Where each effect's coefficients and states lie in the flat vectors of the compiled model.

States that the stepper integrates come first, memories that move only at the end of a substep after them.
"""

from tcp_muscle_ros.muscle.effects import EFFECTS
from tcp_muscle_ros.muscle.quantities import N_STATES
from tcp_muscle_ros.muscle.table import SIZE


def _places() -> tuple[dict[str, slice], dict[str, slice], int, int, int]:
    coefficients, states = {}, {}
    begin = SIZE
    for effect in EFFECTS.values():
        coefficients[effect.name] = slice(begin, begin + len(effect.parameters) + effect.prepared)
        begin = coefficients[effect.name].stop
    vector_size = begin
    begin = N_STATES
    integrated = begin
    for remembers in (False, True):
        for effect in EFFECTS.values():
            if ('rates' not in effect.hooks) is remembers:
                states[effect.name] = slice(begin, begin + len(effect.states))
                begin += len(effect.states)
        if not remembers:
            integrated = begin
    return coefficients, states, vector_size, integrated, begin


COEFFICIENTS, STATES, VECTOR_SIZE, N_INTEGRATED, STATE_SIZE = _places()

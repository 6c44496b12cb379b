"""Recordings that begin before the muscle has rested: creep still on its way, a fibre not yet moist again.

Effects compete as they are after a long rest. Of one that is named, what the recordings show of its states where they
begin is fitted then: each has its own, which bends to much, and would let a slow effect pass for another.
"""

from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit, slopes_with_more
from tcp_muscle_ros.diagnosis.hypothesis.unknowns import states_at_start
from tcp_muscle_ros.diagnosis.search.rivals import penalised


def unrested(fitted: Fit) -> Fit:
    """The fit with the states of its effects where each recording begins, where they explain more than chance gives."""
    for effect in fitted.problem.parameters.effects:
        if not any(u.state and u.name.startswith(f'{effect}.') for u in fitted.problem.unknowns):
            better = _with_states(fitted, effect)
            if better and penalised(fitted) - penalised(better) >= fitted.problem.policy.least_drop:
                fitted = better
    return fitted


def _with_states(fitted: Fit, effect: str) -> Fit | None:
    """The fit with those of one effect; None where it has none."""
    problem = fitted.problem
    recordings = range(len(problem.experiments))
    states = [u for k in recordings for u in states_at_start(problem.model, effect, problem.parameters, k)]
    if not states:
        return None
    problem = replace(problem, unknowns=(*problem.unknowns, *states))
    z = np.concatenate([fitted.z, problem.start()[fitted.z.size :]])
    known = slopes_with_more(fitted, problem, z, fitted.predictions)
    return fit(problem, z, rounds=40, tolerance=1e-5, known=known)

"""What a selection hands on for use: the muscle as it is now, how old it was before, and what its instruments do."""

import numpy as np

from tcp_muscle_ros.diagnosis.fitting import slips
from tcp_muscle_ros.diagnosis.fitting.calibration import ages
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.hypothesis.latents import Latent
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.hypothesis.roles import SLIPS
from tcp_muscle_ros.diagnosis.observation.late import taken_out
from tcp_muscle_ros.diagnosis.search.selection import Selection
from tcp_muscle_ros.muscle import EFFECTS, SPECIFICATIONS, Parameters
from tcp_muscle_ros.settings.ages import Age
from tcp_muscle_ros.settings.rig import BY_EFFECT, Quantity, Rig, RigLimits, from_effects

_HUNG = 12  # different loads, at most


def improved_muscle(selection: Selection) -> Parameters:
    """The muscle with its calibrated parameters and physics, as old as it is after the last recording.

    What belongs to the sensors goes to the rig, and circumstances that differed from recording to recording stay in the
    report; of slips at their own instants it keeps the mean.
    """
    final = selection.final
    muscle = now(final)
    own = {u.name.split('.')[0] for u in final.problem.unknowns if '.' in u.name and u.recording is not None}
    physics = [e for e in muscle.effects if EFFECTS[e].stage != 'sensor' and e not in own]
    leakage = slips.mean_leakage(final) if selection.leapt is None else None
    if leakage is None:
        return muscle.only_effects(physics)
    return muscle.only_effects([*physics, SLIPS]).replace({slips.RATE: leakage[0], slips.FROM: 0.0})


def now(fitted: Fit) -> Parameters:
    """The fitted muscle as old as it is after the last recording."""
    problem = fitted.problem
    if not problem.ages:
        return fitted.muscle
    cycles, used = ages((*problem.experiments, problem.experiments[0]), fitted.outputs)[-1]
    return fitted.muscle.replace(_age(problem.with_latent(Latent(cycles, used), 0), 0))


def ages_of(problem: Problem) -> tuple[Age, ...]:
    """How old the muscle was at the beginning of each recording; empty for one that does not age."""
    if not problem.ages:
        return ()
    return tuple(Age(e.start_ns, _age(problem, k)) for k, e in enumerate(problem.experiments))


def _age(problem: Problem, recording: int) -> dict[str, float]:
    muscle = problem.muscle({}, recording)
    return {name: muscle[name] for name in problem.ages}


def rig_of(fitted: Fit) -> Rig:
    """What the instruments do, as far as it is the same in all recordings, and what the rig was seen to do."""
    found: dict[str, Quantity] = {}
    for k, u in enumerate(fitted.problem.unknowns):
        if u.recording is None and '.' in u.name and (u.name in BY_EFFECT or _makes_late(u.name)):
            value = u.from_fit(float(fitted.z[k]))
            low, high = fitted.interval(k)
            found[u.name] = Quantity(value, min(low, value), max(high, value))
    shared = {name.partition('.')[0] for name in found}
    for name in BY_EFFECT:  # what is chosen and not fitted has no interval
        if SPECIFICATIONS[name].choices and name.partition('.')[0] in shared:
            value = fitted.problem.parameters[name]
            found[name] = Quantity(value, value, value)
    late = taken_out(fitted.muscle)[1] if any(_makes_late(name) for name in found) else None
    return from_effects(found, late.channel if late else '', _limits(fitted.problem))


def _makes_late(parameter: str) -> bool:
    """Whether a parameter is of the effect that makes one channel late."""
    return EFFECTS[parameter.partition('.')[0]].late is not None


def _limits(problem: Problem) -> RigLimits:
    """The largest current, the loads and the longest run that were seen."""
    usual, experiments = RigLimits(), problem.experiments
    currents = [float(np.max(e.imposed.drive)) for e in experiments if e.imposed.kind == 'current']
    hanging = [e.imposed.load for e in experiments if e.holding.end == 'load']
    loads = {round(float(load), 4) for hung in hanging for load in np.unique(hung)}
    if len(loads) > _HUNG:  # a load cell's readings, and no weights that were hung
        loads = {round(float(np.median(hung)), 4) for hung in hanging}
    return RigLimits(
        largest_current=max(currents) if currents else usual.largest_current,
        loads=tuple(sorted(loads)),
        held_end=any(e.holding.end == 'blocked' for e in experiments),
        longest_run=max(usual.longest_run, *(e.duration for e in experiments)),
    )

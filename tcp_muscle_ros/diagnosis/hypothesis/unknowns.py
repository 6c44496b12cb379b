"""What a fit may change beside what a calibration does: the parameters of effects."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

from tcp_muscle_ros.diagnosis.model.model import Model
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT, START, Unknown
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.resting import room_read
from tcp_muscle_ros.muscle import Parameters

_STATE = 0.4  # spread of a state at the start, of what it can be


def effect_unknowns(model: Model, name: str, parameters: Parameters, owner: int | None = None) -> list[Unknown]:
    """The unknowns of an effect: its parameters, each free over its bounds; of one recording (``owner``) or of all.

    A positive parameter whose bounds span more than a decade moves by its logarithm (time constants); amplitudes, which
    may vanish, move linearly.
    """
    unknowns = []
    effect = model.effects[name]
    for row in effect.moved(parameters):
        key = f'{name}.{row.name}'
        wide = row.low > 0.0 and row.high / row.low > 10.0
        value = parameters[key]
        spread = 1.5 if wide else max(abs(row.value), 0.25 * (row.high - row.low) if row.value == 0.0 else 0.0) * 2.0
        unknowns.append(Unknown(key, value, row.low, row.high, spread, log=wide, recording=owner))
    return unknowns


def states_at_start(model: Model, name: str, parameters: Parameters, recording: int) -> list[Unknown]:
    """What an effect's states were where a recording began: what was in use shortly before has not rested."""
    return [
        Unknown(
            f'{name}.{row.name}',
            parameters[f'{name}.{row.name}'],
            row.low,
            row.high,
            _STATE * max(abs(row.low), abs(row.high)),
            recording=recording,
            state=True,
        )
        for row in model.effects[name].parameters
        if row.state
    ]


def own_unknowns(experiment: Experiment, muscle: Parameters) -> tuple[Unknown, ...]:
    """What a recording of a known muscle brings of its own: the room, and the states at the start.

    Where a thermometer read the room while the muscle rested, the room and the start stay as near to that as a room is
    known beforehand: another muscle's resistance would draw them anywhere.
    """
    base = [u for u in base_unknowns([experiment], muscle) if u.recording is not None]
    within = next((u.spread for u in base if u.name == AMBIENT), None)
    read = None if within is None else room_read(experiment, muscle, within)
    if within is not None and read is not None:
        base = [_near(u, read, within) if u.name in (AMBIENT, START) else u for u in base]
    states = (u for name in muscle.effects for u in states_at_start(experiment.model, name, muscle, 0))
    return (*base, *states)


def _near(unknown: Unknown, value: float, within: float) -> Unknown:
    """The same, bound to a value."""
    low, high = value - within, value + within
    return replace(unknown, start=min(max(unknown.start, low), high), low=low, high=high)


def base_unknowns(
    experiments: Iterable[Experiment], nominal: Parameters, separate: Mapping[str, bool] | None = None
) -> list[Unknown]:
    """The unknowns of a calibration, by the machine whose recordings these are; ``separate`` names parameters that are
    fitted per recording."""
    experiments = list(experiments)
    return experiments[0].model.unknowns(experiments, nominal, separate or {})

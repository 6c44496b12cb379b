"""What a fit may change beside what a calibration does: the parameters of effects."""

from collections.abc import Iterable, Mapping

from tcp_muscle_ros.diagnosis.model.model import Model
from tcp_muscle_ros.diagnosis.model.unknown import Unknown
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle import Parameters


def effect_unknowns(model: Model, name: str, parameters: Parameters, owner: int | None = None) -> list[Unknown]:
    """The unknowns of an effect: its parameters, each free over its bounds; of one recording (``owner``) or of all.

    A positive parameter whose bounds span more than a decade moves by its logarithm (time constants); amplitudes, which
    may vanish, move linearly.
    """
    unknowns = []
    effect = model.effects[name]
    for row in effect.fitted:
        key = f'{name}.{row.name}'
        wide = row.low > 0.0 and row.high / row.low > 10.0
        value = parameters[key]
        spread = 1.5 if wide else max(abs(row.value), 0.25 * (row.high - row.low) if row.value == 0.0 else 0.0) * 2.0
        unknowns.append(Unknown(key, value, row.low, row.high, spread, log=wide, recording=owner))
    return unknowns


def base_unknowns(
    experiments: Iterable[Experiment], nominal: Parameters, separate: Mapping[str, bool] | None = None
) -> list[Unknown]:
    """The unknowns of a calibration, by the machine whose recordings these are; ``separate`` names parameters that are
    fitted per recording."""
    experiments = list(experiments)
    return experiments[0].model.unknowns(experiments, nominal, separate or {})

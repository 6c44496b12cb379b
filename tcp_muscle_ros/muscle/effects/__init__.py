"""The physics that the paper leaves out, one file an effect. Adding one: its file, and its line here."""

from collections.abc import Mapping

from tcp_muscle_ros.muscle.effects import (
    creep,
    geometric_stiffening,
    natural_convection,
    resistance_strain,
    thermocouple_lag,
)
from tcp_muscle_ros.muscle.effects.effect import Effect

_MODULES = (
    resistance_strain,
    natural_convection,
    creep,
    geometric_stiffening,
    thermocouple_lag,
)

EFFECTS: Mapping[str, Effect] = {module.EFFECT.name: module.EFFECT for module in _MODULES}

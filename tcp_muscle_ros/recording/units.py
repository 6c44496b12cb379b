"""Named units to SI and back: one table."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.errors import BadInput, Option, nearest

Value = TypeVar('Value', float, NDArray[np.float64])


@dataclass(frozen=True)
class Unit:
    """SI value = scale * x + offset."""

    name: str
    quantity: str
    scale: float
    offset: float = 0.0

    def to_si(self, x: Value) -> Value:
        """From this unit to SI."""
        return self.scale * x + self.offset

    def from_si(self, value: Value) -> Value:
        """From SI to this unit."""
        return (value - self.offset) / self.scale


GRAVITY = 9.80665  # m/s^2, the standard one: a mass that names a force is that mass hanging still
_FAHRENHEIT = 5.0 / 9.0

UNITS: Mapping[str, Unit] = MappingProxyType(
    {
        unit.name: unit
        for unit in (
            Unit('A', 'current', 1.0),
            Unit('mA', 'current', 1e-3),
            Unit('uA', 'current', 1e-6),
            Unit('V', 'voltage', 1.0),
            Unit('mV', 'voltage', 1e-3),
            Unit('W', 'power', 1.0),
            Unit('mW', 'power', 1e-3),
            Unit('ohm', 'resistance', 1.0),
            Unit('mohm', 'resistance', 1e-3),
            Unit('kohm', 'resistance', 1e3),
            Unit('m', 'length', 1.0),
            Unit('cm', 'length', 1e-2),
            Unit('mm', 'length', 1e-3),
            Unit('um', 'length', 1e-6),
            Unit('in', 'length', 0.0254),
            Unit('N', 'force', 1.0),
            Unit('mN', 'force', 1e-3),
            Unit('kN', 'force', 1e3),
            Unit('g', 'force', GRAVITY * 1e-3),
            Unit('kg', 'force', GRAVITY),
            Unit('lbf', 'force', 0.45359237 * GRAVITY),
            Unit('K', 'temperature', 1.0),
            Unit('degC', 'temperature', 1.0, 273.15),
            Unit('degF', 'temperature', _FAHRENHEIT, 273.15 - 32.0 * _FAHRENHEIT),
            Unit('s', 'time', 1.0),
            Unit('ms', 'time', 1e-3),
            Unit('us', 'time', 1e-6),
            Unit('ns', 'time', 1e-9),
            Unit('min', 'time', 60.0),
            Unit('h', 'time', 3600.0),
            Unit('d', 'time', 86400.0),
        )
    }
)


def unit_of(name: object, quantity: str, where: str | Option) -> Unit:
    """The unit `name`, which must measure `quantity`. BadInput, begun with `where`, names the nearest valid one.

    A minus before it turns the sign: ``-mm`` of a displacement that was recorded as a length.
    """
    if isinstance(name, str) and name.startswith('-') and quantity not in ('temperature', 'time'):
        unit = unit_of(name[1:], quantity, where)
        return replace(unit, name=name, scale=-unit.scale)
    fitting = [unit.name for unit in UNITS.values() if unit.quantity == quantity]
    known = UNITS.get(name) if isinstance(name, str) else None
    if known is None:
        raise BadInput(where, f": unknown unit '{name}'{nearest(str(name), fitting)}")
    if known.quantity != quantity:
        raise BadInput(
            where, f": '{name}' is a unit of {known.quantity}, expected one of {quantity}: {', '.join(fitting)}"
        )
    return known

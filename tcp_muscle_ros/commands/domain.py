"""Where a simulation leaves what the model is valid for, and what any muscle survives."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import ZERO_CELSIUS
from tcp_muscle_ros.muscle.mechanical import COIL_LONGEST, COIL_SHORTEST, DOMAIN_HIGH, DOMAIN_LOW

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tcp_muscle_ros.muscle import Outputs
    from tcp_muscle_ros.recording.protocol import Protocol

_MELTS = ZERO_CELSIUS + 255.0  # K, nylon 6,6 (DSC onset about 255 degC; nylon 6 about 220 degC)


class Domain:
    """What is seen of a simulation that comes piece by piece. ``rest_length`` of the muscle, m."""

    def __init__(self, rest_length: float) -> None:
        self._rest_length = rest_length
        self._hottest, self._contraction = -np.inf, -np.inf
        self._count = self._outside = self._beyond = 0
        self._first: dict[str, float] = {}

    def look(self, outputs: Outputs) -> None:
        """Take in a piece. BadInput where the model has no finite answer."""
        finite = np.isfinite(outputs.fibre_temperature) & np.isfinite(outputs.displacement)
        if not finite.all():
            at = float(outputs.time[int(np.argmin(finite))])
            raise BadInput(
                f'the model has no finite answer from {at:.4g} s on: the muscle would have burnt before; less current?'
            )
        self._hottest = max(self._hottest, float(outputs.fibre_temperature.max()))
        self._contraction = max(self._contraction, float(outputs.displacement.max()))
        in_range = (outputs.fibre_temperature >= DOMAIN_LOW) & (outputs.fibre_temperature <= DOMAIN_HIGH)
        self._outside += int(np.count_nonzero(~in_range))
        self._beyond += int(np.count_nonzero(in_range & ~outputs.in_domain))
        self._count += outputs.time.size
        length = outputs.length / self._rest_length
        for what, beyond in (
            ('melts', outputs.fibre_temperature > _MELTS),
            ('long', length > COIL_LONGEST),
            ('short', length < COIL_SHORTEST),
        ):
            if beyond.any():
                self._first.setdefault(what, float(outputs.time[int(np.argmax(beyond))]))

    @property
    def summary(self) -> str:
        """The extremes, in one line."""
        return f'hottest {self._hottest - ZERO_CELSIUS:.4g} degC, largest contraction {1e3 * self._contraction:.4g} mm'

    def notes(self) -> Iterator[str]:
        """What is not to be believed of it, and why."""
        for count, what in (
            (self._beyond, 'a free law is used beyond its table, where it is extended in a straight line'),
            (self._outside, 'the fibre is outside 0 to 120 degC, where the model is not valid'),
        ):
            if count:
                share = 100.0 * count / self._count
                yield f'{f"{share:.0f} %" if share >= 1.0 else "less than 1 %"} of the time {what}'
        said = {
            'melts': f'the fibre is hotter than {_MELTS - ZERO_CELSIUS:.0f} degC, at which nylon melts',
            'long': f'the muscle is more than {COIL_LONGEST:g} times its own length, to which no coil stretches',
            'short': f'the muscle is shorter than {COIL_SHORTEST:g} times its own length, to which no coil contracts',
        }
        for what, at in self._first.items():
            yield f'from {at:.4g} s on {said[what]}: no real muscle does what is simulated there'


def refuse_what_no_node_takes(path: str, protocol: Protocol) -> None:
    """BadInput where a protocol asks for a drive, load or room beyond what sim_node takes."""
    from tcp_muscle_ros.control.safety import ABSURD
    from tcp_muscle_ros.recording.recording import CHANNELS
    from tcp_muscle_ros.settings.operating import OPERATING

    load, room = OPERATING['load_n'], OPERATING['ambient_temperature_c']
    limits = (
        (protocol.kind, [segment.value for segment in protocol.segments], 0.0, ABSURD, CHANNELS[protocol.kind].unit),
        ('load_n', [segment.load for segment in protocol.segments], load.low, load.high, load.unit),
        ('ambient_c', [segment.ambient for segment in protocol.segments], room.low, room.high, room.unit),
    )
    for name, ramps, low, high, unit in limits:
        shift = ZERO_CELSIUS if name == 'ambient_c' else 0.0
        for number, ramp in enumerate(ramps, 1):
            for value in ramp or ():
                if not low <= value - shift <= high:
                    raise BadInput(
                        f'{path}: segments {number}: {name} is {value - shift:g}, expected {low:g} to {high:g} {unit}, '
                        'as sim_node'
                    )

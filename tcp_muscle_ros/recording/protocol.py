"""A protocol: what is done to a muscle, written as segments, and sampled at a fixed rate.

```yaml
rate_hz: 100
input: current            # current | power | voltage
end: load                 # load | blocked | spring
repeat: 3                 # the whole list of segments, this many times
segments:
  - {duration_s: 30, value: 0.27, load_n: 0.588, ambient_c: 23}
  - {duration_s: 10, value: [0.27, 0]}     # a ramp; load and ambient stay as they were
```
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.recording import DRIVES, Array
from tcp_muscle_ros.recording.units import UNITS
from tcp_muscle_ros.recording.yaml_input import Section, as_number, load_yaml

ENDS = ('load', 'blocked', 'spring')
END_OPTIONS = ('held_length_m', 'spring_rate_n_per_m', 'spring_rest_length_m')
DEFAULT_LOAD_N = 0.588399  # 60 g, the load of the paper's figures
DEFAULT_AMBIENT_C = 23.0
_MOST_SAMPLES, _MOST_SEGMENTS = 50_000_000, 5_000_000


class Ramp(NamedTuple):
    """From `start` to `end` over a segment; a constant where both are equal."""

    start: float
    end: float


@dataclass(frozen=True)
class Segment:
    """One stretch of a protocol, SI; ``load`` and ``ambient`` None: as at the end of the segment before."""

    duration: float
    value: Ramp
    load: Ramp | None = None
    ambient: Ramp | None = None


class Sampled(NamedTuple):
    """A protocol on its ticks, each float64[n]: a drive at ``time[k]`` holds until ``time[k + 1]``.

    time s from 0 to the protocol's duration; drive A, W or V according to ``kind``; load N; ambient K
    """

    time: Array
    kind: str
    drive: Array
    load: Array
    ambient: Array


@dataclass(frozen=True)
class Protocol:
    """What is done to a muscle. ``end_options`` are those of END_OPTIONS that the file states."""

    rate_hz: float
    kind: str
    segments: tuple[Segment, ...]
    repeat: int = 1
    end: str = 'load'
    load: float = DEFAULT_LOAD_N
    ambient: float = UNITS['degC'].to_si(DEFAULT_AMBIENT_C)
    end_options: Mapping[str, float] = field(default_factory=dict)

    @property
    def duration(self) -> float:
        """All segments, all repeats, s."""
        return self.repeat * sum(segment.duration for segment in self.segments)

    @property
    def ticks(self) -> int:
        """How many ticks it lasts; it is sampled once more, at its end."""
        return round(self.duration * self.rate_hz)

    def sampled(self) -> Sampled:
        """The protocol at its rate; a segment begins with the first tick at or after its start."""
        (everything,) = self.pieces(self.ticks + 1)
        return everything

    def pieces(self, most: int) -> Iterator[Sampled]:
        """The same, at least ``most`` and fewer than twice as many ticks at a time, but for the last piece.

        Each piece begins with the last tick of the one before: what holds there holds into it.
        """
        parts: list[Sampled] = []
        fresh = 0  # ticks among the parts that no piece had yet
        for part in self._parts(most):
            parts.append(part)
            fresh += len(part.time)
            if fresh >= most:
                whole = _joined(parts)
                yield whole
                parts, fresh = [_last_tick(whole)], 0
        if fresh:
            yield _joined(parts)

    def _parts(self, most: int) -> Iterator[Sampled]:
        """Each segment, at most ``most`` ticks at a time."""
        start, first, count = 0.0, 0, self.repeat * len(self.segments)
        load, ambient = Ramp(self.load, self.load), Ramp(self.ambient, self.ambient)
        for k in range(count):
            segment = self.segments[k % len(self.segments)]
            end = start + segment.duration
            # a microtick of slack: 0.1 s at 10 Hz is one tick, whatever its binary fraction
            after = self.ticks + 1 if k == count - 1 else int(np.ceil(end * self.rate_hz - 1e-6))
            load = segment.load or Ramp(load.end, load.end)
            ambient = segment.ambient or Ramp(ambient.end, ambient.end)
            for at in range(first, after, most):
                time = np.arange(at, min(at + most, after)) / self.rate_hz
                share = np.clip((time - start) / segment.duration, 0.0, 1.0)
                samples = (ramp.start + share * (ramp.end - ramp.start) for ramp in (segment.value, load, ambient))
                yield Sampled(time, self.kind, *samples)
            start, first = end, max(first, after)


def _joined(parts: Sequence[Sampled]) -> Sampled:
    time, drive, load, ambient = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ('time', 'drive', 'load', 'ambient')
    )
    return Sampled(time, parts[0].kind, drive, load, ambient)


def _last_tick(piece: Sampled) -> Sampled:
    return Sampled(piece.time[-1:], piece.kind, piece.drive[-1:], piece.load[-1:], piece.ambient[-1:])


def read_protocol(path: str | Path) -> Protocol:
    """A protocol from its YAML file. BadInput names the key and the nearest valid one."""
    return parse_protocol(load_yaml(path, _shipped()))


def _shipped() -> list[Path]:
    """The protocols that come along, as they can be typed from here."""
    config, here = Path(str(resources.files('tcp_muscle_ros') / 'config')).resolve(), Path.cwd()
    found = sorted(config.glob('protocol_*.yaml'))
    return [path.relative_to(here) if path.is_relative_to(here) else path for path in found]


def parse_protocol(file: Section) -> Protocol:
    """A protocol from the content of its YAML file."""
    file.only('rate_hz', 'input', 'end', 'repeat', 'segments', 'load_n', 'ambient_c', *END_OPTIONS)
    segments = []
    for entry in file.sections('segments'):
        entry.only('duration_s', 'value', 'load_n', 'ambient_c')
        entry.require('value')
        load, ambient = _ramp(entry, 'load_n'), _ramp(entry, 'ambient_c')
        if load and min(load) < 0:
            raise BadInput(f'{entry.where}: load_n is {min(load):g}, expected >= 0: a load can only pull')
        value = _ramp(entry, 'value')
        assert value is not None
        if min(value) < 0.0:
            raise BadInput(
                f'{entry.where}: value is {min(value):g}, expected >= 0: either direction heats, and no node takes less'
            )
        segments.append(
            Segment(
                entry.number('duration_s', above=0.0),
                value,
                load,
                ambient and Ramp(*(UNITS['degC'].to_si(degrees) for degrees in ambient)),
            )
        )
    protocol = Protocol(
        rate_hz=file.number('rate_hz', above=0.0),
        kind=file.choice('input', DRIVES),
        segments=tuple(segments),
        repeat=file.count('repeat', 1),
        end=file.choice('end', ENDS, 'load'),
        load=file.number('load_n', DEFAULT_LOAD_N, least=0.0),
        ambient=UNITS['degC'].to_si(file.number('ambient_c', DEFAULT_AMBIENT_C)),
        end_options={key: file.number(key) for key in END_OPTIONS if key in file},
    )
    if protocol.repeat * len(segments) > _MOST_SEGMENTS:
        raise BadInput(
            f'{file.where}: {len(segments)} segment(s), {protocol.repeat} times, expected at most {_MOST_SEGMENTS:.0e} '
            'in all'
        )
    samples = protocol.duration * protocol.rate_hz
    if samples < 1 or samples > _MOST_SAMPLES:
        raise BadInput(
            f'{file.where}: {protocol.duration:g} s at rate_hz {protocol.rate_hz:g} are {samples:.3g} samples, '
            f'expected 1 to {_MOST_SAMPLES:.0e}'
        )
    return protocol


def _ramp(entry: Section, key: str) -> Ramp | None:
    if key not in entry:
        return None
    value, where = entry[key], f'{entry.where}: {key}'
    if isinstance(value, list):
        if len(value) != 2:
            raise BadInput(f'{where} has {len(value)} numbers, expected one number or a ramp [start, end]')
        return Ramp(as_number(value[0], where), as_number(value[1], where))
    number = as_number(value, where)
    return Ramp(number, number)

"""``rig.yaml``: what a rig's instruments do, and what the rig can do. Read, checked and written without ROS.

```yaml
instruments:
  temperature: {lag_s: {value: 1.2, low: 1.0, high: 1.5}, gain: 0.96}   # a number alone has no interval
  displacement: {delay_s: 0.1}
  current: {gain: 0.98, ohms_apart: 1}  # the resistance does not come from this ammeter
limits:
  largest_current_a: 0.27
  loads_n: [0.3, 0.588]     # that can be hung; empty: the load stays as it is
  loads_by: person
```

An instrument shows ``reference + gain (true(t - delay - pace t) - reference) + offset`` behind a first-order lag, where
the reference is the ambient for a temperature and zero for everything else; a thermometer also ``pickup_k_per_a`` for
each ampere through the muscle. Whatever is left out shows the truth.
Intervals are those of 90 %.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import isclose
from pathlib import Path
from typing import Any

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle import EFFECTS, ZERO_CELSIUS, Parameters
from tcp_muscle_ros.muscle.effects.clock_skew import CHANNELS as DELAYED
from tcp_muscle_ros.recording.recording import OUTPUTS
from tcp_muscle_ros.recording.yaml_input import Section, as_number, load_yaml
from tcp_muscle_ros.settings.operating import OPERATING, Operating, read_value

CURRENT = 'current'
PICKUP = 'pickup_k_per_a'
_UNIT = {'temperature': 'K', 'resistance': 'ohm', 'displacement': 'm', 'force': 'N', CURRENT: 'A'}


@dataclass(frozen=True)
class Quantity:
    """One property of an instrument with its 90 % interval; without one, low and high are the value."""

    value: float
    low: float
    high: float

    def inverse(self) -> 'Quantity':
        """Of 1 over it."""
        return Quantity(1.0 / self.value, 1.0 / self.high, 1.0 / self.low)


@dataclass(frozen=True)
class Row:
    """One key of an instrument. ``effect``: the parameter of the model that is it, or (``inverse``) 1 over it."""

    limits: Operating
    effect: str = ''
    inverse: bool = False


def _row(channel: str, key: str, effect: str, unit: str, meaning: str, bounds: tuple[float, float]) -> Row:
    inverse = effect == 'current_gain.g'
    if effect:  # the bounds are written where the effect is
        name, _, parameter = effect.partition('.')
        known = next(row for row in EFFECTS[name].parameters if row.name == parameter)
        bounds = (1.0 / known.high, 1.0 / known.low) if inverse else (known.low, known.high)
    return Row(
        Operating(f'{channel}.{key}', 1.0 if key == 'gain' else 0.0, unit, meaning, (), *bounds), effect, inverse
    )


def _rows(channel: str) -> Mapping[str, Row]:
    unit = _UNIT[channel]
    offset = f'offset_{unit.lower()}'
    effects = {
        'temperature': {
            'lag_s': 'thermocouple_lag.tau',
            'gain': 'thermocouple_gain.g',
            offset: 'temperature_offset.o',
            PICKUP: 'thermocouple_pickup.k',
        },
        'displacement': {offset: 'displacement_offset.o'},
        CURRENT: {'gain': 'current_gain.g', offset: 'current_gain.z', 'ohms_apart': 'current_gain.ohms'},
    }.get(channel, {})
    if channel in DELAYED:
        effects |= {'delay_s': 'clock_skew.d', 'pace': 'clock_skew.r'}
    keys = {
        'lag_s': ('s', 'first-order lag', (0.0, 100.0)),
        'gain': ('1', 'shown over true', (0.1, 10.0)),
        offset: (unit, 'shown beside what is true', (-100.0, 100.0)),
        'delay_s': ('s', 'how late its clock is', (0.0, 5.0)),
        'pace': ('1', 'seconds a second that its clock falls behind', (0.0, 5e-3)),
    }
    if channel == 'temperature':
        keys[PICKUP] = ('K/A', 'shown for each ampere through the muscle', (0.0, 0.0))
    if channel == CURRENT:
        keys['ohms_apart'] = ('1', 'resistance: 0 voltage over this current, 1 measured apart', (0.0, 1.0))
    return {key: _row(channel, key, effects.get(key, ''), *of_key) for key, of_key in keys.items()}


INSTRUMENTS: Mapping[str, Mapping[str, Row]] = {channel: _rows(channel) for channel in (*OUTPUTS, CURRENT)}
BY_EFFECT: Mapping[str, tuple[str, str]] = {
    row.effect: (channel, key)
    for channel, rows in INSTRUMENTS.items()
    for key, row in rows.items()
    if row.effect and not row.effect.startswith('clock_skew.')  # that one says itself which channel it is of
}

_LIMITS = {
    row.name: row
    for row in (
        replace(OPERATING['current_limit_a'], name='largest_current_a', meaning='largest current'),
        replace(OPERATING['derate_temperature_c'], name='highest_temperature_c', meaning='no protocol goes above it'),
        Operating('loads_by', 'person', '', 'who changes the load', (), choices=('person', 'rig')),
        Operating('held_end', False, '', 'whether the rig can hold the end of the muscle', ()),
        Operating('longest_run_s', 3600.0, 's', 'longest run', (), 1.0, 1e6),
    )
}


@dataclass(frozen=True)
class RigLimits:
    """What a rig can do, SI. ``loads``: those that can be hung, N; none: the load stays as it is."""

    largest_current: float = _LIMITS['largest_current_a'].number
    highest_temperature: float = _LIMITS['highest_temperature_c'].number + ZERO_CELSIUS
    loads: tuple[float, ...] = ()
    by_person: bool = True
    held_end: bool = False
    longest_run: float = _LIMITS['longest_run_s'].number


@dataclass(frozen=True)
class Rig:
    """A rig: ``instruments[channel][key]`` is there where an instrument does not show the truth; ``source``: its file,
    for messages."""

    instruments: Mapping[str, Mapping[str, Quantity]] = field(default_factory=dict)
    limits: RigLimits = RigLimits()
    source: str = field(default='rig', compare=False)

    def sensor_effects(self) -> dict[str, float]:
        """The parameters (``thermocouple_lag.tau``) of the effects with which the model shows what this rig shows.

        Raises:
            BadInput: an instrument does what no effect describes, or several clocks are late.
        """
        values: dict[str, float] = {}
        late = [name for name, found in self.instruments.items() if 'delay_s' in found or 'pace' in found]
        if len(late) > 1:
            raise BadInput(
                f'{self.source}: the clocks of {" and ".join(late)} are late, and the model delays one channel; '
                'correct the stamps of the others, and leave them out'
            )
        for channel, found in self.instruments.items():
            for key, quantity in found.items():
                row = INSTRUMENTS[channel][key]
                if not row.effect:
                    raise BadInput(
                        f'{self.source}: {channel}.{key}: no instrument of the model does that; correct the recording '
                        'by it, and leave it out'
                    )
                values[row.effect] = (quantity.inverse() if row.inverse else quantity).value
        if late:
            values |= {'clock_skew.channel': float(DELAYED.index(late[0]))}
        # What is left out of an instrument shows the truth, whatever is usual of the effect.
        effects = [EFFECTS[name] for name in sorted({name.partition('.')[0] for name in values})]
        true = {
            f'{e.name}.{p.name}': e.none if p.name == e.strength else p.value for e in effects for p in e.parameters
        }
        return {**true, **values}

    @property
    def effects(self) -> set[str]:
        """The effects of its instruments."""
        return {name.partition('.')[0] for name in self.sensor_effects()}


def on_rig(muscle: Parameters, rig: Rig | None) -> Parameters:
    """The muscle with the effects of a rig's instruments: the model then shows what this rig shows."""
    return muscle.with_effects(*sorted(rig.effects)).replace(rig.sensor_effects()) if rig else muscle


def beside(known: Rig | None, found: Rig) -> Rig:
    """What is known of a rig with what was found of it: of its instruments both, of its limits what is known.

    What was taken as known and not fitted keeps its interval.
    """
    if known is None:
        return found
    channels = {**known.instruments, **found.instruments}
    both = {c: {**known.instruments.get(c, {}), **found.instruments.get(c, {})} for c in channels}
    for channel, given in known.instruments.items():
        both[channel] |= {key: q for key, q in given.items() if isclose(both[channel][key].value, q.value)}
    return Rig(both, known.limits)


def read_rig(path: str | Path) -> Rig:
    """A rig from its file. BadInput names the key and the nearest valid one."""
    return parse_rig(load_yaml(path))


def parse_rig(file: Section) -> Rig:
    """A rig from the content of its file."""
    file.only('instruments', 'limits')
    instruments = {}
    section = file.section('instruments').only(*INSTRUMENTS)
    for channel in section.names():
        entry = section.section(channel).only(*INSTRUMENTS[channel])
        instruments[channel] = {key: _quantity(entry, key, INSTRUMENTS[channel][key]) for key in entry.names()}
    return Rig(instruments, _limits(file.section('limits')), file.where)


def _quantity(entry: Section, key: str, row: Row) -> Quantity:
    """A number, or a value with its interval."""
    if isinstance(entry.content[key], dict):
        given = entry.section(key).only('value', 'low', 'high')
        given.require('value')
        value = _bounded(given, 'value', row.limits)
        found = Quantity(value, *(_bounded(given, at, row.limits) if at in given else value for at in ('low', 'high')))
        if not found.low <= found.value <= found.high:
            raise BadInput(
                f'{given.where}: low {found.low:g}, value {found.value:g}, high {found.high:g}; expected in this order'
            )
        return found
    value = _bounded(entry, key, row.limits)
    return Quantity(value, value, value)


def _bounded(entry: Section, key: str, row: Operating) -> float:
    number = entry.number(key)
    if not row.low <= number <= row.high:
        raise BadInput(
            f'{entry.where}: {key} is {number:g}, expected {row.low:g} to {row.high:g} {row.unit} ({row.meaning})'
        )
    return number


def _limits(entry: Section) -> RigLimits:
    entry.only(*_LIMITS, 'loads_n')
    given: dict[str, Any] = {name: row.default for name, row in _LIMITS.items()}
    for name in entry.names():
        if name == 'loads_n':
            continue
        row = _LIMITS[name]
        if isinstance(row.default, float):
            given[name] = _bounded(entry, name, row)
        else:
            try:
                given[name] = read_value(row, entry[name])
            except BadInput as mistake:
                raise BadInput(f'{entry.where}: ', *mistake.args) from None
    return RigLimits(
        largest_current=float(given['largest_current_a']),
        highest_temperature=float(given['highest_temperature_c']) + ZERO_CELSIUS,
        loads=_loads(entry),
        by_person=given['loads_by'] == 'person',
        held_end=bool(given['held_end']),
        longest_run=float(given['longest_run_s']),
    )


def _loads(entry: Section) -> tuple[float, ...]:
    row, given = OPERATING['load_n'], entry.content.get('loads_n') or []
    if not isinstance(given, list):
        raise BadInput(f'{entry.where}: loads_n is {given!r}, expected a list of forces in N, such as [0.3, 0.588]')
    loads = [as_number(load, f'{entry.where}: loads_n') for load in given]
    wrong = [load for load in loads if not row.low <= load <= row.high]
    if wrong:
        raise BadInput(f'{entry.where}: loads_n has {wrong[0]:g}, expected {row.low:g} to {row.high:g} N')
    return tuple(sorted(set(loads)))


def render_rig(rig: Rig, heading: str = '') -> str:
    """The text of a rig's file, which ``read_rig`` reads back."""
    lines = [f'# {line}'.rstrip() for line in heading.splitlines()]
    lines.append('instruments:' if rig.instruments else 'instruments: {}')
    for channel, found in rig.instruments.items():
        lines.append(f'  {channel}:' if found else f'  {channel}: {{}}')
        for key, quantity in found.items():
            row = INSTRUMENTS[channel][key].limits
            numbers = ', '.join(f'{name}: {getattr(quantity, name)!r}' for name in ('value', 'low', 'high'))
            lines.append(f'    {key}: {{{numbers}}}  # {row.unit}; {row.meaning}')
    limits = rig.limits
    values = {
        'largest_current_a': repr(limits.largest_current),
        'highest_temperature_c': repr(round(limits.highest_temperature - ZERO_CELSIUS, 9)),
        'loads_n': repr(list(limits.loads)),
        'loads_by': 'person' if limits.by_person else 'rig',
        'held_end': 'true' if limits.held_end else 'false',
        'longest_run_s': repr(limits.longest_run),
    }
    return '\n'.join([*lines, 'limits:', *(f'  {name}: {value}' for name, value in values.items())]) + '\n'


def from_effects(found: Mapping[str, Quantity], channel: str = '', limits: RigLimits | None = None) -> Rig:
    """A rig whose instruments do what sensor effects say: what ``sensor_effects`` undoes.

    Args:
        found: the effects' parameters (``thermocouple_lag.tau``) with their intervals.
        channel: the channel whose clock ``clock_skew`` delays, where that is among them.
        limits: what the rig can do; default the usual.

    Raises:
        BadInput: a parameter that no key of an instrument is.
    """
    instruments: dict[str, dict[str, Quantity]] = {}
    for effect, quantity in found.items():
        if effect.startswith('clock_skew.'):
            rows = INSTRUMENTS.get(channel, {})
            at = next(((channel, key) for key, row in rows.items() if row.effect == effect), None)
        else:
            at = BY_EFFECT.get(effect)
        if at is None:
            raise BadInput(f"'{effect}' is no property of an instrument{nearest(effect, BY_EFFECT)}")
        row = INSTRUMENTS[at[0]][at[1]]
        instruments.setdefault(at[0], {})[at[1]] = quantity.inverse() if row.inverse else quantity
    return Rig(instruments, limits or RigLimits())

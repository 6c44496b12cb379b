"""Which columns are channels of a muscle, and in which units."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.lab.cells import number
from tcp_muscle_ros.recording.lab.columns import Column
from tcp_muscle_ros.recording.lab.draft import DraftColumn, DraftTime
from tcp_muscle_ros.recording.lab.times import kind_of
from tcp_muscle_ros.recording.plausibility import USUAL
from tcp_muscle_ros.recording.recording import CHANNELS, DRIVES, Array
from tcp_muscle_ros.recording.units import UNITS

_CHANNEL_OF = {'length': 'displacement', 'elongation': 'displacement'}
_COMMANDED = {**{name: f'{name}_command' for name in DRIVES}, 'displacement': 'displacement_setpoint'}
_STEADY = 0.02  # of its size, by which a load that hangs may vary
_FEWEST = 0.2  # share of the cells that are numbers
_ROOM = (278.0, 316.0)  # K
_SURE = 0.9  # of a correlation


@dataclass(frozen=True)
class Candidate:
    """A column that may be a channel."""

    channel: str
    column: Column
    value: Array  # as written, without the cells that are no numbers


def channels_of(
    columns: Sequence[Column], time: DraftTime | float, decimal: str, path: Path
) -> tuple[list[DraftColumn], list[str], list[str]]:
    """The channels of a table, the headings that are left out, and what was assumed.

    BadInput: several columns could be one channel, or the unit of one cannot be told.
    """
    found = [each for column in columns if (each := _candidate(column, columns, decimal)) is not None]
    clocks = _clocks(columns, time, decimal)
    drafts, notes = [], []
    for channel in dict.fromkeys(each.channel for each in found):
        chosen = _chosen(channel, [each for each in found if each.channel == channel], path)
        unit, note = _unit(chosen, path)
        notes += [note] if note else []
        kind = chosen.column.meaning.kind
        drafts.append(
            DraftColumn(
                channel,
                chosen.column.ref,
                unit,
                sign=-1 if kind in ('length', 'elongation') else 1,
                from_first=kind == 'length',
                time=clocks.get(chosen.column.index),
            )
        )
    drafts, more = _turned(drafts, found)
    used = {draft.ref for draft in drafts}
    times = {time.ref, time.date, time.fraction} if isinstance(time, DraftTime) else set()
    left = [c.heading for c in columns if c.heading and c.ref not in used | times and c.meaning.kind != 'time']
    return drafts, left, notes + more


def _candidate(column: Column, columns: Sequence[Column], decimal: str) -> Candidate | None:
    kind = column.meaning.kind
    channel = _CHANNEL_OF.get(kind, kind)
    if channel not in CHANNELS:
        return None
    numbers = [number(cell, decimal) for cell in column.cells]
    value = np.array([each for each in numbers if each is not None])
    if len(value) < max(_FEWEST * len(column.cells), 2):
        return None
    if column.meaning.commanded and channel in _COMMANDED:
        channel = _COMMANDED[channel]
    measured = any(other.meaning.kind == 'force' for other in columns)
    if channel == 'load' and not measured and np.ptp(value) > _STEADY * float(np.max(np.abs(value))):
        channel = 'force'  # what varies while the muscle works is measured, not hung on it
    return Candidate(channel, column, value)


def _chosen(channel: str, found: list[Candidate], path: Path) -> Candidate:
    """The one column for a channel: what is the muscle's own comes first, a stroke before a length."""
    for better in (
        [each for each in found if each.column.meaning.of_muscle],
        [each for each in found if each.column.meaning.kind == channel],
        found,
    ):
        if len(better) == 1:
            return better[0]
    names = ', '.join(f'{each.column.ref} in {each.column.meaning.unit or "?"}' for each in found)
    raise BadInput(
        f"{path}: {channel}: {len(found)} columns could be it ({names}); write 'muscle' into the heading of the right "
        'one, or say it in a map (--map, see docs/recording.md)'
    )


def _unit(chosen: Candidate, path: Path) -> tuple[str, str]:
    """The unit of a column, and a note where it is not written: then the only one in which the values are usual."""
    unit = chosen.column.meaning.unit
    if unit is not None:
        return unit, ''
    kind = CHANNELS[chosen.channel]
    fitting = [
        each.name
        for each in UNITS.values()
        if each.quantity == UNITS[kind.unit].quantity and _would_do(chosen.channel, each.to_si(chosen.value))
    ]
    if len(fitting) == 1:
        return fitting[
            0
        ], f'{chosen.column.ref} has no unit; taken as {fitting[0]}, in which alone its values are usual'
    low, high = float(np.min(chosen.value)), float(np.max(chosen.value))
    would = f'would do in {", ".join(fitting)}' if fitting else 'would do in none of its units'
    raise BadInput(
        f'{path}: {chosen.column.ref} has no unit, and {low:.4g} to {high:.4g} {would}; write it into the heading, as '
        f"'{chosen.column.heading} ({(fitting or [kind.unit])[0]})', or into a map (--map, see docs/recording.md)"
    )


def _would_do(channel: str, value: Array) -> bool:
    low, high = USUAL[channel.removesuffix('_command')]
    if not low <= float(np.max(np.abs(value))) <= high:
        return False
    return channel not in ('temperature', 'ambient') or _ROOM[0] <= float(np.min(value)) <= _ROOM[1]


def _clocks(columns: Sequence[Column], time: DraftTime | float, decimal: str) -> dict[int, DraftTime]:
    """Which columns have a clock of their own: a second column of times stands before them."""
    if not isinstance(time, DraftTime):
        return {}
    found: dict[int, DraftTime] = {}
    own: DraftTime | None = None
    first = next(column.heading for column in columns if column.ref == time.ref)
    for column in columns:
        if column.heading == first and column.ref != time.ref:
            kind = kind_of(column.cells, column.meaning.unit, decimal)
            own = DraftTime(column.ref, kind.unit) if kind is not None else None
        elif own is not None:
            found[column.index] = own
    return found


def _turned(drafts: list[DraftColumn], found: list[Candidate]) -> tuple[list[DraftColumn], list[str]]:
    """A displacement that falls as the muscle warms counts the other way."""
    by_ref = {each.column.ref: each for each in found}
    warm = next((by_ref[draft.ref] for draft in drafts if draft.channel == 'temperature'), None)
    out, notes = [], []
    for draft in drafts:
        each = by_ref[draft.ref]
        if draft.channel == 'displacement' and each.column.meaning.kind == 'displacement' and warm is not None:
            a, b = each.value, warm.value
            moves = len(a) == len(b) > 9 and np.ptp(a) > 0.0 and np.ptp(b) > 0.0
            with np.errstate(all='ignore'):  # a file may hold inf
                falls = moves and np.corrcoef(a, b)[0, 1] < -_SURE
            if falls:
                draft = DraftColumn(draft.channel, draft.ref, draft.unit, sign=-1, time=draft.time)
                notes.append(
                    f'{draft.ref} falls as the muscle warms; its sign is turned, so that contraction is positive'
                )
        out.append(draft)
    return out, notes

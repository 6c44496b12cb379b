"""What was understood of a lab file: the draft of an import map."""

from dataclasses import dataclass, field

from tcp_muscle_ros.recording.lab.grid import Layout


@dataclass(frozen=True)
class ColumnRef:
    """A column by its heading (``occurrence`` where headings repeat), or by its index where it has none."""

    column: str | int
    occurrence: int | None = None

    def __str__(self) -> str:
        name = f"'{self.column}'" if isinstance(self.column, str) else f'column {self.column}'
        return name if self.occurrence is None else f'{name} ({self.occurrence})'


@dataclass(frozen=True)
class DraftTime:
    """A column of times: its unit, or ``clock`` or ``stamp``; what is read with it; where a counter wraps; what was
    assumed of it."""

    ref: ColumnRef
    unit: str
    order: str = 'dmy'
    date: ColumnRef | None = None
    fraction: ColumnRef | None = None
    fraction_unit: str = 's'
    wraps: float = 0.0
    note: str = ''


@dataclass(frozen=True)
class DraftColumn:
    """A channel and the column that it is in."""

    channel: str
    ref: ColumnRef
    unit: str
    sign: int = 1
    scale: float = 1.0
    from_first: bool = False
    time: DraftTime | None = None
    why: str = ''


@dataclass(frozen=True)
class DraftRun:
    """One run of a file. ``time``: a column, or the period in s."""

    name: str
    layout: Layout
    time: DraftTime | float
    columns: tuple[DraftColumn, ...]
    known: dict[str, object] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

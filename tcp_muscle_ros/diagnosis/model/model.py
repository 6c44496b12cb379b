"""The plug: what the rooms above ask of a machine. They know no parameter, state or channel of it by name.

A machine is what can be simulated under what was imposed, with effects that may be on. Its parameters are a mapping
with ``effects``, ``replace``, ``with_effects`` and ``only_effects``, as ``muscle/parameters.py`` has it; what it shows
is an object with ``time`` and a column for each channel. An effect says of itself what is asked of it
(``muscle/effects/effect.py``).
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from tcp_muscle_ros.diagnosis.model.unknown import Unknown
from tcp_muscle_ros.muscle import Effect
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.parameter import Parameter


@dataclass(frozen=True)
class Channel:
    """One channel that is observed.

    ``title``, ``unit``: as people call and write it, ``factor`` times the SI value. ``wander``: standard deviation (SI)
    of what its instrument shows beside the truth, slowly, over minutes, after ``source``. ``floating``: its zero is a
    convention of the rig, for it shows how the end moves. ``adds``: what it would tell where it was not recorded, and
    ``without``: what cannot be known then.
    """

    stage: str
    title: str
    unit: str
    factor: float
    wander: float
    source: str
    floating: bool = False
    adds: str = ''
    without: str = ''


@dataclass(frozen=True)
class Surroundings:
    """How far a room that no thermometer reads goes its own way, after ``source``: standard deviation ``wander`` (K),
    much the same over a ``pace`` (s)."""

    wander: float
    pace: float
    source: str


@dataclass(frozen=True)
class Ratio:
    """A ratio of two parameters that recordings may fix where they fix neither: its ``name`` and ``unit``."""

    name: str
    top: str
    bottom: str
    unit: str


@dataclass(frozen=True)
class Dependence:
    """What a law without a name may depend on: the ``column`` that has it.

    ``by_loads``: under one and the same load it goes with the state and the motion, so that only different loads tell
    what depends on it. ``given_at``: the ends at which it is imposed; ``shown_by``: the channels of which one must be
    recorded elsewhere, for what was never seen is only assumed; where there are none, it is known without.
    """

    column: str
    by_loads: bool = False
    given_at: frozenset[str] = frozenset()
    shown_by: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Roles:
    """The effects that are fitted in a way of their own, by what each says of itself; '' where there is none.

    ``swings``: after it a weight swings; ``course`` of the conductance and ``room``: how they went in time is inferred;
    ``slips``: it is the mean of sudden slips, in its parameters ``rate`` and ``begins``; ``sticks``: it holds and lets
    go; ``like_slips``: what slips pass for.
    """

    swings: str = ''
    course: str = ''
    room: str = ''
    slips: str = ''
    sticks: str = ''
    like_slips: tuple[str, ...] = ()
    rate: str = ''
    begins: str = ''

    @property
    def inferred(self) -> frozenset[str]:
        """Those whose way in time is inferred."""
        return frozenset({self.course, self.room} - {''})

    @classmethod
    def of(cls, effects: Mapping[str, Effect]) -> 'Roles':
        """Those among these effects."""

        def the_one(says: Callable[[Effect], bool]) -> str:
            return next((name for name, effect in effects.items() if says(effect)), '')

        slips = the_one(lambda effect: effect.latent == 'slips')
        return cls(
            the_one(lambda effect: effect.swings),
            the_one(lambda effect: effect.latent == 'course'),
            the_one(lambda effect: effect.latent == 'room'),
            slips,
            the_one(lambda effect: effect.sticks),
            tuple(name for name, effect in effects.items() if effect.like_slips),
            f'{slips}.{effects[slips].strength}' if slips else '',
            f'{slips}.{effects[slips].threshold}' if slips else '',
        )


class Recorded(Protocol):
    """A recording as it is observed (``observation/experiment.py``)."""

    @property
    def imposed(self) -> Any:
        """Drive, load and surroundings over time."""

    @property
    def holding(self) -> Any:
        """What holds the end."""

    @property
    def observed(self) -> Mapping[str, Any]:
        """What was seen, by channel."""

    @property
    def known(self) -> Mapping[str, object]:
        """What else is known of it."""


class Model(Protocol):
    """A machine that recordings are compared with.

    ``effects``: what it may do beside what it is known to do; ``listed``: those that may be named; ``specifications``:
    all its parameters and those of its effects. ``surroundings``: what is around it. ``state``: the column of what is
    simulated that orders what its laws do, called ``state_title`` (in ``state_unit``) by people; ``gauge``: the channel
    that reads it; ``motion``: the column in which its end moves. ``gain``: the parameter that scales the motion;
    ``loss``: the one by which a drive moves the state so far and no farther, '' where that is none alone;
    ``capacity``: the one that makes it slow; ``slowness``: the name of the ratio that is its time constant; ``coarse``:
    those whose nominal values may be far off; ``separate``: those that each specimen may have for itself. ``shown_by``:
    the channels that show a stage, where not all do. ``laws``: what a law without a name may depend on.
    """

    effects: ClassVar[Mapping[str, Effect]]
    roles: ClassVar[Roles]
    listed: ClassVar[Sequence[str]]
    specifications: ClassVar[Mapping[str, Parameter]]
    channels: ClassVar[Mapping[str, Channel]]
    surroundings: ClassVar[Surroundings]
    state: ClassVar[str]
    state_title: ClassVar[str]
    state_unit: ClassVar[str]
    gauge: ClassVar[str]
    motion: ClassVar[str]
    gain: ClassVar[str]
    loss: ClassVar[str] = ''
    capacity: ClassVar[str]
    slowness: ClassVar[str]
    coarse: ClassVar[tuple[str, ...]]
    separate: ClassVar[tuple[str, ...]]
    ratios: ClassVar[tuple[Ratio, ...]]
    shown_by: ClassVar[Mapping[str, frozenset[str]]]
    laws: ClassVar[Mapping[str, Dependence]]

    def simulate(
        self,
        recorded: Recorded,
        parameters: Any,
        start: float | None,
        resolution: float,
        only: Collection[str] | None,
        ambient: Array | None,
    ) -> Any:
        """What it shows under what was imposed, at those instants, from the state ``start``; at this share of the
        usual substeps; only these columns; in other surroundings than were read."""

    def steps(self, recorded: Recorded, parameters: Any, resolution: float) -> float:
        """About how many steps that takes."""

    def strained(self, outputs: Any) -> float:
        """How far beyond what it survives, in units of what that is known to; 0 where it survived."""

    def time_constant(self, parameters: Any) -> float:
        """Its slowest, s."""

    def exposed(self, parameters: Any, outputs: Any) -> Array:
        """What makes the end slip, beyond what holds it, in the unit of its motion, at each instant."""

    def unknowns(self, recordings: Sequence[Recorded], nominal: Any, separate: Mapping[str, bool]) -> list[Unknown]:
        """What a calibration fits: what the recorded channels can say anything about."""


def ages(model: Model, effects: Iterable[str]) -> tuple[str, ...]:
    """The parameters of these effects that say what the machine went through before a recording."""
    return tuple(f'{name}.{model.effects[name].age}' for name in effects if model.effects[name].age)


def floating(model: Model) -> tuple[str, ...]:
    """The channels whose zero is a convention of the rig."""
    return tuple(name for name, channel in model.channels.items() if channel.floating)

"""What a diagnosis says: plain data, in SI, without a word about how it is shown.

The report (JSON, HTML, figures, terminal) is made from ``Diagnosis`` alone.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from tcp_muscle_ros.diagnosis.search.location import Location, Unexplained
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.muscle.arrays import Array

VERDICTS = ('match', 'wrong_parameters', 'sensor_or_setup', 'missing_physics', 'unexplained', 'insufficient_data')
PHASES = ('heating', 'cooling', 'rest', 'transition')


@dataclass(frozen=True)
class Value:
    """A fitted number with its 90 % interval. SI, absolute temperatures in K."""

    value: float
    low: float
    high: float
    unit: str
    nominal: float = float('nan')
    fixed: bool = True
    at_bound: bool = False


@dataclass(frozen=True)
class Change:
    """A root mean square error (SI of the channel) before and after."""

    before: float
    after: float


@dataclass(frozen=True)
class RecordingSummary:
    """One recording as it was read."""

    path: str
    duration: float
    rate: float
    channels: tuple[str, ...]
    issues: tuple[str, ...]


@dataclass(frozen=True)
class Finding:
    """One named effect. ``held_out`` is the free-run error on data not used for the fit, by channel.

    ``confidence`` is the probability of this effect among those it competes with; ``indistinguishable_from`` are the
    others that the data admit as well.
    """

    effect: str
    stage: str
    sentence: str
    equation: str
    parameters: Mapping[str, Value]
    confidence: float
    indistinguishable_from: tuple[str, ...]
    held_out: Mapping[str, Change]
    gain: float


@dataclass(frozen=True)
class ChannelFit:
    """Root mean square errors of one channel over all recordings (SI); ``held_out``: improved is on unseen data.

    ``replayed``: what a replay of the improved muscle shows on the whole recordings, every sample, without what belongs
    to their sensors and their start.
    """

    nominal: float
    calibrated: float
    improved: float
    noise: float
    held_out: bool
    replayed: float = float('nan')


@dataclass(frozen=True)
class NotTestable:
    """An effect that these recordings could not have shown, and why."""

    effect: str
    why: str


@dataclass(frozen=True)
class Step:
    """One segment of a proposed protocol: held for ``duration`` s; current in A, load in N."""

    duration: float
    current: float
    load: float


@dataclass(frozen=True)
class Proposal:
    """The experiment that would decide between two effects, and the probability that it does."""

    separates: tuple[str, str]
    name: str
    reason: str
    steps: tuple[Step, ...]
    repeat: int
    rate: float
    end: str
    power: float


@dataclass(frozen=True)
class Ranked:
    """One candidate of the ranking: how much it improves the fit (log likelihood ratio, twice) and over what."""

    effect: str
    stage: str
    gain: float
    refitted: bool


@dataclass(frozen=True)
class Series:
    """One channel of one recording for the figures: recorded, and the three models (SI), all shape (m,).

    ``temperature`` is the fitted fibre temperature (K), ``rate`` its rate (K/s), ``heating`` whether the drive is on.
    """

    channel: str
    time: Array
    recorded: Array
    nominal: Array
    before: Array
    after: Array
    temperature: Array
    rate: Array
    heating: Array


@dataclass(frozen=True)
class Diagnosis:
    """The whole outcome. ``headline`` is the one plain sentence; ``improved`` the muscle that sim_node should use."""

    headline: str
    verdict: str
    recordings: tuple[RecordingSummary, ...]
    noise: Mapping[str, float]
    calibration: Mapping[str, Value]
    sensors: Mapping[str, Value]
    location: Location | None
    findings: tuple[Finding, ...]
    fit: Mapping[str, ChannelFit]
    ranking: tuple[Ranked, ...]
    not_testable: tuple[NotTestable, ...]
    unexplained: Unexplained | None
    next_experiment: Proposal | None
    nominal: Parameters
    improved: Parameters
    drive: tuple[tuple[str, Array, Array], ...] = ()
    series: tuple[tuple[Series, ...], ...] = ()
    notes: tuple[str, ...] = ()
    partial: bool = False
    seconds: Mapping[str, float] = field(default_factory=dict)

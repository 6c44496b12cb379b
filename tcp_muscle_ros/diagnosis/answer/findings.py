"""What a diagnosis says: plain data, in SI, without a word about how it is shown.

The report (JSON, HTML, figures, terminal) is made from ``Diagnosis`` alone.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from tcp_muscle_ros.diagnosis.fitting.calibration import Known
from tcp_muscle_ros.diagnosis.search.location import Location, Unexplained
from tcp_muscle_ros.diagnosis.search.selected import Weighed
from tcp_muscle_ros.muscle import EFFECTS, Parameters
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.settings.ages import Age
from tcp_muscle_ros.settings.rig import Rig

VERDICTS = (
    'match',
    'wrong_parameters',
    'not_repeatable',
    'sensor_or_setup',
    'unexplained',
    'missing_physics',
    'insufficient_data',
)
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
    """A root mean square error (SI of the channel, of single samples) without something, and with it."""

    before: float
    after: float


@dataclass(frozen=True)
class Run:
    """What one recording has for itself: its ``gain`` over the mean of all, its ``time_constant`` (s), and what the
    model misses of it, as a share of its peak. ``protocol``: a number that runs of the same have, None for a single
    one."""

    name: str
    protocol: int | None
    gain: float
    time_constant: float
    error: float


@dataclass(frozen=True)
class RunToRun:
    """What runs of one protocol do not share: by channel (SI) in ``sizes``.

    Where that is more than noise, ``channel`` shows it most: ``repeatability`` with a gain of its own for each run,
    ``plain`` without, and the ``error`` of the improved model, all as shares of the peak; ``own_gain``: whether each
    recording was given one; ``runs``: one by one; ``scales``: of ``repeatability``, what is quick, between, and slow.
    """

    sizes: Mapping[str, float]
    channel: str = ''
    repeatability: float = float('nan')
    plain: float = float('nan')
    error: float = float('nan')
    own_gain: bool = False
    runs: tuple[Run, ...] = ()
    scales: tuple[float, ...] = ()


@dataclass(frozen=True)
class RecordingSummary:
    """One recording as it was read."""

    path: str
    duration: float
    rate: float
    channels: tuple[str, ...]
    issues: tuple[str, ...]


@dataclass(frozen=True)
class InWords:
    """A law without a name by a form: its name, the sentence that says it, its ``equation`` with ``parameters`` (value
    and unit), the other forms that fit its table ``as_well``, and its values where the law's curve has its own."""

    form: str
    sentence: str
    equation: str
    parameters: Mapping[str, tuple[float, str]]
    as_well: tuple[str, ...]
    value: Array


@dataclass(frozen=True)
class FreeLaw:
    """The curve of a law without a name: ``value`` over the driver ``at`` (SI, shape (m,)), 90 % between ``low`` and
    ``high``; ``unit``: of the values; ``nearest``: the listed effect that comes closest, None where none does, and
    ``nearest_share``: of what the law removes of the misfit, what that one removes alone, None where that is not known.
    ``in_words``: None where no form predicts unseen data as well."""

    driver: str
    unit: str
    at: Array
    value: Array
    low: Array
    high: Array
    nearest: str | None
    nearest_share: float | None = None
    in_words: InWords | None = None


@dataclass(frozen=True)
class Member:
    """A cause of a cluster of causes that look alike, and the share of the cluster's probability that is its own."""

    effect: str
    stage: str
    probability: float


@dataclass(frozen=True)
class Finding:
    """One named effect, or a law without a name (``unlisted``).

    ``probability``: that it is there, rather than one of those it competes with or nothing; ``indistinguishable_from``:
    the others that the data admit as well. ``improvement``: the free-run error on data not used for the fit, by
    channel that it changes: with all other findings but without this one, and with all. ``evidence``: what its
    probability is made from, by term (answer/probability.py). ``cluster``: the causes that compete for its place,
    itself too; their probabilities add up to one, and empty where none does. ``one_channel``: nothing else was
    recorded, so that no stage is told.
    """

    effect: str
    stage: str
    sentence: str
    equation: str
    parameters: Mapping[str, Value]
    probability: float
    indistinguishable_from: tuple[str, ...]
    improvement: Mapping[str, Change]
    gain: float
    unlisted: FreeLaw | None = None
    evidence: Mapping[str, float] = field(default_factory=dict)
    cluster: tuple[Member, ...] = ()
    one_channel: bool = False

    @property
    def may_be_nothing(self) -> bool:
        """Whether the intervals of all by which it acts contain no effect."""
        return includes_nothing(self.effect, self.parameters)

    @property
    def singled_out(self) -> bool:
        """Whether the data admit it and nothing else in its place, not even nothing; one channel never tells that."""
        return not self.indistinguishable_from and not self.may_be_nothing and not self.one_channel


@dataclass(frozen=True)
class ChannelFit:
    """Root mean square errors of one channel over all recordings, all of single samples (SI).

    ``nominal``, ``calibrated`` and ``improved``: of replays of the whole recordings with the nominal muscle, the
    recalibrated one, and improved.yaml on rig.yaml. ``held_out``: the free-run error on data not used for the fit,
    recalibrated and with all findings; None where nothing was held out. ``fitted``: of the fit with all findings, which
    the figures show; it has also what is of these recordings alone (a room that drifted), and improved.yaml has not.
    """

    nominal: float
    calibrated: float
    improved: float
    noise: float
    held_out: Change | None = None
    fitted: float | None = None


@dataclass(frozen=True)
class NotTestable:
    """An effect that these recordings could not have shown, and why."""

    effect: str
    why: str


@dataclass(frozen=True)
class Step:
    """One segment of a proposed protocol: held for ``duration`` s; load in N, current in A, or W or V in its place
    where a power or a voltage is proposed."""

    duration: float
    current: float
    load: float


@dataclass(frozen=True)
class Proposal:
    """The experiment that would decide between two effects, and the probability that it does.

    ``ambient``: the room it was planned for, K; None where that is not known; ``kind``: of its drive.
    """

    separates: tuple[str, str]
    name: str
    reason: str
    steps: tuple[Step, ...]
    repeat: int
    rate: float
    end: str
    power: float
    ambient: float | None = None
    kind: str = 'current'

    @property
    def duration(self) -> float:
        """Of all repetitions, s."""
        return self.repeat * sum(step.duration for step in self.steps)


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
class Sticking:
    """That a ``channel`` sticks and slips, in some of the ``seen`` recordings that show it (``recordings``: their
    names): how long most ``rests`` are (s, from, to), and how large most ``jumps`` (SI).

    ``values``: of the effect's parameters, with which the improved muscle sticks as they do; empty where none are
    known. ``alike_jumps``, ``alike_rests``: the probability that what is simulated with them differs so much by chance.
    """

    channel: str
    recordings: tuple[str, ...]
    seen: int
    rests: tuple[float, float]
    jumps: tuple[float, float]
    values: Mapping[str, float] = field(default_factory=dict)
    alike_jumps: float | None = None
    alike_rests: float | None = None


@dataclass(frozen=True)
class Imitated:
    """A recording (its ``name``) that sticks and slips, and one simulation of the improved muscle that does, at
    ``time`` (s): ``recorded`` and ``simulated`` (SI, shape (n,)) of a ``channel``."""

    name: str
    channel: str
    time: Array
    recorded: Array
    simulated: Array


@dataclass(frozen=True)
class Diagnosis:
    """The whole outcome.

    ``headline`` is the one plain sentence; ``calibrated`` the nominal muscle recalibrated, without what was found,
    ``improved`` the muscle that sim_node should use, as it is after the last recording; ``ages`` how old it was in
    each; ``rig`` what the instruments do; ``known`` how well the improved muscle is known, None where nothing was
    fitted.

    ``repeatability``: by channel what runs of one protocol do not share (SI), None where there are no replicates.
    ``runs``: what each has for itself where they differ.
    ``doubtful``: effects that were found and are not named, for they are not probable enough.
    ``sticking``: that the motion sticks and slips, None where it does not.
    ``stopped``: the sentence that leads where contractions end against a stop, else ''.
    ``imitated``: the recording that sticks and slips most beside a simulation that does, None where none does.
    ``would_help``: what to record so that an undecided question can be decided, where no planned experiment would.
    """

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
    ages: tuple[Age, ...] = ()
    rig: Rig = field(default_factory=Rig)
    drive: tuple[tuple[str, Array, Array], ...] = ()
    series: tuple[tuple[Series, ...], ...] = ()
    notes: tuple[str, ...] = ()
    partial: bool = False
    seconds: Mapping[str, float] = field(default_factory=dict)
    calibrated: Parameters | None = None
    repeatability: Mapping[str, float | None] = field(default_factory=dict)
    runs: tuple[Run, ...] = ()
    verdict_probability: float | None = None
    would_help: tuple[str, ...] = ()
    doubtful: tuple[Weighed, ...] = ()
    sticking: Sticking | None = None
    stopped: str = ''
    imitated: Imitated | None = None
    known: Known | None = None

    @property
    def tried(self) -> bool:
        """Whether any listed effect was."""
        return bool(self.ranking)


def strengths(effect: str, parameters: Mapping[str, Value]) -> list[tuple[Value, float]]:
    """The values by which an effect acts, each with that of no effect.

    These are its strength, one or one for each recording (``g [2]``), and what else of it is usually zero, such as the
    zero of an ammeter beside its gain.
    """
    definition = EFFECTS.get(effect)
    if definition is None:
        return []
    nothing = {row.name: 0.0 for row in definition.fitted if row.value == 0.0} | {definition.strength: definition.none}
    own = [(name.removeprefix(f'{effect}.').split(' ')[0], value) for name, value in parameters.items()]
    return [(value, nothing[name]) for name, value in own if name in nothing]


def includes_nothing(effect: str, parameters: Mapping[str, Value]) -> bool:
    """Whether the intervals of all by which an effect acts contain no effect: one that does not says that it is there.

    An exponent or a pace that may be zero takes nothing from a strength that may not.
    """
    bounds = strengths(effect, parameters)
    return bool(bounds) and all(v.low <= none <= v.high for v, none in bounds)

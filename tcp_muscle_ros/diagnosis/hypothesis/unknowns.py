"""What a fit may change: parameters of the muscle and of effects, and what each recording starts from.

Every unknown has a weak prior around its nominal value, so that a direction which the data do not fix stays where it
was and is reported as not fixed, instead of running away.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle import EFFECTS, SPECIFICATIONS, Parameters
from tcp_muscle_ros.recording.mending import RESUMED

AMBIENT, START = 'ambient', 'initial_temperature'
STIFFNESS = 'k0'
SEPARABLE = ('hA', 'C', 'R0', 'B', STIFFNESS)
GAIN, CAPACITY = 'B', 'C'  # by which specimens of one kind differ: their stroke, their time constant
_OHMMETER = 0.1
_MATERIAL = 0.3  # spread of the logarithm of what differs from one coil to the next of its kind
_ANYWHERE = 50.0  # K, where a recording begins in the middle of something
# Fixed by the data: the interval is half the prior's at most, and spans less than a factor of two.
_NARROWED, FACTOR = 0.5, 0.2
_LONGEST, _SOFTER = 2.0, 0.5  # times its length, which a load stretches no muscle to; of the stiffness as assumed
_LOG_SPREAD = 1.5  # prior standard deviation of a positive parameter's logarithm: a factor of 4.5 either way


@dataclass(frozen=True)
class Unknown:
    """One unknown. ``log``: fitted as a logarithm. ``recording``: the one it belongs to, None for all.

    ``start``, ``low``, ``high`` are in the parameter's own unit; ``spread`` is the prior's standard deviation, of the
    logarithm where ``log``.
    """

    name: str
    start: float
    low: float
    high: float
    spread: float
    log: bool = False
    recording: int | None = None

    def to_fit(self, value: float) -> float:
        """The coordinate that the fit moves."""
        return float(np.log(value)) if self.log else value / self.spread

    def from_fit(self, z: float) -> float:
        """The value at a coordinate, kept inside the bounds against rounding."""
        value = float(np.exp(z)) if self.log else z * self.spread
        return min(max(value, self.low), self.high)

    @property
    def prior_spread(self) -> float:
        """The prior's standard deviation in the fit's coordinate."""
        return self.spread if self.log else 1.0

    def fixed_by(self, spread: float) -> bool:
        """Whether data that leave this spread (fit's coordinate) fix it: well within the prior, and to a factor."""
        return spread < min(_NARROWED * self.prior_spread, FACTOR if self.log else np.inf)

    @property
    def key(self) -> tuple[str, int | None]:
        """What identifies it."""
        return self.name, self.recording


def positive(
    nominal: Parameters, name: str, recording: int | None = None, spread: float = _LOG_SPREAD, least: float = 1e-12
) -> Unknown:
    """A positive parameter of the muscle, by its logarithm, no less than its bound and ``least``."""
    row = SPECIFICATIONS[name]
    return Unknown(name, nominal[name], max(row.low, least), row.high, spread, log=True, recording=recording)


def effect_unknowns(name: str, parameters: Parameters, owner: int | None = None) -> list[Unknown]:
    """The unknowns of an effect: its parameters, each free over its bounds; of one recording (``owner``) or of all.

    A positive parameter whose bounds span more than a decade moves by its logarithm (time constants); amplitudes, which
    may vanish, move linearly.
    """
    unknowns = []
    effect = EFFECTS[name]
    for row in effect.fitted:
        key = f'{name}.{row.name}'
        wide = row.low > 0.0 and row.high / row.low > 10.0
        value = parameters[key]
        spread = 1.5 if wide else max(abs(row.value), 0.25 * (row.high - row.low) if row.value == 0.0 else 0.0) * 2.0
        unknowns.append(Unknown(key, value, row.low, row.high, spread, log=wide, recording=owner))
    return unknowns


def base_unknowns(
    experiments: Iterable[Experiment], nominal: Parameters, separate: Mapping[str, bool] | None = None
) -> list[Unknown]:
    """The unknowns of a calibration: what the recorded channels can say anything about.

    Electrical R0, a_R; thermal hA, C; mechanical stroke gain B, its shape c2, stiffness k0; per recording the ambient
    (where it was not recorded) and the temperature at the start. ``separate`` names parameters fitted per recording.
    """
    experiments = list(experiments)
    separate = separate or {}
    channels = set().union(*(e.observed for e in experiments))
    names = ['hA', 'C']
    seen_resistance = 'resistance' in channels
    if seen_resistance or any(e.imposed.kind != 'power' for e in experiments):
        names += ['R0']
    mechanical = channels & {'displacement', 'force'}
    if mechanical:
        names += ['B', STIFFNESS]
    unknowns: list[Unknown] = []
    for name in names:
        owners: list[int | None] = list(range(len(experiments))) if separate.get(name) else [None]
        # A resistance that was not recorded still heats: it is then known as well as an ohmmeter's reading ages.
        spread = _OHMMETER if name == 'R0' and not seen_resistance else _LOG_SPREAD
        # Without a thermometer all temperatures could be twice as large: what is known of the materials anchors them.
        spread = _MATERIAL if name == STIFFNESS and 'temperature' not in channels else spread
        least = _softest(experiments, nominal) if name == STIFFNESS else 1e-12
        unknowns += [positive(nominal, name, owner, spread, least) for owner in owners]
    if 'R0' in names:
        row = SPECIFICATIONS['a_R']
        spread = 0.002 if seen_resistance and 'temperature' in channels else 0.5 * _MATERIAL * nominal['a_R']
        unknowns.append(Unknown('a_R', nominal['a_R'], row.low, row.high, spread))
    if mechanical:
        row = SPECIFICATIONS['c2']
        unknowns.append(Unknown('c2', nominal['c2'], row.low, row.high, 4e-4))
    for k, experiment in enumerate(experiments):
        seen = 'temperature' in experiment.observed
        still = float(experiment.imposed.ambient[0])
        if np.ptp(experiment.imposed.ambient) == 0.0:
            unknowns.append(Unknown(AMBIENT, still, still - 40.0, still + 40.0, 3.0 if seen else 1.0, recording=k))
        begins = _ANYWHERE if experiment.known.get(RESUMED) else 10.0 if seen else 1.0
        unknowns.append(Unknown(START, still, still - 40.0, still + 150.0, begins, recording=k))
    return unknowns


def _softest(experiments: Iterable[Experiment], nominal: Parameters) -> float:
    """The least stiffness (N/m): with less the load would have drawn the muscle to twice its length, as where it hangs
    one sees that it does not. Under one load a stroke alone hardly tells."""
    pulls = [float(np.median(e.imposed.load)) for e in experiments if e.holding.end == 'load']
    return min(max(pulls, default=0.0) / ((_LONGEST - 1.0) * nominal['H0']), _SOFTER * nominal['k0'])

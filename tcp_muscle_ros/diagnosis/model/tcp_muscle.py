"""The muscle, as a diagnosis asks for it: the one place above the readers of recordings that knows its names.

Electrical R0, a_R; thermal hA, C; mechanical stroke gain B, its shape c2, stiffness k0; and for each recording the room
(where it was not recorded) and the temperature at the start.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tcp_muscle_ros.diagnosis.model.model import Channel, Dependence, Model, Ratio, Recorded, Roles, Surroundings
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT, LOG_SPREAD, START, Unknown
from tcp_muscle_ros.muscle import EFFECTS, LISTED, SPECIFICATIONS, Effect, Muscle, Outputs, Parameters, follow, length
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.muscle import NoMuscle
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.stepping import SUBSTEP
from tcp_muscle_ros.muscle.table import INDEX
from tcp_muscle_ros.recording.mending import RESUMED

STIFFNESS = 'k0'
SEPARABLE = ('hA', 'C', 'R0', 'B', STIFFNESS)
STROKE = ('displacement', 'force')  # the channels that show it: free, and held
_OHMMETER = 0.1
_MATERIAL = 0.3  # spread of the logarithm of what differs from one coil to the next of its kind
_ANYWHERE = 50.0  # K, where a recording begins in the middle of something
_LONGEST, _SOFTER = 2.0, 0.5  # times its length, which a load stretches no muscle to; of the stiffness as assumed
_HOTTER = 20.0  # K: the fibre than its thermometer, at most
_ROUNDS = 4.0  # of the model's loop for motion, about
# Nylon 6,6 melts near 260 degC; well before, the coil's set is lost.
_SURVIVED, _MELTING_SPREAD = ZERO_CELSIUS + 220.0, 5.0  # K


@dataclass(frozen=True)
class TcpMuscle(Model):
    """A twisted and coiled polymer muscle (``muscle/``)."""

    effects: ClassVar[Mapping[str, Effect]] = EFFECTS
    roles: ClassVar[Roles] = Roles.of(EFFECTS)
    listed: ClassVar[Sequence[str]] = LISTED
    specifications: ClassVar[Mapping[str, Parameter]] = SPECIFICATIONS
    channels: ClassVar[Mapping[str, Channel]] = {
        'temperature': Channel(
            'thermal',
            'temperature',
            'K',
            1.0,
            0.1,
            'thermocouple amplifiers: cold junction follows the board by 0.1 to 0.25 K',
            adds='a thermometer on the muscle: it tells thermal from mechanical causes',
            without='no thermometer was recorded: the temperature is inferred from the input; hA, C and the stroke '
            'gain trade against each other, and thermal and mechanical causes are hard to tell apart',
        ),
        'resistance': Channel(
            'electrical',
            'resistance',
            'ohm',
            1.0,
            0.015,
            'voltage over current, each to 0.05 to 0.1 % of 14 ohm',
            adds='the resistance (voltage and current): it follows the temperature of the whole fibre',
        ),
        'displacement': Channel(
            'mechanical',
            'stroke',
            'mm',
            1e3,
            4e-5,
            'laser triangulation over 50 mm: linearity and drift 0.06 to 0.1 % of the range',
            floating=True,
            adds='the contraction: it tells mechanical from thermal causes',
        ),
        'force': Channel('mechanical', 'force', 'mN', 1e3, 2e-3, 'load cells of 10 N: creep 0.02 %', floating=True),
    }
    surroundings: ClassVar[Surroundings] = Surroundings(
        0.1,
        200.0,
        'a calm room: ANSI/ASHRAE 55 allows others to swing by 1.1 K, peak to peak, within 15 min',
    )
    state: ClassVar[str] = 'fibre_temperature'
    state_title: ClassVar[str] = 'temperature'
    state_unit: ClassVar[str] = 'K'
    gauge: ClassVar[str] = 'temperature'
    motion: ClassVar[str] = 'displacement'
    gain: ClassVar[str] = 'B'
    loss: ClassVar[str] = 'hA'
    capacity: ClassVar[str] = 'C'
    slowness: ClassVar[str] = 'C/hA'
    coarse: ClassVar[tuple[str, ...]] = ('hA', 'C')  # the paper's own hA is off eightfold
    separate: ClassVar[tuple[str, ...]] = SEPARABLE
    ratios: ClassVar[tuple[Ratio, ...]] = (
        Ratio('C/hA', 'C', 'hA', 's'),  # the time constant of cooling
        Ratio('B/hA', 'B', 'hA', 'm K/W'),  # stroke a watt
        Ratio('hA/R0', 'hA', 'R0', 'W/(K ohm)'),
    )
    shown_by: ClassVar[Mapping[str, frozenset[str]]] = {
        'thermal': frozenset({'temperature', 'resistance'}),
        'electrical': frozenset({'resistance'}),
    }
    # A time is no law of a material, and a power tells little that a current does not.
    laws: ClassVar[Mapping[str, Dependence]] = {
        'temperature': Dependence('fibre_temperature'),
        'current': Dependence('current'),
        'length': Dependence('length', True, frozenset({'blocked'}), frozenset(STROKE)),
        'force': Dependence('force', True, frozenset({'load'}), frozenset(STROKE)),
    }

    def simulate(
        self,
        recorded: Recorded,
        parameters: Parameters,
        start: float | None,
        resolution: float,
        only: Collection[str] | None,
        ambient: Array | None,
    ) -> Outputs:
        """What a muscle shows that begins at a temperature (K; None: the room's), in a room (K; None: as it was
        read)."""
        imposed, holding = recorded.imposed, recorded.holding
        schedule = imposed.schedule if ambient is None or ambient is imposed.ambient else imposed.schedule.at(ambient)
        try:
            muscle = Muscle(
                parameters,
                end=holding.end,
                load=holding.starting_load,
                held_length=holding.held_length,
                spring_rate=holding.spring_rate,
                spring_rest_length=holding.spring_rest_length,
                ambient=float(schedule.ambient[0]),
                temperature=start,
            )
        except NoMuscle:  # where a fit looks too far
            return Outputs.unknown(schedule.time)
        hottest = _hottest(recorded)
        return follow(muscle, schedule, kind=imposed.kind, resolution=resolution, hottest=hottest, only=only)

    def steps(self, recorded: Recorded, parameters: Parameters, resolution: float) -> float:
        """About how many steps a simulation takes: more where heat is integrated, or a weight moves."""
        time = recorded.imposed.time
        steps = float(time.size)
        if parameters.vector[INDEX['integrated']]:
            quickest = parameters.followed(resolution, _hottest(recorded))[INDEX['fastest_rate']]
            steps += float(time[-1] - time[0]) * quickest / SUBSTEP
        return steps * (_ROUNDS if parameters.vector[INDEX['motion']] else 1.0)

    def strained(self, outputs: Outputs) -> float:
        """How far the fibre was beyond melting, in units of what that is known to."""
        return max(0.0, float(outputs.fibre_temperature.max()) - _SURVIVED) / _MELTING_SPREAD

    def time_constant(self, parameters: Parameters) -> float:
        """That of cooling, s."""
        return float(parameters['C'] / parameters['hA'])

    def exposed(self, parameters: Parameters, outputs: Outputs) -> Array:
        """The torque of its end, m: its contraction by temperature alone, and what the load stretches it by."""
        cold, warm = (length(parameters, at, 0.0) for at in (parameters['T0'], outputs.fibre_temperature))
        return np.asarray(cold - warm + length(parameters, outputs.fibre_temperature, outputs.force) - warm)

    def unknowns(
        self, recordings: Sequence[Recorded], nominal: Parameters, separate: Mapping[str, bool]
    ) -> list[Unknown]:
        """What the recorded channels can say anything about."""
        channels = set().union(*(e.observed for e in recordings))
        names = ['hA', 'C']
        seen_resistance = 'resistance' in channels
        if seen_resistance or any(e.imposed.kind != 'power' for e in recordings):
            names += ['R0']
        mechanical = channels & set(STROKE)
        if mechanical:
            names += ['B', STIFFNESS]
        unknowns: list[Unknown] = []
        for name in names:
            owners: list[int | None] = list(range(len(recordings))) if separate.get(name) else [None]
            # A resistance that was not recorded still heats: it is then known as well as an ohmmeter's reading ages.
            spread = _OHMMETER if name == 'R0' and not seen_resistance else LOG_SPREAD
            # Without a thermometer all temperatures could be twice as large: what is known of materials anchors them.
            spread = _MATERIAL if name == STIFFNESS and 'temperature' not in channels else spread
            least = _softest(recordings, nominal) if name == STIFFNESS else 1e-12
            unknowns += [_positive(nominal, name, owner, spread, least) for owner in owners]
        if 'R0' in names:
            row = SPECIFICATIONS['a_R']
            spread = 0.002 if seen_resistance and 'temperature' in channels else 0.5 * _MATERIAL * nominal['a_R']
            unknowns.append(Unknown('a_R', nominal['a_R'], row.low, row.high, spread))
        if mechanical:
            row = SPECIFICATIONS['c2']
            unknowns.append(Unknown('c2', nominal['c2'], row.low, row.high, 4e-4))
        for k, recorded in enumerate(recordings):
            unknowns += _its_own(recorded, k)
        return unknowns


def _positive(nominal: Parameters, name: str, recording: int | None, spread: float, least: float) -> Unknown:
    """A positive parameter, by its logarithm, no less than its bound and ``least``."""
    row = SPECIFICATIONS[name]
    return Unknown(name, nominal[name], max(row.low, least), row.high, spread, log=True, recording=recording)


def _its_own(recorded: Recorded, k: int) -> Iterable[Unknown]:
    """What recording k has for itself: its room, where that was not recorded, and the temperature at its start."""
    seen = 'temperature' in recorded.observed
    still = float(recorded.imposed.ambient[0])
    if np.ptp(recorded.imposed.ambient) == 0.0:
        yield Unknown(AMBIENT, still, still - 40.0, still + 40.0, 3.0 if seen else 1.0, recording=k)
    begins = _ANYWHERE if recorded.known.get(RESUMED) else 10.0 if seen else 1.0
    yield Unknown(START, still, still - 40.0, still + 150.0, begins, recording=k, state=True)


def _softest(recordings: Iterable[Recorded], nominal: Parameters) -> float:
    """The least stiffness (N/m): with less the load would have drawn the muscle to twice its length, as where it hangs
    one sees that it does not. Under one load a stroke alone hardly tells."""
    pulls = [float(np.median(e.imposed.load)) for e in recordings if e.holding.hangs]
    return min(max(pulls, default=0.0) / ((_LONGEST - 1.0) * nominal['H0']), _SOFTER * nominal['k0'])


def _hottest(recorded: Recorded) -> float | None:
    """K, that the muscle certainly did not exceed: a bead in its surface may show less than the fibre has."""
    seen = recorded.observed.get('temperature')
    return None if seen is None or not seen.value.size else seen.highest + _HOTTER


TCP_MUSCLE = TcpMuscle()

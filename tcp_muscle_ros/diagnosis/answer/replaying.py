"""Replay: drive the model with recorded inputs, free-run, and compare each channel.

A recording brings things of its own, which are no property of a muscle: the temperature of the room, that of the fibre
at the start and what else it has not yet recovered from, the zero of its displacement or force, and when between two
samples its drive switched. ``own_of`` fits these and nothing else.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.calibration import under_what_is_left
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.fitting.switching import settled
from tcp_muscle_ros.diagnosis.fitting.warm_start import begun_warm
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.hypothesis.unknowns import own_unknowns
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT, START, Unknown
from tcp_muscle_ros.diagnosis.noise.noise import Noise, quick_noise
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.holding import Conditions
from tcp_muscle_ros.diagnosis.observation.imposed import Earlier
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.recording.recording import Recording

_BAND = (5.0, 95.0)  # percentiles
_FIRST = 20  # readings
_ROUNDS = 12  # of fitting what a recording brings of its own
SETTLED_BY = 500  # observations a channel that it is fitted to
_quickly = partial(fit, rounds=_ROUNDS, tolerance=1e-5)
FAR, _AT_BOUND = 10.0, 0.99  # K of a room from what was read or stated of it; of as far as it may go
_CHANCE = 20.0  # of the squared error in units of the noise: more is no chance


@dataclass(frozen=True)
class Comparison:
    """One channel: predictions (SI) at the recorded stamps and how far they are from what was recorded.

    ``nrmse`` is ``rmse`` over the recorded peak to peak; ``bias`` the mean of recorded minus predicted. ``low`` and
    ``high`` bound the 90 % band that the parameters' intervals give, where they are known.
    """

    time: Array
    recorded: Array
    predicted: Array
    rmse: float
    nrmse: float
    bias: float
    low: Array | None = None
    high: Array | None = None


def start_temperature(experiment: Experiment, parameters: Parameters) -> float:
    """The fibre's temperature (K) at the start, from the first readings of the thermometer; without one, the ambient.

    Of the ambient, the first reading, and the mean of what was read before the drive came on, the one from which the
    model comes closest to the first readings.
    """
    ambient = float(experiment.imposed.ambient[0])
    observed = experiment.observed.get(experiment.model.gauge)
    if observed is None:
        return ambient
    on = np.flatnonzero(experiment.imposed.drive != 0.0)
    until = float(experiment.imposed.time[on[0]]) if on.size else float(experiment.imposed.time[-1])
    still = observed.value[observed.time <= until][:_FIRST]
    starts = [ambient, float(observed.value[0]), float(np.mean(still)) if still.size else ambient]

    beginning = experiment.until(float(observed.time[:_FIRST][-1]))

    def error(start: float) -> float:
        shown = beginning.predict(parameters, start)[experiment.model.gauge]
        return float(np.sum((shown - observed.value[:_FIRST]) ** 2))

    return min(starts, key=error)


@dataclass(frozen=True)
class Own:
    """What a recording brings of its own: ``ambient`` (K, None: as it was recorded), the fibre's temperature at the
    ``start`` (K), by channel what is shown at the model's ``zeros`` (SI), the ``states`` of the muscle's effects at the
    start, by parameter, and which ``switches`` of the drive came before they were shown. ``fitted``: it was, to what
    was recorded. ``strayed``: how far (K) the room was drawn from what was read or stated of it, where that is more
    than a room is wrong: then the muscle is."""

    ambient: float | None
    start: float
    zeros: Mapping[str, float] = field(default_factory=dict)
    states: Mapping[str, float] = field(default_factory=dict)
    switches: tuple[Earlier, ...] = ()
    fitted: bool = False
    strayed: float = 0.0

    @property
    def warning(self) -> str:
        """What a room says that strayed; empty where it did not."""
        if not self.strayed:
            return ''
        side = 'above' if self.strayed > 0.0 else 'below'
        return (
            f'the room was fitted {abs(self.strayed):.1f} K {side} what was read or stated of it: the parameters are '
            f'probably those of another muscle, and the room makes up for some of that'
        )

    def followed(self, experiment: Experiment) -> Experiment:
        """The recording with its drive switched when it did."""
        imposed = experiment.imposed
        for switch in self.switches:
            imposed = imposed.switched(switch)
        return replace(experiment, imposed=imposed)

    def run(self, experiment: Experiment, muscle: Parameters) -> dict[str, Array]:
        """What the muscle shows in the recording (SI), shapes as observed."""
        experiment = self.followed(experiment)
        shown = experiment.predict(self.begun(muscle), self.start, self.room(experiment))
        return {name: values + self.zeros.get(name, 0.0) for name, values in shown.items()}

    def begun(self, muscle: Parameters) -> Parameters:
        """The muscle in the states in which the recording begins."""
        return muscle.replace(self.states) if self.states else muscle

    def room(self, experiment: Experiment) -> Array | None:
        """The ambient (K) of the recording as it is followed, shape as its inputs; None: as it was recorded."""
        return None if self.ambient is None else np.full(experiment.imposed.time.size, self.ambient)


def as_given(experiment: Experiment, muscle: Parameters) -> Own:
    """Nothing of its own: the room as stated, zeros as recorded, the start as its first readings show."""
    return Own(None, start_temperature(experiment, muscle))


def own_of(experiment: Experiment, muscle: Parameters) -> Own:
    """Fit what a recording brings of its own to a muscle, by penalised least squares.

    Once more under the noise that is left: where the muscle is another one, what it misses must not bend the room.
    Where that gains nothing beyond what chance gives, the recording is taken as given.

    Args:
        experiment: prepared with some hundred observations a channel, which is enough and quick.
        muscle: with the effects of its sensors, where they are known.
    """
    unknowns = own_unknowns(experiment, muscle)
    first = _quickly(Problem((experiment,), muscle, unknowns, quick_noise([experiment])))
    cold = under_what_is_left(first, _quickly)
    fitted = begun_warm(cold, _quickly)
    fitted = _switched(cold if fitted is cold else under_what_is_left(fitted, _quickly))
    noise = fitted.problem.noise
    values, shown = fitted.values, fitted.predictions[0]
    floats = fitted.problem.zeros(shown, 0)  # where noise is as slow as what a wrong muscle misses, not its mean
    zeros = {name: float(np.mean(experiment.observed[name].value - shown[name])) for name in floats}
    states = {u.name: values[u.key] for u in unknowns if u.name in muscle}
    switched = fitted.problem.latents[0].switched
    moves = switched.moves if switched else ()
    room = values.get((AMBIENT, 0))
    own = Own(room, values[START, 0], zeros, states, moves, fitted=True, strayed=_strayed(unknowns, room))
    given = as_given(experiment, muscle)
    gained = _missed(given.run(experiment, muscle), experiment, noise) - _missed(shown, experiment, noise, zeros)
    return own if gained > _CHANCE else given


def _strayed(unknowns: Sequence[Unknown], room: float | None) -> float:
    """How far (K) a room lies from the middle of where it may be, where it is at the end of that or 10 K away."""
    for u in unknowns:
        if u.name == AMBIENT and room is not None:
            middle = 0.5 * (u.low + u.high)
            off, most = room - middle, 0.5 * (u.high - u.low)
            return off if abs(off) > min(FAR, _AT_BOUND * most) else 0.0
    return 0.0


def _switched(fitted: Fit) -> Fit:
    """The same with the drive switched when all channels see it, where that is what the muscle misses."""
    latents = settled(fitted)
    if latents is None:
        return fitted
    return _quickly(fitted.problem.with_latent(latents[0], 0), fitted.z)


def _missed(
    shown: Mapping[str, Array],
    experiment: Experiment,
    noise: Mapping[str, Noise],
    zeros: Mapping[str, float] | None = None,
) -> float:
    """The squared error in units of the noise, over all channels."""
    return sum(
        float(np.sum((o.value - shown[name] - (zeros or {}).get(name, 0.0)) ** 2)) / noise[name].sigma ** 2
        for name, o in experiment.observed.items()
    )


class ReplayedErrors:
    """Root mean square errors (SI) by channel of replays of several recordings together."""

    def __init__(self) -> None:
        self._squares: dict[str, list[float]] = {}

    def add(self, experiment: Experiment, muscle: Parameters, own: Own) -> None:
        """Replay one more recording with the muscle as it was then."""
        experiment = own.followed(experiment)
        muscle, room = own.begun(muscle), own.room(experiment)
        for name, observed in experiment.observed.items():  # one at a time: they may be long
            outputs = experiment.outputs(muscle, own.start, only=(name,), ambient=room)
            error = np.interp(observed.time, outputs.time, getattr(outputs, name))
            del outputs
            error += own.zeros.get(name, 0.0)
            error -= observed.value
            entry = self._squares.setdefault(name, [0.0, 0.0])
            entry[0] += float(error @ error)
            entry[1] += error.size

    def add_as_read(self, recording: Recording, assumed: Parameters, stated: Conditions, muscle: Parameters) -> Own:
        """The same of one as it was read, prepared for what is ``assumed`` of the muscle; what it brings of its own."""
        own = own_of(prepare(recording, assumed, stated, SETTLED_BY), muscle)
        self.add(prepare(recording, assumed, stated), muscle, own)
        return own

    def rmse(self) -> dict[str, float]:
        """Of all that was replayed."""
        return {name: float(np.sqrt(total / count)) for name, (total, count) in self._squares.items()}


def replay(
    experiment: Experiment,
    parameters: Parameters,
    variants: Mapping[int, Parameters] | None = None,
    own: Own | None = None,
) -> dict[str, Comparison]:
    """Compare every recorded output with the model's free run under the recorded inputs.

    ``variants``: other muscles within the parameters' intervals; their spread is the band. ``own``: what the recording
    brings of its own; default nothing (``as_given``).
    """
    own = own or as_given(experiment, parameters)
    predicted = own.run(experiment, parameters)
    spread = [own.run(experiment, muscle) for muscle in (variants or {}).values()]
    found = {}
    for name, observed in experiment.observed.items():
        error = observed.value - predicted[name]
        rmse = float(np.sqrt(np.mean(error**2)))
        span = float(np.ptp(observed.value))
        band = np.percentile([p[name] for p in spread], _BAND, axis=0) if spread else (None, None)
        found[name] = Comparison(
            observed.time,
            observed.value,
            predicted[name],
            rmse,
            rmse / span if span > 0.0 else float('inf'),
            float(np.mean(error)),
            band[0],
            band[1],
        )
    return found

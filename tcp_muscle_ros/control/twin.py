"""A model that runs beside a muscle: does the muscle still do what the model says, and where does it begin to differ.

Pure: times are passed in. One ``tick`` a period with what flowed and what was measured. States:

    FOLLOWS <-> DRIFTS   the residuals' mean is no longer chance, but may be what a calibration leaves
    any -> DIFFERS       the sequential test has alarmed; latched until ``forget`` or until a better model is adopted

A second model may be on trial: where it predicts better for long enough it takes the first one's place, and is taken
back the same way. Adopting changes what is predicted, never what is allowed: ``hottest`` is the hotter of both models.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from tcp_muscle_ros.control.inverse import Inverse
from tcp_muscle_ros.control.predictor import CHANNELS, LEAST, Predictor
from tcp_muscle_ros.control.sequential import Rule, Sequential
from tcp_muscle_ros.muscle.arrays import Array

BAND = 1.6449  # standard deviations: 90 %
LONGEST_STEP = 1.5  # s without a current: what flowed meanwhile nobody knows. The slowest muscle's tick is 1 s
_T, _R, _X, _F = range(len(CHANNELS))
_REMEMBERED = 30.0  # s, over which it is weighed in which stage the difference is
TRIAL = 60.0  # s of heating or cooling, over which two models are compared, where nothing else is said
WATCHED = 600.0  # s, for which a model that was replaced is kept beside the new one
BETTER = 0.8  # of the other's mean squared error: so much less for a model to take its place
_MOVING = 3.0  # K above the ambient: a cold muscle tells two models apart by nothing


class State(Enum):
    """What the twin says of the muscle; the value is what people read."""

    FOLLOWS = 'follows'
    DRIFTS = 'drifts'
    DIFFERS = 'differs'


@dataclass(frozen=True)
class Difference:
    """Where a muscle differs: stage, since when (s), and the stage's share of all that differs."""

    stage: str
    channel: str
    since: float
    sure: float


@dataclass(frozen=True)
class Tick:
    """What a tick found. float64[4] in the order of CHANNELS, SI; NaN where nothing was measured."""

    value: Array
    low: Array
    high: Array
    residual: Array


@dataclass
class _Trial:
    """A model beside the one in use, and how both have done: sums of squared errors, in variances."""

    predictor: Predictor
    former: bool  # it was in use before
    began: float
    heated: float = 0.0  # s
    own: float = 0.0
    other: float = 0.0

    def begin_anew(self) -> None:
        """What it was compared on does not count any more."""
        self.heated = self.own = self.other = 0.0


@dataclass
class Twin:
    """The twin of one muscle. ``period`` is s, from tick to tick, and what times of messages are unsure by; ``trial`` s
    of heating or cooling two models are compared over."""

    predictor: Predictor
    period: float
    rule: Rule = field(default_factory=Rule)
    trial: float = TRIAL

    def __post_init__(self) -> None:
        self.test = Sequential((len(CHANNELS),), self.rule)
        self.state = State.FOLLOWS
        self.difference: Difference | None = None
        self.events: list[str] = []  # what was adopted and taken back, oldest first; whoever tells of it empties it
        self._trials: list[_Trial] = []  # at most one that is new, and the one that was in use before
        self._scores = np.zeros(4)  # thermal, electrical, mechanical, sensor
        self._sum, self._count = np.zeros(len(CHANNELS)), np.zeros(len(CHANNELS))
        self._warmer = 0.0  # K, than predicted, by the thermometer, in the last block
        self._use(self.predictor)

    def _use(self, predictor: Predictor) -> None:
        self.predictor = predictor
        self._inverse: Inverse | None = None

    def start(self, temperature: float) -> None:
        """The muscle is at rest at this temperature (K), as far as anybody knows."""
        for one in self._predictors():
            one.start(temperature)

    def _predictors(self) -> list[Predictor]:
        return [self.predictor, *(trial.predictor for trial in self._trials)]

    @property
    def sources(self) -> list[str]:
        """The files of the models in use and on trial."""
        return [one.source for one in self._predictors()]

    @property
    def hottest(self) -> float:
        """The fibre's temperature by the hotter of the models, K."""
        return max(one.fibre_temperature for one in self._predictors())

    @property
    def on_trial(self) -> bool:
        """Whether a model that has not been in use is compared with the one that is."""
        return not all(trial.former for trial in self._trials)

    def tick(
        self, now: float, dt: float, current: float, load: float, ambient: float | None, measured: Mapping[str, float]
    ) -> Tick:
        """``dt`` (s) passed until ``now`` (s, steady) under this current (A), load (N) and ambient (K; None: that of
        each model).

        ``measured`` at the end of it, by channel, SI.
        """
        shown = np.array([measured.get(name, np.nan) for name in CHANNELS])
        for one in self._predictors():
            one.step(dt, current, load, ambient, self.period)
        main = self.predictor
        residual = shown - main.value
        known = np.isfinite(residual)
        self._sum += np.where(known, residual, 0.0)
        self._count += known
        self._compare(now, dt, shown, main.excess)
        if self.test.add(residual, main.spread, now):
            self._judge(now, load)
        width = BAND * np.hypot(main.spread, self.test.noise)
        return Tick(main.value, main.value - width, main.value + width, residual)

    # Follows, drifts, differs

    def _judge(self, now: float, load: float) -> None:
        """At the end of a block."""
        test, rule = self.test, self.rule
        self._weigh_stages(load)
        if np.any(test.alarm):
            if self.state is not State.DIFFERS:
                self.state = State.DIFFERS
                self.difference = self._located()
        elif self.state is not State.DIFFERS:
            far = float(np.max(np.abs(test.mean_z)))
            if far > rule.drift:
                self.state = State.DRIFTS
            elif far < rule.settled:
                self.state = State.FOLLOWS

    def _weigh_stages(self, load: float) -> None:
        """What of the block's residuals each stage explains: the resistance and the length are those of the
        temperature that was measured, so that heat which is off is no fault of the wire or of the coil.
        """
        count = np.maximum(self._count, 1.0)
        known, mean = self._count > 0, self._sum / np.maximum(self._count, 1.0)
        self._sum, self._count = np.zeros(len(CHANNELS)), np.zeros(len(CHANNELS))
        self._warmer = float(mean[_T]) if known[_T] else 0.0
        scale = np.hypot(self.test.noise / np.sqrt(count), self.predictor.spread)
        model = self.predictor.model
        slopes = np.zeros(len(CHANNELS))
        slopes[_R] = model['R0'] * model['a_R']
        if self._inverse is None:
            self._inverse = Inverse(model, load)
        slopes[_X] = self._inverse.slope(float(self.predictor.value[_T]), load)
        warmer, unsure = (float(mean[_T]), float(scale[_T])) if known[_T] else (0.0, 0.0)
        if not known[_T] and known[_R] and slopes[_R]:
            warmer, unsure = float(mean[_R] / slopes[_R]), float(scale[_R] / slopes[_R])
        rest = (mean - slopes * warmer) / np.hypot(scale, slopes * unsure)
        own = mean / scale
        thermal = warmer / unsure if unsure else 0.0
        electrical = rest[_R] if known[_R] and known[_T] else 0.0
        mechanical = max((abs(float(rest[k])) for k in (_X, _F) if known[k]), default=0.0)
        # A thermometer alone that says something else than wire and coil do: it is the thermometer.
        others = [abs(float(own[k])) for k in (_R, _X) if known[k]]
        sensor = 0.0
        if known[_T] and others and max(others) < self.rule.allowance < abs(own[_T]):
            sensor, thermal, electrical, mechanical = thermal, 0.0, 0.0, 0.0
        share = min(self.rule.block / _REMEMBERED, 1.0)
        scores = np.array([thermal, electrical, mechanical, sensor]) ** 2
        self._scores += share * (scores - self._scores)

    def _located(self) -> Difference:
        """The stage that differs: of those that do, the first in the way that the heat takes."""
        channel = int(np.argmax(np.max(self.test.sums, axis=0)))
        thermal, electrical, mechanical, sensor = self._scores.tolist()
        total = max(thermal + electrical + mechanical + sensor, 1e-30)
        stages = {'sensor': sensor, 'electrical': electrical, 'thermal': thermal, 'mechanical': mechanical}
        stage = max(stages, key=lambda name: stages[name])
        return Difference(stage, CHANNELS[channel], float(self.test.since[channel]), stages[stage] / total)

    def forget(self) -> None:
        """Begin anew with the same model: follows, until shown otherwise."""
        self.test.forget()
        self._scores[:] = 0.0
        self.state, self.difference = State.FOLLOWS, None

    # Which model

    def propose(self, predictor: Predictor, now: float) -> None:
        """Try another model beside the one in use; the former one stays, for it may still be the better of all."""
        # The one in use may be wrong about the heat: then the thermometer's word counts, where there is one.
        predictor.start(self.predictor.fibre_temperature + self._warmer)
        self._trials = [*(trial for trial in self._trials if trial.former), _Trial(predictor, False, now)]

    def _compare(self, now: float, dt: float, shown: Array, above: float) -> None:
        self._trials = [trial for trial in self._trials if not trial.former or now - trial.began <= WATCHED]
        if above < _MOVING or not self._trials:
            return
        other = self._squared(self.predictor, shown)
        for trial in self._trials:
            trial.own += dt * self._squared(trial.predictor, shown)
            trial.other += dt * other
            trial.heated += dt
        over = next((trial for trial in self._trials if trial.heated >= self.trial), None)
        if over is not None:
            self._decide(over, now)

    def _squared(self, predictor: Predictor, shown: Array) -> float:
        """A tick's squared errors of a model, in variances."""
        errors = (shown - predictor.value) / np.hypot(LEAST, self.test.noise)
        return float(np.sum(errors[np.isfinite(errors)] ** 2))

    def _decide(self, trial: _Trial, now: float) -> None:
        if trial.own < BETTER * trial.other:
            before = self.predictor
            self._use(trial.predictor)
            rest = [one for one in self._trials if one is not trial and not one.former]
            for one in rest:
                one.begin_anew()  # it was compared with the model that has just been replaced
            self._trials = [*rest, _Trial(before, True, now)]
            ratio = np.sqrt(trial.own / max(trial.other, 1e-30))
            done = 'taken back: the former model' if trial.former else 'adopted: the new model'
            self.events.append(f'{done} predicts the last {trial.heated:.0f} s with {ratio:.2f} times the error')
            self.forget()
        elif trial.former:
            trial.begin_anew()
        else:
            self._trials.remove(trial)
            self.events.append('not adopted: the new model predicts no better than the one in use')

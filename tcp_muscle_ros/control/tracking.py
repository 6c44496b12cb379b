"""Which current brings the muscle to the setpoint. No ROS, no clock: ``update`` is called once a period.

Mode ``model``: the setpoint becomes a temperature (``inverse``), the observer says where the muscle is and how far
the model is off (``observer``), and the current is the one that takes it there with a short closed-loop time
constant: full current until just before the setpoint, then at once the current that holds it. Mode ``pid``: a plain
PID on position. docs/control.md explains both and shows what they do.

Time: ``update`` at t_k is given what was measured at t_k and the current that flows from t_k on. Its command takes
effect a period later; the model's step over that period is part of the law.
"""

from copy import copy
from dataclasses import dataclass
from math import exp, expm1
from typing import Any

from tcp_muscle_ros.control.inverse import Inverse
from tcp_muscle_ros.control.observer import Observer
from tcp_muscle_ros.control.pid import Pid
from tcp_muscle_ros.control.setpoint import Slope
from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle import ZERO_CELSIUS, Muscle, Parameters

MODES = ('model', 'pid')
_SLOWEST_PERIODS = 3.0  # the closed loop's time constant is at least so many periods
_GUARD_TIME = 0.5  # s, with which the temperature limit is approached
_COLDEST, _HOTTEST = ZERO_CELSIUS - 60.0, ZERO_CELSIUS + 250.0  # K; what a thermometer says beyond is no temperature
_LEARNT_AGO = 0.3  # s, by which the expectation follows what the feedback teaches
_AT_REST = 0.1  # K above ambient, where a setpoint needs no current


@dataclass(frozen=True)
class Settings:
    """What can be chosen. SI, temperatures in K."""

    mode: str = 'model'
    temperature_limit: float = 100.0 + ZERO_CELSIUS  # never heated above it, by the model and by the thermometer
    time_constant: float = 0.07  # s, of the closed loop (mode model)
    probe_current: float = 0.0  # A, flows at least while resistance is the feedback and none comes; 0 = none
    pid_kp: float = 200.0  # A/m
    pid_ki: float = 32.0  # A/(m s)
    pid_kd: float = 20.0  # A s/m
    pid_filter_time: float = 0.05  # s, of the derivative


@dataclass(frozen=True)
class Command:
    """What an update decides.

    current                A, for the next period, within 0 and the current limit
    shaped_setpoint        m, the setpoint as far as the muscle can follow it
    predicted_displacement m, by the model from the current alone: it knows nothing of what is measured
    predicted_temperature  K, however the sensor errs
    expected_displacement  m, what the feedback should show by what was learnt of the muscle a moment ago: a sensor that
    expected_resistance    ohm, froze is left behind by it, a muscle at rest that is not quite the model is not
    highest_current        A, that keeps model and thermometer below the temperature limit
    """

    current: float
    shaped_setpoint: float
    predicted_displacement: float
    predicted_temperature: float
    expected_displacement: float
    expected_resistance: float
    highest_current: float


class TrackingController:
    """Setpoint (m) in, current (A) out.

    Args:
        model: the muscle as the controller believes it to be.
        period: s, between two updates.
        current_limit: A.
        load: N, the starting load (displacement is zero at rest at T0 under it), in force until one is given.
        ambient: K, in force until one is given.
        settings: the fields of Settings.

    Raises:
        BadInput: an unknown mode or setting, a period, limit or time constant that makes no sense.
    """

    def __init__(
        self, model: Parameters, period: float, current_limit: float, load: float, ambient: float, **settings: Any
    ) -> None:
        known = Settings.__dataclass_fields__
        for name in settings:
            if name not in known:
                raise BadInput(f"unknown controller setting '{name}'{nearest(name, known)}")
        self.settings = Settings(**settings)
        if self.settings.mode not in MODES:
            raise BadInput(f"unknown mode '{self.settings.mode}'{nearest(self.settings.mode, MODES)}")
        for name, value in (('period', period), ('time_constant', self.settings.time_constant)):
            if not 0.0 < value < float('inf'):
                raise BadInput(f'controller {name} = {value} s: expected a number above 0')
        if not 0.0 <= current_limit < float('inf'):
            raise BadInput(f'controller current limit = {current_limit} A: expected 0 or more')
        self.current_limit = current_limit
        self._period = period
        self._load, self._ambient = load, ambient
        self._inverse = Inverse(model, load)
        self._observer = Observer(model, period)
        self._nominal = Observer(model, period)  # never corrected: the model as it stands
        self._expected = Observer(model, period)  # follows the observer slowly
        self._follow = -expm1(-period / _LEARNT_AGO)
        self._muscle = Muscle(model, load=load, ambient=ambient)
        self._stepped = self._seeded = False
        self._carried: float | None = None  # K
        self._R0, self._a_R, self._T0 = model['R0'], model['a_R'], model['T0']
        self._slope = Slope(period)
        self._pid = Pid(
            self.settings.pid_kp, self.settings.pid_ki, self.settings.pid_kd, period, self.settings.pid_filter_time
        )
        self._keep = exp(-period / max(self.settings.time_constant, _SLOWEST_PERIODS * period))
        self._guard = exp(-period / max(_GUARD_TIME, _SLOWEST_PERIODS * period))
        self._flowing = 0.0

    def reset(self) -> None:
        """Forget what the feedback has taught; the next update starts from where the muscle then is.

        The prediction goes on: what has flowed has heated the muscle all the same.
        """
        self._observer.started = False
        self._pid.reset()
        self._slope.reset()

    def carry(self, fibre: float) -> None:
        """Begin at least so warm (K), by another controller's prediction: what has flowed has heated the muscle,
        whatever the first measurement says."""
        self._carried = fibre

    def take_over(self, other: 'TrackingController') -> None:
        """Go on with what of another controller has nothing to do with its model."""
        self._pid, self._slope = copy(other._pid), copy(other._slope)

    def update(
        self,
        setpoint: float,
        *,
        displacement: float | None = None,
        resistance: float | None = None,
        temperature: float | None = None,
        load: float | None = None,
        ambient: float | None = None,
        applied_current: float | None = None,
    ) -> Command:
        """One period. Every value is finite or None (not measured now).

        Args:
            setpoint: m.
            displacement: m, measured. It is the feedback wherever it is given.
            resistance: ohm, measured. It is the feedback where no displacement is given.
            temperature: K, measured; for the temperature limit only.
            load: N; None: as before.
            ambient: K; None: as before.
            applied_current: A, flowing from now until the command takes effect; None: the last command.
        """
        if load is not None:
            self._load = load
        if ambient is not None:
            self._ambient = ambient
        flowed, self._flowing = self._flowing, self._flowing if applied_current is None else applied_current
        measured = self._coordinate(displacement, resistance)
        self._predict(flowed, measured, temperature)
        observer = self._observer
        began = observer.started
        if began:
            observer.predict(flowed, self._ambient)
        if measured is not None:
            observer.correct(measured)
        elif not observer.started:
            observer.start(self._fibre)
        self._expect(flowed, anew=not began)

        wanted = self._inverse.temperature(setpoint, self._load)
        target = min(max(wanted, self._ambient), self._highest())
        if self.settings.mode == 'pid':
            x = displacement if displacement is not None else self._seen()
            current = self._pid.update(setpoint, x, self.current_limit)
        else:
            current = self._track(setpoint, target, shaped=target != wanted)
        current = min(current, self.current_limit, highest := self._safe_current(temperature))
        if displacement is None and resistance is None:
            current = max(current, min(self.settings.probe_current, self.current_limit))
        self._flowing = current if applied_current is None else self._flowing
        expected = self._expected.temperature
        return Command(
            current=current,
            shaped_setpoint=setpoint if target == wanted else self._inverse.displacement(target, self._load),
            predicted_displacement=self._predicted,
            predicted_temperature=self._fibre,
            expected_displacement=self._inverse.displacement(expected, self._load),
            expected_resistance=self._expected.resistance(expected),
            highest_current=highest,
        )

    def _coordinate(self, displacement: float | None, resistance: float | None) -> float | None:
        if displacement is not None:
            return self._inverse.temperature(displacement, self._load)
        if resistance is not None and self._a_R != 0.0:
            found = self._T0 + (resistance / self._R0 - 1.0) / self._a_R
            return min(max(found, _COLDEST), _HOTTEST)
        return None

    def _seen(self) -> float:
        return self._inverse.displacement(self._observer.temperature, self._load)

    def _predict(self, flowed: float, measured: float | None, temperature: float | None) -> None:
        """The model from the current alone. It starts from what the first measurement says."""
        begins = None if self._seeded else self._begins(temperature if temperature is not None else measured)
        if begins is not None:
            self._muscle.reset(min(max(begins, _COLDEST), _HOTTEST))
            self._seeded = True
        if begins is not None or not self._stepped:
            reading = self._muscle.reading(0.0, load=self._load, ambient=self._ambient)
        else:
            reading = self._muscle.step(self._period, flowed, load=self._load, ambient=self._ambient)
        self._stepped = True
        self._predicted, self._fibre = reading.displacement, reading.fibre_temperature

    def _begins(self, first: float | None) -> float | None:
        """What it starts from, K: the first measurement, or what was carried over where that is hotter; None without
        either."""
        if self._carried is None or self._stepped:
            return first
        return self._carried if first is None else max(first, self._carried)

    def _expect(self, flowed: float, anew: bool) -> None:
        """What the feedback should say. It goes its own way with the current, and what was learnt reaches it late."""
        expected, observer = self._expected, self._observer
        follow = 1.0 if anew else self._follow
        ahead = expected.after(expected.temperature, flowed, self._ambient)
        expected.temperature = ahead + follow * (observer.temperature - ahead)
        expected.gain += follow * (observer.gain - expected.gain)
        expected.power += follow * (observer.power - expected.power)

    def _highest(self) -> float:
        settles = self._observer.steady_temperature(self.current_limit, self._ambient)
        return min(self.settings.temperature_limit, settles, self._inverse.hottest(self._load))

    def _track(self, setpoint: float, target: float, shaped: bool) -> float:
        observer = self._observer
        begin = observer.after(observer.temperature, self._flowing, self._ambient)
        slope = self._slope.update(setpoint)
        if target <= self._ambient + _AT_REST and begin > target - 4.0 * observer.noise.deviation:
            return 0.0
        drift = 0.0 if shaped else slope / self._inverse.slope(target, self._load) * self._period
        end = target + 2.0 * drift + (begin - target - drift) * self._keep
        return observer.current_between(begin, end, self._ambient)

    def _safe_current(self, temperature: float | None) -> float:
        """The highest current that keeps model and thermometer below the temperature limit."""
        limit = self.settings.temperature_limit
        hottest = max(self._fibre, temperature if temperature is not None else self._fibre)
        end = limit - (limit - hottest) * self._guard
        return self._nominal.current_between(hottest, end, self._ambient)

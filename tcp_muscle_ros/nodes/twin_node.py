"""A twin of the muscle: the model under the currents that really flow, and whether the muscle still does what it says.

It commands nothing and needs nobody's leave: started and stopped beside a working muscle, it changes nothing there.
"""

from __future__ import annotations

if __name__ == '__main__':  # python -m: before the rest is loaded, see process/quiet_end.py
    from tcp_muscle_ros.process.quiet_end import end_quietly_when_asked

    end_quietly_when_asked()

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.parameter import Parameter as RosParameter
from rclpy.publisher import Publisher
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger

from tcp_muscle_ros.control.estimate import Estimate
from tcp_muscle_ros.control.memory import Memory
from tcp_muscle_ros.control.predictor import CHANNELS, Predictor
from tcp_muscle_ros.control.twin import LONGEST_STEP, Difference, State, Tick, Twin
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import TABLE, ZERO_CELSIUS, Parameters
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.nodes.declaring import DeclaredNode
from tcp_muscle_ros.nodes.lifetime import run
from tcp_muscle_ros.nodes.lockstep import FollowingTime, out_of_step, timeless
from tcp_muscle_ros.nodes.parameters import Settings, descriptor, of_rclpy, read_rows
from tcp_muscle_ros.nodes.safe_muscle import number
from tcp_muscle_ros.nodes.serialized import NumberPublisher
from tcp_muscle_ros.nodes.ticks import SECOND, SteadyTime, TickLoop
from tcp_muscle_ros.nodes.topics import MEASUREMENT_QOS, STATE_QOS, Topics
from tcp_muscle_ros.nodes.twin_alarm import Alarm
from tcp_muscle_ros.nodes.twin_controller import Believing
from tcp_muscle_ros.nodes.twin_hearing import HEARD, Heard, Hearing
from tcp_muscle_ros.recording.recording import OUTPUTS
from tcp_muscle_ros.settings import intervals
from tcp_muscle_ros.settings.operating import DEFAULT_SET, OPERATING, TWIN, TWIN_NODE
from tcp_muscle_ros.settings.parameter_file import ParameterFile, read
from tcp_muscle_ros.settings.rig import Rig, on_rig, read_rig

PREDICTED = CHANNELS[:3]
_SETTLES = 1.0  # s, in which the state is estimated before the model starts from it
_VARIANTS = 8  # muscles drawn from the intervals: as many as a band needs, few enough for every tick
_HEARS_WITHIN = 10.0  # s, in which a topic that is published is heard; one that is not is subscribed to anew
_DIAGNOSES = 4  # of one alarm: what differs and cannot be told by then needs another experiment, not more of the same
_MOST_AT_ONCE = 50  # ticks that are made up for: more means that the machine stood still


class TwinNode(DeclaredNode):
    """Hears the muscle's topics in ticks of its own, and publishes prediction, band and residual of each."""

    def __init__(self) -> None:
        super().__init__(TWIN_NODE)
        given = {n: p.value for n, p in self._parameter_overrides.items() if n in TWIN or not _elsewhere(n)}
        self._settings: Settings = read_rows(given, TWIN, TWIN_NODE)
        for name, value in self._settings.items():
            self.declare_parameter(name, value, descriptor(TWIN[name]), ignore_override=True)
        self.add_post_set_parameters_callback(self._was_set)
        self._lock = threading.Lock()  # between the ticks and the executor's callbacks
        self._rate = float(self._settings['rate_hz'])
        self._longest_step = max(LONGEST_STEP, self._settings.longest_step)
        self._file = read(self._settings['params_file'] or DEFAULT_SET)
        self._rig = read_rig(self._settings['rig_file']) if self._settings['rig_file'] else None
        self._load = self._file.number('load_n')
        self._ambient: float | None = None  # K, measured; none: each model has that in which it was found
        model = on_rig(self._file.parameters, self._rig)
        self._twin = Twin(
            self._predictor(self._file, model, self._variants(self._settings['params_file'], self._file, self._rig)),
            1.0 / self._rate,
            trial=float(self._settings['trial_s']),
        )
        # By the path of a model that the twin may have in use: what a diagnosis found, and its rig's file.
        self._found: dict[str, tuple[ParameterFile, str]] = {}
        self._controller = Believing(self, self._settings['adopting_controller'], self._tell)
        self._estimate = Estimate(model, 1.0 / self._rate, self._load)
        self._memory = Memory(HEARD, round(self._settings['keep_s'] * self._rate), set(HEARD) - set(OUTPUTS))
        self._current: float | None = None
        self._then = self._heard_since = self._current_since = 0.0
        self._follows_since: float | None = None  # none: the state is still being estimated
        self._alarms = 0
        self._alarm: Alarm | None = None
        self._difference: Difference | None = None  # that the alarm is about
        self._diagnose_at: float | None = None
        self._diagnoses = 0  # that were begun or are to begin, of this difference
        self.loop: TickLoop | None = None
        simulated = self.get_parameter('use_sim_time').value
        self._base = FollowingTime(self, self._collect) if simulated else SteadyTime(self.get_clock())
        self._collected: list[Heard] = []  # ticks of a simulation in lockstep
        self._timeless = ''  # why there is no time to follow a muscle in
        self._out_of_step: dict[str, str] = {}
        self._unmatched: dict[str, str] = {}
        self._silent: dict[str, float] = {}  # by topic that is published, for how long (s) it was not heard
        self._topics = Topics(self)
        self._publish_on(self._topics)
        if self._settings['adopting_controller']:
            self._topics.subscription(DiagnosticArray, '/diagnostics', self._controller.hear, MEASUREMENT_QOS)
        self.create_service(Trigger, '~/reset', self._reset)
        # On the steady clock: it must also speak while /clock is silent.
        self.create_timer(1.0, self._look_after, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _publish_on(self, topics: Topics) -> None:
        clock = None if isinstance(self._base, SteadyTime) else self._seconds
        self._hearing = Hearing(self, topics, 1.0 / self._rate, clock)
        self._outputs: list[tuple[NumberPublisher, ...]] = [
            tuple(
                NumberPublisher(topics.publisher(Float64, f'~/{topic}', STATE_QOS))
                for topic in (f'predicted_{n}', f'predicted_{n}_low', f'predicted_{n}_high', f'residual_{n}')
            )
            for n in PREDICTED
        ]
        self._finding = topics.publisher(String, '~/finding', STATE_QOS)
        self._diagnostics = topics.publisher(DiagnosticArray, '/diagnostics', STATE_QOS)

    # Models

    def _variants(self, path: str, found: ParameterFile, rig: Rig | None) -> list[Parameters]:
        """What the muscle of a file might be as well; none where nothing is beside the file, or it is no file."""
        drawn = intervals.variants(path, found.parameters) if path and Path(path).is_file() else None
        return [on_rig(one, rig) for one in (drawn or {}).values()][:_VARIANTS]

    def _predictor(
        self, found: ParameterFile, model: Parameters, variants: Sequence[Parameters] = (), source: str = ''
    ) -> Predictor:
        file: ParameterFile = self._file
        return Predictor(
            model,
            variants,
            load=file.number('load_n'),
            ambient=found.number('ambient_temperature_c') + ZERO_CELSIUS,
            end=file.text('end'),
            held_length=file.number('held_length_m'),
            spring_rate=file.number('spring_rate_n_per_m'),
            spring_rest_length=file.number('spring_rest_length_m'),
            source=source,
        )

    # Life (see lifetime.py)

    def start(self, on_failure: Callable[[], None]) -> None:
        """Begin to tick."""
        if isinstance(self._base, FollowingTime):
            self._base.open(self._topics)
        self.loop = TickLoop(self._base, self._rate, self._tick, longest_step=self._longest_step, on_failure=on_failure)
        self.loop.start()

    def stop(self) -> Sequence[Publisher]:
        """Stop ticking, and end a diagnosis that still runs."""
        if self.loop is not None:
            self.loop.stop()
        if self._alarm is not None:
            self._alarm.end()
        return []

    @property
    def failure(self) -> BaseException | None:
        """What ended the ticks, if anything did."""
        return None if self.loop is None else self.loop.failure

    def _was_set(self, parameters: Sequence[RosParameter]) -> None:
        mine = {parameter.name: parameter.value for parameter in parameters if parameter.name in TWIN}
        self._settings = self._settings.changed(mine)
        self._twin.trial = float(self._settings['trial_s'])

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        with self._lock:
            self._twin.forget()
            self._lose(self._then)
            self._current = None
        response.success, response.message = True, 'reset: the model starts from what is measured'
        return response

    # One tick

    def _tick(self, stamp: int, dt: float, publish: bool) -> None:
        with self._lock:
            ticks = self._collected if self._base.collects else self._hearing.ticks()
            self._collected = []
            for k, heard in enumerate(ticks):
                if k < _MOST_AT_ONCE and not self._out_of_step:
                    self._take(heard)
            self._notice()

    def _collect(self, sent: int) -> None:
        """What a simulation in lockstep published with its tick."""
        with self._lock:
            self._collected.append(self._hearing.tick(self._seconds(), sent))

    def _take(self, heard: Heard) -> None:
        values = heard.values
        dt = heard.time - self._then
        if -1.0 / self._rate < dt <= 0.0:  # under way for longer than anybody waited for it: its tick is over
            return
        if dt < 0.0:
            self._tell('the clock was set back: the twin begins anew')
            self._memory.forget()
            self._twin.forget()  # its times are those of the clock before, and so are an alarm's
        self._then = heard.time
        self._load = values.get('load', self._load)
        self._ambient = values.get('ambient', self._ambient)
        self._memory.add(heard.time, [values.get(name, np.nan) for name in HEARD])
        flowed, self._current = self._current, values.get('current', self._current)
        if 'current' in values or dt < 0.0:
            self._current_since = heard.time
        elif heard.time - self._current_since > self._longest_step:  # what flows nobody says any more
            self._current = None
        measured = {name: values[name] for name in CHANNELS if name in values}
        if flowed is None or not 0.0 < dt <= self._longest_step:
            self._lose(heard.time)
            return
        if self._follows_since is None:
            known = {name: value for name, value in measured.items() if name != 'force'}
            ambient = self._twin.predictor.ambient if self._ambient is None else self._ambient
            self._estimate.update(flowed, self._load, ambient, **known)
            temperature = self._estimate.temperature
            if temperature is None or heard.time - self._heard_since < _SETTLES:
                return
            self._twin.start(temperature)
            self._follows_since = heard.time
        self._show(self._twin.tick(heard.time, dt, flowed, self._load, self._ambient, measured))

    def _lose(self, now: float) -> None:
        """What flowed nobody knows: the state is to be estimated anew."""
        self._estimate.begin_anew()
        self._heard_since, self._follows_since = now, None

    def _show(self, tick: Tick) -> None:
        for k, (value, low, high, residual) in enumerate(self._outputs):
            zero = ZERO_CELSIUS if PREDICTED[k] == 'temperature' else 0.0
            value.send(float(tick.value[k]) - zero)
            low.send(float(tick.low[k]) - zero)
            high.send(float(tick.high[k]) - zero)
            if np.isfinite(tick.residual[k]):
                residual.send(float(tick.residual[k]))

    def _notice(self) -> None:
        """What is to be done about a change of state."""
        twin = self._twin
        while twin.events:
            self._tell(twin.events.pop(0))
        if twin.predictor.model is not self._estimate.model:  # a worn wire's resistance is another temperature's
            self._estimate = Estimate(twin.predictor.model, 1.0 / self._rate, self._file.number('load_n'))
        idle = self._alarm is None or not (self._alarm.busy or twin.on_trial)
        if idle and twin.difference is not self._difference:
            self._difference, self._alarm, self._diagnose_at, self._diagnoses = twin.difference, None, None, 0
        if twin.difference is not None and self._alarm is None:
            self._alarms += 1
            self.get_logger().warning(f'the muscle differs: {self._where(twin.difference)}')
            self._alarm = self._new_alarm()
            self._alarm.write('last_minutes', self._memory.columns(), 0.0, self._file.number('load_n'))

    def _new_alarm(self) -> Alarm:
        """To be diagnosed against the model in use: what an adopted one has already is not found again."""
        if self._settings['auto_diagnose']:
            self._diagnose_at = self._then + self._settings['collect_s']
            self._diagnoses += 1
        used, rig = self._found.get(self._twin.predictor.source, (self._file, self._settings['rig_file']))
        folder = Path(self._settings['report_folder'])
        return Alarm(folder, used.parameters, used.operating, self._tell, rig)

    def _diagnose_anew(self) -> None:
        """Where the difference stays though it was diagnosed: more of it may tell more."""
        alarm, settings = self._alarm, self._settings
        if alarm is None or alarm.busy or self._twin.on_trial or self._diagnose_at is not None:
            return
        answered = alarm.answered and not settings['auto_adopt']  # a person has the report
        if answered or not settings['auto_diagnose'] or not 0 < self._diagnoses < _DIAGNOSES:
            return
        if self._twin.difference is not self._difference:  # the next tick sees to it
            return
        self._alarm = self._new_alarm()
        self._tell(
            f'the muscle still differs: diagnosis {self._diagnoses} of at most {_DIAGNOSES} follows after a further '
            f'{settings["collect_s"]:g} s'
        )

    # Once a second

    def _look_after(self) -> None:
        with self._lock:
            alarm, difference, columns = self._alarm, self._difference, None
            if self._diagnose_at is not None and self._then >= self._diagnose_at:
                self._diagnose_at, columns = None, self._memory.columns()
        if alarm is not None and difference is not None:
            self._attend(alarm, difference, columns)
        self._controller.believe(self._twin.predictor.source)
        before, self._timeless = self._timeless, timeless(self._base)
        if self._timeless != before and self._timeless:
            self.get_logger().warning(self._timeless)
        self._out_of_step = out_of_step(self, self._base, self._hearing.topics)
        self._unmatched = self._topics.mismatches_since(self._unmatched, self.get_logger().warning)
        self._hear_anew()
        self._publish_diagnostics()

    def _attend(self, alarm: Alarm, difference: Difference, columns: Mapping[str, tuple[Array, Array]] | None) -> None:
        """Diagnose what is in ``columns`` (none: it is not time), and see to what came of a diagnosis."""
        if columns is not None:
            # In the block in which it began the muscle was still the one before for a part.
            alarm.diagnose(columns, difference.since + self._twin.rule.block, self._file.number('load_n'))
        headline = alarm.poll()
        if headline is not None:
            self._tell(headline)
            self._finding.publish(String(data=headline))
            self._propose(alarm)
        with self._lock:
            self._diagnose_anew()

    def _hear_anew(self) -> None:
        """Subscribe once more where a muscle publishes and is not heard: rarely, after a kill, that was so for minutes.

        In lockstep a subscription that is new would miss the tick; and a simulation may stand still for long.
        """
        silent = self._hearing.silent() if self._waits and not self._timeless else {}
        self._silent = {topic: age for topic, age in silent.items() if topic not in self._unmatched}
        if isinstance(self._base, SteadyTime) and max(self._silent.values(), default=0.0) > _HEARS_WITHIN:
            self._tell(f'{self._unheard}; subscribed anew')
            with self._lock:
                self._hearing.end()
                self._hearing = Hearing(self, self._topics, 1.0 / self._rate)

    @property
    def _waits(self) -> bool:
        """Whether no muscle is followed."""
        late = self._seconds() - self._then > self._longest_step
        return self._follows_since is None or late or bool(self._out_of_step or self._timeless)

    def _seconds(self) -> float:
        """The time that ticks are heard in, s."""
        return time.time() if isinstance(self._base, SteadyTime) else self._base.now() / SECOND

    @property
    def _unheard(self) -> str:
        """What to say of topics that are published and not heard; '' where there are none."""
        told = (
            f'nothing has come on {topic} for {age:.0f} s, which is published' for topic, age in self._silent.items()
        )
        return ', '.join(told)

    def _propose(self, alarm: Alarm) -> None:
        found = alarm.improved() if self._settings['auto_adopt'] else None
        if found is None:
            return
        self._tell('the diagnosed model runs beside the present one, and replaces it where it predicts better')
        # The muscle as it was found shows what was recorded on the rig as it was found.
        rig, of_rig = alarm.rig(), str(alarm.rig_file)
        if rig is None:
            rig, of_rig = self._rig, self._settings['rig_file']
        model, source = on_rig(found.parameters, rig), str(alarm.model.resolve())
        try:
            variants = self._variants(source, found, rig)
        except BadInput as error:
            self._tell(f'the diagnosed model is taken to be exact: {error}')
            variants = []
        predictor = self._predictor(found, model, variants, source)
        with self._lock:
            self._twin.propose(predictor, self._then)
            self._found[source] = found, of_rig
            self._found = {known: file for known, file in self._found.items() if known in self._twin.sources}

    def _tell(self, sentence: str) -> None:
        self.get_logger().info(sentence)

    def _where(self, difference: Difference) -> str:
        where = (
            f'{difference.stage}, by its {difference.channel}, since {self._then - difference.since:.0f} s, '
            f'{100.0 * difference.sure:.0f} % of all that differs'
        )
        if self._ambient is not None:
            return where
        assumed = self._twin.predictor.ambient - ZERO_CELSIUS
        return f'{where}; or the room is not at {assumed:.1f} degC: no ambient_temperature is heard'

    def _publish_diagnostics(self) -> None:
        twin, difference = self._twin, self._twin.difference
        silent = self._waits
        worries = [*self._unmatched.values(), *filter(None, (self._base.held_up(),))]
        reasons = self._timeless, *[*self._out_of_step.values()][:1], *worries, self._unheard
        reason = '; '.join(filter(None, reasons))
        message = 'waits for a muscle' + (f': {reason}' if reason else '') if silent else twin.state.value
        if difference is not None and not silent:
            message += f': {self._where(difference)}'
        if worries and not silent:
            message += '; ' + '; '.join(worries)
        well = twin.state is State.FOLLOWS and not silent and not worries
        status = DiagnosticStatus(
            level=DiagnosticStatus.OK if well else DiagnosticStatus.WARN,
            name=self.get_fully_qualified_name(),
            message=message,
            values=[
                KeyValue(key=key, value=value)
                for key, value in {
                    'state': 'waits' if silent else twin.state.value,
                    'stage': difference.stage if difference else 'none',
                    'channel': difference.channel if difference else 'none',
                    'differs_for_s': number(self._then - difference.since if difference else None),
                    'sure': number(difference.sure if difference else None),
                    'alarms': str(self._alarms),
                    'hottest_c': number(twin.hottest - ZERO_CELSIUS),
                    'effects': ', '.join(twin.predictor.model.effects) or 'none',
                    'model_file': twin.predictor.source or 'none',
                    'on_trial': str(twin.on_trial).lower(),
                }.items()
            ],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(array)


def _elsewhere(name: str) -> bool:
    """Whether a parameter is the muscle's or another node's: one file serves all."""
    return (
        of_rclpy(name) or name in OPERATING or name == 'effects' or name in {row.name for row in TABLE} or '.' in name
    )


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run(TwinNode, TWIN_NODE, args)


if __name__ == '__main__':
    raise SystemExit(main())

"""The state machine that decides when current may flow: each hazard by name, then any sequence of events at all."""

from math import inf, isfinite, nan, sqrt

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from tcp_muscle_ros.control.safety import (
    ABSURD,
    Kind,
    Limits,
    Safety,
    State,
)
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS

COOL = 23.0 + ZERO_CELSIUS
PERIOD = 0.01


def limits(**changed):
    usual = {
        'current': 0.27,
        'slew': 0.0,
        'command_timeout': 0.5,
        'derate_temperature': 100.0 + ZERO_CELSIUS,
        'max_temperature': 115.0 + ZERO_CELSIUS,
        'longest_step': 1.0,
    }
    return Limits(**{**usual, **changed})


class Bench:
    """A machine with a clock: ``tick`` advances it and decides."""

    def __init__(self, **changed):
        self.safety = Safety(limits(**changed))
        self.now = 0.0

    def tick(self, seconds=PERIOD, *, temperature=COOL, **arguments):
        self.now += seconds
        return self.safety.update(self.now, PERIOD, temperatures=(temperature,), **arguments)

    def command(self, value, kind=Kind.CURRENT):
        return self.safety.command(value, self.now, kind)


def test_a_command_within_the_limits_is_applied_as_it_is():
    bench = Bench()
    assert bench.command(0.2) == ''
    assert bench.tick() == 0.2
    assert bench.safety.state is State.ENABLED


def test_without_a_command_there_is_no_current_and_no_alarm():
    bench = Bench()
    assert bench.tick(10.0) == 0.0
    assert bench.safety.state is State.ENABLED
    assert bench.safety.report().timeouts == 0


def test_too_much_is_clamped_and_said():
    bench = Bench(current=0.27)
    bench.command(2.0)
    assert bench.tick() == 0.27
    assert bench.safety.report().limited_by == ('current limit',)


def test_milliampere_for_ampere_are_refused():
    bench = Bench(current=0.27)
    why = 'current command of 250 A: more than ten times the limit of 0.27 A; mA?'
    assert bench.command(250.0) == why and bench.safety.report().last_rejected == why
    assert bench.tick() == 0.0
    assert bench.command(250.0, Kind.POWER) == '', 'the limit is no measure of other kinds'


@pytest.mark.parametrize('value', [nan, inf, -inf, -1e-9, 1e308, ABSURD * 1.001])
@pytest.mark.parametrize('kind', Kind)
def test_a_useless_command_is_rejected_and_counted_and_the_last_good_one_ages_on(value, kind):
    bench = Bench(command_timeout=0.5)
    bench.command(0.2)
    for _ in range(5):
        bench.tick(0.09)
        assert 'expected 0 to' in bench.command(value, kind)
        assert bench.safety.current == 0.2
    assert bench.tick(0.09) == 0.0
    assert bench.safety.state is State.TIMED_OUT
    assert bench.safety.report().rejected == 5
    assert bench.safety.report().command_age == pytest.approx(0.54)


def test_a_silent_commander_gives_zero_until_the_next_command():
    bench = Bench(command_timeout=0.5)
    bench.command(0.2)
    assert bench.tick(0.5) == 0.2
    assert bench.tick(0.01) == 0.0
    assert bench.safety.state is State.TIMED_OUT
    assert bench.tick(10.0) == 0.0
    assert bench.safety.report().timeouts == 1
    bench.command(0.1)
    assert bench.tick() == 0.1


def test_a_command_that_timed_out_does_not_come_back_when_the_timeout_is_lengthened():
    bench = Bench(command_timeout=0.5)
    bench.command(0.2)
    bench.tick(0.6)
    bench.safety.limits = limits(command_timeout=0.0)
    assert bench.tick() == 0.0


def test_a_timeout_of_zero_is_no_watchdog():
    bench = Bench(command_timeout=0.0)
    bench.command(0.2)
    assert bench.tick(1e6) == 0.2


def test_a_clock_set_back_cannot_keep_an_old_command_alive():
    bench = Bench(command_timeout=0.5)
    bench.now = 1e6
    bench.command(0.2)
    bench.now = 0.0
    assert bench.tick(0.4) == 0.2
    assert bench.tick(0.2) == 0.2  # 0.2 s since the first tick on the new clock
    assert bench.tick(0.4) == 0.0


@pytest.mark.parametrize('dt', [0.0, -1.0, nan, inf, 1.1])
def test_a_useless_step_is_counted_and_raises_nothing(dt):
    bench = Bench()
    bench.command(0.1)
    bench.tick()
    bench.command(0.2)
    assert bench.safety.update(bench.now, dt, temperatures=(COOL,)) == 0.1
    bench.command(0.05)
    assert bench.safety.update(bench.now, dt, temperatures=(COOL,)) == 0.05
    assert bench.safety.report().skipped == 2


def test_the_slew_limit_holds_up_and_down_and_from_the_first_command():
    bench = Bench(slew=1.0)
    bench.command(0.025)
    assert [bench.tick() for _ in range(4)] == pytest.approx([0.01, 0.02, 0.025, 0.025])
    bench.command(0.0)
    assert bench.tick() == pytest.approx(0.015)


def test_a_stop_cuts_at_once_and_the_restart_begins_at_zero():
    bench = Bench(slew=1.0)
    bench.command(0.2)
    for _ in range(30):
        bench.tick()
    bench.safety.disable()
    assert bench.safety.current == 0.0
    assert bench.tick() == 0.0
    bench.safety.enable()
    bench.command(0.2)
    assert bench.tick() == pytest.approx(0.01)


def test_a_command_from_before_the_enabling_is_forgotten():
    bench = Bench(command_timeout=0.0)
    bench.command(0.2)
    bench.safety.disable()
    assert bench.command(0.2) == 'disabled'
    bench.safety.enable()
    assert bench.tick() == 0.0


def test_heat_derates_linearly_and_latches_at_the_maximum():
    bench = Bench(current=0.2, derate_temperature=100 + ZERO_CELSIUS, max_temperature=110 + ZERO_CELSIUS)
    bench.command(0.2)
    assert bench.tick(temperature=100 + ZERO_CELSIUS) == 0.2
    assert bench.tick(temperature=105 + ZERO_CELSIUS) == pytest.approx(0.1)
    assert bench.safety.state is State.DERATING
    assert bench.safety.report().limit == pytest.approx(0.1)
    assert bench.safety.report().limited_by == ('derating',)
    assert bench.tick(temperature=90 + ZERO_CELSIUS) == 0.2
    assert bench.safety.state is State.ENABLED
    assert bench.tick(temperature=110 + ZERO_CELSIUS) == 0.0
    assert bench.tick(temperature=COOL) == 0.0
    assert bench.safety.state is State.FAULT
    assert bench.safety.report().why == 'over-temperature: 110.0 degC, maximum 110.0 degC'


def test_the_hotter_of_measured_and_modelled_counts():
    for temperatures in ((COOL, 400.0), (400.0, COOL), (None, 400.0)):
        safety = Safety(limits())
        safety.update(0.0, PERIOD, temperatures=temperatures)
        assert safety.state is State.FAULT


@pytest.mark.parametrize('broken', [{'temperatures': (COOL, nan)}, {'resistance': nan}, {'resistance': 0.0}])
def test_a_state_that_is_no_number_latches(broken):
    bench = Bench()
    bench.command(0.2)
    bench.tick()
    assert bench.safety.update(bench.now, PERIOD, **broken) == 0.0
    assert bench.tick() == 0.0
    assert bench.safety.state is State.FAULT


def test_a_fault_is_cleared_only_when_its_cause_is_gone_and_the_command_is_zero():
    bench = Bench()
    bench.command(0.2)
    bench.tick(temperature=400.0)
    assert 'the cause is still there: over-temperature' in bench.safety.clear_fault()
    bench.tick()
    assert bench.safety.clear_fault() == 'the command is 0.2 A: command 0 first'
    bench.command(0.0)
    assert bench.safety.clear_fault() == ''
    assert bench.safety.state is State.ENABLED and bench.safety.current == 0.0, 'before the next update'
    bench.command(0.1)
    assert bench.tick() == 0.1


def test_a_fault_with_the_commander_gone_can_be_cleared():
    bench = Bench()
    bench.command(0.2)
    bench.tick(temperature=400.0)
    bench.tick(1.0)
    assert bench.safety.clear_fault() == ''
    assert bench.tick() == 0.0


def test_disable_wins_over_everything_and_a_fault_over_enable():
    bench = Bench()
    bench.command(0.2)
    bench.safety.trip('found by hand')
    assert bench.safety.enable() == 'fault latched (found by hand): clear it first'
    bench.safety.disable()
    assert bench.safety.clear_fault() == ''
    assert bench.safety.state is State.DISABLED, 'before the next update'
    bench.tick()
    assert bench.safety.state is State.DISABLED


def test_power_and_voltage_meet_the_same_current_limit():
    bench = Bench(current=0.25)
    bench.command(0.56, Kind.POWER)
    assert bench.tick(resistance=14.0) == pytest.approx(sqrt(0.56 / 14.0))
    bench.command(2.8, Kind.VOLTAGE)
    assert bench.tick(resistance=14.0) == pytest.approx(0.2)
    bench.command(9.0, Kind.POWER)
    assert bench.tick(resistance=14.0) == 0.25
    bench.command(0.1)
    assert bench.tick(resistance=14.0) == 0.1


def test_a_pause_is_over_with_the_next_update():
    bench = Bench(slew=1.0)
    bench.command(0.2)
    for _ in range(30):
        bench.tick()
    bench.safety.pause('/clock stands still')
    assert bench.safety.current == 0.0
    assert bench.safety.state is State.TIMED_OUT
    assert bench.tick() == pytest.approx(0.01)


def test_silent_feedback_gives_zero_and_is_not_latched():
    bench = Bench()
    bench.command(0.2)
    assert bench.tick(silent='no displacement for 0.2 s') == 0.0
    assert bench.safety.state is State.TIMED_OUT
    assert bench.safety.report().why == 'no displacement for 0.2 s'
    assert bench.tick() == 0.2


@pytest.mark.parametrize(
    'changed',
    [{'current': nan}, {'current': -1.0}, {'slew': inf}, {'derate_temperature': 400.0, 'max_temperature': 390.0}],
)
def test_limits_that_make_no_sense_are_refused(changed):
    with pytest.raises(BadInput, match=r'expected|must begin below'):
        limits(**changed)


# Any sequence of events

numbers = st.one_of(
    st.floats(0.0, 1.0),
    st.sampled_from([0.0, -0.0, nan, inf, -inf, 1e308, -1.0, ABSURD, 5e-324]),
    st.floats(),
)
temperatures = st.one_of(
    st.none(),
    st.floats(290.0, 370.0),
    st.floats(370.0, 395.0),
    st.sampled_from([nan, inf, -inf]),
)
good_limits = st.builds(
    limits,
    current=st.floats(0.0, 2.0),
    slew=st.sampled_from([0.0, 0.5, 100.0]),
    command_timeout=st.sampled_from([0.0, 0.1, 0.5]),
    derate_temperature=st.floats(330.0, 372.0),
    max_temperature=st.floats(373.0, 400.0),
)


class AnySequence(RuleBasedStateMachine):
    """What must hold after every event, whatever came before; kept with a second, simpler book of its own."""

    @initialize(limits=good_limits, enabled=st.booleans())
    def start(self, limits, enabled):
        self.safety = Safety(limits, enabled=enabled)
        self.now = 0.0
        self.enabled = enabled
        self.faulted = False
        self.last_good = None  # when, on the forward clock
        self.good_value = 0.0
        self.forward = 0.0
        self.highest = limits.current
        self.rejected = 0

    @rule(value=numbers, kind=st.sampled_from(Kind))
    def command(self, value, kind):
        answer = self.safety.command(value, self.now, kind)
        most = (
            10.0 * self.safety.limits.current if kind is Kind.CURRENT and self.safety.limits.current > 0.0 else ABSURD
        )
        good = isfinite(value) and 0.0 <= value <= min(most, ABSURD)
        self.rejected += not good
        assert bool(answer) == (not good or not self.enabled)
        if good and self.enabled:
            self.last_good = self.forward
            self.good_value = value
        assert self.safety.report().rejected == self.rejected

    @rule()
    def enable(self):
        refused = self.safety.enable()
        assert bool(refused) == self.faulted
        self.enabled = self.enabled or not refused

    @rule()
    def disable(self):
        self.safety.disable()
        self.enabled = False
        self.last_good = None
        assert self.safety.current == 0.0

    @rule()
    def pause(self):
        self.safety.pause('/clock stands still')
        assert self.safety.current == 0.0

    @rule()
    def trip(self):
        self.safety.trip('by hand')
        self.faulted = True
        assert self.safety.current == 0.0

    @rule()
    def clear(self):
        refused = self.safety.clear_fault()
        if self.faulted and not refused:
            assert self.last_good is None or self.good_value == 0.0, 'cleared under a command'
            self.faulted = False
        assert bool(refused) == self.faulted

    @rule(limits=good_limits)
    def change_limits(self, limits):
        self.safety.limits = limits
        self.highest = max(self.safety.current, limits.current)  # until the next update

    @rule(
        step=st.one_of(st.floats(0.0, 0.3), st.sampled_from([-100.0, 1e6, nan, inf, 0.0])),
        dt=st.one_of(st.floats(1e-4, 0.1), st.sampled_from([0.0, -1.0, nan, inf, 5.0])),
        resistance=st.one_of(st.none(), st.floats(1.0, 50.0), st.sampled_from([nan, 0.0, -1.0, inf, 5e-324])),
        measured=temperatures,
        modelled=temperatures,
        silent=st.sampled_from(['', '', '', 'no displacement']),
    )
    def update(self, step, dt, resistance, measured, modelled, silent):
        before = self.safety.current
        was_faulted = self.faulted
        now = self.now + step
        if isfinite(now):
            self.forward += max(now - self.now, 0.0)
            self.now = now
        current = self.safety.update(now, dt, resistance=resistance, temperatures=(measured, modelled), silent=silent)
        limits = self.safety.limits
        self.highest = limits.current
        known = [value for value in (measured, modelled) if value is not None]
        broken = any(not isfinite(value) or value >= limits.max_temperature for value in known) or (
            resistance is not None and not (isfinite(resistance) and resistance > 0.0)
        )
        self.faulted = was_faulted or broken
        assert (self.safety.state is State.FAULT) == self.faulted
        assert current == self.safety.current
        timeout = limits.command_timeout
        if timeout and self.last_good is not None and self.forward - self.last_good > timeout:
            assert current == 0.0, 'the commander is dead'
            self.last_good = None
        if self.last_good is None or silent or not self.enabled or self.faulted:
            assert current == 0.0
        if known and not self.faulted:
            assert current <= limits.current_at(max(known))
        useless = not 0.0 < dt <= limits.longest_step
        if useless:
            assert current <= before, 'a useless step raised the current'
        elif limits.slew:
            assert current - before <= limits.slew * dt * (1.0 + 1e-12) + 1e-300

    @precondition(lambda self: hasattr(self, 'safety'))
    @invariant()
    def current_flows_only_where_it_may(self):
        current = self.safety.current
        assert isfinite(current) and 0.0 <= current <= self.highest
        if current > 0.0:
            assert self.safety.state in (State.ENABLED, State.DERATING)
            assert self.enabled and not self.faulted
        assert self.safety.report().current == current


AnySequence.TestCase.settings = settings(max_examples=300, stateful_step_count=40, deadline=None)
TestAnySequence = AnySequence.TestCase

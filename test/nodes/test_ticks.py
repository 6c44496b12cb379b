"""The rate that keeps to its clock. Time is a script here: it stands still but for what sleeps, and for busy ticks."""

import threading
from itertools import pairwise
from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from rclpy.clock import Clock, ClockType

from tcp_muscle_ros.nodes import ticks
from tcp_muscle_ros.nodes.ticks import BACKLOG, SECOND, ScaledTime, SteadyTime, TickLoop

MS = SECOND // 1000
OVERSLEPT = MS  # by every sleep


class Script:
    """What ``ticks`` takes for the module ``time``, and a system clock that agrees with it."""

    def __init__(self):
        self.ns = 7 * SECOND

    def monotonic_ns(self):
        return self.ns

    def sleep(self, seconds):
        self.ns += round(seconds * SECOND) + OVERSLEPT

    def now(self):
        return SimpleNamespace(nanoseconds=self.ns + 1000 * SECOND)


@pytest.fixture
def script(monkeypatch):
    made = Script()
    monkeypatch.setattr(ticks, 'time', made)
    return made


class Counted:
    """A loop whose ticks are written down; ``busy`` holds how long a tick takes (ns), by its number."""

    def __init__(self, base, rate, enough, *, script=None, busy=None, longest_step=1.0):
        self.script, self.busy, self.enough = script, busy or {}, enough
        self.calls, self.begun = [], []
        self.done = threading.Event()
        self.loop = TickLoop(base, rate, self.tick, longest_step=longest_step, on_failure=self.done.set)
        self.loop.start()
        assert self.done.wait(60.0)
        self.loop.stop()
        assert self.loop.failure is None

    def tick(self, stamp, dt, publish):
        if len(self.calls) == self.enough:  # until it is stopped
            return
        self.calls.append((stamp, dt, publish))
        if self.script is not None:
            self.begun.append(self.script.ns)
            self.script.ns += self.busy.get(len(self.calls), 0)
        if len(self.calls) == self.enough:
            # What is counted of a tick is counted before it.
            self.missed, self.unpublished, self.jumps = self.loop.missed, self.loop.unpublished, self.loop.jumps
            self.done.set()


def test_on_the_real_clock_stamps_are_multiples_of_a_period_that_no_float_holds():
    base = SteadyTime(Clock(clock_type=ClockType.SYSTEM_TIME))
    stamps = [stamp for stamp, _, _ in Counted(base, 300.0, 100, longest_step=60.0).calls]
    first = stamps[0]
    assert [stamp - first for stamp in stamps] == pytest.approx([k * 1e9 / 300.0 for k in range(100)], abs=1.0)


def test_a_hiccup_is_made_up_for_and_counted_and_nothing_drifts(script):
    begun = SteadyTime(script).now()
    counted = Counted(SteadyTime(script), 200.0, 600, script=script, busy={10: 27 * MS + MS // 2})
    assert [stamp - begun for stamp, _, _ in counted.calls] == [5 * MS * k for k in range(1, 601)]
    assert {dt for _, dt, _ in counted.calls} == {0.005}
    assert all(publish for _, _, publish in counted.calls), 'five ticks late are still published'
    assert (counted.missed, counted.unpublished, counted.jumps) == (4, 0, 0)


def test_who_falls_behind_by_more_than_anyone_keeps_stays_in_the_present(script):
    counted = Counted(SteadyTime(script), 200.0, 200, script=script, busy={10: 500 * MS})  # a hundred periods
    lost = 100 - BACKLOG
    assert [publish for _, _, publish in counted.calls] == [True] * 10 + [False] * lost + [True] * (190 - lost)
    assert (counted.missed, counted.unpublished, counted.jumps) == (99, lost, 0)
    assert {b - a for (a, *_), (b, *_) in pairwise(counted.calls)} == {5 * MS}


def test_a_jump_ahead_is_not_run_after(script):
    begun = SteadyTime(script).now()
    counted = Counted(SteadyTime(script), 100.0, 20, script=script, busy={5: 500 * MS}, longest_step=0.2)
    landed = 50 * MS + OVERSLEPT + 500 * MS
    stamps = [10 * MS * k for k in range(1, 6)] + [landed + 10 * MS * k for k in range(15)]
    assert [stamp - begun for stamp, _, _ in counted.calls] == stamps
    assert [dt for _, dt, _ in counted.calls] == pytest.approx([0.01] * 5 + [0.501] + [0.01] * 14, abs=1e-12)
    assert all(publish for _, _, publish in counted.calls)
    assert (counted.missed, counted.unpublished, counted.jumps) == (0, 0, 1)


@pytest.mark.parametrize('factor', [0.0, 5.0])
def test_simulated_time_begins_after_zero_and_knows_no_lateness(script, factor):
    counted = Counted(ScaledTime(factor), 100.0, 50, script=script, busy={10: 300 * MS})
    assert [stamp for stamp, _, _ in counted.calls] == [10 * MS * k for k in range(1, 51)]
    assert all(publish for _, _, publish in counted.calls)
    assert (counted.missed, counted.unpublished, counted.jumps) == (0, 0, 0)


def test_as_fast_as_it_goes_waits_for_nothing(script):
    begun = script.ns
    assert set(Counted(ScaledTime(0.0), 100.0, 50, script=script).begun) == {begun}


def test_simulated_time_keeps_its_pace_runs_after_a_little_and_never_after_much(script):
    def due(*, busy):
        begun = script.ns
        counted = Counted(ScaledTime(5.0), 100.0, 400, script=script, busy=busy)
        return [at - begun for at in counted.begun]

    every = [2 * MS * k + OVERSLEPT for k in range(1, 401)]  # 10 ms, five times as fast
    assert due(busy={}) == every, 'what is overslept does not add up'
    little = due(busy={10: 50 * MS})
    assert little[:10] == every[:10] and little[40:] == every[40:]
    assert set(little[10:35]) == {every[9] + 50 * MS}, 'what was lost is made up for'
    much = due(busy={10: 200 * MS})
    landed = every[9] + 200 * MS
    assert much[:10] == every[:10] and much[10] == landed
    assert much[11:] == [landed + 2 * MS * k + OVERSLEPT for k in range(1, 390)], 'the pace is that of before'


def test_what_fails_in_a_tick_ends_the_loop_and_is_kept(script):
    done = threading.Event()

    def fail(*_):
        raise ZeroDivisionError

    loop = TickLoop(SteadyTime(script), 100.0, fail, longest_step=1.0, on_failure=done.set)
    loop.start()
    assert done.wait(60.0)
    loop.stop()
    assert isinstance(loop.failure, ZeroDivisionError)

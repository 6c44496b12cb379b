"""The rate that keeps to its clock, on real clocks."""

import threading
import time
from itertools import pairwise

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from rclpy.clock import Clock, ClockType

from tcp_muscle_ros.nodes.ticks import BACKLOG, ScaledTime, SteadyTime, TickLoop


class Counted:
    """A loop whose ticks are written down; ``busy`` holds how long a tick takes (s), by its number."""

    def __init__(self, base, rate, ticks, *, busy=None, longest_step=1.0):
        self.calls, self.busy, self.enough = [], busy or {}, ticks
        self.done = threading.Event()
        self.loop = TickLoop(base, rate, self.tick, longest_step=longest_step, on_failure=self.done.set)
        self.loop.start()
        assert self.done.wait(30.0)
        self.loop.stop()

    def tick(self, stamp, dt, publish):
        self.calls.append((stamp, dt, publish))
        time.sleep(self.busy.get(len(self.calls), 0.0))
        if len(self.calls) >= self.enough:
            self.done.set()


def steady():
    return SteadyTime(Clock(clock_type=ClockType.SYSTEM_TIME))


def test_stamps_are_multiples_of_a_period_that_no_float_holds():
    stamps = [stamp for stamp, _, _ in Counted(steady(), 300.0, 100).calls]
    first = stamps[0]
    assert [stamp - first for stamp in stamps] == pytest.approx([k * 1e9 / 300.0 for k in range(100)], abs=1.0)


def test_a_hiccup_is_made_up_for_and_counted_and_nothing_drifts():
    counted = Counted(steady(), 200.0, 60, busy={10: 0.0275})
    stamps = [stamp for stamp, _, _ in counted.calls]
    assert {b - a for a, b in pairwise(stamps)} == {5_000_000}
    assert {dt for _, dt, _ in counted.calls} == {0.005}
    assert counted.loop.missed >= 4
    assert all(publish for _, _, publish in counted.calls[:15]), 'five ticks late are still published'


def test_who_falls_behind_by_more_than_anyone_keeps_stays_in_the_present():
    counted = Counted(steady(), 200.0, 200, busy={10: 0.5})  # a hundred periods; a busy machine costs a few
    published = [publish for _, _, publish in counted.calls]
    assert counted.loop.unpublished >= 100 - BACKLOG - 2
    assert not any(published[10:80]) and published[-1]
    assert counted.calls[199][0] - counted.calls[0][0] == 199 * 5_000_000


def test_a_jump_ahead_is_not_run_after():
    counted = Counted(steady(), 100.0, 20, busy={5: 0.5}, longest_step=0.2)
    assert counted.loop.jumps == 1
    stamps, steps = [stamp for stamp, _, _ in counted.calls], [dt for _, dt, _ in counted.calls]
    assert max(steps) > 0.4 and steps.count(0.01) == 19
    assert stamps == sorted(stamps)


def test_simulated_time_begins_after_zero_and_knows_no_lateness():
    counted = Counted(ScaledTime(0.0), 100.0, 50, busy={10: 0.3})
    assert [stamp for stamp, _, _ in counted.calls][:50] == [10_000_000 * k for k in range(1, 51)]
    assert counted.loop.missed == counted.loop.jumps == 0


def test_what_fails_in_a_tick_ends_the_loop_and_is_kept():
    done = threading.Event()

    def fail(*_):
        raise ZeroDivisionError

    loop = TickLoop(steady(), 100.0, fail, longest_step=1.0, on_failure=done.set)
    loop.start()
    assert done.wait(10.0)
    loop.stop()
    assert isinstance(loop.failure, ZeroDivisionError)

"""What the twin hears is put together into the muscle's ticks, whenever it looks."""

from itertools import pairwise
from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from tcp_muscle_ros.nodes import twin_hearing
from tcp_muscle_ros.nodes.twin_hearing import Hearing
from tcp_muscle_ros.recording.recording import OUTPUTS

PERIOD = 0.01  # s
TICK = dict.fromkeys((*OUTPUTS, 'current'), 1.0)
BETWEEN = 1e-4  # s from one topic of a tick to the next


class Topic:
    """A subscription: what has come by now, and what comes after the look at it."""

    def __init__(self, topic, world):
        self.topic_name, self.handle, self._world = topic, self, world
        self.waiting, self.held_up = [], 0.0  # s, by which the next look at it comes later

    def take_message(self, kind, _):
        self._world.now += 2e-5 + self.held_up
        self.held_up = 0.0
        if self.waiting and self.waiting[0] <= self._world.now:
            message = Temperature(temperature=1.0) if kind is Temperature else Float64(data=1.0)
            return message, {'received_timestamp': round(self.waiting.pop(0) * 1e9)}
        return None


class World:
    """A time that goes on with each look, and the topics of a muscle that publishes at its own."""

    def __init__(self, monkeypatch, by=None):
        self.now, self.topics = 1000.0, []
        clock = SimpleNamespace(time=lambda: self.now, monotonic=lambda: self.now)
        monkeypatch.setattr(twin_hearing, 'time', clock, raising=False)
        self.published = set()
        self.hearing = Hearing(self, self, PERIOD, by and (lambda: by(self.now)))

    def subscription(self, kind, topic, take, qos, group):
        self.topics.append(Topic(topic, self))
        return self.topics[-1]

    def count_publishers(self, topic):
        return topic in self.published

    def publishes(self, when):
        for k, topic in enumerate(self.topics[: len(TICK)]):
            topic.waiting.append(when + k * BETWEEN)


@pytest.mark.parametrize('phase', [k * 1e-4 for k in range(-10, 11)])
def test_a_tick_of_the_muscle_is_one_whenever_the_twin_looks(monkeypatch, phase):
    world = World(monkeypatch)
    heard = []
    for k in range(1, 21):
        world.publishes(1000.0 + k * PERIOD)
    for k in range(1, 24):
        world.now = max(world.now, 1000.0 + k * PERIOD + phase)
        heard += world.hearing.ticks()
    assert [sorted(tick.values) for tick in heard] == [sorted(TICK)] * 20
    assert [tick.time for tick in heard] == pytest.approx([1000.0 + k * PERIOD for k in range(1, 21)])


@pytest.mark.parametrize('lost', [0.9 * PERIOD, 4.0 * PERIOD])
@pytest.mark.parametrize('place', range(len(TICK)))
def test_a_tick_of_the_muscle_is_one_where_the_machine_is_busy_elsewhere_between_two_looks(monkeypatch, place, lost):
    world = World(monkeypatch)
    heard = []
    for k in range(1, 21):
        world.publishes(1000.0 + k * PERIOD)
    for k in range(1, 30):
        world.now = max(world.now, 1000.0 + (k + 0.6) * PERIOD)
        world.topics[place].held_up = lost * (k == 10)
        heard += world.hearing.ticks()
    assert [sorted(tick.values) for tick in heard] == [sorted(TICK)] * 20
    assert [tick.time for tick in heard] == pytest.approx([1000.0 + k * PERIOD for k in range(1, 21)])


@pytest.mark.parametrize('set_back', [0.0, 5.0])
def test_times_run_back_only_where_the_clock_does(monkeypatch, set_back):
    """What the middleware hands over late was said to be of a clock that was set back: the twin began anew."""
    world = World(monkeypatch)
    heard = []
    for k in range(1, 21):
        world.now = 1000.0 + k * PERIOD - set_back * (k > 10)
        world.publishes(world.now)
        world.now += 0.9 * PERIOD
        if k == 12:
            world.topics[0].waiting.insert(0, world.now - 3.5 * PERIOD)
        heard += [tick.time for tick in world.hearing.ticks()]
    back = [after - before for before, after in pairwise(heard) if after < before]
    assert back == ([pytest.approx(PERIOD - set_back)] if set_back else [])
    assert len(heard) == 20


@pytest.mark.parametrize('pace', [0.5, 3.0])
@pytest.mark.parametrize('set_back', [0.0, 20.0])
def test_ticks_are_of_the_time_that_a_clock_of_another_pace_says(monkeypatch, pace, set_back):
    """By the system's time a simulation at three times its pace moved a third as much as it did, and so differed."""

    def clock(now):
        return 100.0 + pace * (now - 1000.0) - set_back * (now >= 1000.0 + 10 * PERIOD)

    world = World(monkeypatch, clock)
    heard, published = [], [1000.0 + k * PERIOD for k in range(1, 21)]
    for when in published:
        world.publishes(when)
    for k in range(1, 50):
        world.now = max(world.now, 1000.0 + 0.5 * k * PERIOD)
        heard += [tick.time for tick in world.hearing.ticks()]
    # Around the moment at which it is set back none knows what time it was.
    assert heard[:8] == pytest.approx([clock(when) for when in published[:8]], abs=2e-4)
    assert heard[-9:] == pytest.approx([clock(when) for when in published[-9:]], abs=2e-4)


def test_what_came_before_the_clock_was_set_back_is_not_waited_for(monkeypatch):
    world = World(monkeypatch)
    world.publishes(1000.0)
    assert not list(world.hearing.ticks())
    world.now -= 3600.0
    (tick,) = world.hearing.ticks()
    assert tick.time == pytest.approx(1000.0)


def test_a_topic_that_is_published_and_not_heard_is_named(monkeypatch):
    world = World(monkeypatch)
    world.published = {'temperature', 'current', 'load'}  # a load is published where it changes
    assert not world.hearing.silent()
    world.now += 5.0
    next(topic for topic in world.topics if topic.topic_name == 'temperature').waiting.append(1004.0)
    world.hearing.ticks()
    assert world.hearing.silent() == {'current': pytest.approx(5.0, abs=0.01)}

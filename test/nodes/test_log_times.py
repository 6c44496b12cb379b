"""When messages were: those that waited on the way are logged when they were sent, by the clock of the log."""

from itertools import pairwise

from tcp_muscle_ros.nodes.log_times import LogTimes

MS = 1_000_000
OFFSET = 10**12  # of the publisher's clock


def test_the_first_samples_of_a_publisher_that_is_being_discovered_are_a_period_apart():
    sent = [k * 10 * MS + OFFSET for k in range(8)]
    received = [70 * MS + 300_000 + k * 1000 for k in range(8)]  # eight within ten microseconds
    times = LogTimes().of(received, sent)
    assert times[-1] == received[-1]
    assert {b - a for a, b in pairwise(times)} == {10 * MS}


def test_messages_in_time_are_logged_as_received():
    clock = LogTimes()
    for k in range(100):
        received = k * 10 * MS + 300_000 + (k * 7919) % 500_000
        assert clock.of([received], [k * 10 * MS]) == [received]


def test_a_stall_is_told_from_what_came_before():
    clock = LogTimes()
    clock.of([MS + 300_000], [MS])
    times = clock.of([50 * MS + 300_000, 50 * MS + 301_000], [10 * MS, 20 * MS])
    assert [round(time / 1e5) for time in times] == [103, 203]


def test_a_clock_that_is_set_or_drifts_or_is_not_known_is_not_followed():
    clock = LogTimes()
    clock.of([MS + 300_000], [MS])
    assert clock.of([10 * MS], [10 * MS - 3600 * 1000 * MS]) == [10 * MS]
    assert clock.of([20 * MS], [20 * MS - 3600 * 1000 * MS]) == [20 * MS]
    assert clock.of([30 * MS], [0]) == [30 * MS]
    drifting = LogTimes()
    for k in range(1000):  # an hour at which one clock loses 50 us each second
        received = k * 3600 * MS
        assert drifting.of([received], [received - 300_000 - k * 180_000]) == [received]

"""When messages were: those that waited on the way are logged when they were sent, by the clock of the log."""

from itertools import pairwise

from tcp_muscle_ros.nodes.log_times import LogTimes

MS = 1_000_000
OFFSET = 10**13  # of the publisher's clock


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


def test_a_stall_of_any_length_keeps_each_message_where_it_was_sent():
    """Five seconds of standing still, handed over in three turns: none is taken for a clock that was set."""
    clock = LogTimes()
    assert clock.of([300_000], [OFFSET]) == [300_000]
    sent = [OFFSET + k * 10 * MS for k in range(1, 501)]
    received = [5000 * MS + 300_000 + k * 1000 for k in range(500)]
    times = [
        time
        for part in (slice(0, 100), slice(100, 250), slice(250, 500))
        for time in clock.of(received[part], sent[part])
    ]
    assert max(abs(time - (s - OFFSET) - 300_000) for time, s in zip(times, sent, strict=True)) < MS


def test_where_the_first_message_was_the_slowest_the_log_still_runs_on():
    clock = LogTimes()
    first = clock.of([3000 * MS], [OFFSET])
    later = clock.of([3001 * MS] * 3, [OFFSET + 10 * MS, OFFSET + 20 * MS, OFFSET + 3000 * MS])
    assert all(after > before for before, after in pairwise(first + later))
    assert later[-1] <= 3001 * MS + 2


def test_a_clock_that_is_set_or_drifts_or_is_not_known_is_not_followed():
    clock = LogTimes()
    clock.of([MS + 300_000], [OFFSET + MS])
    assert clock.of([10 * MS], [OFFSET + 10 * MS - 3600 * 1000 * MS]) == [10 * MS]
    assert clock.of([20 * MS], [OFFSET + 20 * MS - 3600 * 1000 * MS]) == [20 * MS]
    assert clock.of([30 * MS], [0]) == [30 * MS]
    assert clock.of([9 * MS], [OFFSET + 40 * MS]) == [9 * MS]  # the log's own clock
    drifting = LogTimes()
    for k in range(1, 1000):  # an hour at which one clock loses 50 us each second
        received = k * 3600 * MS
        assert drifting.of([received], [OFFSET + received - 300_000 - k * 180_000]) == [received]


def test_a_clock_of_the_log_that_is_set_forward_is_followed_once_no_stall_explains_it():
    clock = LogTimes()
    clock.of([300_000], [OFFSET])
    late = [clock.of([k * 100 * MS + 3600_000 * MS], [OFFSET + k * 100 * MS]) for k in range(1, 120)]
    assert late[0][0] < 1000 * MS
    assert late[-1] == [119 * 100 * MS + 3600_000 * MS]

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.protocol import DEFAULT_LOAD_N, read_protocol


@pytest.fixture
def protocol(tmp_path):
    def read(text):
        path = tmp_path / 'protocol.yaml'
        path.write_text(text)
        return read_protocol(path)

    return read


def test_segments_ramps_loads_and_ambient_on_the_ticks(protocol):
    sampled = protocol(
        """
        rate_hz: 10
        input: power
        segments:
          - {duration_s: 0.3, value: 2, load_n: 1, ambient_c: 20}
          - {duration_s: 0.4, value: [0, 4], ambient_c: [20, 30]}
          - {duration_s: 0.2, value: 1e-1, load_n: [1, 2]}
        """
    ).sampled()
    np.testing.assert_allclose(sampled.time, np.arange(10) / 10)
    assert sampled.kind == 'power'
    np.testing.assert_allclose(sampled.drive, [2, 2, 2, 0, 1, 2, 3, 0.1, 0.1, 0.1], atol=1e-12)
    np.testing.assert_allclose(sampled.load, [1, 1, 1, 1, 1, 1, 1, 1, 1.5, 2], atol=1e-12)
    np.testing.assert_allclose(sampled.ambient - 273.15, [20, 20, 20, 20, 22.5, 25, 27.5, 30, 30, 30], atol=1e-9)


def test_repeats_and_defaults(protocol):
    repeated = protocol('{rate_hz: 4, input: current, repeat: 3, segments: [{duration_s: 1, value: 0.27}, '
                        '{duration_s: 0.5, value: 0}]}')  # fmt: skip
    sampled = repeated.sampled()
    assert repeated.duration == 4.5
    np.testing.assert_array_equal(sampled.drive, [0.27, 0.27, 0.27, 0.27, 0, 0] * 3 + [0])
    assert set(sampled.load) == {DEFAULT_LOAD_N}
    assert set(sampled.ambient) == {296.15}
    assert (repeated.end, repeated.end_options) == ('load', {})


def test_ticks_do_not_drift_over_many_repeats(protocol):
    """0.1 s is no binary fraction: after 5000 repeats every segment still begins on its tick."""
    sampled = protocol(
        '{rate_hz: 100, input: current, repeat: 5000, '
        'segments: [{duration_s: 0.1, value: 1}, {duration_s: 0.3, value: 0}]}'
    ).sampled()
    assert len(sampled.time) == 200_001
    np.testing.assert_array_equal(sampled.drive[:-1].reshape(5000, 40), [[1.0] * 10 + [0.0] * 30] * 5000)


def test_a_segment_that_ends_between_ticks_lasts_until_the_next_tick(protocol):
    sampled = protocol(
        '{rate_hz: 10, input: voltage, segments: [{duration_s: 0.25, value: 1}, {duration_s: 0.25, value: 2}]}'
    ).sampled()
    assert sampled.drive.tolist() == [1, 1, 1, 2, 2, 2]


def test_pieces_are_the_whole_and_begin_with_the_last_tick_before(protocol):
    made = protocol(
        '{rate_hz: 100, input: current, repeat: 40, segments: [{duration_s: 0.104, value: [0, 1], load_n: 0.5}, '
        '{duration_s: 3.3, value: 0, ambient_c: [20, 30]}, {duration_s: 0.002, value: 1, load_n: [1, 2]}]}'
    )
    whole = made.sampled()
    for most in (1, 7, 1000, len(whole.time) - 1, len(whole.time)):
        pieces = list(made.pieces(most))
        assert max(len(piece.time) for piece in pieces) <= 2 * most
        for before, after in pairwise(pieces):
            assert before.time[-1] == after.time[0]
        for name in ('time', 'drive', 'load', 'ambient'):
            parts = [getattr(piece, name)[k > 0 :] for k, piece in enumerate(pieces)]
            np.testing.assert_array_equal(np.concatenate(parts), getattr(whole, name))


def test_the_end_of_the_muscle(protocol):
    spring = protocol(
        '{rate_hz: 1, input: current, end: spring, spring_rate_n_per_m: 20, segments: [{duration_s: 1, value: 0}]}'
    )
    assert (spring.end, spring.end_options) == ('spring', {'spring_rate_n_per_m': 20.0})


HEAD = 'rate_hz: 10\ninput: current\n'


@pytest.mark.parametrize(
    ('text', 'says'),
    [
        (
            'rate_hz: 10\ninput: curent\nsegments: [{duration_s: 1, value: 0}]',
            "input is 'curent'; did you mean 'current'",
        ),
        ('input: current\nsegments: [{duration_s: 1, value: 0}]', "the key 'rate_hz' is missing"),
        (HEAD + 'segment: [{duration_s: 1, value: 0}]', "unknown key 'segment'; did you mean 'segments'"),
        (HEAD + 'segments: []', r'segments is \[\], expected a list'),
        (HEAD + 'segments: [{duration: 1, value: 0}]', "segments 1: unknown key 'duration'; did you mean 'duration_s'"),
        (HEAD + 'segments: [{duration_s: 1}]', "segments 1: the key 'value' is missing"),
        (HEAD + 'segments: [{duration_s: 1, value: [1, 2, 3]}]', 'has 3 numbers, expected one number or a ramp'),
        (HEAD + 'segments: [{duration_s: 1, value: .nan}]', 'expected a finite number'),
        (HEAD + 'segments: [{duration_s: 1, value: high}]', "value is 'high', expected a number"),
        (HEAD + 'segments: [{duration_s: 0, value: 1}]', 'duration_s is 0, expected a number > 0'),
        (HEAD + 'segments: [{duration_s: 1, value: 1, load_n: -1}]', 'a load can only pull'),
        (HEAD + 'segments: [{duration_s: 1, value: [0.2, -0.1]}]', 'segments 1: value is -0.1, expected >= 0'),
        (HEAD + 'repeat: 1e9\nsegments: [{duration_s: 1e-9, value: 1}]', 'expected at most 5e\\+06'),
        (HEAD + 'repeat: 1.5\nsegments: [{duration_s: 1, value: 1}]', 'expected a whole number of 1 or more'),
        (HEAD + 'end: free\nsegments: [{duration_s: 1, value: 1}]', "end is 'free'; known: blocked, load, spring"),
        (HEAD + 'segments: [{duration_s: 1e9, value: 1}]', '1e\\+10 samples'),
        (HEAD + 'segments: [{duration_s: 1, value: 1', ':3:.*not valid YAML'),
        ('just a text', 'expected keys with values'),
    ],
)
def test_a_mistake_is_one_line_with_the_key_and_the_nearest_valid_one(protocol, text, says):
    with pytest.raises(BadInput, match=says) as caught:
        protocol(text)
    assert 'protocol.yaml' in str(caught.value)
    assert '\n' not in str(caught.value)


def test_a_missing_file_that_is_like_none_beside_it_names_those_that_come_along(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'mkdocs.yml').write_text('')
    with pytest.raises(BadInput, match=r'known: .*/config/protocol_loads.yaml, .*/config/protocol_steps.yaml$'):
        read_protocol(tmp_path / 'nope.yaml')
    monkeypatch.chdir(Path(__file__).parents[2])
    with pytest.raises(BadInput, match=r'known: config/protocol_loads.yaml, config/protocol_steps.yaml$'):
        read_protocol('nope.yaml')


def test_a_missing_file_names_the_nearest(tmp_path):
    (tmp_path / 'steps.yaml').touch()
    with pytest.raises(BadInput, match=r"cannot be read .*did you mean 'steps.yaml'"):
        read_protocol(tmp_path / 'step.yaml')
    with pytest.raises(BadInput) as refused:
        read_protocol(tmp_path / 'nofile.yaml')
    assert 'did you mean' not in str(refused.value), 'alike in nothing but the suffix'

import os
from pathlib import Path

import numpy as np
import pytest

from tcp_muscle_ros.recording.checks import check, check_samples, quantum
from tcp_muscle_ros.recording.csv_import import import_runs, lab_files
from tcp_muscle_ros.recording.import_map import read_import_map
from tcp_muscle_ros.recording.recording import Channel, Recording

REPOSITORY = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get('TCP_MUSCLE_SHARED', REPOSITORY.parent / 'shared')) / 'data'

TIME = np.arange(3000) / 100


def temperature(noise=0.05, seed=0):
    """A heating and cooling muscle's temperature, K."""
    rise = np.where(TIME < 15, 1 - np.exp(-TIME / 5), np.exp(-(TIME - 15) / 5))
    return 296.15 + 60 * rise + noise * np.random.default_rng(seed).normal(size=len(TIME))


def kinds(name, time, value):
    return [issue.kind for issue in check_samples(name, time, value)]


@pytest.mark.parametrize('noise', [0.0, 1e-4, 0.05, 2.0])
def test_a_sound_channel_has_no_findings(noise):
    for seed in range(5):
        assert kinds('temperature', TIME, temperature(noise, seed)) == []
        jittered = TIME + np.random.default_rng(seed).uniform(-0.0005, 0.0005, len(TIME))
        assert kinds('temperature', jittered, temperature(noise, seed)) == []


def test_a_muscle_at_rest_on_a_coarse_encoder_is_not_stuck():
    moving = 0.025 * (1 - np.exp(-np.clip(TIME - 10, 0, None) / 2))
    encoder = np.round(moving / 9e-6) * 9e-6
    assert kinds('displacement', TIME, encoder) == []


def test_a_gap_is_found_where_it_is():
    kept = (TIME < 10) | (TIME > 12)
    (issue,) = check_samples('temperature', TIME[kept], temperature()[kept])
    assert issue.kind == 'gap'
    assert issue.interval == pytest.approx((9.99, 12.01))
    assert 'no sample for 2.02 s from 9.990 s' in issue.sentence


def test_many_gaps_are_one_sentence():
    kept = (np.arange(3000) % 300) > 20
    (issue,) = check_samples('temperature', TIME[kept], temperature()[kept])
    assert issue.sentence.startswith('temperature: 9 gaps, ')


def test_an_unsteady_rhythm_of_all_channels_is_told_once():
    uneven = np.cumsum(np.random.default_rng(0).uniform(0.002, 0.018, 3000))
    names = ('temperature', 'displacement')
    channels = {name: Channel(name, uneven, temperature(), name) for name in names}
    recording = Recording(Path('run'), channels, 0)
    told = [issue.sentence for issue in check(recording) if issue.kind == 'jitter']
    assert len(told) == 1 and told[0].startswith('temperature, displacement: intervals spread')


def test_weights_that_are_put_on_and_taken_off_are_no_sensor_at_its_limit():
    weights = np.array([100.0, 67.0, 100.0, 30.0, 100.0])[np.arange(3000) // 600]
    weights[np.arange(600, 3000, 600)] = (80.3, 83.1, 61.2, 77.0)  # a hand
    assert kinds('force', TIME, 9.80665e-3 * weights) == []


def test_jitter_backwards_and_duplicate_times():
    rng = np.random.default_rng(0)
    uneven = np.cumsum(rng.uniform(0.002, 0.018, 3000))
    assert 'jitter' in kinds('temperature', uneven, temperature())
    swapped = TIME.copy()
    swapped[[1000, 1001]] = swapped[[1001, 1000]]
    (back,) = [issue for issue in check_samples('temperature', swapped, temperature()) if issue.kind == 'backwards']
    assert back.interval == pytest.approx((10.0, 10.01))
    doubled = TIME.copy()
    doubled[500] = doubled[499]
    assert 'duplicate' in kinds('temperature', doubled, temperature())


def test_a_noisy_sensor_that_freezes_is_stuck():
    value = temperature()
    value[1200:1400] = value[1200]
    (issue,) = check_samples('temperature', TIME, value)
    assert issue.kind == 'stuck'
    assert issue.interval == pytest.approx((12.0, 13.99))


def test_a_noiseless_sensor_that_stops_dead_while_moving_is_stuck():
    value = temperature(0.0)
    value[300:500] = value[300]
    (issue,) = check_samples('temperature', TIME, value)
    assert (issue.kind, issue.interval) == ('stuck', pytest.approx((3.0, 4.99)))


def test_a_sensor_at_its_limit():
    (issue,) = check_samples('temperature', TIME, np.minimum(temperature(), 340.0))
    assert issue.kind == 'saturation'
    assert 'sit at its top, 66.85 degC' in issue.sentence
    (issue,) = check_samples('displacement', TIME, np.maximum(-temperature(0.0), -340.0) * 1e-3)
    assert 'sit at its bottom' in issue.sentence


def test_values_that_are_not_finite():
    value = temperature()
    value[[5, 7]] = np.nan, np.inf
    (issue,) = check_samples('temperature', TIME, value)
    assert (issue.kind, issue.interval) == ('not_finite', (0.05, 0.07))


@pytest.mark.parametrize('step', [0.0625, 0.25, 1.0])
def test_the_step_of_a_quantised_channel(step):
    assert quantum(np.round(temperature() / step) * step) == pytest.approx(step)


def test_a_coarse_channel_is_said_to_be_coarse():
    (issue,) = check_samples('temperature', TIME, np.round(temperature(0.5) / 4) * 4)
    assert issue.kind == 'quantisation'
    assert 'in steps of 4, ' in issue.sentence


def test_the_rounding_of_a_constant_is_no_step():
    assert kinds('temperature', TIME, 296.15 + 5.7e-14 * (np.arange(TIME.size) % 6)) == []


@pytest.mark.parametrize(
    ('name', 'value', 'says'),
    [
        ('temperature', temperature() + 273.15, r'--unit temperature='),  # kelvin, read as degrees Celsius
        ('displacement', temperature() / 10, r'--unit displacement='),  # millimetres, read as metres
        ('force', temperature() * 10, r'--unit force='),  # grams, read as newtons
        ('current', np.full(3000, 270.0), r'--unit current='),  # milliamperes
    ],
)
def test_an_unlikely_magnitude_points_at_the_unit(name, value, says):
    (issue,) = check_samples(name, TIME, value)
    assert issue.kind == 'unit'
    assert says in issue.sentence


def test_inputs_may_rest_and_sit_at_their_limit():
    square = np.where(TIME % 10 < 5, 0.27, 0.0)
    assert kinds('current', TIME, square) == []
    assert kinds('current_command', np.array([0.0, 1.0, 20.0]), np.array([0.0, 0.27, 0.0])) == []


def test_too_short_a_channel():
    assert kinds('force', np.array([1.0]), np.array([2.0])) == ['short']
    assert kinds('force', np.array([]), np.array([])) == ['short']


def test_a_recording_is_checked_channel_by_channel():
    bad = temperature()
    bad[1200:1400] = bad[1200]
    channels = {
        'temperature': Channel('temperature', TIME, bad, '/temperature'),
        'resistance': Channel('resistance', TIME, temperature() / 100, '/resistance'),
    }
    assert [(issue.channel, issue.kind) for issue in check(Recording('', channels, 0))] == [('temperature', 'stuck')]


@pytest.mark.skipif(not DATA.is_dir(), reason='the recordings of other labs are not here (TCP_MUSCLE_SHARED)')
def test_what_is_known_of_the_real_rigs_is_found():
    """Positions read by eye, 1 s then 2 s apart; an encoder that sticks and slips; nothing else."""
    found = {}
    for rig in ('tca_bench_rig', 'tca_video_rig'):
        import_map = read_import_map(REPOSITORY / 'config' / f'import_{rig}.yaml')
        for run in import_runs(import_map, lab_files([DATA / rig])):
            found[run.name] = {issue.kind for issue in check(run.recording)}
    video = {name: issues for name, issues in found.items() if name.startswith(('mandrel', 'self'))}
    assert all(issues == ({'jitter'} if 'step' not in name else set()) for name, issues in video.items())
    assert all(not issues for name, issues in found.items() if name.startswith('force'))
    stroke = [issues for name, issues in found.items() if name.startswith('stroke')]
    assert set().union(*stroke) <= {'stuck', 'saturation'}


def heated(*, resistance, missing=(0.0, 0.0)):
    """30 s, heated half of the time in stretches of 5 s; no sample of any channel between ``missing``."""
    on = TIME % 10.0 < 5.0
    after, before = missing
    there = ~((after <= TIME) & (before >= TIME))
    flows = there & on & resistance(TIME)
    noise = 0.01 * np.random.default_rng(4).standard_normal(TIME.size)
    return Recording(
        'bag',
        {
            'current': Channel('current', TIME[there], 0.2 * on[there], 'current'),
            'temperature': Channel('temperature', TIME[there], temperature()[there], 'temperature'),
            'resistance': Channel('resistance', TIME[flows], 14.0 + noise[flows], 'resistance'),
        },
        0,
    )


def test_a_resistance_is_not_missed_where_no_current_flows():
    (issue,) = check(heated(resistance=lambda t: t >= 0.0))
    assert issue.kind == 'pause'
    assert issue.sentence == 'resistance: read under current only; nothing in 2 pause(s)'


def test_a_resistance_is_missed_where_current_flows():
    pause, gap = check(heated(resistance=lambda t: (t < 11.0) | (t > 13.0)))
    assert (pause.kind, gap.kind) == ('pause', 'gap')
    assert gap.interval == pytest.approx((10.99, 13.01), abs=0.02)
    assert 'no sample for 2.0' in gap.sentence
    assert 'though current flowed' in gap.sentence


def test_a_gap_that_all_channels_share_is_told_once():
    gap, _ = check(heated(resistance=lambda t: t >= 0.0, missing=(11.0, 14.0)))
    assert gap.kind == 'gap'
    assert gap.sentence.startswith('current, temperature, resistance: no sample for 3.02 s from 10.990 s')


def test_a_gap_of_all_channels_is_no_pause_of_a_resistance():
    """The logger paused while no current flowed: the resistance is read without any, too."""
    there = (TIME < 7.0) | (TIME > 7.24)
    made = {'current': 0.2 * (TIME < 5.0), 'temperature': temperature(), 'resistance': temperature(seed=1) / 20.0}
    channels = {name: Channel(name, TIME[there], value[there], name) for name, value in made.items()}
    (gap,) = check(Recording('bag', channels, 0))
    assert gap.sentence.startswith('current, temperature, resistance: no sample for 0.26 s from 6.990 s')

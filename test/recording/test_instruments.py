"""Faults of instruments that one recording shows: each is named where it is, and nothing where there is none."""

from dataclasses import replace

import numpy as np
import pytest
from commands import faulty_bags as bags
from scipy.signal import lfilter

from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.instruments import instrument_faults
from tcp_muscle_ros.recording.recording import Channel, Recording


@pytest.fixture(scope='module')
def sound(tmp_path_factory):
    """Two heatings of a muscle of the independent truth generator, at 10 Hz."""
    return read_bag(bags.write_bag(tmp_path_factory.mktemp('sound') / 'bag', *bags.sound()))


def changed(recording, name, change):
    channel = recording[name]
    time, value = change(channel.time.copy(), channel.value.copy())
    return replace(recording, channels={**recording.channels, name: Channel(name, time, value, channel.topic)})


def named(recording):
    return {(channel, kind): sentence for channel, kind, sentence in instrument_faults(recording)}


def held(time, value):
    for k in np.flatnonzero(np.random.default_rng(1).random(value.size) < 0.2):
        value[k] = value[max(k - 1, 0)]
    return time, value


def test_what_is_sound_has_no_name(sound):
    assert named(sound) == {}


def test_held_duplicates_are_named(sound):
    found = named(changed(sound, 'temperature', held))
    assert set(found) == {('temperature', 'held')}
    assert '% of its samples repeat the one before to the last bit' in found['temperature', 'held']


def cycled():
    """Seven minutes at 10 Hz in which the muscle is heated and cools again and again, as it is without noise."""
    time = np.arange(4000) / 10.0
    current = 0.25 * ((time % 60.0 > 10.0) & (time % 60.0 < 35.0))
    rise = lfilter([0.0, 0.0125], [1.0, -0.9875], (current / 0.25) ** 2)
    return time, current, {'temperature': 296.15 + 55.0 * rise, 'displacement': 4e-3 * rise}


@pytest.mark.parametrize('name', ['temperature', 'displacement'])
@pytest.mark.parametrize('times', [2, 3, 5, 10])
def test_a_sensor_that_is_slower_than_its_logger_is_named_with_how_often_each_value_stands(name, times):
    time, current, sound = cycled()
    read = sound[name] * (1.0 + 1e-4 * np.random.default_rng(5).standard_normal(time.size))
    for value in (sound[name], read):
        assert named(driven(time, current, outputs={name: value})) == {}
        found = named(driven(time, current, outputs={name: value[np.arange(time.size) // times * times]}))
        assert set(found) == {(name, 'held')}
        assert f'each of its values stands there {times} times' in found[name, 'held']


@pytest.mark.parametrize('step', [0.05, 0.25, 2.0])
@pytest.mark.parametrize('share', [1.0, 0.1, 0.02], ids=['quick', 'slow', 'nearly at rest'])
def test_a_coarse_thermometer_is_not_held(step, share):
    time, current, sound = cycled()
    value = 296.15 + share * (sound['temperature'] - 296.15)
    for noise in (0.0, 0.5 * step):
        read = np.round((value + noise * np.random.default_rng(6).standard_normal(time.size)) / step) * step
        assert ('temperature', 'held') not in named(driven(time, current, outputs={'temperature': read}))


def test_quantised_samples_repeat_by_themselves(sound):
    coarse = changed(sound, 'temperature', lambda t, v: (t, np.round(v / 0.25) * 0.25))
    assert ('temperature', 'held') not in named(coarse)


@pytest.mark.parametrize(('channel', 'size'), [('displacement', 2e-4), ('temperature', 1.0)])
def test_a_tone_is_named_with_its_frequency(sound, channel, size):
    found = named(changed(sound, channel, lambda t, v: (t, v + size * np.sin(2 * np.pi * 3.1 * t))))
    assert set(found) == {(channel, 'tone')}
    assert 'a tone of 3.1 Hz throughout' in found[channel, 'tone']


@pytest.mark.parametrize(('cycles', 'beside'), [(0.3, 1.3), (0.4, 1.3), (0.6, 1.7)])  # Hz
@pytest.mark.parametrize(('drive', 'noise'), [('current', 0.0), ('current', 1e-3), ('voltage', 1e-3), ('power', 1e-3)])
def test_what_a_drive_that_goes_to_and_fro_does_to_the_muscle_is_no_tone_and_one_beside_it_is(
    cycles, beside, drive, noise
):
    """Heat goes as the square of a current: of a sine through zero it has twice the frequency."""
    time, rng = np.arange(4000) / 20.0, np.random.default_rng(7)
    given = 0.25 * np.sin(2 * np.pi * cycles * time)
    given = given**2 if drive == 'power' else given
    heat = given if drive == 'power' else given**2
    rise = lfilter([0.0, 0.00625], [1.0, -0.99375], heat / 0.0625)
    value = 296.15 + 55.0 * rise + 0.05 * rng.standard_normal(time.size)
    given = given + noise * rng.standard_normal(time.size)

    def tones(tone):
        outputs = {drive: given, 'temperature': value + 0.5 * np.sin(2 * np.pi * tone * time) * (tone > 0.0)}
        return named(Recording('', {name: Channel(name, time, of, name) for name, of in outputs.items()}, 0))

    assert ('temperature', 'tone') not in tones(0.0)
    assert f'a tone of {beside} Hz throughout' in tones(beside)['temperature', 'tone']


@pytest.mark.parametrize(('rate', 'each', 'lag'), [(100, 4.0, 3.0), (100, 4.0, 20.0), (50, 10.0, 5.0), (10, 30.0, 8.0)])
def test_a_smooth_heating_and_cooling_is_no_tone(rate, each, lag):
    """A simulated recording has no noise: all that its spectrum has is the curve itself, and its rounding."""
    time = np.arange(int(2 * each * rate) + 1) / rate
    current = 0.2 * (time < each)
    top = 1.0 - np.exp(-each / lag)
    rise = np.where(time < each, 1.0 - np.exp(-time / lag), top * np.exp(-(time - each) / lag))
    assert named(driven(time, current, outputs={'temperature': 296.15 + 60.0 * rise})) == {}


def test_a_wave_in_the_last_bit_of_a_number_is_no_tone():
    time = np.arange(2400) / 20.0
    value = 300.0 + 1e-12 * np.sin(2 * np.pi * 3.1 * time)
    assert named(driven(time, np.zeros(2400), outputs={'temperature': value})) == {}
    value = 300.0 + 1e-3 * np.sin(2 * np.pi * 3.1 * time)
    assert set(named(driven(time, np.zeros(2400), outputs={'temperature': value}))) == {('temperature', 'tone')}


def test_a_channel_of_another_clock_that_is_ahead_is_named(sound):
    found = named(changed(sound, 'temperature', lambda t, v: (t[20:] - 2.0, v[20:])))
    assert set(found) == {('temperature', 'clock')}
    assert 'temperature: moves 2 s before the current that moves it' in found['temperature', 'clock']


def heated_once(ahead=0.0, noise=2e-5, drift=0.0, sticks=False):
    """One heating after a rest, as a bench has it: a stroke, on a clock that is so much (s) ahead."""
    time = np.arange(400) / 5.0
    rise = np.where(time < 25.0, 0.0, 1.0 - np.exp(-np.maximum(time - 25.0, 0.0) / 9.0))
    stroke = 0.04 * np.where(time < 55.0, rise, rise[275] * np.exp(-(time - 55.0) / 9.0))
    stroke = np.round(stroke / 3e-3) * 3e-3 if sticks else stroke  # it rests, and then jumps
    stroke = stroke + drift * time + noise * np.random.default_rng(2).standard_normal(time.size)
    power = Channel('power', time, 3.0 * ((time >= 25.0) & (time < 55.0)), 'power')
    return Recording('', {'power': power, 'displacement': Channel('displacement', time - ahead, stroke, '')}, 0)


@pytest.mark.parametrize('seen', [{}, {'noise': 2e-4}, {'sticks': True, 'noise': 0.0}])
def test_what_moves_before_its_only_heating_is_of_another_clock(seen):
    found = named(heated_once(2.0, **seen))
    assert set(found) == {('displacement', 'clock')}
    assert ' s before the power that moves it: their clocks differ' in found['displacement', 'clock']
    assert named(heated_once(0.0, **seen)) == {} and named(heated_once(-2.0, **seen)) == {}


def stroke(jumps=0.0):
    """One heating as ``heated_once`` has it, by an encoder of 9 um; ``jumps``: it rests and jumps by so much (m)."""
    seen = heated_once(noise=0.0)
    value = seen['displacement'].value
    value = np.round(value / jumps) * jumps if jumps else value
    return changed(seen, 'displacement', lambda t, _: (t, np.round(value / 9e-6) * 9e-6))


@pytest.mark.parametrize('jumps', [0.0, 2e-3])
def test_duplicates_of_an_encoder_are_named_where_it_moves_on(jumps):
    """At rest it repeats without end, and what sticks rests: a logger that holds a value does so while it moves."""
    assert named(stroke(jumps)) == {}
    assert set(named(changed(stroke(), 'displacement', held))) == {('displacement', 'held')}


def test_noise_that_is_read_coarsely_repeats_by_chance():
    rng = np.random.default_rng(3)
    time = np.arange(4000) / 20.0
    value = np.round((300.0 + 0.2 * time + 1.0 * rng.standard_normal(4000)) / 0.1) * 0.1
    assert named(driven(time, np.zeros(4000), outputs={'temperature': value})) == {}


@pytest.mark.parametrize('jumps', [0.0, 1e-3])
def test_a_step_at_each_of_two_switches_is_named(jumps):
    power = stroke()['power']

    def picks_up(time, value):
        return time, value + 3e-3 * (power.value > 0.0)

    found = named(changed(stroke(jumps), 'displacement', picks_up))
    assert set(found) == {('displacement', 'switch')}
    assert 'mm at each of 2 switches of the power' in found['displacement', 'switch']


def test_a_tone_is_named_beside_jumps():
    wave = changed(stroke(1e-3), 'displacement', lambda t, v: (t, v + 5e-4 * np.sin(2 * np.pi * 1.7 * t)))
    assert set(named(wave)) == {('displacement', 'tone')}


def test_a_channel_that_drifts_while_it_rests_does_not_move_before_its_heating():
    for drift in (1e-5, 1e-4, -1e-4):
        assert named(heated_once(drift=drift)) == {}


def test_a_channel_that_is_late_may_be_heat_that_is_late(sound):
    assert named(changed(sound, 'temperature', lambda t, v: (t[:-20] + 2.0, v[:-20]))) == {}


def test_a_step_at_each_switch_is_named(sound):
    drive = sound['current']

    def picks_up(time, value):
        on = drive.value[np.clip(np.searchsorted(drive.time, time + 1e-9, side='right') - 1, 0, None)]
        return time, value + 4.0 * on / on.max()

    found = named(changed(sound, 'temperature', picks_up))
    assert set(found) == {('temperature', 'switch')}
    assert 'at each of 4 switches of the current, faster than heat' in found['temperature', 'switch']


def test_the_last_bit_of_a_number_is_no_step(sound):
    """A force that was computed from a load: it is constant but for its rounding, which goes with the state."""
    drive = sound['current']

    def rounded(time, value):
        on = drive.value[np.clip(np.searchsorted(drive.time, time + 1e-9, side='right') - 1, 0, None)]
        return time, 0.5 + 1e-12 * (on > 0.5 * on.max())

    assert named(changed(sound, 'displacement', rounded)) == {}


def switched(cycle_s, *, duty=0.4, rate=20.0, read=0.0):
    """Two minutes of which the second is heated by a PWM as an instrument reads it now and then, and a thermometer."""
    time = np.arange(int(120 * rate)) / rate
    current = 0.4 * ((time > 60.0) & (time % cycle_s < duty * cycle_s))
    current += read * np.random.default_rng(0).standard_normal(time.size)
    return driven(time, current)


def driven(time, current, output_s=0.05, outputs=None):
    """Outputs at the times of the drive; a thermometer of its own times where there are none."""
    if outputs is not None:
        made = {'current': current, **outputs}
        return Recording('', {name: Channel(name, time, value, name) for name, value in made.items()}, 0)
    at = np.arange(0.0, 120.0, output_s)
    temperature = 300.0 + np.random.default_rng(3).standard_normal(at.size)
    channels = {'current': (time, current), 'temperature': (at, temperature)}
    return Recording('', {name: Channel(name, *of, name) for name, of in channels.items()}, 0)


@pytest.mark.parametrize('duty', [0.25, 0.4, 0.7])
@pytest.mark.parametrize('read', [0.0, 0.01])
def test_a_pwm_that_is_read_too_seldom_is_named(duty, read):
    found = named(switched(0.137, duty=duty, read=read))
    assert set(found) == {('current', 'undersampled')}
    assert found['current', 'undersampled'].startswith('current: switches so often that it is read only 1.')


_AT = np.arange(2400) / 20.0
_ANY = np.random.default_rng(4)


@pytest.mark.parametrize(
    'current',
    [
        0.4 * (_AT % 1.0 < 0.4),
        0.4 * (_AT % 0.137 / 0.137),  # as an ammeter averages it
        0.4 * np.repeat(_ANY.integers(0, 2, 240), 10),
        0.2 + 0.2 * np.sin(2 * np.pi * 4.1 * _AT),
        0.4 * (_AT % 20.0) / 20.0,
        0.01 * _ANY.standard_normal(2400),
        0.4 * (_AT > 60.0) + 0.01 * _ANY.standard_normal(2400),
        0.4 + 0.05 * _ANY.integers(0, 2, 2400),  # one step of a coarse ammeter
        0.005 * _ANY.integers(0, 2, 2400),  # the same, and nothing flows
    ],
    ids=['slow', 'averaged', 'prbs', 'sine', 'ramp', 'noise', 'noisy step', 'coarse', 'idle'],
)
def test_what_is_read_often_enough_or_does_not_switch_has_no_name(current):
    assert ('current', 'undersampled') not in named(driven(_AT, current))


def test_a_drive_that_was_told_when_it_changed_is_known_between():
    time = np.arange(0.0, 120.0, 0.5)
    assert ('current', 'undersampled') not in named(driven(time, 0.4 * (np.arange(time.size) % 2)))


def test_voltage_and_current_that_are_both_high_contradict_a_power():
    time = np.arange(300) / 10.0
    on = (time % 10.0) < 5.0
    made = {'current': 0.25 * on, 'voltage': 2.5 * on, 'power': 0.625 * on, 'resistance': np.full(300, 10.0)}

    def recorded(**factors):
        channels = {n: Channel(n, time, v * factors.get(n, 1.0), n) for n, v in made.items()}
        return named(Recording('', channels, 0))

    assert recorded() == {}
    assert set(recorded(current=1.07, voltage=1.07)) == {('power', 'contradiction')}
    assert '+14.5 %' in recorded(current=1.07, voltage=1.07)['power', 'contradiction']
    assert set(recorded(current=1.07)) == {('power', 'contradiction'), ('resistance', 'contradiction')}
    assert 'PWM' not in recorded(current=1.07)['power', 'contradiction']
    means = recorded(current=0.3, voltage=0.3, power=0.3)  # of a PWM of 30 %
    assert set(means) == {('power', 'contradiction')}
    assert '-70.0 %: an instrument is wrong, or these are means of a PWM' in means['power', 'contradiction']

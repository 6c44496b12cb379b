"""A recording as the model sees it."""

from dataclasses import replace

import numpy as np
import pytest

from tcp_muscle_ros.commands.calibrate import admitted
from tcp_muscle_ros.commands.one_diagnosis import diagnosed
from tcp_muscle_ros.diagnosis.observation.holding import Conditions
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.diagnosis.observation.quotient import beside
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Parameters, simulate
from tcp_muscle_ros.muscle.free_basis import basis
from tcp_muscle_ros.recording.leaps import DAY_NS
from tcp_muscle_ros.recording.plausibility import not_across
from tcp_muscle_ros.recording.recording import UNDATED_NS, Channel, Recording
from tcp_muscle_ros.settings.parameter_file import ParameterFile

NOMINAL = Parameters.named('karami_tadesse_2017')
TIME = np.arange(0.0, 140.0, 0.05)
CURRENT = np.where(np.mod(TIME, 70.0) < 25.0, 0.24, 0.0)


def recording(known=None, **channels):
    made = {name: Channel(name, time, value, name) for name, (time, value) in channels.items()}
    return Recording('made', made, 0, known or {}, ())


def stepped():
    """Three loads, 20 Hz, the length answering at the next tick, resistance under current only."""
    load = np.select([TIME < 40.0, TIME < 90.0], [0.3, 0.9], 0.6)
    out = simulate(NOMINAL, TIME, CURRENT, load=load, starting_load=0.3)
    late = np.concatenate([out.displacement[:1], out.displacement[:-1]])
    at = TIME[np.isin(TIME, TIME[np.flatnonzero(np.diff(load)) + 1])]
    x = np.where(np.isin(TIME, at), late, out.displacement)
    on = CURRENT > 0.0
    return recording(
        current=(TIME, CURRENT),
        load=(TIME[::20], load[::20]),
        temperature=(TIME, out.temperature),
        resistance=(TIME[on], out.resistance[on]),
        displacement=(TIME, x),
    )


@pytest.mark.parametrize('most', [None, 1000, 300])
def test_the_true_muscle_predicts_its_own_recording_at_any_averaging(most):
    experiment = prepare(stepped(), NOMINAL, Conditions(), most)
    predicted = experiment.predict(NOMINAL)
    # Blocks of half a second average a curve that the model shows at their middle.
    tolerance = {None: 1e-9, 1000: 2e-2, 300: 8e-2}[most]
    assert np.max(np.abs(predicted['temperature'] - experiment.observed['temperature'].value)) < tolerance
    assert (
        np.max(np.abs(predicted['displacement'] - experiment.observed['displacement'].value)) < 1e-3 * tolerance + 1e-9
    )
    assert np.max(np.abs(predicted['resistance'] - experiment.observed['resistance'].value)) < 0.1 * tolerance


@pytest.mark.parametrize(('said', 'pulls'), [('5e-1', 0.5), (0.5, 0.5), ('a brick', 0.0), (True, 0.0)])
def test_a_load_that_yaml_takes_for_a_word_is_a_load(said, pulls):
    out = simulate(NOMINAL, TIME, CURRENT, load=np.full(TIME.size, 0.5), starting_load=0.5)
    made = recording({'load_n': said}, current=(TIME, CURRENT), displacement=(TIME, out.displacement))
    experiment = prepare(made, NOMINAL)
    assert experiment.holding.starting_load == pulls
    assert any('taken as 0 N' in note for note in experiment.notes) is (pulls == 0.0)


def test_a_beginning_shows_what_the_whole_shows():
    whole = prepare(stepped(), NOMINAL)
    beginning = whole.until(50.0)
    for name, shown in beginning.predict(NOMINAL).items():
        np.testing.assert_array_equal(shown, whole.predict(NOMINAL)[name][: shown.size])
        assert 0 < shown.size < whole.observed[name].time.size


@pytest.mark.parametrize('more', [0, 1, 2, 7])
def test_a_channel_that_ended_before_the_drive_began_is_left_out(more):
    # Of a thermometer whose log ended as the current's began one or two values may lie within that, which tell nothing.
    early = np.arange(-15.0 + more, more, 1.0)
    found = simulate(NOMINAL, TIME, CURRENT)
    made = recording(
        current=(TIME + 20.0, CURRENT),
        displacement=(TIME + 20.0, found.displacement),
        temperature=(early + 20.0, np.full(early.size, NOMINAL['T0'])),
    )
    experiment = prepare(made, NOMINAL)
    assert set(experiment.observed) == {'displacement'}
    assert any(note.startswith(f'temperature: {more} values') and 'left out' in note for note in experiment.notes)
    alone = replace(made, channels={name: made[name] for name in ('current', 'temperature')})
    with pytest.raises(BadInput, match='temperature'):
        prepare(alone, NOMINAL)


def test_the_force_at_a_loaded_end_is_the_load():
    made = recording(
        current=(TIME, CURRENT), displacement=(TIME, 1e-3 * CURRENT), force=(TIME, np.full(TIME.size, 0.5))
    )
    experiment = prepare(made, NOMINAL)
    assert experiment.holding.end == 'load'
    assert np.all(experiment.imposed.load == 0.5)
    assert set(experiment.observed) == {'displacement'}


def test_a_force_that_changes_at_a_still_end_is_a_blocked_muscles():
    force = 0.3 + simulate(NOMINAL, TIME, CURRENT).displacement
    made = recording(current=(TIME, CURRENT), force=(TIME, force))
    assert prepare(made, NOMINAL).holding.end == 'blocked'


@pytest.mark.parametrize('stepped', [False, True])
def test_a_load_cell_that_reads_the_load_with_noise_holds_no_end(stepped):
    load = np.where(TIME < 60.0, 0.35, 0.5) if stepped else np.full(TIME.size, 0.35)
    cell = load + 5e-3 * np.random.default_rng(2).standard_normal(TIME.size)
    temperature = simulate(NOMINAL, TIME, CURRENT).temperature
    made = recording(
        current=(TIME, CURRENT), temperature=(TIME, temperature), force=(TIME, cell), load=(TIME[::20], load[::20])
    )
    experiment = prepare(made, NOMINAL)
    assert experiment.holding.end == 'load'
    assert set(experiment.observed) == {'temperature'}


def test_a_spring_is_recognised_and_its_rate_measured():
    out = simulate(NOMINAL, TIME, CURRENT, load=0.3, end='spring', spring_rate=40.0)
    made = recording(current=(TIME, CURRENT), displacement=(TIME, out.displacement), force=(TIME, out.force))
    experiment = prepare(made, NOMINAL)
    assert experiment.holding.end == 'spring'
    assert experiment.holding.spring_rate == pytest.approx(40.0, rel=1e-6)


def test_resistance_is_derived_from_voltage_and_current():
    on = CURRENT > 0.0
    made = recording(
        current=(TIME, CURRENT), voltage=(TIME, 14.5 * CURRENT), displacement=(TIME, CURRENT), load=(TIME, 0 * TIME)
    )
    experiment = prepare(made, NOMINAL)
    assert experiment.observed['resistance'].value == pytest.approx(np.full(int(on.sum()), 14.5))
    assert any('derived' in note for note in experiment.notes)


def sensed(level, noisy_ammeter, noisy_voltmeter):
    """A muscle whose resistance voltage and current show, with ``level`` (A) between its pulses; what it truly was."""
    current = np.where(CURRENT > 0.0, CURRENT, level)
    out = simulate(NOMINAL, TIME, current)
    noise = np.random.default_rng(7).standard_normal((2, TIME.size))
    made = recording(
        current=(TIME, current + noisy_ammeter * noise[0]),
        voltage=(TIME, current * out.resistance + noisy_voltmeter * noise[1]),
        displacement=(TIME, out.displacement),
    )
    return made, out.resistance


def test_where_no_current_flows_the_noise_of_two_meters_is_no_resistance():
    made, true = sensed(0.0, 4e-4, 3e-3)
    experiment = prepare(made, NOMINAL)
    seen = experiment.observed['resistance']
    np.testing.assert_array_equal(seen.time, TIME[CURRENT > 0.0])
    assert np.max(np.abs(seen.value - true[CURRENT > 0.0])) < 0.2
    assert np.all(seen.weight == pytest.approx(1.0, abs=0.02))
    assert any('A flowed, resistance was left out' in note for note in experiment.notes)


@pytest.mark.parametrize(('ammeter', 'voltmeter'), [(0.0, 0.0), (5e-5, 5e-4)], ids=['exact', 'quiet'])
@pytest.mark.parametrize('most', [None, 300])
def test_a_quiet_current_that_only_senses_keeps_its_readings(ammeter, voltmeter, most):
    made, true = sensed(0.012, ammeter, voltmeter)
    experiment = prepare(made, NOMINAL, most=most)
    seen = experiment.observed['resistance']
    assert most is not None or seen.time.size == TIME.size
    assert np.min(np.diff(seen.time)) > 0.04
    assert np.max(np.diff(seen.time)) < 0.6
    assert np.max(np.abs(seen.value - np.interp(seen.time, TIME, true))) < 0.4
    assert not any('left out' in note for note in experiment.notes)


def test_a_reading_weighs_by_the_current_that_it_was_taken_with():
    current = np.select([TIME < 90.0, TIME < 115.0], [0.24, 0.03], 0.0)
    noise = np.random.default_rng(7).standard_normal((2, TIME.size))
    made = recording(
        current=(TIME, current + 2e-4 * noise[0]),
        voltage=(TIME, 14.0 * current + 2e-3 * noise[1]),
        displacement=(TIME, current),
    )
    seen = prepare(made, NOMINAL, most=300).observed['resistance']
    assert seen.time[-1] < 115.0
    assert np.all(seen.weight[(seen.time < 89.0) & (seen.count == seen.count.max())] == pytest.approx(1.0, abs=0.01))
    small = (seen.time > 91.0) & (seen.time < 114.0)
    np.testing.assert_allclose(seen.weight[small], 0.16, rtol=0.2)
    assert np.mean(seen.value[small]) == pytest.approx(14.0, abs=0.03)
    half = seen.only(seen.time > 80.0)
    np.testing.assert_array_equal(half.weight, seen.weight[seen.time > 80.0])


def test_what_ripples_in_current_and_voltage_alike_hides_no_resistance():
    ripple = 1.0 + 0.1 * np.random.default_rng(7).standard_normal(TIME.size)
    current = np.where(CURRENT > 0.0, CURRENT, 0.02) * ripple
    made = recording(current=(TIME, current), voltage=(TIME, 14.0 * current), displacement=(TIME, CURRENT))
    seen = prepare(made, NOMINAL).observed['resistance']
    assert seen.value == pytest.approx(np.full(TIME.size, 14.0))
    assert np.all(seen.weight == 1.0)


def test_what_a_run_is_known_for_counts_before_what_the_user_assumes():
    made = recording({'load_n': 0.2, 'ambient_c': 20.0}, power=(TIME, CURRENT), displacement=(TIME, CURRENT))
    experiment = prepare(made, NOMINAL, Conditions(load=0.9, ambient=300.0))
    assert experiment.holding.starting_load == 0.2
    assert np.all(experiment.imposed.ambient == pytest.approx(293.15))


def test_a_room_is_read_where_a_thermometer_shows_more_than_nothing():
    made = recording(current=(TIME, CURRENT), displacement=(TIME, CURRENT), ambient=(TIME, np.full(TIME.size, 296.0)))
    assert not prepare(made, NOMINAL).imposed.unread
    unread = recording(current=(TIME, CURRENT), displacement=(TIME, CURRENT), ambient=(TIME[:0], TIME[:0]))
    assert prepare(unread, NOMINAL, Conditions(ambient=300.0)).imposed.unread
    assert prepare(recording(current=(TIME, CURRENT), displacement=(TIME, CURRENT)), NOMINAL).imposed.unread


def test_without_input_or_output_one_line_says_so():
    with pytest.raises(BadInput, match='no input recorded'):
        prepare(recording(displacement=(TIME, CURRENT)), NOMINAL)
    with pytest.raises(BadInput, match='nothing to compare'):
        prepare(recording(current=(TIME, CURRENT)), NOMINAL)


@pytest.mark.parametrize('with_force', [False, True])
def test_before_the_first_load_message_the_stated_load_pulls_or_the_force_that_was_measured(with_force):
    time = np.arange(0.0, 20.0, 0.1)
    channels = {
        'current': Channel('current', time, np.where(time > 5.0, 0.2, 0.0), 'current'),
        'displacement': Channel('displacement', time, 1e-3 * time, 'displacement'),
        'load': Channel('load', np.array([3.0, 9.0]), np.array([1.0, 0.5]), 'load'),
    }
    if with_force:
        force = np.where(time < 3.0, 0.6, np.where(time < 9.0, 1.0, 0.5))
        channels['force'] = Channel('force', time, force, 'force')
    stated = None if with_force else Conditions(load=0.6)
    imposed = prepare(Recording('bag', channels, 0, {'end': 'load'}), NOMINAL, stated).imposed
    at = np.searchsorted(imposed.time, [0.0, 2.0, 4.0, 10.0])
    assert imposed.load[at] == pytest.approx([0.6, 0.6, 1.0, 0.5])


def test_a_load_message_that_came_late_is_put_right_by_the_force():
    time = np.arange(0.0, 20.0, 0.1)
    force = np.where(time < 9.0, 1.0, 0.5)
    channels = {
        'current': Channel('current', time, np.where(time > 5.0, 0.2, 0.0), 'current'),
        'displacement': Channel('displacement', time, 1e-3 * time, 'displacement'),
        'load': Channel('load', np.array([0.0, 9.4]), np.array([1.0, 0.5]), 'load'),
        'force': Channel('force', time, force, 'force'),
    }
    known = {'end': 'load'}
    imposed = prepare(Recording('bag', channels, 0, known), NOMINAL).imposed
    assert imposed.load[np.searchsorted(imposed.time, [8.85, 9.05, 9.25])] == pytest.approx([1.0, 0.5, 0.5])
    noisy = force + 0.01 * np.random.default_rng(1).normal(size=time.size)
    channels['force'] = Channel('force', time, noisy, 'force')
    imposed = prepare(Recording('bag', channels, 0, known), NOMINAL).imposed
    assert imposed.load[np.searchsorted(imposed.time, [8.85, 9.25, 9.45])] == pytest.approx([1.0, 1.0, 0.5])


@pytest.mark.parametrize('weights', [(0.69, 0.59, 0.69, 0.69, 0.69), (0.3, 1.2), (0.98, 0.95, 0.5)])
def test_a_load_that_is_written_down_beside_every_sample_steps_where_it_says(weights):
    load = np.repeat(weights, -(-TIME.size // len(weights)))[: TIME.size]
    made = recording(current=(TIME, CURRENT), displacement=(TIME, 1e-3 * CURRENT - 0.02 * load), force=(TIME, load))
    imposed = prepare(made, NOMINAL, most=500).imposed
    steps = imposed.time[1:][np.diff(imposed.load) != 0.0]
    assert steps == pytest.approx(TIME[1:][np.diff(load) != 0.0])
    assert imposed.load[[0, -1]] == pytest.approx([weights[0], weights[-1]])


def test_a_measured_force_is_the_load_without_its_noise():
    """A load cell's noise is no change of the load, after which the muscle would have to be seen sample by sample."""
    rng = np.random.default_rng(2)
    load = np.where(TIME < 70.0, 0.3, 0.9)
    noisy = load + 1e-3 * rng.standard_normal(TIME.size)
    made = recording(
        {'end': 'load'}, current=(TIME, CURRENT), force=(TIME, noisy), displacement=(TIME, 1e-3 * CURRENT - 0.02 * load)
    )
    experiment = prepare(made, NOMINAL, most=300)
    levels = np.unique(experiment.imposed.load)
    assert levels == pytest.approx([0.3, 0.9], abs=2e-4)
    assert experiment.holding.starting_load == pytest.approx(0.3, abs=2e-4)
    assert experiment.observed['displacement'].time.size < 400


def test_a_load_that_is_stated_of_a_held_muscle_is_what_it_started_from():
    force = simulate(NOMINAL, TIME, CURRENT, load=0.6, end='blocked').force
    made = recording({'load_n': 0.6}, current=(TIME, CURRENT), force=(TIME, force))
    experiment = prepare(made, NOMINAL)
    assert (experiment.holding.end, experiment.holding.starting_load) == ('blocked', 0.6)
    assert 'force' in experiment.observed
    assert not any('no load' in note for note in experiment.notes)


def test_where_a_fit_looks_at_a_muscle_that_cannot_be_it_sees_no_number_and_goes_on():
    """Blocked force tells little of what is held: a law was tried that shortens it by more than there is."""
    force = simulate(NOMINAL, TIME, CURRENT, load=0.6, end='blocked').force
    held = prepare(recording({'load_n': 0.6}, current=(TIME, CURRENT), force=(TIME, force)), NOMINAL)
    nothing = basis('free_stroke', 0.0, 2.0, 'force', 2).on(NOMINAL, [-0.2, -0.2])
    shown = held.predict(nothing)['force']
    assert shown.shape == held.observed['force'].value.shape
    assert np.all(np.isnan(shown))
    assert np.all(np.isfinite(held.predict(NOMINAL)['force']))


def test_a_held_muscle_of_which_no_load_is_stated_started_from_the_tension_at_rest():
    current = np.where(TIME < 5.0, 0.0, CURRENT)
    force = simulate(NOMINAL, TIME, current, load=0.5, end='blocked', starting_load=0.5).force
    noise = 2e-3 * np.random.default_rng(1).standard_normal(TIME.size)
    made = prepare(recording({'end': 'blocked'}, current=(TIME, current), force=(TIME, force + noise)), NOMINAL)
    assert made.holding.starting_load == pytest.approx(0.5, abs=1e-3)
    missed = made.observed['force'].value - made.predict(NOMINAL)['force']
    assert np.std(missed) < 1.1 * np.std(noise)
    assert any('the tension before the drive comes on; state load_n' in note for note in made.notes)
    tared = recording({'end': 'blocked'}, current=(TIME, current), force=(TIME, force - 0.5 + noise))
    assert prepare(tared, NOMINAL).holding.starting_load == 0.0


@pytest.mark.parametrize('first', [0.0, 0.04])
def test_a_load_that_was_recorded_from_the_start_counts_before_what_the_user_assumes(first):
    """A muscle that creeps would begin to, under the assumed load, and did not."""
    creeps = NOMINAL.with_effects('creep').replace({'creep.J': 0.15, 'creep.tau50': 30.0})
    out = simulate(creeps, TIME, CURRENT, load=0.588, starting_load=0.588)
    told = TIME[::20] + first
    made = recording(current=(TIME, CURRENT), load=(told, np.full(told.size, 0.588)),
                     displacement=(TIME, out.displacement))  # fmt: skip
    experiment = prepare(made, NOMINAL, Conditions(load=0.294))
    assert experiment.holding.starting_load == 0.588 and set(experiment.imposed.load) == {0.588}
    missed = experiment.observed['displacement'].value - experiment.predict(creeps)['displacement']
    assert np.std(missed) < 2e-6


def test_a_load_told_at_every_tick_has_the_steps_it_takes():
    rng = np.random.default_rng(3)
    load = np.where(TIME < 70.0, 0.3, 0.9)
    made = recording(
        {'end': 'load', 'load_n': 0.3},
        current=(TIME, CURRENT),
        load=(TIME, load),
        force=(TIME, load + 1e-3 * rng.standard_normal(TIME.size)),
        displacement=(TIME, 1e-3 * CURRENT - 0.02 * load),
    )
    experiment = prepare(made, NOMINAL, most=300)
    assert set(np.unique(experiment.imposed.load)) == {0.3, 0.9}
    assert experiment.observed['displacement'].time.size < 400


@pytest.mark.parametrize('noise', [0.0, 2e-3], ids=['exact', 'noisy'])
def test_no_block_reaches_across_a_switch_or_over_a_gap(noise):
    """Resistance is read under current only: what would stand between two heatings was never read. An ammeter's noise
    makes the current change at every sample."""
    read = CURRENT + noise * np.random.default_rng(6).standard_normal(TIME.size)
    on = CURRENT > 0.0
    made = recording(current=(TIME, read), resistance=(TIME[on], 10.0 + TIME[on]), displacement=(TIME, CURRENT))
    observed = prepare(made, NOMINAL, most=97).observed
    resistance = observed['resistance']
    assert resistance.time.size < 1.5 * 97
    assert np.all(np.interp(resistance.time, TIME, CURRENT) == 0.24)
    np.testing.assert_allclose(resistance.value, 10.0 + resistance.time)
    assert set(np.round(observed['displacement'].value, 9)) == {0.0, 0.24}


@pytest.mark.parametrize('size', [4e-4, 0.0], ids=['swings', 'still'])
def test_what_swings_after_a_switch_is_not_averaged_away(size):
    """A weight that hangs on the muscle rings where the current is switched, faster than blocks show."""
    since = np.mod(TIME, 70.0) - np.where(np.mod(TIME, 70.0) < 25.0, 0.0, 25.0)
    ringing = size * np.exp(-since / 2.0) * np.sin(2.0 * np.pi * 2.5 * since)
    read = simulate(NOMINAL, TIME, CURRENT).displacement + ringing
    read += 2e-5 * np.random.default_rng(6).standard_normal(TIME.size)
    observed = prepare(recording(current=(TIME, CURRENT), displacement=(TIME, read)), NOMINAL, most=300).observed
    seen = observed['displacement']
    after = (seen.time > 25.1) & (seen.time < 26.0)
    assert bool(np.max(np.diff(seen.time[after])) < 0.06) is bool(size)
    assert (seen.swinging is not None and bool(np.all(seen.swinging[after]))) is bool(size)
    assert seen.time.size < 600


def test_a_load_that_changes_all_the_time_is_averaged_with_the_rest():
    load = 0.6 + 0.3 * np.sin(2.0 * np.pi * TIME / 30.0)
    made = recording(current=(TIME, CURRENT), load=(TIME, load), displacement=(TIME, 1e-3 * CURRENT - 0.02 * load))
    experiment = prepare(made, NOMINAL, most=300)
    assert experiment.observed['displacement'].time.size < 400


def test_where_the_source_holds_a_power_that_is_what_drives():
    power = np.where(np.mod(TIME, 70.0) < 25.0, 0.9, 0.002)
    out = simulate(NOMINAL, TIME, power, kind='power')
    current = np.sqrt(power / out.resistance)
    noise = np.random.default_rng(4).standard_normal((2, TIME.size))
    made = recording(
        current=(TIME, current + 1e-4 * noise[0]),
        voltage=(TIME + 2e-5, current * out.resistance + 1e-3 * noise[1]),
        displacement=(TIME, out.displacement),
    )
    experiment = prepare(made, NOMINAL)
    assert experiment.imposed.kind == 'power'
    levels = experiment.imposed.drive[np.append(True, np.diff(experiment.imposed.drive) != 0.0)]
    assert levels.size == np.count_nonzero(np.diff(power)) + 1
    np.testing.assert_allclose(levels, np.where(np.arange(levels.size) % 2 == 0, 0.9, 0.002), atol=2e-4)
    held = recording(
        current=(TIME, CURRENT), voltage=(TIME, CURRENT * out.resistance), displacement=(TIME, out.displacement)
    )
    assert prepare(held, NOMINAL).imposed.kind == 'current'


@pytest.mark.parametrize(
    ('shown', 'said'),
    [
        (np.zeros(TIME.size), 'shows no voltage, though a current flows'),  # a voltmeter that is not connected
        (np.full(TIME.size, 12.0), 'shows a voltage where no current flows'),  # of the supply
        (12.0 - 3.0 * (CURRENT > 0.0), 'shows a voltage where no current flows'),
    ],
    ids=['none', 'supply', 'supply under load'],
)
@pytest.mark.parametrize('step', [1, 20])
def test_a_voltage_that_is_not_across_the_muscle_neither_drives_it_nor_shows_its_resistance(shown, said, step):
    noise = np.random.default_rng(4).standard_normal(TIME.size)
    made = recording(
        current=(TIME, CURRENT + 1e-3 * noise),
        voltage=(TIME[::step] + 0.02, shown[::step]),
        displacement=(TIME, simulate(NOMINAL, TIME, CURRENT).displacement),
    )
    experiment = prepare(made, NOMINAL)
    assert experiment.imposed.kind == 'current' and list(experiment.observed) == ['displacement']
    assert [note for note in experiment.notes if said in note]
    assert experiment.fingerprint == made.fingerprint


def test_a_sample_without_a_current_says_nothing_of_a_voltage():
    """An ammeter that is a sample late shows none at the beginning of a run that has no rest."""
    assert not_across(np.full(1000, 3.0), np.append(0.0, np.full(999, 0.2))) == ''
    assert not_across(np.full(1000, 3.0), np.append(np.zeros(50), np.full(950, 0.2))) != ''


@pytest.mark.parametrize('logged', ['apart', 'where it changes', 'sensing'])
def test_a_voltage_across_the_muscle_shows_its_resistance_however_the_current_was_logged(logged):
    current = np.where(CURRENT > 0.0, CURRENT, 0.004 if logged == 'sensing' else 0.0)
    out = simulate(NOMINAL, TIME, current)
    at = np.append(0, np.flatnonzero(np.diff(current)) + 1) if logged == 'where it changes' else np.arange(TIME.size)
    made = recording(
        current=(TIME[at] - (0.02 if logged == 'apart' else 0.0), current[at]),
        voltage=(TIME, current * out.resistance),
        displacement=(TIME, out.displacement),
    )
    experiment = prepare(made, NOMINAL)
    assert set(experiment.observed) == {'displacement', 'resistance'}
    assert experiment.imposed.kind == 'current'
    assert_shows(out.resistance, experiment)


def assert_shows(resistance, experiment):
    seen = experiment.observed['resistance']
    np.testing.assert_allclose(seen.value, np.interp(seen.time, TIME, resistance), rtol=1e-2)


PULSED = {
    'on and off': np.where(np.mod(TIME, 70.0) < 25.0, 0.24, 0.0),
    'two levels': np.where(np.mod(TIME, 70.0) < 25.0, 0.27, 0.05),
    'as long on as off': np.where(np.mod(TIME, 20.0) < 10.0, 0.27, 0.05),
    'short': np.where(np.mod(TIME, 10.0) < 2.0, 0.3, 0.0),
    'stairs': 0.2 + 0.1 * np.sin(2.0 * np.pi * np.floor(TIME / 2.0) / 30.0),
}
CHANGES_ONLY = ['at its changes', 'early', 'late', 'and now and then']


def logged_by_changes(value, how):
    """As a sparse column or a topic that is sent on change has it; also with what is sent in between all the same."""
    at = np.append(0, np.flatnonzero(np.diff(value)) + 1)
    if how == 'and now and then':
        at = np.union1d(at, np.arange(0, TIME.size, 200))
    late = {'early': -0.03, 'late': 0.03}.get(how, 0.0)
    return TIME[at] + np.where(at > 0, late, 0.0), value[at]


@pytest.mark.parametrize('how', CHANGES_ONLY)
@pytest.mark.parametrize('level', PULSED.values(), ids=list(PULSED))
def test_a_current_that_was_logged_where_it_changes_holds_until_the_next_change(level, how):
    out = simulate(NOMINAL, TIME, level)
    noise = 1e-3 * np.random.default_rng(4).standard_normal(TIME.size)
    made = recording(
        current=logged_by_changes(level, how),
        voltage=(TIME, level * out.resistance + noise),
        displacement=(TIME, out.displacement),
    )
    experiment = prepare(made, NOMINAL)
    assert experiment.imposed.kind == 'current'
    assert_shows(out.resistance, experiment)
    # Where a current flows, the edges alone are left out.
    edges = np.count_nonzero(np.diff(level))
    assert experiment.observed['resistance'].time.size >= np.count_nonzero(level) - 2 * edges - 2


@pytest.mark.parametrize('how', CHANGES_ONLY)
def test_a_voltage_that_was_logged_where_it_changes_holds_until_the_next_change(how):
    """A source that holds a voltage: the current changes with the resistance, and was sampled."""
    level = np.where(np.mod(TIME, 20.0) < 10.0, 3.5, 0.7)
    out = simulate(NOMINAL, TIME, level, kind='voltage')
    noise = 1e-4 * np.random.default_rng(4).standard_normal(TIME.size)
    made = recording(
        current=(TIME, level / out.resistance + noise),
        voltage=logged_by_changes(level, how),
        displacement=(TIME, out.displacement),
    )
    experiment = prepare(made, NOMINAL)
    assert experiment.imposed.kind == 'voltage'
    assert_shows(out.resistance, experiment)
    assert experiment.observed['resistance'].time.size > 0.9 * TIME.size


@pytest.mark.parametrize(
    ('first', 'noise'), [(0, 1e-3), *((first, noise) for first in (3, 7, 13, 17) for noise in (0.0, 1e-3))]
)
@pytest.mark.parametrize('slow', ['current', 'voltage'])
def test_a_slow_instrument_reads_and_does_not_hold(slow, noise, first):
    """One value a second of its own rhythm, beside twenty: until the next it says nothing of an edge."""
    out = simulate(NOMINAL, TIME, PULSED['two levels'])
    read = {'current': PULSED['two levels'], 'voltage': PULSED['two levels'] * out.resistance}
    scatter = noise * np.random.default_rng(4).standard_normal((2, TIME.size))
    channels = {
        name: Channel(name, TIME, value + part, name) for (name, value), part in zip(read.items(), scatter, strict=True)
    }
    whole = channels[slow]
    channels[slow] = replace(whole, time=whole.time[first::20], value=whole.value[first::20])
    assert beside(channels['voltage'], channels['current']) == (channels['voltage'], channels['current'])


def test_a_muscle_is_followed_through_its_recordings_as_they_were_made(monkeypatch):
    days = [replace(stepped(), path=str(day), start_ns=UNDATED_NS + day * DAY_NS) for day in (3, 1, 2)]
    found = [e.name for e in admitted(days, ParameterFile(NOMINAL), 300)]
    assert found == ['1', '2', '3']

    def stopped(experiments, *_, **__):
        raise KeyboardInterrupt(*[e.name for e in experiments])

    monkeypatch.setattr('tcp_muscle_ros.diagnosis.diagnose.diagnose', stopped)
    with pytest.raises(KeyboardInterrupt) as order:
        diagnosed(days, ParameterFile(NOMINAL))
    assert list(order.value.args) == found


def test_a_wattmeter_that_reads_noise_about_zero_heats_nothing_there():
    power = np.where(CURRENT > 0.0, 1.2, 0.0)
    out = simulate(NOMINAL, TIME, power, kind='power', load=np.full(TIME.size, 0.5), starting_load=0.5)
    read = power + 2e-3 * np.random.default_rng(4).standard_normal(TIME.size)
    made = recording({'load_n': 0.5}, power=(TIME, read), temperature=(TIME, out.temperature))
    shown = prepare(made, NOMINAL).predict(NOMINAL)['temperature']
    assert np.sqrt(np.mean((shown - out.temperature) ** 2)) < 0.05

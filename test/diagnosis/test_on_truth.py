"""The whole diagnosis on bags of the independent truth generator: nothing concealed, physics, a sensor."""

import pytest
from diagnosis.truth import recordings

from proof.cases import make_case
from proof.generate import write_case
from proof.tool import diagnose_case
from tcp_muscle_ros.diagnosis.diagnose import diagnose
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.fitting.forms import allowing_forms
from tcp_muscle_ros.diagnosis.fitting.slips import slipped
from tcp_muscle_ros.diagnosis.fitting.weighing import calmed, settle_noise
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.diagnosis.search.candidates import screen
from tcp_muscle_ros.diagnosis.search.company import confirm
from tcp_muscle_ros.diagnosis.search.holdout import Gain, stretches
from tcp_muscle_ros.diagnosis.search.refitting import rivals_for
from tcp_muscle_ros.diagnosis.search.rivals import begins
from tcp_muscle_ros.muscle import Parameters

NOMINAL = Parameters.named('karami_tadesse_2017')
# Seeds of their own: the development suite is tuned on others.
SEED = 4711


def recorded(folder, number, kind, what, seed=SEED, suite='development', change=None, most=800):
    found = recordings(folder, suite, seed, number, kind, what, change)
    return [prepare(recording, NOMINAL, most=most) for recording in found]


@pytest.fixture
def diagnosed(tmp_path):
    return lambda *case, **how: diagnose(recorded(tmp_path, *case, **how), NOMINAL)


@pytest.mark.slow
def test_no_physics_is_found_where_none_is_concealed(diagnosed):
    found = diagnosed(0, 'null', '')
    assert found.verdict in ('match', 'wrong_parameters')
    assert found.findings == ()
    assert found.unexplained is None


@pytest.mark.long
def test_a_laser_that_is_late_is_no_second_node(diagnosed):
    """The suites' own decoy is a late thermometer."""

    def late_laser(case):
        case.bench.delay['displacement'] = case.bench.delay.pop('temperature')

    found = diagnosed(4, 'decoy', 'clock_skew', 5150, change=late_laser)
    assert [f.effect for f in found.findings] == ['clock_skew']
    assert found.findings[0].parameters['channel'].value == 1.0


@pytest.mark.long
def test_a_thermometer_that_is_off_by_another_amount_each_time_is_a_sensor(diagnosed):
    found = diagnosed(54, 'decoy', 'temperature_offset', 11, 'varied')
    assert [f.effect for f in found.findings] == ['temperature_offset']


@pytest.mark.long
def test_a_thermometer_that_shows_the_current_is_no_second_node(diagnosed):
    found = diagnosed(7, 'decoy', 'thermocouple_pickup', 5152)
    assert [f.effect for f in found.findings] == ['thermocouple_pickup']
    assert 'pickup_k_per_a' in found.rig.instruments['temperature']


@pytest.mark.long
def test_a_resistance_that_bends_with_the_current_is_a_contact_that_it_lowers(diagnosed):
    """And not one that is read late, which it resembles."""
    found = diagnosed(101, 'unlisted', 'varistor', 701)
    assert found.findings[0].effect == 'contact_resistance'
    assert 'clock_skew' not in [f.effect for f in found.findings]


@pytest.mark.long
def test_what_the_misfit_of_another_effect_shows_as_slips_is_no_slip(diagnosed):
    found = diagnosed(76, 'single', 'shear_softening', 701)
    assert [f.effect for f in found.findings] == ['shear_softening']


@pytest.mark.long
@pytest.mark.slow
def test_the_course_of_gusts_is_inferred_where_one_gust_is_not_the_weather(tmp_path):
    calibrated, _ = settle_noise(calibrate(recorded(tmp_path, 5, 'single', 'airflow'), NOMINAL).fit)
    (named,) = rivals_for(calibrated, screen(calibrated, ['airflow'])[0], None)
    followed = allowing_forms(named.fit, ['airflow'])
    for channel in ('temperature', 'displacement'):
        left = [one.mean_square[channel] ** 0.5 for one in (calibrated, named.fit, followed)]
        assert left[0] > left[1] > 3.0 * left[2], (channel, left)


@pytest.mark.long
def test_one_swing_above_the_unloaded_length_does_not_spoil_the_phase_of_the_others(tmp_path):
    """The generator's coil pushes as it pulls."""

    def one_alone(case):
        case.experiments = case.experiments[1:2]

    steps_of_the_load = recorded(tmp_path, 361, 'double', '', 1009, change=one_alone)
    calibrated = in_turn(calibrate(steps_of_the_load, NOMINAL).fit)
    ranked, _ = screen(calibrated, ['inertia'])
    values = rivals_for(calibrated, ranked, None)[0].fit.values
    assert values['inertia.b', None] == pytest.approx(1.0, abs=0.01)
    assert values['inertia.zeta', None] == pytest.approx(0.03, abs=0.006)
    assert values['inertia.q', None] > 0.9


@pytest.mark.long
def test_a_swing_is_not_dropped_because_recordings_that_hardly_show_it_outvote_the_others(tmp_path, monkeypatch):
    """What a swing leaves weighs little once it is found; the votes are those of nine recordings, two of which showed
    one. Any other effect goes."""

    def one_alone(case):
        case.experiments = case.experiments[1:2]

    calibrated = in_turn(calibrate(recorded(tmp_path, 361, 'double', '', 1009, change=one_alone), NOMINAL).fit)
    outvoted = Gain(total=863.0, chance=115.0, scatter=410.0, folds=0.5, say=7)
    assert outvoted.fails and not outvoted.holds
    monkeypatch.setattr(
        'tcp_muscle_ros.diagnosis.search.company.confirmation', lambda _, after: (outvoted, stretches(after.problem))
    )
    for effect, kept in (('inertia', ['inertia']), ('friction', [])):
        (rival,) = rivals_for(calibrated, screen(calibrated, [effect])[0], None)
        assert begins(rival), effect
        _, accepted, _, _ = confirm(rival.fit, [effect], {effect: (100.0, [rival])}, calibrated)
        assert accepted == kept


@pytest.mark.slow
def test_sudden_slips_are_named_and_leave_their_mean_to_the_better_muscle(diagnosed):
    found = diagnosed(6, 'single', 'torsional_leakage')
    assert [f.effect for f in found.findings] == ['torsional_leakage']
    assert 'torsional_leakage' in found.improved.effects
    fit = found.fit['displacement']
    assert fit.improved < 0.3 * fit.calibrated
    assert any('slipped suddenly' in note for note in found.notes)


@pytest.mark.long
def test_slips_that_a_swing_hides_show_once_it_is_found(tmp_path):
    recordings = recorded(tmp_path, 207, 'double', '', 1009)[1:3]
    calibrated = in_turn(calibrate(recordings, NOMINAL).fit)
    ranked, _ = screen(calibrated, ['inertia'])
    swinging = rivals_for(calibrated, ranked, None)[0].fit
    found = slipped(calmed(swinging, swinging))
    assert slipped(calibrated) is None
    assert found is not None
    assert len(found.problem.slips) >= 4


@pytest.mark.long
def test_a_draught_keeps_its_name_where_runs_of_one_protocol_differ(tmp_path):
    """A law of the muscle's state bends to a swinging fan, and would have the same in both runs of the protocol."""
    case = make_case('varied', 9301, 27, 'single', 'airflow')
    write_case(case, tmp_path)
    found = diagnose_case(tmp_path / case.name, tmp_path / 'reports', 1000)
    assert [f.effect for f in found.findings] == ['airflow']


@pytest.mark.long
def test_a_heat_capacity_may_rise_beyond_the_temperatures_that_were_reached(diagnosed):
    """Chains that thaw: the listed rise follows it with its middle above all temperatures, and its width below."""
    found = diagnosed(35, 'single', 'heat_capacity', 9301, 'varied')
    assert [f.effect for f in found.findings] == ['heat_capacity']

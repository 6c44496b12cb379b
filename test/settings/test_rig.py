"""rig.yaml: read, refused with the key and the nearest one, written and read back."""

import pytest

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import EFFECTS, Parameters
from tcp_muscle_ros.settings.rig import (
    INSTRUMENTS,
    Quantity,
    Rig,
    RigLimits,
    beside,
    from_effects,
    on_rig,
    read_rig,
    render_rig,
)


def written(tmp_path, text):
    path = tmp_path / 'rig.yaml'
    path.write_text(text)
    return path


def test_a_file_says_what_instruments_do_and_what_the_rig_can_do(tmp_path):
    rig = read_rig(
        written(
            tmp_path,
            'instruments:\n  temperature: {lag_s: {value: 1.2, low: 1.0, high: 1.5}, gain: 0.96}\n'
            '  current: {gain: 0.8}\nlimits: {largest_current_a: 0.2, loads_n: [0.6, 3e-1], loads_by: rig,'
            ' held_end: true}\n',
        )
    )
    assert rig.instruments['temperature']['lag_s'] == Quantity(1.2, 1.0, 1.5)
    assert rig.limits == RigLimits(0.2, 373.15, (0.3, 0.6), by_person=False, held_end=True)
    assert rig.sensor_effects() == {
        'thermocouple_lag.tau': 1.2,
        'thermocouple_gain.g': 0.96,
        'current_gain.g': 1.25,
        'current_gain.z': 0.0,
        'current_gain.ohms': 0.0,
    }


def test_an_empty_file_of_limits_is_a_rig_without_faults_and_with_the_usual_limits(tmp_path):
    assert read_rig(written(tmp_path, 'limits: {}\n')) == Rig()


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        ('instrument: {}', "unknown key 'instrument'; did you mean 'instruments'?"),
        ('instruments: {temprature: {lag_s: 1}}', "did you mean 'temperature'?"),
        ('instruments: {temperature: {lag: 1}}', "unknown key 'lag'; did you mean 'lag_s'?"),
        ('instruments: {temperature: {lag_s: 99}}', 'lag_s is 99, expected 0 to 30 s'),
        ('instruments: {temperature: {lag_s: {value: 1, low: 2}}}', 'low 2, value 1, high 1; expected in this order'),
        ('instruments: {temperature: {lag_s: {low: 2}}}', "'value' is missing"),
        ('limits: {largest_current: 1}', "did you mean 'largest_current_a'?"),
        ('limits: {largest_current_a: -1}', 'expected 0 to 100 A'),
        ('limits: {loads_n: 3}', 'expected a list of forces'),
        ('limits: {loads_n: [-1]}', 'loads_n has -1'),
        ('limits: {held_end: maybe}', 'true or false'),
        ('limits: {loads_by: nobody}', "'loads_by' is 'nobody'; known: person, rig"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, text, expected):
    with pytest.raises(BadInput) as refused:
        read_rig(written(tmp_path, text + '\n'))
    assert expected in str(refused.value)
    assert '\n' not in str(refused.value)
    assert 'rig.yaml' in str(refused.value)


def test_what_is_written_is_read_back(tmp_path):
    rig = Rig(
        {'temperature': {'lag_s': Quantity(1 / 3, 0.3, 0.4)}, 'force': {'delay_s': Quantity(0.1, 0.1, 0.1)}},
        RigLimits(0.123, 390.0, (0.1, 0.7), by_person=False, held_end=True, longest_run=77.0),
    )
    assert read_rig(written(tmp_path, render_rig(rig, 'two\nlines'))) == rig


def test_every_sensor_effect_that_an_instrument_can_be_is_a_key_and_comes_back():
    found = {
        'thermocouple_lag.tau': Quantity(2.0, 1.0, 3.0),
        'current_gain.g': Quantity(1.25, 1.0, 2.0),
        'clock_skew.d': Quantity(0.2, 0.1, 0.3),
    }
    rig = from_effects(found, channel='displacement')
    assert rig.instruments['current']['gain'] == Quantity(0.8, 0.5, 1.0)
    values = rig.sensor_effects()
    assert values['clock_skew.channel'] == 1.0
    assert {name: values[name] for name in found} == {name: quantity.value for name, quantity in found.items()}
    Parameters(values, tuple({name.partition('.')[0] for name in values}))  # the model takes them
    with pytest.raises(BadInput, match='no property of an instrument'):
        from_effects({'creep.J': Quantity(1.0, 1.0, 1.0)})
    effects = {row.effect.partition('.')[0] for rows in INSTRUMENTS.values() for row in rows.values() if row.effect}
    assert effects == {name for name, one in EFFECTS.items() if one.stage == 'sensor'} - {'displacement_drift'}


@pytest.mark.parametrize('left', ['offset_a: 0.002', 'ohms_apart: 1'])
def test_what_is_left_out_of_an_instrument_shows_the_truth(tmp_path, left):
    rig = read_rig(written(tmp_path, f'instruments: {{current: {{{left}}}}}\n'))
    muscle = on_rig(Parameters.named('karami_tadesse_2017').replace({'current_gain.g': 0.9}), rig)
    assert 'current_gain' in muscle.effects and muscle['current_gain.g'] == 1.0


def test_what_was_known_and_not_fitted_keeps_its_interval():
    known = Rig({'temperature': {'lag_s': Quantity(2.0, 1.0, 3.0), 'gain': Quantity(0.9, 0.8, 1.0)}})
    found = Rig({'temperature': {'lag_s': Quantity(2.0, 2.0, 2.0), 'gain': Quantity(0.95, 0.94, 0.96)}})
    both = beside(known, found).instruments['temperature']
    assert both == {'lag_s': Quantity(2.0, 1.0, 3.0), 'gain': Quantity(0.95, 0.94, 0.96)}


def test_two_late_clocks_are_more_than_the_model_has():
    late = {'delay_s': Quantity(0.1, 0.1, 0.1)}
    with pytest.raises(BadInput, match='temperature and force'):
        Rig({'temperature': late, 'force': late}).sensor_effects()

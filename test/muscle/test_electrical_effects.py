"""What each effect on the current, the resistance and the sensors is: its equation written out, or solved."""

from math import exp

import numpy as np
import pytest
from muscle.effect_runs import NOMINAL, PULSE, assert_same, baseline, contraction, e0, model, ohms, protocol, solve

from tcp_muscle_ros.muscle import Parameters, simulate


def test_lags_solve_their_equations():
    def bead(t, y, i, load):
        return [(i**2 * ohms(y[0]) - 0.01933 * (y[0] - 296.15)) / 0.17, (y[0] - y[1]) / 2.0]

    kelvin, shown = solve(bead, [296.15, 296.15], PULSE)
    assert_same(model('thermocouple_lag', PULSE), kelvin, contraction(kelvin), shown)

    def supply(t, y, i, load):
        return [(y[1] ** 2 * ohms(y[0]) - 0.01933 * (y[0] - 296.15)) / 0.17, (i - y[1]) / 0.5]

    kelvin, _ = solve(supply, [296.15, 0.0], PULSE)
    run = model('supply_lag', PULSE)
    assert_same(run, kelvin, contraction(kelvin))
    assert run.current[0] == 0.27 and run.power[0] == 0.0  # the display shows the setting, the muscle gets nothing yet

    for loop, inertia in ((1.0, 0.25), (2.0, 0.6)):

        def second(t, y, i, load, inertia=inertia):
            return [
                (y[1] ** 2 * ohms(y[0]) - 0.01933 * (y[0] - 296.15)) / 0.17,
                y[2],
                (i - y[1] - 0.5 * y[2]) / (inertia * 0.25),
            ]

        kelvin, *_ = solve(second, [296.15, 0.0, 0.0], PULSE)
        assert_same(model('supply_lag', PULSE, {'loop': loop}), kelvin, contraction(kelvin))


def test_a_supply_of_power_that_overshoots_takes_none_back():
    muscle = NOMINAL.with_effects('supply_lag').replace({'supply_lag.tau': 0.6, 'supply_lag.loop': 2.0})
    time = np.arange(0.0, 30.0, 0.05)
    run = simulate(muscle, time, np.where((time > 1.0) & (time < 15.0), 0.8, 0.0), kind='power', load=0.5)
    assert run.current[(time > 5.0) & (time < 15.0)].min() > 0.2  # it heats
    assert np.isfinite(run.current).all() and run.current.min() == 0.0


def test_effects_of_the_resistance_solve_their_equations():
    rest = 0.15 + 0.5884 / 23.0
    for name, ohm in (
        ('tcr_curvature', lambda t, T, H: 14.0 * (1.0 + 0.003 * (T - 296.15) - 4e-6 * (T - 296.15) ** 2)),
        ('contact_shorting', lambda t, T, H: ohms(T) * (1.0 - 0.1 / (1.0 + exp((H - 0.087) / 0.005)))),
        ('resistance_drift', lambda t, T, H: ohms(T) * (1.0 + 1e-4 * t)),
        ('resistance_strain', lambda t, T, H: ohms(T) * (1.0 + 0.15 * (H - 0.15) / 0.15)),
    ):

        def rates(t, y, i, load, ohm=ohm):
            length = rest - contraction(y[0])
            return [(i**2 * ohm(t, y[0], length) - 0.01933 * (y[0] - 296.15)) / 0.17]

        (kelvin,) = solve(rates, [296.15], PULSE)
        run = model(name, PULSE)
        assert_same(run, kelvin, contraction(kelvin))
        expected = [ohm(t, T, rest - contraction(T)) for t, T in zip(run.time, kelvin, strict=True)]
        assert run.resistance == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize('curvature', [-3.0, 9e-4, 2.0])
def test_resistance_follows_strain_with_a_curvature(curvature):
    time, on = protocol(20.0, 40.0)
    muscle = NOMINAL.replace({'resistance_strain.n': curvature, 'resistance_strain.GF': 0.4})
    run = simulate(muscle.with_effects('resistance_strain'), time, 0.27 * on, load=0.5884)
    strain = (run.length - 0.15) / 0.15
    law = 1.0 + 0.4 * (np.exp(curvature * strain) - 1.0) / curvature
    assert run.resistance == pytest.approx(ohms(run.temperature) * law, rel=1e-8)


@pytest.mark.parametrize(('kind', 'drive'), [('current', 0.27), ('power', 1.02), ('voltage', 4.4)])
def test_contact_resistance_is_in_series(kind, drive):
    time, on = protocol(20.0, 40.0)
    run = simulate(NOMINAL.with_effects('contact_resistance'), time, drive * on, kind=kind, load=0.5884)
    hot = on & (time > 0)
    assert run.resistance - 0.5 == pytest.approx(ohms(run.temperature), abs=1e-9)
    assert run.voltage[hot] / run.current[hot] == pytest.approx(run.resistance[hot])
    assert run.power[hot] == pytest.approx(run.current[hot] * run.voltage[hot])
    released = np.sum((run.power * (1.0 - 0.5 / run.resistance))[:-1] * np.diff(time))
    assert run.heated == pytest.approx(released, rel=5e-3)  # rectangles over 50 ms


@pytest.mark.parametrize(('kind', 'drive'), [('current', 0.27), ('power', 1.02), ('voltage', 4.4)])
def test_a_contact_conducts_better_the_more_current_it_carries(kind, drive):
    time, on = protocol(20.0, 40.0)
    muscle = NOMINAL.replace({
        'contact_resistance.Rc': 2.0, 'contact_resistance.falls': 1.0, 'contact_resistance.b': 20.0,
    })  # fmt: skip
    run = simulate(muscle.with_effects('contact_resistance'), time, drive * on, kind=kind, load=0.5884)
    contact = run.resistance - ohms(run.temperature)
    assert contact == pytest.approx(2.0 / (1.0 + 20.0 * run.current**2), rel=1e-5)
    assert contact.max() == pytest.approx(2.0) and contact.min() < 1.2


@pytest.mark.parametrize('zero', [0.0, 0.004, -0.004])
@pytest.mark.parametrize(('kind', 'drive'), [('current', 0.27), ('power', 1.02), ('voltage', 4.4)])
def test_current_gain_is_in_what_the_ammeter_shows(kind, drive, zero):
    time, on = protocol(20.0, 40.0)
    run = simulate(
        NOMINAL.replace({'current_gain.z': zero}).with_effects('current_gain'), time, drive * on, kind=kind, load=0.5884
    )
    g = NOMINAL['current_gain.g']
    assert getattr(run, kind) == pytest.approx(drive * on, abs=1e-10)  # what was recorded is what was shown
    flowing = run.current > 0.0
    assert np.array_equal(flowing, on)
    i = g * (run.current[flowing] - zero)
    true = ohms(run.temperature)[flowing]
    assert run.resistance[flowing] == pytest.approx(i * true / run.current[flowing], abs=1e-8)
    assert run.voltage[flowing] == pytest.approx(i * true, abs=1e-8)
    # What really flowed, set with a right ammeter, heats as much (a power with a zero is not constant over a tick).
    really = np.zeros(time.size)
    really[flowing] = {'current': i, 'power': i * run.voltage[flowing], 'voltage': run.voltage[flowing]}[kind]
    right = simulate(NOMINAL, time, really, kind=kind, load=0.5884)
    assert run.temperature == pytest.approx(right.temperature, abs=1e-3 if kind == 'power' and zero else 1e-8)


@pytest.mark.parametrize(('kind', 'drive'), [('current', 0.27), ('power', 1.02), ('voltage', 4.4)])
def test_an_ohmmeter_apart_is_right_where_the_ammeter_is_not(kind, drive):
    time, on = protocol(20.0, 40.0)
    wrong = NOMINAL.replace({'current_gain.z': 0.004}).with_effects('current_gain')
    by_it, apart = (
        simulate(muscle, time, drive * on, kind=kind, load=0.5884)
        for muscle in (wrong, wrong.replace({'current_gain.ohms': 1.0}))
    )
    assert apart.resistance == pytest.approx(ohms(apart.temperature), abs=1e-9)
    assert np.abs(by_it.resistance - apart.resistance)[on].min() > 0.02
    assert apart.temperature == pytest.approx(by_it.temperature, abs=1e-12)
    assert apart.current == pytest.approx(by_it.current, abs=1e-12)


@pytest.mark.parametrize('drive', [0.001, 0.0031, 0.0035])
def test_an_ammeter_whose_zero_is_as_large_as_the_current_neither_turns_it_round_nor_shows_any_resistance(drive):
    """What flows has the sign of what is set, and what is shown stays near what is there."""
    time = 0.05 * np.arange(40)
    muscle = NOMINAL.replace({'current_gain.z': 0.003}).with_effects('current_gain')
    run = simulate(muscle, time, drive, load=0.5884)
    assert np.all(run.voltage >= 0.0)
    assert np.all(run.temperature[1:] >= 296.15)
    assert np.all((run.resistance > ohms(296.15) / 3.1) & (run.resistance < 3.1 * ohms(296.15)))


@pytest.mark.parametrize('rate_hz', [20.0, 100.0])
@pytest.mark.parametrize('delay', [0.05, 0.2, 0.3, 0.5])
def test_clock_skew_is_a_pure_delay(rate_hz, delay):
    time, on = protocol(rate_hz, 60.0)
    skewed = simulate(NOMINAL.replace({'clock_skew.d': delay}).with_effects('clock_skew'), time, 0.27 * on, load=0.5)
    plain = simulate(NOMINAL, time, 0.27 * on, load=0.5)
    late = np.interp(time - delay, time, plain.temperature)
    assert skewed.temperature == pytest.approx(late, abs=0.03 if (rate_hz, delay) == (100.0, 0.5) else 1e-3)
    assert skewed.displacement == pytest.approx(plain.displacement, abs=1e-12)


@pytest.mark.parametrize(
    ('number', 'channel', 'end'), [(1, 'displacement', 'load'), (2, 'resistance', 'load'), (3, 'force', 'blocked')]
)
def test_any_channel_may_come_from_a_clock_that_is_late_and_slow(number, channel, end):
    time, on = protocol(20.0, 60.0)
    load = np.where((time > 29.99) & (time < 44.99), 0.9, 0.5)  # its jumps stay jumps
    values = {'clock_skew.d': 0.23, 'clock_skew.r': 2e-3, 'clock_skew.channel': float(number)}
    more = {'end': end, 'starting_load': 0.5} if end == 'blocked' else {'load': load}
    skewed = simulate(NOMINAL.replace(values).with_effects('clock_skew'), time, 0.27 * on, **more)
    plain = simulate(NOMINAL, time, 0.27 * on, **more)
    fine = np.arange(round(60.0 * 2000.0) + 1) / 2000.0
    if end == 'load':
        more = {'load': np.where((fine > 29.9999) & (fine < 44.9999), 0.9, 0.5)}
    true = simulate(NOMINAL, fine, 0.27 * (np.mod(np.arange(fine.size), 140000) < 50000), **more)
    late = np.interp(time - 0.23 - 2e-3 * time, fine, getattr(true, channel))
    shown, was = getattr(skewed, channel), getattr(plain, channel)
    assert np.max(np.abs(was - late)) > 30 * np.max(np.abs(shown - late)[5:])
    others = {'temperature', 'resistance', 'displacement', 'force'} - {channel}
    for name in others:
        assert getattr(skewed, name) == pytest.approx(getattr(plain, name), abs=1e-9)


def test_sensor_errors_are_what_they_say():
    plain = baseline(0.5884, 0.27)
    gain = e0(NOMINAL.with_effects('thermocouple_gain'), 0.5884, 0.27)
    assert gain.temperature == pytest.approx(296.15 + 0.93 * (plain.temperature - 296.15), abs=1e-8)
    offset = e0(NOMINAL.with_effects('temperature_offset'), 0.5884, 0.27)
    assert offset.temperature == pytest.approx(plain.temperature + 0.5, abs=1e-8)
    pickup = e0(NOMINAL.with_effects('thermocouple_pickup'), 0.5884, 0.27)
    assert pickup.temperature == pytest.approx(plain.temperature + 3.0 * plain.current, abs=1e-8)
    drift = e0(NOMINAL.with_effects('displacement_drift'), 0.5884, 0.27)
    assert drift.displacement == pytest.approx(plain.displacement + 2.5e-6 * plain.time, abs=1e-12)
    course = {'displacement_drift.b': 0.8, 'displacement_drift.c': -2.0, 'displacement_drift.tau': 30.0}
    bent = e0(NOMINAL.replace(course).with_effects('displacement_drift'), 0.5884, 0.27)
    z = np.minimum(plain.time / 30.0, 1.0)
    way = 2.5e-6 * plain.time * (1.0 + (1.0 - z) * (0.8 - 2.0 * (1.0 - 2.0 * z)))
    assert bent.displacement == pytest.approx(plain.displacement + way, abs=1e-12)
    zero = e0(NOMINAL.with_effects('displacement_offset'), 0.5884, 0.27)
    assert zero.displacement == pytest.approx(plain.displacement + 5e-4, abs=1e-12)


def test_resistance_drift_goes_on_or_begins_anew():
    """A muscle that was in use for so long goes on as one that was given it, or as a new one."""
    t = np.arange(0.0, 300.0, 0.2)
    drift = {'resistance_drift.r': 1e-4, 'resistance_drift.n': 0.6}
    runs = {
        course: simulate(
            Parameters({**drift, 'resistance_drift.w0': 150.0, 'resistance_drift.course': course}).with_effects(
                'resistance_drift'
            ),
            t,
            np.full(t.size, 1e-3),
        ).resistance
        for course in (0.0, 1.0)
    }
    whole = simulate(Parameters(drift).with_effects('resistance_drift'), t, np.full(t.size, 1e-3)).resistance
    np.testing.assert_allclose(runs[1.0][: t.size // 2], whole[t.size // 2 :], rtol=1e-4)
    np.testing.assert_array_equal(runs[0.0], whole)

"""Diagnoses to show: recordings made by simulating a muscle with an effect, explained as a diagnosis would.

The engine is not asked: a report must be right for whatever a diagnosis says.
"""

from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import (
    Change,
    ChannelFit,
    Diagnosis,
    Finding,
    FreeLaw,
    InWords,
    NotTestable,
    Proposal,
    Ranked,
    RecordingSummary,
    Run,
    Series,
    Step,
    Value,
)
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import Holding, Imposed
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.diagnosis.search.location import Driver, Location, Unexplained
from tcp_muscle_ros.muscle import EFFECTS, Parameters

NOMINAL = Parameters.named('karami_tadesse_2017')
NOISE = {'temperature': 0.15, 'resistance': 0.02, 'displacement': 4e-5, 'force': 2e-3}
CHANNELS = ('temperature', 'resistance', 'displacement')
_NAN = float('nan')


def experiment(truth, *, load=0.59, seed=0, duration=300.0, rate=10.0, channels=CHANNELS, end='load'):
    """A recording of a muscle with parameters ``truth``, with noise."""
    time = np.arange(round(duration * rate) + 1) / rate
    drive = np.where(time % 60.0 < 30.0, 0.27, 0.0)
    loads, ambient = np.full(time.size, load), np.full(time.size, 296.15)
    imposed = Imposed('current', time, drive, loads, ambient)
    made = Experiment(f'lab/run_{seed + 1}', imposed, Holding(end, load), {})
    outputs = made.outputs(truth)
    chance = np.random.default_rng(seed)
    observed = {}
    for name in channels:
        keep = drive > 0.0 if name == 'resistance' else np.full(time.size, True)
        value = getattr(outputs, name)[keep] + chance.normal(0.0, NOISE[name], int(keep.sum()))
        observed[name] = Observed(time[keep], value, np.ones(int(keep.sum())))
    return replace(made, observed=observed)


def series_of(made, nominal, before, after):
    outputs = made.outputs(after)
    temperature, rate = outputs.fibre_temperature, np.gradient(outputs.fibre_temperature, outputs.time)
    predictions = [made.predict(parameters) for parameters in (nominal, before, after)]
    found = []
    for name, o in made.observed.items():
        if name in ('displacement', 'force'):  # whose zero is a convention of the rig
            for p in predictions:
                p[name] = p[name] + np.mean(o.value - p[name])
        on = np.interp(o.time, made.imposed.time, made.imposed.drive) > 0.0
        found.append(
            Series(
                name,
                o.time,
                o.value,
                *(p[name] for p in predictions),
                np.interp(o.time, outputs.time, temperature),
                np.interp(o.time, outputs.time, rate),
                on,
            )
        )
    return tuple(found)


def _rms(x):
    return float(np.sqrt(np.mean(x**2)))


def _diagnosis(experiments, *, nominal=NOMINAL, before=None, after=None, **said):
    """A diagnosis whose series and errors are those of real simulations; ``said`` is the rest of it."""
    before = nominal if before is None else before
    after = before if after is None else after
    series = tuple(series_of(made, nominal, before, after) for made in experiments)
    fit = {}
    for name in experiments[0].observed:
        mine = [s for found in series for s in found if s.channel == name]
        errors = [
            _rms(np.concatenate([s.recorded - getattr(s, model) for s in mine]))
            for model in ('nominal', 'before', 'after')
        ]
        fit[name] = ChannelFit(*errors, NOISE[name], Change(*errors[1:]))
    calibration = {
        'hA': Value(before['hA'], 0.97 * before['hA'], 1.03 * before['hA'], 'W/K', nominal['hA']),
        'C': Value(before['C'], 0.96 * before['C'], 1.04 * before['C'], 'J/K', nominal['C']),
        'k0': Value(before['k0'], 0.4 * before['k0'], 2.5 * before['k0'], 'N/m', nominal['k0'], fixed=False),
        'ambient [1]': Value(296.4, 296.3, 296.5, 'K', 296.15),
    }
    filled = {
        'headline': 'The simulation matches the recordings.',
        'verdict': 'match',
        'recordings': tuple(
            RecordingSummary(e.name, e.duration, 10.0, ('current', *e.observed), ()) for e in experiments
        ),
        'noise': {name: NOISE[name] for name in experiments[0].observed},
        'calibration': calibration,
        'sensors': {'temperature_offset': Value(0.1, -0.2, 0.4, 'K', 0.0)},
        'location': None,
        'findings': (),
        'fit': fit,
        'ranking': (),
        'not_testable': (NotTestable('contact_resistance', 'acts as another R0: measure with four wires'),),
        'unexplained': None,
        'next_experiment': None,
        'nominal': nominal,
        'improved': after,
        'calibrated': before,
        'repeatability': dict.fromkeys(experiments[0].observed),
        'drive': tuple(('current', e.imposed.time, e.imposed.drive) for e in experiments),
        'series': series,
        'seconds': {'calibrate': 3.2, 'screen': 0.8},
    }
    return Diagnosis(**{**filled, **said}), experiments


def creep():
    """Physics is missing and singled out; two loads; the stroke lags behind."""
    truth = NOMINAL.with_effects('creep').replace({'creep.J': 0.35, 'creep.tau50': 25.0, 'hA': 1.05 * NOMINAL['hA']})
    experiments = [experiment(truth, load=0.59, seed=0), experiment(truth, load=1.18, seed=1)]
    before = NOMINAL.replace(hA=truth['hA'])
    after = truth.replace({'creep.J': 0.347})
    found = Finding(
        'creep',
        'mechanical',
        'While cooling the muscle stays longer than the simulation: part of its elastic elongation comes late.',
        EFFECTS['creep'].equation,
        {
            'creep.J': Value(0.347, 0.339, 0.356, '1', 0.0),
            'creep.tau50': Value(25.1, 24.0, 26.3, 's', 15.0),
            'creep.aT': Value(0.071, 0.066, 0.075, '1/K', 0.07),
        },
        0.98,
        (),
        {'displacement': Change(1.9e-3, 4.3e-5)},
        5120.0,
    )
    return _diagnosis(
        experiments,
        before=before,
        after=after,
        headline='Between 45 and 80 degC while cooling, the recorded stroke is on average 2.1 mm below the '
        'simulation. The simulation lacks creep; with it the error on unseen data falls from 1.9 mm to 0.04 mm.',
        verdict='missing_physics',
        location=Location(
            'mechanical',
            'displacement',
            ('cooling', 'transition'),
            (
                Driver('temperature', 318.15, 353.15, 0.71, 'K'),
                Driver('since_switch', 2.0, 30.0, 0.2, 's'),
            ),
            ((0, 30.0, 52.0), (0, 90.0, 112.0), (1, 30.0, 55.0)),
            2.4e-3,
            -2.1e-3,
        ),
        findings=(found,),
        ranking=(
            Ranked('creep', 'mechanical', 5120.0, True),
            Ranked('viscous_flow', 'mechanical', 2310.0, True),
            Ranked('hysteresis', 'mechanical', 1890.0, True),
            Ranked('branch_cte', 'mechanical', 1210.0, False),
            Ranked('cte_kink', 'mechanical', 240.0, False),
            Ranked('thermocouple_lag', 'sensor', 90.0, False),
            Ranked('natural_convection', 'thermal', 12.0, False),
            Ranked('radiation', 'thermal', 9.0, False),
        ),
    )


def convection_or_radiation():
    """Physics is missing, and the recordings do not say which of two it is; an experiment would."""
    truth = NOMINAL.with_effects('natural_convection').replace({'natural_convection.n': 0.2})
    experiments = [experiment(truth, seed=0)]
    after = truth.replace({'natural_convection.n': 0.19})
    found = Finding(
        'natural_convection',
        'thermal',
        'The hotter the muscle, the more heat it gives off for each kelvin.',
        EFFECTS['natural_convection'].equation,
        {'n': Value(0.19, 0.17, 0.21, '1', 0.0)},
        0.61,
        ('radiation',),
        {'temperature': Change(1.1, 0.16), 'displacement': Change(3.1e-4, 4.1e-5)},
        842.0,
    )
    return _diagnosis(
        experiments,
        before=NOMINAL.replace(hA=1.07 * NOMINAL['hA']),
        after=after,
        headline='While heating, the recorded temperature is on average 1.3 K below the simulation. The simulation '
        'lacks natural convection (or radiation).',
        verdict='missing_physics',
        location=Location(
            'thermal',
            'temperature',
            ('heating',),
            (Driver('temperature', 340.15, 353.15, 0.64, 'K'),),
            ((0, 10.0, 30.0),),
            1.5,
            -1.3,
        ),
        findings=(found,),
        ranking=(
            Ranked('natural_convection', 'thermal', 842.0, True),
            Ranked('radiation', 'thermal', 839.0, True),
            Ranked('exposed_area', 'thermal', 301.0, True),
            Ranked('heat_capacity', 'thermal', 88.0, False),
        ),
        next_experiment=Proposal(
            ('natural_convection', 'radiation'),
            'steps_of_current',
            'Long holds at three currents show how the conductance grows with temperature.',
            (Step(120.0, 0.12, 0.59), Step(120.0, 0.2, 0.59), Step(120.0, 0.27, 1.18), Step(60.0, 0.0, 0.59)),
            2,
            20.0,
            'load',
            0.93,
        ),
    )


def three_effects():
    """As much as a diagnosis may have to say."""
    (d, experiments), (other, _) = creep(), convection_or_radiation()
    third = replace(d.findings[0], effect='geometric_stiffening', parameters={}, probability=0.55)
    fit = {**d.fit, 'force': ChannelFit(0.02, 0.015, 0.004, 0.002)}
    told = replace(
        d,
        headline=' '.join([d.headline] * 3),
        findings=(*d.findings, *other.findings, third),
        fit=fit,
        unexplained=_unexplained(),
        next_experiment=other.next_experiment,
        not_testable=tuple(NotTestable(name, 'no slow part') for name in ('fatigue', 'first_cycle', 'inertia') * 4),
        recordings=tuple(replace(r, issues=('displacement: a gap of 10 s <at> 20 s',)) for r in d.recordings),
        notes=('no thermometer was recorded: the temperature is inferred',),
        partial=True,
    )
    return told, experiments


def match():
    """Nothing is missing."""
    return _diagnosis([experiment(NOMINAL)])


def wrong_parameters():
    """hA is wrong eightfold, as the paper prints it."""
    nominal = Parameters.named('karami_tadesse_2017_as_printed').replace(B=NOMINAL['B'])
    return _diagnosis(
        [experiment(NOMINAL)],
        nominal=nominal,
        before=NOMINAL,
        headline='The recordings follow the paper with other parameters: hA is 0.0189 W/K, not 0.15 W/K.',
        verdict='wrong_parameters',
    )


def sensor_or_setup():
    """The thermometer lags; no muscle parameter is wrong."""
    truth = NOMINAL.with_effects('thermocouple_lag').replace({'thermocouple_lag.tau': 2.5})
    return _diagnosis(
        [experiment(truth)],
        after=truth,
        headline='The thermometer lags by 2.5 s; the muscle is as simulated.',
        verdict='sensor_or_setup',
        sensors={'thermocouple_lag.tau': Value(2.5, 2.4, 2.6, 's', 0.0)},
        location=Location('sensor', 'temperature', ('transition',), (), ((0, 0.0, 8.0),), 9.0),
    )


def _unexplained():
    return Unexplained('mechanical', 'displacement', 0.42, 'temperature', 323.15, 333.15, (0, 100.0, 160.0))


def unexplained():
    """A misfit that goes with temperature near 55 degC, without a name."""
    truth = NOMINAL.with_effects('geometric_stiffening')
    return _diagnosis(
        [experiment(truth, load=1.5)],
        headline='Near 55 degC the stroke differs by 0.6 mm from anything in the catalogue.',
        verdict='unexplained',
        location=Location('mechanical', 'displacement', (), (), (), _NAN),
        unexplained=_unexplained(),
        ranking=(Ranked('radiation', 'thermal', 9.0, True),),
    )


def insufficient_data():
    """Ten samples."""
    made = experiment(NOMINAL, duration=1.0)
    return _diagnosis(
        [made],
        headline='The recording is too short to tell: 1 s, 10 samples.',
        verdict='insufficient_data',
        fit={},
        calibration={},
        sensors={},
        noise={'temperature': _NAN},
        series=(),
        drive=(),
    )


def not_repeatable():
    """Two runs of one protocol differ by more than the simulation misses either."""
    experiments = [experiment(NOMINAL, seed=k) for k in range(2)]
    return _diagnosis(
        experiments,
        headline='Runs of the same protocol differ from each other by as much as they differ from the simulation.',
        verdict='not_repeatable',
        verdict_probability=0.9,
        repeatability={'displacement': 4e-4, 'temperature': None},
        runs=(Run('one', 1, 0.8, 7.1, 0.05), Run('other', 1, 1.25, 14.9, 0.06), Run('alone', None, 1.0, 9.0, 0.04)),
    )


def next_to_nothing():
    """An effect whose interval contains no effect at all, and no experiment that would decide."""
    d, experiments = convection_or_radiation()
    found = replace(
        d.findings[0],
        parameters={'n': Value(0.03, -0.004, 0.064, '1', 0.0)},
        probability=0.41,
        indistinguishable_from=(),
    )
    return replace(d, findings=(found,), next_experiment=None, would_help=('a second load',)), experiments


def unlisted():
    """A law without a name: the conductance over temperature."""
    d, experiments = convection_or_radiation()
    at = np.linspace(296.15, 363.15, 12)
    value = 0.0189 * (1.0 + 0.004 * (at - 296.15))
    said = InWords(
        'linear',
        'The conductance rises evenly with the temperature, by 0.4 % per K.',
        'c + b (x - o)/w',
        {'c': (0.0189, 'W/K'), 'b': (0.005, 'W/K'), 'o': (23.0, 'degC'), 'w': (67.0, 'K')},
        (),
        1.01 * value,
    )
    law = FreeLaw('temperature', 'W/K', at, value, 0.97 * value, 1.03 * value, 'natural_convection', 0.41, said)
    found = replace(
        d.findings[0], effect='free_conductance', parameters={}, indistinguishable_from=(), unlisted=law, equation=''
    )
    return replace(d, findings=(found,), next_experiment=None, ranking=()), experiments


def force_only():
    """A held muscle: no stroke, no thermometer."""
    truth = NOMINAL.replace(hA=1.2 * NOMINAL['hA'])
    return _diagnosis([experiment(truth, end='blocked', channels=('force',))], after=truth, verdict='wrong_parameters')


ALL = {
    made.__name__: made
    for made in (
        creep,
        convection_or_radiation,
        three_effects,
        match,
        wrong_parameters,
        sensor_or_setup,
        unexplained,
        not_repeatable,
        next_to_nothing,
        unlisted,
        insufficient_data,
        force_only,
    )
}

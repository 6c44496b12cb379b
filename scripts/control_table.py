"""Print every figure of docs/control.md and, with --figure, draw its picture: python scripts/control_table.py

The controller against the simulated muscle, offline, at 100 Hz with the nodes' timing. A minute.
"""

import argparse
import sys

import numpy as np

from tcp_muscle_ros.control.offline import PERFECT, Sensors, run
from tcp_muscle_ros.control.tracking import MODES
from tcp_muscle_ros.muscle import Muscle, Parameters
from tcp_muscle_ros.studies import control_study as study

MODEL = Parameters.named('karami_tadesse_2017')
STEPS = [(limit, target) for limit in (0.27, 0.40) for target in (0.020, 0.040)]
HEAD = f'{"":44s} {"possible s":>10} {"settled s":>10} {"ratio":>6} {"over %":>7} {"steady mm":>9} {"ripple mA":>9}'


def row(name: str, figures: study.Figures) -> None:
    r = figures.response
    times = f'{figures.physical_time:10.2f} {r.settling_time:10.2f} {figures.ratio:6.3f}'
    errors = f'{100 * r.overshoot:7.3f} {1e3 * r.steady_error:9.4f} {1e3 * r.ripple:9.2f}'
    print(f'{name:44s} {times} {errors}')


def title(text: str) -> None:
    print(f'\n{text}\n{HEAD}')


def steps(plant: Parameters, sensors: Sensors = PERFECT) -> None:
    for mode in MODES:
        for limit, target in STEPS:
            figures = study.heating(plant, MODEL, limit, target, sensors, mode=mode)
            row(f'{mode} {1e3 * target:.0f} mm at {limit:.2f} A', figures)


def other_muscles(mode: str, limit: float, target: float) -> None:
    plants = [plant for plant, _ in study.draws(MODEL, 20, seed=1) if study.reachable(plant, limit, target)]
    all_figures = [study.heating(plant, MODEL, limit, target, mode=mode) for plant in plants]
    ratios = [figures.ratio for figures in all_figures]
    overshoot = max(figures.response.overshoot for figures in all_figures)
    steady = max(figures.response.steady_error for figures in all_figures)
    print(
        f'{mode:5s} {1e3 * target:.0f} mm at {limit:.2f} A: {len(plants)} of 20 reachable; '
        f'ratio median {np.median(ratios):.3f}, worst {np.max(ratios):.3f}; '
        f'overshoot at most {100 * overshoot:.2f} %; steady error at most {1e3 * steady:.4f} mm'
    )


def sine(mode: str) -> None:
    time = np.arange(0.0, 60.0, study.PERIOD)
    wanted = 0.025 + 0.005 * np.sin(2.0 * np.pi * time / 20.0)
    happened = run(study.controller(MODEL, 0.27, mode=mode), Muscle(MODEL, load=study.LOAD), study.PERIOD, wanted)
    late = time >= 15.0
    error = 1e3 * (happened.displacement - wanted)[late]
    print(f'{mode:5s} rms error {np.sqrt(np.mean(error**2)):.4f} mm, largest {np.abs(error).max():.4f} mm')


def main() -> int:
    parser = argparse.ArgumentParser(description='the figures of docs/control.md')
    parser.add_argument('--figure', metavar='PNG', help='draw its picture as well')
    arguments = parser.parse_args()

    title('Heating from rest under 60 g; possible = full current enters the 2 % band')
    steps(MODEL)
    title('Release; possible = passive cooling enters the band')
    for mode in MODES:
        for begin, end in ((0.04, 0.0), (0.02, 0.0), (0.04, 0.02)):
            row(
                f'{mode} {1e3 * begin:.0f} to {1e3 * end:.0f} mm',
                study.release(MODEL, MODEL, begin, end, 0.4, mode=mode),
            )
    title('The load grows by 0.3 N at 0.27 A; possible = full current from the same state')
    for mode in MODES:
        for target in (0.02, 0.03):
            for told in (True, False):
                how = 'load told' if told else 'load not told'
                row(
                    f'{mode} at {1e3 * target:.0f} mm, {how}',
                    study.load_step(MODEL, MODEL, target, 0.3, 0.27, told, mode=mode),
                )
    print('\nA sine of 5 mm about 25 mm, 0.05 Hz, at 0.27 A, from 15 s on')
    for mode in MODES:
        sine(mode)
    print('\n20 muscles with R0, a_R, C, hA, k0 and B each within 20 % of the model (seed 1)')
    for mode in MODES:
        for limit, target in STEPS:
            other_muscles(mode, limit, target)
    for effect in ('creep', 'thermocouple_lag', 'resistance_strain', 'natural_convection'):
        title(f'In the muscle, not in the model: {effect}')
        steps(MODEL.with_effects(effect))
    for name, sensors in (
        ('displacement noise 0.02 mm', Sensors(displacement_noise=2e-5)),
        ('displacement noise 0.05 mm', Sensors(displacement_noise=5e-5)),
        ('displacement quantum 0.05 mm', Sensors(displacement_quantum=5e-5)),
        ('on resistance alone', Sensors(feedback='resistance')),
        ('on resistance alone, noise 0.01 ohm', Sensors(feedback='resistance', resistance_noise=0.01)),
    ):
        title(f'Sensor: {name}')
        steps(MODEL, sensors)
    title('On resistance alone, effect resistance_strain in the muscle and not in the model')
    steps(MODEL.with_effects('resistance_strain'), Sensors(feedback='resistance'))
    if arguments.figure:
        from tcp_muscle_ros.report.tracking_pictures import draw_control

        others = {step: study.of_others(MODEL, step, 20, 1) for step in ((0.27, 0.040), (0.40, 0.020), (0.40, 0.040))}
        draw_control(study.side_by_side(MODEL), others, arguments.figure)
    return 0


if __name__ == '__main__':
    sys.exit(main())

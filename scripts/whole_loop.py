"""Conceal physics in a muscle, find it from recordings alone: python scripts/whole_loop.py [--output FOLDER] [--seed N]

A sim_node gets another specimen than the nominal one and one effect of the catalogue, both drawn from a seed that is
not shown. Two experiments on it are recorded, `tcp_muscle diagnose` reads the bags and the nominal parameters, and a
second sim_node loads the improved.yaml that comes out. Both then do a third experiment, at another load and other
currents, which the diagnosis has not seen: the table compares them. Last of all it is told what was concealed.

Nodes, recorder and commander are real ones (see lockstep_bench.py).
"""

import argparse
import json
import secrets
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from lockstep_bench import Bench, Step

from tcp_muscle_ros.diagnosis.answer.replaying import replay
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.holding import Conditions
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.muscle import EFFECTS, LISTED, SPECIFICATIONS, Parameters, simulate
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.units import GRAVITY
from tcp_muscle_ros.report.as_read import CHANNEL_AXIS, SHOWN, shown
from tcp_muscle_ros.report.style import AFTER, BEFORE, DRIVE, RECORDED, canvas, save
from tcp_muscle_ros.report.tables import table
from tcp_muscle_ros.settings.parameter_file import read, write

NOMINAL = Parameters.named('karami_tadesse_2017')
RATE = 10.0  # Hz
NOISE = {'temperature': 0.1, 'resistance': 5e-3, 'displacement': 3e-5}  # K, ohm, m: standard deviations
SENSORS = {
    'temperature_noise_k': NOISE['temperature'],
    'resistance_noise_ohm': NOISE['resistance'],
    'displacement_noise_m': NOISE['displacement'],
}
# The watchdog is on the wall's clock, of which a busy machine may lose a second.
OPERATING = {'load_n': 0.060 * GRAVITY, 'rate_hz': RATE, 'current_limit_a': 0.3, 'command_timeout_s': 3.0}
MOVED = ('hA', 'C', 'R0', 'a_R', 'k0', 'B')  # parameters that a specimen has for itself, by up to
SPREAD = 0.12
ATTEMPTS = 3  # a recorder that the machine holds up loses what comes meanwhile
PROBE = 0.012  # A: enough to read a resistance, too little to heat


def cycles(currents: Sequence[float], mass: float, on: float = 25.0, off: float = 45.0) -> list[Step]:
    """The paper's protocol, with a current to read R by while it cools."""
    heated = [[Step(on, i, mass), Step(off, PROBE, mass)] for i in currents]
    return [Step(5.0, PROBE, mass), *(step for pair in heated for step in pair)]


LOADS = (0.100, 0.150, 0.060, 0.100, 0.030)
EXPERIMENTS = {
    'cycles': cycles((0.26, 0.26, 0.19), 0.060),  # the same twice shows what is noise
    'loads': [
        *(Step(8.0, PROBE, mass) for mass in LOADS),
        *(Step(25.0 if k == 0 else 10.0, 0.22, mass) for k, mass in enumerate(LOADS)),
        Step(40.0, PROBE, 0.100),
        *(Step(12.0, i, 0.060) for i in (0.15, 0.20, 0.25, 0.20, 0.24, 0.16)),
        Step(30.0, PROBE, 0.060),
    ],
}
UNSEEN = cycles((0.255, 0.225), 0.080, on=35.0, off=35.0)


def specimen(seed: int) -> Parameters:
    """The muscle of a seed: its own parameters, and one effect between its usual strength and twice that."""
    rng = np.random.default_rng(seed)
    moved = {name: NOMINAL[name] * float(np.exp(rng.uniform(-SPREAD, SPREAD))) for name in MOVED}
    # A hanging weight's ringing is beyond this rate; a resistance in series is beyond any recording of one muscle. What
    # a draught or a room did in two recordings, nobody can foretell of a third.
    physics = [n for n in LISTED if EFFECTS[n].stage != 'sensor']
    effects = [n for n in physics if not (EFFECTS[n].hidden or EFFECTS[n].swings or EFFECTS[n].circumstance)]
    effect = EFFECTS[str(rng.choice(effects))]
    strongest = f'{effect.name}.{effect.strength}'
    row = SPECIFICATIONS[strongest]
    strength = effect.none + (row.value - effect.none) * float(rng.uniform(1.0, 2.0))
    muscle = NOMINAL.replace(moved).with_effects(effect.name)
    return muscle.replace({strongest: min(max(strength, row.low), row.high)})


def shows(muscle: Parameters) -> bool:
    """Whether the recordings show the effect of a specimen: without it a channel is three noises off, in the mean. A
    contact of coils that no current of these brings about is not to be found."""
    for steps in EXPERIMENTS.values():
        ends = np.cumsum([step.seconds for step in steps])
        time = np.arange(0.0, ends[-1], 1.0 / RATE)
        now = [steps[k] for k in np.searchsorted(ends, time, side='right')]
        current, load = np.array([step.current for step in now]), np.array([step.mass * GRAVITY for step in now])
        with_it, without = (simulate(m, time, current, load=load) for m in (muscle, muscle.only_effects([])))
        for channel, noise in NOISE.items():
            off = getattr(with_it, channel) - getattr(without, channel)
            if float(np.sqrt(np.mean(off**2))) > 3.0 * noise:
                return True
    return False


def drawn() -> Parameters:
    """A specimen by chance, of which the recordings show the effect."""
    while not shows(found := specimen(secrets.randbits(32))):
        pass
    return found


def record_all(parameters: Path, what: dict[str, Sequence[Step]], folder: Path) -> None:
    """Record experiments on the muscle of a parameter file, a bag each."""
    bench = Bench(parameters, RATE, OPERATING['load_n'])
    try:
        for name, steps in what.items():
            print(f'recording {name}: {sum(s.seconds for s in steps):.0f} s of the muscle', flush=True)
            for _ in range(ATTEMPTS):
                bench.perform(steps, folder / name)
                if (gap := longest_gap(folder / name)) < 1.5 / RATE:
                    break
                print(f'{name}: {gap:.1f} s did not reach the recorder; it is recorded again', flush=True)
                shutil.rmtree(folder / name)
            else:
                raise RuntimeError(f'{name}: this machine loses messages in each of {ATTEMPTS} recordings')
    finally:
        bench.close()


def longest_gap(bag: Path) -> float:
    """The longest time (s) between two temperatures of a recording."""
    return float(np.diff(read_bag(bag)['temperature'].time).max())


def unseen_errors(
    folder: Path, improved: Parameters
) -> tuple[list[list[str]], Experiment, dict[str, dict[str, np.ndarray]]]:
    """Rows of the table (per channel: nominal, improved, and the improved sim_node), and what the picture shows.

    The models run under the recorded inputs; the improved sim_node was commanded anew: its own recording is compared,
    switch by switch.
    """
    recorded = prepare(read_bag(folder / 'unseen'), NOMINAL, Conditions(load=OPERATING['load_n']))
    again = read_bag(folder / 'unseen_improved')
    nominal, better = replay(recorded, NOMINAL), replay(recorded, improved)
    here, there = switches(folder / 'unseen'), switches(folder / 'unseen_improved')
    if here.size != there.size:  # a command was lost: the first one still begins both
        here, there = here[:1], there[:1]
    rows, curves = [], {}
    for name, found in nominal.items():
        unit, factor = SHOWN[name]
        moments = np.interp(found.time, here, there) + np.minimum(found.time - here[0], 0.0)
        moments += np.maximum(found.time - here[-1], 0.0)
        node = np.interp(moments, again[name].time, again[name].value)
        error = float(np.sqrt(np.mean((node - found.recorded) ** 2)))
        values = (found.rmse, better[name].rmse, error, NOISE[name])
        rows.append([name, *(f'{value * factor:.3g} {unit}' for value in values)])
        curves[name] = {'nominal': found.predicted, 'improved': better[name].predicted, 'node': node}
    return rows, recorded, curves


def switches(bag: Path) -> np.ndarray:
    """When (s) a recording's heating was switched; a command reaches its node a tick sooner or later."""
    current = read_bag(bag)['current']
    return current.time[1:][np.diff(current.value > 2.0 * PROBE)]


def draw(path: Path, experiment: Experiment, curves: dict[str, dict[str, np.ndarray]]) -> None:
    """The unseen experiment: recorded, the nominal muscle, the improved sim_node; and the two errors."""
    figure, axes = canvas(len(curves), 2, width=11.0, height=2.3, sharex=True)
    for row, (name, found) in enumerate(curves.items()):
        o = experiment.observed[name]
        left, right = axes[2 * row], axes[2 * row + 1]
        # Broad, for what the improved muscle shows lies upon it.
        left.plot(o.time, shown(name, o.value), '.', markersize=5.0, color=RECORDED, label='recorded')
        for label, colour, said in (('nominal', BEFORE, 'nominal'), ('node', AFTER, 'sim_node with improved.yaml')):
            left.plot(o.time, shown(name, found[label]), '.', markersize=1.2, color=colour, label=said)
            error = shown(name, o.value) - shown(name, found[label])
            right.plot(o.time, error, '.', markersize=1.2, color=colour, label=said)
        left.set_ylabel(CHANNEL_AXIS[name])
        right.set_ylabel('recorded - simulated')
        on = experiment.imposed.drive > 2.0 * PROBE
        for axis in (left, right):
            low, high = axis.get_ylim()
            axis.fill_between(
                experiment.imposed.time, low, high, where=on, step='post', color=DRIVE, alpha=0.12, linewidth=0
            )
            axis.set_ylim(low, high)
    lines, said_of_them = axes[0].get_legend_handles_labels()
    figure.legend(lines, said_of_them, loc='outside upper center', ncols=3, fontsize=9, frameon=False, markerscale=4)
    axes[0].set_title('an experiment that the diagnosis has not seen', fontsize=10)
    axes[1].set_title('error', fontsize=10)
    for axis in axes[-2:]:
        axis.set_xlabel('time (s), shaded: heated')
    save(figure, path)


def told(truth: Parameters, report: dict[str, object]) -> list[str]:
    """What was concealed, and whether the diagnosis named it."""
    (effect,) = truth.effects
    findings: list[dict[str, object]] = report['findings']  # type: ignore[assignment]
    first = findings[0] if findings else {'effect': None, 'indistinguishable_from': []}
    named = [str(f['effect']) for f in findings]
    if first['effect'] == effect:
        verdict = 'named first'
    elif effect in named:
        verdict = f'named, after {named[0]}'
    elif effect in [other for f in findings for other in f['indistinguishable_from']]:  # type: ignore[attr-defined]
        verdict = f'in the set of {named[0]}, from which these recordings cannot tell it'
    elif effect in [n['effect'] for n in report['not_testable']]:  # type: ignore[index,attr-defined]
        verdict = 'said not to be testable with these recordings'
    else:
        verdict = f'not named; the diagnosis says {", ".join(named) or report["verdict"]}'
    others = [name for name in named if name != effect]
    name = f'{effect}.{EFFECTS[effect].strength}'
    return [
        f'concealed was: {effect} ({EFFECTS[effect].stage}), {name} = {truth[name]:.3g} {SPECIFICATIONS[name].unit}',
        f'it was {verdict}' + (f'; also named: {", ".join(others)}' if others and effect in named else ''),
    ]


def main() -> int:
    """Conceal, record, diagnose, improve, compare, reveal."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--output', type=Path, default=Path('demo'), help='folder for whole_loop/, made anew')
    parser.add_argument('--seed', type=int, default=None, help='what is concealed (default: drawn, and not shown)')
    args = parser.parse_args()
    folder: Path = args.output / 'whole_loop'
    begun = time.monotonic()
    if folder.exists():
        shutil.rmtree(folder)  # of the last run
    folder.mkdir(parents=True)
    truth = drawn() if args.seed is None else specimen(args.seed)
    nominal = folder / 'nominal.yaml'
    write(nominal, NOMINAL, operating=OPERATING)
    with tempfile.TemporaryDirectory() as hidden:
        concealed = Path(hidden) / 'muscle.yaml'
        write(concealed, truth, operating={**OPERATING, **SENSORS})
        record_all(concealed, {**EXPERIMENTS, 'unseen': UNSEEN}, folder)
    report = folder / 'report'
    command = [sys.executable, '-m', 'tcp_muscle_ros.tool', 'diagnose', *(str(folder / name) for name in EXPERIMENTS)]
    print('\ntcp_muscle diagnose cycles loads --params nominal.yaml --output report', flush=True)
    subprocess.run([*command, '--params', str(nominal), '--output', str(report)], check=True)
    print(flush=True)
    record_all(report / 'improved.yaml', {'unseen_improved': UNSEEN}, folder)
    rows, recorded, curves = unseen_errors(folder, read(report / 'improved.yaml').parameters)
    draw(folder / 'whole_loop.png', recorded, curves)
    print(f'\n{table(["unseen experiment, RMSE", "nominal", "improved.yaml", "its sim_node", "noise"], rows)}\n')
    print('\n'.join(told(truth, json.loads((report / 'report.json').read_text()))))
    print(f'picture {folder / "whole_loop.png"}\nreport {report / "report.html"}')
    print(f'the whole loop took {time.monotonic() - begun:.0f} s')
    return 0


if __name__ == '__main__':
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        print('\ninterrupted')
        sys.exit(130)

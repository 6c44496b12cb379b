"""config/example_lab_run.csv: what a lab's logger would have written of a muscle with a concealed effect.

    python scripts/make_example_csv.py

The muscle is not the one of the shipped parameters: it loses heat a little better, and the better the hotter it is
(natural convection), which the paper leaves out. config/protocol_steps.yaml is what was done to it, read twice a
second.
"""

from pathlib import Path

import numpy as np

from tcp_muscle_ros.muscle import ZERO_CELSIUS, Parameters, simulate
from tcp_muscle_ros.recording.protocol import read_protocol

CONFIG = Path(__file__).resolve().parents[1] / 'config'
CONCEALED = Parameters({'hA': 0.0185, 'natural_convection.n': 0.3}, ('natural_convection',))
EVERY = 5  # ticks of the protocol between readings: 2 a second
ROOM = 23.0 + ZERO_CELSIUS
NOISE = {'temperature': 0.08, 'resistance': 0.004, 'stroke': 8e-6}  # K, ohm, m
HEADING = """\
Rig: bench 2, multimeter + laser
Specimen: coil 7, nylon, 4 ply
Room: 23.0 °C

Time (s);Current (mA);Temp. coil [°C];Resistance [Ohm];Stroke [mm];Weight [g]
"""


def write(path: Path) -> None:
    sampled = read_protocol(CONFIG / 'protocol_steps.yaml').sampled()
    outputs = simulate(
        CONCEALED,
        sampled.time,
        sampled.drive,
        kind=sampled.kind,
        load=sampled.load,
        ambient=np.full_like(sampled.time, ROOM),
    )
    noise = np.random.default_rng(7)
    with path.open('w', encoding='cp1252', newline='\r\n') as file:
        file.write(HEADING)
        for k in range(0, len(sampled.time), EVERY):
            heat = outputs.temperature[k] - ZERO_CELSIUS + NOISE['temperature'] * noise.standard_normal()
            ohms = outputs.resistance[k] + NOISE['resistance'] * noise.standard_normal()
            stroke = 1e3 * (
                outputs.displacement[k] - outputs.displacement[0] + NOISE['stroke'] * noise.standard_normal()
            )
            row = f'{sampled.time[k]:.2f};{1e3 * outputs.current[k]:.1f};{heat:.2f};{ohms:.3f};{stroke:.3f};60\n'
            file.write(row.replace('.', ','))


if __name__ == '__main__':
    write(CONFIG / 'example_lab_run.csv')

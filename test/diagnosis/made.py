"""Recordings made by the package's own model: for what a fit does with them, never for what is true of a muscle."""

from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import Holding, Imposed
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.muscle import Parameters, simulate

NOMINAL = Parameters.named('karami_tadesse_2017')
TRUE = NOMINAL.replace(hA=0.0225, C=0.15, R0=13.2, a_R=0.0032, k0=26.0, B=1.45)
TIME = np.arange(0.0, 210.0, 0.2)
NOISE = {'temperature': 0.2, 'resistance': 0.02, 'displacement': 5e-5}


def experiment(channels, current=0.27, load=0.588, seed=0, kind='current', drive=None, muscle=TRUE, ambient=None):
    """``ambient`` (K): the room, which its thermometer shows as it usually is."""
    rng = np.random.default_rng(seed)
    heat = np.mod(TIME, 70.0) < 25.0
    drive = np.where(heat, current, 0.0) if drive is None else drive
    out = simulate(muscle, TIME, drive, kind=kind, load=load, ambient=ambient)
    observed = {
        name: Observed(TIME, getattr(out, name) + NOISE[name] * rng.standard_normal(TIME.size), np.ones(TIME.size))
        for name in channels
    }
    imposed = Imposed(
        kind, TIME, drive, np.broadcast_to(load, TIME.shape).astype(float), np.full(TIME.size, NOMINAL['T0'])
    )
    return Experiment('made', imposed, Holding('load', float(np.ravel(load)[0])), observed)


def shown_with(run, course):
    """The same recording, by a sensor that is off by a course (m) over the seconds since it began."""
    shown = run.observed['displacement']
    off = replace(shown, value=shown.value + course(shown.time - shown.time[0]))
    return replace(run, observed={**run.observed, 'displacement': off})

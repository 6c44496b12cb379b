"""A machine of another kind for the engine: a DC motor with a flywheel, driven by a voltage.

    J dw/dt = k i - b w - effects        i = (u - k w) / R

Its recordings are made by an integrator and by forms that are not the model's: friction there is smooth.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numba
import numpy as np
from scipy.integrate import solve_ivp

from tcp_muscle_ros.diagnosis.model.model import Channel, Model, Ratio, Roles, Surroundings
from tcp_muscle_ros.diagnosis.model.unknown import LOG_SPREAD, Unknown
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import Holding, Imposed
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.muscle import Effect
from tcp_muscle_ros.muscle.parameter import Parameter

STEP = 2e-3  # s, of the model
TIME = np.arange(0.0, 120.0, 0.25)  # s
NOISE = {'speed': 0.15, 'current': 4e-3}  # rad/s, A
LEVELS = ((6.0, 0.0, -3.0, 1.5), (2.0, -5.0, 0.0, 4.0), (1.2, 3.0, -1.5, 0.0))  # V, by recording
HELD = 12.0  # s, each level
_SMOOTH = 0.05  # rad/s, over which the friction of the recordings turns round


def _effect(name, stage, strength, usual, high, unit, low=0.0, others=()):
    row = Parameter(strength, usual, unit, low, high, name, 'test')
    return Effect(name, name, stage, '', 'test', (row, *others), {}, strength)


_SLOW = Parameter('tau', 30.0, 's', 5.0, 200.0, 'thermal time constant of the winding', 'test')
_TABLE = (
    Parameter('J', 6e-3, 'kg m^2', 1e-5, 1.0, 'inertia', 'test'),
    Parameter('R', 2.3, 'ohm', 1e-2, 1e3, 'resistance', 'test'),
    Parameter('k', 0.045, 'N m/A', 1e-4, 10.0, 'torque a current', 'test'),
    Parameter('b', 1.2e-4, 'N m s', 1e-8, 1.0, 'viscous friction', 'test'),
)
_EFFECTS = {
    effect.name: effect
    for effect in (
        _effect('dry_friction', 'mechanical', 'torque', 0.01, 0.1, 'N m'),
        _effect('windage', 'mechanical', 'drag', 1e-6, 1e-4, 'N m s^2'),
        _effect('warm_winding', 'electrical', 'rise', 0.02, 1.0, '1/W', others=(_SLOW,)),
        _effect('tachometer_gain', 'sensor', 'gain', 0.02, 0.3, '1', low=-0.3),
    )
}


class Servo(Mapping):
    """Its parameters, and which effects are on."""

    def __init__(self, given=(), effects=()):
        self.given, self.effects = dict(given), tuple(effects)

    def __getitem__(self, name):
        return self.given.get(name, DcServo.specifications[name].value)

    def __iter__(self):
        return iter(DcServo.specifications)

    def __len__(self):
        return len(DcServo.specifications)

    def replace(self, values):
        return Servo(self.given | dict(values), self.effects)

    def with_effects(self, *names):
        return Servo(self.given, (*self.effects, *names))

    def only_effects(self, names):
        return Servo(self.given, names)


@dataclass(frozen=True)
class Shown:
    """What a run shows, a value at each instant."""

    time: np.ndarray
    speed: np.ndarray
    angle: np.ndarray
    current: np.ndarray


@numba.njit
def _run(time, drive, J, R, k, b, friction, drag, rise, tau):
    speed, angle, current = np.zeros(time.size), np.zeros(time.size), np.zeros(time.size)
    w = theta = warm = 0.0
    for n in range(time.size):
        resistance = R * (1.0 + rise * warm)
        speed[n], angle[n], current[n] = w, theta, (drive[n] - k * w) / resistance
        if n + 1 == time.size:
            break
        steps = max(1, round((time[n + 1] - time[n]) / STEP))
        dt = (time[n + 1] - time[n]) / steps
        for _ in range(steps):
            resistance = R * (1.0 + rise * warm)
            i = (drive[n] - k * w) / resistance
            warm += dt * (i * i * resistance - warm) / tau
            moved = w + dt * (k * i - b * w - drag * w * abs(w)) / J
            w = np.sign(moved) * max(abs(moved) - dt * friction / J, 0.0)  # friction stops it, and no more
            theta += dt * w
    return speed, angle, current


@dataclass(frozen=True)
class DcServo(Model):
    """What the engine asks of it."""

    effects: ClassVar = _EFFECTS
    roles: ClassVar = Roles.of(_EFFECTS)
    listed: ClassVar = tuple(_EFFECTS)
    specifications: ClassVar = {row.name: row for row in _TABLE} | {
        f'{effect.name}.{row.name}': row for effect in _EFFECTS.values() for row in effect.parameters
    }
    channels: ClassVar = {
        'speed': Channel('mechanical', 'speed', 'rad/s', 1.0, 0.05, 'test'),
        'current': Channel('electrical', 'current', 'A', 1.0, 1e-3, 'test'),
        'angle': Channel('mechanical', 'angle', 'rad', 1.0, 1e-3, 'test', floating=True),
    }
    surroundings: ClassVar = Surroundings(0.0, 1.0, 'it does not depend on them')
    state: ClassVar = 'speed'
    state_title: ClassVar = 'speed'
    state_unit: ClassVar = 'rad/s'
    gauge: ClassVar = 'speed'
    motion: ClassVar = 'angle'
    gain: ClassVar = ''
    capacity: ClassVar = 'J'
    slowness: ClassVar = 'J/b'
    coarse: ClassVar = ('J', 'R')
    separate: ClassVar = ('J', 'R', 'k', 'b')
    ratios: ClassVar = (Ratio('J/b', 'J', 'b', 's'),)
    shown_by: ClassVar = {'electrical': frozenset({'current'})}
    laws: ClassVar = {}

    def simulate(self, recorded, parameters, start, resolution, only, ambient):
        on = {name: name in parameters.effects for name in self.effects}
        imposed = recorded.imposed
        speed, angle, current = _run(
            imposed.time,
            imposed.drive,
            *(parameters[name] for name in 'JRkb'),
            on['dry_friction'] * parameters['dry_friction.torque'],
            on['windage'] * parameters['windage.drag'],
            on['warm_winding'] * parameters['warm_winding.rise'],
            parameters['warm_winding.tau'],
        )
        gain = 1.0 + on['tachometer_gain'] * parameters['tachometer_gain.gain']
        return Shown(imposed.time, gain * speed, angle, current)

    def steps(self, recorded, parameters, resolution):
        return float(recorded.imposed.time.size)

    def strained(self, outputs):
        return 0.0

    def time_constant(self, parameters):
        return parameters['J'] / (parameters['b'] + parameters['k'] ** 2 / parameters['R'])

    def exposed(self, parameters, outputs):
        return outputs.angle

    def unknowns(self, recordings, nominal, separate):
        return [
            Unknown(row.name, nominal[row.name], row.low, row.high, LOG_SPREAD, log=True)
            for row in (self.specifications[name] for name in 'JRkb')
        ]


def recordings(seed, friction=0.0, drag=0.0):
    """Three of one servo, whose numbers the nominal ones miss by a fifth: with dry friction (N m), and with drag
    (N m s^2)."""
    J, R, k, b = 5e-3, 2.0, 0.05, 1e-4
    rng = np.random.default_rng(seed)

    def rate(_, state, u):
        (w,) = state
        return [(k * (u - k * w) / R - b * w - drag * w * abs(w) - friction * np.tanh(w / _SMOOTH)) / J]

    made = []
    for number, levels in enumerate(LEVELS):
        drive = np.array(levels)[(TIME // HELD).astype(int) % len(levels)]
        speed, at = np.zeros(TIME.size), 0
        while at < TIME.size - 1:  # from switch to switch
            end = min(at + round(HELD / TIME[1]), TIME.size - 1)
            span, u = TIME[at : end + 1], drive[at]
            run = solve_ivp(
                rate, (span[0], span[-1]), [speed[at]], 'LSODA', span, args=(u,), rtol=1e-8, atol=1e-9, max_step=0.5
            )
            speed[at : end + 1], at = run.y[0], end
        seen = {'speed': speed, 'current': (drive - k * speed) / R}
        observed = {
            name: Observed(TIME, value + NOISE[name] * rng.standard_normal(TIME.size), np.ones(TIME.size))
            for name, value in seen.items()
        }
        imposed = Imposed('voltage', TIME, drive, np.zeros(TIME.size), np.full(TIME.size, 293.0))
        made.append(Experiment(f'run {number + 1}', imposed, Holding('load', 0.0), observed, model=DcServo()))
    return made

"""Recordings of the independent truth generator in which nothing is concealed, and what a lab can do to them."""

import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from proof.cases import make_case
from proof.protocols import Step, build
from proof.recordings import INPUTS, START_NS, instrument, write
from proof.truth import Bench, observe

CHANNELS = ('temperature', 'resistance', 'displacement')
RATE = 10.0  # Hz


@cache
def sound(load=0.5884, on=(3, 1), level=None, kind='current', blocked=False):
    """Two heatings of 25 s, 35 s of cooling after each: (experiment, channels), channels as (ticks, values).

    ``level``: a current (A) held throughout instead. ``kind``: which input the source holds.
    ``blocked``: the end is held, and its force recorded in place of the displacement.
    """
    case = make_case('development', 4711, 0, 'null', '')
    lab = replace(case.lab, rate=RATE, kind=INPUTS.index(kind))
    steps = [Step(5.0, 0.0, load)]
    for current in on:
        steps += [Step(25.0, lab.currents()[current], load), Step(35.0, 0.0, load)]
    if level is not None:
        steps = [Step(90.0, level, load)]
    rng = np.random.default_rng([7, round(1e3 * load)])  # a recording has noise of its own, or it would be no noise
    done = build(lab, 'heated twice', steps, rng, blocked=blocked)
    channels = ('temperature', 'resistance', 'force') if blocked else CHANNELS
    noise = {name: replace(each, bursts=0, quantum=0.0) for name, each in case.noise.items()}
    return done, instrument(observe(Bench.of(lab.body), done), done, noise, channels, rng)


def write_bag(path, experiment, channels):
    """The bag, as the truth generator writes it."""
    write(path, experiment, channels, 0.04, START_NS, np.random.default_rng(8))
    return path


def without(*names):
    return lambda e, c: (e, {n: v for n, v in c.items() if n not in names})


def added(name, level, scatter=0.0):
    """A channel that stays at a level, with noise, and that ``write_bag`` puts on the topic of its name."""

    def add(e, c):
        noise = scatter * np.random.default_rng(9).standard_normal(len(e.time))
        return e, {**c, name: (np.arange(len(e.time)), level + noise)}

    return add


def swapped(a, b):
    return lambda e, c: (e, {**c, a: c[b], b: c[a]})


def changed(name, change):
    return lambda e, c: (e, {**c, name: (c[name][0], change(c[name][1]))})


def frozen(share):
    """The value at this share of the recording stays."""

    def freeze(value):
        k = int(share * len(value))
        return np.append(value[:k], np.full(len(value) - k, value[k]))

    return freeze


def some_nan(value):
    value = value.copy()
    value[::17] = np.nan
    return value


def kept(inside):
    """Only the samples at instants that satisfy ``inside``."""
    return lambda e, c: (e, {n: (k[inside(e.time[k])], v[inside(e.time[k])]) for n, (k, v) in c.items()})


def glued(until, pause):
    """The first seconds, then, after a pause (s), the whole run from its cold start."""

    def glue(e, c):
        k = int(np.searchsorted(e.time, until))
        time = np.concatenate([e.time[:k], e.time + e.time[k - 1] + pause])
        both = replace(
            e, time=time, drive=np.concatenate([e.drive[:k], e.drive]), load=np.concatenate([e.load[:k], e.load])
        )
        return both, {n: (np.concatenate([w[w < k], w + k]), np.concatenate([v[w < k], v])) for n, (w, v) in c.items()}

    return glue


def set_back(seconds):
    """The clock is set back halfway."""

    def turn(e, c):
        time = e.time.copy()
        time[len(time) // 2 :] -= seconds
        return replace(e, time=time), c

    return turn

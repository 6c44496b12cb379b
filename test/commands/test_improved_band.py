"""improved.yaml has intervals beside it: its replay of a new recording has a band, neither nothing nor everything."""

import json
from contextlib import redirect_stdout
from io import StringIO

import numpy as np
import pytest

from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.settings.intervals import path_beside, variants
from tcp_muscle_ros.settings.parameter_file import read, write
from tcp_muscle_ros.settings.rig import on_rig, read_rig
from tcp_muscle_ros.tool import main

pytestmark = pytest.mark.slow

MUSCLE = (
    Parameters.named('karami_tadesse_2017').with_effects('creep').replace({'creep.J': 0.25, 'hA': 0.0203, 'k0': 25.0})
)
NOISE = {'temperature': 0.15, 'resistance': 0.02, 'displacement': 4e-5}
SENSORS = {'temperature_noise_k': 0.15, 'resistance_noise_ohm': 0.02, 'displacement_noise_m': 4e-5}
DIAGNOSED = """rate_hz: 4
input: current
repeat: 3
segments:
  - {duration_s: 30, value: 0.27}
  - {duration_s: 40, value: 0.02}
"""
NEW = """rate_hz: 4
input: current
segments:
  - {duration_s: 10, value: 0.0}
  - {duration_s: 50, value: 0.22}
  - {duration_s: 50, value: [0.05, 0.3]}
  - {duration_s: 40, value: 0.0}
"""


def tool(*words):
    with redirect_stdout(StringIO()):
        assert main([str(word) for word in words]) == 0


def record(folder, name, protocol, load, **sensors):
    write(folder / f'{name}.yaml', MUSCLE, operating={'load_n': load, 'seed': len(name), **sensors})
    (folder / 'protocol.yaml').write_text(f'load_n: {load}\n{protocol}')
    tool('simulate', folder / 'protocol.yaml', '--params', folder / f'{name}.yaml', '--output', folder / name)


@pytest.fixture(
    scope='module', params=[pytest.param((0.5, 1.2), marks=pytest.mark.long), (0.5,)], ids=['two loads', 'one load']
)
def lab(request, tmp_path_factory):
    """A diagnosis of a muscle that creeps, and what it does under another load and another current, without noise."""
    folder = tmp_path_factory.mktemp('lab')
    bags = [folder / f'{"old" * k}' for k in range(1, 1 + len(request.param))]
    for bag, load in zip(bags, request.param, strict=True):
        record(folder, bag.name, DIAGNOSED, load, **SENSORS)
    tool('diagnose', *bags, '--output', folder / 'report')
    record(folder, 'new', NEW, 0.8, **SENSORS)
    record(folder, 'truth', NEW, 0.8)
    return folder


def test_the_band_of_a_new_recording_is_as_wide_as_the_error_and_far_narrower_than_what_is_predicted(lab):
    improved = lab / 'report' / 'improved.yaml'
    tool('replay', lab / 'new', '--params', improved, '--output', lab / 'over', '--figure', lab / 'over.png', '--force')
    truth = read_bag(lab / 'truth')
    low, high = (read_bag(lab / 'over', namespace=f'predicted_{side}') for side in ('low', 'high'))
    for name, noise in NOISE.items():
        half, middle = 0.5 * (high[name].value - low[name].value), 0.5 * (high[name].value + low[name].value)
        missed = middle - truth[name].value
        missed = np.sqrt(np.mean((missed - np.mean(missed)) ** 2))  # zeros are each recording's own
        wide = np.sqrt(np.mean(half**2))
        assert np.all(half >= 0.0) and 0.0 < wide < 0.01 * np.ptp(truth[name].value), name
        assert missed < wide + 0.1 * noise, name


def test_the_file_holds_what_improved_yaml_holds_and_its_intervals_lie_about_that(lab):
    improved = lab / 'report' / 'improved.yaml'
    muscle, content = read(improved).parameters, json.loads(path_beside(improved).read_text())
    names = [row['name'] for row in content['parameters']]
    assert names == [row['name'] for row in content['coordinates']]
    assert {'hA', 'C', 'R0', 'k0', 'B', 'creep.J'} <= set(names)
    assert {name.split('.')[0] for name in names if '.' in name} <= set(muscle.effects)
    for row in content['parameters']:
        assert row['low'] <= row['value'] <= row['high'] and row['low'] < row['high'], row['name']
        assert row['value'] == pytest.approx(muscle[row['name']], rel=1e-9)
    one, k0 = len(list(lab.glob('old*.yaml'))) == 1, names.index('k0')
    assert (content['covariance'][k0][k0] > 0.02**2) is one  # one load hardly tells it, whatever the fit says


def test_a_twin_draws_muscles_from_it_on_its_rig(lab):
    improved, rig = lab / 'report' / 'improved.yaml', read_rig(lab / 'report' / 'rig.yaml')
    muscle = read(improved).parameters
    drawn = [on_rig(one, rig) for one in variants(improved, muscle).values()]
    assert len({one['creep.J'] for one in drawn}) == len(drawn) > 1
    assert all(one.effects == on_rig(muscle, rig).effects for one in drawn)

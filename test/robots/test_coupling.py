"""Muscles on the tendons of a simulated robot: the muscle's own law, stable, with its energy accounted for."""

import re
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Muscle, Parameters, simulate
from tcp_muscle_ros.robots.robot import Robot

mujoco = pytest.importorskip('mujoco', reason="needs MuJoCo (extra 'mujoco', Python 3.11 and later)")

PAPER = Parameters.named('karami_tadesse_2017')
ARM = ('shoulder_flexor', 'shoulder_extensor', 'elbow_flexor', 'elbow_extensor')
FINGER = ('knuckle_flexor', 'knuckle_extensor', 'middle_flexor', 'middle_extensor')
WEIGHT = """
<mujoco>
  <option timestep="{step}" integrator="{integrator}"/>
  <worldbody>
    <site name="ceiling" pos="0 0 0.5"/>
    <body name="weight"><joint name="lift" type="slide" axis="0 0 1"/><geom size="0.01" mass="{mass}"/>
      <site name="hook"/></body>
  </worldbody>
  <tendon><spatial name="muscle"><site site="ceiling"/><site site="hook"/></spatial></tendon>
  <actuator><general name="muscle" tendon="muscle" biastype="affine" gainprm="{gain}" biasprm="0 0 0"/></actuator>
</mujoco>
"""


def made(robot, names, model=PAPER, load=0.4):
    return Robot(robot, {name: Muscle(model, end='blocked', load=load) for name in names})


def weight(model=PAPER, step=0.002, mass=0.04, load=0.4, integrator='implicitfast', gain=-1):
    text = WEIGHT.format(step=step, mass=mass, integrator=integrator, gain=gain)
    return made(mujoco.MjModel.from_xml_string(text), ('muscle',), model, load)


@pytest.mark.parametrize(('robot', 'names'), [('arm', ARM), ('finger', FINGER)])
def test_a_pulley_has_one_radius_over_the_whole_turn(robot, names):
    it = made(robot, names)
    for joint in {name.rsplit('_', 1)[0] for name in names}:
        low, high = it.model.joint(joint).range
        pulley = it.model.geom(f'{joint}_pulley').size[0]
        angles, lengths = np.linspace(low, high, 15), []
        for angle in angles:
            it.reset({joint: angle})
            lengths.append(it.lengths())
        arms = -np.diff(np.array(lengths), axis=0).T / np.diff(angles)
        for name, arm in zip(names, arms, strict=True):
            wanted = 0.0 if not name.startswith(joint) else pulley if name.endswith('flexor') else -pulley
            assert np.abs(arm - wanted).max() < 1e-6, (joint, name)


def test_a_hanging_weight_is_the_muscle_under_that_load():
    """Temperatures are the muscle's own to the last bit; its length follows the load model once a swing has died."""
    it = weight()
    it.model.dof_damping[0] = 0.5
    time, current = np.arange(0.0, 30.0, 0.002), 0.2
    alone = simulate(PAPER, time, current, load=0.04 * 9.81)
    it.step([current], len(time) - 1)
    assert it.temperatures[0] == pytest.approx(alone.temperature[-1], abs=1e-9)
    it.step([current], 1)
    assert it.lengths()[0] == pytest.approx(alone.length[-1], abs=2e-5)
    assert it.tensions[0] == pytest.approx(0.04 * 9.81, rel=1e-3)


def test_it_is_stable_where_an_explicit_spring_explodes():
    """An arm of a tenth of a gram on 20 N/mm at 5 ms: 20 rad a step, where an explicit spring ends at 2."""
    stiff = PAPER.replace(k0=2e4)
    it = made('arm', ARM, stiff, load=400.0)
    it.model.opt.timestep = 0.005
    it.model.body_mass[2:] *= 0.01
    it.model.body_inertia[2:] *= 0.01
    it = Robot(it.model, {name: Muscle(stiff, end='blocked', load=400.0) for name in ARM})
    forearm = it.model.body('forearm')
    inertia = forearm.inertia.max() + forearm.mass[0] * forearm.ipos[2] ** 2
    assert np.sqrt(2.0 * stiff['k0'] * 0.012**2 / inertia) * 0.005 > 20.0
    it.data.qvel[:] = 5.0
    it.step([0.0, 0.0, 0.0, 0.0], 400)
    assert np.abs(it.data.qpos).max() < 1e-9 and np.abs(it.data.qvel).max() < 1e-9
    assert it.tensions == pytest.approx(400.0)


def test_stiff_and_slack_in_turn_it_stays_within_what_gravity_does_in_a_step():
    it = weight(PAPER.replace(k0=2e4), step=0.005, mass=1e-3, load=0.1)
    it.data.qvel[0] = 0.3
    it.step([0.0], 200)
    for _ in range(200):
        it.step([0.0], 1)
        assert abs(it.data.qpos[0]) < 3.0 * 9.81 * 0.005**2


def test_a_slack_tendon_neither_pulls_nor_pushes():
    """Thrown up, the weight flies as if there were no muscle; where it falls taut again, it is caught."""
    it = weight(mass=0.02, load=0.2)
    it.data.qvel[0] = 0.8
    it.step([0.0], 10)
    flown, before, v = [], it.data.qpos[0], it.data.qvel[0]
    while it.tensions[0] == 0.0:
        it.step([0.0], 1)
        flown.append((it.data.time, it.data.qpos[0]))
    assert len(flown) > 50
    t = np.array(flown[:-2])
    since = t[:, 0] - 0.02
    assert t[:, 1] == pytest.approx(before + v * since - 0.5 * 9.81 * since**2, abs=1e-4 + 9.81 * 0.002 * since.max())
    it.model.dof_damping[0] = 0.05
    it.step([0.0], 5000)
    assert it.tensions[0] == pytest.approx(0.02 * 9.81, rel=1e-2)


def swung(step, seconds):
    """The arm with currents that come and go, at a step of the simulator."""
    it = made('arm', ARM)
    it.model.opt.timestep = step
    it = Robot(it.model, {name: Muscle(PAPER, end='blocked', load=0.4) for name in ARM})
    drawn = np.random.default_rng(5).uniform(0.0, 0.27, (round(seconds / 0.5), 4))
    for row in drawn:
        it.advance(0.5, row)
    return it.book()


def test_energy_of_a_minute():
    """Within 1 % of the input (which is far more than 1 % of the work), and within 1 % of the work that was done."""
    book = swung(0.002, 60.0)
    assert book.heated > 30.0 and book.by_heat > 0.02
    assert abs(book.error) < 1e-4
    assert abs(book.heat_error) < 1e-9 * book.heated
    assert abs(book.work_error) < 0.01 * book.by_heat


def test_the_error_halves_with_the_step():
    errors = [swung(step, 6.0).work_error for step in (0.004, 0.002, 0.001)]
    for coarse, fine in pairwise(errors):
        assert coarse / fine == pytest.approx(2.0, rel=0.15)


def test_what_the_muscles_do_the_bodies_get():
    """By the simulator's own energy: what it gained, and what its dampers took, came by the tendons."""
    it = made('arm', ARM)
    it.model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    it.reset()
    begin, damped = it.data.energy.sum(), 0.0
    for k in range(5000):
        it.step([0.27 * (k < 2500), 0.0, 0.0, 0.2], 1)
        damped += it.model.opt.timestep * float(it.model.dof_damping @ it.data.qvel**2)
    mujoco.mj_forward(it.model, it.data)
    gained = it.data.energy.sum() - begin
    assert -it.book().work == pytest.approx(gained + damped, rel=0.02)
    assert gained > 3e-4


def test_cut_wire_and_cut_cable():
    it = made('arm', ARM)
    it.step([0.2] * 4, 2000)
    hot, heated = it.temperatures.copy(), it.tendons.muscles[0].heated
    it.cut_wire('shoulder_flexor')
    it.cut_cable('shoulder_extensor')
    it.step([0.2] * 4, 2500)
    assert it.tendons.muscles[0].heated == heated and it.temperatures[0] < hot[0] - 3.0
    assert it.tensions[1] == 0.0 and it.temperatures[1] > hot[1]
    assert np.isfinite(it.data.qpos).all()
    it.reset()
    it.step([0.2] * 4, 10)
    assert it.tensions[1] > 0.3 and it.tendons.muscles[0].heated > 0.0


def test_what_does_not_fit_is_said():
    with pytest.raises(BadInput, match="no tendon 'elbo_flexor'; did you mean 'elbow_flexor'"):
        made('arm', ('elbo_flexor',))
    with pytest.raises(BadInput, match="unknown robot 'fingers'; did you mean 'finger'"):
        made('fingers', FINGER)
    with pytest.raises(BadInput, match='implicitfast'):
        weight(integrator='Euler')
    with pytest.raises(BadInput, match=r"actuator 'muscle' .*gainprm='-1'"):
        weight(gain=1)
    with pytest.raises(BadInput, match='whole number'):
        weight().advance(0.003, [0.0])
    with pytest.raises(BadInput, match="no muscle 'musle'; did you mean 'muscle'"):
        weight().cut_wire('musle')


@pytest.mark.parametrize(
    ('wrong', 'said'),
    [
        ('gear="2"', 'has gear 2'),
        ('ctrlrange="0 0.2"', 'has a ctrlrange'),
        ('forcerange="-0.2 0"', 'has a forcerange'),
        ('biasprm="0.1 0 0"', 'has biasprm 0.1 0'),
        ('dyntype="filter" dynprm="0.1"', 'has a dyntype'),
        ('gaintype="affine"', 'has a gain that is not fixed'),
        ('joint="lift"', 'does not act on the tendon of its name'),
        ('tendon="other"', 'does not act on the tendon of its name'),
    ],
)
def test_an_actuator_that_would_pull_with_another_force_is_refused(wrong, said):
    """It gets the tension of the muscle, and the book and the muscle take it to be what pulls."""
    text = WEIGHT.format(step=0.002, integrator='implicitfast', mass=0.04, gain=-1)
    other = '<spatial name="other"><site site="ceiling"/><site site="hook"/></spatial></tendon>'
    for given in ('tendon', 'biasprm'):
        if wrong.startswith((given, 'joint')):
            text = re.sub(rf' {given}="(muscle|0 0 0)"', '', text)
    text = text.replace('</tendon>', other).replace('biastype="affine"', f'biastype="affine" {wrong}')
    with pytest.raises(BadInput, match=f"actuator 'muscle' {said}, which .* expected <general") as refused:
        made(mujoco.MjModel.from_xml_string(text), ('muscle',))
    assert '\n' not in str(refused.value)


@pytest.mark.parametrize('pose', [{}, {'knuckle': 0.8}])
def test_a_reset_forgets_the_pose_before(pose):
    """A muscle that creeps is settled at its length in the new pose, whatever it was in the last."""
    creeps = PAPER.replace({'creep.J': 0.4}).with_effects('creep')
    fresh, used = made('finger', FINGER, creeps), made('finger', FINGER, creeps)
    mounted = fresh.tensions.copy()
    used.step([0.25, 0.0, 0.25, 0.0], 500)
    for it in (fresh, used):
        it.reset(pose)
    first = fresh.tensions.copy()
    assert np.array_equal(used.tensions, first)
    fresh.reset(pose)
    assert np.array_equal(fresh.tensions, first)
    assert pose or first == pytest.approx(mounted, rel=1e-9)


def test_a_motion_without_bounds_ends_with_one_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log of its own where it runs
    it = weight()
    it.data.qvel[0] = 1e12
    with pytest.raises(BadInput, match='the motion diverges at'):
        it.step([0.1], 100)


def held(**more):
    return {name: Muscle(PAPER, load=0.4, **{'end': 'blocked', **more}) for name in ARM}


ONE = Muscle(PAPER, end='blocked', load=0.4)


@pytest.mark.parametrize(
    ('call', 'said'),
    [
        (lambda: Robot('arm', {}), 'without muscles'),
        (lambda: Robot('arm', held(end='load')), "'shoulder_flexor': a robot holds the ends .* end='blocked'"),
        (lambda: Robot('arm', held(end='spring', spring_rate=10.0)), "expected Muscle\\(..., end='blocked'\\)"),
        (
            lambda: Robot('arm', dict.fromkeys(ARM, ONE)),
            "'shoulder_extensor' and 'shoulder_flexor' are one and the same",
        ),
        (lambda: made('arm', ARM).take([ONE]), '^1 muscles for 4; expected one each for shoulder_flexor, '),
        (lambda: made('arm', ARM).take([ONE] * 4), 'are one and the same muscle'),
        (lambda: made('arm', ARM).take(held(end='load').values()), 'a robot holds the ends of its muscles'),
    ],
)
def test_muscles_that_it_cannot_hold_are_refused(call, said):
    with pytest.raises(BadInput, match=said):
        call()


def test_a_muscle_whose_cable_is_cut_may_get_other_properties():
    it = made('arm', ARM)
    it.cut_cable('elbow_flexor')
    it.take(it.tendons.muscles)
    it.step([0.1] * 4)
    assert it.tensions[ARM.index('elbow_flexor')] == 0.0


def test_what_it_shows_is_kept_as_it_was():
    it = made('arm', ARM)
    temperatures, tensions = it.temperatures, it.tensions
    before = temperatures.copy(), tensions.copy()
    it.step([0.25] * 4, 500)
    np.testing.assert_array_equal((temperatures, tensions), before)
    assert (it.temperatures > temperatures).all()
    it.tensions[:] = 99.0
    assert it.tensions.max() < 99.0


def test_a_model_is_a_path_too(tmp_path):
    path = tmp_path / 'own.xml'
    path.write_text(WEIGHT.format(step=0.002, mass=0.04, integrator='implicitfast', gain=-1))
    assert made(path, ('muscle',)).names == ('muscle',)


def test_without_mujoco_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(__import__('sys').modules, 'mujoco', None)
    with pytest.raises(BadInput, match=r"pip install '\.\[mujoco\]' in the checkout"):
        made('arm', ARM)


def test_after_compiling_ahead_no_start_compiles_a_robots_muscles():
    subprocess.run([sys.executable, '-m', 'tcp_muscle_ros.robots'], check=True, timeout=300, stdout=subprocess.DEVNULL)
    program = (
        'from tcp_muscle_ros.muscle import Muscle, Parameters; from tcp_muscle_ros.robots.coupling import *; '
        "Tendons([Muscle(Parameters.named('karami_tadesse_2017'), end='blocked', load=0.5)]); "
        'print(sum(couple.stats.cache_hits.values()), sum(couple.stats.cache_misses.values()))'
    )
    done = subprocess.run([sys.executable, '-c', program], check=True, timeout=300, capture_output=True, text=True)
    assert done.stdout.split() == ['1', '0']

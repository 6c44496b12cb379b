"""One source for a robot: its URDF is made from its MJCF, and gravity by the URDF is MuJoCo's own."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from tcp_muscle_ros.control.gravity import Gravity
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.robots.controlled import joints_of
from tcp_muscle_ros.robots.models import ROBOTS, load
from tcp_muscle_ros.robots.urdf import urdf

mujoco = pytest.importorskip('mujoco', reason="needs MuJoCo (extra 'mujoco', Python 3.11 and later)")
ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize('robot', ROBOTS)
def test_the_urdf_is_what_the_mjcf_makes(robot):
    assert (ROOT / 'urdf' / f'{robot}.urdf').read_text(encoding='utf-8') == urdf(robot), 'run scripts/make_urdf.py'


@pytest.mark.parametrize('robot', ROBOTS)
def test_mujoco_reads_the_urdf_as_the_same_robot(robot):
    """Masses, inertias and joint axes in a pose; the palm's ball and what does not move are no part of it."""
    text = (ROOT / 'urdf' / f'{robot}.urdf').read_text(encoding='utf-8')
    mine, theirs = load(robot), mujoco.MjModel.from_xml_string(text)
    poses = {joint: 0.3 * (k + 1) for k, joint in enumerate(joints_of(robot))}
    found = []
    for model in (mine, theirs):
        data = mujoco.MjData(model)
        for joint, angle in poses.items():
            data.qpos[model.joint(joint).qposadr] = angle
        mujoco.mj_forward(model, data)
        places = [int(model.jnt_dofadr[model.joint(joint).id]) for joint in poses]
        full = np.zeros((model.nv, model.nv))
        for k in range(model.nv):  # column by column: M e_k
            mujoco.mj_mulM(model, data, full[k], np.eye(model.nv)[k])
        found.append((full[np.ix_(places, places)], data.qfrc_bias[places]))
    assert found[0][0] == pytest.approx(found[1][0], rel=1e-5)
    assert found[0][1] == pytest.approx(found[1][1], rel=1e-5)


@pytest.mark.parametrize('robot', ROBOTS)
def test_gravity_is_that_of_mujoco_in_every_pose_and_direction(robot):
    gravity, model, chance = Gravity(urdf(robot)), load(robot), np.random.default_rng(1)
    data = mujoco.MjData(model)
    for _ in range(20):
        pose = {joint: chance.uniform(-1.2, 1.2) for joint in joints_of(robot)}
        model.opt.gravity[:] = chance.normal(0.0, 5.0, 3)
        for joint, angle in pose.items():
            data.qpos[model.joint(joint).qposadr] = angle
        mujoco.mj_forward(model, data)
        torques = gravity.torques(pose, model.opt.gravity)
        for joint in pose:
            held = data.qfrc_bias[int(model.jnt_dofadr[model.joint(joint).id])]
            assert torques[joint] == pytest.approx(held, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize('robot', ROBOTS)
def test_a_muscle_ends_where_its_tendon_does_and_the_camera_looks_where_mujocos_does(robot):
    """In a pose, by MuJoCo's reading of the URDF whose fixed frames are kept."""
    described = ElementTree.fromstring(urdf(robot))
    ElementTree.SubElement(ElementTree.SubElement(described, 'mujoco'), 'compiler', fusestatic='false')
    mine, theirs = load(robot), mujoco.MjModel.from_xml_string(ElementTree.tostring(described, encoding='unicode'))
    posed = []
    for model in (mine, theirs):
        data = mujoco.MjData(model)
        for k, joint in enumerate(joints_of(robot)):
            data.qpos[model.joint(joint).qposadr] = 0.3 * (k + 1)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_camlight(model, data)
        posed.append(data)
    data, said = posed
    for joint in joints_of(robot):
        for muscle in (f'{joint}_flexor', f'{joint}_extensor'):
            end = said.body(f'{muscle}_moving_end').xpos
            assert end == pytest.approx(data.site(f'{muscle}_end').xpos, abs=1e-9)
    camera, optical, ahead = data.camera('side'), said.body('camera_optical_frame'), said.body('camera')
    assert optical.xpos == pytest.approx(camera.xpos, abs=1e-9) and ahead.xpos == pytest.approx(camera.xpos, abs=1e-9)
    right, up, back = camera.xmat.reshape(3, 3).T
    assert np.abs(optical.xmat.reshape(3, 3).T - [right, -up, -back]).max() < 1e-6
    assert np.abs(ahead.xmat.reshape(3, 3).T - [-back, -right, up]).max() < 1e-6


def test_the_pulleys_are_those_of_the_controllers_parameters():
    import yaml

    values = yaml.safe_load((ROOT / 'config' / 'finger.yaml').read_text())['/**']['ros__parameters']
    model = load('finger')
    assert values['joints'] == list(joints_of('finger'))
    for joint in values['joints']:
        row, turn = values[joint], model.joint(joint)
        assert row['radius_m'] == model.geom(f'{joint}_pulley').size[0]
        assert [row['low_rad'], row['high_rad']] == turn.range.tolist()
        assert {row['agonist'], row['antagonist']} <= set(values['muscles'])


def test_what_is_no_description_is_said():
    with pytest.raises(BadInput, match='no XML'):
        Gravity('<robot')
    with pytest.raises(BadInput, match="link 'b' hangs on a joint that is prismatic"):
        Gravity(
            '<robot><link name="a"/><link name="b"/><joint name="j" type="prismatic">'
            '<parent link="a"/><child link="b"/></joint></robot>'
        )
    with pytest.raises(BadInput, match="no turning joint 'elbo'; did you mean 'elbow'"):
        Gravity(ElementTree.tostring(ElementTree.fromstring(urdf('arm')), encoding='unicode')).torques({'elbo': 0.0})


LIMB = (
    '<robot><link name="trunk"/><link name="limb">'
    '<inertial><mass value="0.1"/><origin xyz="0.03 0 0"/></inertial></link>'
    '<joint name="knee" type="revolute"><parent link="trunk"/><child link="limb"/><origin xyz="0 0 0" rpy="0 0 0"/>'
    '<axis xyz="0 1 0"/></joint></robot>'
)


@pytest.mark.parametrize(
    ('right', 'wrong', 'said'),
    [
        ('value="0.1"', 'value="${mass}"', r"<mass value='\$\{mass\}'> in link 'limb'; expected a number; run xacro"),
        ('value="0.1"', 'value="nan"', "<mass value='nan'> in link 'limb'; expected a number$"),
        ('xyz="0.03 0 0"', 'xyz="0.03 0"', "<origin xyz='0.03 0'> in link 'limb'; expected 3 numbers"),
        ('rpy="0 0 0"', 'rpy="0"', "<origin rpy='0'> in joint 'knee'; expected 3 numbers"),
        ('xyz="0 1 0"', 'xyz="0,1,0"', "<axis xyz='0,1,0'> in joint 'knee'; expected 3 numbers"),
        ('xyz="0 1 0"', 'xyz="0 0 0"', "joint 'knee' turn about the axis 0 0 0; expected a direction"),
        ('<child link="limb"/>', '', "no <child link='...'> in joint 'knee'"),
        ('<parent link="trunk"/>', '<parent/>', "no <parent link='...'> in joint 'knee'"),
    ],
)
def test_what_is_wrong_in_a_description_is_named_with_its_link_or_joint(right, wrong, said):
    with pytest.raises(BadInput, match=said):
        Gravity(LIMB.replace(right, wrong))


@pytest.mark.parametrize(
    ('right', 'wrong'), [('"revolute"', '"fixed"'), ('<axis xyz="0 1 0"/>', ''), ('<mass value="0.1"/>', '')]
)
def test_a_fixed_joint_may_have_no_axis_and_what_is_left_out_has_its_default(right, wrong):
    limb = LIMB.replace(right, wrong)
    limb = limb.replace('xyz="0 1 0"', 'xyz="0 0 0"') if 'fixed' in limb else limb
    hand = '<link name="hand"><inertial><mass value="1"/></inertial></link><joint name="wrist" type="revolute">'
    hand += '<parent link="limb"/><child link="hand"/><origin xyz="0 0 0.1"/><axis xyz="0 1 0"/></joint></robot>'
    torques = Gravity(limb.replace('</robot>', hand)).torques({'wrist': 0.0})
    assert torques and all(abs(torque) < 1.0 for torque in torques.values())  # False for NaN

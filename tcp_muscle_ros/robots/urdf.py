"""A robot's URDF, made from its MJCF: one source for the links, joints, masses and inertias of both.

Links are the bodies; what floats freely (a ball to be grasped) is no part of the robot. A capsule becomes a cylinder
with two spheres. Muscles are in neither description's links: their cables weigh nothing. Frames without mass are where
each ends (``<muscle>_moving_end``, where the tendon holds its link) and where pictures are taken from (``camera``).
"""

from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.robots.models import OPTICAL, VIEW, load, mujoco, root

# MJCF's camera looks along -z, a link along x.
_LOOKING = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])
_SIDEWAYS = '-1.57079633 0 -1.57079633'  # rpy of an optical frame, z ahead and y down, on the camera's link
_EFFORT, _SPEED = 0.02, 5.0  # N m and rad/s: of the muscles that come along, for those who plan motions


def _text(values: ArrayLike) -> str:
    return ' '.join(f'{value:.9g}' for value in np.round(np.atleast_1d(np.asarray(values, dtype=np.float64)), 12) + 0.0)


def _rpy(quaternion: NDArray[np.float64]) -> str:
    """Roll, pitch and yaw of a unit quaternion (w, x, y, z)."""
    w, x, y, z = quaternion
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return _text([roll, pitch, np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))])


def _origin(parent: Element, place: NDArray[np.float64], quaternion: NDArray[np.float64]) -> None:
    SubElement(parent, 'origin', xyz=_text(place), rpy=_rpy(quaternion))


class _Writer:
    def __init__(self, robot: str) -> None:
        self.mj, self.m = mujoco(), load(robot)
        self.root = Element('robot', name=robot)
        self.turning: list[str] = []

    def _name(self, kind: str, number: int) -> str:
        return str(self.mj.mj_id2name(self.m, getattr(self.mj.mjtObj, f'mjOBJ_{kind}'), number))

    def write(self) -> str:
        free = {int(self.m.jnt_bodyid[j]) for j in range(self.m.njnt) if self.m.jnt_type[j] == 0}
        for body in range(1, self.m.nbody):
            if body not in free:
                self._link(body)
                self._joint(body)
        self._ends(free)
        self._camera()
        self._control()
        ElementTree.indent(self.root)
        note = f'<!-- Made from {self.root.get("name")}.xml by scripts/make_urdf.py; change that. -->'
        return f'<?xml version="1.0"?>\n{note}\n{ElementTree.tostring(self.root, encoding="unicode")}\n'

    def _link(self, body: int) -> None:
        m = self.m
        link = SubElement(self.root, 'link', name=self._name('BODY', body))
        inertial = SubElement(link, 'inertial')
        _origin(inertial, m.body_ipos[body], m.body_iquat[body])
        SubElement(inertial, 'mass', value=_text(m.body_mass[body]))
        xx, yy, zz = (_text(value) for value in m.body_inertia[body])
        SubElement(inertial, 'inertia', ixx=xx, iyy=yy, izz=zz, ixy='0', ixz='0', iyz='0')
        for geom in range(m.body_geomadr[body], m.body_geomadr[body] + m.body_geomnum[body]):
            for use in ('visual', 'collision') if m.geom_contype[geom] else ('visual',):
                self._shape(link, use, geom)

    def _shape(self, link: Element, use: str, geom: int) -> None:
        m, kinds = self.m, self.mj.mjtGeom
        size, place, turn = m.geom_size[geom], m.geom_pos[geom], m.geom_quat[geom]
        axis = np.zeros(3)
        self.mj.mju_rotVecQuat(axis, np.array([0.0, 0.0, size[1]]), turn)
        shapes: dict[int, list[tuple[str, dict[str, str], NDArray[np.float64]]]] = {
            int(kinds.mjGEOM_BOX): [('box', {'size': _text(2.0 * size)}, place)],
            int(kinds.mjGEOM_SPHERE): [('sphere', {'radius': _text(size[0])}, place)],
            int(kinds.mjGEOM_CYLINDER): [
                ('cylinder', {'radius': _text(size[0]), 'length': _text(2.0 * size[1])}, place)
            ],
            int(kinds.mjGEOM_CAPSULE): [
                ('cylinder', {'radius': _text(size[0]), 'length': _text(2.0 * size[1])}, place),
                ('sphere', {'radius': _text(size[0])}, place + axis),
                ('sphere', {'radius': _text(size[0])}, place - axis),
            ],
        }
        kind = int(m.geom_type[geom])
        if kind not in shapes:
            raise BadInput(f"geom '{self._name('GEOM', geom)}': a URDF knows box, sphere, cylinder and capsule only")
        for shape, measures, at in shapes[kind]:
            one = SubElement(link, use)
            _origin(one, at, turn)
            SubElement(SubElement(one, 'geometry'), shape, measures)
            if use == 'visual':
                material = SubElement(one, 'material', name=self._name('GEOM', geom))
                SubElement(material, 'color', rgba=_text(m.geom_rgba[geom]))

    def _joint(self, body: int) -> None:
        m = self.m
        parent, joint = int(m.body_parentid[body]), int(m.body_jntadr[body])
        if parent == 0:
            return
        name = self._name('JOINT', joint) if joint >= 0 else self._name('BODY', body) + '_mount'
        element = SubElement(self.root, 'joint', name=name, type='revolute' if joint >= 0 else 'fixed')
        SubElement(element, 'parent', link=self._name('BODY', parent))
        SubElement(element, 'child', link=self._name('BODY', body))
        _origin(element, m.body_pos[body], m.body_quat[body])
        if joint >= 0:
            low, high = (_text(value) for value in m.jnt_range[joint])
            SubElement(element, 'axis', xyz=_text(m.jnt_axis[joint]))
            SubElement(element, 'limit', lower=low, upper=high, effort=_text(_EFFORT), velocity=_text(_SPEED))
            SubElement(element, 'dynamics', damping=_text(m.dof_damping[m.jnt_dofadr[joint]]))
            self.turning.append(name)

    def _frame(self, name: str, body: int, place: NDArray[np.float64], quaternion: NDArray[np.float64]) -> None:
        """A link without mass, fixed to a body; what is fixed to the world stands fixed to the robot's root."""
        m, mj = self.m, self.mj
        if body == 0:
            body = root(m)
            back, turned = np.zeros(4), np.zeros(4)
            mj.mju_negQuat(back, m.body_quat[body])
            mj.mju_mulQuat(turned, back, quaternion)
            moved = np.zeros(3)
            mj.mju_rotVecQuat(moved, place - m.body_pos[body], back)
            place, quaternion = moved, turned
        SubElement(self.root, 'link', name=name)
        joint = SubElement(self.root, 'joint', name=f'{name}_mount', type='fixed')
        SubElement(joint, 'parent', link=self._name('BODY', body))
        SubElement(joint, 'child', link=name)
        _origin(joint, place, quaternion)

    def _ends(self, free: set[int]) -> None:
        """Where the tendon of each muscle ends: the frame of what the muscle publishes."""
        m = self.m
        for actuator in np.flatnonzero(m.actuator_trntype == self.mj.mjtTrn.mjTRN_TENDON):
            tendon = int(m.actuator_trnid[actuator, 0])
            last = int(m.tendon_adr[tendon] + m.tendon_num[tendon] - 1)
            site = int(m.wrap_objid[last])
            if m.wrap_type[last] == self.mj.mjtWrap.mjWRAP_SITE and int(m.site_bodyid[site]) not in free:
                name = f'{self._name("TENDON", tendon)}_moving_end'
                self._frame(name, int(m.site_bodyid[site]), m.site_pos[site], m.site_quat[site])

    def _camera(self) -> None:
        """The camera of the pictures, with the frame that they are in."""
        number = self.mj.mj_name2id(self.m, self.mj.mjtObj.mjOBJ_CAMERA, VIEW)
        if number < 0:
            return
        ahead, turned = np.zeros(4), np.zeros(4)
        self.mj.mju_mat2Quat(ahead, _LOOKING.ravel())
        self.mj.mju_mulQuat(turned, self.m.cam_quat[number], ahead)
        self._frame('camera', int(self.m.cam_bodyid[number]), self.m.cam_pos[number], turned)
        SubElement(self.root, 'link', name=OPTICAL)
        joint = SubElement(self.root, 'joint', name=f'{OPTICAL}_mount', type='fixed')
        SubElement(joint, 'parent', link='camera')
        SubElement(joint, 'child', link=OPTICAL)
        SubElement(joint, 'origin', xyz='0 0 0', rpy=_SIDEWAYS)

    def _control(self) -> None:
        """What ros2_control needs to drive it through topics, as in tcp_muscle_macros.xacro.

        In the robot's own namespace, never the root: joint_state_broadcaster says its own joint_states there.
        """
        robot = self.root.get('name')
        control = SubElement(self.root, 'ros2_control', name=f'{robot}_system', type='system')
        hardware = SubElement(control, 'hardware')
        SubElement(hardware, 'plugin').text = 'joint_state_topic_hardware_interface/JointStateTopicSystem'
        for name, value in (
            ('joint_commands_topic', f'/{robot}/joint_commands'),
            ('joint_states_topic', f'/{robot}/joint_states'),
            ('trigger_joint_command_threshold', '-1'),
        ):
            SubElement(hardware, 'param', name=name).text = value
        for name in self.turning:
            joint = SubElement(control, 'joint', name=name)
            SubElement(joint, 'command_interface', name='position')
            for state in ('position', 'velocity', 'effort'):
                SubElement(joint, 'state_interface', name=state)


def urdf(robot: str) -> str:
    """The URDF of a robot that comes along, as text.

    Raises:
        BadInput: as ``models.load``.
    """
    return _Writer(robot).write()

"""A MuJoCo model in which muscles pull at the tendons."""

from collections.abc import Mapping, Sequence
from copy import copy
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle import Muscle
from tcp_muscle_ros.muscle import quantities as at
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.robots.coupling import Book, Tendons
from tcp_muscle_ros.robots.models import load, mujoco

_RUNAWAY = ('BADQPOS', 'BADQVEL', 'BADQACC', 'BADCTRL')  # MuJoCo's warnings of a motion without bounds


def _places(numbers: list[int]) -> Any:
    """Numbers as a slice where they follow one another: a view of an array costs a tenth of a copy."""
    follow = numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    return slice(numbers[0], numbers[0] + len(numbers)) if follow else np.array(numbers)


class Robot:
    """Bodies of MuJoCo, and muscles on its tendons.

    Each muscle has a tendon and, acting on it, a ``general`` actuator of its own name (gain -1, affine bias 0 0 0; no
    gear and no range, which would make another force of the tension). Of a tendon's length the muscle is a part; the
    rest is a cable that does not stretch. The model's integrator is ``implicitfast`` or ``implicit``.

    Args:
        model: a name of ``models.ROBOTS``, an MJCF file, or MuJoCo's compiled model, which is then this robot's own.
        muscles: by the names of their tendons, ``blocked`` with the tension with which they were mounted: at rest at
            T0, in the pose in which the model is written. Each is stepped by one robot alone: for a second robot,
            make others.

    Raises:
        BadInput: MuJoCo is missing, or the model and the muscles do not fit together.
    """

    def __init__(self, model: Any, muscles: Mapping[str, Muscle]) -> None:
        self._mj = mujoco()
        self.model = load(model) if isinstance(model, str | Path) else model
        self.data = self._mj.MjData(self.model)
        self.names = tuple(muscles)
        if not self.names:
            raise BadInput('a robot without muscles; expected at least one, by the name of its tendon')
        kinds = self._mj.mjtObj
        tendons = [self._number(kinds.mjOBJ_TENDON, name, 'tendon') for name in self.names]
        actuators = [self._number(kinds.mjOBJ_ACTUATOR, name, 'actuator') for name in self.names]
        self._check(tendons, actuators)
        self._tendon, self._actuator = _places(tendons), _places(actuators)
        self.tendons = self._mounted(list(muscles.values()), [True] * len(self.names))
        self._step = float(self.model.opt.timestep)
        self._connected = np.ones(len(self.names))
        self._mj.mj_forward(self.model, self.data)
        self._cable = self.data.ten_length[self._tendon] - self.tendons.rest_lengths
        self.tendons.begin(self.lengths())

    def _number(self, kind: Any, name: str, what: str) -> int:
        number = int(self._mj.mj_name2id(self.model, kind, name))
        if number < 0:
            count = {'tendon': self.model.ntendon, 'actuator': self.model.nu, 'joint': self.model.njnt}[what]
            known = [self._mj.mj_id2name(self.model, kind, k) or '' for k in range(count)]
            raise BadInput(f"the robot has no {what} '{name}'{nearest(name, known)}")
        return number

    def _check(self, tendons: Sequence[int], actuators: Sequence[int]) -> None:
        integrators = self._mj.mjtIntegrator
        if self.model.opt.integrator not in (integrators.mjINT_IMPLICITFAST, integrators.mjINT_IMPLICIT):
            raise BadInput("the robot's integrator is explicit in velocities; expected integrator='implicitfast'")
        for name, tendon, k in zip(self.names, tendons, actuators, strict=True):
            found = self._unlike(tendon, k)
            if found:
                raise BadInput(
                    f"actuator '{name}' {found}, which is no muscle's; expected <general name='{name}' "
                    f"tendon='{name}' biastype='affine' gainprm='-1' biasprm='0 0 0'/>"
                )

    def _mounted(self, muscles: list[Muscle], held: Sequence[bool]) -> Tendons:
        """Muscles on the tendons. ``held``: whose cable is whole, so that the robot holds its end."""
        if len(muscles) != len(self.names):
            raise BadInput(
                f'{len(muscles)} muscles for {len(self.names)}; expected one each for {", ".join(self.names)}'
            )
        for k, (name, muscle) in enumerate(zip(self.names, muscles, strict=True)):
            first = next(j for j, other in enumerate(muscles) if other is muscle)
            if first < k:
                raise BadInput(f"'{name}' and '{self.names[first]}' are one and the same muscle; expected one for each")
            if held[k] and not muscle.blocked:
                raise BadInput(f"'{name}': a robot holds the ends of its muscles; expected Muscle(..., end='blocked')")
        return Tendons(muscles)

    def _unlike(self, tendon: int, k: int) -> str:
        """What makes an actuator pull with another force than it is told, or elsewhere; '' where nothing does.

        The third number of its bias is this robot's own: there the slope of each step is written.
        """
        mj, model = self._mj, self.model
        gear, gain, bias = model.actuator_gear[k, 0], model.actuator_gainprm[k, 0], model.actuator_biasprm[k, :2]
        elsewhere = model.actuator_trntype[k] != mj.mjtTrn.mjTRN_TENDON or model.actuator_trnid[k, 0] != tendon
        unlike = {
            'does not act on the tendon of its name': elsewhere,
            f'has gear {gear:g}': gear != 1.0,
            f'has gainprm {gain:g}': gain != -1.0,
            'has a gain that is not fixed': model.actuator_gaintype[k] != mj.mjtGain.mjGAIN_FIXED,
            'has a bias that is not affine': model.actuator_biastype[k] != mj.mjtBias.mjBIAS_AFFINE,
            f'has biasprm {bias[0]:g} {bias[1]:g}': bias.any(),
            'has a dyntype': model.actuator_dyntype[k] != mj.mjtDyn.mjDYN_NONE,
            'has a ctrlrange': model.actuator_ctrllimited[k],
            'has a forcerange': model.actuator_forcelimited[k],
        }
        return next((said for said, so in unlike.items() if so), '')

    # State

    @property
    def time(self) -> float:
        """s since the start."""
        return float(self.data.time)

    def reset(self, pose: Mapping[str, float] | None = None) -> None:
        """At rest in a pose (rad or m, by joint; default: the model's own), muscles whole and at the ambient."""
        self._mj.mj_resetData(self.model, self.data)
        for name, value in (pose or {}).items():
            self.data.qpos[self.place(name)] = value
        self._mj.mj_forward(self.model, self.data)
        lengths = self.lengths()
        for muscle, length in zip(self.tendons.muscles, lengths, strict=True):  # what creeps rests at its length there
            muscle.imposed[at.IN_HELD], muscle.imposed[at.IN_WALL] = 1.0, length
            muscle.reset()
        self.tendons.begin(lengths)
        self._connected[:] = 1.0

    def take(self, muscles: Sequence[Muscle]) -> None:
        """The same muscles with other properties, on their cables as they are; the book is opened anew.

        Raises:
            BadInput: they are not as many as before, one is given twice, or one's end is not ``blocked``.
        """
        self.tendons = self._mounted(list(muscles), [before.blocked for before in self.tendons.muscles])
        self.tendons.begin(self.lengths())

    def still(self) -> 'Robot':
        """What it looks like now, for a picture that is made while time goes on."""
        seen = copy(self)
        seen.data, seen.tendons = copy(self.data), copy(self.tendons)
        seen.tendons.shown = self.tendons.shown.copy()
        return seen

    def place(self, joint: str) -> int:
        """Where a joint's position stands in ``data.qpos``."""
        return int(self.model.jnt_qposadr[self._number(self._mj.mjtObj.mjOBJ_JOINT, joint, 'joint')])

    def speed_place(self, joint: str) -> int:
        """Where a joint's velocity stands in ``data.qvel``."""
        return int(self.model.jnt_dofadr[self._number(self._mj.mjtObj.mjOBJ_JOINT, joint, 'joint')])

    def lengths(self) -> Array:
        """Of the muscles, m; shorter than nothing where a tendon has gone slack by more than the muscle's length."""
        found: Array = self.data.ten_length[self._tendon] - self._cable
        return found

    def moment_arm(self, muscle: str, joint: str) -> float:
        """m, in the present pose: by how much a muscle is shorter for each rad that a joint turns further."""
        place, index, before = self.place(joint), self._index(muscle), self.data.qpos.copy()
        found = []
        for angle in (before[place] - 1e-4, before[place] + 1e-4):
            self.data.qpos[place] = angle
            self._mj.mj_kinematics(self.model, self.data)
            self._mj.mj_tendon(self.model, self.data)
            found.append(self.lengths()[index])
        self.data.qpos[:] = before
        self._mj.mj_forward(self.model, self.data)
        return float(found[0] - found[1]) / 2e-4

    def cables(self) -> list[Array]:
        """The way of each tendon over its pulleys, shape (points, 3), m."""
        data, ways = self.data, []
        for tendon in np.arange(self.model.ntendon)[self._tendon]:
            first = int(data.ten_wrapadr[tendon])
            points = data.wrap_xpos.reshape(-1, 3)[first : first + int(data.ten_wrapnum[tendon])]
            ways.append(points.copy())
        return ways

    def coils(self) -> list[tuple[Array, Array]]:
        """Where each muscle's coil lies: from the anchor of its tendon as far as it is long, m."""
        found = []
        for way, length in zip(self.cables(), self.lengths(), strict=True):
            towards = way[1] - way[0]
            whole = float(np.linalg.norm(towards))
            found.append((way[0], way[0] + towards * min(max(length, 0.0), whole) / whole))
        return found

    def pressure(self, geom: int) -> float:
        """N: what presses on a geom (by its number), all contacts together."""
        force, pressed = np.zeros(6), 0.0
        for k in range(self.data.ncon):
            contact = self.data.contact[k]
            if geom in (contact.geom1, contact.geom2):
                self._mj.mj_contactForce(self.model, self.data, k, force)
                pressed += float(force[0])
        return pressed

    @property
    def temperatures(self) -> Array:
        """Of the fibres, K."""
        now: Array = self.tendons.shown[:, at.Y_FIBRE_TEMPERATURE].copy()
        return now

    @property
    def tensions(self) -> Array:
        """N."""
        now: Array = self.tendons.shown[:, at.Y_FORCE].copy()
        return now

    def book(self) -> Book:
        """Where the muscles' energy went since the last ``reset``."""
        return self.tendons.book()

    # What may break

    def cut_wire(self, muscle: str) -> None:
        """From now on no current reaches the muscle."""
        self._connected[self._index(muscle)] = 0.0

    def cut_cable(self, muscle: str) -> None:
        """From now on nothing holds the muscle's end."""
        self.tendons.muscles[self._index(muscle)].imposed[at.IN_HELD] = 0.0
        self.tendons.muscles[self._index(muscle)].impose(load=0.0)

    def _index(self, muscle: str) -> int:
        if muscle not in self.names:
            raise BadInput(f"the robot has no muscle '{muscle}'{nearest(muscle, self.names)}")
        return self.names.index(muscle)

    # Time

    def step(self, currents: ArrayLike, steps: int = 1) -> None:
        """Hold the currents (A, one a muscle) for so many steps of the simulator.

        Raises:
            BadInput: the motion has lost all bounds; the state is then MuJoCo's of a reset.
        """
        mj, model, data, tendons = self._mj, self.model, self.data, self.tendons
        flowing = np.asarray(currents, dtype=np.float64) * self._connected
        bias, ctrl = model.actuator_biasprm[:, 2], data.ctrl
        length, speed = data.ten_length, data.ten_velocity
        for _ in range(steps):
            mj.mj_step1(model, data)
            tension, slope = tendons.step(length[self._tendon] - self._cable, speed[self._tendon], flowing, self._step)
            ctrl[self._actuator] = tension
            bias[self._actuator] = -slope
            mj.mj_step2(model, data)
        for name in _RUNAWAY:
            if data.warning[getattr(mj.mjtWarning, f'mjWARN_{name}')].number:
                raise BadInput(
                    f'the motion diverges at {data.time:.3f} s ({name}): the timestep of {self._step:g} s is too long'
                )

    def advance(self, dt: float, currents: ArrayLike) -> None:
        """Hold the currents (A) for ``dt`` (s), a whole number of the simulator's steps.

        Raises:
            BadInput: as ``step``, or the steps do not fill ``dt``.
        """
        steps = round(dt / self._step)
        if abs(steps * self._step - dt) > 1e-9 * dt or steps < 1:
            raise BadInput(f"{dt:g} s is no whole number of the simulator's steps of {self._step:g} s")
        self.step(currents, steps)

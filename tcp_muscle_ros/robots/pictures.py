"""Pictures of a robot without a screen: by EGL or OSMesa where they are, else drawn from the poses."""

from collections.abc import Sequence
from importlib import import_module
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle import ZERO_CELSIUS
from tcp_muscle_ros.robots.drawing import Drawing
from tcp_muscle_ros.robots.models import VIEW, mujoco
from tcp_muscle_ros.robots.robot import Robot

Image = NDArray[np.uint8]
Arrow = tuple[Sequence[float], Sequence[float]]  # from and to, m
BACKENDS = ('egl', 'osmesa', 'drawn')
_COLD, _HOT = 23.0 + ZERO_CELSIUS, 90.0 + ZERO_CELSIUS  # K: the ends of the scale of colours
_COIL = 0.0022  # m: radius with which a coil is shown, three times its own, to be seen


class Camera(Protocol):
    """What makes pictures of one robot."""

    backend: str

    def picture(self, robot: Robot, arrows: Sequence[Arrow] = ()) -> Image:
        """What it sees now, shape (height, width, 3)."""

    def close(self) -> None:
        """Give back what the graphics hold."""


def colour(temperature: float) -> tuple[float, float, float, float]:
    """Red, green, blue and opacity of a coil: from silver at 23 degC to red at 90 degC."""
    share = float(np.clip((temperature - _COLD) / (_HOT - _COLD), 0.0, 1.0))
    return 0.72 + 0.23 * share, 0.74 - 0.62 * share, 0.78 - 0.70 * share, 1.0


def camera(robot: Robot, width: int = 640, height: int = 400, backend: str = '', view: str = VIEW) -> Camera:
    """A camera that looks at this robot.

    Args:
        robot: the robot.
        width: pixels.
        height: pixels.
        backend: one of BACKENDS; default the first that works here.
        view: the camera of the model.

    Raises:
        BadInput: an unknown backend, or one that does not work here.
    """
    if backend and backend not in BACKENDS:
        raise BadInput(f"unknown backend '{backend}'{nearest(backend, BACKENDS)}")
    for name in (backend,) if backend else BACKENDS:
        if name == 'drawn':
            break
        try:
            return _Rendered(robot, width, height, name, view)
        except Exception as problem:  # whatever a machine's graphics raise: the next way is tried
            if backend:
                raise BadInput(f'no pictures can be drawn with {name} here: {type(problem).__name__}') from None
    return Drawing(width, height, colour)


class _Rendered:
    def __init__(self, robot: Robot, width: int, height: int, backend: str, view: str) -> None:
        self.backend = backend
        self._mj = mj = mujoco()
        self._context = import_module(f'mujoco.{backend}').GLContext(width, height)
        self._context.make_current()
        model = robot.model
        model.vis.global_.offwidth = max(model.vis.global_.offwidth, width)
        model.vis.global_.offheight = max(model.vis.global_.offheight, height)
        model.vis.quality.shadowsize = 1024
        self._scene = mj.MjvScene(model, maxgeom=500)
        self._scene.flags[mj.mjtRndFlag.mjRND_REFLECTION] = 0
        self._renderer = mj.MjrContext(model, mj.mjtFontScale.mjFONTSCALE_100)
        mj.mjr_setBuffer(mj.mjtFramebuffer.mjFB_OFFSCREEN, self._renderer)
        self._option, self._eye = mj.MjvOption(), mj.MjvCamera()
        self._eye.type = mj.mjtCamera.mjCAMERA_FIXED
        self._eye.fixedcamid = model.camera(view).id
        self._area = mj.MjrRect(0, 0, width, height)
        self._pixels = np.zeros((height, width, 3), dtype=np.uint8)

    def picture(self, robot: Robot, arrows: Sequence[Arrow] = ()) -> Image:
        mj = self._mj
        self._context.make_current()
        mj.mjv_updateScene(robot.model, robot.data, self._option, None, self._eye, mj.mjtCatBit.mjCAT_ALL, self._scene)
        for (start, end), temperature in zip(robot.coils(), robot.temperatures, strict=True):
            self._add(mj.mjtGeom.mjGEOM_CAPSULE, _COIL, start, end, colour(temperature))
        for tail, tip in arrows:
            self._add(mj.mjtGeom.mjGEOM_ARROW, 0.002, tail, tip, (0.1, 0.5, 0.2, 1.0))
        mj.mjr_render(self._area, self._scene, self._renderer)
        mj.mjr_readPixels(self._pixels, None, self._area, self._renderer)
        seen: Image = self._pixels[::-1].copy()
        return seen

    def _add(self, kind: Any, width: float, start: Any, end: Any, rgba: Sequence[float]) -> None:
        mj, scene = self._mj, self._scene
        if scene.ngeom >= scene.maxgeom:
            return
        geom = scene.geoms[scene.ngeom]
        mj.mjv_initGeom(geom, kind, np.zeros(3), np.zeros(3), np.zeros(9), np.array(rgba, dtype=np.float32))
        mj.mjv_connector(geom, kind, width, np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64))
        scene.ngeom += 1

    def close(self) -> None:
        self._context.make_current()
        self._renderer.free()
        self._context.free()

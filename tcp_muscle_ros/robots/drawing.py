"""A robot drawn from its poses with matplotlib, from the side (along y), where no renderer is to be had."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.robots.models import mujoco
from tcp_muscle_ros.robots.robot import Robot

_DPI = 100


class Drawing:
    """Links, pulleys, cables and coils as outlines; see ``pictures.Camera``."""

    backend = 'drawn'

    def __init__(self, width: int, height: int, colour: Callable[[float], tuple[float, float, float, float]]) -> None:
        self._size = width / _DPI, height / _DPI
        self._colour = colour

    def picture(self, robot: Robot, arrows: Sequence[Any] = ()) -> NDArray[np.uint8]:
        """What is seen from the side now, shape (height, width, 3)."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=self._size, dpi=_DPI)
        canvas: Any = FigureCanvasAgg(figure)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        # From the side that is farthest in y: what is nearer to the camera is drawn over it.
        for geom in np.argsort(-robot.data.geom_xpos[:, 1], kind='stable'):
            self._geom(axes, robot, int(geom))
        for path in robot.cables():
            axes.plot(path[:, 0], path[:, 2], color='0.3', lw=0.8)
        for (start, end), temperature in zip(robot.coils(), robot.temperatures, strict=True):
            axes.plot([start[0], end[0]], [start[2], end[2]], color=self._colour(temperature), lw=4.0)
        for start, end in arrows:
            axes.annotate('', (end[0], end[2]), (start[0], start[2]), arrowprops={'color': 'tab:green', 'width': 2.0})
        axes.set_aspect('equal', adjustable='datalim')
        axes.margins(0.05)
        canvas.draw()
        seen: NDArray[np.uint8] = np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
        return seen

    @staticmethod
    def _geom(axes: Any, robot: Robot, geom: int) -> None:
        from matplotlib.patches import Circle, Polygon

        kinds = mujoco().mjtGeom
        model, data = robot.model, robot.data
        kind, size, colour = model.geom_type[geom], model.geom_size[geom], model.geom_rgba[geom]
        x, z = data.geom_xpos[geom][[0, 2]]
        turn = data.geom_xmat[geom].reshape(3, 3)[[0, 2]]
        if kind == kinds.mjGEOM_BOX:
            corners = [turn @ (size * np.array(sign)) for sign in ((1, 1, 1), (1, 1, -1), (-1, 1, -1), (-1, 1, 1))]
            axes.add_patch(Polygon(np.array(corners) + np.array((x, z)), color=colour))
        elif kind == kinds.mjGEOM_CAPSULE:
            along = turn @ (0.0, 0.0, size[1])
            across = size[0] * np.array([-along[1], along[0]]) / max(np.hypot(*along), 1e-9)
            ends = np.array([along + across, along - across, -along - across, -along + across])
            axes.add_patch(Polygon(ends + np.array((x, z)), color=colour))
            for end in (along, -along):
                axes.add_patch(Circle((x + end[0], z + end[1]), size[0], color=colour))
        else:
            axes.add_patch(Circle((x, z), size[0], color=colour))

    def close(self) -> None:
        """Nothing is held."""

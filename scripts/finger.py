"""A finger grasps a ball: the figure and the video of docs/robots.md, and what the grasp measured.

    python scripts/finger.py [--folder docs/images] [--backend egl|osmesa|drawn]

Needs MuJoCo (extra ``mujoco``). About a minute, most of it for the pictures.
"""

import argparse
import sys
from itertools import pairwise
from pathlib import Path

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import ZERO_CELSIUS
from tcp_muscle_ros.robots import grasp as the_grasp
from tcp_muscle_ros.robots.controlled import ControlledRobot
from tcp_muscle_ros.robots.grasp import CLOSED, END, HELD, LIFTED, Grasp, grasp
from tcp_muscle_ros.robots.pictures import BACKENDS, Camera, camera

ROOT = Path(__file__).resolve().parent.parent
WIDTH, HEIGHT = 640, 280
EVERY = 0.25  # s between two pictures
SPEED = 2.5  # times as fast as it was
SHOWN = (LIFTED, CLOSED, END)  # s: the pictures of the figure
ARROW = np.array([0.085, 0.0, 0.030]), 0.030  # m: the middle of the arrow of gravity, and its length
COLOURS = ('tab:red', 'tab:orange', 'tab:blue', 'tab:cyan')


class Film:
    """Pictures at even times while the grasp goes on."""

    def __init__(self, backend: str) -> None:
        self._backend, self._camera = backend, None
        self.frames: list[NDArray[np.uint8]] = []
        self.times: list[float] = []

    def watch(self, finger: ControlledRobot, turned: float) -> None:
        """Take a picture if it is time for one."""
        seeing: Camera = self._camera or camera(finger.robot, WIDTH, HEIGHT, self._backend)
        self._camera = seeing
        if finger.robot.time + 1e-9 < len(self.frames) * EVERY:
            return
        middle, length = ARROW
        along = 0.5 * length * np.array([np.sin(turned), 0.0, -np.cos(turned)])
        self.frames.append(seeing.picture(finger.robot, [(middle - along, middle + along)]))
        self.times.append(finger.robot.time)

    def save(self, path: Path) -> None:
        """As a GIF that repeats."""
        images = []
        few = np.concatenate(self.frames[:: len(self.frames) // 4])
        palette = Image.fromarray(few).quantize(160)  # one for all pictures: colours do not flicker
        for frame, time in zip(self.frames, self.times, strict=True):
            image = Image.fromarray(frame)
            pen = ImageDraw.Draw(image)
            pen.text((10, HEIGHT - 18), f'{time:4.1f} s   {part(time)}', fill=(60, 60, 70), font_size=13)
            images.append(image.quantize(palette=palette, dither=Image.Dither.NONE))
        images[0].save(
            path, save_all=True, append_images=images[1:], duration=round(1000 * EVERY / SPEED), loop=0, optimize=True
        )


def part(time: float) -> str:
    """What goes on at a time (s)."""
    names = (('lifts', LIFTED), ('closes and presses', CLOSED), ('gravity turns', HELD), ('holds', END + 1.0))
    return next(name for name, until in names if time <= until + 1e-6)


def draw(it: Grasp, film: Film, path: Path) -> None:
    """Three pictures, and below them angles, temperatures and what the ball felt, over time."""
    mpl.use('Agg')
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=(9.6, 8.0), layout='constrained')
    grid = figure.add_gridspec(4, 3, height_ratios=(1.0, 1.0, 1.0, 1.0))
    for k, time in enumerate(SHOWN):
        axes = figure.add_subplot(grid[0, k])
        axes.imshow(film.frames[int(np.argmin(np.abs(np.array(film.times) - time)))])
        axes.set_axis_off()
        axes.set_title(f'{time:g} s', fontsize=9)
    angle, warm, ball = (figure.add_subplot(grid[row, :]) for row in (1, 2, 3))
    for k, joint in enumerate(it.joints):
        angle.plot(it.time, it.setpoints[:, k], color=COLOURS[2 * k], ls=':', lw=1.2)
        angle.plot(it.time, it.angles[:, k], color=COLOURS[2 * k], label=f'{joint} (dotted: asked for)')
    for k, muscle in enumerate(it.muscles):
        warm.plot(it.time, it.temperatures[:, k] - ZERO_CELSIUS, color=COLOURS[k], label=muscle.replace('_', ' '))
    ball.plot(it.time, it.pressed, color='tab:green', label='pressed on the palm, N')
    moved = np.linalg.norm(it.ball - it.ball[np.searchsorted(it.time, CLOSED)], axis=1)
    ball.plot(it.time, 1e3 * moved, color='k', label='ball, from where it was at 13 s, mm')
    ball.set_ylim(0.0, 2.0)
    for axes, label in ((angle, 'angle, rad'), (warm, 'fibre, °C'), (ball, 'N, mm')):
        for begin, end in pairwise((0.0, LIFTED, CLOSED, HELD, END)):
            axes.axvspan(begin, end, color='0.94' if begin == CLOSED else 'w', zorder=-1)
        axes.set_ylabel(label)
        axes.legend(fontsize=8, ncols=4, loc='upper left')
        axes.grid(alpha=0.3)
        axes.margins(x=0.0)
    angle.set_ylim(-0.3, 0.85)
    warm.set_ylim(20.0, 95.0)
    ball.set_xlabel('time, s (grey: gravity turns by a right angle)')
    figure.savefig(path, dpi=100)


def main() -> int:
    """Let it happen, print, draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--folder', type=Path, default=ROOT / 'docs' / 'images')
    parser.add_argument('--backend', choices=BACKENDS, default='', help='default: the first that works here')
    given = parser.parse_args()
    try:
        film = Film(given.backend)
        it = grasp(film.watch)
    except BadInput as problem:
        print(f'finger: {problem}', file=sys.stderr)
        return 2
    for name, save in (('finger.gif', film.save), ('finger.png', lambda path: draw(it, film, path))):
        save(given.folder / name)
        print(f'{given.folder / name}: {(given.folder / name).stat().st_size / 1e6:.2f} MB')
    since = it.time >= CLOSED
    print(f'slip while gravity turns and after: {1e3 * it.slip:.2f} mm (asked for: below 2)')
    print(f'pressed with {it.pressed[since].min():.3f} to {it.pressed[since].max():.3f} N, ball of 0.039 N')
    print(
        f'warmest muscle {it.temperatures.max() - ZERO_CELSIUS:.1f} degC (limit {the_grasp.WARMEST - ZERO_CELSIUS:.0f})'
    )
    print(
        f'energy: {it.book.heated:.1f} J in, {it.book.by_heat * 1e3:.1f} mJ to work, error {100 * it.book.error:.6f} %'
    )
    return 0


if __name__ == '__main__':
    sys.exit(main())

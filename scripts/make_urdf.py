"""Make the URDF of every robot from its MJCF: python scripts/make_urdf.py"""

from pathlib import Path

from tcp_muscle_ros.robots.models import ROBOTS
from tcp_muscle_ros.robots.urdf import urdf

FOLDER = Path(__file__).resolve().parent.parent / 'urdf'

if __name__ == '__main__':
    for robot in ROBOTS:
        (FOLDER / f'{robot}.urdf').write_text(urdf(robot), encoding='utf-8')
        print(f'urdf/{robot}.urdf')

"""The robots that come along, and MuJoCo itself, which is optional."""

from importlib import resources
from pathlib import Path
from typing import Any

from tcp_muscle_ros.errors import BadInput, install, nearest

DATA = Path(str(resources.files('tcp_muscle_ros.robots') / 'data'))
ROBOTS = tuple(sorted(path.stem for path in DATA.glob('*.xml')))
VIEW = 'side'  # the camera of a model that takes the pictures
OPTICAL = 'camera_optical_frame'  # the link of the URDF that they are in


def mujoco() -> Any:
    """The module of MuJoCo.

    Raises:
        BadInput: it is not installed.
    """
    try:
        import mujoco as module
    except ImportError:
        raise BadInput(
            f'a simulated robot needs MuJoCo, which is not installed: {install("mujoco")} (Python 3.11 and later)'
        ) from None
    return module


def path_of(robot: str | Path) -> Path:
    """The MJCF of a robot that comes along (``arm``, ``finger``), or the file itself.

    Raises:
        BadInput: no such robot and no such file.
    """
    if robot in ROBOTS:
        return DATA / f'{robot}.xml'
    path = Path(robot)
    if path.suffix != '.xml':
        raise BadInput(f"unknown robot '{robot}'{nearest(str(robot), ROBOTS)}; or give an MJCF file, name.xml")
    if not path.is_file():
        raise BadInput(f"there is no MJCF file '{robot}'")
    return path


def load(robot: str | Path) -> Any:
    """A robot's compiled MuJoCo model.

    Raises:
        BadInput: as ``path_of``, or MuJoCo cannot read the file.
    """
    path = path_of(robot)
    try:
        return mujoco().MjModel.from_xml_path(str(path))
    except ValueError as problem:
        raise BadInput(f'{path}: MuJoCo cannot read it: {" ".join(str(problem).split())}') from None


def root(model: Any) -> int:
    """The number of the body that the others hang on: the first that does not float freely."""
    free = {int(model.jnt_bodyid[j]) for j in range(model.njnt) if model.jnt_type[j] == mujoco().mjtJoint.mjJNT_FREE}
    return next(body for body in range(1, model.nbody) if body not in free)

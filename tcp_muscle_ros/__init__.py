"""TCP artificial muscles in ROS 2: simulation, control, recording and diagnosis.

``load``, ``simulate``, ``calibrate``, ``diagnose`` and ``plot`` are for scripts and notebooks (``interface``). They and
what they need are loaded when one of them is first used.
"""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tcp_muscle_ros.interface import calibrate, diagnose, load, plot, simulate

__version__ = '0.1.0'
__all__ = ['__version__', 'calibrate', 'diagnose', 'load', 'plot', 'simulate']


def __getattr__(name: str) -> object:
    if name in __all__:
        return getattr(importlib.import_module('tcp_muscle_ros.interface'), name)
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}')


def __dir__() -> list[str]:
    return __all__

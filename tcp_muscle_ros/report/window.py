"""A window for a figure, where there is a display."""

import os

from matplotlib.figure import Figure

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import OUTPUT

_TOOLKITS = ('QtAgg', 'TkAgg', 'GTK4Agg', 'GTK3Agg', 'WXAgg')


def window() -> Figure:
    """An empty figure with a window. BadInput where there is no display, or nothing that opens windows."""
    import matplotlib.pyplot as plt

    if not (os.environ.get('DISPLAY') or os.environ.get('WAYLAND_DISPLAY')):
        raise BadInput('there is no display for a window; draw to a file with ', OUTPUT, ' PICTURE.png')
    if any(map(_works, _TOOLKITS)):
        return plt.figure(layout='constrained')
    raise BadInput(
        'no toolkit for windows is installed (python3-tk, or PyQt); draw to a file with ', OUTPUT, ' PICTURE.png'
    )


def _works(toolkit: str) -> bool:
    """Can this toolkit open windows here? Each fails in its own way where it cannot."""
    import matplotlib.pyplot as plt

    try:
        plt.switch_backend(toolkit)
    except Exception:
        return False
    return True


def show(figure: Figure) -> None:
    """Wait until the window of the figure is closed."""
    import matplotlib.pyplot as plt

    figure.set_size_inches(9.0, min(2.2 * len(figure.axes), 10.0))
    plt.show()

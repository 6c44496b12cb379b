"""A muscle in a script or a notebook, with pandas DataFrames in and out (extra ``labs``).

>>> import tcp_muscle_ros as tcp
>>> steps = [{'duration_s': 5, 'value': 0}, {'duration_s': 20, 'value': 0.27}]
>>> frame = tcp.simulate({'rate_hz': 5, 'input': 'current', 'segments': steps})
>>> frame[['current_A', 'temperature_degC', 'displacement_m']].iloc[[0, -1]].round(3)
        current_A  temperature_degC  displacement_m
time_s
0.0          0.00            23.000           0.000
25.0         0.27            76.482           0.061
>>> tcp.calibrate(frame).value('hA')
0.019

A frame's index is the time in s, each column a channel with its unit: ``temperature_degC``, ``current_A``. Frames of a
lab may have headings of their own: ``I (mA)``, ``Weg [mm]``. Whatever is wrong is a ``BadInput``, one line that says
what.
"""

from tcp_muscle_ros.interface.running import calibrate, diagnose, plot, simulate
from tcp_muscle_ros.interface.sources import load

__all__ = ['calibrate', 'diagnose', 'load', 'plot', 'simulate']

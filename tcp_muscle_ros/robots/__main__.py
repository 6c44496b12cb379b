"""Compile the model, and how it acts on a robot, ahead: ``python -m tcp_muscle_ros.robots``.

As ``python -m tcp_muscle_ros.muscle``, which leaves the robots out. ``--ship`` as there.
"""

import runpy

from tcp_muscle_ros.muscle import Muscle, Parameters
from tcp_muscle_ros.robots.coupling import Tendons

if __name__ == '__main__':
    print('compiling the model, as tendons of a robot', flush=True)
    Tendons([Muscle(Parameters.named('karami_tadesse_2017'), end='blocked', load=0.5)])
    runpy.run_module('tcp_muscle_ros.muscle', run_name='__main__')  # last: it ships all that is compiled

"""Compile the model ahead of its first use: ``python -m tcp_muscle_ros.muscle``, once after an installation by pip.

Otherwise the first start of a node or of the tool does it, and takes as long. The machine code is kept in the user's
cache (see ``compiled.py``), for this version of the package on this machine. ``--ship`` puts it into the package's own
folder, as ``colcon build`` does: then nobody's first start compiles.
"""

import sys
import time

from tcp_muscle_ros.muscle.ahead import compile_ahead, ship
from tcp_muscle_ros.muscle.compiled import CACHE

if __name__ == '__main__':
    if CACHE is None:
        sys.exit('nowhere to keep compiled code: neither ~/.cache nor the temporary folder can be written')
    begin = time.monotonic()
    compile_ahead(lambda step: print(f'compiling the model, {step}', flush=True))
    print(f'compiled the model in {time.monotonic() - begin:.0f} s')
    if '--ship' in sys.argv[1:]:
        try:
            print(f'its machine code is in {ship()}')
        except OSError as problem:
            sys.exit(f'the machine code cannot be put into the package: {problem.strerror or problem}')

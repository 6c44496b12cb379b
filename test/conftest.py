"""What every test shares."""

import os

from tcp_muscle_ros.process.threads import one_of_linear_algebra

one_of_linear_algebra()  # before numpy comes
# Nodes that tests kill leave their shared memory behind: the middleware runs out of it, and messages do not arrive.
os.environ['FASTDDS_BUILTIN_TRANSPORTS'] = 'UDPv4'

from hypothesis import settings  # noqa: E402

# A property is about values; how long one takes depends on what numba still has to compile and on who else computes.
settings.register_profile('untimed', deadline=None)
settings.load_profile('untimed')


# What keeps to the clock: nothing that computes all the time may run beside it.
REAL_TIME = ('test/nodes/', 'test/commands/test_diagnose_closed_loop.py')
# The longest of these come first, so that no core waits for one of them at the end.
LONG = ('test/nodes/test_twin_adoption.py', 'test/nodes/test_runner.py', 'test/nodes/test_lockstep.py')


def pytest_collection_modifyitems(items):
    """What keeps to the clock comes last; ``./scripts/test`` hands the files out to the cores in this order."""
    items.sort(key=lambda item: (item.nodeid.startswith(REAL_TIME), not item.nodeid.startswith(LONG)))

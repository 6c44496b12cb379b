"""What every test shares."""

from tcp_muscle_ros.threads import one_of_linear_algebra

one_of_linear_algebra()  # before numpy comes

import pytest  # noqa: E402
from hypothesis import settings  # noqa: E402

# A property is about values; how long one takes depends on what numba still has to compile and on who else computes.
settings.register_profile('untimed', deadline=None)
settings.load_profile('untimed')


# What keeps to the clock: nothing may run beside it.
REAL_TIME = ('test/nodes/', 'test/commands/test_diagnose_closed_loop.py')


def pytest_collection_modifyitems(items):
    """What keeps to the clock comes last."""
    items.sort(key=lambda item: item.nodeid.startswith(REAL_TIME))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """``./scripts/test`` shares the files out to the cores, and after them all that keeps to the clock to one.

    By names and not by xdist's marks of groups, which pytest 9.2 no longer hands on.
    """
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            return 'real time' if nodeid.startswith(REAL_TIME) else nodeid.split('::')[0]

    return ByFile(config, log)

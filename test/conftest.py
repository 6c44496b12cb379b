"""What every test shares."""

from tcp_muscle_ros.threads import one_of_linear_algebra

one_of_linear_algebra()  # before numpy comes

import pytest  # noqa: E402
from hypothesis import settings  # noqa: E402

# A property is about values; how long one takes depends on what numba still has to compile and on who else computes.
settings.register_profile('untimed', deadline=None)
settings.load_profile('untimed')


def pytest_collection_modifyitems(config, items):
    """Files are shared out to the cores (``./scripts/test``); what keeps to the clock comes after them, one by one."""
    items.sort(key=keeps_time)
    if config.pluginmanager.hasplugin('xdist'):
        for item in items:
            item.add_marker(pytest.mark.xdist_group('real time' if keeps_time(item) else item.path.stem))


def keeps_time(item):
    return 'test/nodes/' in item.path.as_posix() or item.get_closest_marker('real_time') is not None

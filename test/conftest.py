"""What every test shares."""

import os
import signal

from tcp_muscle_ros.process.threads import one_of_linear_algebra

one_of_linear_algebra()  # before numpy comes

import domains  # noqa: E402
import pytest  # noqa: E402
from hypothesis import settings  # noqa: E402

# A shell without job control starts what runs behind it deaf to Ctrl-C, which the tests and their processes hear.
signal.signal(signal.SIGINT, signal.default_int_handler)
os.environ.update(domains.ALONE, ROS_DOMAIN_ID=str(domains.take()))

# A property is about values; how long one takes depends on what numba still has to compile and on who else computes.
settings.register_profile('untimed', deadline=None)
settings.load_profile('untimed')


# What keeps to the clock: what computes all the time goes behind it where both want a core.
REAL_TIME = ('test/nodes/', 'test/commands/test_diagnose_closed_loop.py')
BEHIND = 5  # of `nice`: a third of the share of what keeps to the clock
# The longest files, of what computes and of what keeps to the clock, from the longest on: so no core waits for one of
# them at the end.
LONG = (
    'diagnosis/test_on_truth', 'proof/test_truth', 'diagnosis/test_weathered', 'commands/test_campaign',
    'diagnosis/test_free_laws', 'proof/test_alternatives', 'diagnosis/test_in_words', 'commands/test_diagnose_faults',
    'diagnosis/test_selection', 'report/test_diagnosis_report', 'diagnosis/test_run_to_run', 'diagnosis/test_search',
    'nodes/test_runner', 'nodes/test_kills', 'nodes/test_sim_node', 'nodes/test_many_muscles',
    'nodes/test_controller_node', 'nodes/test_twin_adoption', 'nodes/test_faults', 'nodes/test_recorder',
    'nodes/test_twin_node', 'nodes/test_lockstep', 'commands/test_diagnose_closed_loop', 'nodes/test_tracking_nodes',
    'nodes/test_robot',
)  # fmt: skip


def by_length(item):
    return next((k for k, file in enumerate(LONG) if item.nodeid.startswith(f'test/{file}.py')), len(LONG))


def pytest_collection_modifyitems(items):
    """``./scripts/test`` hands the files out to the cores in this order, of each kind (``workers.py``)."""
    items.sort(key=lambda item: (item.nodeid.startswith(REAL_TIME), by_length(item)))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """With ``--dist=loadfile``; any other way to hand out stays as it is."""
    if config.getvalue('dist') != 'loadfile':
        return None
    from workers import Scheduling

    return Scheduling(config, log, REAL_TIME)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item):
    """A worker that has begun to compute goes on with it: without rights nobody is lifted in front again."""
    if 'PYTEST_XDIST_WORKER' in os.environ and not item.nodeid.startswith(REAL_TIME):
        os.setpriority(os.PRIO_PROCESS, 0, max(BEHIND, os.getpriority(os.PRIO_PROCESS, 0)))

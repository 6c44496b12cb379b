"""Threads of linear algebra where numpy was loaded first."""

import os
import subprocess
import sys

import pytest

from tcp_muscle_ros.process.threads import LINEAR_ALGEBRA

LOADED_FIRST = """
import numpy
from threadpoolctl import threadpool_info
from tcp_muscle_ros.process.threads import with_one_of_linear_algebra

def most():
    return max(pool['num_threads'] for pool in threadpool_info() if pool['user_api'] == 'blas')

before = most()
with with_one_of_linear_algebra():
    print(before, most(), end=' ')
print(most())
"""


def test_numpy_that_was_loaded_with_more_threads_keeps_to_one_for_the_time_of_the_work():
    pytest.importorskip('threadpoolctl', reason='comes with the extra labs')
    environment = {**os.environ, **dict.fromkeys(LINEAR_ALGEBRA, '2')}
    shown = subprocess.run(
        [sys.executable, '-c', LOADED_FIRST], env=environment, capture_output=True, text=True, check=True
    )
    assert shown.stdout.split() == ['2', '1', '2']

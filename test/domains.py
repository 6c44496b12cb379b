"""A domain of the middleware for who asks: no other process of this machine that asks here has the same one.

Two workers of pytest in one domain hear each other's nodes: a recorder records what it never was told of, a run finds
a commander that is not its own.
"""

import fcntl
import os
import random
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import chain

# The middleware within this machine, without shared memory, which a killed node may leave locked for good: others then
# hang where they begin, or stall. `ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST` would bring it back, whatever else is said.
_PROFILE = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'localhost.xml')
OF_FAST_DDS = os.environ.get('RMW_IMPLEMENTATION', 'rmw_fastrtps_cpp') == 'rmw_fastrtps_cpp'
ALONE = {
    'FASTRTPS_DEFAULT_PROFILES_FILE': _PROFILE,  # of Fast DDS 2
    'FASTDDS_DEFAULT_PROFILES_FILE': _PROFILE,  # of Fast DDS 3
    'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET',  # the profile is narrower
}
if not OF_FAST_DDS:  # another reads no profile
    ALONE = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}

# `scripts/setup` gives those up to 50 to what runs beside the tests; above 101 a domain meets ephemeral ports.
FIRST, LAST = 51, 101


def take() -> int:
    """A domain that is this process's own for as long as it lives."""
    return _taken()[0]


@contextmanager
def lent() -> Iterator[int]:
    """A domain that is this process's own for a while: what was killed in another is believed to be there for 20 s."""
    number, place = _taken()
    try:
        yield number
    finally:
        os.close(place)


def _taken() -> tuple[int, int]:
    """The domain, and the open file that holds it."""
    folder = os.path.join(tempfile.gettempdir(), f'tcp_muscle_domains_{os.getuid()}')
    os.makedirs(folder, exist_ok=True)
    # Not always the first: what a run before this one left behind may still be there.
    begin = random.SystemRandom().randint(FIRST, LAST)
    for number in chain(range(begin, LAST + 1), range(FIRST, begin)):
        place = os.open(os.path.join(folder, str(number)), os.O_RDWR | os.O_CREAT)
        try:
            fcntl.flock(place, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(place)
        else:
            return number, place
    raise RuntimeError(f'all domains from {FIRST} to {LAST} are taken; see {folder}')

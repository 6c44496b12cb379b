"""What scripts/kills.py sees of the processes: what they publish, and how long they waited for a core."""

from __future__ import annotations

import os
import subprocess
import time
from contextlib import suppress
from itertools import pairwise
from pathlib import Path

from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64


class Waits:
    """How long (s) a process has waited for a core since this was made, and what other machines on the same cores took
    from this one.

    All its threads together: they wait for each other, one holding what the next must have, and each for a core. Always
    0 where the kernel does not count it.
    """

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._threads = Path(f'/proc/{process.pid}/task')
        self._before, self._taken = self._counted(), self._stolen()

    def _counted(self) -> dict[str, tuple[float, float]]:
        """Of each thread: computed, waited."""
        found = {}
        for path in self._threads.glob('*/schedstat'):
            with suppress(OSError):  # a thread that ended meanwhile
                computed, waited, _ = path.read_text().split()
                found[path.parent.name] = int(computed) * 1e-9, int(waited) * 1e-9
        return found

    def _stolen(self) -> float:
        """Of each core, on average."""
        said = Path('/proc/stat').read_text().splitlines()[0].split()
        return int(said[8]) / os.sysconf('SC_CLK_TCK') / (os.cpu_count() or 1)

    def so_far(self) -> float:
        """Up to now."""
        return self._sum(1) + self._stolen() - self._taken

    def __str__(self) -> str:
        """Of what the process did with its time."""
        return f'it computed {self._sum(0):.2f} s, {self._stolen() - self._taken:.2f} s were stolen'

    def _sum(self, k: int) -> float:
        none = (0.0, 0.0)
        return sum(now[k] - self._before.get(one, none)[k] for one, now in self._counted().items())


class Heard:
    """A topic's values with the times (steady, s) at which they came."""

    def __init__(self, node: Node, topic: str) -> None:
        self.messages: list[tuple[float, float]] = []
        self._node = node
        self._subscription = node.create_subscription(Float64, topic, self._take, QoSProfile(depth=100))

    def _take(self, message: Float64) -> None:
        self.messages.append((time.monotonic(), message.data))
        del self.messages[:-2000]

    @property
    def last(self) -> float:
        """The latest value; 0 where there is none of the last half second."""
        came, value = self.messages[-1] if self.messages else (0.0, 0.0)
        return value if time.monotonic() - came < 0.5 else 0.0

    def __str__(self) -> str:
        """Who publishes on the topic, and what came of it."""
        topic = self._subscription.topic_name
        there, matched = self._node.count_publishers(topic), self._subscription.get_publisher_count()
        came = f'{time.monotonic() - self.messages[-1][0]:.1f} s ago' if self.messages else 'never'
        return f'{topic} has {there} publishers here, {matched} of them matched; the last message came {came}'

    def zero_after(self, moment: float) -> float:
        """How long after the moment (s) a value above zero last came, less what the machine held up."""
        since = [(came, value) for came, value in self.messages[:] if came >= moment - 1.0]
        positive = [came - moment for came, value in since if value > 0.0]
        pause = max((b - a for (a, _), (b, _) in pairwise(since)), default=0.0)
        return max(0.0, max(positive, default=0.0) - max(pause - 0.02, 0.0))

"""The recorder beside a node that plays: in a thread of its own, or in step with a simulation in lockstep."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from pathlib import Path

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.nodes.recorder import Recorder


class RecorderBeside:
    """A recorder; ``in_thread``: in one of its own, else what has come is recorded when told to."""

    def __init__(
        self,
        bag: Path,
        namespace: str,
        known: Mapping[str, object],
        more: Mapping[str, type],
        wanted: Sequence[str],
        in_thread: bool,
    ) -> None:
        self.failure: BaseException | None = None
        self._recorder = Recorder(bag, namespace, False, lambda _: None, known=known, more=more, wanted=wanted)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name='recorder', daemon=True) if in_thread else None
        if self._thread is not None:
            self._thread.start()

    def _run(self) -> None:
        try:
            self._recorder.run(None, self._stop.is_set)
        except BaseException as failure:
            self.failure = failure

    def take(self, at: int) -> None:
        """Record what has come, as of ``at`` (ns)."""
        try:
            self._recorder.turn(at)
        except BadInput as failure:
            self.failure = failure

    @property
    def topics(self) -> frozenset[str]:
        """Those of which something is in the bag."""
        return self._recorder.topics

    @property
    def absent(self) -> str:
        """Which of the wanted topics nobody publishes, as the end of a sentence; '' where all are."""
        return self._recorder.absent()

    def end(self) -> None:
        """Finish the bag. Raises what went wrong meanwhile."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
        self._recorder.close()
        if self.failure is not None:
            raise self.failure

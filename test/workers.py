"""Which worker of pytest-xdist runs which file, so that no core waits for the clock.

What keeps to the clock mostly waits: two files of it at once leave half of two cores idle, and a third beside them was
too many for a slow machine. So all workers but the last begin with it, and the last computes beside them: behind them,
where both want a core (``conftest.py``). All compute together what is then left.
"""

from xdist.scheduler import LoadFileScheduling


class Scheduling(LoadFileScheduling):
    """File by file in the order of the collection; ``clocked`` begins the names of those that keep to the clock."""

    def __init__(self, config, log, clocked):
        super().__init__(config, log)
        self._clocked = clocked

    def _suited(self, worker):
        """The file that this worker is to run next, None where nothing is left for it."""
        # One that takes the place of a worker that crashed has a number of its own, beyond the last.
        last = self.numnodes > 1 and worker.gateway.id == f'gw{self.numnodes - 1}'
        clocked = [] if last else [file for file in self.workqueue if file.startswith(self._clocked)]
        return next(iter([*clocked, *(file for file in self.workqueue if not file.startswith(self._clocked))]), None)

    def _assign_work_unit(self, node):
        file = self._suited(node)
        if file is None:
            node.shutdown()
            return
        self.workqueue.move_to_end(file, last=False)
        super()._assign_work_unit(node)

    def _reschedule(self, node):
        if self._suited(node) is not None:
            super()._reschedule(node)
        elif not node.shutting_down:
            node.shutdown()

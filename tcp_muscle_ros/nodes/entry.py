"""Where a node's process begins, before anything that takes long to load: asked to stop meanwhile, it just ends.

No current flows yet and nothing is open; from ``lifetime.run`` on, the handlers there are in force.
"""

import os
import signal


def end_quietly_when_asked() -> None:
    """SIGINT and SIGTERM end the process with exit code 0, as they do later."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: os._exit(0))


def sim_node() -> int:
    """The program sim_node."""
    end_quietly_when_asked()
    from tcp_muscle_ros.nodes.sim_node import main

    return main()


def controller_node() -> int:
    """The program controller_node."""
    end_quietly_when_asked()
    from tcp_muscle_ros.nodes.controller_node import main

    return main()

"""Where a node's process begins, before anything that takes long to load: asked to stop meanwhile, it just ends.

No current flows yet and nothing is open; from ``lifetime.run`` on, the handlers there are in force.
"""

from tcp_muscle_ros.process.quiet_end import end_quietly_when_asked


def sim_node() -> int:
    """The program sim_node."""
    end_quietly_when_asked()
    from tcp_muscle_ros.nodes.sim_node import main

    return main()


def serial_driver_node() -> int:
    """The program serial_driver_node."""
    end_quietly_when_asked()
    from tcp_muscle_ros.nodes.serial_driver_node import main

    return main()


def controller_node() -> int:
    """The program controller_node."""
    end_quietly_when_asked()
    from tcp_muscle_ros.nodes.controller_node import main

    return main()


def twin_node() -> int:
    """The program twin_node."""
    end_quietly_when_asked()
    from tcp_muscle_ros.nodes.twin_node import main

    return main()

"""Where the processor time of one tick of sim_node goes.

    python benchmarks/node_tick.py

One muscle in this process, ticks back to back without waiting, nobody subscribed. The least work publishes the same
seven messages unchanged, as objects and as bytes; the parts are called by themselves, so that they need not add up.
"""

import os
import time

import rclpy
from publishing import TOPICS
from rclpy.node import Node
from rclpy.serialization import serialize_message
from side_by_side import Contender, in_turns, show

from tcp_muscle_ros.nodes.sim_node import SimNode
from tcp_muscle_ros.nodes.topics import STATE_QOS

TICKS = 500
PERIOD = 0.001  # s


def main() -> None:
    """Time the parts in turns; print the table."""
    os.environ.update(ROS_DOMAIN_ID='96', ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST')
    rclpy.init()
    bare = Node('bare')
    pairs = [(bare.create_publisher(kind, f'bare/{name}', STATE_QOS), kind()) for name, kind in TOPICS.items()]
    serialized = [(publisher, bytes(serialize_message(message))) for publisher, message in pairs]
    node = SimNode()
    muscle = node.muscles[0]
    stamp = node.time_base.now()
    reading = muscle.muscle.reading(0.0)
    parts = {
        'least: seven messages published': lambda: [publisher.publish(message) for publisher, message in pairs],
        'the same, serialised ahead': lambda: [publisher.publish(message) for publisher, message in serialized],
        'ours: a whole tick': lambda: node._tick(stamp, PERIOD, True),
        'of it: numbers written and messages published': lambda: node._publish(stamp),
        'of it: sensors, safety and the next current': lambda: muscle.decide(reading, PERIOD, time.monotonic()),
        'of it: the step of the muscle': lambda: node._together.step(PERIOD, [0.0]),
        'of it: a look for changes of state': node._notice_changes,
    }

    def repeated(part):
        def run() -> None:
            for _ in range(TICKS):
                part()

        return run

    measured = in_turns([Contender(name, repeated(part)) for name, part in parts.items()])
    floor = measured[0].seconds
    show(
        'Processor time of one tick of sim_node', ('', 'us', 'over the least'),
        [(row.name, f'{1e6 * row.seconds / TICKS:.1f}', f'{row.seconds / floor:.2f}') for row in measured],
    )  # fmt: skip
    rclpy.shutdown()


if __name__ == '__main__':
    main()

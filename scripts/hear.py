#!/usr/bin/env python3
"""Hear a muscle from another process, as `ros2 topic echo`, `param get` and `service call` do where there is a ROS 2.

python scripts/hear.py NAMESPACE      # of a sim_node whose current_limit_a is 0.1
"""

import sys
from typing import Any

import rclpy
from rcl_interfaces.srv import GetParameters
from rclpy.node import Node
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64
from std_srvs.srv import SetBool

TOPICS = {'displacement': Float64, 'current': Float64, 'temperature': Temperature}


def answer(node: Node, kind: Any, service: str, request: Any) -> Any:
    """What a service answers."""
    client = node.create_client(kind, service)
    if not client.wait_for_service(60.0):
        raise SystemExit(f'nobody serves {service}')
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=30.0)
    return future.result()


def main() -> int:
    """0 where all was heard."""
    (namespace,) = sys.argv[1:]
    rclpy.init()
    node = rclpy.create_node('hear')
    heard: dict[str, Any] = {}
    for name, kind in TOPICS.items():
        node.create_subscription(
            kind, f'{namespace}/{name}', lambda message, name=name: heard.update({name: message}), 1
        )
    limit = answer(
        node,
        GetParameters,
        f'{namespace}/sim_node/get_parameters',
        GetParameters.Request(names=['current_limit_a']),
    )
    enabled = answer(node, SetBool, f'{namespace}/sim_node/enable', SetBool.Request(data=True))
    for _ in range(1000):
        rclpy.spin_once(node, timeout_sec=0.1)
        if set(heard) == set(TOPICS):
            break
    print(heard, limit, enabled)
    rclpy.shutdown()
    right = set(heard) == set(TOPICS) and limit.values[0].double_value == 0.1 and enabled.success
    return 0 if right else 1


if __name__ == '__main__':
    sys.exit(main())

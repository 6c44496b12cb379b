"""Write config/sros2_policy.xml: for each node of one muscle the topics and services that it has, and no more.

python scripts/make_sros2_policy.py      # starts the nodes and asks them
"""

import subprocess
import sys
import time
from pathlib import Path

import rclpy
from rclpy.node import Node

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / 'config' / 'sros2_policy.xml'
NODES = ('sim_node', 'controller_node', 'serial_driver_node', 'twin_node')
HEAD = """\
<?xml version="1.0" encoding="UTF-8"?>
<!--
  SROS 2 policy: the least that each node of one muscle needs. Made by scripts/make_sros2_policy.py from the running
  nodes, and held against them by test/nodes/test_security.py. For a muscle in a namespace write it in place of ns="/".
  Simulated time (/clock, /lockstep/tick, /lockstep/done) is left out: whoever sets the clock holds the watchdogs.

  ros2 security create_keystore keys && ros2 security generate_artifacts -k keys -p config/sros2_policy.xml
-->
<policy version="0.2.0">
  <enclaves>
"""
Access = dict[str, list[str]]


def access_of(asker: Node, name: str, namespace: str) -> Access:
    """What a node publishes, subscribes to, serves and asks for: absolute names below its namespace made relative."""

    def relative(topics: list[tuple[str, list[str]]]) -> list[str]:
        prefix = namespace.rstrip('/') + '/'
        names = [topic for topic, _ in topics]
        common = ('/diagnostics', '/rosout', '/parameter_events', '/clock')
        return sorted(topic if topic in common else topic.removeprefix(prefix) for topic in names)

    return {
        'publish': relative(asker.get_publisher_names_and_types_by_node(name, namespace)),
        'subscribe': relative(asker.get_subscriber_names_and_types_by_node(name, namespace)),
        'reply': relative(asker.get_service_names_and_types_by_node(name, namespace)),
        'request': relative(asker.get_client_names_and_types_by_node(name, namespace)),
    }


def settled(asker: Node) -> dict[str, Access]:
    """What all nodes have, once each is up (``~/reset``) and nothing was added for 5 s."""
    found: dict[str, Access] = {}
    since = time.monotonic()
    while time.monotonic() - since < 5.0 or len(found) < len(NODES):
        rclpy.spin_once(asker, timeout_sec=0.2)
        there = [name for name in NODES if name in asker.get_node_names()]
        now = {name: access for name in there if f'{name}/reset' in (access := access_of(asker, name, '/'))['reply']}
        if now != found:
            found, since = now, time.monotonic()
    return found


def policy(accesses: dict[str, Access]) -> str:
    """The policy file's text."""
    lines = []
    for node, access in accesses.items():
        lines += [f'    <enclave path="/tcp_muscle/{node}">', '      <profiles>']
        lines.append(f'        <profile ns="/" node="{node}">')
        for kind in ('subscribe', 'publish'):
            lines.append(f'          <topics {kind}="ALLOW">')
            lines += [f'            <topic>{topic}</topic>' for topic in access[kind]]
            lines.append('          </topics>')
        for kind in ('reply', 'request'):
            if access[kind]:
                lines.append(f'          <services {kind}="ALLOW">')
                lines += [f'            <service>{service}</service>' for service in access[kind]]
                lines.append('          </services>')
        lines += ['        </profile>', '      </profiles>', '    </enclave>']
    return HEAD + '\n'.join(lines) + '\n  </enclaves>\n</policy>\n'


def main() -> int:
    rclpy.init()
    asker = rclpy.create_node('asker')
    processes = [subprocess.Popen([sys.executable, '-m', f'tcp_muscle_ros.nodes.{name}']) for name in NODES]
    try:
        FILE.write_text(policy(settled(asker)), encoding='utf-8')
    finally:
        for process in processes:
            process.terminate()
            process.wait()
        rclpy.shutdown()
    print(f'wrote {FILE.relative_to(ROOT)}')
    return 0


if __name__ == '__main__':
    sys.exit(main())

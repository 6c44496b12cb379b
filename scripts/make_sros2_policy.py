"""Write SROS 2 policies: for each node the topics and services that it has, and no more.

python scripts/make_sros2_policy.py      # those of config/: starts the nodes and asks them
python scripts/make_sros2_policy.py --params-file hand.yaml --output policy.xml      # of muscles and joints of your own
"""

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import rclpy
from rclpy.node import Node

CONFIG = Path(__file__).resolve().parents[1] / 'config'
NODES = ('sim_node', 'controller_node', 'serial_driver_node', 'twin_node')
# Of `tcp_muscle record`, and of `tcp_muscle run`, which records too; what each has once it is up (others: ~/reset).
RECORDER, RUNNER = 'muscle_recorder', 'protocol_runner'
HAS = {RECORDER: ('subscribe', 'displacement'), RUNNER: ('publish', 'command_lateness')}
OF_MANY = ('sim_node', 'controller_node')  # which take a list of muscles, and of joints
HEAD = """\
<?xml version="1.0" encoding="UTF-8"?>
<!--
  SROS 2 policy: the least that each node of {whom} needs. Made by scripts/make_sros2_policy.py from
  the running nodes, and held against them by test/nodes/test_security.py. {elsewhere}
  Simulated time (/clock, /lockstep/tick, /lockstep/done) is left out: whoever sets the clock holds the watchdogs.

  ros2 security create_keystore keys && ros2 security generate_artifacts -k keys -p config/{name}
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


def settled(asker: Node, nodes: Sequence[str]) -> dict[str, Access]:
    """What all nodes have, once each is up and nothing was added for 5 s."""

    def up(name: str, access: Access) -> bool:
        kind, what = HAS.get(name, ('reply', f'{name}/reset'))
        return what in access[kind]

    found: dict[str, Access] = {}
    since = time.monotonic()
    while time.monotonic() - since < 5.0 or len(found) < len(nodes):
        rclpy.spin_once(asker, timeout_sec=0.2)
        there = [name for name in nodes if name in asker.get_node_names()]
        now = {name: access for name in there if up(name, access := access_of(asker, name, '/'))}
        if now != found:
            found, since = now, time.monotonic()
    return found


def profile(node: str, access: Access) -> list[str]:
    """The lines of one node."""
    lines = [f'        <profile ns="/" node="{node}">']
    for kind in ('subscribe', 'publish'):
        lines.append(f'          <topics {kind}="ALLOW">')
        lines += [f'            <topic>{topic}</topic>' for topic in access[kind]]
        lines.append('          </topics>')
    for kind in ('reply', 'request'):
        if access[kind]:
            lines.append(f'          <services {kind}="ALLOW">')
            lines += [f'            <service>{service}</service>' for service in access[kind]]
            lines.append('          </services>')
    return [*lines, '        </profile>']


def policy(processes: Mapping[str, Mapping[str, Access]], head: str) -> str:
    """The policy file's text, of the nodes of each process: keys are a process's."""
    lines = []
    for process, nodes in processes.items():
        lines += [f'    <enclave path="/tcp_muscle/{process}">', '      <profiles>']
        for node, access in nodes.items():
            lines += profile(node, access)
        lines += ['      </profiles>', '    </enclave>']
    return head + '\n'.join(lines) + '\n  </enclaves>\n</policy>\n'


@contextmanager
def running(modules: Sequence[Sequence[str]]) -> Iterator[None]:
    """Processes, each a module with its arguments."""
    processes = [subprocess.Popen([sys.executable, '-m', *module]) for module in modules]
    try:
        yield
    finally:
        for process in processes:
            process.terminate()
            process.wait()


def write(file: Path, params_file: Path | None) -> None:
    """Start the nodes of one muscle, or of the muscles and joints of a parameter file, and write what they have."""
    nodes = NODES if params_file is None else OF_MANY
    arguments = [] if params_file is None else ['--ros-args', '--params-file', str(params_file)]
    if params_file is None:
        whom, elsewhere = 'one muscle', 'For a muscle in a namespace\n  write it in place of ns="/".'
    else:
        whom, elsewhere = f'the joint of {params_file.name}', 'Other names have\n  other topics.'
    asker = rclpy.create_node('asker')
    modules = {name: [f'tcp_muscle_ros.nodes.{name}', *arguments] for name in nodes}
    if 'serial_driver_node' in modules:
        modules['serial_driver_node'] += ['--ros-args', '-p', 'port:=/dev/ptmx']  # opens, and no board answers
    with running(list(modules.values())):
        found = {name: {name: access} for name, access in settled(asker, nodes).items()}
    if params_file is None:
        found |= tools(asker, modules['sim_node'])
    asker.destroy_node()
    file.write_text(policy(found, HEAD.format(whom=whom, elsewhere=elsewhere, name=file.name)), encoding='utf-8')
    print(f'wrote {file}')


def tools(asker: Node, muscle: Sequence[str]) -> dict[str, dict[str, Access]]:
    """What `tcp_muscle record` has, then `tcp_muscle run` beside a muscle."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        tool = ('tcp_muscle_ros.tool', 'record', '--output', f'{folder}/recorded')
        with running([muscle, tool]):
            found[RECORDER] = settled(asker, [RECORDER])
        tool = ('tcp_muscle_ros.tool', 'run', str(CONFIG / 'protocol_steps.yaml'), '--output', f'{folder}/played')
        with running([muscle, tool]):
            found[RUNNER] = settled(asker, [RUNNER, RECORDER])
    return found


def main() -> int:
    """Without arguments the policies of config/."""
    parser = argparse.ArgumentParser(description='Write SROS 2 policies from the running nodes.')
    parser.add_argument('--params-file', type=Path, help='muscles and joints of your own')
    parser.add_argument('--output', type=Path, help='where their policy goes')
    args = parser.parse_args()
    if (args.params_file is None) != (args.output is None):
        parser.error('--params-file and --output go together')
    rclpy.init()
    try:
        if args.output:
            write(args.output, args.params_file)
        else:
            write(CONFIG / 'sros2_policy.xml', None)
            write(CONFIG / 'sros2_policy_joint.xml', CONFIG / 'antagonist.yaml')
    finally:
        rclpy.shutdown()
    return 0


if __name__ == '__main__':
    sys.exit(main())

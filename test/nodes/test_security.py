"""The policies of config/ give each node what it has, and no more."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')
pytest.importorskip('serial', reason='needs pyserial, the extra hardware')

CONFIG = Path(__file__).resolve().parents[2] / 'config'
JOINT = CONFIG / 'antagonist.yaml'  # two muscles and a joint, of which sros2_policy_joint.xml is
COMMON = ('/diagnostics', '/rosout', '/parameter_events', '/clock')
pytestmark = pytest.mark.processes


def allowed(file):
    """(process, node, kind) -> names, of a policy."""
    policy = ElementTree.parse(CONFIG / file).getroot()
    found = {}
    for enclave in policy.iter('enclave'):
        process = enclave.get('path').removeprefix('/tcp_muscle/')
        profiles = list(enclave.iter('profile'))
        assert profiles[0].get('node') == process and {profile.get('ns') for profile in profiles} == {'/'}
        for profile in profiles:
            for group in profile:
                ((kind, permission),) = group.attrib.items()
                assert permission == 'ALLOW'
                found[process, profile.get('node'), kind] = {entry.text for entry in group}
    return found


def relative(names_and_types, namespace):
    names = {name for name, _ in names_and_types}
    return {name if name in COMMON else name.removeprefix(namespace + '/') for name in names}


def holds(bench, policy, process, namespace, node=''):
    """Whether a running node has exactly what the policy allows it, in a process of this name."""
    node = node or process
    asks = {
        'publish': bench.node.get_publisher_names_and_types_by_node,
        'subscribe': bench.node.get_subscriber_names_and_types_by_node,
        'reply': bench.node.get_service_names_and_types_by_node,
        'request': bench.node.get_client_names_and_types_by_node,
    }
    bench.until(lambda: (node, namespace) in bench.node.get_node_names_and_namespaces(), 'it is not there', 120.0)

    def has(kind):
        # Services stand below the node's own name, which a namespace stands before.
        return relative(asks[kind](node, namespace), namespace)

    def as_allowed():
        return all(has(kind) == policy.get((process, node, kind), set()) for kind in asks)

    bench.until(as_allowed, f'{node} has other topics', 10.0)


@pytest.mark.parametrize('node', ['sim_node', 'controller_node', 'serial_driver_node', 'twin_node'])
def test_a_node_has_exactly_the_topics_and_services_of_the_policy(bench, no_board, node):
    port = {'port': no_board} if node == 'serial_driver_node' else {}
    program = bench.start(node, f'secure_{node}', **port)
    holds(bench, allowed('sros2_policy.xml'), node, f'/secure_{node}')
    program.kill()


def tool(bench, *arguments):
    return bench.run(['-m', 'tcp_muscle_ros.tool', *map(str, arguments)], arguments[0])


def test_so_has_who_records_and_who_plays_a_protocol_which_records_too(bench, tmp_path):
    """One process, one enclave: `tcp_muscle run` has the profiles of its two nodes."""
    policy = allowed('sros2_policy.xml')
    recorder = tool(bench, 'record', '--output', tmp_path / 'recorded', '--namespace', 'secure_recorded')
    holds(bench, policy, 'muscle_recorder', '/secure_recorded')
    recorder.kill()
    muscle = bench.start('sim_node', 'secure_run')
    runner = tool(
        bench, 'run', CONFIG / 'protocol_steps.yaml', '--output', tmp_path / 'played', '--namespace', 'secure_run'
    )
    for node in ('protocol_runner', 'muscle_recorder'):
        holds(bench, policy, 'protocol_runner', '/secure_run', node)
    runner.kill()
    muscle.kill()


def test_who_records_commands_nothing():
    policy = allowed('sros2_policy.xml')
    assert policy['muscle_recorder', 'muscle_recorder', 'publish'] <= {'/parameter_events', '/rosout'}
    played = policy['protocol_runner', 'protocol_runner', 'publish']
    assert {topic for topic in played if topic.endswith('_command')} == {'current_command'}


@pytest.mark.parametrize('node', ['sim_node', 'controller_node'])
def test_so_has_a_node_of_two_muscles_on_a_joint(bench, node):
    policy = allowed('sros2_policy_joint.xml')
    program = bench.start(node, f'secure_joint_{node}', '--params-file', str(JOINT))
    holds(bench, policy, node, f'/secure_joint_{node}')
    program.kill()
    assert {process for process, _, _ in policy} == {'sim_node', 'controller_node'}


def test_who_commands_a_joint_commands_no_muscle():
    """Of the joint's nodes only the controller may say what current flows."""
    policy = allowed('sros2_policy_joint.xml')
    commands = {'flexor/current_command', 'extensor/current_command'}
    assert (
        commands <= policy['controller_node', 'controller_node', 'publish']
        and commands <= policy['sim_node', 'sim_node', 'subscribe']
    )
    assert not commands & policy['sim_node', 'sim_node', 'publish']
    assert {'knuckle/angle', 'knuckle/angle_setpoint'} <= policy['controller_node', 'controller_node', 'subscribe']
    assert 'knuckle/angle' in policy['sim_node', 'sim_node', 'publish']

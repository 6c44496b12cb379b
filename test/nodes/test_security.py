"""config/sros2_policy.xml gives each node what it has, and no more."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')
pytest.importorskip('serial', reason='needs pyserial, the extra hardware')

ROOT = Path(__file__).resolve().parents[2]
COMMON = ('/diagnostics', '/rosout', '/parameter_events', '/clock')
pytestmark = pytest.mark.processes


def allowed():
    """(node, kind) -> names, of the policy."""
    policy = ElementTree.parse(ROOT / 'config' / 'sros2_policy.xml').getroot()
    found = {}
    for enclave in policy.iter('enclave'):
        (profile,) = enclave.iter('profile')
        assert enclave.get('path') == f'/tcp_muscle/{profile.get("node")}' and profile.get('ns') == '/'
        for group in profile:
            ((kind, permission),) = group.attrib.items()
            assert permission == 'ALLOW'
            found[profile.get('node'), kind] = {entry.text for entry in group}
    return found


def relative(names_and_types, namespace):
    names = {name for name, _ in names_and_types}
    return {name if name in COMMON else name.removeprefix(namespace + '/') for name in names}


@pytest.mark.parametrize('node', ['sim_node', 'controller_node', 'serial_driver_node', 'twin_node'])
def test_a_node_has_exactly_the_topics_and_services_of_the_policy(bench, node):
    policy, namespace = allowed(), f'/secure_{node}'
    program = bench.start(node, namespace.strip('/'))
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
        return all(has(kind) == policy.get((node, kind), set()) for kind in asks)

    bench.until(as_allowed, f'{node} has other topics', 10.0)
    program.kill()

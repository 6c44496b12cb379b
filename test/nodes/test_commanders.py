"""Who commands a muscle is counted by processes: two nodes of one name are two, but for one that was killed."""

from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from tcp_muscle_ros.nodes import topics
from tcp_muscle_ros.nodes.mixing import Mixing
from tcp_muscle_ros.nodes.topics import LEASE, NAMELESS, REMEMBERED, Commanders

TOPICS = ('/current_command', '/power_command')
ME = '/protocol_runner'


class Graph:
    """A node's view: who publishes where, and a time that the test sets."""

    def __init__(self, monkeypatch):
        self.ends, self.now = [], 1000.0
        self.commanders = Commanders()
        monkeypatch.setattr(topics, 'time', SimpleNamespace(monotonic=lambda: self.now))

    def add(self, process, name='protocol_runner', topic=TOPICS[0]):
        gid = [process] * 12 + [0, 0, len(self.ends), 3]
        end = SimpleNamespace(node_name=name, node_namespace='/', endpoint_gid=gid, topic=topic, process=process)
        self.ends.append(end)

    def remove(self, process):
        self.ends = [end for end in self.ends if end.process != process]

    def count_publishers(self, topic):
        return len(self.get_publishers_info_by_topic(topic))

    def get_publishers_info_by_topic(self, topic):
        return [end for end in self.ends if end.topic == topic]

    def look(self, standing, after=0.0):
        self.now += after
        return self.commanders.look(self, TOPICS, standing)


@pytest.fixture
def graph(monkeypatch):
    return Graph(monkeypatch)


@pytest.mark.parametrize('topic', TOPICS)
def test_two_nodes_of_one_name_are_two_once_both_stand_longer_than_one_that_was_killed(graph, topic):
    graph.add(1)
    assert graph.look(REMEMBERED, 100.0) == {ME}
    graph.add(2, topic=topic)
    assert graph.look(0.0) == {ME, f'another {ME}'}
    assert graph.look(REMEMBERED) == graph.look(REMEMBERED, LEASE) == {ME}
    assert graph.look(REMEMBERED, 6.0) == {ME, f'another {ME}'}
    graph.remove(1)
    assert graph.look(REMEMBERED) == {ME}


def test_a_node_that_is_killed_and_begun_again_over_and_over_is_one(graph):
    for process in range(1, 20):
        graph.add(process)
        graph.remove(process - 2)
        assert graph.look(REMEMBERED) == graph.look(REMEMBERED, LEASE) == {ME}


def test_a_node_with_two_publishers_is_one_and_nodes_without_a_name_have_none_in_common(graph):
    for topic in (*TOPICS, *TOPICS):
        graph.add(1, topic=topic)
    assert graph.look(0.0) == {ME}
    for process in (2, 3):
        graph.add(process, name='_NODE_NAME_UNKNOWN_')
    assert graph.look(0.0) == {ME, NAMELESS}


@pytest.mark.parametrize('name', ['sim_node', 'driver'])
def test_two_nodes_that_publish_a_measurement_are_told_once_when_neither_was_killed(graph, name):
    mixing, told = Mixing(), []
    topic = '/displacement'

    def look(after=0.0):
        graph.now += after
        return list(mixing.look(graph, [topic, '/current'], told.append))

    graph.add(1, name=name, topic=topic)
    graph.add(1, name=name, topic=topic)
    assert look() == look(2 * REMEMBERED) == [], 'one node with two publishers'
    graph.add(2, name='sim_node', topic=topic)
    assert look() == look(LEASE) == []
    (said,) = look(REMEMBERED)
    assert said.startswith(f'/displacement is published by /{name} and by /sim_node: ') and told == [said]
    assert look(1.0) == told and len(told) == 1
    graph.remove(1)
    assert look(1.0) == []

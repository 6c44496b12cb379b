"""How a node's topics are offered and heard: the quality of service of each, and who does not match it.

A measurement is heard best effort, so that a driver may offer it either way. A command must arrive, and only the newest
counts. What ``qos_overrides`` in a parameter file says of a topic comes before both.
"""

import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from copy import copy
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSCompatibility, QoSPolicyKind, QoSProfile, ReliabilityPolicy, qos_check_compatible
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.nodes.ticks import BACKLOG
from tcp_muscle_ros.settings.operating import shown

MEASUREMENT_QOS = QoSProfile(depth=BACKLOG, reliability=ReliabilityPolicy.BEST_EFFORT)  # in
COMMAND_QOS = QoSProfile(depth=1)  # in and out: reliable, keep last; only the newest command counts
STATE_QOS = QoSProfile(depth=BACKLOG)  # out: reliable, keep last
OVERRIDES = 'qos_overrides.'
COMMANDED_BY = 'commanded_by'  # in /diagnostics: the nodes that command a muscle, or nobody
NOBODY = 'nobody'
NAMELESS = 'an unknown node'  # found, but not by name yet, or no longer: a node that comes or goes, or none of ROS
# What a simulated muscle or joint publishes in every tick, by the last part of the topic.
EVERY_TICK = frozenset(('current', 'voltage', 'temperature', 'displacement', 'force', 'joint_states', 'angle'))
LEASE = 20.0  # s, for which a node that was killed is still believed to be there
REMEMBERED = LEASE + 5.0  # s, after which one that still stands in the graph lives
_PROCESS = 12  # bytes of an endpoint's identifier that all of its process share
_NEVER = Duration(seconds=1e9)
_DEEPEST = 100_000  # messages; a queue that is deeper is a mistake
_POLICIES = {
    QoSPolicyKind.RELIABILITY: ('reliable', 'best_effort', 'system_default'),
    QoSPolicyKind.HISTORY: ('keep_last', 'keep_all', 'system_default'),
    QoSPolicyKind.DEPTH: (),
}
_CHOICES = {kind.name.lower(): choices for kind, choices in _POLICIES.items()}


class Topics:
    """Makes the publishers and subscriptions of a node, and knows whom they cannot reach.

    Overrides are named as in every ROS 2 node: ``qos_overrides.<topic>.<publisher or subscription>.<policy>``, with
    ``reliability``, ``history`` or ``depth`` as the policy.

    Raises:
        BadInput: an override whose value its policy does not have.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        given: Mapping[str, Any] = node._parameter_overrides  # rclpy has no public way to list the undeclared
        self._overrides = [name for name in given if name.startswith(OVERRIDES)]
        for name in self._overrides:
            _check(name, given[name].value)
        self._known: list[str] = []
        self._publishers: list[Publisher] = []
        self._subscriptions: list[Subscription] = []

    def publisher(self, kind: type, topic: str, qos: QoSProfile) -> Publisher:
        """A publisher."""
        made = self._node.create_publisher(
            kind,
            topic,
            copy(qos),
            event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
            qos_overriding_options=self._overriding(topic, 'publisher'),
        )
        self._publishers.append(made)
        return made

    def subscription(
        self, kind: type, topic: str, take: Callable[[Any], None], qos: QoSProfile, group: CallbackGroup | None = None
    ) -> Subscription:
        """A subscription."""
        made = self._node.create_subscription(
            kind,
            topic,
            take,
            copy(qos),
            callback_group=group,
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
            qos_overriding_options=self._overriding(topic, 'subscription'),
        )
        self._subscriptions.append(made)
        return made

    def forget(self, subscription: Subscription) -> None:
        """End a subscription."""
        self._subscriptions.remove(subscription)
        self._node.destroy_subscription(subscription)

    def unused_overrides(self) -> list[str]:
        """What to say of overrides that fit no topic here, when all topics are made. One file may serve both nodes."""
        return [
            f"parameter '{name}' fits no topic of this node{nearest(name, self._known)}"
            for name in self._overrides
            if name not in self._known
        ]

    def mismatches(self) -> dict[str, str]:
        """By topic, who there is not heard or does not hear, and why: ``incompatible QoS ...``. Asks the graph."""
        found: dict[str, str] = {}
        node = self._node
        for one in self._subscriptions:
            topic, mine = one.topic_name, one.qos_profile
            # Two counts tell whether anybody is left out; who it is takes a walk through the graph.
            if node.count_publishers(topic) > one.get_publisher_count():
                others = node.get_publishers_info_by_topic(topic)
                _note(found, topic, one.msg_type, [(other, other.qos_profile, mine) for other in others])
        for one in self._publishers:
            topic, mine = one.topic_name, one.qos_profile
            if node.count_subscribers(topic) > one.get_subscription_count():
                others = node.get_subscriptions_info_by_topic(topic)
                _note(found, topic, one.msg_type, [(other, mine, other.qos_profile) for other in others])
        return found

    def mismatches_since(self, before: Mapping[str, str], tell: Callable[[str], object]) -> dict[str, str]:
        """The same; what was not there ``before`` is told."""
        now = self.mismatches()
        for topic, sentence in now.items():
            if before.get(topic) != sentence:
                tell(sentence)
        return now

    def _overriding(self, topic: str, end: str) -> QoSOverridingOptions:
        """The policies that are overridden; declared as parameters only then, so that the list of them stays short."""
        prefix = f'{OVERRIDES}{self._node.resolve_topic_name(topic)}.{end}.'
        kinds = []
        for kind in _POLICIES:
            name = prefix + kind.name.lower()
            self._known.append(name)
            if name in self._overrides:
                kinds.append(kind)
        return QoSOverridingOptions(kinds)


def _check(name: str, value: object) -> None:
    policy = name.rpartition('.')[2]
    if policy not in _CHOICES:
        return  # of a topic of rclpy's own, or said of later
    choices = _CHOICES[policy]
    if choices and value not in choices:
        raise BadInput(f"parameter '{name}' is {shown(value)}{nearest(str(value), choices)}")
    if not choices and not (isinstance(value, int) and not isinstance(value, bool) and 0 < value <= _DEEPEST):
        raise BadInput(f"parameter '{name}' is {shown(value)}; expected a whole number, 1 to {_DEEPEST}")


def _note(
    found: dict[str, str], topic: str, kind: Any, pairs: Iterable[tuple[TopicEndpointInfo, QoSProfile, QoSProfile]]
) -> None:
    """Add the first of the others, with the publisher's and the subscriber's QoS, that does not match."""
    package, _, name = kind.__module__.rpartition('.')[0].partition('.')
    own_type = f'{package}/{name}/{kind.__name__}'
    for other, offered, asked in pairs:
        there = f'{topic} with {name_of(other)}'
        if why := qos_mismatch(offered, asked):
            found[topic] = f'incompatible QoS on {there}: {why}'
            return
        if other.topic_type != own_type:
            found[topic] = f'incompatible type on {there}: {other.topic_type}, expected {own_type}'
            return


def qos_mismatch(offered: QoSProfile, asked: QoSProfile) -> str:
    """Why a subscription that asks for the one hears nobody who offers the other; '' where it does."""
    compatible, why = qos_check_compatible(_stated(offered), _stated(asked))
    if compatible != QoSCompatibility.ERROR:
        return ''
    reasons = (reason.strip().lower() for reason in why.split(';'))
    return ', '.join(reason.removeprefix('error: ') for reason in reasons if reason.startswith('error: '))


def _stated(profile: QoSProfile) -> QoSProfile:
    """The same without deadlines and leases that never end: one that nobody states may be told as such."""
    stated = copy(profile)
    for name in ('deadline', 'liveliness_lease_duration'):
        if getattr(profile, name) > _NEVER:
            setattr(stated, name, Duration())
    return stated


def name_of(end: TopicEndpointInfo) -> str:
    """The full name of the node to which a publisher or a subscription belongs, or ``NAMELESS``."""
    if 'UNKNOWN' in end.node_name:
        return NAMELESS
    return f'{end.node_namespace.rstrip("/")}/{end.node_name}'


def publishers_of(node: Node, topic: str) -> set[str]:
    """The full names of the nodes that publish on a topic."""
    return {name_of(end) for end in node.get_publishers_info_by_topic(topic)} if node.count_publishers(topic) else set()


def published_by(topic: str, names: Iterable[str]) -> str:
    """That several nodes publish on a topic that is one's."""
    return f'{topic} is published by {" and by ".join(sorted(names))}'


def another(name: str) -> str:
    """What a second node is called that has the name of a first."""
    return f'another {name}'


class Commanders:
    """Who publishes on some topics, by the graph. Processes are counted and not names: two nodes may have one.

    One that was killed stands beside its successor for LEASE.
    """

    def __init__(self) -> None:
        self._since: dict[tuple[str, bytes], float] = {}  # s, steady: when a name in a process was first seen

    def look(self, node: Node, topics: Iterable[str], standing: float) -> set[str]:
        """The full names of the nodes; where two have one name, also ``another ...``, once both stand so long (s)."""
        stand = Counter(self.standing(node, topics, standing))
        names = {name for name, _ in self._since}
        return names | {another(name) for name in names - {NAMELESS} if stand[name] > 1}

    def standing(self, node: Node, topics: Iterable[str], seconds: float) -> list[str]:
        """The full names of those that stand so long, each as often as nodes have it."""
        now = time.monotonic()
        ends = [
            end for topic in topics if node.count_publishers(topic) for end in node.get_publishers_info_by_topic(topic)
        ]
        there = {(name_of(end), bytes(end.endpoint_gid[:_PROCESS])) for end in ends}
        self._since = {one: self._since.get(one, now) for one in there}
        return sorted(name for (name, _), since in self._since.items() if now - since >= seconds)

"""Which topic of a bag is which channel: by the names of the contract, or as the user says."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from tcp_muscle_ros.errors import BadInput, Option, nearest
from tcp_muscle_ros.recording import options
from tcp_muscle_ros.recording.bag_files import Bag
from tcp_muscle_ros.recording.recording import CHANNELS, channel_kind
from tcp_muscle_ros.recording.units import UNITS, Unit, unit_of

JOINT_STATES = 'joint_states'
_FROM_JOINT_STATES = {'displacement': 'position', 'force': 'effort'}


@dataclass(frozen=True)
class Source:
    """Where a channel comes from."""

    channel: str
    topic: str
    field: str  # '' = the message's own number
    unit: Unit
    explicit: bool  # the user named the topic


def sources_of(bag: Bag, namespace: str | None, channels: Mapping[str, str], units: Mapping[str, str]) -> list[Source]:
    """Where each channel of a bag comes from: the topic that the user names, else that of the contract.

    ``namespace``, ``channels``, ``units`` as of ``read_bag``. BadInput: no known topic, several namespaces, an unknown
    channel, topic or unit.
    """
    channels = {channel_kind(name, options.CHANNEL).name: text for name, text in channels.items()}
    units = {channel_kind(name, options.UNIT).name: unit for name, unit in units.items()}
    prefix = _namespace(bag, namespace, bool(channels))
    topics: dict[str, tuple[str, str, bool]] = {}
    for kind in CHANNELS.values():
        if prefix + kind.topic in bag.topics:
            topics[kind.name] = (prefix + kind.topic, '', False)
    if prefix + JOINT_STATES in bag.topics:
        for name, field in _FROM_JOINT_STATES.items():
            topics.setdefault(name, (prefix + JOINT_STATES, f'{field}[0]', False))
    for name, text in channels.items():
        topic, _, field = text.partition('.')
        topics[name] = (_topic(bag, prefix, topic, options.channel(name)), field, True)
    for name in units:
        if name not in topics:
            raise BadInput(options.unit(name), f': {bag.path} has no channel of this name{nearest(name, topics)}')
    sources = []
    for name, (topic, field, explicit) in topics.items():
        kind = CHANNELS[name]
        unit = unit_of(units.get(name, kind.unit), UNITS[kind.unit].quantity, options.unit(name))
        sources.append(Source(name, topic, field, unit, explicit))
    return sources


def _namespace(bag: Bag, wanted: str | None, channels_given: bool) -> str:
    """The prefix ('/' or '/ns/') under which the muscle's topics are."""
    contract = {kind.topic for kind in CHANNELS.values()}
    prefixes = {topic.rpartition('/')[0] + '/' for topic in bag.topics if topic.rpartition('/')[2] in contract}
    if not prefixes:  # a joint_states of some robot is a muscle's only where nothing else is
        prefixes = {topic[: -len(JOINT_STATES)] for topic in bag.topics if topic.rpartition('/')[2] == JOINT_STATES}
    if wanted is not None:
        prefix = f'/{wanted.strip("/")}/' if wanted.strip('/') else '/'
        if prefix not in prefixes and not channels_given:
            raise BadInput(
                options.namespace(wanted),
                f": {bag.path} has no muscle's topic there{nearest(prefix[:-1], _shown(prefixes))}",
            )
        return prefix
    if len(prefixes) > 1:
        raise BadInput(
            f'{bag.path}: muscles in several namespaces: {", ".join(_shown(prefixes))}; choose one with ',
            options.this_namespace(_shown(prefixes)[0]),
        )
    if not prefixes and not channels_given:
        raise BadInput(
            f'{bag.path}: no known topic; it has {", ".join(sorted(bag.topics))}; say which is which with ',
            options.some_channel('NAME', 'TOPIC[.FIELD]'),
        )
    return prefixes.pop() if prefixes else '/'


def _shown(prefixes: Collection[str]) -> list[str]:
    return sorted(prefix[:-1] or '/' for prefix in prefixes)


def _topic(bag: Bag, prefix: str, name: str, where: Option) -> str:
    """The topic of a name that may be given without its namespace. BadInput, begun with ``where``: none has it."""
    for candidate in (name, '/' + name, prefix + name):
        if candidate in bag.topics:
            return candidate
    raise BadInput(where, f": {bag.path} has no topic '{name}'{nearest(name, bag.topics)}")

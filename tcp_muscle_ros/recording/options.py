"""What a user can say of a recording or of a lab's file, as an Option of a message."""

from collections.abc import Mapping

from tcp_muscle_ros.errors import Option

CHANNEL = Option('--channel', 'channels')
UNIT = Option('--unit', 'units')
PARAMS = Option('--params', 'params')
A_MAP = ('a map (', Option('--map', 'tcp_muscle import --map'), ', see docs/recording.md)')


def channel(name: str) -> Option:
    """What was said of where a channel comes from."""
    return Option(f'--channel {name}', f"channels['{name}']")


def unit(name: str) -> Option:
    """What was said of a channel's unit."""
    return Option(f'--unit {name}', f"units['{name}']")


def namespace(name: str) -> Option:
    """The namespace that was named."""
    return Option(f'--namespace {name}', f"namespace='{name}'")


def some_channel(name: str, form: str = 'TOPIC') -> Option:
    """To say where a channel comes from, in a ``form`` in which only the user can tell it."""
    return Option(f'--channel {name}={form}', f"load(..., channels={{'{name}': '...'}})")


def these_channels(topics: Mapping[str, str]) -> Option:
    """To say from which topic each of some channels comes."""
    command = ' '.join(f'--channel {name}={topic}' for name, topic in topics.items())
    return Option(command, f'load(..., channels={dict(topics)})')


def this_unit(name: str, unit: str) -> Option:
    """To say in which unit a channel's numbers are."""
    return Option(f'--unit {name}={unit}', f"load(..., units={{'{name}': '{unit}'}})")


def this_namespace(name: str) -> Option:
    """To name a namespace, this one for example."""
    return Option(f'--namespace, for example --namespace {name}', f"load(..., namespace='{name}')")

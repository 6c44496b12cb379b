"""What a user got wrong, in the words of the interface: its arguments instead of the options of the commands."""

import re
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from tcp_muscle_ros.errors import BadInput

_Given = ParamSpec('_Given')
_Back = TypeVar('_Back')

_NAME, _VALUE = r'(\w+)', r'([^\s;,?()]*[^\s;,?().])'
# What a message says of the commands, and what of the functions, in this order.
_WORDS = tuple(
    (re.compile(rf'(?<![\w-])--{option}'), said)
    for option, said in (
        (rf'channel {_NAME}=TOPIC(?:\[?\.FIELD\]?)?', r"load(..., channels={'\1': '...'})"),
        (rf'channel {_NAME}={_VALUE} --channel {_NAME}={_VALUE}', r"load(..., channels={'\1': '\2', '\3': '\4'})"),
        (rf'channel {_NAME}={_VALUE}', r"load(..., channels={'\1': '\2'})"),
        (rf'channel {_NAME}', r"channels['\1']"),
        ('channel', 'channels'),
        (r'unit (\w+)=\.\.\.', r"load(..., units={'\1': '...'})"),
        (rf'unit {_NAME}={_VALUE}', r"load(..., units={'\1': '\2'})"),
        (rf'unit {_NAME}', r"units['\1']"),
        ('unit', 'units'),
        (r'namespace, for example --namespace (\S+)', r"load(..., namespace='\1')"),
        (r'namespace ([^\s:]+)', r"namespace='\1'"),
        (rf'separate {_NAME}', r"separate=('\1',)"),
        ('params', 'params'),
        ('force', 'force=True'),
        ('(?:output|figure)', 'path'),
        ('map', 'tcp_muscle import --map'),
    )
)


def in_python(function: Callable[_Given, _Back]) -> Callable[_Given, _Back]:
    """The function, whose BadInput speaks of arguments."""

    @wraps(function)
    def called(*given: _Given.args, **named: _Given.kwargs) -> _Back:
        try:
            return function(*given, **named)
        except BadInput as mistake:
            raise BadInput(as_arguments(str(mistake))) from None

    return called


def as_arguments(message: str) -> str:
    """A message of a command, with the arguments of the functions that do what its options do."""
    for option, argument in _WORDS:
        message = option.sub(argument, message)
    return message

"""What a user got wrong, in the words of the interface: its arguments instead of the options of the commands."""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from tcp_muscle_ros.errors import BadInput, Option

_Given = ParamSpec('_Given')
_Back = TypeVar('_Back')


def in_python(function: Callable[_Given, _Back]) -> Callable[_Given, _Back]:
    """The function, whose BadInput speaks of arguments."""

    @wraps(function)
    def called(*given: _Given.args, **named: _Given.kwargs) -> _Back:
        try:
            return function(*given, **named)
        except BadInput as mistake:
            said = ''.join(part.python if isinstance(part, Option) else str(part) for part in mistake.args)
            raise BadInput(said) from None

    return called

"""A controller that is to believe in the model that its twin has adopted: told by its parameter ``model_file``."""

from __future__ import annotations

from collections.abc import Callable

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future

_PATIENCE = 5  # looks, one a second, at an answer that does not come


class Believing:
    """The controller ``name`` (relative to the namespace of ``node``; '' none). ``say`` is told in words."""

    def __init__(self, node: Node, name: str, say: Callable[[str], None]) -> None:
        self._name, self._say = name, say
        self._client = node.create_client(SetParameters, f'{name}/set_parameters') if name else None
        self._told: str | None = ''  # the file that it has, or was refused; None: it is to be asked again
        self._asked: Future | None = None
        self._looks = 0
        self._ticks = 0

    def hear(self, array: DiagnosticArray) -> None:
        """Diagnostics: a controller that has done fewer ticks than before is another process, with its own parameters.

        One that is killed and begun again within the discovery lease is never seen to be gone.
        """
        if self._client is None:
            return
        full_name = self._client.service_name.rpartition('/')[0]
        for status in array.status:
            if f'{status.name}/'.startswith(f'{full_name}/'):  # below it are the muscles of one that has several
                said = (fact.value for fact in status.values if fact.key == 'ticks' and fact.value.isdecimal())
                ticks = int(next(said, self._ticks))
                before, self._ticks = self._ticks, ticks
                if ticks < before:
                    self._forget()

    def _forget(self) -> None:
        """What it was told is gone with it."""
        if self._asked is not None and self._client is not None:
            self._client.remove_pending_request(self._asked)
        self._asked, self._told = None, ''

    def believe(self, model_file: str) -> None:
        """It is to believe in this file's model ('': its own parameters); call now and then."""
        if self._client is not None and not self._client.service_is_ready():
            self._forget()
            return
        if self._client is None or (self._asked is None and model_file == self._told):
            return
        if self._asked is None:
            parameter = Parameter('model_file', value=model_file).to_parameter_msg()
            request = SetParameters.Request(parameters=[parameter])
            self._asked, self._told, self._looks = self._client.call_async(request), model_file, 0
            return
        self._looks += 1
        if self._asked.done():
            (result,) = self._asked.result().results
            what = f'assumes {self._told}' if self._told else 'assumes its own parameters again'
            self._say(f'{self._name} {what}' if result.successful else f'{self._name} refuses: {result.reason}')
            self._asked = None
        elif self._looks > _PATIENCE:
            self._client.remove_pending_request(self._asked)
            self._asked = self._told = None

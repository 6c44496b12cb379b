"""Who else commands the muscle that a node commands: by the graph of that node, and by the words of its drivers."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.nodes.topics import COMMANDED_BY, NAMELESS, NOBODY, REMEMBERED, Commanders, another

NAMED_WITHIN = 10.0  # s, in which a commander without a name gets one, or goes: a node of a moment ago, or this one
# s, after which a run of the same name that stands has not been refused: that takes 15 s, and more on a busy machine.
_STAYS = 60.0


class Rivals:
    """The other commanders of a muscle.

    ``topics``: of each kind of command, the one of kind ``mine`` being this node's; ``answers``: what the muscle's
    drivers said last, by their names.
    """

    def __init__(
        self, node: Node, topics: Mapping[str, str], mine: str, answers: Mapping[str, DiagnosticStatus]
    ) -> None:
        self._node, self._topics, self._mine, self._answers = node, topics, mine, answers
        self._me: str = node.get_fully_qualified_name()
        self._commanders = Commanders()
        self._nameless = False  # whether the last look found a commander without a name

    def told_of_me(self) -> bool:
        """Whether the muscle's driver has said who commands it since it has found this node, if it says that at all.

        It may have found another commander long before the graph of this node shows it.
        """
        return bool(self._answers) and all(self._me in names for names in self._named() if names)

    def _named(self) -> list[set[str]]:
        """The nodes that command the muscle by each of its drivers' words; empty where one does not say it."""
        said = ({value.key: value.value for value in status.values} for status in self._answers.values())
        return [set(filter(None, facts.get(COMMANDED_BY, '').split(', '))) for facts in said]

    def refuse(self, patience: float, pause: Callable[[], None], say: Callable[[str], None]) -> None:
        """BadInput where another node commands the muscle, by the graph of this node or by the driver's word.

        One of this node's name is given so long (s) to go: it may have been killed. A node that has just begun never
        sees those, and should be gone before one that plays takes it for one that stays (_STAYS).
        """

        def others() -> set[str]:
            said = set[str]().union(*self._named()) - {self._me, NOBODY}
            return self._others(0.0) | said

        begun, namesake = time.monotonic(), another(self._me)
        passing = {NAMELESS: NAMED_WITHIN, namesake: patience}
        if namesake in others():
            say(f'{namesake} commands this muscle too; waiting {patience:.0f} s for it to go')
        while (found := others()) and time.monotonic() - begun < min(passing.get(name, 0.0) for name in found):
            pause()
        if found:
            raise _refused(found)

    def refuse_latecomers(self) -> None:
        """BadInput where another node commands the muscle that the graph of this node showed late, asked now and then.

        One of this node's name once it stands for longer than one that was killed.
        """
        if found := self._others(REMEMBERED) - {NAMELESS}:
            raise _refused(found)

    def _others(self, standing: float) -> set[str]:
        """Other commanders of the muscle, by the graph of this node; those of its own name that stand so long (s)."""
        # Counting tells that there is nobody else; who it is takes a walk through the graph.
        if all(self._node.count_publishers(topic) <= (kind == self._mine) for kind, topic in self._topics.items()):
            return set()
        found = self._commanders.look(self._node, self._topics.values(), standing)
        return found - {self._me}

    def newcomer(self) -> str:
        """Another commander, '' where there is none; one without a name only if the last look found it so too."""
        others = self._others(_STAYS)
        passing, self._nameless = not self._nameless, NAMELESS in others
        return min(others - {NAMELESS} if passing else others, default='')


def _refused(others: set[str]) -> BadInput:
    return BadInput(f'{min(others)} commands this muscle too; stop it first: only one node may command a muscle')

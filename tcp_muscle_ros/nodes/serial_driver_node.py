"""A real muscle through a microcontroller on a serial line: current commands in, currents and measurements out."""

if __name__ == '__main__':  # python -m: before the rest is loaded, see entry.py
    from tcp_muscle_ros.process.quiet_end import end_quietly_when_asked

    end_quietly_when_asked()

import importlib.util
from collections.abc import Callable, Sequence

from rclpy.publisher import Publisher

from tcp_muscle_ros.errors import BadInput, install
from tcp_muscle_ros.nodes.driven_muscle import DrivenMuscle
from tcp_muscle_ros.nodes.lifetime import run
from tcp_muscle_ros.nodes.parameters import Settings
from tcp_muscle_ros.nodes.safe_node import SafeNode
from tcp_muscle_ros.nodes.ticks import SteadyTime, TimeBase
from tcp_muscle_ros.settings.operating import DRIVER


class SerialDriverNode(SafeNode[DrivenMuscle]):
    """Asks the board for a current once a tick. Its last words to the board are 0 A."""

    def __init__(self) -> None:
        if importlib.util.find_spec('serial') is None:
            raise BadInput(f'needs pyserial: {install("hardware")}, or sudo apt install python3-serial')
        super().__init__(DRIVER)
        for muscle in self.muscles:
            muscle.begin()

    def start(self, on_failure: Callable[[], None]) -> None:
        """Begin to tick. That a current can flow at once nobody should learn from a hot muscle."""
        enabled = [muscle for muscle in self.muscles if muscle.settings['start_enabled']]
        if enabled:
            limits = ', '.join(f'{muscle.said}{muscle.settings["current_limit_a"]:g} A' for muscle in enabled)
            self.get_logger().warning(
                f'starts enabled: what is commanded flows at once, up to {limits} (current_limit_a); '
                'with start_enabled:=false it waits for ~/enable'
            )
        super().start(on_failure)

    def check(self, settings: Settings) -> None:
        """Raise BadInput against values that make no limits, or no board to drive."""
        settings.limits(command_timeout=settings['command_timeout_s'])
        if settings['command_timeout_s'] == 0.0:
            raise BadInput("parameter 'command_timeout_s' is 0; expected more: a real muscle needs a watchdog")

    def make_muscle(self, name: str, settings: Settings) -> DrivenMuscle:
        """A muscle behind a board."""
        return DrivenMuscle(self, name, settings)

    def make_time_base(self) -> TimeBase:
        """The system's, whatever /clock says: the muscle is real."""
        return SteadyTime(self.get_clock())

    def work(self, stamp: int, dt: float, now: float, publish: bool) -> None:
        """Each muscle's current."""
        for muscle in self.muscles:
            muscle.work(stamp, dt, now)

    def stop(self) -> Sequence[Publisher]:
        """Stop ticking, publish 0 A, and say it to the boards last."""
        publishers = super().stop()
        for muscle in self.muscles:
            muscle.board.end()
        return publishers


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run(SerialDriverNode, DRIVER, args, models=False)


if __name__ == '__main__':
    raise SystemExit(main())

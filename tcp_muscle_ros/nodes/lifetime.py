"""The life of a node's process: it ends with the current off, with exit code 0 when asked to, and without a traceback.

rclpy's own signal handlers shut the context down first, and then nothing can be published any more: the last
current would stay on. So the handlers are ours, and the context is the last thing to go.
"""

import gc
import os
import re
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import rclpy
from rclpy.duration import Duration
from rclpy.exceptions import InvalidNamespaceException, InvalidNodeNameException
from rclpy.executors import SingleThreadedExecutor
from rclpy.logging import LoggingSeverity, get_logger, set_logger_level
from rclpy.publisher import Publisher
from rclpy.signals import SignalHandlerOptions

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle.ahead import compile_ahead, is_compiled
from tcp_muscle_ros.nodes.arguments import asks_for_help, check_arguments, idle_files, refuse_leftover, usage
from tcp_muscle_ros.process.compiling import SAID as COMPILING

_SHARE = 1e-4  # s: how long a callback may keep a tick that is due from running; Python's own 5 ms are five ticks
_STOP = (signal.SIGINT, signal.SIGTERM)
_ACKNOWLEDGED_WITHIN = Duration(seconds=1.0)


class _Asked(BaseException):
    """A signal during start-up."""


class Lively(Protocol):
    """What a node brings to be run here."""

    def start(self, on_failure: Callable[[], None]) -> None:
        """Begin to work."""

    def stop(self) -> Sequence[Publisher]:
        """Stop working and publish 0 A; returns the publishers whose last message must arrive."""

    @property
    def failure(self) -> BaseException | None:
        """What ended the work, if anything did."""


class Callbacks(threading.Thread):
    """The executor in a thread of its own, so that the main thread hears signals at once."""

    def __init__(self, node: Any, on_failure: Callable[[], None]) -> None:
        super().__init__(name='callbacks', daemon=True)
        self.failure: BaseException | None = None
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(node)
        self._on_failure = on_failure
        self._ended = False

    def run(self) -> None:
        """Callbacks, until ``end``."""
        try:
            while not self._ended:
                self._executor.spin_once()
        except BaseException as failure:  # without callbacks there is no commander and no service: end
            self.failure = failure
            self._on_failure()

    def end(self) -> None:
        """Return when the last callback has. (Shutting an executor down under its own spin makes that one fail.)"""
        self._ended = True
        if self.is_alive():  # a signal may come before it was started
            self._executor.create_task(lambda: None)
            self.join(1.0)
        self._executor.shutdown(timeout_sec=1.0)


def run(make: Callable[[], Any], name: str, args: Sequence[str] | None = None, *, models: bool = True) -> int:
    """Make the node, let it live until SIGINT or SIGTERM, end it with 0 A. Returns the exit code.

    ``models``: whether it computes with the model, which is compiled first where it is not yet.

    0 when asked to stop, 2 for bad input (one line on stderr), 1 for an error of ours.
    """
    life = _Life(make, name, list(sys.argv if args is None else args), models)
    try:
        return life.live()
    except _Asked:
        return 0
    except BadInput as problem:
        print(f'{name}: {problem}', file=sys.stderr)
        return 2
    except (InvalidNamespaceException, InvalidNodeNameException) as problem:
        print(f'{name}: {_one_line(problem)}', file=sys.stderr)
        return 2
    except Exception as problem:
        if life.ends_before_it_began:  # what a signal broke off fails in ways of its own
            return 0
        if life.node is None and type(problem).__module__.startswith('rclpy.'):  # its arguments: rclpy's own words
            said = _one_line(problem)
            unknown = re.fullmatch(r"\['(.*)'\]", said)  # rclpy says no more of it
            told = f"argument '{unknown[1]}' is not understood; see {name} --help" if unknown else said
            print(f'{name}: {told}', file=sys.stderr)
            return 2
        raise
    finally:
        life.end()


class _Life:
    """Of one node in its process; ``node`` is None until it is made."""

    def __init__(self, make: Callable[[], Any], name: str, arguments: list[str], models: bool) -> None:
        self._make, self._name, self._arguments, self._models = make, name, arguments, models
        self._asked = threading.Event()
        self._compiling = self._started = False
        self.node: Any = None
        self._callbacks: Callbacks | None = None
        for number in _STOP:
            signal.signal(number, self._on_signal)

    def _on_signal(self, *_: object) -> None:
        self._asked.set()
        if self._compiling:  # nothing is open; an exception in a callback of the compiler would break it off anyhow
            os._exit(0)
        if not self._started:  # each time: compiled code that calls back swallows it, and goes on
            raise _Asked

    @property
    def ends_before_it_began(self) -> bool:
        """Whether it was asked to stop during its start."""
        return self._asked.is_set() and not self._started

    def _stop_if_asked(self) -> None:
        if self._asked.is_set():
            raise _Asked

    def live(self) -> int:
        """Make the node and wait until it is asked to stop, or fails, or say how it is used; the exit code."""
        if asks_for_help(self._arguments):
            print(usage(self._name))
            return 0
        check_arguments(self._arguments, self._name)
        set_logger_level('rcl', LoggingSeverity.FATAL)  # it would say everything a second time
        refuse_leftover(self._arguments, self._name)
        rclpy.init(args=self._arguments, signal_handler_options=SignalHandlerOptions.NO)
        set_logger_level('rcl', LoggingSeverity.INFO)
        for sentence in idle_files(self._arguments, self._name):
            get_logger(self._name).warning(sentence)
        if self._models:
            self._compiling = True
            compile_model(self._name)
            self._compiling = False
        self._stop_if_asked()
        self.node = node = self._make()
        self._callbacks = callbacks = Callbacks(node, self._asked.set)
        sys.setswitchinterval(_SHARE)
        gc.freeze()  # what is here now stays: the collector need not walk it in the middle of a tick
        self._started = True
        callbacks.start()
        node.start(self._asked.set)
        self._asked.wait()
        failures = [failure for failure in (node.failure, callbacks.failure) if failure is not None]
        for failure in failures:
            sys.excepthook(type(failure), failure, failure.__traceback__)
        return 1 if failures else 0

    def end(self) -> None:
        """0 A, and no more callbacks."""
        for number in _STOP:
            signal.signal(number, signal.SIG_IGN)
        if self.node is not None:
            for publisher in self.node.stop():
                publisher.wait_for_all_acked(_ACKNOWLEDGED_WITHIN)
        if self._callbacks is not None:
            self._callbacks.end()
        if self.node is not None:
            self.node.destroy_node()
        rclpy.try_shutdown()


def compile_model(name: str) -> None:
    """Compile the model if this installation has not, and say so: nothing else happens for 15 to 40 s."""
    if not is_compiled():
        log = get_logger(name)
        log.info(COMPILING)
        compile_ahead(lambda step: log.info(f'compiling, {step}'))


def _one_line(problem: BaseException) -> str:
    return ' '.join(str(problem).split())

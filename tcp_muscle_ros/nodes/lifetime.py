"""The life of a node's process: it ends with the current off, with exit code 0 when asked to, and without a traceback.

rclpy's own signal handlers shut the context down first, and then nothing can be published any more: the last
current would stay on. So the handlers are ours, and the context is the last thing to go.
"""

import gc
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Protocol

import rclpy
import yaml
from rclpy.duration import Duration
from rclpy.exceptions import InvalidNamespaceException, InvalidNodeNameException
from rclpy.executors import SingleThreadedExecutor
from rclpy.logging import LoggingSeverity, set_logger_level
from rclpy.publisher import Publisher
from rclpy.signals import SignalHandlerOptions

from tcp_muscle_ros import parameter_file
from tcp_muscle_ros.errors import BadInput

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


def run(make: Callable[[], Any], name: str, args: Sequence[str] | None = None) -> int:
    """Make the node, let it live until SIGINT or SIGTERM, end it with 0 A. Returns the exit code.

    0 when asked to stop, 2 for bad input (one line on stderr), 1 for an error of ours.
    """
    arguments = list(sys.argv if args is None else args)
    asked = threading.Event()
    started = False

    def on_signal(*_: object) -> None:
        first = not asked.is_set()
        asked.set()
        if first and not started:
            raise _Asked

    for number in _STOP:
        signal.signal(number, on_signal)
    node = executor = spinner = None
    try:
        check_arguments(arguments, name)
        set_logger_level('rcl', LoggingSeverity.FATAL)  # it would say everything a second time
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
        set_logger_level('rcl', LoggingSeverity.INFO)
        node = make()
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        gc.freeze()  # what is here now stays: the collector need not walk it in the middle of a tick
        started = True
        spinner = threading.Thread(target=_spin, args=(executor, asked), name='executor', daemon=True)
        spinner.start()
        node.start(asked.set)
        asked.wait()
        return 0 if node.failure is None else 1
    except _Asked:
        return 0
    except BadInput as problem:
        print(f'{name}: {problem}', file=sys.stderr)
        return 2
    except (InvalidNamespaceException, InvalidNodeNameException) as problem:
        print(f'{name}: {_one_line(problem)}', file=sys.stderr)
        return 2
    except Exception as problem:
        if node is None and type(problem).__module__.startswith('rclpy.'):  # its arguments: rclpy's own words
            print(f'{name}: {_one_line(problem)}', file=sys.stderr)
            return 2
        raise
    finally:
        for number in _STOP:
            signal.signal(number, signal.SIG_IGN)
        if node is not None:
            for publisher in node.stop():
                publisher.wait_for_all_acked(_ACKNOWLEDGED_WITHIN)
            if node.failure is not None:
                sys.excepthook(type(node.failure), node.failure, node.failure.__traceback__)
        if executor is not None:
            executor.shutdown(timeout_sec=1.0)
        if spinner is not None:
            spinner.join(1.0)
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()


def _spin(executor: SingleThreadedExecutor, asked: threading.Event) -> None:
    try:
        executor.spin()
    finally:
        asked.set()  # without callbacks there is no commander and no service: end


def _one_line(problem: BaseException) -> str:
    return ' '.join(str(problem).split())


def check_arguments(arguments: Sequence[str], name: str) -> None:
    """Refuse what rcl would read with fewer words, or read wrongly.

    Given a whole number in one place and a decimal in another, rcl takes the whole one whatever the order: a current
    limit of 0.1 A after a file that says 1 would be 1 A.

    Raises:
        BadInput: a ``--params-file`` that is missing, is no YAML or holds no parameters; a parameter of node ``name``
            given both ways.
    """
    first: dict[str, tuple[type, str]] = {}
    for flag, argument in pairwise(arguments):
        if flag == '--params-file':
            given = parameter_file.values_for(Path(argument), name)
            source = argument
        elif flag in ('-p', '--param'):
            given = _on_the_command_line(argument, name)
            source = f'-p {argument}'
        else:
            continue
        for key, value in given.items():
            if isinstance(value, int | float) and not isinstance(value, bool):
                kind, before = first.setdefault(key, (type(value), source))
                if kind is not type(value):
                    raise BadInput(
                        f"parameter '{key}' is a whole number and a decimal one ({before}, {source}), of which ROS "
                        f'would take the whole one: write it with a point in both'
                    )


def _on_the_command_line(argument: str, name: str) -> dict[str, object]:
    key, _, text = argument.partition(':=')
    node, _, parameter = key.rpartition(':')
    if node not in ('', name):
        return {}
    try:
        return {parameter: parameter_file.as_ros_reads(yaml.safe_load(text))}
    except yaml.YAMLError:
        return {}  # rcl says so

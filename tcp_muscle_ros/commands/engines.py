"""Where the runs of a campaign are done: in processes of this machine, or on the workers of a dask scheduler.

Both are generators of outcomes in the order in which they come, and of None now and then while none comes.
Leaving them early (Ctrl-C) stops what is running.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import socket
import time
import uuid
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import TYPE_CHECKING

from tcp_muscle_ros.commands.one_run import Outcome, Task, is_done, work
from tcp_muscle_ros.errors import BadInput, install
from tcp_muscle_ros.process.threads import LINEAR_ALGEBRA

if TYPE_CHECKING:
    import distributed

_ONE_THREAD = (*LINEAR_ALGEBRA, 'NUMBA_NUM_THREADS')
_TICK, _GLANCE = 1.0, 0.1  # s
_PATIENCE = 10.0  # s, until a scheduler must have answered


def local(tasks: Sequence[Task], jobs: int) -> Generator[Outcome | None, None, None]:
    """Every task in one of ``jobs`` new processes. One that dies costs the run that it was at, and is replaced."""
    waiting = list(reversed(tasks))
    busy: dict[Connection, tuple[SpawnProcess, Task]] = {}
    idle: list[tuple[Connection, SpawnProcess]] = []
    try:
        while waiting or busy:
            while waiting and len(busy) < jobs:
                pipe, process = idle.pop() if idle else _started()
                if not process.is_alive():  # killed while it had nothing to do
                    continue
                busy[pipe] = (process, waiting.pop())
                with suppress(BrokenPipeError):  # it died just now: its end is heard below, as any other's
                    pipe.send(busy[pipe][1])
            told = wait(list(busy), timeout=_TICK)
            if not told:
                yield None
            for pipe in [each for each in busy if each in told]:
                process, task = busy[pipe]
                try:
                    outcome = pipe.recv()
                    idle.append((pipe, process))
                except (EOFError, ConnectionResetError):
                    process.join()
                    outcome = Outcome(task.name, f'its process died ({_how(process.exitcode)})')
                del busy[pipe]  # not before: Ctrl-C may come at any line, and must find every process
                yield outcome
    finally:
        for process in [p for _, p in idle] + [p for p, _ in busy.values()]:
            process.terminate()
            process.join()


@contextmanager
def _deaf() -> Iterator[None]:
    """What starts in it does not hear Ctrl-C, where a system has signals that can be held back."""
    if not hasattr(signal, 'pthread_sigmask'):
        yield
        return
    heard = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, heard)


def _started() -> tuple[Connection, SpawnProcess]:
    """A process that works on what it is sent. It never hears Ctrl-C, which is its parent's to answer."""
    context = multiprocessing.get_context('spawn')
    mine, its = context.Pipe()
    process = context.Process(target=_serve, args=(its,), daemon=True)
    with _deaf():
        process.start()
    its.close()
    return mine, process


def _serve(pipe: Connection) -> None:
    os.environ.update(dict.fromkeys(_ONE_THREAD, '1'))  # before numpy is loaded
    with suppress(EOFError, ConnectionError):  # the parent is gone, perhaps before it has read the last outcome
        while True:
            pipe.send(work(pipe.recv()))


def _how(exitcode: int | None) -> str:
    if exitcode is None or exitcode >= 0:
        return f'exit code {exitcode}'
    name = signal.Signals(-exitcode).name
    return f'{name}; out of memory?' if name == 'SIGKILL' else name


def cluster(tasks: Sequence[Task], address: str) -> Generator[Outcome | None, None, None]:
    """Every task on a worker of the dask scheduler at ``address``, which sees the same files under the same names.

    What a worker was at when it was lost, the scheduler gives to another.

    Raises:
        BadInput: distributed is not installed, or nothing answers at the address.
    """
    try:
        from distributed import Client
    except ModuleNotFoundError:
        raise BadInput(f'--scheduler needs distributed: {install("cluster")}') from None
    _refuse_silence(address)
    with _no_logging(), _connected(Client, address) as client:
        futures = {client.submit(work, task, key=f'{task.name}-{uuid.uuid4().hex}', pure=False): task for task in tasks}
        try:
            while futures:
                ended = [future for future in futures if future.done()]
                if not ended:
                    time.sleep(_GLANCE)
                    yield None
                for future in ended:
                    yield _outcome(future, futures.pop(future))
        finally:
            with suppress(OSError):  # the scheduler may be gone
                client.cancel(list(futures))


@contextmanager
def _no_logging() -> Iterator[None]:
    """distributed logs every connection that it loses, with a traceback; what is lost is said in the summary."""
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(logging.NOTSET)


@contextmanager
def _connected(make: type[distributed.Client], address: str) -> Iterator[distributed.Client]:
    try:
        client = make(f'tcp://{address}', timeout=_PATIENCE)
    except OSError as error:
        why = ' '.join(str(error).split())
        raise BadInput(f'--scheduler {address}: what answers there is no dask scheduler ({why})') from None
    try:
        yield client
    finally:
        with suppress(OSError):
            client.close()


def _refuse_silence(address: str) -> None:
    """BadInput unless somebody listens at HOST:PORT."""
    host, colon, port = address.rpartition(':')
    if not (host and colon and port.isdigit() and 0 < int(port) < 1 << 16) or '/' in host:
        raise BadInput(f'--scheduler {address}: expected HOST:PORT, as in localhost:8786')
    try:
        socket.create_connection((host, int(port)), timeout=_PATIENCE).close()
    except OSError as error:
        raise BadInput(f'--scheduler {address}: nobody answers there ({error.strerror or error})') from None


def _outcome(future: distributed.Future, task: Task) -> Outcome:
    """What became of a task whose future has ended; its report may be there although nobody could say so."""
    with suppress(OSError):
        if future.status == 'finished':
            return future.result()
        if future.status == 'error':
            error = future.exception()
            return Outcome(task.name, ' '.join(f'its worker failed: {type(error).__name__}: {error}'.split()))
    return Outcome(task.name, None if is_done(task) else 'the scheduler was lost before this run was done')

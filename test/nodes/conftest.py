"""A bench for tests on real processes: starts nodes, talks to them, and waits for what they do, never for a time."""

import fcntl
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import ExitStack, contextmanager
from itertools import dropwhile, pairwise

import domains
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

import rclpy
from rclpy.context import Context
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import Float64

from tcp_muscle_ros.nodes.polled import Polled
from tcp_muscle_ros.nodes.topics import LEASE

STARTING = 120.0  # s; a first start compiles the model, and the machine may be busy
PATIENCE = 90.0  # s, for what a running node does: half a minute where nobody else computes, three times that else
LOOKING = 0.002  # s, from one look at what came to the next
ASKING = 10.0  # s, after which a service is asked again
ENVIRONMENT = {
    **os.environ,
    'ROS_PYTHON_CHECK_FIELDS': '1',
    'PYTHONPATH': os.pathsep.join(filter(None, sys.path)),
    'PYTHONUNBUFFERED': '1',
}


class Program:
    """A process of one of the package's nodes; ``command`` is what follows python."""

    def __init__(self, command, errors, domain, stdin=None):
        self.errors_path = errors
        with open(errors, 'w') as sink:
            self.process = subprocess.Popen(
                [sys.executable, *command],
                env={**ENVIRONMENT, 'ROS_DOMAIN_ID': str(domain)},
                stderr=sink,
                stdout=sink,
                stdin=stdin,
            )

    def said(self):
        return self.errors_path.read_text()

    def kill(self):
        """kill -9"""
        self.process.kill()
        self.process.wait()

    def end(self, *signals):
        """Send the signals, wait, return the exit code."""
        for number in signals:
            self.process.send_signal(number)
        return self.process.wait(20)


_FAREWELL = 0.5  # s
_FAILED = pytest.StashKey()  # whether a test has failed
_LEFT = []  # contexts and nodes whose module is over: kept, so that nothing destroys them


class Heard(list):
    """The messages of one topic, each with the (steady) time at which it came."""

    def take(self):
        """What came since the last look."""
        subscription = self.subscription
        with subscription.handle:
            while came := subscription.handle.take_message(subscription.msg_type, False):
                self.append((time.monotonic(), came[0]))

    @property
    def values(self):
        return [message.data for _, message in self]

    @property
    def last(self):
        return self[-1][1]

    def since(self, moment):
        return [message for came, message in self[:] if came >= moment]

    def flowing_for(self, moment, rate=100.0):
        """For how long after the moment (s) a current was still decided, by the node's own ticks.

        Ticks and not the wall's time: where the whole machine stands still, the node does too.
        """
        return sum(message.data > 0.0 for message in self.since(moment)) / rate

    def pause(self, moment):
        """The longest silence (s) around the moment and since: what the machine may have held up, messages or us."""
        came = [came for came, _ in self[:]]
        return max((b - a for a, b in pairwise(came) if b > moment - 1.0), default=0.0)

    def from_zero(self, moment):
        """What came since the moment, from the first zero on: before it there may be what was under way."""
        return [message.data for message in dropwhile(lambda message: message.data != 0.0, self.since(moment))]


class Bench:
    def __init__(self, folder):
        self.folder, self.domain = folder, domains.take()
        self.context = Context()
        rclpy.init(context=self.context, domain_id=self.domain, signal_handler_options=SignalHandlerOptions.NO)
        self.node = rclpy.create_node('bench', context=self.context, start_parameter_services=False)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.thread = threading.Thread(target=self.executor.spin, daemon=True)
        self.thread.start()
        # It looks at its topics itself: an executor looks at everything whenever one message comes, which took as much
        # of the machine as the nodes that are tested; on a busy one the bench fell a minute behind what it judges.
        self.polled, self.topics, self.guard, self.over = Polled(), [], threading.Lock(), threading.Event()
        self.looking = threading.Thread(target=self._look, daemon=True)
        self.looking.start()
        self.programs = []

    def _look(self):
        while not self.over.wait(LOOKING):
            with self.guard:
                for heard in self.topics:
                    heard.take()

    def close(self):
        self.kill(self.programs)
        self.over.set()
        self.looking.join(60.0)
        self.executor.shutdown()
        self.thread.join(60.0)
        # A participant that is taken down while it still learns that others have left has died in the middleware.
        time.sleep(_FAREWELL)
        # In a thread of its own: the middleware has waited for itself here, for good.
        leaving = threading.Thread(target=self._leave, daemon=True)
        leaving.start()
        leaving.join(60.0)

    def _leave(self):
        """Take down all that others could hear or call. The node itself goes with the process: its destruction has
        ended in native code with a segmentation fault, once in some hundred times, and the whole run with it."""
        _LEFT.append((self.context, self.node))
        if self.thread.is_alive():  # what it still waits on would be pulled from under it
            return
        node = self.node
        for entities, destroy in (
            (node.publishers, node.destroy_publisher),
            (node.subscriptions, node.destroy_subscription),
            (node.clients, node.destroy_client),
            (node.services, node.destroy_service),
            (node.timers, node.destroy_timer),
        ):
            for entity in list(entities):
                destroy(entity)

    def kill(self, programs):
        """Those that still run; each of them takes its share of the machine from the tests that follow."""
        for program in programs:
            if program.process.poll() is None:
                program.kill()

    def start(self, name, namespace, *more, **parameters):
        """A node of the package."""
        arguments = [*more, '-r', f'__ns:=/{namespace}']
        for key, value in parameters.items():
            text = str(value).lower() if isinstance(value, bool) else str(value)
            arguments += ['-p', f'{key}:={text}']
        return self.run(['-m', f'tcp_muscle_ros.nodes.{name}', '--ros-args', *arguments], f'{namespace}_{name}')

    def start_uncompiled(self, name, namespace, cache, *more):
        """A node for which nothing is compiled yet: its cache is an empty folder."""
        begin = (
            f"import os, sys; os.environ.update(XDG_CACHE_HOME='{cache}', TMPDIR='{cache}')\n"
            f'from tcp_muscle_ros.nodes.{name} import main\nsys.exit(main())'
        )
        return self.run(['-c', begin, '--ros-args', '-r', f'__ns:=/{namespace}', *more], namespace)

    def run(self, command, label, stdin=None):
        """A Python process."""
        errors = self.folder / f'{label.replace("/", "_")}_{len(self.programs)}.txt'
        program = Program(command, errors, self.domain, stdin)
        self.programs.append(program)
        return program

    def listen(self, topic, kind=Float64, depth=5000):
        heard = Heard()
        heard.subscription = self.node.create_subscription(
            kind,
            topic,
            heard.append,
            QoSProfile(depth=depth),
            callback_group=self.polled,
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
        )
        with self.guard:
            self.topics.append(heard)
        return heard

    def forget(self, *topics):
        """Stop listening: every subscription costs.

        In the executor's own thread, from under which what it is about to wait on would be pulled else.
        """

        def forget():
            with self.guard:
                self.topics = [heard for heard in self.topics if not any(heard is one for one in topics)]
            for heard in topics:
                self.node.destroy_subscription(heard.subscription)

        self.until(self.executor.create_task(forget).done, 'the bench itself hangs')

    def speaker(self, topic, kind=Float64):
        """A publisher that knows of somebody who hears it.

        Who hears may know of it only later. A reliable subscription then gets what was published meanwhile all the
        same; a best-effort one, of a measurement, does not: see ``insist``.
        """
        publisher = self.node.create_publisher(kind, topic, QoSProfile(depth=1))
        self.until(publisher.get_subscription_count, f'nobody listens to {topic}', STARTING)
        return publisher

    def until(self, condition, otherwise, patience=PATIENCE):
        """Wait for the condition, looked at every few milliseconds; returns when it held."""
        deadline = time.monotonic() + patience
        while not condition():
            for program in [one for one in self.programs if one.process.poll() not in (None, 0, -signal.SIGKILL)]:
                self.programs.remove(program)  # one test fails for it, not all that follow
                raise AssertionError(f'{otherwise}: a node ended:\n{program.said()}')
            assert time.monotonic() < deadline, otherwise
            time.sleep(0.005)
        return time.monotonic()

    def insist(self, publisher, message, condition, otherwise):
        """Publish until the condition holds, what may be lost."""
        with self.repeating(publisher, message):
            return self.until(condition, otherwise)

    @contextmanager
    def repeating(self, publisher, value, rate=50.0):
        """Publish the value, a number or a message, over and over, as a living commander does; yields a function that
        changes it."""
        held, stop = [value], threading.Event()

        def publish():
            publisher.publish(Float64(data=held[0]) if isinstance(held[0], float) else held[0])

        def repeat():
            while not stop.wait(1.0 / rate):
                publish()

        def change(new):
            held[0] = new

        publish()
        thread = threading.Thread(target=repeat, daemon=True)
        thread.start()
        try:
            yield change
        finally:
            stop.set()
            thread.join()

    def call(self, kind, service, **fields):
        """What the service answers; asked again where nothing came.

        A request is lost where the node of the same name that a test before killed is still believed to be there, an
        answer where the node does not know yet who asked.
        """
        client = self.node.create_client(kind, service)
        assert client.wait_for_service(STARTING), service
        asked, again = [client.call_async(kind.Request(**fields))], time.monotonic() + ASKING

        def answered():
            nonlocal again
            if time.monotonic() > again:
                again += ASKING
                asked.append(client.call_async(kind.Request(**fields)))
            return any(future.done() for future in asked)

        self.until(answered, f'{service} does not answer')
        return next(future.result() for future in asked if future.done())


@contextmanager
def turn(folder):
    """One of as many turns as there are cores: what keeps to the clock starts processes that compute."""
    with ExitStack() as opened:
        places = [opened.enter_context(open(folder / f'turn_{k}', 'w')) for k in range(os.cpu_count() or 1)]
        while not any(map(free, places)):
            time.sleep(0.2)
        yield


def free(place):
    try:
        fcntl.flock(place, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


@pytest.fixture(scope='module')
def bench(tmp_path_factory):
    with turn(tmp_path_factory.getbasetemp().parent):
        made = Bench(tmp_path_factory.mktemp('nodes'))
        yield made
        made.close()


@pytest.fixture(scope='module')
def no_board():
    """A serial port that opens, with nothing at its far end. Not /dev/ptmx itself: a driver locks what it opens, and
    two tests at once would have one."""
    far, near = os.openpty()
    yield os.ttyname(near)
    os.close(near)
    os.close(far)


@pytest.fixture(autouse=True)
def nothing_left_running(request):
    """What a test starts ends with it, and what its module's fixtures start with the module: each takes its share of
    the machine."""
    bench = request.getfixturevalue('bench') if 'bench' in request.fixturenames else None
    before = list(bench.programs) if bench else []
    yield
    if bench:
        started = [program for program in bench.programs if program not in before]
        bench.kill(started)
        if started and request.node.stash.get(_FAILED, False):
            time.sleep(LEASE)  # in which they are still believed to be there, and the next attempt waits for them


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    item.stash[_FAILED] = item.stash.get(_FAILED, False) or report.failed
    return report


def pytest_collection_modifyitems(config, items):
    """Once more for real processes in real time, shown as a rerun: a shared machine may stand still for a second.

    A fault of ours fails twice. The plugin comes with colcon; without it nothing is run again.
    """
    if config.pluginmanager.hasplugin('rerunfailures'):
        for item in items:
            if 'test/nodes/' in item.path.as_posix():
                item.add_marker(pytest.mark.flaky(reruns=1))

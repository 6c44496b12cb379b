"""serial_driver_node against a board on a pseudo-terminal that does what boards do: in the end, 0 A at the muscle."""

import os
import signal
import subprocess
import sys
import threading
import time
import tty
from contextlib import contextmanager, suppress

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')
pytest.importorskip('serial', reason='needs pyserial, the extra hardware')

from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState, Temperature
from std_srvs.srv import Trigger

from tcp_muscle_ros.control.safety import Limits, Safety
from tcp_muscle_ros.nodes.board import Board
from tcp_muscle_ros.nodes.driven_muscle import DrivenMuscle
from tcp_muscle_ros.nodes.serial_line import Lines, checksum, command, framed, sample

WATCHDOG = 0.25  # s, the board's own
NO_ANSWER = 'no answer from the board to what was asked in the last 0.2 s'


def test_it_needs_no_model_and_compiles_none(bench, no_board, tmp_path):
    program = bench.start_uncompiled('serial_driver_node', 'uncompiled', tmp_path, '-p', f'port:={no_board}')
    bench.until(lambda: 'no answer from the board' in program.said(), 'it does not start', 120.0)
    assert 'compiling' not in program.said()
    assert program.end(signal.SIGINT) == 0


@pytest.mark.parametrize('enabled', [True, False])
def test_one_that_starts_enabled_says_so_once_with_its_limit(bench, no_board, enabled):
    asked = {} if enabled else {'start_enabled': False}
    program = bench.start('serial_driver_node', 'careful', port=no_board, current_limit_a=0.1, **asked)
    statuses = bench.listen('/diagnostics', DiagnosticArray)
    bench.until(
        lambda: any(status.name == '/careful/serial_driver_node' for _, array in statuses for status in array.status),
        'it does not start',
        120.0,
    )
    bench.forget(statuses)
    assert program.end(signal.SIGINT) == 0
    told = [line for line in program.said().splitlines() if 'starts enabled' in line]
    assert len(told) == enabled
    assert all('WARN' in line and 'up to 0.1 A' in line for line in told)


class SimulatedBoard:
    """The firmware of docs/hardware.md on the far end of a pseudo-terminal, and the ways in which it can go wrong."""

    def __init__(self, link):
        self._link = link
        self.current = 0.0  # A, what flows
        self.last = 0  # number of the last command
        self.told = []  # A, every command that it heard
        self.emptied = 0.0  # when the line last had nothing more to be read
        self.delay = 0.0  # s, by which answers are late
        self.garbage = self.silent = False
        self.extra = 0.0  # A, more than was asked for
        self._heard_at = 0.0
        self._stop = threading.Event()
        self._cable = threading.Lock()  # whoever pulls or plugs it waits until the board has no hand on it
        self.connect()
        self.start_again()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def connect(self):
        """A cable."""
        with self._cable:
            self._fd, slave = os.openpty()
            tty.setraw(self._fd)
            self._link.unlink(missing_ok=True)
            self._link.symlink_to(os.ttyname(slave))
            os.close(slave)
            os.set_blocking(self._fd, False)
            self._lines, self._waiting = Lines(), []

    def cut(self):
        """The cable is pulled; pulled again, nothing."""
        with self._cable:
            if self._fd is not None:
                os.close(self._fd)
                self._fd = None

    def start_again(self):
        """A reset: 0 A, uptime from 0."""
        self._begun, self.current, self.last = time.monotonic(), 0.0, 0

    def end(self):
        self._stop.set()
        self._thread.join()
        self.cut()

    def _run(self):
        while not self._stop.wait(0.002):
            now = time.monotonic()
            with suppress(OSError), self._cable:  # nobody may be at the other end
                self._exchange(now)
            if now - self._heard_at > WATCHDOG:
                self.current = 0.0

    def _exchange(self, now):
        if self._fd is None:
            return
        try:
            received = os.read(self._fd, 4096)
        except BlockingIOError:
            received, self.emptied = b'', now
        except OSError:  # the other end is closed, and all that it sent was read
            self.emptied = now
            raise
        for line in self._lines.feed(received):
            body, _, digits = line.rpartition(b'*')
            if int(digits, 16) == checksum(body):
                _, number, microampere = body.decode().split(',')
                self.last, self.current, self._heard_at = int(number), int(microampere) / 1e6, now
                self.told.append(self.current)
                self._waiting.append((now + self.delay, self._answer(now)))
        while self._waiting and self._waiting[0][0] <= now:
            _, line = self._waiting.pop(0)
            if self.garbage:
                line = line.replace(b',', b'.', 1)
            if not self.silent:
                os.write(self._fd, line)

    def _answer(self, now):
        uptime = round(1e3 * (now - self._begun))
        current = self.current + self.extra
        return framed(f'S,{self.last},{uptime},{round(1e6 * current)},{round(14e6 * current)},3000000,310000')


def test_a_line_goes_there_and_back_and_a_broken_one_is_none():
    line = framed('S,7,1500,100000,1400000,3000000,310000')
    heard = sample(line)
    assert (heard.command, heard.uptime, heard.current, heard.voltage) == (7, 1.5, 0.1, 1.4)
    assert (heard.displacement, heard.temperature) == (0.003, 310.0)
    assert sample(framed('S,7,1500,0,0,,')).temperature is None
    assert checksum(b'123456789') == 0x29B1  # the CRC's published check value
    for place in range(len(line) - 1):
        broken = line[:place] + bytes([line[place] ^ 1]) + line[place + 1 :]
        assert sample(broken) is None, broken
    for wrong in (b'', b'*', b'S,1*', framed('S,1,2'), framed('C,1,2,3,4,5,6'), framed('S,a,2,3,4,5,6'), b'\xff*0000'):
        assert sample(wrong) is None
    assert command(3, 0.25).startswith(b'C,3,250000*')


def test_lines_come_in_pieces_and_noise_without_end_is_thrown_away():
    lines = Lines()
    assert lines.feed(b'S,1') == [] and lines.feed(b',2*\nS') == [b'S,1,2*']
    for _ in range(100):
        lines.feed(b'x' * 100)
    assert lines.feed(b'\nwhole\n')[-1] == b'whole'


class SlowThermometer:
    """A port to a board that answers each of 100 commands a second, one answer of ``every`` with a temperature."""

    def __init__(self, every):
        self.every, self.answers, self.kelvin = every, 0, 383.15
        self._said = b''

    @property
    def in_waiting(self):
        return len(self._said)

    def read(self, size):
        said, self._said = self._said, b''
        return said

    def write(self, line):
        _, number, microampere = line.split(b'*')[0].decode().split(',')
        measured = '' if self.answers % self.every else f'{round(1e3 * self.kelvin)}'
        self.answers += 1
        self._said += framed(f'S,{number},{10 * self.answers},{microampere},{14 * int(microampere)},,{measured}')


@pytest.mark.parametrize(('every', 'ticks_a_look'), [(1, 1), (100, 1), (100, 3)])
def test_a_thermometer_that_is_slower_than_the_answers_derates_like_a_fast_one(every, ticks_a_look):
    limits = Limits(0.27, 0.0, 0.5, 373.15, 388.15, 1.0)
    driven = DrivenMuscle.__new__(DrivenMuscle)  # without a node: what it does in a tick
    driven.settings, driven._publish = {'min_sense_current_a': 0.0}, lambda *_: None
    driven.board, driven.safety = Board(lambda: port, 0.2), Safety(limits)
    port = SlowThermometer(every)
    driven.board.begin()

    def flows(ticks):
        for k in ticks:
            driven.safety.command(0.27, 0.01 * k)
            driven.work(k, 0.01, 0.01 * k)
            for _ in range(ticks_a_look - 1):  # answers that are read together: an older one has the temperature
                port.write(b'C,%d,%d*' % (driven.board._number, round(1e6 * driven.safety.current)))
            yield driven.safety.current

    begins = 10
    assert list(flows(range(1000)))[begins:] == pytest.approx([limits.current_at(383.15)] * (1000 - begins))
    port.every = 10**9  # it hangs, or has come off
    later = list(flows(range(1000, 1500)))
    assert later[150] == pytest.approx(limits.current_at(383.15)) and later[-1] == 0.27


@pytest.fixture(scope='module')
def rig(bench):
    class Rig:
        board = SimulatedBoard(bench.folder / 'board')
        program = bench.start('serial_driver_node', 'rig', port=bench.folder / 'board')
        current = bench.listen('/rig/current')
        temperature = bench.listen('/rig/temperature', Temperature)
        resistance = bench.listen('/rig/resistance')
        joints = bench.listen('/rig/joint_states', JointState)
        diagnostics = bench.listen('/diagnostics', DiagnosticArray)
        command = bench.speaker('/rig/current_command')

        def said(self):
            return next((s.message for _, a in reversed(self.diagnostics) for s in a.status if 'rig' in s.name), '')

        def stops(self, why):
            bench.until(lambda: self.board.current == 0.0, f'{why}: the current stays on', 5.0)
            bench.until(lambda: why in self.said(), f'not said: {why}, but {self.said()}', 5.0)

        def is_told_0_for_a_second(self):
            before = len(self.board.told)
            bench.until(lambda: len(self.board.told) >= before + 100, 'the board is told nothing', 10.0)
            assert set(self.board.told[before:]) == {0.0}

        @contextmanager
        def at_fault(self, fault, value, why):
            """The board with a fault, which stops the current; it flows again when the fault is gone."""
            with bench.repeating(self.command, 0.1):
                self.flows()
                usual = getattr(self.board, fault)
                setattr(self.board, fault, value)
                self.stops(why)
                yield
                setattr(self.board, fault, usual)
                self.flows()

        def flows(self):
            bench.until(lambda: self.board.current == 0.1, 'no current flows', 10.0)

    made = Rig()
    yield made
    made.board.end()


@pytest.mark.processes
def test_what_is_commanded_flows_and_what_is_measured_is_said(bench, rig):
    with bench.repeating(rig.command, 0.1):
        rig.flows()
        bench.until(lambda: rig.current and rig.current.last.data == 0.1, 'the current is not said')
        bench.until(lambda: rig.resistance and rig.temperature and rig.joints, 'not measured')
        assert rig.resistance.last.data == pytest.approx(14.0)
        assert rig.temperature.last.temperature == pytest.approx(36.85)
        assert rig.joints.last.position[0] == pytest.approx(0.003)
        assert rig.temperature.last.header.frame_id == rig.joints.last.header.frame_id == 'rig_moving_end'
    rig.stops('no command for 0.5 s')


@pytest.mark.processes
def test_garbage_stops_the_current_and_it_comes_back(rig):
    with rig.at_fault('garbage', True, NO_ANSWER):
        pass


@pytest.mark.processes
def test_a_board_that_hears_and_says_nothing_is_told_0_and_the_current_comes_back(rig):
    with rig.at_fault('silent', True, NO_ANSWER):
        rig.is_told_0_for_a_second()


@pytest.mark.processes
def test_late_answers_stop_the_current_and_it_comes_back(rig):
    with rig.at_fault('delay', 0.6, 'no answer from the board'):
        pass


@pytest.mark.processes
def test_a_cut_cable_stops_the_current_and_a_new_one_is_found(bench, rig):
    with bench.repeating(rig.command, 0.1):
        rig.flows()
        rig.board.cut()
        rig.stops('the serial port is gone')
        rig.board.connect()
        rig.flows()


@pytest.mark.processes
@pytest.mark.parametrize('fault', ['reset', 'excess', 'reversed'])
def test_what_must_be_looked_at_first_latches(bench, rig, fault):
    with bench.repeating(rig.command, 0.1) as change:
        rig.flows()
        if fault == 'reset':
            rig.board.start_again()
            rig.stops('the board started again in the middle of its work')
        else:
            rig.board.extra, gives = (0.1, '0.200') if fault == 'excess' else (-0.3, '-0.200')
            rig.stops(f'the board gives {gives} A where 0.100 A was asked for')
            rig.board.extra = 0.0
        rig.is_told_0_for_a_second()  # while 0.1 A are asked for
        change(0.0)
        bench.until(
            lambda: bench.call(Trigger, '/rig/serial_driver_node/clear_fault').success, 'cannot be cleared', 5.0
        )
        change(0.1)
        rig.flows()


@pytest.mark.processes
def test_the_last_word_to_the_board_is_0_and_after_kill_9_its_own_watchdog_stops_it(bench, rig):
    with bench.repeating(rig.command, 0.1):
        rig.flows()
        rig.program.kill()
        killed = time.monotonic()
        bench.until(lambda: rig.board.current == 0.0, 'the board heats on', 5.0)
        assert time.monotonic() - killed < WATCHDOG + 0.3
        assert rig.board.told[-1] == 0.1, 'nobody told it: that was its own watchdog'
        for stop in (signal.SIGINT, signal.SIGTERM):
            again = bench.start('serial_driver_node', 'rig', port=bench.folder / 'board')
            rig.flows()
            assert again.end(stop) == 0, again.said()
            ended = time.monotonic()
            bench.until(lambda ended=ended: rig.board.emptied > ended, 'the board reads on', 5.0)
            assert rig.board.told[-1] == 0.0, f'the last word before the end by {stop.name} is a current'
            assert 'Traceback' not in again.said()


@pytest.mark.processes
def test_a_port_that_is_not_there_at_the_start_is_one_line_and_2():
    command = ['-m', 'tcp_muscle_ros.nodes.serial_driver_node', '--ros-args', '-p', 'port:=/dev/no_such_port']
    done = subprocess.run([sys.executable, *command], capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    said = "parameter 'port' is '/dev/no_such_port', which cannot be opened: No such file or directory"
    heard = [line for line in done.stderr.splitlines() if not line.startswith('[INFO]')]
    assert heard == [f'serial_driver_node: {said}']

"""kill -9 at random instants of muscle, controller, twin, recorder and investigation, and what must hold afterwards.

After the death of a commander the muscle applies 0 A within the watchdog time; after the muscle's the controller
commands 0 A; the twin's changes nothing; a recorder loses at most its last second; an investigation goes on. What the
process that must act waited for a core meanwhile is allowed beside that.
Usage: scripts/kills.py [--kills 200] [--output docs/kills.md]; exit code 1 where something did not hold.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from datetime import date
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1] / 'test'))
from domains import ALONE

# Before the middleware is loaded; and by SIGABRT a process says where it stands.
os.environ.update(ALONE, PYTHONFAULTHANDLER='1')

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from kills_seen import Heard, Waits
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.bag import read_bag

WATCHDOG = 0.5  # s, of sim_node
FEEDBACK = 0.2  # s, after which the controller takes a silent muscle for lost
MARGIN = 0.1  # s: the last command's age, two ticks, and what was under way
LOST = 1.0  # s, that a recorder may lose
WATCHED = 2.0  # s before a recorder is killed, in which its waits for a core count
PATIENCE = 120.0  # s
STARTING = 300.0  # s
LOOK = 2.0  # s, after which a current must still flow
PAUSE = 10.0  # s: cooling to the setpoint takes about two
RATE = 50.0  # Hz of the muscles and the controller: half of the usual takes half as much of the machine
PROTOCOL = """
rate_hz: 50
input: current
segments:
  - {duration_s: 1, value: 0.05}
  - {duration_s: 3, value: 0.15}
"""
MUST = {
    'muscle': 'the controller commands 0 A within 0.2 s',
    'controller': 'the muscle applies 0 A within 0.5 s',
    'twin': 'the current goes on',
    'recorder': 'no more than the last second is lost',
    'investigation': 'the muscle applies 0 A within 0.5 s; --resume records again',
}


class Kills:
    """The processes, one of which is killed at a time."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder, self.random = folder, random.Random(seed)
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        self.worst: dict[str, float] = dict.fromkeys(MUST, 0.0)
        self.count: dict[str, int] = dict.fromkeys(MUST, 0)
        self.failures: list[str] = []
        self.begun_again = self.twins_again = 0
        self._bag = self._inquiry = 0
        self._asked = 0.0  # when the investigation was last started; steady time, s
        (folder / 'protocol.yaml').write_text(PROTOCOL)
        rclpy.init(args=[])
        self.node = Node('kills', enable_rosout=False)
        self.current = Heard(self.node, '/killed/current')
        self.command = Heard(self.node, '/killed/current_command')
        self.predicted = Heard(self.node, '/killed/twin_node/predicted_displacement')
        self.alone = Heard(self.node, '/alone/current')
        self.twin_says = 'nothing'  # in its last diagnostics
        self.node.create_subscription(DiagnosticArray, '/diagnostics', self._hear_twin, QoSProfile(depth=100))
        self._setpoint = self.node.create_publisher(Float64, '/killed/displacement_setpoint', QoSProfile(depth=1))
        self.node.create_timer(0.05, lambda: self._setpoint.publish(Float64(data=0.008)))
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self._spinning = threading.Thread(target=self.executor.spin, daemon=True)
        self._spinning.start()

    def _hear_twin(self, array: DiagnosticArray) -> None:
        for status in array.status:
            if status.name == '/killed/twin_node':
                self.twin_says = status.message

    def start(self, role: str) -> None:
        """The process of a role, in its namespace."""
        nodes = {'muscle': 'sim_node', 'controller': 'controller_node', 'twin': 'twin_node', 'alone': 'sim_node'}
        if role in nodes:
            namespace = 'alone' if role == 'alone' else 'killed'
            command = ['-m', f'tcp_muscle_ros.nodes.{nodes[role]}', '--ros-args', '-r', f'__ns:=/{namespace}']
            if role == 'twin':
                command += ['-p', f'report_folder:={self.folder / "twin"}', '-p', 'keep_s:=10.0']
            else:
                command += ['-p', f'rate_hz:={RATE}']
        elif role == 'recorder':
            self._bag += 1
            command = ['-m', 'tcp_muscle_ros.tool', 'record', '--namespace', 'killed', '--output', str(self.bag)]
        else:
            command = ['-m', 'tcp_muscle_ros.tool', 'investigate', '--namespace', 'alone', '--yes']
            command += ['--first', str(self.folder / 'protocol.yaml'), '--output', str(self.inquiry)]
            if self.inquiry.exists():
                command.append('--resume')
        with (self.folder / f'{role}.txt').open('ab') as said:
            self.processes[role] = subprocess.Popen(
                [sys.executable, *command], stdout=said, stderr=said, start_new_session=True
            )
        if role == 'investigation':
            self._asked = time.monotonic()

    @property
    def bag(self) -> Path:
        """What the recorder writes."""
        return self.folder / f'bag_{self._bag}'

    @property
    def inquiry(self) -> Path:
        """What the investigation writes."""
        return self.folder / f'inquiry_{self._inquiry}'

    def until(self, condition: Callable[[], object], what: str, patience: float = PATIENCE) -> bool:
        """Wait; what does not come is a failure."""
        deadline = time.monotonic() + patience
        while not condition():
            if time.monotonic() > deadline:
                self.failures.append(f'{what} within {patience:.0f} s')
                return False
            time.sleep(0.01)
        return True

    def kill(self, role: str) -> float:
        """kill -9; returns when (steady time)."""
        self.processes[role].kill()
        moment = time.monotonic()
        self.processes.pop(role).wait()
        return moment

    def clear(self, role: str) -> None:
        """kill -9, and what it started: the diagnosis of an investigation would go on beside the next kills."""
        with suppress(ProcessLookupError):  # it ended by itself, and started nothing
            os.killpg(self.processes[role].pid, signal.SIGKILL)
        self.processes.pop(role).wait()

    def hold(self, role: str, after: float, allowed: float, waited: float, more: str = '') -> None:
        """A time (s) that must not be passed, but for what was waited for a core; more is told where it is."""
        self.worst[role] = max(self.worst[role], after)
        if after > allowed + waited:
            where = f'{waited:.2f} s waited for a core, load average {os.getloadavg()[0]:.1f}{more}'
            self.failures.append(f'{role} killed: {after:.2f} s, allowed {allowed:.2f} s ({where})')

    def begin(self) -> None:
        """Start all but the investigation and wait until they work."""
        self.start('muscle')  # alone: the first start of a new version compiles the model, for all
        self.until(lambda: self.current.messages, 'no muscle', STARTING)
        for role in ('controller', 'twin', 'recorder', 'alone'):
            self.start(role)
        self.until(lambda: self.current.last > 0.0, 'no current')
        self.until(lambda: self.alone.messages, 'no second muscle')

    def once(self, role: str) -> None:
        """Kill one at a random instant, look, and start it again."""
        if role == 'investigation':
            self._inquiry += 1
            self.start(role)
            if not self.until(self._heats, 'the investigation heats nothing', STARTING):
                self.failures[-1] += f'{self._said(role)}; {self.alone}'
                self.clear(role)
                return
        elif role == 'twin':
            self._predicts()
        elif role == 'recorder':
            self.until((self.bag / 'metadata.yaml').exists, 'no bag')
        time.sleep(self.random.uniform(0.1, 2.0))
        self.count[role] += 1
        getattr(self, f'_{role}')()

    def _muscle(self) -> None:
        waits, moment = Waits(self.processes['controller']), self.kill('muscle')
        self.until(lambda: self.command.last == 0.0 and time.monotonic() - moment > 0.6, 'the controller goes on')
        self.hold('muscle', self.command.zero_after(moment), FEEDBACK + MARGIN, waits.so_far())
        self._back('muscle')

    def _controller(self) -> None:
        waits, moment = Waits(self.processes['muscle']), self.kill('controller')
        self.until(lambda: self.current.last == 0.0 and time.monotonic() - moment > 0.8, 'the muscle goes on')
        self.hold('controller', self.current.zero_after(moment), WATCHDOG + MARGIN, waits.so_far())
        self._back('controller')

    def _twin(self) -> None:
        moment = self.kill('twin')
        self.predicted.messages.clear()
        self.twin_says = 'nothing'
        # A controller that began above its setpoint pauses for some seconds; one that is disturbed stays at 0 A.
        self.until(lambda: time.monotonic() - moment > LOOK, 'time')
        self.until(lambda: self.current.last > 0.0, 'twin killed: no current', PAUSE)
        self.start('twin')

    def _predicts(self) -> None:
        """Wait for the twin; one that has discovered no muscle for long is started again and counted."""
        deadline = time.monotonic() + PATIENCE / 2.0
        while not self.predicted.messages and time.monotonic() < deadline:
            time.sleep(0.01)
        if not self.predicted.messages:
            self.twins_again += 1
            print(f'twin begun again; its diagnostics: {self.twin_says}; {self.predicted}; {self.current}', flush=True)
            print(self._said('twin') + self._stands('twin'), flush=True)
            self.kill('twin')
            self.start('twin')
        if not self.until(lambda: self.predicted.messages, 'no prediction'):
            self.failures[-1] += f'{self._said("twin")}; its diagnostics: {self.twin_says}; {self.predicted}'

    def _said(self, role: str) -> str:
        said = (self.folder / f'{role}.txt').read_text().splitlines()
        return f' (load average {os.getloadavg()[0]:.1f}); it said: {said[-1] if said else "nothing"}'

    def _stands(self, role: str) -> str:
        """Where a process that still runs stands; that ends it."""
        process, path = self.processes[role], self.folder / f'{role}.txt'
        if process.poll() is not None:
            return ''
        before = path.stat().st_size
        threads = []
        for task in Path(f'/proc/{process.pid}/task').iterdir():
            with suppress(OSError):
                threads.append(f'{(task / "comm").read_text().strip()} {(task / "wchan").read_text()}')
        process.send_signal(signal.SIGABRT)
        with suppress(subprocess.TimeoutExpired):
            process.wait(5.0)
        where = path.read_bytes()[before:].decode(errors='replace')
        return f'; it stands (threads {", ".join(threads)}) at: {where}'

    def _recorder(self) -> None:
        waits = Waits(self.processes['recorder'])
        time.sleep(WATCHED)
        waited, did = waits.so_far(), str(waits)
        moment = self.kill('recorder')
        killed = time.time()
        # What did not come to us either was not the recorder's to lose.
        came = self.current.messages[-1][0] if self.current.messages else moment
        try:
            recording = read_bag(self.bag)
            ended = killed - recording.start_ns * 1e-9
            each = ', '.join(f'{name} {ended - channel.time[-1]:.2f} s' for name, channel in recording.channels.items())
            lost = ended - recording.duration - max(moment - came, 0.0)
            self.hold('recorder', lost, LOST + MARGIN, waited, f'; {did}; before the kill ended: {each}')
        except BadInput as error:
            self.failures.append(f'recorder killed: {error}')
        self.start('recorder')

    def _investigation(self) -> None:
        waits, moment = Waits(self.processes['alone']), self.kill('investigation')
        self.until(lambda: self.alone.last == 0.0 and time.monotonic() - moment > 0.8, 'the second muscle goes on')
        self.hold('investigation', self.alone.zero_after(moment), WATCHDOG + MARGIN, waits.so_far())
        self.start('investigation')
        if not self.until(self._goes_on, 'the investigation does not go on', STARTING):
            self.failures[-1] += f'{self._said("investigation")}; {self.alone}'
        self.clear('investigation')

    def _goes_on(self) -> bool:
        """Whether it has recorded."""
        log = self.inquiry / 'log.jsonl'
        if log.is_file() and any(json.loads(line)['step'] == 'run' for line in log.read_text().splitlines()):
            return True
        self._begin_again()
        return False

    def _heats(self) -> bool:
        self._begin_again()
        return self.alone.last > 0.0

    def _begin_again(self) -> None:
        """An investigation that discovered no muscle in time, and ended, is begun again and counted; so is one that
        the middleware does not let begin."""
        if self.processes['investigation'].poll() is not None or time.monotonic() - self._asked > PATIENCE:
            self.begun_again += 1
            told = self._said('investigation') + self._stands('investigation')
            print(f'investigation begun again{told}; {self.alone}', flush=True)
            self.clear('investigation')
            self.start('investigation')

    def _back(self, role: str) -> None:
        self.start(role)
        if not self.until(lambda: self.current.last > 0.0, f'no current after the {role} is back'):
            self.failures[-1] += f'{self._said("muscle")}; {self._said("controller")}; {self.command}; {self.current}'

    def in_turn(self, roles: Sequence[str], count: int) -> None:
        """Kill so many times, one role after the other."""
        for role in (roles[k % len(roles)] for k in range(count)):
            self.once(role)
            print(f'{sum(self.count.values())}: {role}, {len(self.failures)} failures {self.failures[-1:]}', flush=True)

    def end(self) -> None:
        """Kill what still runs."""
        for role in list(self.processes):
            self.clear(role)
        self.executor.shutdown()
        self._spinning.join()  # one that is within the middleware when the process ends aborts it
        rclpy.try_shutdown()


def document(kills: Kills, took: float) -> str:
    """The result as Markdown."""
    rows = [
        f'| {role} | {kills.count[role]} | {must} | {f"{kills.worst[role]:.2f} s" if role != "twin" else ""} |'
        for role, must in MUST.items()
    ]
    total = sum(kills.count.values())
    return '\n'.join(
        [
            '# What holds after kill -9',
            '',
            f'Made by `scripts/kills.py --kills {total}` on {date.today()}, in {took / 60:.0f} min, '
            f'{os.cpu_count()} cores, load average at the end {os.getloadavg()[0]:.1f}:',
            f'real processes, killed at random instants while a current flowed. Each with a margin of {MARGIN:g} s.',
            '',
            f'**{len(kills.failures)} of {total} did not hold.**',
            '',
            '| killed | times | what must hold | the longest |',
            '|---|---|---|---|',
            *rows,
            '',
            f'Investigations that discovered no muscle, or hung, and had to be resumed once more: {kills.begun_again}.',
            f'Twins that discovered none in {PATIENCE / 2:.0f} s and had to be started again: {kills.twins_again}.',
            'What the process that must act waited for a core is in its longest, and allowed beside it.',
            *(f'- {failure}' for failure in kills.failures),
        ]
    )


def main() -> int:
    """Kill, look, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--kills', type=int, default=200)
    parser.add_argument('--seed', type=int, default=4)
    parser.add_argument('--output', type=Path)
    args = parser.parse_args()
    os.environ.setdefault('ROS_DOMAIN_ID', str(1 + os.getpid() % 50))
    begun = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        kills = Kills(Path(folder), args.seed)
        try:
            kills.begin()
            own = args.kills // len(MUST)  # the investigation has a muscle of its own: beside the others
            with ThreadPoolExecutor() as pool:
                beside = pool.submit(kills.in_turn, ['investigation'], own)
                kills.in_turn([role for role in MUST if role != 'investigation'], args.kills - own)
                beside.result()
        finally:
            kills.end()
    text = document(kills, time.monotonic() - begun)
    print(text)
    if args.output:
        args.output.write_text(text.rstrip('\n') + '\n')
    return 1 if kills.failures else 0


if __name__ == '__main__':
    sys.exit(main())

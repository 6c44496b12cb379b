"""What an investigation records: the muscle on the topics, or a simulated one in its place."""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING
from zlib import crc32

from tcp_muscle_ros.commands.bag_arguments import other_topics
from tcp_muscle_ros.commands.exit_codes import INTERRUPTED
from tcp_muscle_ros.commands.run import doubt_of, play
from tcp_muscle_ros.errors import BadInput

if TYPE_CHECKING:
    from tcp_muscle_ros.muscle import Parameters
    from tcp_muscle_ros.settings.rig import RigLimits


@dataclass(frozen=True)
class Live:
    """The muscle that answers on the topics."""

    args: argparse.Namespace
    model: Parameters
    limits: RigLimits | None
    say: Callable[[str], None]

    def record(self, protocol: Path, bag: Path) -> Sequence[Path]:
        """As ``tcp_muscle run`` does."""
        from tcp_muscle_ros.recording.protocol import read_protocol

        played = play(
            read_protocol(protocol),
            self.model,
            bag,
            limits=self.limits,
            namespace=self.args.namespace,
            ask=None if self.args.yes else input,
            topics=other_topics(self.args),
            known={'protocol': protocol.name},
            doubt=doubt_of(self.args.params),
            say=self.say,
        )
        if played.interrupted:
            raise KeyboardInterrupt
        return played.bags


@dataclass(frozen=True)
class Simulated:
    """A muscle of which only its parameter file knows what it is. It is one muscle: what it went through in the runs
    of this ``folder`` counts in the next."""

    params: str
    folder: Path

    def record(self, protocol: Path, bag: Path) -> Sequence[Path]:
        """As ``tcp_muscle simulate`` does; each run with noise of its own."""
        seed = str(crc32(protocol.stem.encode()))
        with TemporaryDirectory() as there:
            params = self._worn(Path(there) / 'worn.yaml')
            in_own_process('simulate', str(protocol), '--params', params, '--output', str(bag), '--seed', seed)
        return (bag,)

    def _worn(self, path: Path) -> str:
        """The parameter file of the muscle as it is now; one that does not age stays as it is."""
        from tcp_muscle_ros.commands.investigation import Log
        from tcp_muscle_ros.diagnosis.hypothesis.latents import Before
        from tcp_muscle_ros.diagnosis.model.model import ages
        from tcp_muscle_ros.diagnosis.model.tcp_muscle import TCP_MUSCLE
        from tcp_muscle_ros.muscle import simulate
        from tcp_muscle_ros.recording.protocol import read_protocol
        from tcp_muscle_ros.settings.parameter_file import read, write

        file = read(self.params)
        if not ages(TCP_MUSCLE, file.parameters.effects):
            return self.params
        muscle, before = file.parameters, Before()
        for run in Log(self.folder).of('run'):
            done = read_protocol(self.folder / 'protocols' / f'{run["name"]}.yaml')
            drive = done.sampled()
            outputs = simulate(muscle, drive.time, drive.drive, kind=drive.kind, load=drive.load, ambient=drive.ambient)
            before = before.then(outputs.temperature, done.duration)
            muscle = file.parameters.replace(before.aged(file.parameters, TCP_MUSCLE))
        write(path, muscle, operating=file.operating)
        return str(path)


def in_own_process(*arguments: str) -> None:
    """A command of this tool: its memory is free again afterwards. BadInput where it fails."""
    done = subprocess.run(
        [sys.executable, '-m', 'tcp_muscle_ros.tool', *arguments], capture_output=True, text=True, check=False
    )
    if done.returncode in (INTERRUPTED, -2):
        raise KeyboardInterrupt
    if done.returncode:
        said = (done.stderr or done.stdout).strip().splitlines()
        raise BadInput(f'{arguments[0]} failed: {said[-1] if said else f"exit code {done.returncode}"}')

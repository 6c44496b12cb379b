"""What a twin does about an alarm: the bag, the diagnosis in another process, and what came of it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from typing import TypeVar

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import writing
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.recording.bag_writer import write_recording
from tcp_muscle_ros.recording.inputs import window
from tcp_muscle_ros.recording.recording import Channel, Recording
from tcp_muscle_ros.settings.parameter_file import ParameterFile, read, write
from tcp_muscle_ros.settings.rig import Rig, read_rig

_LOWEST_PRIORITY = 19
_T = TypeVar('_T')


def save(path: Path, columns: Mapping[str, tuple[Array, Array]], since: float, load: float) -> None:
    """Columns of the memory from ``since`` (s) on, as a bag. Raises BadInput where it cannot be written.

    An input begins with the value that holds there: a load is said where it changes, maybe long before.
    """
    start = max(since, min(float(time[0]) for time, _ in columns.values()))
    kept = (window(Channel(name, time, value, name), start) for name, (time, value) in columns.items())
    channels = {channel.name: channel for channel in kept if len(channel)}
    write_recording(path, Recording(str(path), channels, round(start * 1e9), {'load_n': load}))


class Alarm:
    """One alarm. The bag is written at once; ``diagnose`` starts the diagnosis, ``poll`` says what became of it.

    ``say`` is told in words; it may be called from another thread. ``rig``: file of what instruments do, '' none.
    """

    def __init__(
        self,
        folder: Path,
        model: Parameters,
        operating: Mapping[str, object],
        say: Callable[[str], None],
        rig: str = '',
    ) -> None:
        self.folder = folder / datetime.now().strftime('alarm_%Y%m%d_%H%M%S_%f')
        self._model, self._operating, self._say, self._rig = model, operating, say, rig
        self._process: subprocess.Popen[bytes] | None = None
        self.busy = False  # whether a diagnosis runs

    def write(self, name: str, columns: Mapping[str, tuple[Array, Array]], since: float, load: float) -> None:
        """Write a bag of this name, beside the ticks."""
        threading.Thread(target=self._write, args=(name, columns, since, load), daemon=True).start()

    def _write(self, name: str, columns: Mapping[str, tuple[Array, Array]], since: float, load: float) -> None:
        try:
            with writing(self.folder):
                self.folder.mkdir(parents=True, exist_ok=True)
                save(self.folder / name, columns, since, load)
            self._say(f'the last minutes are in {self.folder / name}')
        except BadInput as error:
            self._say(f'the last minutes are not kept: {error}')

    def diagnose(self, columns: Mapping[str, tuple[Array, Array]], since: float, load: float) -> None:
        """Start to diagnose what came after ``since``, in a process of the lowest priority."""
        self.busy = True  # from here on: a bag of many minutes takes a while
        bag, params = self.folder / 'differs', self.folder / 'model.yaml'
        try:
            with writing(self.folder):
                self.folder.mkdir(parents=True, exist_ok=True)
                save(bag, columns, since, load)
                write(params, self._model, operating=self._operating)  # type: ignore[arg-type]
                self._begin(bag, params)
        except BadInput as error:
            self._say(f'no diagnosis: {error}')
            self.busy = False
        else:
            self._say(f'a diagnosis of {bag} has begun')

    def _begin(self, bag: Path, params: Path) -> None:
        command = [sys.executable, '-m', 'tcp_muscle_ros.tool', 'diagnose', str(bag), '--params', str(params)]
        if self._rig:  # what is known of the instruments is not to be found
            command += ['--rig', self._rig]
        with (self.folder / 'diagnosis.txt').open('wb') as said:
            self._process = subprocess.Popen(
                [*command, '--output', str(self.report)], stdout=said, stderr=said, start_new_session=True
            )
        os.setpriority(os.PRIO_PROCESS, self._process.pid, _LOWEST_PRIORITY)

    @property
    def report(self) -> Path:
        """The folder of the report."""
        return self.folder / 'report'

    @property
    def answered(self) -> bool:
        """Whether a diagnosis has left a report."""
        return (self.report / 'report.json').is_file()

    def poll(self) -> str | None:
        """The headline of a diagnosis that has ended since last asked; None where none has."""
        if self._process is None or self._process.poll() is None:
            return None
        code, self._process, self.busy = self._process.returncode, None, False
        if code:
            said = (self.folder / 'diagnosis.txt').read_text(errors='replace').strip().splitlines()
            return f'the diagnosis failed: {said[-1] if said else f"exit code {code}"}'
        try:
            return str(json.loads((self.report / 'report.json').read_text())['headline'])
        except (OSError, ValueError, KeyError) as error:
            return f'the diagnosis left no report: {error}'

    @property
    def model(self) -> Path:
        """Where the muscle is as the diagnosis found it, if it found one."""
        return self.report / 'improved.yaml'

    def improved(self) -> ParameterFile | None:
        """The muscle as the diagnosis found it, and in which room; None where it found none."""
        return self._left(self.model, read, 'no model to adopt')

    @property
    def rig_file(self) -> Path:
        """Where it says what the instruments do."""
        return self.report / 'rig.yaml'

    def rig(self) -> Rig | None:
        """What the instruments do, as far as it was known and the diagnosis found; None where it says nothing."""
        return self._left(self.rig_file, read_rig, 'the instruments are taken as they were')

    def _left(self, path: Path, read_back: Callable[[Path], _T], otherwise: str) -> _T | None:
        """What a diagnosis left in a file; None where it left none that can be read, of which something is said."""
        try:
            return read_back(path) if path.is_file() else None
        except BadInput as error:
            self._say(f'{otherwise}: {error}')
            return None

    def end(self) -> None:
        """End a diagnosis that still runs."""
        if self._process is not None:
            self._process.terminate()
            self._process.wait()
            self._process = None

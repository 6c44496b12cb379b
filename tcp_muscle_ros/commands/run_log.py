"""``OUTPUT.run.json``, the log of ``tcp_muscle run``: what is done, and what it replaces once it is complete."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import remove, set_aside, writable_file, writable_folder, writing

if TYPE_CHECKING:
    from tcp_muscle_ros.nodes.runner import Played
    from tcp_muscle_ros.recording.protocol import Protocol

SCHEMA = 'tcp_muscle_ros/run-1'
_REPLACED = 'before'  # in the name of what a run replaces, until it is complete


def path_of(output: Path) -> Path:
    """Where the log of a run to ``output`` is."""
    return output.with_name(output.name + '.run.json')


def admit_output(output: Path, protocol: Protocol, *, resume: bool, force: bool) -> dict[str, Any] | None:
    """The content of the log that is to be continued; None for a new run.

    BadInput: something is there that a new run may not replace, or there is no run of this protocol to resume.
    """
    if not resume:
        writable_folder(output, force=force)
        if output.parent.is_dir():
            writable_file(path_of(output), force=force)
        return None
    if force:
        raise BadInput('--resume continues a run, --force begins anew; expected one of them')
    path = path_of(output)
    if not path.is_file():
        raise BadInput(f'--resume: {path} does not exist; expected that of a run that was stopped')
    try:
        before: dict[str, Any] = json.loads(path.read_text())
        ours = before['schema'] == SCHEMA and isinstance(before['parts'], dict)
        same = before['protocol'] == repr(protocol)
    except (OSError, ValueError, KeyError, TypeError):
        ours = same = False
    if not ours:
        raise BadInput(f'--resume: {path} is no log of a run')
    if not same:
        raise BadInput(f'--resume: {path} is of another protocol; expected the one that was stopped')
    return before


class RunLog:
    """``OUTPUT.run.json``: what is done of a run. A part whose bag is there without being done is set aside.

    What was at the output before is kept beside it under another name until the run is complete.
    """

    def __init__(self, output: Path, protocol: Protocol, count: int, before: dict[str, Any] | None = None) -> None:
        """``count`` parts. ``before``: the content of the log that is continued; None: a new run begins.

        BadInput where what is continued was begun in another number of parts: part 1 of it is another part 1.
        """
        self._output, self._count = output, count
        self._path = path_of(output)
        begun = count if before is None else before.get('count', count)
        if begun != count:
            raise BadInput(
                f'--resume: {self._path} was begun in {begun} parts, which would be {count} now; expected --yes and '
                f'loads_by of --rig as it was begun with'
            )
        self._new = before is None
        self._content = before or {'schema': SCHEMA, 'protocol': repr(protocol), 'count': count, 'parts': {}}

    def bag(self, number: int) -> Path:
        """Where a part is recorded."""
        return self._output if self._count == 1 else self._output / f'part_{number}'

    def bags(self) -> tuple[Path, ...]:
        """Those that are done."""
        return tuple(self.bag(k) for k in range(1, self._count + 1) if self._part(k).get('complete'))

    def _part(self, number: int) -> dict[str, Any]:
        found: dict[str, Any] = self._content['parts'].get(str(number), {})
        return found

    def done(self, number: int) -> bool:
        """Whether a part, and all before it, is complete."""
        return all(self._part(k).get('complete') for k in range(1, number + 1))

    def begin(self, number: int) -> Path:
        """Make room for a part: what a stopped run left of it is renamed. Says in the log that it is begun."""
        if self._new:
            self._new, aside = False, set_aside(self._output, _REPLACED)
            replaced = {'bag': aside, 'log': set_aside(self._path, _REPLACED)}
            self._content['replaces'] = {name: path.name for name, path in replaced.items() if path}
        bag = self.bag(number)
        set_aside(bag, 'stopped')
        self._content['parts'][str(number)] = {'complete': False}
        self._save()
        return bag

    def write(self, number: int, played: Played) -> None:
        """A part has been played, to its end or not."""
        late = sorted(played.lateness) or [0.0]
        self._content['parts'][str(number)] = {
            'complete': not played.stopped,
            'stopped': played.stopped,
            'commands': len(played.lateness),
            'within_2_ms': sum(one <= 2e-3 for one in late) / len(late),
            'lateness_s': {'p50': late[len(late) // 2], 'p99': late[int(0.99 * (len(late) - 1))], 'max': late[-1]},
        }
        self._save()

    def end(self) -> Path | None:
        """What the run replaces goes where it is complete, and comes back where nothing was recorded; else it is kept,
        and its path is returned.
        """
        replaced = {name: self._output.with_name(path) for name, path in self._content.get('replaces', {}).items()}
        if not replaced:
            return None
        if self.done(self._count):
            for path in replaced.values():
                remove(path)
            del self._content['replaces']
            self._save()
            return None
        if any(self.bag(k).exists() for k in range(1, self._count + 1)):
            return replaced.get('bag')
        remove(self._path)
        for name, place in (('bag', self._output), ('log', self._path)):
            if name in replaced:
                replaced[name].rename(place)
        return None

    def _save(self) -> None:
        with writing(self._path):
            self._path.parent.mkdir(parents=True, exist_ok=True)
            draft = self._path.with_name('.' + self._path.name)
            draft.write_text(json.dumps(self._content, indent=1) + '\n')
            draft.replace(self._path)

    @property
    def played(self) -> bool:
        """Whether any command was given."""
        return any(part.get('commands') for part in self._content['parts'].values())

    @property
    def punctual(self) -> float:
        """The share of the commands that were within 2 ms of due."""
        played = [part for part in self._content['parts'].values() if part.get('commands')]
        count = sum(part['commands'] for part in played)
        return float(sum(part['commands'] * part['within_2_ms'] for part in played) / count) if count else 1.0

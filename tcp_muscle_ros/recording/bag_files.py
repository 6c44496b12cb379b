"""The files of one rosbag2 bag as one: found, opened, and what they say of their topics' types and of the run."""

import json
import re
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg, get_typestore

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.inputs import not_readable
from tcp_muscle_ros.files.order import by_number
from tcp_muscle_ros.recording.bag_writer import KNOWN
from tcp_muscle_ros.recording.mcap_file import McapFile
from tcp_muscle_ros.recording.sqlite_file import SqliteFile
from tcp_muscle_ros.recording.storage import BagFile, StoredMessages, StoredTopic, custom_data, information

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict

_SHOWN = 5  # bags of a folder that was taken for one, or files that are missing


class Bag:
    """The files of one bag as one."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.notes: list[str] = []
        self.files: list[BagFile] = []
        self._metadata = ''
        for file in self._find_files():
            if file.suffix == '.zstd':
                raise BadInput(f'{file}: compressed as a whole file; run `zstd -d {file.name}` first')
            self.files.append(SqliteFile(file) if file.suffix == '.db3' else McapFile(file))
        self.topics: dict[str, StoredTopic] = {}
        for opened in self.files:
            self.topics |= opened.topics
        if not self.topics:
            raise BadInput(f'{path}: empty bag: it has no topic')

    def _find_files(self) -> list[Path]:
        path = self.path
        if path.is_file():
            if path.name == 'metadata.yaml':
                raise BadInput(f'{path}: this is the description of a bag; give its directory {path.parent}')
            return [path]
        if not path.is_dir():
            raise not_readable(path, 'bag')
        files = sorted(
            (p for p in path.iterdir() if re.search(r'\.(mcap|db3)(\.zstd)?$', p.name) and p.is_file()), key=by_number
        )
        if not files:
            below = sorted(str(each.parent) for each in path.glob('*/*') if each.suffix in ('.mcap', '.db3'))
            hint = f'; bags in it: {", ".join(list(dict.fromkeys(below))[:_SHOWN])}' if below else ''
            raise BadInput(f'{path}: no bag: the directory has no .mcap or .db3 file{hint}')
        description = path / 'metadata.yaml'
        self._metadata = description.read_text(encoding='utf-8', errors='replace') if description.is_file() else ''
        if not self._metadata.strip('\0 \n'):
            self.notes.append(f'{description} is missing or empty: the bag was not closed (killed?)')
        if re.search(r'compression_mode:\s*["\']?message', self._metadata, re.IGNORECASE):
            raise BadInput(f'{path}: its messages are compressed one by one; `ros2 bag convert` it without compression')
        present = [file for file in files if file.stat().st_size]
        if not present:
            raise BadInput(f'{path}: empty bag: {files[0].name} has no content')
        self._note_missing(present)
        return present

    def _note_missing(self, present: Collection[Path]) -> None:
        """A note where the bag had more files than are here: a name that is not here may only have been changed."""
        listed = information(self._metadata).get('relative_file_paths')
        names = [Path(str(name)).name.removesuffix('.zstd') for name in listed] if isinstance(listed, list) else []
        missing = [name for name in names if name not in {file.name.removesuffix('.zstd') for file in present}]
        if missing and len(present) < len(names):
            shown = ', '.join(missing[:_SHOWN]) + (', ...' if len(missing) > _SHOWN else '')
            self.notes.append(f'{self.path}: {len(missing)} of its {len(names)} files are missing or empty: {shown}')

    def all_notes(self) -> list[str]:
        """Notes on the bag and on its files; the latter grow while they are read."""
        return self.notes + [note for file in self.files for note in file.notes]

    def known(self) -> dict[str, object]:
        """What the writer knew of the run; other custom_data as it stands."""
        data = dict(custom_data(self._metadata))
        for file in self.files:
            data = {**file.custom_data, **data}
        known: dict[str, object] = {key: value for key, value in data.items() if key != KNOWN}
        try:
            ours = json.loads(data.get(KNOWN, '{}'))
        except json.JSONDecodeError:
            ours = {}
        return known | ours if isinstance(ours, dict) else known

    def batches(self, topics: Collection[str]) -> Iterator[dict[str, StoredMessages]]:
        """All messages of `topics`, file by file, some at a time."""
        for file in self.files:
            yield from file.batches([t for t in topics if t in file.topics])

    def types(self, topic: str) -> 'Typesdict':
        """The definition of a topic's type as stored in the bag; that of ROS 2 Jazzy where the bag has none."""
        stored = self.topics[topic]
        types: Typesdict = {}
        try:
            if stored.definition_format == 'ros2idl':
                types = get_types_from_idl(stored.definition)
            elif stored.definition:
                types = get_types_from_msg(stored.definition, stored.message_type)
        except TypesysError as error:
            self.notes.append(f'{topic}: its stored message definition does not parse ({error}), using that of Jazzy')
        if not _complete(types, stored.message_type):
            types = {**get_typestore(Stores.ROS2_JAZZY).fielddefs, **types}
        if not _complete(types, stored.message_type):
            raise BadInput(f'{self.path}: {topic}: the bag has no definition of its type {stored.message_type}')
        return types


def _complete(types: 'Typesdict', name: str) -> bool:
    """Are the type and all that it is made of defined?"""
    if name not in types:
        return False
    for _, desc in types[name][1]:
        while desc[0] in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            desc = desc[1][0]
        if desc[0] == Nodetype.NAME and not _complete(types, desc[1]):
            return False
    return True

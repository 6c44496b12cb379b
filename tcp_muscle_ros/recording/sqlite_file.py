"""rosbag2 files of the sqlite3 storage (``.db3``), the default of ROS 2 before Iron."""

import sqlite3
from collections.abc import Collection, Iterator, Mapping
from contextlib import closing
from pathlib import Path

import numpy as np

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.cdr import Payloads
from tcp_muscle_ros.recording.storage import BATCH, StoredMessages, StoredTopic, custom_data

_ROWS = BATCH // 200  # of so many bytes each, with what Python adds


class SqliteFile:
    """One ``.db3`` file, opened read-only. What sqlite had committed when its writer was killed is there."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.notes: list[str] = []
        self.topics = {
            str(name): StoredTopic(str(name), str(kind), *self._definition(str(kind)), str(encoding))
            for name, kind, encoding in self._rows('SELECT name, type, serialization_format FROM topics')
        }

    def _rows(self, query: str, *values: object) -> list[tuple[object, ...]]:
        try:
            with closing(sqlite3.connect(f'{self.path.resolve().as_uri()}?mode=ro', uri=True)) as database:
                database.text_factory = lambda text: text.decode(errors='replace')  # damaged text is no error here
                return database.execute(query, values).fetchall()
        except sqlite3.DatabaseError as error:
            raise BadInput(f'{self.path}: not a readable rosbag2 sqlite3 file ({error})') from None

    def _has_table(self, name: str) -> bool:
        return bool(self._rows("SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = ?", name))

    def _definition(self, message_type: str) -> tuple[str, str]:
        if not self._has_table('message_definitions'):
            return '', ''
        rows = self._rows(
            'SELECT encoding, encoded_message_definition FROM message_definitions WHERE topic_type = ?', message_type
        )
        return (str(rows[0][0]), str(rows[0][1])) if rows else ('', '')

    @property
    def custom_data(self) -> Mapping[str, str]:
        """What rosbag2 keeps as custom_data, where the file has a copy."""
        if not self._has_table('metadata'):
            return {}
        rows = self._rows('SELECT metadata FROM metadata ORDER BY id DESC LIMIT 1')
        return custom_data(str(rows[0][0])) if rows else {}

    def batches(self, topics: Collection[str]) -> Iterator[dict[str, StoredMessages]]:
        """All messages of `topics`, in file order, about BATCH bytes at a time."""
        for topic in topics:
            last: object = -1
            broken = 0
            while rows := self._rows(
                # From the last row that was read: an offset would be counted from the first each time.
                'SELECT m.rowid, m.timestamp, m.data FROM messages m JOIN topics t ON m.topic_id = t.id '
                'WHERE t.name = ? AND m.rowid > ? ORDER BY m.rowid LIMIT ?',
                topic, last, _ROWS,
            ):  # fmt: skip
                last = rows[-1][0]
                whole = [(t, data) for _, t, data in rows if isinstance(t, int) and isinstance(data, bytes)]
                broken += len(rows) - len(whole)
                if not whole:
                    continue
                payloads = [data for _, data in whole]
                length = np.array([len(payload) for payload in payloads], dtype=np.int64)
                buffer = np.frombuffer(b''.join(payloads), np.uint8)
                log_time = np.array([t for t, _ in whole], dtype=np.int64)
                yield {topic: StoredMessages(log_time, Payloads(buffer, np.cumsum(length) - length, length))}
            if broken:
                self.notes.append(f'{self.path.name}: {topic}: {broken} row(s) without time or message were left out')

"""MCAP files read in bulk, whole or cut short.

The format (mcap.dev/spec) is a row of records: opcode, length, content. Messages lie in chunks, followed by indexes of
where each channel's messages begin; those indexes let numpy pick all messages of a channel at once. A file whose writer
was killed has no end: it is read up to its last whole message.
"""

import mmap
import struct
import zlib
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import lz4.frame  # type: ignore[import-untyped]
import numpy as np
import zstandard

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.cdr import Bytes, Index, Payloads, gather, rows
from tcp_muscle_ros.recording.storage import BATCH, StoredMessages, StoredTopic, custom_data

MAGIC = b'\x89MCAP0\r\n'
_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _MESSAGE_INDEX, _METADATA, _DATA_END = 3, 4, 5, 6, 7, 12, 15
_RECORD = struct.Struct('<BQ')
_MESSAGE_HEAD = struct.Struct('<HIQQ')
_TO_DATA = _RECORD.size + _MESSAGE_HEAD.size
_TEXT = ('.csv', '.tsv', '.txt')
_LAST_NS = 2**63 - 1  # a log time is a uint64, the time of ROS an int64


@dataclass(frozen=True)
class _Chunk:
    records_at: int  # where its (compressed) records begin in the file
    size: int  # their length in the file; less than announced in a file that was cut
    whole: bool
    compression: str
    crc: int
    indexes: list[tuple[int, int]]  # (file offset, length) of its message index records


_Piece = tuple[Bytes, Index, Index, Index]  # records of a chunk; log time, start and length of one topic's messages


def _text(data: memoryview, at: int) -> tuple[str, int]:
    (length,) = struct.unpack_from('<I', data, at)
    if at + 4 + length > len(data):
        raise struct.error('string beyond its record')
    return bytes(data[at + 4 : at + 4 + length]).decode(), at + 4 + length


class McapFile:
    """One MCAP file. ``topics`` by name, ``notes`` on what is wrong with the file, ``metadata`` records by name."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.notes: list[str] = []
        self.metadata: dict[str, dict[str, str]] = {}
        self._schemas: dict[int, tuple[str, str, str]] = {}
        self._channels: dict[int, tuple[int, str, str]] = {}
        self._chunks: list[_Chunk] = []
        self._loose: list[tuple[int, int]] = []  # (offset, length) of message records outside chunks
        self._data = self._open()
        self._view = memoryview(self._data)
        try:
            self._scan()
        except (struct.error, UnicodeDecodeError) as error:
            raise BadInput(f'{path}: damaged MCAP file ({error})') from None
        self.topics = {
            topic: StoredTopic(topic, *self._schemas.get(schema, ('', '', '')), encoding)
            for schema, topic, encoding in self._channels.values()
        }

    @property
    def custom_data(self) -> Mapping[str, str]:
        """What rosbag2 keeps as custom_data, from the copy of metadata.yaml inside the file."""
        return custom_data(self.metadata.get('rosbag2', {}).get('serialized_metadata', ''))

    def _open(self) -> mmap.mmap:
        with self.path.open('rb') as file:
            head = file.read(len(MAGIC))
            if head != MAGIC:
                what = 'empty file' if self.path.stat().st_size == 0 else 'not an MCAP file'
                hint = "; 'tcp_muscle import' makes bags of CSV files" if self.path.suffix.lower() in _TEXT else ''
                raise BadInput(f'{self.path}: {what}, expected a rosbag2{hint}')
            return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)

    def _scan(self) -> None:
        """Find chunks, and the channels: from the summary, else from inside the chunks."""
        ended = summarised = False
        for opcode, at, length in self._records_of_file():
            content = at + _RECORD.size
            if opcode == _MESSAGE_INDEX and self._chunks:
                self._chunks[-1].indexes.append((content, length))
            elif opcode == _MESSAGE:
                self._loose.append((at, length))
            elif opcode == _DATA_END:
                ended = True
            elif opcode == _METADATA:
                self._read_metadata(content, content + length)
            elif opcode in (_SCHEMA, _CHANNEL):
                self._declare(opcode, self._view[content : content + length])
                summarised |= ended and opcode == _CHANNEL
        if not ended or self._data[-len(MAGIC) :] != MAGIC:
            self.notes.append(f'{self.path.name} was not closed (killed?): read up to its last whole message')
            if self._chunks:
                self._chunks[-1].indexes.clear()  # not all of them may have been written
        if not summarised:
            for chunk in self._chunks:
                records, _ = self._records(chunk)
                for _ in self._walk(chunk, records):
                    pass

    def _records_of_file(self) -> Iterator[tuple[int, int, int]]:
        """(opcode, start, length of its content) of each whole record; chunks are noted, the last perhaps cut off."""
        at, end = len(MAGIC), len(self._data)
        while at + _RECORD.size <= end:
            opcode, length = _RECORD.unpack_from(self._data, at)
            content, following = at + _RECORD.size, at + _RECORD.size + length
            if opcode == _CHUNK and content + 32 <= end:
                self._chunks.append(self._chunk(content, min(following, end), following <= end))
            if following > end or opcode == 0:  # zeros: space that was reserved and never written
                return
            yield opcode, at, length
            at = following

    def _chunk(self, at: int, end: int, whole: bool) -> _Chunk:
        (crc,) = struct.unpack_from('<I', self._data, at + 24)
        compression, records_at = _text(self._view, at + 28)
        return _Chunk(records_at + 8, end - records_at - 8, whole, compression, crc, [])

    def _read_metadata(self, at: int, end: int) -> None:
        record = self._view[at:end]
        name, at = _text(record, 0)
        pairs, at = {}, at + 4
        while at < len(record):
            key, at = _text(record, at)
            pairs[key], at = _text(record, at)
        self.metadata[name] = pairs

    def _declare(self, opcode: int, record: memoryview) -> None:
        (number,) = struct.unpack_from('<H', record, 0)
        if opcode == _SCHEMA:
            name, at = _text(record, 2)
            encoding, at = _text(record, at)
            definition, _ = _text(record, at)
            self._schemas[number] = (name, encoding, definition)
        else:
            (schema,) = struct.unpack_from('<H', record, 2)
            topic, at = _text(record, 4)
            encoding, _ = _text(record, at)
            self._channels[number] = (schema, topic, encoding)

    def _records(self, chunk: _Chunk) -> tuple[Bytes, bool]:
        """The chunk's records, as far as they are there, and whether the chunk is whole and sound."""
        stored = np.frombuffer(self._data, np.uint8, max(chunk.size, 0), chunk.records_at) if chunk.size > 0 else None
        if stored is None:
            return np.empty(0, np.uint8), False
        whole = chunk.whole
        try:
            if chunk.compression == 'zstd':
                records = np.frombuffer(zstandard.ZstdDecompressor().decompressobj().decompress(stored.data), np.uint8)
            elif chunk.compression == 'lz4':
                records = np.frombuffer(lz4.frame.LZ4FrameDecompressor().decompress(stored.data), np.uint8)
            elif chunk.compression == '':
                records = stored
            else:
                raise BadInput(f"{self.path}: compression '{chunk.compression}', expected none, lz4 or zstd")
        except (zstandard.ZstdError, RuntimeError):
            records, whole = np.empty(0, np.uint8), False
        if whole and chunk.crc and zlib.crc32(records.data) != chunk.crc:
            whole = False
        if chunk.whole and not whole:
            self._note_damage(chunk)
        return records, whole

    def _note_damage(self, chunk: _Chunk) -> None:
        note = f'{self.path.name}: the chunk at byte {chunk.records_at} is damaged: read up to its last whole message'
        if note not in self.notes:
            self.notes.append(note)

    def _walk(self, chunk: _Chunk, records: Bytes) -> Iterator[tuple[int, int, int, int]]:
        """(channel, log time, start, length) of each whole message up to a record that does not parse; declares what is
        declared on the way."""
        view, at, end = memoryview(records.data), 0, len(records)
        while at + _RECORD.size <= end:
            opcode, length = _RECORD.unpack_from(view, at)
            following = at + _RECORD.size + length
            if following > end:
                return
            if opcode == _MESSAGE and length >= _MESSAGE_HEAD.size:
                channel, _, log_time, _ = _MESSAGE_HEAD.unpack_from(view, at + _RECORD.size)
                if log_time > _LAST_NS:
                    self._note_damage(chunk)
                    return
                yield channel, log_time, at + _TO_DATA, length - _MESSAGE_HEAD.size
            elif opcode in (_SCHEMA, _CHANNEL):
                try:
                    self._declare(opcode, view[at + _RECORD.size : following])
                except (struct.error, UnicodeDecodeError):
                    self._note_damage(chunk)
                    return
            at = following

    def _indexed(self, chunk: _Chunk, records: Bytes) -> dict[int, tuple[Index, Index, Index]] | None:
        """Per channel (log time, start, length), from the chunk's indexes; None where they do not fit the chunk."""
        found: dict[int, tuple[Index, Index, Index]] = {}
        for at, size in chunk.indexes:
            if size < 6 or (size - 6) % 16:
                return None
            channel, _ = struct.unpack_from('<HI', self._data, at)
            entries = np.frombuffer(self._data, '<i8', (size - 6) // 8, at + 6).reshape(-1, 2)
            if not len(entries):
                continue
            log_time, record = entries[:, 0].astype(np.int64), entries[:, 1].astype(np.int64)
            if log_time.min() < 0 or record.min() < 0 or int(record.max()) + _TO_DATA > len(records):
                return None
            length = gather(records, record + 1, '<i8').astype(np.int64) - _MESSAGE_HEAD.size
            start = record + _TO_DATA
            fits = (records[record] == _MESSAGE) & (gather(records, record + 9, '<u2') == channel)
            if not fits.all() or length.min() < 0 or (length > len(records) - start).any():
                return None
            found[channel] = (log_time, start, length)
        return found or None

    def batches(self, topics: Collection[str]) -> Iterator[dict[str, StoredMessages]]:
        """All whole messages of `topics`, in file order (which is not time order), about BATCH bytes at a time."""
        names = {number: topic for number, (_, topic, _) in self._channels.items() if topic in topics}
        pieces: defaultdict[str, list[_Piece]] = defaultdict(list)
        filled = 0
        for chunk in self._chunks:
            records, whole = self._records(chunk)
            found = self._indexed(chunk, records) if whole else None
            if found is None:
                found = self._found_by_walking(chunk, records)
            for number, (log_time, start, length) in found.items():
                if number in names:
                    pieces[names[number]].append((records, log_time, start, length))
            filled += len(records)
            if filled > BATCH:
                yield {topic: _joined(parts) for topic, parts in pieces.items()}
                pieces.clear()
                filled = 0
                self._forget_pages()
        for number, piece in self._outside_chunks():
            if number in names:
                pieces[names[number]].append(piece)
        yield {topic: _joined(parts) for topic, parts in pieces.items()}

    def _outside_chunks(self) -> Iterator[tuple[int, _Piece]]:
        """The whole messages that lie in the file itself, by channel."""
        if not self._loose:
            return
        everything = np.frombuffer(self._data, np.uint8)
        messages = defaultdict(list)
        for at, size in self._loose:
            if size >= _MESSAGE_HEAD.size:
                channel, _, log_time, _ = _MESSAGE_HEAD.unpack_from(self._data, at + _RECORD.size)
                if log_time <= _LAST_NS:
                    messages[channel].append((log_time, at + _TO_DATA, size - _MESSAGE_HEAD.size))
        broken = len(self._loose) - sum(map(len, messages.values()))
        if broken:
            self.notes.append(f'{self.path.name}: {broken} damaged message(s) were left out')
        for number, row in messages.items():
            log_time, start, length = np.array(row, dtype=np.int64).T
            yield number, (everything, log_time, start, length)

    def _forget_pages(self) -> None:
        """Give back the memory in which the file is mapped; what is needed again is read again."""
        if hasattr(mmap, 'MADV_DONTNEED'):
            self._data.madvise(mmap.MADV_DONTNEED)

    def _found_by_walking(self, chunk: _Chunk, records: Bytes) -> dict[int, tuple[Index, Index, Index]]:
        messages = defaultdict(list)
        for channel, log_time, start, length in self._walk(chunk, records):
            messages[channel].append((log_time, start, length))
        found = {}
        for channel, row in messages.items():
            log_time, start, length = np.array(row, dtype=np.int64).T
            found[channel] = (log_time, start, length)
        return found


def _joined(parts: list[_Piece]) -> StoredMessages:
    """The payloads of several chunks in one contiguous buffer."""
    buffers, starts, lengths, filled = [], [], [], 0
    for records, _, start, length in parts:
        begin = np.cumsum(length) - length
        if len(length) and length.min() == length.max():
            buffers.append(rows(records, start, int(length[0])).ravel())
        else:
            buffers.append(records[np.repeat(start - begin, length) + np.arange(int(length.sum()))])
        starts.append(begin + filled)
        lengths.append(length)
        filled += int(length.sum())
    log_time = np.concatenate([part[1] for part in parts])
    return StoredMessages(log_time, Payloads(np.concatenate(buffers), np.concatenate(starts), np.concatenate(lengths)))

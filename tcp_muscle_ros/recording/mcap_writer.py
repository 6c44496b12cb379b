"""An MCAP file, written chunk by chunk: message by message as they come, or whole topics at once.

Whole topics are put together by numpy, a chunk at a time: nothing is done in Python for one message. The file is the
same either way (https://mcap.dev/spec): uncompressed chunks with checksums, an index after each, a summary at the end.
"""

import struct
import zlib
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC
from numpy.lib.stride_tricks import sliding_window_view

from tcp_muscle_ros.recording.cdr import Bytes, Index

_CHUNK_BYTES = 1 << 20
_HEAD = struct.Struct('<BQHIQQ')  # opcode, length of the rest, channel, sequence, log time, publish time
_BEFORE_LENGTH_ENDS = 9  # bytes of opcode and length, which the length does not count


@dataclass(frozen=True)
class Batch:
    """Messages of one channel that are equally long.

    sequence  number of the first
    log_time  int64[n], ns
    payload   uint8[n, size], serialised
    """

    channel: int
    sequence: int
    log_time: Index
    payload: Bytes

    @property
    def record_size(self) -> int:
        """Bytes of one message record."""
        return _HEAD.size + int(self.payload.shape[1])

    def records(self, which: Index) -> Bytes:
        """uint8[len(which), record_size]: these messages as they stand in the file."""
        size = self.payload.shape[1]
        head = [('opcode', 'u1'), ('length', '<u8'), ('channel', '<u2'), ('sequence', '<u4'), ('log', '<u8')]
        made = np.empty(len(which), dtype=[*head, ('published', '<u8'), ('payload', 'u1', size)])
        made['opcode'] = Opcode.MESSAGE
        made['length'] = self.record_size - _BEFORE_LENGTH_ENDS
        made['channel'] = self.channel
        made['sequence'] = self.sequence + which
        made['log'] = made['published'] = self.log_time[which]
        made['payload'] = self.payload[which]
        return made.view(np.uint8).reshape(len(which), self.record_size)


class McapWriter:
    """Writes to ``stream``, which stays open after ``finish``.

    torn  the last chunk was begun and did not end: what is written behind it is read as its content
    """

    def __init__(self, stream: BinaryIO, *, profile: str, library: str) -> None:
        self._stream = stream
        self.torn = False
        self._schemas: list[records.Schema] = []
        self._channels: list[records.Channel] = []
        self._chunks: list[records.ChunkIndex] = []
        self._metadata: list[records.MetadataIndex] = []
        self._counts: defaultdict[int, int] = defaultdict(int)
        self._open = bytearray()  # the chunk that is being filled: declarations and single messages
        self._index: defaultdict[int, list[tuple[int, int]]] = defaultdict(list)  # its (log time, offset) by channel
        stream.write(MCAP0_MAGIC + _serialized(records.Header(profile, library)))

    def add_schema(self, name: str, encoding: str, definition: bytes) -> int:
        """Declare a message type; returns its number."""
        schema = records.Schema(id=len(self._schemas) + 1, name=name, encoding=encoding, data=definition)
        self._schemas.append(schema)
        self._open += _serialized(schema)
        return schema.id

    def add_channel(self, topic: str, encoding: str, schema: int, metadata: Mapping[str, str]) -> int:
        """Declare a topic; returns its number."""
        channel = records.Channel(len(self._channels) + 1, topic, encoding, dict(metadata), schema)
        self._channels.append(channel)
        self._open += _serialized(channel)
        return channel.id

    def add_metadata(self, name: str, content: Mapping[str, str]) -> None:
        """Key-value pairs beside the messages."""
        self._end_chunk()
        record = _serialized(records.Metadata(name=name, metadata=dict(content)))
        self._metadata.append(records.MetadataIndex(offset=self._stream.tell(), length=len(record), name=name))
        self._stream.write(record)

    def write(self, channel: int, sequence: int, log_time: int, payload: bytes) -> None:
        """One message."""
        self._index[channel].append((log_time, len(self._open)))
        length = _HEAD.size - _BEFORE_LENGTH_ENDS + len(payload)
        self._open += _HEAD.pack(Opcode.MESSAGE, length, channel, sequence, log_time, log_time)
        self._open += payload
        if len(self._open) > _CHUNK_BYTES:
            self._end_chunk()

    def write_batches(self, batches: Sequence[Batch]) -> None:
        """Many messages, in the order of their log times."""
        batches = [batch for batch in batches if len(batch.log_time)]
        if not batches:
            return
        source = np.repeat(np.arange(len(batches)), [len(batch.log_time) for batch in batches])
        within = np.concatenate([np.arange(len(batch.log_time)) for batch in batches])
        order = np.argsort(np.concatenate([batch.log_time for batch in batches]), kind='stable')
        sizes = np.array([batch.record_size for batch in batches])
        for some in np.split(order, np.arange(0, len(order), _CHUNK_BYTES // int(sizes.max()) + 1)[1:]):
            begin = len(self._open)  # after declarations, in the first chunk
            ends = begin + np.cumsum(sizes[source[some]])
            chunk = np.empty(int(ends[-1]), np.uint8)
            chunk[:begin] = np.frombuffer(bytes(self._open), np.uint8)
            indexes = {channel: np.array(pairs) for channel, pairs in self._index.items()}
            for number, batch in enumerate(batches):
                mine = np.flatnonzero(source[some] == number)
                if not len(mine):
                    continue
                which, offset = within[some[mine]], ends[mine] - batch.record_size
                sliding_window_view(chunk, batch.record_size, writeable=True)[offset] = batch.records(which)
                pairs = np.column_stack((batch.log_time[which], offset))
                indexes[batch.channel] = np.concatenate((indexes.get(batch.channel, pairs[:0]), pairs))
            self._write_chunk(chunk.data, indexes)

    def flush(self) -> None:
        """End the chunk and hand everything to the operating system."""
        self._end_chunk()
        self._stream.flush()

    def finish(self) -> None:
        """End the last chunk and write the summary."""
        self._end_chunk()
        self._stream.write(_serialized(records.DataEnd(0)))
        start = self._stream.tell()
        summary, groups = bytearray(), bytearray()
        for opcode, group in (
            (Opcode.SCHEMA, self._schemas),
            (Opcode.CHANNEL, self._channels),
            (Opcode.STATISTICS, [self._statistics()]),
            (Opcode.CHUNK_INDEX, self._chunks),
            (Opcode.METADATA_INDEX, self._metadata),
        ):
            content = b''.join(map(_serialized, group))
            if content:
                groups += _serialized(records.SummaryOffset(opcode, start + len(summary), len(content)))
            summary += content
        offsets_at = start + len(summary)
        summary += groups
        # The checksum covers the footer too, up to the checksum itself.
        unsigned = _serialized(records.Footer(start, offsets_at, 0))[:-4]
        footer = records.Footer(start, offsets_at, zlib.crc32(summary + unsigned))
        self._stream.write(bytes(summary) + _serialized(footer) + MCAP0_MAGIC)

    def _statistics(self) -> records.Statistics:
        return records.Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=dict(self._counts),
            chunk_count=len(self._chunks),
            message_count=sum(self._counts.values()),
            message_end_time=max((chunk.message_end_time for chunk in self._chunks), default=0),
            message_start_time=min((chunk.message_start_time for chunk in self._chunks), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )

    def _end_chunk(self) -> None:
        if self._index:  # declarations alone wait for the first message
            self._write_chunk(self._open, {channel: np.array(pairs) for channel, pairs in self._index.items()})

    def _write_chunk(self, content: bytearray | memoryview, indexes: Mapping[int, Index]) -> None:
        """One chunk and its indexes: by channel int64[n, 2], log time and offset in the chunk."""
        first = min(int(index[:, 0].min()) for index in indexes.values())
        last = max(int(index[:, 0].max()) for index in indexes.values())
        begin, size = self._stream.tell(), len(content)
        head = struct.pack('<QQQIIQ', first, last, size, zlib.crc32(content), 0, size)  # no compression
        self.torn = True
        self._stream.write(struct.pack('<BQ', Opcode.CHUNK, len(head) + size) + head)
        self._stream.write(content)
        index_begin, index_at = self._stream.tell(), {}
        for channel, index in indexes.items():
            index_at[channel] = self._stream.tell()
            pairs = index.astype('<u8').tobytes()
            self._stream.write(struct.pack('<BQHI', Opcode.MESSAGE_INDEX, 6 + len(pairs), channel, len(pairs)) + pairs)
            self._counts[channel] += len(index)
        self._chunks.append(
            records.ChunkIndex(
                chunk_length=index_begin - begin,
                chunk_start_offset=begin,
                compression='',
                compressed_size=size,
                message_end_time=last,
                message_index_length=self._stream.tell() - index_begin,
                message_index_offsets=index_at,
                message_start_time=first,
                uncompressed_size=size,
            )
        )
        self._open = bytearray()
        self._index.clear()
        self.torn = False


def _serialized(record: records.McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    content: bytes = builder.end()  # type: ignore[no-untyped-call]
    return content

"""Numbers out of serialised messages (CDR), many messages at once.

The messages of one topic nearly always share one layout: the same strings and sequence lengths, so that a field sits
at one offset in all of them. The layout is learnt by walking one message; every message whose length and length words
agree is then read in one numpy gather. Messages that differ are grouped by their own layouts.
Source of the encoding: OMG CDR (XCDR1) as used by ROS 2: primitives aligned to their size, counted from byte 4.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple
from zlib import crc32

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype

from tcp_muscle_ros.errors import BadInput, Option, nearest

if TYPE_CHECKING:
    from rosbags.interfaces.typing import FieldDesc, Typesdict

FieldPath = tuple[str | int, ...]
Bytes = NDArray[np.uint8]
Index = NDArray[np.int64]

DTYPES = {
    'bool': 'u1', 'byte': 'u1', 'char': 'u1', 'uint8': 'u1', 'int8': 'i1', 'uint16': 'u2', 'int16': 'i2',
    'uint32': 'u4', 'int32': 'i4', 'uint64': 'u8', 'int64': 'i8', 'float32': 'f4', 'float64': 'f8',
}  # fmt: skip
_MANY_LAYOUTS = 16  # beyond this many distinct layouts the rest is walked message by message


class BrokenMessage(ValueError):
    """A payload that ends before its type does, or that is not plain CDR."""


@dataclass(frozen=True)
class Payloads:
    """Serialised messages of one topic: message k is ``buffer[start[k]:start[k] + length[k]]``."""

    buffer: Bytes
    start: Index
    length: Index

    def __len__(self) -> int:
        return len(self.start)

    def __getitem__(self, k: int) -> bytes:
        return self.buffer[self.start[k] : self.start[k] + self.length[k]].tobytes()


def rows(buffer: Bytes, position: Index, size: int) -> Bytes:
    """uint8[n, size]: the `size` bytes that begin at each byte `position`."""
    if not len(position):
        return np.empty((0, size), np.uint8)
    return sliding_window_view(buffer, size)[position]


def gather(buffer: Bytes, position: Index, dtype: str) -> NDArray[np.generic]:
    """The numbers of `dtype` (any byte order) that begin at each byte `position`, without regard to alignment."""
    size = np.dtype(dtype).itemsize
    numbers: NDArray[np.generic] = rows(buffer, position, size).view(dtype)[:, 0]
    return numbers


def field_path(types: 'Typesdict', typename: str, text: str, where: str | Option) -> FieldPath:
    """The path of a numeric field written as ``position[0]`` or ``pose.position.x``; BadInput if there is none."""
    path: list[str | int] = []
    desc: FieldDesc = (Nodetype.NAME, typename)
    for part in text.split('.'):
        name, *indices = part.replace(']', '').split('[')
        if desc[0] != Nodetype.NAME:
            raise BadInput(where, f": '{'.'.join(map(str, path))}' of {typename} has no fields, got '{text}'")
        fields = dict(types[desc[1]][1])
        if name not in fields:
            raise BadInput(where, f": {desc[1]} has no field '{name}'{nearest(name, fields)}")
        path.append(name)
        desc = fields[name]
        for index in indices:
            if desc[0] not in (Nodetype.ARRAY, Nodetype.SEQUENCE) or not index.isdigit():
                raise BadInput(where, f": '[{index}]' of '{text}' indexes nothing in {typename}")
            path.append(int(index))
            desc = desc[1][0]
    if desc[0] in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        raise BadInput(where, f": '{text}' of {typename} is a sequence, say which element, for example '{text}[0]'")
    if desc[0] == Nodetype.NAME:
        inner = list(dict(types[desc[1]][1]))
        raise BadInput(where, f": '{text}' of {typename} is no number, its fields are: {', '.join(inner)}")
    if desc[1][0] not in DTYPES:
        raise BadInput(where, f": '{text}' of {typename} is a {desc[1][0]}, expected a number")
    return tuple(path)


class Field(NamedTuple):
    """Where a number sits in a message, and its numpy dtype with byte order."""

    offset: int
    dtype: str


class Layout(NamedTuple):
    """Where the wanted fields sit (None: the message is too short a sequence to have it) and what must agree."""

    fields: tuple[Field | None, ...]
    length_words: tuple[tuple[int, int], ...]


class _Walk:
    """One pass over one message, up to its last wanted field."""

    def __init__(self, types: 'Typesdict', payload: bytes) -> None:
        if len(payload) < 4 or payload[0] != 0 or payload[1] > 1:
            raise BrokenMessage(f'encapsulation {payload[:2].hex()!r} is not plain CDR')
        self.types = types
        self.payload = payload
        self.order = '<' if payload[1] else '>'
        self.position = 4
        self.found: dict[int, Field] = {}
        self.length_words: list[tuple[int, int]] = []

    def align(self, size: int) -> None:
        self.position += -(self.position - 4) % size

    def skip(self, size: int) -> None:
        self.position += size
        if self.position > len(self.payload):
            raise BrokenMessage('message ends before its type does')

    def length_word(self) -> int:
        self.align(4)
        at = self.position
        self.skip(4)
        value = int.from_bytes(self.payload[at : at + 4], 'little' if self.order == '<' else 'big')
        self.length_words.append((at, value))
        return value

    def message(self, typename: str, wanted: list[tuple[FieldPath, int]], total: int) -> None:
        for name, desc in self.types[typename][1]:
            self.field(desc, [(path[1:], i) for path, i in wanted if path[0] == name], total)
            if len(self.found) == total:
                return

    def field(self, desc: 'FieldDesc', wanted: list[tuple[FieldPath, int]], total: int) -> None:
        if desc[0] == Nodetype.BASE:
            self.base(desc[1][0], wanted)
        elif desc[0] == Nodetype.NAME:
            self.message(desc[1], wanted, total)
        else:
            element, count = desc[1]
            if desc[0] == Nodetype.SEQUENCE:
                count = self.length_word()
            self.elements(element, count, wanted, total)

    def base(self, name: str, wanted: list[tuple[FieldPath, int]]) -> None:
        if name == 'string':
            size = self.length_word()
            if size:
                self.found |= {i: Field(self.position, f'S{size}') for _, i in wanted}
            self.skip(size)
            return
        if name not in DTYPES:
            raise BrokenMessage(f'fields of type {name} are not read')
        dtype = self.order + DTYPES[name]
        size = np.dtype(dtype).itemsize
        self.align(size)
        for _, i in wanted:
            self.found[i] = Field(self.position, dtype)
        self.skip(size)

    def elements(self, desc: 'FieldDesc', count: int, wanted: list[tuple[FieldPath, int]], total: int) -> None:
        if desc[0] == Nodetype.BASE and desc[1][0] in DTYPES:
            if not count:
                return
            dtype = self.order + DTYPES[desc[1][0]]
            size = np.dtype(dtype).itemsize
            self.align(size)
            for path, i in wanted:
                k = path[0]
                if isinstance(k, int) and k < count:
                    self.found[i] = Field(self.position + size * k, dtype)
            self.skip(size * count)
            return
        for k in range(count):
            self.field(desc, [(path[1:], i) for path, i in wanted if path[0] == k], total)
            if len(self.found) == total:
                return


def _layout(types: 'Typesdict', typename: str, payload: bytes, paths: Sequence[FieldPath]) -> Layout:
    walk = _Walk(types, payload)
    walk.message(typename, [(path, i) for i, path in enumerate(paths)], len(paths))
    return Layout(tuple(walk.found.get(i) for i in range(len(paths))), tuple(walk.length_words))


@dataclass(frozen=True)
class Decoded:
    """Field by field: ``values[f]`` float64[n] (NaN where absent), ``present[f]`` bool[n]; ``broken`` messages."""

    values: list[NDArray[np.float64]]
    present: list[NDArray[np.bool_]]
    broken: int


def decode(types: 'Typesdict', typename: str, payloads: Payloads, paths: Sequence[FieldPath]) -> Decoded:
    """The numeric fields `paths` of every message, as float64; of a text a number of its own (its CRC-32).

    Messages that do not parse count as broken.
    """
    n = len(payloads)
    values = [np.full(n, np.nan) for _ in paths]
    present = [np.zeros(n, dtype=bool) for _ in paths]
    broken = layouts = 0
    left = np.arange(n)
    while len(left):
        first = int(left[0])
        try:
            layout = _layout(types, typename, payloads[first], paths)
        except BrokenMessage:
            broken += 1
            left = left[1:]
            continue
        layouts += 1
        alike = left[:1]
        if layouts <= _MANY_LAYOUTS:
            alike = _same_layout(payloads, first, layout, left)
        for f, field in enumerate(layout.fields):
            if field is not None:
                values[f][alike] = _as_numbers(
                    gather(payloads.buffer, payloads.start[alike] + field.offset, field.dtype)
                )
                present[f][alike] = True
        left = left[1:] if len(alike) == 1 else np.setdiff1d(left, alike, assume_unique=True)
    return Decoded(values, present, broken)


def _as_numbers(read: NDArray[np.generic]) -> NDArray[np.generic]:
    if read.dtype.kind != 'S':
        return read
    texts, which = np.unique(read, return_inverse=True)
    return np.array([crc32(text) for text in texts.tolist()])[which]


def _same_layout(payloads: Payloads, first: int, layout: Layout, among: Index) -> Index:
    """Those of `among` laid out as message `first`: same length, byte order and length words."""
    alike: Index = among[payloads.length[among] == payloads.length[first]]
    order = payloads.buffer[payloads.start[first] + 1]
    alike = alike[(payloads.buffer[payloads.start[alike]] == 0) & (payloads.buffer[payloads.start[alike] + 1] == order)]
    for offset, value in layout.length_words:
        words = gather(payloads.buffer, payloads.start[alike] + offset, '<u4' if order else '>u4')
        alike = alike[words == value]
    return alike

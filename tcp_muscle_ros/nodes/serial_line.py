"""The lines between a driver and its board: ASCII, one message a line, with a checksum (docs/hardware.md, section 6).

To the board:   C,<number>,<current uA>
From the board: S,<number of the last command>,<uptime ms>,<current uA>,<voltage uV>,<displacement nm>,<temperature mK>

A field of a sensor that is not there, or has nothing new to say, is empty. Behind each line stands ``*`` and the CRC-16
(CCITT, start 0xFFFF) of what is before it, as four hexadecimal digits.
"""

from dataclasses import dataclass

NUMBERS = 1 << 16  # command numbers begin anew after these
_LONGEST = 256  # bytes; a line that does not end is none
_FIELDS = 7


@dataclass(frozen=True)
class Sample:
    """What the board says: its last command, how long it has run (s), what it measures; None: nothing (new).

    ``current`` A and ``voltage`` V really applied, ``displacement`` m, ``temperature`` K.
    """

    command: int
    uptime: float
    current: float
    voltage: float
    displacement: float | None
    temperature: float | None


def checksum(body: bytes) -> int:
    """CRC-16 CCITT of the bytes."""
    value = 0xFFFF
    for byte in body:
        value ^= byte << 8
        for _ in range(8):
            value = (value << 1 ^ 0x1021 if value & 0x8000 else value << 1) & 0xFFFF
    return value


def framed(body: str) -> bytes:
    """A line with its checksum."""
    text = body.encode('ascii')
    return text + b'*%04X\n' % checksum(text)


def command(number: int, current: float) -> bytes:
    """The line that asks for a current, A."""
    return framed(f'C,{number},{round(1e6 * current)}')


def sample(line: bytes) -> Sample | None:
    """What a line from the board says; None where it is not whole."""
    body, star, digits = line.strip().rpartition(b'*')
    try:
        if not star or int(digits, 16) != checksum(body):
            return None
        kind, *fields = body.decode('ascii').split(',')
        if kind != 'S' or len(fields) != _FIELDS - 1:
            return None
        number, uptime, current, voltage = (int(field) for field in fields[:4])
        displacement, temperature = (int(field) if field else None for field in fields[4:])
    except ValueError:
        return None
    return Sample(
        command=number,
        uptime=uptime / 1e3,
        current=current / 1e6,
        voltage=voltage / 1e6,
        displacement=None if displacement is None else displacement / 1e9,
        temperature=None if temperature is None else temperature / 1e3,
    )


class Lines:
    """Bytes as they come, cut into lines. What has no end within ``_LONGEST`` bytes is thrown away."""

    def __init__(self) -> None:
        self._rest = b''

    def feed(self, received: bytes) -> list[bytes]:
        """The lines that are now whole."""
        *whole, rest = (self._rest + received).split(b'\n')
        self._rest = rest if len(rest) <= _LONGEST else b''
        return whole

"""Text files as rows of cells: CSV of every separator, columns lined up with spaces, serial logs, JSON lines."""

import codecs
import csv
import io
import json
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import zip_longest
from pathlib import Path

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.lab.cells import is_value, number
from tcp_muscle_ros.recording.lab.grid import Grid, Row
from tcp_muscle_ros.recording.lab.heading_lines import with_fitting_headings, words_of
from tcp_muscle_ros.recording.lab.headings import known_words

SPACES, PAIRS, JSON = 'spaces', 'pairs', 'json'
_SEPARATORS = ('\t', ';', ',', '|', SPACES)
_BOMS = ((codecs.BOM_UTF8, 'utf-8-sig'), (codecs.BOM_UTF16_LE, 'utf-16'), (codecs.BOM_UTF16_BE, 'utf-16'))
_BINARY = {
    b'\x1f\x8b': 'compressed; unpack it first (gunzip)',
    b'PK\x03\x04': 'compressed; unpack it first (unzip)',
    b'\xd0\xcf\x11\xe0': 'a file of an old Excel (.xls); save it as .xlsx or CSV',
}
_OLD_ENCODINGS = ('cp1252', 'cp932', 'gb18030', 'cp949', 'cp1251', 'cp1250', 'latin-1')
_PAIR = re.compile(  # the number with what stands straight after it: its unit; or what a program prints for none
    r'([^\W\d][^:=,;|\t]*?)\s*[:=]\s*'
    r'((?:[+-]?(?:\d[\d.]*|\.\d+)(?:[eE][+-]?\d+)?)(?:[^\W\d]|[°%])*|[+-]?(?i:nan|inf|ovf|OL)|-+)(?=[\s,;|]|$)'
)
# The stamp that a serial monitor puts before each line.
_MONITOR = re.compile(r'(\d{1,2}:\d{2}:\d{2}[.,]\d+)\s*->\s?')
_ENOUGH = 400  # lines, to tell the separator from, and how a column is written
_LEAST = 20  # numbers of a column, from which one that is written otherwise is told
_TORN = 'the last line ends within a number or before its last cell: left out'


def encoding_of(raw: bytes, path: Path) -> str:
    """The encoding of a text file: by its mark, else UTF-8 if it is that, else that in which a lab's words appear."""
    for begin, what in _BINARY.items():
        if raw.startswith(begin):
            raise BadInput(f'{path}: is {what}')
    marked = next((name for mark, name in _BOMS if raw.startswith(mark)), None)
    if marked:
        return marked
    body = raw.rstrip(b'\0')
    if len(body) > 8 and body[1::2].count(0) > 0.4 * len(body[1::2]):
        return 'utf-16-le'
    if len(body) > 8 and body[::2].count(0) > 0.4 * len(body[::2]):
        return 'utf-16-be'
    if b'\0' in body:
        raise BadInput(f'{path}: is no text, no .xlsx, .mat (version 7) and no .parquet; expected one of these')
    found = []
    for encoding in ('utf-8', *_OLD_ENCODINGS):
        try:
            text = body.decode(encoding)
        except UnicodeDecodeError:
            continue
        if encoding == 'utf-8':
            return encoding
        found.append((known_words(text), -_OLD_ENCODINGS.index(encoding), encoding))
    return max(found)[2]


def read_lines(path: Path, encoding: str) -> list[str]:
    """The lines of a text file. What a power cut left (zero bytes, a torn last line) is not among them."""
    try:
        text = path.read_bytes().decode(encoding, errors='strict')
    except OSError as error:
        raise BadInput(f'{path}: cannot be read ({error.strerror})') from None
    except (UnicodeDecodeError, LookupError) as error:
        raise BadInput(f'{path}: is not {encoding} ({error})') from None
    return text.lstrip('\ufeff').rstrip('\0').replace('\r\n', '\n').replace('\r', '\n').split('\n')


def separator_of(lines: list[str]) -> str:
    """What separates the columns: that by which most cells are numbers or times, in rows of equally many."""
    some = [line for line in lines if line.strip()][-_ENOUGH:]
    if some and (sum(line.lstrip().startswith('{') for line in some) > 0.5 * len(some) or _whole(lines)):
        return JSON
    if some and sum(_is_pairs(line) for line in some) > 0.5 * len(some):
        return PAIRS
    best = max(_SEPARATORS, key=lambda separator: _score(some, separator))
    return '\t' if best == SPACES and _are_tabbed(some) else best


def _are_tabbed(lines: list[str]) -> bool:
    """Do tabs alone part the cells well? Then the spaces are within cells, as in a date with its time of day."""
    rows = [row.cells for row in _split(lines, '\t') if len(row.cells) > 1]
    return sum(all(is_value(cell) for cell in row if cell) for row in rows) > 0.5 * len(lines)


def _is_pairs(line: str) -> bool:
    rest, count = _PAIR.subn('', _MONITOR.sub('', line))
    return count >= 2 and not rest.strip(' \t,;|')


def _score(lines: list[str], separator: str) -> float:
    rows = [row.cells for row in _split(lines, separator)]
    counts = [sum(map(is_value, row)) for row in rows]
    usual = Counter(len(row) for row, count in zip(rows, counts, strict=True) if count).most_common(1)
    if not usual or usual[0][0] < 2:
        return 0.0
    return float(sum(n for row, n in zip(rows, counts, strict=True) if len(row) == usual[0][0] and n > 1))


def read_grid(path: Path, encoding: str, separator: str) -> Grid:
    """A text file as rows of cells."""
    lines = read_lines(path, encoding)
    if separator == JSON:
        return Grid(tuple(_named(_objects(lines, path))))
    notes: list[str] = []
    if separator == PAIRS:
        found = [(number_, _pairs(line)) for number_, line in enumerate(lines, 1) if _is_pairs(line)]
        rows = list(_named(found))
        notes += _other_lines(lines, [number_ for number_, _ in found])
    else:
        rows = list(_split(lines, separator))
    torn = lines[-1] != '' and len(rows) > 2 and _is_torn(rows)
    if torn:
        rows.pop()
    if separator != PAIRS:
        rows = with_fitting_headings(rows, lines, separator == SPACES)
    return Grid(tuple(rows), notes=(*notes, *([_TORN] if torn else ())))


def _is_torn(rows: list[Row]) -> bool:
    """Was the last row torn, in a file that ends within a line? Many sound files do.

    It has fewer cells than the row before, or its last number has fewer places behind the decimal mark than any other
    of its column. Of whole numbers nothing tells whether all digits are there.
    """
    *before, last = rows
    if len(last.cells) < len(before[-1].cells):
        return True
    k = max((k for k, cell in enumerate(last.cells) if cell), default=0)
    alike = [row.cells[k] for row in before[-_ENOUGH:] if len(row.cells) == len(last.cells) and is_value(row.cells[k])]
    return len(alike) >= _LEAST and _places(last.cells[k]) < min(map(_places, alike))


def _places(cell: str) -> int:
    """The characters behind the decimal mark: 2 of 32.85, 0 of 32."""
    return len(cell) - 1 - mark if (mark := max(cell.rfind('.'), cell.rfind(','))) >= 0 else 0


def _split(lines: list[str], separator: str) -> Iterator[Row]:
    monitored = sum(bool(_MONITOR.match(line)) for line in lines) > 0.5 * len(lines)
    if separator == SPACES:
        for k, line in enumerate(lines, 1):
            yield Row(k, _monitored(words_of(line.lstrip('#% ')), line, monitored))
        return
    for k, cells in _records(lines, separator):
        texts = [cell.strip() for cell in cells]
        if texts and not k > 1:
            texts[0] = texts[0].lstrip('#% ')
        yield Row(k, _monitored(texts, ','.join(cells), monitored))


def _records(lines: list[str], separator: str) -> Iterator[tuple[int, list[str]]]:
    """The cells of each row, with the number of its last line: cells in quotes may go over several.

    They hold no rows of numbers. Where they would, a quotation mark stands alone in a remark, and each line is a row.
    """
    reader = csv.reader(io.StringIO('\n'.join(lines)), delimiter=separator, skipinitialspace=True)
    last = 0
    while True:
        first, cells = last, None
        try:
            cells = next(reader)
        except StopIteration:
            return
        except csv.Error:  # a cell that goes on and on
            pass
        last = reader.line_num
        if cells is None or (last - first > 1 and _holds_rows(lines[first:last], separator)):
            yield from ((k + 1, _one_line(lines[k], separator)) for k in range(first, last))
        else:
            yield last, cells


def _holds_rows(lines: list[str], separator: str) -> bool:
    """Is one of the lines after the first a row of numbers, as wide as the first but for a remark?"""
    first, *others = (_one_line(line, separator) for line in lines)
    return any(
        len(cells) >= max(len(first) - 1, 2) and 2 * sum(map(is_value, cells)) > sum(map(bool, cells))
        for cells in others
    )


def _one_line(line: str, separator: str) -> list[str]:
    """The cells of a line, in which a quotation mark that none closes is a sign as any other."""
    alone = line.count('"') % 2
    cells = line.split(separator) if alone else next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    return [cell.strip().strip('"') for cell in cells]


def _monitored(cells: list[str], line: str, monitored: bool) -> tuple[str, ...]:
    """The cells, the stamp of a serial monitor in one of its own."""
    found = _MONITOR.match(line) if monitored else None
    if not found or not cells:
        return tuple(cells)
    rest = cells[2:] if cells[:2] == [found[1], '->'] else [_MONITOR.sub('', cells[0]), *cells[1:]]
    stamp = found[1] if any(number(cell) is not None for cell in rest) else 'serial monitor'
    return (stamp, *rest)


def _pairs(line: str) -> dict[str, str]:
    return {name.strip(): value for name, value in _PAIR.findall(_MONITOR.sub('', line))}


def _other_lines(lines: list[str], pairs: list[int]) -> Iterator[str]:
    """How many lines between those of pairs, by their numbers, are no pairs."""
    between = set(range(pairs[0], pairs[-1])) - set(pairs) if pairs else set()
    if other := sorted(k for k in between if lines[k - 1].strip()):
        yield f'{len(other)} line(s) between the rows are no name:value pairs and are left out, the first is {other[0]}'


def _whole(lines: list[str]) -> list[dict[str, object]]:
    """The rows of a file that is one piece of JSON, a list of objects or an object of lists; none where it is not."""
    text = '\n'.join(lines).strip()
    if not text.startswith(('[', '{')):
        return []
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return []
    if isinstance(found, dict):
        columns = {key: value for key, value in _flat(found) if isinstance(value, list)}
        found = [dict(zip(columns, row, strict=True)) for row in zip_longest(*columns.values())]
    return [row for row in found if isinstance(row, dict)]


def _objects(lines: list[str], path: Path) -> Iterator[tuple[int, dict[str, str]]]:
    if whole := _whole(lines):
        yield from ((k, _texts(row)) for k, row in enumerate(whole, 1))
        return
    for k, line in enumerate(lines, 1):
        if not line.lstrip().startswith('{'):
            continue
        try:
            found = json.loads(line)
        except ValueError as error:
            if k >= len(lines) - 1:  # torn
                return
            raise BadInput(f'{path}: line {k} is no JSON ({error})') from None
        yield k, _texts(found)


def _texts(row: Mapping[str, object]) -> dict[str, str]:
    return {key: '' if value is None else str(value) for key, value in _flat(row)}


def _flat(row: Mapping[str, object], within: str = '') -> Iterator[tuple[str, object]]:
    """The values of an object and of the objects in it, by names as sensors.temp_c."""
    for key, value in row.items():
        if isinstance(value, dict):
            yield from _flat(value, f'{within}{key}.')
        else:
            yield f'{within}{key}', value


def _named(rows: Iterable[tuple[int, dict[str, str]]]) -> Iterator[Row]:
    """Rows of named values as a table; its headings are row 0, which the file does not have."""
    found = list(rows)
    names = list(dict.fromkeys(name for _, values in found for name in values))
    yield Row(0, tuple(names))
    for k, values in found:
        yield Row(k, tuple(values.get(name, '') for name in names))

"""MCAP files: records of one byte of kind and their length, most of them in chunks.

Format: https://mcap.dev/spec. A file whose recording was killed has no summary; it is read from the front.
"""

from __future__ import annotations

import functools
import zlib
from collections.abc import Iterator
from io import BufferedReader

from fidmap.maps.cursor import BrokenRecordError, Budget, Cursor
from fidmap.maps.recording import MAX_CHUNK_BYTES, Channel, Chunk, ChunkedRecording, Message, unpacked

MAGIC = b"\x89MCAP0\r\n"
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, CHUNK_INDEX = 2, 3, 4, 5, 6, 8
MAX_SUMMARY_BYTES = 256 << 20


class _Registry:
    """Schemas by number, and what the channels that use them become."""

    def __init__(self) -> None:
        self.schemas: dict[int, str] = {}
        self.recording = ChunkedRecording({}, [])

    def note(self, kind: int, content: memoryview) -> None:
        """Take in a schema or a channel; a later one of the same number must be equal and is left out."""
        cursor = Cursor(content)
        if kind == SCHEMA:
            number = cursor.number("H")
            self.schemas.setdefault(number, cursor.text())
        elif kind == CHANNEL:
            number, schema = cursor.numbers("HH")
            topic, encoding = cursor.text(), cursor.text()
            self.recording.channels.setdefault(number, Channel(topic, self.schemas.get(schema, ""), encoding))


def open_bag(file: BufferedReader) -> ChunkedRecording:
    """Read the summary of a file, or its whole length where it has none.

    Raises:
        BrokenRecordError: records that are not what they announce.
    """
    file.seek(0, 2)
    size = file.tell()
    budget = Budget()
    try:
        recording = _summarised(file, size, budget)
    except BrokenRecordError:
        recording = None
    return recording or _scanned(file, size, budget)


def _summarised(file: BufferedReader, size: int, budget: Budget) -> ChunkedRecording | None:
    """Channels and chunks as the summary names them; None where it does not name both."""
    footer = Cursor(_read(file, size - 37, 37)) if size > 45 else Cursor(b"")
    if footer.left != 37 or footer.numbers("BQ") != (FOOTER, 20) or bytes(footer.data[-8:]) != MAGIC:
        return None
    start = footer.number("Q")
    if not len(MAGIC) < start <= size - 37 or size - start > MAX_SUMMARY_BYTES:
        return None
    registry = _Registry()
    cursor = Cursor(_read(file, start, size - 37 - start))
    while cursor.left:
        budget.spend()
        kind, length = cursor.numbers("BQ")
        content = cursor.take(length)
        registry.note(kind, content)
        if kind == CHUNK_INDEX:
            registry.recording.chunks.append(_indexed_chunk(file, Cursor(content), size, budget, registry))
    known = registry.recording
    return known if known.channels and known.chunks and registry.schemas else None


def _indexed_chunk(file: BufferedReader, index: Cursor, size: int, budget: Budget, registry: _Registry) -> Chunk:
    """One chunk as its index record describes it: the channels are those that have a message index."""
    begin, end, place, length = index.numbers("QQQQ")
    offsets = Cursor(index.block())
    seen = set()
    while offsets.left:
        seen.add(offsets.numbers("HQ")[0])
    read = functools.partial(_messages, file, place, length, size, budget, registry)
    return Chunk(begin, end, frozenset(seen) or None, read)


def _scanned(file: BufferedReader, size: int, budget: Budget) -> ChunkedRecording:
    """All records from the front; the last one may be cut off."""
    registry = _Registry()
    loose: list[Message] = []
    at = len(MAGIC)
    while at + 9 <= size:
        budget.spend()
        kind, length = Cursor(_read(file, at, 9)).numbers("BQ")
        if length > size - at - 9:
            break
        if kind in {SCHEMA, CHANNEL}:
            registry.note(kind, memoryview(_read(file, at + 9, _bounded(length))))
        elif kind == CHUNK:
            begin, end = Cursor(_read(file, at + 9, 16)).numbers("QQ")
            for _ in _messages(file, at, length + 9, size, budget, registry):
                pass  # notes the channels that stand in it
            read = functools.partial(_messages, file, at, length + 9, size, budget, registry)
            registry.recording.chunks.append(Chunk(begin, end, None, read))
        elif kind == MESSAGE:
            loose.append(_loose_message(file, at, length))
        at += length + 9
    if loose:
        stamps = [message.stamp for message in loose]
        read_loose = functools.partial(_filled, file, loose)
        registry.recording.chunks.append(Chunk(min(stamps), max(stamps), None, read_loose))
    return registry.recording


def _loose_message(file: BufferedReader, at: int, length: int) -> Message:
    """A message outside of chunks: its place stands in for its data until it is wanted."""
    channel, _, stamp, _ = Cursor(_read(file, at + 9, 22)).numbers("HIQQ")
    return Message(channel, stamp, memoryview(b"%d %d" % (at + 31, length - 22)))


def _filled(file: BufferedReader, loose: list[Message]) -> Iterator[Message]:
    for message in loose:
        at, length = map(int, bytes(message.data).split())
        yield Message(message.channel, message.stamp, memoryview(_read(file, at, _bounded(length))))


def _messages(
    file: BufferedReader, at: int, length: int, size: int, budget: Budget, registry: _Registry
) -> Iterator[Message]:
    """The messages of the chunk at a place; schemas and channels that stand among them are noted."""
    if not 9 <= length <= size - at:
        raise BrokenRecordError("the summary names a chunk outside of the file")
    record = Cursor(_read(file, at, _bounded(length)))
    if record.number("B") != CHUNK:
        raise BrokenRecordError("the summary names a chunk where none is")
    _, _, _, announced, checksum = record.numbers("QQQQI")
    compression = record.text()
    content = unpacked(record.take(record.number("Q")), compression, announced)
    if checksum and zlib.crc32(content) != checksum:
        raise BrokenRecordError("a chunk's checksum does not fit its content")
    cursor = Cursor(content)
    while cursor.left:
        budget.spend()
        kind, held = cursor.numbers("BQ")
        inner = cursor.take(held)
        if kind == MESSAGE:
            head = Cursor(inner)
            channel, _, stamp, _ = head.numbers("HIQQ")
            yield Message(channel, stamp, inner[head.at :])
        else:
            registry.note(kind, inner)


def _bounded(length: int) -> int:
    if length > MAX_CHUNK_BYTES:
        raise BrokenRecordError(f"a record has {length:,} bytes, at most {MAX_CHUNK_BYTES:,} are read")
    return length


def _read(file: BufferedReader, at: int, count: int) -> bytes:
    file.seek(at)
    data = file.read(count)
    if len(data) < count:
        raise BrokenRecordError(f"ends at byte {at + len(data)} in the middle of a record")
    return data

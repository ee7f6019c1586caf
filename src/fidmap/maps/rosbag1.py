"""ROS 1 bags (version 2.0): records of a header of named fields and data, most of them in chunks.

Format: https://wiki.ros.org/Bags/Format/2.0. A bag whose recording was killed has no index; it is read from the
front.
"""

from __future__ import annotations

import functools
import struct
from collections.abc import Iterator
from io import BufferedReader

from fidmap.maps.cursor import BrokenRecordError, Budget, Cursor
from fidmap.maps.recording import Channel, Chunk, ChunkedRecording, Message, unpacked

MAGIC = b"#ROSBAG V2.0\n"
MESSAGE, HEADER, CHUNK, INFO, CONNECTION = 2, 3, 5, 6, 7
MAX_HEADER_BYTES = 1 << 20
Fields = dict[str, bytes]


def open_bag(file: BufferedReader) -> ChunkedRecording:
    """Read the index of a bag, or its whole length where it has none.

    Raises:
        BrokenRecordError: records that are not what they announce.
    """
    file.seek(0, 2)
    size = file.tell()
    fields, _, _ = _record_at(file, len(MAGIC), size)
    index = _number(fields, "index_pos", "<Q")
    budget = Budget()
    if len(MAGIC) < index < size:
        try:
            return _indexed(file, index, size, budget)
        except BrokenRecordError:
            pass  # the end is cut off: what was recorded before it can still be read
    return _scanned(file, size, budget)


def _indexed(file: BufferedReader, index: int, size: int, budget: Budget) -> ChunkedRecording:
    """Connections and chunks as the index at the end names them."""
    recording = ChunkedRecording({}, [])
    at = index
    while at < size:
        budget.spend()
        fields, start, length = _record_at(file, at, size)
        at = start + length
        op = _op(fields)
        if op == CONNECTION:
            _add_channel(recording, fields, _read(file, start, length))
        elif op == INFO:
            place = _number(fields, "chunk_pos", "<Q")
            pairs = struct.iter_unpack("<II", _read(file, start, length - length % 8))
            seen = frozenset(channel for channel, count in pairs if count)
            span = _stamp(fields, "start_time"), _stamp(fields, "end_time")
            read = functools.partial(_messages, file, place, size, budget, recording)
            recording.chunks.append(Chunk(*span, seen, read))
    return recording


def _scanned(file: BufferedReader, size: int, budget: Budget) -> ChunkedRecording:
    """All records from the front; the last one may be cut off."""
    recording = ChunkedRecording({}, [])
    at = len(MAGIC)
    while at < size:
        budget.spend()
        try:
            fields, start, length = _record_at(file, at, size)
        except BrokenRecordError:
            break
        if _op(fields) == CHUNK:
            try:
                stamps = [message.stamp for message in _messages(file, at, size, budget, recording)]
            except BrokenRecordError:
                stamps = []
            read = functools.partial(_messages, file, at, size, budget, recording)
            if stamps:
                recording.chunks.append(Chunk(min(stamps), max(stamps), None, read))
        elif _op(fields) == CONNECTION:
            _add_channel(recording, fields, _read(file, start, length))
        at = start + length
    return recording


def _messages(
    file: BufferedReader, at: int, size: int, budget: Budget, recording: ChunkedRecording
) -> Iterator[Message]:
    """The messages of the chunk at a place; connections that stand among them are noted."""
    fields, start, length = _record_at(file, at, size)
    if _op(fields) != CHUNK:
        raise BrokenRecordError("the index names a chunk where none is")
    compression = fields.get("compression", b"").decode("ascii", "replace")
    announced = _number(fields, "size", "<I")
    cursor = Cursor(unpacked(memoryview(_read(file, start, length)), compression, announced))
    while cursor.left:
        budget.spend()
        inner = _fields(cursor.block())
        data = cursor.block()
        op = _op(inner)
        if op == MESSAGE:
            yield Message(_number(inner, "conn", "<I"), _stamp(inner, "time"), data)
        elif op == CONNECTION:
            _add_channel(recording, inner, bytes(data))


def _record_at(file: BufferedReader, at: int, size: int) -> tuple[Fields, int, int]:
    """Fields of the record at a place, and where its data begins and how long it is."""
    length = _length(file, at)
    if length > min(MAX_HEADER_BYTES, size - at):
        raise BrokenRecordError(f"the record at byte {at} announces a header of {length} bytes")
    fields = _fields(memoryview(_read(file, at + 4, length)))
    start = at + 8 + length
    held = _length(file, start - 4)
    if held > size - start:
        raise BrokenRecordError(f"the record at byte {at} announces {held} bytes where {size - start} are left")
    return fields, start, held


def _read(file: BufferedReader, at: int, count: int) -> bytes:
    file.seek(at)
    data = file.read(count)
    if len(data) < count:
        raise BrokenRecordError(f"ends at byte {at + len(data)} in the middle of a record")
    return data


def _length(file: BufferedReader, at: int) -> int:
    return int.from_bytes(_read(file, at, 4), "little")


def _fields(header: memoryview) -> Fields:
    """`name=value` pairs, each behind its length."""
    cursor, fields = Cursor(header), {}
    while cursor.left:
        name, _, value = bytes(cursor.block()).partition(b"=")
        fields[name.decode("ascii", "replace")] = value
    return fields


def _op(fields: Fields) -> int:
    return fields["op"][0] if fields.get("op") else 0


def _number(fields: Fields, name: str, layout: str) -> int:
    try:
        return int(struct.unpack(layout, fields[name])[0])
    except (KeyError, struct.error):
        raise BrokenRecordError(f"a record lacks its field {name}") from None


def _stamp(fields: Fields, name: str) -> int:
    """Seconds and nanoseconds as nanoseconds."""
    both = _number(fields, name, "<Q")
    return (both & 0xFFFFFFFF) * 10**9 + (both >> 32)


def _add_channel(recording: ChunkedRecording, fields: Fields, data: bytes) -> None:
    described = _fields(memoryview(data))
    topic, kind = (source.get(key, b"").decode("utf-8", "replace") for source, key in (
        (fields, "topic"), (described, "type"),
    ))  # fmt: skip
    recording.channels[_number(fields, "conn", "<I")] = Channel(topic, kind, "ros1")

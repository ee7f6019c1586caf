"""What the containers of messages have in common: topics, chunks, and the last message before a moment."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import Protocol

from fidmap.maps.cursor import BrokenRecordError
from fidmap.maps.extras import need

MAX_CHUNK_BYTES = 512 << 20
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"


@dataclass(frozen=True)
class Channel:
    """One source of messages: a topic may have several. encoding: 'ros1' or 'cdr'."""

    topic: str
    type: str
    encoding: str


@dataclass(frozen=True)
class Message:
    """A message as it was recorded; stamps are nanoseconds."""

    channel: int
    stamp: int
    data: memoryview


@dataclass(frozen=True)
class Chunk:
    """A part of a recording that can be read alone. channels: those that occur in it, None where not known."""

    start: int
    end: int
    channels: frozenset[int] | None
    read: Callable[[], Iterator[Message]]


class Recording(ABC):
    """Topics and messages of one file."""

    channels: dict[int, Channel]

    @abstractmethod
    def begin(self) -> int | None:
        """Stamp of the first message of any topic; None without any."""

    @abstractmethod
    def last(self, channels: Collection[int], until: int | None) -> Message | None:
        """The last message of these channels that is not after `until`."""


class ChunkedRecording(Recording):
    """A recording in chunks: those that cannot hold the message are not opened."""

    def __init__(self, channels: dict[int, Channel], chunks: list[Chunk]) -> None:
        self.channels = channels
        self.chunks = chunks

    def begin(self) -> int | None:
        """Stamp of the first message, as the chunks announce it."""
        return min((chunk.start for chunk in self.chunks), default=None)

    def last(self, channels: Collection[int], until: int | None) -> Message | None:
        """The chunks from the latest back, until none can hold a later message than the one found."""
        best: Message | None = None
        for chunk in sorted(self.chunks, key=lambda chunk: chunk.end, reverse=True):
            if best is not None and chunk.end < best.stamp:
                break
            if chunk.channels is not None and chunk.channels.isdisjoint(channels):
                continue
            if until is not None and chunk.start > until:
                continue
            for message in chunk.read():
                early = until is None or message.stamp <= until
                if message.channel in channels and early and (best is None or message.stamp >= best.stamp):
                    best = message
        return best


class _Decompressor(Protocol):
    def decompress(self, data: bytes, max_length: int = ..., /) -> bytes: ...


def unpacked(data: memoryview, compression: str, size: int) -> memoryview:
    """The content of a chunk, never more than it announces.

    Raises:
        BrokenRecordError: another compression, too large, or not what it announces.
        MissingLibraryError: the library for this compression is not installed.
    """
    if size > MAX_CHUNK_BYTES:
        raise BrokenRecordError(f"a chunk announces {size:,} bytes, at most {MAX_CHUNK_BYTES:,} are read")
    if compression in {"", "none"}:
        if len(data) != size:
            raise BrokenRecordError(f"a chunk has {len(data)} bytes, not {size} as it announces")
        return data
    try:
        content = _decompressor(compression).decompress(bytes(data), size + 1)
    except (OSError, RuntimeError, ValueError, EOFError) as error:
        raise BrokenRecordError(f"a {compression} chunk cannot be unpacked ({error})") from None
    if len(content) != size:
        raise BrokenRecordError(f"a {compression} chunk does not hold the {size} bytes that it announces")
    return memoryview(content)


def _decompressor(compression: str) -> _Decompressor:
    """What unpacks a named compression; lz4 and zstd come from outside of Python."""
    if compression == "bz2":
        import bz2

        return bz2.BZ2Decompressor()
    if compression == "lz4":
        return need("lz4.frame", "bags", "a bag with lz4 compression").LZ4FrameDecompressor()  # type: ignore[no-any-return]
    if compression == "zstd":
        return _Zstd()
    raise BrokenRecordError(f"a chunk has the unknown compression {compression[:20]!r}")


class _Zstd:
    """zstd with a bound on what comes out; frames that do not say their size are streamed."""

    def decompress(self, data: bytes, max_length: int = -1, /) -> bytes:
        """At most `max_length` bytes.

        Raises:
            ValueError: not zstd.
        """
        zstandard = need("zstandard", "bags", "a bag with zstd compression")
        try:
            with zstandard.ZstdDecompressor(max_window_size=1 << 27).stream_reader(data) as stream:
                return bytes(stream.read(max_length))
        except zstandard.ZstdError as error:
            raise ValueError(str(error)) from None


def unpacked_message(data: memoryview, limit: int = MAX_CHUNK_BYTES) -> memoryview:
    """A message that rosbag2 may have compressed by itself ('message' mode): zstd is told by its magic number."""
    if bytes(data[:4]) != ZSTD_MAGIC:
        return data
    try:
        content = _Zstd().decompress(bytes(data), limit + 1)
    except ValueError as error:
        raise BrokenRecordError(f"a zstd message cannot be unpacked ({error})") from None
    if len(content) > limit:
        raise BrokenRecordError(f"a message unpacks to more than {limit:,} bytes")
    return memoryview(content)

"""LAS and LAZ point clouds, decoded block by block by laspy and lazrs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fidmap.maps.cloud import CHUNK_POINTS, Cloud, Points, read_cloud
from fidmap.maps.cursor import BrokenRecordError
from fidmap.maps.extras import need
from fidmap.maps.overrides import Overrides
from fidmap.maps.point_table import kept
from fidmap.model import Grid

MAGIC = b"LASF"


def read(path: Path, name: str, overrides: Overrides) -> Grid:
    """Read the points of a LAS or LAZ file as a map.

    Raises:
        MapFileError: as `read_cloud`.
        MissingLibraryError: the library for it is not installed.
        BrokenRecordError: a header or points that are not what they announce.
    """
    laspy = need("laspy", "pointcloud", "a LAS or LAZ file")
    _check_header(path)

    def blocks() -> Iterator[Points]:
        with _opened(laspy, path) as reader:
            for block in _guarded(reader.chunk_iterator(CHUNK_POINTS)):
                yield np.stack([np.asarray(block.x), np.asarray(block.y), np.asarray(block.z)]).T

    with _opened(laspy, path) as reader:
        count = int(reader.header.point_count)
    return read_cloud(Cloud(count, kept(blocks, count)), path, name, "las", overrides)


def _check_header(path: Path) -> None:
    """What laspy would take memory for before it looks whether it is there."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(375)
    if len(head) < 227:
        raise BrokenRecordError("its header is cut off")
    start = int.from_bytes(head[96:100], "little")
    records = int.from_bytes(head[100:104], "little")
    if start > size or records * 54 > size:
        raise BrokenRecordError(f"it announces {records:,} records before byte {start:,}, beyond its end")
    if head[25] >= 4 and len(head) >= 247 and int.from_bytes(head[243:247], "little") * 60 > size:
        raise BrokenRecordError("it announces more extended records than it can hold")


def _opened(laspy: Any, path: Path) -> Any:
    try:
        return laspy.open(path)
    except Exception as error:
        raise BrokenRecordError(f"laspy says: {error}") from None


def _guarded(blocks: Iterator[Any]) -> Iterator[Any]:
    """Blocks with the decoder's errors as one kind; panics of Rust are not even exceptions of Python."""
    while True:
        try:
            block = next(blocks)
        except StopIteration:
            return
        except (KeyboardInterrupt, MemoryError, GeneratorExit):
            raise
        except BaseException as error:
            raise BrokenRecordError(f"its points cannot be decoded ({error})") from None
        yield block

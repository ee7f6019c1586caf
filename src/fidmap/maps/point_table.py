"""Points as rows of a table, binary or text: the common half of PLY and PCD."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fidmap.maps.cloud import CHUNK_POINTS, Points
from fidmap.maps.cursor import BrokenRecordError
from fidmap.model import FloatArray

TEXT_BYTES = 16 << 20
KEPT_POINTS = 60_000_000


def binary_rows(path: Path, start: int, count: int, layout: np.dtype[np.void]) -> Iterator[Points]:
    """Blocks (n, 3) of the columns x, y and z of rows that begin at a byte.

    Raises:
        BrokenRecordError: fewer rows than announced.
    """
    if (held := (path.stat().st_size - start) // layout.itemsize) < count:
        raise BrokenRecordError(f"it announces {count:,} points where bytes for {max(0, held):,} are left")
    with path.open("rb") as file:
        file.seek(start)
        for done in range(0, count, CHUNK_POINTS):
            rows = np.fromfile(file, layout, min(CHUNK_POINTS, count - done))
            yield columns(rows)


def columns(rows: npt.NDArray[np.void]) -> Points:
    """x, y and z as (n, 3): float32 where the file has nothing finer."""
    kind = np.result_type(np.float32, *(rows.dtype[axis] for axis in "xyz"))
    points = np.empty((len(rows), 3), kind if kind == np.float32 else np.float64, order="F")
    for k, axis in enumerate("xyz"):
        points[:, k] = rows[axis]
    return points


def text_rows(path: Path, start: int, count: int, width: int, xyz: tuple[int, int, int]) -> Iterator[Points]:
    """Blocks (n, 3) of three columns of a table of numbers that begins at a byte.

    Raises:
        BrokenRecordError: words among the numbers, or fewer rows than announced.
    """
    done = 0
    with path.open("rb") as file:
        file.seek(start)
        rest = b""
        while done < count:
            block = file.read(TEXT_BYTES)
            text, _, rest = (rest + block).rpartition(b"\n") if block else (rest, b"", b"")
            if not block and not text.strip():
                raise BrokenRecordError(f"it announces {count:,} points where {done:,} are")
            if len(rest) > TEXT_BYTES:
                raise BrokenRecordError("it has a line without end")
            table = _numbers(text, width)[: count - done]
            done += len(table)
            yield np.asfortranarray(table[:, xyz])


def _numbers(text: bytes, width: int) -> npt.NDArray[np.float64]:
    """Numbers of whole lines as (n, width)."""
    if not text.strip():
        return np.empty((0, width))
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # numpy only warns of words among the numbers
        try:
            numbers = np.fromstring(text, float, sep=" ")
        except (ValueError, DeprecationWarning):
            raise BrokenRecordError("there are words among the numbers of its points") from None
    if len(numbers) % width:
        raise BrokenRecordError(f"its points do not have {width} numbers each, as the header says")
    return numbers.reshape(-1, width)


def kept(blocks: Callable[[], Iterator[Points]], count: int) -> Callable[[], Iterator[Points]]:
    """Blocks that are slow to decode, remembered for a second pass where they fit into memory.

    They are remembered as float32 from the first block's first point, exact to a tenth of a millimetre over 1 km.
    """
    if count > KEPT_POINTS:
        return blocks
    memory: list[tuple[FloatArray, npt.NDArray[np.float32]]] = []

    def again() -> Iterator[Points]:
        if memory:
            for base, offsets in memory:
                yield offsets + base
            return
        base = np.zeros(3)
        for block in blocks():
            if not memory and len(block):
                base = np.nan_to_num(block[0].astype(float), posinf=0, neginf=0)
            memory.append((base, np.asfortranarray(block - base, np.float32)))
            yield block

    return again

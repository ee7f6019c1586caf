"""Reading binary records that may lie: nothing is taken that is not there, and steps are counted."""

from __future__ import annotations

import struct
from typing import Any

MAX_STEPS = 2_000_000


class BrokenRecordError(Exception):
    """What is wrong with a record; readers turn it into a sentence about their file."""


class Cursor:
    """A place in bytes that moves forward only."""

    def __init__(self, data: bytes | memoryview, order: str = "<", at: int = 0) -> None:
        self.data = memoryview(data)
        self.order = order
        self.at = at

    @property
    def left(self) -> int:
        """Bytes after this place."""
        return len(self.data) - self.at

    def take(self, count: int) -> memoryview:
        """The next bytes.

        Raises:
            BrokenRecordError: there are fewer.
        """
        if not 0 <= count <= self.left:
            raise BrokenRecordError(f"a record announces {count} bytes where {max(0, self.left)} are left")
        self.at += count
        return self.data[self.at - count : self.at]

    def numbers(self, layout: str) -> tuple[Any, ...]:
        """The next numbers, laid out as `struct` names them."""
        form = struct.Struct(self.order + layout)
        return form.unpack(self.take(form.size))

    def number(self, layout: str) -> Any:
        """The next number."""
        return self.numbers(layout)[0]

    def block(self) -> memoryview:
        """Bytes behind their length in 32 bit."""
        return self.take(self.number("I"))

    def text(self) -> str:
        """Text behind its length in 32 bit."""
        return bytes(self.block()).decode("utf-8", "replace")

    def align(self, size: int, start: int = 0) -> None:
        """Go on to the next multiple of `size` bytes after `start`."""
        self.take(-(self.at - start) % size)


class Budget:
    """How many records may be looked at: a small file must not keep its reader busy for minutes."""

    def __init__(self, steps: int = MAX_STEPS) -> None:
        self.steps = steps

    def spend(self) -> None:
        """Count one record.

        Raises:
            BrokenRecordError: too many.
        """
        self.steps -= 1
        if self.steps < 0:
            raise BrokenRecordError(f"more than {MAX_STEPS:,} records would have to be looked at")

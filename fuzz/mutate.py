"""Small damage to files, the way broken disks, other programs and bad intentions do it."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Literal

import numpy as np

Random = np.random.Generator
NUMBERS = (0, 1, 2, 7, 127, 128, 255, 256, 32767, 65535, 65536, 2**24, 2**31 - 1, 2**31, 2**32 - 1, 2**40, 2**63 - 1,
           2**64 - 1)  # fmt: skip
WORDS = (b"nan", b"inf", b"-inf", b"-1", b"0", b"1e308", b"1e-308", b"99999999999999999999", b"4294967296", b"", b"[",
         b"{", b"&a", b"*a", b"\0", b"\n", b"../../../../etc/passwd", b"%n", b"\xff\xfe", b"1,2,3", b"<!ENTITY a 'b'>",
         b"[[[[[[[[[[[[[[[[[[[[[[[[", b"{\"a\":" * 30)  # fmt: skip
TEXT_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


def mutated(data: bytes, others: list[bytes], rng: Random) -> bytes:
    """A damaged copy: mostly one or two faults, now and then many."""
    for _ in range(1 + int(rng.geometric(0.5))):
        damage = DAMAGES[rng.integers(len(DAMAGES))]
        data = damage(data, others, rng)
    return data[:4_000_000]


def _place(data: bytes, rng: Random) -> int:
    """A place in the data; headers are hit more often than what follows."""
    if not data:
        return 0
    end = min(len(data), int(rng.choice([64, 512, 4096, len(data)])))
    return int(rng.integers(end))


def _flip(data: bytes, _: list[bytes], rng: Random) -> bytes:
    if not data:
        return data
    at = _place(data, rng)
    return data[:at] + bytes([data[at] ^ (1 << int(rng.integers(8)))]) + data[at + 1 :]


def _number(data: bytes, _: list[bytes], rng: Random) -> bytes:
    """A number where one may stand, in either order of bytes."""
    size = int(rng.choice([1, 2, 4, 8]))
    top: int = 256**size
    value = NUMBERS[rng.integers(len(NUMBERS))] % top
    at = _place(data, rng)
    order: Literal["little", "big"] = "little" if rng.random() < 0.5 else "big"
    return data[:at] + value.to_bytes(size, order) + data[at + size :]


def _shifted_number(data: bytes, _: list[bytes], rng: Random) -> bytes:
    """A number that is there, a little larger or smaller, or many times larger."""
    size = int(rng.choice([1, 2, 4, 8]))
    at = _place(data, rng)
    value = int.from_bytes(data[at : at + size], "little")
    changed = value + int(rng.integers(-3, 4)) if rng.random() < 0.5 else value * int(rng.choice([2, 16, 1000]))
    top: int = 256**size
    return data[:at] + (changed % top).to_bytes(size, "little") + data[at + size :]


def _cut(data: bytes, _: list[bytes], rng: Random) -> bytes:
    return data[: int(rng.integers(len(data) + 1))]


def _removed(data: bytes, _: list[bytes], rng: Random) -> bytes:
    at = _place(data, rng)
    return data[:at] + data[at + int(rng.choice([1, 2, 4, 16, 256])) :]


def _repeated(data: bytes, _: list[bytes], rng: Random) -> bytes:
    at = _place(data, rng)
    piece = data[at : at + int(rng.choice([1, 4, 16, 256, 4096]))]
    times = min(int(rng.choice([1, 2, 10, 1000])), 200_000 // max(1, len(piece)))
    return data[:at] + piece * times + data[at:]


def _inserted(data: bytes, _: list[bytes], rng: Random) -> bytes:
    at = _place(data, rng)
    return data[:at] + rng.bytes(int(rng.choice([1, 4, 64]))) + data[at:]


def _word(data: bytes, _: list[bytes], rng: Random) -> bytes:
    at = _place(data, rng)
    word = WORDS[rng.integers(len(WORDS))]
    return data[:at] + word + data[at + (len(word) if rng.random() < 0.5 else 0) :]


def _text_number(data: bytes, _: list[bytes], rng: Random) -> bytes:
    """Another number or word in place of one that is written in digits."""
    found = [match.span() for match in TEXT_NUMBER.finditer(data[:20_000])]
    if not found:
        return data
    start, end = found[rng.integers(len(found))]
    return data[:start] + WORDS[rng.integers(9)] + data[end:]


def _line(data: bytes, _: list[bytes], rng: Random) -> bytes:
    """A line left out, doubled, or exchanged with another."""
    lines = data.splitlines(keepends=True)
    if not 1 < len(lines) < 10_000:
        return data
    a, b = rng.integers(len(lines), size=2)
    match rng.integers(3):
        case 0:
            del lines[a]
        case 1:
            lines.insert(b, lines[a])
        case _:
            lines[a], lines[b] = lines[b], lines[a]
    return b"".join(lines)


def _spliced(data: bytes, others: list[bytes], rng: Random) -> bytes:
    """The beginning of this file and the end of another."""
    other = others[rng.integers(len(others))]
    return data[: _place(data, rng)] + other[_place(other, rng) :]


DAMAGES: tuple[Callable[[bytes, list[bytes], Random], bytes], ...] = (
    _flip, _flip, _number, _number, _shifted_number, _cut, _removed, _repeated, _inserted, _word, _text_number,
    _text_number, _line, _spliced,
)  # fmt: skip

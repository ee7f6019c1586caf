"""PBM, PGM and PPM (P1 to P6), as the netpbm specification describes them.

Decoded here: Pillow leaves plain files and depths other than 8 and 16 bit to loops over single samples, which
take many seconds for a large map.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fidmap.maps.files import check_size, fault
from fidmap.maps.tables import look_up

Samples = npt.NDArray[np.unsignedinteger[Any]]

_MAGIC = re.compile(rb"P[1-6](?=[\s#])")
_NUMBER = re.compile(rb"(?:\s|#[^\r\n]*[\r\n])*([0-9]{1,9})(?![0-9])")
_COMMENT = re.compile(rb"#[^\r\n]*")
_SPACE = b" \t\r\n\v\f"
_SPACES = tuple(bytes([code]) for code in _SPACE)
_PIECE_BYTES = 1 << 20


@dataclass(frozen=True)
class Header:
    """What stands before the samples; `start` is the offset of the first one."""

    kind: int
    width: int
    height: int
    maxval: int
    start: int

    @property
    def plain(self) -> bool:
        """Whether the samples are decimal text."""
        return self.kind <= 3

    @property
    def channels(self) -> int:
        """Samples per pixel."""
        return 3 if self.kind in {3, 6} else 1

    @property
    def samples(self) -> int:
        """Samples of the whole image."""
        return self.width * self.height * self.channels


def is_netpbm(data: bytes) -> bool:
    """Whether the magic number is one of P1 to P6."""
    return _MAGIC.match(data) is not None


def decode(data: bytes, subject: object) -> Samples:
    """Decode the first image of a file: (H, W) uint8 for grey, (H, W, 3) uint8 or uint16 for colour.

    Samples are stretched to 16 bit, half up, and grey ones then reduced to floor(v / 257), which is exact for
    the usual depths: the value itself at maxval 255, floor(v / 257) at 65535. Values over maxval count as it.

    Raises:
        MapFileError: a broken header, too many cells, or fewer samples than announced.
    """
    header = read_header(data, subject)
    check_size(header.width, header.height, subject)
    if header.kind in {1, 4}:
        return _bits(data, header, subject)
    raw = _plain_samples(data, header, subject) if header.plain else _raw_samples(data, header, subject)
    shape = (header.height, header.width, 3) if header.channels == 3 else (header.height, header.width)
    if header.maxval == 255 and raw.dtype == np.uint8:
        return raw.reshape(shape)
    return look_up(_levels(header, 65536 if raw.itemsize > 1 else 256), raw.reshape(shape))


def read_header(data: bytes, subject: object) -> Header:
    """Read magic number, width, height and maxval, with comments anywhere between them.

    Raises:
        MapFileError: a number is missing, or maxval is outside of 1 to 65535.
    """
    kind, at, numbers = data[1] - ord("0"), 2, []
    for _ in range(2 if kind in {1, 4} else 3):
        match = _NUMBER.match(data, at)
        if match is None:
            raise fault(subject, f"has a broken P{kind} header; expected width, height and maximum as numbers")
        numbers.append(int(match[1]))
        at = match.end()
    width, height, maxval = (*numbers, 1)[:3]
    if not 1 <= maxval <= 65535:
        raise fault(subject, f"announces a maximum grey of {maxval}; expected 1 to 65535, so save it again")
    return Header(kind, width, height, maxval, at + 1)


def _levels(header: Header, entries: int) -> Samples:
    """Lookup table from a sample to 16 bit for colour, to 8 bit for grey."""
    value = np.minimum(np.arange(entries, dtype=np.int64), header.maxval)
    wide = (2 * 65535 * value + header.maxval) // (2 * header.maxval)
    return wide.astype(np.uint16) if header.channels == 3 else (wide // 257).astype(np.uint8)


def _truncated(subject: object, header: Header, found: int, wanted: int) -> Exception:
    return fault(
        subject,
        f"is truncated: {header.width} x {header.height} cells need {wanted} values or bytes, {found} are "
        "there; copy or save the map again",
    )


def _raw_samples(data: bytes, header: Header, subject: object) -> Samples:
    """Binary samples, one byte each up to maxval 255, else two, the most significant first."""
    wanted = header.samples * (2 if header.maxval > 255 else 1)
    if (found := max(0, len(data) - header.start)) < wanted:
        raise _truncated(subject, header, found, wanted)
    if header.maxval > 255:
        return np.frombuffer(data, ">u2", header.samples, header.start).astype(np.uint16)
    return np.frombuffer(data, np.uint8, header.samples, header.start)


def _pieces(data: bytes, header: Header, allowed: bytes, subject: object) -> Iterator[bytes]:
    """The samples' text of a plain file, in pieces that end at space and without comments.

    Raises:
        MapFileError: there is something else than numbers.
    """
    commented = data.find(b"#", header.start - 1) >= 0
    text = _COMMENT.sub(b" ", data[header.start - 1 :]) if commented else data
    at = 0 if commented else header.start - 1
    while at < len(text):
        piece = text[at : at + _PIECE_BYTES]
        if at + len(piece) < len(text):
            piece = piece[: 1 + max(piece.rfind(space) for space in _SPACES)]
        if not piece or piece.translate(None, allowed + _SPACE):
            raise fault(
                subject, f"is a P{header.kind} file with text among its numbers; expected numbers, so save it again"
            )
        yield piece
        at += len(piece)


def _plain_samples(data: bytes, header: Header, subject: object) -> Samples:
    """Decimal samples; numpy's own parser, because a Python loop takes seconds for a large map."""
    # Two characters hold at most one sample: without this a tiny file could ask for gigabytes.
    most = header.samples if len(data) - header.start + 2 >= 2 * header.samples else 0
    wide = header.maxval > 255
    samples: Samples = np.empty(most, np.uint16 if wide else np.uint8)
    found = 0
    for piece in _pieces(data, header, b"0123456789", subject):
        numbers = np.fromstring(piece, np.uint32, sep=" ") if piece.strip() else np.empty(0, np.uint32)
        part = numbers[: max(0, most - found)]
        samples[found : found + len(part)] = np.minimum(part, 65535 if wide else 255)
        found += len(numbers)
    if found < header.samples:
        raise _truncated(subject, header, found, header.samples)
    return samples


def _bits(data: bytes, header: Header, subject: object) -> npt.NDArray[np.uint8]:
    """A bitmap: 1 is black (0), 0 is white (255); rows of a binary one are padded to whole bytes."""
    shape = (header.height, header.width)
    if header.plain:
        digits = b"".join(piece.translate(None, _SPACE) for piece in _pieces(data, header, b"01", subject))
        if len(digits) < header.samples:
            raise _truncated(subject, header, len(digits), header.samples)
        ones = np.frombuffer(digits, np.uint8, header.samples).reshape(shape) == ord("1")
        return np.where(ones, np.uint8(0), np.uint8(255))
    per_row = (header.width + 7) // 8
    wanted = per_row * header.height
    if (found := max(0, len(data) - header.start)) < wanted:
        raise _truncated(subject, header, found, wanted)
    rows = np.frombuffer(data, np.uint8, wanted, header.start).reshape(header.height, per_row)
    return np.unpackbits(rows, axis=1, count=header.width) * np.uint8(255) ^ np.uint8(255)

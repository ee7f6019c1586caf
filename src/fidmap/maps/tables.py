"""Lookup tables over whole maps, block by block: numpy would make all indices 64-bit integers at once."""

from __future__ import annotations

from typing import Any, TypeVar

import cv2
import numpy as np
import numpy.typing as npt

Entry = TypeVar("Entry", bound=np.generic)

_BLOCK_ROWS = 64


def look_up(table: npt.NDArray[Entry], codes: npt.NDArray[np.unsignedinteger[Any]]) -> npt.NDArray[Entry]:
    """table[codes] for codes (H, W) or (H, W, C), C-contiguous; larger codes count as the last entry."""
    out: npt.NDArray[Entry] = np.empty(codes.shape, table.dtype)
    if codes.dtype == np.uint8 and table.dtype in {np.dtype(np.uint8), np.dtype(np.float32)}:
        _look_up_bytes(table, codes.reshape(len(codes), -1), out.reshape(len(codes), -1))
        return out
    for top in range(0, len(codes), _BLOCK_ROWS):
        table.take(codes[top : top + _BLOCK_ROWS], out=out[top : top + _BLOCK_ROWS], mode="clip")
    return out


def _look_up_bytes(table: npt.NDArray[Any], codes: npt.NDArray[np.unsignedinteger[Any]], out: npt.NDArray[Any]) -> None:
    """The same for bytes (H, W): OpenCV is nearly twice as quick as numpy, which widens its indices."""
    entries = table.take(np.arange(256), mode="clip")
    for top in range(0, len(codes), _BLOCK_ROWS):
        block = np.ascontiguousarray(codes[top : top + _BLOCK_ROWS])  # rows may stand upside down
        cv2.LUT(block, entries, dst=out[top : top + _BLOCK_ROWS])


def histogram(
    codes: npt.NDArray[np.unsignedinteger[Any]], left_out: npt.NDArray[np.bool_] | None
) -> npt.NDArray[np.int64]:
    """How often each of the 256 codes occurs in (H, W), without the cells left out."""
    counts = np.zeros(256, np.int64)
    for top in range(0, len(codes), _BLOCK_ROWS):
        block = np.ascontiguousarray(codes[top : top + _BLOCK_ROWS])
        seen = None if left_out is None else (~left_out[top : top + _BLOCK_ROWS]).view(np.uint8)
        # twice as quick as bincount, which widens its input; its float32 counts are exact for so few rows
        counts += cv2.calcHist([block], [0], seen, [256], [0, 256]).ravel().astype(np.int64)
    return counts

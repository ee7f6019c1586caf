"""OctoMap's `.bt` and `.ot` as maps: free and unknown are known here, seen from above through the slab."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fidmap.maps.cursor import BrokenRecordError
from fidmap.maps.files import fault, read_bytes
from fidmap.maps.floor import find_floor
from fidmap.maps.octree_file import Leaves, binary_leaves, full_leaves
from fidmap.maps.overrides import Overrides, is_resolution
from fidmap.maps.slab import MAX_SLAB_CELLS, slab_grid, slab_of
from fidmap.model import FloatArray, Grid

BINARY = b"# Octomap OcTree binary file"
MAX_BYTES = 400_000_000
SAMPLE = 50_000
Square = tuple[npt.NDArray[np.int32], npt.NDArray[np.int32], int]  # column and row of the lower left, side


def read(path: Path, name: str, overrides: Overrides) -> Grid:
    """Read an octree as a map; z is up, as OctoMap has it, and a cell is as large as the tree's smallest cube.

    Raises:
        MapFileError: nothing is occupied, the map is too large, or `--up` names another axis.
        BrokenRecordError: a header or a tree that is not what it announces.
    """
    if overrides.up not in {None, "z"}:
        raise fault(name, f"is an octree, whose z is up; it cannot be read with --up {overrides.up}")
    data = read_bytes(path, name, MAX_BYTES, "an octree")
    kind, resolution, start = _header(data)
    resolution = overrides.resolution_m or resolution
    body = data[start:]
    leaves = list(binary_leaves(body) if data.startswith(BINARY) else full_leaves(body, kind))
    centres = _occupied_centres(leaves) * resolution
    if not len(centres):
        raise fault(name, "holds nothing occupied; expected the walls of a map, so save it again")
    floor = find_floor(centres[:: max(1, len(centres) // SAMPLE)], "z")
    low, high = (floor.height_m + height for height in slab_of(overrides))
    squares = {mine: list(_cut(leaves, mine, low / resolution, high / resolution)) for mine in (True, False)}
    corner, shape = _frame(squares[True], squares[False], name)
    occupancy = np.full(shape, np.nan, np.float32)
    occupancy[_painted(squares[False], corner, shape)] = 0
    occupancy[_painted(squares[True], corner, shape)] = 1
    place = float(corner[0] * resolution), float(corner[1] * resolution)
    return slab_grid(occupancy, resolution, place, floor, (path, name, "octomap"), overrides)


def _header(data: bytes) -> tuple[str, float, int]:
    """Kind of tree, side of its smallest cube, and where the tree begins."""
    words: dict[str, str] = {}
    at = 0
    for _ in range(100):
        end = data.find(b"\n", at, at + 1000)
        if end < 0:
            break
        line = data[at:end].decode("latin-1").strip()
        at = end + 1
        if line == "data":
            return words.get("id", "OcTree"), _resolution(words.get("res", "")), at
        if not line.startswith("#"):
            key, _, value = line.partition(" ")
            words[key] = value
    raise BrokenRecordError("its header does not end with `data`")


def _resolution(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not is_resolution(value):
        raise BrokenRecordError(f"its resolution `res` is {text[:20]!r}")
    return value


def _occupied_centres(leaves: Sequence[Leaves]) -> FloatArray:
    """(N, 3) in cells."""
    parts = [group.corner[group.occupied] + group.side / 2 for group in leaves]
    return np.concatenate(parts) if parts else np.empty((0, 3))


def _cut(leaves: Sequence[Leaves], occupied: bool, low: float, high: float) -> Iterator[Square]:
    """The leaves of one kind that reach into the slab by half a cell or more, from above; heights in cells."""
    for group in leaves:
        bottom = group.corner[:, 2]
        inside = np.minimum(bottom + group.side, high) - np.maximum(bottom, low) >= 0.5
        mine = inside & (group.occupied == occupied)
        if mine.any():
            yield group.corner[mine, 0], group.corner[mine, 1], group.side


def _frame(walls: list[Square], free: list[Square], name: str) -> tuple[tuple[int, int], tuple[int, int]]:
    """Lower-left cell (column, row) and shape: of all, or of the occupied cells where free space reaches too far."""
    for squares in (walls + free, walls):
        if not squares:
            continue
        columns = min(int(c.min()) for c, _, _ in squares), max(int(c.max()) + side for c, _, side in squares)
        rows = min(int(r.min()) for _, r, _ in squares), max(int(r.max()) + side for _, r, side in squares)
        shape = rows[1] - rows[0], columns[1] - columns[0]
        if shape[0] * shape[1] <= MAX_SLAB_CELLS:
            return (columns[0], rows[0]), shape
    if not walls + free:
        raise fault(name, "holds nothing at the height of the slab; choose another one with --slab LOW_M,HIGH_M")
    raise fault(
        name,
        f"covers {shape[1]:,} x {shape[0]:,} cells; at most {MAX_SLAB_CELLS // 1_000_000} million are read, so crop it",
    )


def _painted(squares: list[Square], corner: tuple[int, int], shape: tuple[int, int]) -> npt.NDArray[np.bool_]:
    """Where any square lies: ones at its corners, summed up along both axes."""
    steps = np.zeros((shape[0] + 1, shape[1] + 1), np.int32)
    for columns, rows, side in squares:
        left, right = (np.clip(columns - corner[0] + d, 0, shape[1]) for d in (0, side))
        lower, upper = (np.clip(rows - corner[1] + d, 0, shape[0]) for d in (0, side))
        for row, column, sign in ((lower, left, 1), (lower, right, -1), (upper, left, -1), (upper, right, 1)):
            np.add.at(steps, (row, column), np.int32(sign))
    return np.asarray(steps.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] > 0)

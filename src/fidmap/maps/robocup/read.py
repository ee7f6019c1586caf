"""A rescue map to a grid: classify colours, find the scale, recover the cells, restore what was drawn over."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np
import numpy.typing as npt
from PIL.Image import Resampling

from fidmap.maps.files import fault
from fidmap.maps.georeference import Georeference
from fidmap.maps.images import Picture, strips
from fidmap.maps.overrides import Overrides
from fidmap.maps.robocup.cells import COVERED, Enlargement, enlargement, to_cells
from fidmap.maps.robocup.palette import DESCRIPTION_TAG, FACTOR, OURS, Kind, kinds_of, looks_like_one
from fidmap.maps.robocup.restore import restored
from fidmap.maps.robocup.scale import pixels_per_metre
from fidmap.maps.tables import look_up
from fidmap.model import Finding, Grid, Label, Pose2, Source

Bytes = npt.NDArray[np.uint8]
SAMPLE = 300_000
_BLOCK_ROWS = 64
_COLOURED = {"P", "RGB", "RGBA", "RGBX", "CMYK", "YCbCr"}
_OCCUPANCY = np.array([0, np.nan, 1], np.float32)


def is_rescue_map(picture: Picture) -> bool:
    """Whether a picture is in the colours of rescue maps, from a sample of its pixels."""
    if _is_ours(picture):
        return True
    if picture.image is not None and picture.image.mode in _COLOURED:
        width, height = picture.image.size
        stride = max(1, math.isqrt(width * height // SAMPLE))
        size = (max(1, width // stride), max(1, height // stride))
        some = picture.image.resize(size, Resampling.NEAREST)
        sample = np.asarray(some.convert("RGB")).reshape(-1, 3)
    elif picture.samples is not None and picture.samples.ndim == 3 and picture.samples.dtype == np.uint8:
        stride = max(1, math.isqrt(picture.samples[..., 0].size // SAMPLE))
        sample = picture.samples[stride // 2 :: stride, stride // 2 :: stride].astype(np.uint8).reshape(-1, 3)
    else:
        return False
    return looks_like_one(kinds_of(sample), sample)


def _is_ours(picture: Picture) -> bool:
    """Whether `fidmap convert` wrote it."""
    tags = getattr(picture.image, "tag_v2", None) or {}
    if picture.image is None or picture.image.mode not in _COLOURED or tags.get(DESCRIPTION_TAG) != OURS:
        return False  # somebody else's, or ours after another program saved it in greys
    return picture.image.width % FACTOR == picture.image.height % FACTOR == 0


@dataclass(frozen=True, eq=False)
class Drawn:
    """A recognised picture: (H, W) of `Kind`, and of greens where the two tiles have to be told apart.

    ours: `fidmap convert` wrote it, so how far it was enlarged is known.
    """

    kinds: Bytes
    green: Bytes | None
    jpeg: bool
    ours: bool


def recognised(picture: Picture, scaled: bool) -> Drawn | None:
    """What a picture in the colours of rescue maps shows, None for any other; `scaled`: its scale is known."""
    if not is_rescue_map(picture):
        return None
    image = picture.image
    if image is not None and image.mode == "P":
        palette = np.zeros((256, 3), np.uint8)
        entries = np.frombuffer(bytes(image.getpalette("RGB") or []), np.uint8).reshape(-1, 3)[:256]
        palette[: len(entries)] = entries
        index = np.asarray(image)
        green = None if scaled else look_up(np.ascontiguousarray(palette[:, 1]), index)
        return Drawn(look_up(kinds_of(palette), index), green, picture.format == "JPEG", _is_ours(picture))
    kinds = np.empty(picture.shape, np.uint8)
    green = None if scaled else np.empty(picture.shape, np.uint8)
    for rows, colours in _colours(picture):
        kinds[rows] = kinds_of(colours)
        if green is not None:
            green[rows] = colours[..., 1]
    return Drawn(kinds, green, picture.format == "JPEG", _is_ours(picture))


def _colours(picture: Picture) -> Iterator[tuple[slice, Bytes]]:
    """Blocks of rows (n, W, 3 or more) of a picture in colours without a palette."""
    image, samples = picture.image, picture.samples
    if image is not None:
        yield from strips(image if image.mode.startswith("RGB") else image.convert("RGB"))
        return
    assert samples is not None, "a picture has an image or samples"
    for top in range(0, len(samples), _BLOCK_ROWS):
        yield slice(top, top + _BLOCK_ROWS), samples[top : top + _BLOCK_ROWS].astype(np.uint8, copy=False)


def read(drawn: Drawn, place: Georeference | None, overrides: Overrides, source: Source) -> Grid:
    """The grid of a recognised picture.

    Raises:
        MapFileError: neither tags nor world file nor drawn scale say how large a cell is.
    """
    kinds = drawn.kinds
    if drawn.jpeg:
        _settle_bars(kinds)
    metre = None if drawn.green is None else pixels_per_metre(kinds, drawn.green)
    if place is None and overrides.resolution_m is None and metre is None:
        raise fault(
            source.name,
            "is in the colours of a rescue map, but has neither GeoTIFF tags nor a world file nor a scale bar; give "
            "the side of a cell with --resolution M_PER_CELL",
        )
    _settle_margin(kinds)
    kinds[kinds == Kind.BAR] = Kind.OVER
    scale = _enlarged(drawn, place)
    pixel_m = place.pixel_m if place else 1 / metre if metre else 0.0
    resolution_m = overrides.resolution_m or pixel_m * scale.factor
    cells = to_cells(kinds, scale)
    findings = _findings(cells, scale, place, metre)
    labels = restored(cells, resolution_m)
    upright, pose = _placed(labels, scale, place)
    origin = overrides.corner(overrides.origin or pose, resolution_m)
    occupancy = look_up(_OCCUPANCY, np.ascontiguousarray(upright))
    return Grid(occupancy, resolution_m, origin, source=replace(source, findings=findings))


def _enlarged(drawn: Drawn, place: Georeference | None) -> Enlargement:
    """Pixels per cell, known of what is written here and of crosbot's pictures, else measured."""
    if drawn.ours:
        return Enlargement(FACTOR)
    if place is not None and place.source == "world file, y upwards":
        return Enlargement()
    return enlargement(drawn.kinds, 0.75 if drawn.jpeg else 0.9)


def _settle_bars(kinds: Bytes) -> None:
    """JPEG cannot tell walls from the scale bar by single pixels: what hangs together is all wall or all bar."""
    dark = (kinds == Kind.WALL) | (kinds == Kind.BAR)
    count, parts = cv2.connectedComponents(dark.view(np.uint8), connectivity=8, ltype=cv2.CV_32S)
    places = np.flatnonzero(dark)  # few: masks would be walked through each time
    part, flat = parts.ravel()[places], kinds.reshape(-1)
    del parts, dark
    bars = np.bincount(part[flat[places] == Kind.BAR], minlength=count)
    kind = np.where(2 * bars > np.bincount(part, minlength=count), np.uint8(Kind.BAR), np.uint8(Kind.WALL))
    flat[places] = kind[part]


def _settle_margin(kinds: Bytes) -> None:
    """Grey that hangs together with the picture's rim is margin, so unknown; elsewhere it is free space."""
    grey = kinds == Kind.GREY
    if not grey.any():
        return
    padded = np.pad(grey, 1, constant_values=True).view(np.uint8)
    cv2.floodFill(padded, None, (0, 0), 2)
    kinds[grey] = np.where(padded[1:-1, 1:-1][grey] == 2, np.uint8(Kind.UNKNOWN), np.uint8(Kind.FREE))


def _placed(labels: Bytes, scale: Enlargement, place: Georeference | None) -> tuple[Bytes, Pose2]:
    """Labels with row 0 lowest and the pose of their corner: +x up the picture where it was drawn so.

    hector's world file has east = -y and north = x, and names a place one pixel beyond the corner where the format
    says half a pixel within it.
    """
    h, w, k = *labels.shape, scale.factor
    low, right = scale.top + h * k, scale.left + w * k
    if place is None:
        return labels[::-1], Pose2()
    if place.source == "world file":
        corner = replace(place, east_m=place.east_m + 1.5 * place.pixel_m, north_m=place.north_m - 1.5 * place.pixel_m)
        east, north = corner.at(right, low)
        return labels[::-1, ::-1].T, Pose2(north, -east, place.yaw)
    if place.source == "tags" and abs(place.yaw) > 1e-9:
        return labels[::-1, ::-1].T, Pose2(*place.at(right, low), _turned(place.yaw + math.pi / 2))
    return labels[::-1], place.pose(scale.left, low)


def _turned(angle: float) -> float:
    """An angle in (-pi, pi], without the noise of a quarter turn there and back."""
    wrapped = math.remainder(angle, 2 * math.pi)
    return 0.0 if abs(wrapped) < 1e-12 else wrapped


def _findings(cells: Bytes, scale: Enlargement, place: Georeference | None, metre: float | None) -> tuple[Finding, ...]:
    """What was done to the picture, and what to check."""
    covered = float((cells == COVERED).mean())
    k = f" from {scale.factor} x {scale.factor} pixels per cell" if scale.factor > 1 else ""
    text = f"read by the colours of rescue maps{k}"
    if covered:
        text += f"; {covered:.1%} of the cells are drawn over (marks, path, text) and were filled from around them"
    found = [Finding("note", "robocup-colours", text)]
    if metre is not None:
        text = (
            f"the scale was measured in the picture ({metre:.1f} pixels per metre) and is as exact as that drawing: "
            "give the side of a cell where it is known, since a wrong scale shifts all distances"
        )
        found.append(Finding("note", "scale-from-picture", text, "--resolution M_PER_CELL"))
    if place is not None and place.source == "world file, y upwards":
        text = "the world file's fourth line is positive though rows run down; it was read as running down"
        found.append(Finding("note", "world-file-upwards", text))
    if not (cells == Label.OCCUPIED).any():
        text = "no cell is occupied, so no barrel part can be found and the coverage is 0"
        found.append(Finding("warning", "nothing-occupied", text))
    return tuple(found)

"""The formats of `./run bench formats`: how each is written here, and its library's own way to decode it.

A new format adds its rows to `ROWS`; nothing else in the benchmark knows any format.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from benchmarks.foreign_rows import FOREIGN_ROWS
from benchmarks.robocup_picture import clean_picture, marked_picture
from benchmarks.rows import Row
from fidmap.maps.robocup.palette import FACTOR
from fidmap.maps.robocup.write import write_geotiff
from fidmap.maps.write import greys, write_map
from fidmap.model import Grid


def pillow(path: Path) -> int:
    """Bytes of the image beside a YAML, or of an image, as Pillow decodes it."""
    file = next(p for p in sorted(path.parent.glob(f"{path.stem}.*")) if p.suffix not in {".yaml", ".tfw"})
    with Image.open(file) as image:
        return int(np.asarray(image).nbytes)


def _pgm(folder: Path, grid: Grid) -> Path:
    return write_map(folder, "pgm", grid)


def _plain_pgm(folder: Path, grid: Grid) -> Path:
    path = write_map(folder, "plain", grid)
    grey = greys(grid)[::-1]
    lines = "\n".join(" ".join(map(str, row)) for row in grey.tolist())
    (folder / "plain.pgm").write_text(f"P2\n{grey.shape[1]} {grey.shape[0]}\n255\n{lines}\n")
    return path


def _with_image(name: str, suffix: str, convert: Callable[[Image.Image], Image.Image]) -> Callable[[Path, Grid], Path]:
    """A map_server YAML whose image is of another kind."""

    def write(folder: Path, grid: Grid) -> Path:
        path = write_map(folder, name, grid)
        (folder / f"{name}.pgm").unlink()
        path.write_text(path.read_text().replace(f"{name}.pgm", f"{name}.{suffix}"))
        options: dict[str, Any] = {"quality": 90} if suffix == "jpg" else {}
        convert(Image.fromarray(np.ascontiguousarray(greys(grid)[::-1]))).save(folder / f"{name}.{suffix}", **options)
        return path

    return write


def _wide(image: Image.Image) -> Image.Image:
    return Image.fromarray(np.asarray(image).astype(np.uint16) * 257)


def _geotiff(folder: Path, grid: Grid) -> Path:
    write_geotiff(folder / "geotiff.tif", grid)
    return folder / "geotiff.tif"


def _picture(draw: Callable[[Grid], Any], name: str, **options: object) -> Callable[[Path, Grid], Path]:
    """A rescue map without tags: its scale is measured in the picture."""

    def write(folder: Path, grid: Grid) -> Path:
        Image.fromarray(draw(grid)).save(folder / name, **options)  # type: ignore[arg-type]
        return folder / name

    return write


ROWS = (
    Row("map_server, PGM", _pgm, pillow),
    Row("map_server, ASCII PGM", _plain_pgm, pillow),
    Row("map_server, PNG", _with_image("png", "png", lambda image: image), pillow),
    Row("map_server, PNG with palette", _with_image("palette", "png", lambda image: image.convert("P")), pillow),
    Row("map_server, PNG with alpha", _with_image("alpha", "png", lambda image: image.convert("RGBA")), pillow),
    Row("map_server, PNG of 16 bit", _with_image("wide", "png", _wide), pillow),
    Row("map_server, BMP", _with_image("bmp", "bmp", lambda image: image), pillow),
    Row("map_server, JPEG", _with_image("jpg", "jpg", lambda image: image), pillow),
    Row("RoboCup GeoTIFF", _geotiff, pillow, across=FACTOR),
    Row("RoboCup PNG", _picture(clean_picture, "clean.png"), pillow, across=FACTOR),
    Row("RoboCup PNG, 12 victims and other marks", _picture(marked_picture, "marks.png"), pillow, across=FACTOR),
    Row("RoboCup JPEG, the same", _picture(marked_picture, "marks.jpg", quality=85), pillow, across=FACTOR),
    *FOREIGN_ROWS,
)

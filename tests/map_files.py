"""Small map files for tests, written by hand into a folder."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from fidmap.maps import read_map
from fidmap.model import MapFileError

YAML = {
    "image": "map.png",
    "resolution": "0.05",
    "origin": "[0, 0, 0]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}


def write_yaml(folder: Path, name: str = "map.yaml", **changed: str | None) -> Path:
    """A valid YAML with some keys changed, or left out where they are None."""
    keys = {**YAML, **changed}
    path = folder / name
    path.write_text("".join(f"{key}: {value}\n" for key, value in keys.items() if value is not None))
    return path


def write_map(folder: Path, pixels: object, image: str = "map.png", **changed: str | None) -> Path:
    """An image of these pixels (row 0 on top) and the YAML that names it."""
    array = np.asarray(pixels)
    Image.fromarray(array.astype(np.uint8) if array.dtype != np.uint16 else array).save(folder / image)
    return write_yaml(folder, image=image, **changed)


def write_pgm(folder: Path, pixels: object, name: str = "map.pgm") -> Path:
    """A binary PGM without any YAML."""
    array = np.asarray(pixels, np.uint8)
    path = folder / name
    path.write_bytes(b"P5\n%d %d\n255\n" % (array.shape[1], array.shape[0]) + array.tobytes())
    return path


def sentence(path: str | Path, **options: object) -> str:
    """The text of the error that reading ends in, which has to be one line."""
    with pytest.raises(MapFileError) as caught:
        read_map(path, **options)
    assert caught.value.code == "map-file"
    assert "\n" not in str(caught.value)
    return str(caught.value)

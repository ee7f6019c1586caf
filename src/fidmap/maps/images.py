"""Image files as grey values, the way nav2_map_server sees them; the only place that knows pixels.

Pillow decodes PNG, BMP, JPEG and TIFF (OpenCV's imread misreads some PGM files). The decoders are
called directly, not by `Image.open`: only the formats named here, by content, under our own bound on size.
"""

from __future__ import annotations

import io
import logging
import os
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from PIL import BmpImagePlugin, Image, ImageFile, JpegImagePlugin, PngImagePlugin, TiffImagePlugin

from fidmap.maps import netpbm
from fidmap.maps.files import check_size, fault
from fidmap.maps.tables import look_up
from fidmap.model import MapFileError

# what is wrong with a file is told in our own sentence, not in a line of Pillow's before it
logging.getLogger("PIL").addHandler(logging.NullHandler())

Bytes = npt.NDArray[np.uint8]

_DECODERS: dict[bytes, tuple[str, type[ImageFile.ImageFile]]] = {
    b"\x89PNG\r\n\x1a\n": ("PNG", PngImagePlugin.PngImageFile),
    b"\xff\xd8\xff": ("JPEG", JpegImagePlugin.JpegImageFile),
    b"BM": ("BMP", BmpImagePlugin.BmpImageFile),
    b"II*\0": ("TIFF", TiffImagePlugin.TiffImageFile),
    b"MM\0*": ("TIFF", TiffImagePlugin.TiffImageFile),
}
_MODES = {"1", "L", "LA", "I;16", "I;16B", "P", "PA", "RGB", "RGBA", "RGBX", "CMYK", "YCbCr"}
_BLOCK_ROWS = 64
_FEW_ROWS = 16  # whose sums stay in the processor's cache
MOST_PIXELS_PER_BYTE = 512  # of a JPEG: at least one bit for each block of 8 x 8
Channels = Literal["brightness", "mean", "mean-with-alpha"]


@dataclass(frozen=True, eq=False)
class Raster:
    """A decoded image, row 0 at the top, and where it is not opaque (None: nowhere).

    grey: (H, W) uint8; where a mean of several channels was asked for, uint16 with the sum of `parts` of them.
    """

    grey: Bytes | npt.NDArray[np.uint16]
    transparent: npt.NDArray[np.bool_] | None = None
    parts: int = 1


def is_image(data: bytes) -> bool:
    """Whether the content starts like a format read here; a file's suffix says nothing."""
    return netpbm.is_netpbm(data) or any(data.startswith(magic) for magic in _DECODERS)


@dataclass(frozen=True, eq=False)
class Picture:
    """A decoded file before anybody said what its pixels mean: Pillow's image, or the samples of a netpbm file."""

    format: str
    image: ImageFile.ImageFile | None
    samples: netpbm.Samples | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        if self.image is not None:
            return self.image.height, self.image.width
        assert self.samples is not None, "a picture has an image or samples"
        return self.samples.shape[0], self.samples.shape[1]


def decode(data: bytes, subject: object, channels: Channels = "brightness") -> Raster:
    """Decode an image to grey values: see `load` and `in_greys`."""
    return in_greys(load(data, subject), channels)


def load(data: bytes, subject: object) -> Picture:
    """Decode an image.

    Raises:
        MapFileError: not an image read here, broken, truncated, or beyond the bound on cells.
    """
    if netpbm.is_netpbm(data):
        return Picture("PNM", None, netpbm.decode(data, subject))
    for magic, (name, decoder) in _DECODERS.items():
        if data.startswith(magic):
            return Picture(name, _load(data, name, decoder, subject))
    if data.startswith(b"version https://git-lfs"):
        raise fault(subject, "is a Git LFS pointer, not the image itself; fetch it with `git lfs pull`")
    raise fault(subject, "is not a PGM, PNG, BMP, JPEG or TIFF image; save the map in one of these formats")


def in_greys(picture: Picture, channels: Channels = "brightness") -> Raster:
    """Grey values: 16 bit floor(v / 257), colour floor(0.299 R + 0.587 G + 0.114 B).

    With another word for `channels` a colour is the sum of its channels instead (see `Raster`).
    """
    if picture.image is not None:
        return _raster(picture.image, channels)
    samples = picture.samples
    assert samples is not None, "a picture has an image or samples"
    return _combined(samples, channels) if samples.ndim == 3 else Raster(samples.astype(np.uint8, copy=False))


def _load(data: bytes, name: str, decoder: type[ImageFile.ImageFile], subject: object) -> ImageFile.ImageFile:
    """Decode with Pillow; whatever a broken file makes it raise or warn of becomes one sentence."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            image = decoder(io.BytesIO(data))
            check_size(*image.size, subject)
            if name == "JPEG" and image.width * image.height > MOST_PIXELS_PER_BYTE * len(data):
                raise OSError("no JPEG holds so many pixels in so few bytes; its decoder would fill them up with grey")
            if name == "TIFF" and _covered(image) < image.width * image.height:
                raise OSError("the strips of the file do not cover the image; its decoder would fill it up with black")
            # Pillow forgets how many bits a grey PNG had, while its transparent grey is given in those bits.
            image.info["fidmap_bits"] = {"L;2": 2, "L;4": 4}.get(_raw_mode(image), 8)
            if name == "TIFF":
                _load_tiff(image)
            else:
                image.load()
            if image.mode not in _MODES:
                raise fault(subject, f"holds samples of kind {image.mode}; save the map with 8 or 16 bits per pixel")
    except (MapFileError, MemoryError):
        raise
    # A decoder fed with hostile bytes raises nearly anything: OSError, SyntaxError, struct.error, IndexError.
    except Exception:
        raise fault(
            subject,
            f"is a broken or truncated {name} image; expected a whole one, so copy or save the map again",
        ) from None
    return image


def _load_tiff(image: ImageFile.ImageFile) -> None:
    """Decode a TIFF.

    What libtiff dislikes it writes to the process's own stderr, past Python, where only our sentence belongs; and
    behind a broken word of a fax code it goes on without telling Pillow, so what it wrote is looked at.

    Raises:
        OSError: broken, as Pillow or libtiff says.
    """
    reading, writing = os.pipe()
    os.set_blocking(writing, False)  # what does not fit into the pipe is dropped
    stderr = os.dup(2)
    with os.fdopen(reading, "rb") as words:
        try:
            os.dup2(writing, 2)
            image.load()
        finally:
            os.dup2(stderr, 2)
            os.close(stderr)
            os.close(writing)
        # a bar of progress may have been written too, by another thread
        if b"Decode" in words.read():
            raise OSError("libtiff could not decode all of it")


def _covered(image: ImageFile.ImageFile) -> int:
    """Pixels of all strips or tiles that the file has."""
    boxes = [tile.extents for tile in image.tile if tile.extents is not None]
    return sum(max(0, right - left) * max(0, bottom - top) for left, top, right, bottom in boxes)


def _raw_mode(image: ImageFile.ImageFile) -> str:
    """The layout of the file's samples, as Pillow names it."""
    arguments: Any = image.tile[0].args if image.tile else ""
    return arguments if isinstance(arguments, str) else str((*(arguments or ("",)),)[0])


def _raster(image: ImageFile.ImageFile, wanted: Channels) -> Raster:
    """Grey values and transparency of a loaded image, whatever its mode."""
    mode, clear = image.mode, image.info.get("transparency")
    if wanted != "brightness" and (mode not in {"L", "1", "I;16", "I;16B"} or clear is not None):
        opaque = "A" not in mode and clear is None
        return _combined(np.asarray(image.convert("RGB" if opaque else "RGBA")), wanted)
    if mode == "P":
        return _palette(image, clear)
    if mode in {"LA", "RGBA"}:
        grey, transparent = np.empty(image.size[::-1], np.uint8), np.empty(image.size[::-1], bool)
        for rows, block in strips(image):
            grey[rows] = block[..., 0] if mode == "LA" else _luma(block)
            transparent[rows] = block[..., -1] < 255
        return Raster(grey, transparent if transparent.any() else None)
    if mode.startswith("I;16"):
        wide = np.asarray(image).astype(np.uint16, copy=False)
        narrow = look_up((np.arange(65536) // 257).astype(np.uint8), wide)
        return Raster(narrow, None if clear is None else wide == clear)
    if mode in {"L", "1"}:
        grey = np.asarray(image if mode == "L" else image.convert("L"))
        unit = 255 // (2 ** image.info["fidmap_bits"] - 1)
        return Raster(grey, None if clear is None else grey == clear * (unit if mode == "L" else 1))
    grey, hidden = np.empty(image.size[::-1], np.uint8), np.zeros(image.size[::-1], bool)
    for rows, block in strips(image if mode == "RGB" else image.convert("RGB")):
        grey[rows] = _luma(block)
        if clear is not None:
            hidden[rows] = (block == np.asarray(clear)).all(axis=-1)
    return Raster(grey, None if clear is None else hidden)


def strips(image: Image.Image) -> Iterator[tuple[slice, Bytes]]:
    """Rows of an image and their samples, block by block: Pillow takes three times the memory for all at once."""
    for top in range(0, image.height, _BLOCK_ROWS):
        rows = slice(top, min(top + _BLOCK_ROWS, image.height))
        yield rows, np.asarray(image.crop((0, rows.start, image.width, rows.stop)))


def _combined(colour: netpbm.Samples, wanted: Channels) -> Raster:
    """Colours (H, W, 3), or (H, W, 4) with alpha, as one number each; sums where a mean is wanted."""
    transparent = colour[..., 3] < 255 if colour.shape[2] == 4 else None
    if transparent is not None and not transparent.any():
        transparent = None
    if wanted == "brightness":
        return Raster(_luma(colour[..., :3]), transparent)
    if colour.dtype == np.uint16:
        colour = look_up((np.arange(65536) // 257).astype(np.uint8), colour)
    parts = colour.shape[2] if wanted == "mean-with-alpha" else 3
    total = colour[..., 0].astype(np.uint16)
    for k in range(1, parts):
        total += colour[..., k]
    return Raster(total, transparent, parts)


def _palette(image: ImageFile.ImageFile, clear: int | bytes | None) -> Raster:
    """A palette image through a table of 256 greys, never through a colour copy of the map."""
    colours = np.zeros((1, 256, 3), np.uint8)
    entries = np.frombuffer(bytes(image.getpalette("RGB") or []), np.uint8).reshape(1, -1, 3)[:, :256]
    colours[:, : entries.shape[1]] = entries
    index = np.asarray(image)
    grey = look_up(_luma(colours)[0], index)
    if clear is None:
        return Raster(grey)
    hidden = np.zeros(256, bool)
    if isinstance(clear, int):
        hidden[clear] = True
    else:
        alpha = np.frombuffer(clear, np.uint8)[:256]
        hidden[: len(alpha)] = alpha < 255
    transparent = look_up(hidden, index)
    return Raster(grey, transparent if transparent.any() else None)


def _luma(colour: netpbm.Samples) -> Bytes:
    """floor(0.299 R + 0.587 G + 0.114 B) of (H, W, 3 or more), in integers: floats would turn a grey g into g - 1.

    16-bit samples are reduced after the sum, as GraphicsMagick does for nav2_map_server.
    """
    grey = np.empty(colour.shape[:2], np.uint8)
    divisor = np.uint32(257_000 if colour.dtype == np.uint16 else 1000)
    for top in range(0, len(colour), _FEW_ROWS):
        block = colour[top : top + _FEW_ROWS]
        total = block[..., 0] * np.uint32(299)
        total += block[..., 1] * np.uint32(587)
        total += block[..., 2] * np.uint32(114)
        total //= divisor
        grey[top : top + _FEW_ROWS] = total
    return grey

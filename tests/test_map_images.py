"""Decoding images: depth, colour, palettes, transparency and the netpbm family."""

from __future__ import annotations

import io
import struct
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from fidmap.maps.images import decode
from fidmap.model import MapFileError


def png(image: Image.Image, **options: object) -> bytes:
    """The bytes of an image saved as PNG."""
    buffer = io.BytesIO()
    image.save(buffer, "PNG", **options)
    return buffer.getvalue()


def grey_png(width: int, depth: int, row: bytes, clear: int | None = None) -> bytes:
    """A PNG of one row of grey at a depth that Pillow cannot write, with a transparent grey."""
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", width, 1, depth, 0, 0, 0, 0))]
    chunks += [] if clear is None else [(b"tRNS", struct.pack(">H", clear))]
    chunks += [(b"IDAT", zlib.compress(b"\0" + row)), (b"IEND", b"")]
    parts = [struct.pack(">I", len(d)) + n + d + struct.pack(">I", zlib.crc32(n + d)) for n, d in chunks]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (b"P5\n3 1\n255\n\x00\xcd\xfe", [0, 205, 254]),
        (b"P5 # made by\n# a saver\n3 # wide\n1\n255\n\x00\xcd\xfe", [0, 205, 254]),
        (b"P5\r\n3 1\r255\n\x00\xcd\xfe trailing", [0, 205, 254]),
        (b"P2\n3 1\n255\n0 205\n254", [0, 205, 254]),
        (b"P2\n# c\n3 1\n255\n0 # wall\n205 254\n", [0, 205, 254]),
        (b"P2 3 1 15 0 12 15", [0, 204, 255]),
        (b"P2 3 1 255 0 205 999", [0, 205, 255]),
        (b"P5 3 1 100\n\x00\x32\x64", [0, 127, 255]),
        # floor(v / 257): 256 is 0, 257 is 1, 52684 is 204, 52685 = 205 * 257
        (b"P5 5 1 65535\n" + struct.pack(">5H", 256, 257, 52684, 52685, 65535), [0, 1, 204, 205, 255]),
        (b"P2 2 1 65535 52684 52685", [204, 205]),
        (b"P5 2 1 1023\n" + struct.pack(">2H", 1023, 0), [255, 0]),
        (b"P6 2 1 255\n\xcd\xcd\xcd\xff\x00\x00", [205, 76]),
        (b"P3 2 1 255 205 205 205 0 255 0", [205, 149]),
        (b"P6 1 1 65535\n" + struct.pack(">3H", 52685, 52685, 52684), [204]),
        (b"P1 4 1 01\n10", [255, 0, 0, 255]),
        (b"P4\n9 1\n\x80\x80", [0, 255, 255, 255, 255, 255, 255, 255, 0]),
    ],
)
def test_netpbm_by_hand(data: bytes, expected: list[int]) -> None:
    """Each member of the netpbm family gives the greys computed by hand, comments and depths included."""
    assert decode(data, "m.pgm").grey.tolist() == [expected]


def test_netpbm_rows_are_not_mixed() -> None:
    """Binary, plain and bitmap rasters of several padded rows keep their rows."""
    expected = [[0, 255, 0], [255, 255, 0]]
    for data in [
        b"P5 3 2 255\n\x00\xff\x00\xff\xff\x00",
        b"P2 3 2 255\n0 255 0 255 255 0",
        b"P1 3 2 101 001",
        b"P4 3 2\n\xa0\x20",
    ]:
        assert decode(data, "m").grey.tolist() == expected


def test_plain_files_of_several_pieces() -> None:
    """Plain files are parsed a megabyte at a time: numbers and comments across these borders stay whole."""
    grey = np.random.default_rng(3).integers(0, 256, (700, 900))
    lines = [" ".join(map(str, row)) for row in grey.tolist()]
    for text in (" ".join(lines), "\n".join(lines), " # 7 8 9\n".join(lines)):
        assert np.array_equal(decode(f"P2 900 700 255\n{text}".encode(), "m").grey, grey)
    with pytest.raises(MapFileError, match="700 cells need 630000 values or bytes, 629999 are there"):
        decode(f"P2 900 700 255\n{text.rpartition(' ')[0]}".encode(), "m")
    for end in ("x", "1" * 3_000_000):
        with pytest.raises(MapFileError, match="text among its numbers"):
            decode(f"P2 900 700 255\n{text} {end} 1".encode(), "m")


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "LA"])
def test_colours_of_many_rows(mode: str) -> None:
    """Colours are taken a few rows at a time: greys and transparency of all rows, one by one computed."""
    samples = np.random.default_rng(5).integers(250, 256, (150, 7, len(mode)), dtype=np.uint8)
    clear = {"transparency": (255, 255, 254)} if mode == "RGB" else {}
    raster = decode(png(Image.fromarray(samples, mode), **clear), "m")
    wide = samples.astype(int)
    luma = wide[..., 0] if mode == "LA" else wide[..., :3] @ (299, 587, 114) // 1000
    hidden = (samples == (255, 255, 254)).all(axis=-1) if mode == "RGB" else samples[..., -1] < 255
    assert np.array_equal(raster.grey, luma)
    assert raster.transparent is not None
    assert np.array_equal(raster.transparent, hidden)


def test_colour_is_rounded_down() -> None:
    """Colour becomes floor(.299 R + .587 G + .114 B), where Pillow would round; greys keep their value."""
    rgb = np.array([[[10, 20, 31], [255, 255, 255], [205, 205, 205], [1, 0, 0]]], np.uint8)

    # 2.99 + 11.74 + 3.534 = 18.264; .299 rounds to 0
    assert decode(png(Image.fromarray(rgb)), "m").grey.tolist() == [[18, 255, 205, 0]]


@settings(max_examples=50, derandomize=True, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_colour_is_exact_for_random_pictures(seed: int) -> None:
    """Integer arithmetic agrees with exact fractions on random colours, and a grey colour is that grey."""
    rgb = np.random.default_rng(seed).integers(0, 256, (70, 3, 3), np.uint8)
    rgb[0] = rgb[0, :, :1]
    exact = [[(299 * int(r) + 587 * int(g) + 114 * int(b)) // 1000 for r, g, b in row] for row in rgb]

    grey = decode(png(Image.fromarray(rgb)), "m").grey
    assert grey.tolist() == exact
    assert grey[0].tolist() == rgb[0, :, 0].tolist()


def test_sixteen_bit_png() -> None:
    """16 bit values become floor(v / 257), where Pillow's own conversion clips at 255."""
    wide = np.array([[0, 256, 257, 52684, 52685, 65535]], np.uint16)

    assert decode(png(Image.fromarray(wide)), "m").grey.tolist() == [[0, 0, 1, 204, 205, 255]]


@pytest.mark.parametrize(
    ("depth", "row", "clear", "grey", "transparent"),
    [
        (1, b"\x40", None, [0, 255], None),
        (1, b"\x40", 1, [0, 255], [False, True]),
        (2, b"\x60", 2, [85, 170], [False, True]),
        (4, b"\x0c", 12, [0, 204], [False, True]),
        (8, b"\x00\xcd", 205, [0, 205], [False, True]),
        (16, b"\x00\x00\xcd\xcd", 0xCDCD, [0, 205], [False, True]),
    ],
)
def test_grey_png_of_any_depth(
    depth: int, row: bytes, clear: int | None, grey: list[int], transparent: list[bool] | None
) -> None:
    """Grey PNGs of 1 to 16 bit decode to 8 bit greys, and their transparent grey is found at that depth."""
    raster = decode(grey_png(2, depth, row, clear), "m")

    assert raster.grey.tolist() == [grey]
    assert (None if raster.transparent is None else raster.transparent.tolist()[0]) == transparent


@pytest.mark.parametrize(("clear", "expected"), [(1, [False, True]), (b"\xff\xfe", [False, True]), (None, None)])
def test_palette(clear: int | bytes | None, expected: list[bool] | None) -> None:
    """A palette's colours and its transparent entries are looked up, not copied into a colour image."""
    image = Image.new("P", (2, 1))
    image.putpalette([205, 205, 205, 10, 20, 31])
    image.putdata([0, 1])
    raster = decode(png(image, **({} if clear is None else {"transparency": clear})), "m")

    assert raster.grey.tolist() == [[205, 18]]
    assert (None if raster.transparent is None else raster.transparent.tolist()[0]) == expected


def test_transparent_colour() -> None:
    """The transparent colour of an RGB image without alpha is transparent."""
    image = Image.fromarray(np.array([[[1, 2, 3], [1, 2, 4]]], np.uint8))

    assert decode(png(image, transparency=(1, 2, 3)), "m").transparent.tolist() == [[True, False]]


def test_fully_opaque_alpha_is_no_transparency() -> None:
    """An alpha channel of 255 everywhere costs nothing further on."""
    assert decode(png(Image.new("RGBA", (2, 2), (9, 9, 9, 255))), "m").transparent is None


def test_jpeg_and_bmp() -> None:
    """JPEG, also in CMYK, and BMP are decoded by content."""
    for form, mode in [
        ("JPEG", "L"),
        ("JPEG", "RGB"),
        ("JPEG", "CMYK"),
        ("BMP", "L"),
        ("BMP", "RGB"),
        ("BMP", "1"),
    ]:
        buffer = io.BytesIO()
        Image.new("L", (16, 16), 255).convert(mode).save(buffer, form)
        assert decode(buffer.getvalue(), "m").grey.min() >= 254


@settings(max_examples=300, derandomize=True, deadline=None)
@given(
    start=st.sampled_from(["png", "bmp", "jpeg", "P1 ", "P2 ", "P3 ", "P4 ", "P5 ", "P6 "]),
    cut=st.integers(0, 400),
    noise=st.binary(max_size=40),
)
def test_hostile_bytes_end_in_one_sentence(start: str, cut: int, noise: bytes) -> None:
    """Whatever follows a magic number, decoding gives an image or one line that names the file."""
    data = start.encode()
    if start.islower():
        buffer = io.BytesIO()
        Image.effect_noise((12, 9), 90).save(buffer, start)
        data = buffer.getvalue()[: max(8, cut)]
    try:
        text = f"m.img {decode(data + noise, 'm.img').grey.shape}"
    except MapFileError as error:
        text = str(error)
    assert text.startswith("m.img ")
    assert "\n" not in text

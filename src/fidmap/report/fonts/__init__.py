"""The shipped fonts: how wide a text is, and SVG to PNG that looks alike on every machine.

A fresh Debian has no fonts at all, and resvg then leaves every text out without a word.
"""

from __future__ import annotations

from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PIL import ImageFont

FAMILY = "DejaVu Sans, Verdana, Geneva, sans-serif"  # Verdana has the same widths
FOLDER = Path(__file__).parent
REGULAR = FOLDER / "DejaVuSans.ttf"
BOLD = FOLDER / "DejaVuSans-Bold.ttf"
_MEASURED_AT = 100


def is_covered(text: str) -> bool:
    """Whether the shipped fonts have every letter of a text (Latin, Greek, Cyrillic)."""
    return all(letter < "\u0460" or "\u2010" <= letter <= "\u2265" or letter == "\ufffd" for letter in text)


def text_width(text: str, size: float, bold: bool = False) -> float:
    """Width of a text in drawing units; letters of other scripts count as squares."""
    own = "".join(letter for letter in text if is_covered(letter))
    return size * (_length(own, bold) / _MEASURED_AT + len(text) - len(own))


@lru_cache(4096)
def _length(text: str, bold: bool) -> float:
    return float(_font(bold).getlength(text))


@cache
def _font(bold: bool) -> ImageFont.FreeTypeFont:
    from PIL import ImageFont

    return ImageFont.truetype(BOLD if bold else REGULAR, _MEASURED_AT)


def svg_to_png(svg: str, width: int, height: int) -> bytes:
    """Draw an SVG; the system's fonts are read only for letters that the shipped ones lack."""
    import resvg_py

    return bytes(
        resvg_py.svg_to_bytes(
            svg_string=svg,
            width=width,
            height=height,
            skip_system_fonts=is_covered(svg),
            font_files=[str(REGULAR), str(BOLD)],
            font_family="DejaVu Sans",
            sans_serif_family="DejaVu Sans",
        )
    )

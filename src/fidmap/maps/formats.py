"""Which reader a file belongs to, by its first bytes; readers are imported when a file needs them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from fidmap.maps.cursor import BrokenRecordError
from fidmap.maps.extras import MissingLibraryError
from fidmap.maps.files import fault, read_bytes
from fidmap.maps.overrides import Overrides
from fidmap.maps.refused import is_refused
from fidmap.model import Grid

HEAD_BYTES = 4096


@dataclass(frozen=True)
class Format:
    """A format beside images and YAML: how it begins, what it is called, and the module whose `read` reads it."""

    begins: Callable[[bytes], bool]
    called: str
    module: str


def _starts(*magics: bytes) -> Callable[[bytes], bool]:
    return lambda head: head.startswith(magics)


def _is_pcd(head: bytes) -> bool:
    """A text header of PCD's words, perhaps after comments."""
    words = [line.split()[0] for line in head.splitlines()[:20] if line.strip() and not line.startswith(b"#")]
    return words[:1] == [b"VERSION"] and b"FIELDS" in words


def _is_svg(head: bytes) -> bool:
    """XML whose first element, as far as it can be seen, is svg."""
    return head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<") and b"<svg" in head


def _is_dxf(head: bytes) -> bool:
    """The group code 0 with SECTION, perhaps after comments (999); or the mark of binary files."""
    words = [line.strip() for line in head.lstrip(b"\xef\xbb\xbf \t\r\n").splitlines()[:2]]
    commented = words[:1] == [b"999"] and b"SECTION" in head
    return head.startswith(b"AutoCAD Binary DXF") or words == [b"0", b"SECTION"] or commented


def _is_geojson(head: bytes) -> bool:
    """JSON that names a kind of GeoJSON near its beginning."""
    kinds = (b'"FeatureCollection"', b'"GeometryCollection"', b'"Feature"', b'LineString"', b'Polygon"')
    return head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{") and any(kind in head for kind in kinds)


FORMATS = (
    Format(_starts(b"#ROSBAG V2.0\n"), "a ROS 1 bag", "bag"),
    Format(_starts(b"\x89MCAP0\r\n"), "an MCAP file", "bag"),
    Format(_starts(b"SQLite format 3\0"), "an SQLite file", "sqlite_map"),
    Format(_starts(b"ply\n", b"ply\r"), "a PLY file", "ply"),
    Format(_is_pcd, "a PCD file", "pcd"),
    Format(_starts(b"# Octomap OcTree"), "an octree", "octomap"),
    Format(_starts(b"LASF"), "a LAS file", "las"),
    Format(_is_svg, "an SVG file", "svg"),
    Format(_is_dxf, "a DXF file", "dxf"),
    Format(_is_geojson, "a GeoJSON file", "geojson"),
    Format(is_refused, "another program's file", "refused"),
)


def format_of(file: Path, name: str) -> Format | None:
    """The format of a file, or of a bag's folder; None for an image, a YAML and whatever else it may be.

    Raises:
        MapFileError: the file cannot be read at all.
    """
    if file.is_dir():
        from fidmap.maps.bag import is_bag_folder

        if is_bag_folder(file):
            return Format(_starts(), "a ROS 2 bag", "bag")
    head = read_bytes(file, name, HEAD_BYTES)
    return next((known for known in FORMATS if known.begins(head)), None)


def read(known: Format, file: Path, name: str, overrides: Overrides) -> Grid:
    """Read a file of a known format.

    Raises:
        MapFileError: one sentence with what is wrong.
    """
    reader = import_module(f"fidmap.maps.{known.module}").read
    try:
        grid: Grid = reader(file, name, overrides)
    except MissingLibraryError as error:
        raise fault(name, str(error)) from None
    except BrokenRecordError as error:
        raise fault(name, f"is {known.called} that cannot be used: {error}; copy or save it again") from None
    except OSError as error:
        raise fault(name, f"cannot be read ({error.strerror or error}); check the path") from None
    return grid

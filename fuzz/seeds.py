"""Small whole files of every kind that is read, made by the project, and how each is read."""

from __future__ import annotations

import functools
import io
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from benchmarks.bag_files import cells, mcap_bytes, write_bag1, write_bag2, write_rtabmap
from benchmarks.cloud_files import Points, write_las, write_octree, write_pcd, write_ply
from benchmarks.drawing_files import write_dxf, write_geojson, write_svg
from PIL import Image

from fidmap.arena import read_arena
from fidmap.maps import read_map
from fidmap.points import read_points
from fidmap.profiles import read_profile

Read = Callable[[Path], object]


@dataclass(frozen=True)
class Seed:
    """A whole file: what it is called, its name on the disk, its bytes, and what reads it."""

    name: str
    file: str
    data: bytes
    read: Read

    def place(self, folder: Path) -> Path:
        """Where it is written; other seeds' files, such as the image of a YAML, lie beside it."""
        return folder / self.file


YAML = b"""image: map.pgm
resolution: 0.05
origin: [-1.5, 2.5, 0.1]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
mode: trinary  # a comment
"""
ARENA = b"""fidmap_arena: 1
name: A2
radius_m: 0.30
parts:
  - {id: 1A, x_m: 5.975, y_m: 5.413, facing_deg: 180, sigma_m: 0.005}
  - {id: 1B, x_m: 5.995, y_m: 5.413, facing_deg: 0}
groups:
  - {id: "1", parts: [1A, 1B], walking_pallets: 9}
"""
PROFILE = b"fidmap_profile: 1\nbase: ssrr2011\nmin_opening: 1/2\nweights: {coverage: 2, consistency: 1}\n"
POINTS = (
    b"n,x_m,y_m,facing_deg,drawn_deg,sigma_m,confidence,part,id\n1,4.912,3.707,84.4,164.0,0.009,1.0,7B,\n2,1,2,,,,,,-\n"
)
POIS = (
    b"pois,,,\n1.2,,,\nTeam,,,\n,,,\nid,time,text,x-coord,y,z\n1,16:08:20,A,1.0753,-0.6884,0.86\n2,16:08:21,B,2,3,0\n"
)
PTS = b"Lab,,\nqr_1,5.5,4.12\nqr_2,9.2,2.14\n"


def seeds(folder: Path) -> list[Seed]:
    """All seeds; the folder gets the files that others name."""
    grey = np.random.default_rng(0).choice(np.array([0, 205, 254], np.uint8), (20, 30))
    (folder / "map.pgm").write_bytes(_pgm(grey))
    plain = functools.partial(read_map, resolution_m=0.05)
    return [
        Seed("map_server YAML", "seed.yaml", YAML, read_map),
        *(Seed(name, f"image{k}", data, plain) for k, (name, data) in enumerate(_images(grey))),
        *(Seed(name, f"cloud{k}", data, read_map) for k, (name, data) in enumerate(_clouds())),
        *(Seed(name, f"bag{k}", data, read_map) for k, (name, data) in enumerate(_bags())),
        *(Seed(name, f"plan{k}", data, read_map) for k, (name, data) in enumerate(_plans())),
        Seed("RTAB-Map", "rtabmap.db", _rtabmap(), read_map),
        Seed("arena file", "arena.yaml", ARENA, read_arena),
        Seed("profile file", "profile.yaml", PROFILE, read_profile),
        Seed("points file", "points.csv", POINTS, read_points),
        Seed("object list", "pois.csv", POIS, read_points),
        Seed("pts", "seed.pts", PTS, read_points),
    ]


def _pgm(grey: np.ndarray[tuple[int, int], np.dtype[np.uint8]]) -> bytes:
    return b"P5\n# made for fuzzing\n%d %d\n255\n" % grey.shape[::-1] + grey.tobytes()


def _images(grey: np.ndarray[tuple[int, int], np.dtype[np.uint8]]) -> Iterator[tuple[str, bytes]]:
    yield "PGM", _pgm(grey)
    yield "plain PGM", b"P2 30 20 255\n" + b"\n".join(b" ".join(b"%d" % v for v in row) for row in grey)
    yield "PBM", b"P4 30 20\n" + np.packbits(grey > 100, axis=1).tobytes()
    image = Image.fromarray(grey)
    for name, form, mode in (
        ("PNG", "PNG", "L"), ("PNG palette", "PNG", "P"), ("PNG alpha", "PNG", "RGBA"), ("PNG 1 bit", "PNG", "1"),
        ("PNG 16 bit", "PNG", "I;16"), ("JPEG", "JPEG", "L"), ("BMP", "BMP", "L"), ("BMP colour", "BMP", "RGB"),
        ("TIFF", "TIFF", "RGB"), ("TIFF grey", "TIFF", "L"),
    ):  # fmt: skip
        file = io.BytesIO()
        image.convert(mode).save(file, form)
        yield name, file.getvalue()
    for name, mode, compression in (("TIFF LZW", "L", "tiff_lzw"), ("TIFF fax", "1", "group4")):
        file = io.BytesIO()
        image.convert(mode).save(file, "TIFF", compression=compression)
        yield name, file.getvalue()


def _room() -> Points:
    steps = np.linspace(0, 2, 21)
    a, b = (axis.ravel() for axis in np.meshgrid(steps, steps))
    zero = np.zeros_like(a)
    return np.concatenate([np.column_stack(c) for c in ((a, b, zero), (a, zero, b / 2), (zero, a, b / 2))])


def _clouds() -> Iterator[tuple[str, bytes]]:
    with tempfile.TemporaryDirectory() as folder:
        yield from _cloud_files(_room(), Path(folder) / "written")


def _cloud_files(points: Points, path: Path) -> Iterator[tuple[str, bytes]]:
    for form in ("ascii", "binary_little_endian", "binary_big_endian"):
        yield f"PLY {form}", write_ply(path, points, form).read_bytes()
    for encoding in ("ascii", "binary", "binary_compressed"):
        yield f"PCD {encoding}", write_pcd(path, points, encoding).read_bytes()
    for suffix in (".las", ".laz"):
        yield suffix, write_las(path.with_suffix(suffix), points).read_bytes()
    for suffix in (".bt", ".ot"):
        yield suffix, write_octree(path.with_suffix(suffix), points, points + 0.3).read_bytes()


def _bags() -> Iterator[tuple[str, bytes]]:
    with tempfile.TemporaryDirectory() as folder:
        yield from _bag_files(Path(folder))


def _bag_files(folder: Path) -> Iterator[tuple[str, bytes]]:
    written = [("/map", 0.0, cells(0)), ("/map", 1.0, cells(1))]
    path = folder / "written.bag"
    for compression in (None, "BZ2", "LZ4"):
        yield f"ROS 1 bag {compression}", write_bag1(path, written, compression).read_bytes()
        path.unlink()
    yield "db3", (write_bag2(folder / "bag2", written) / "bag2.db3").read_bytes()
    yield "db3 zstd", (write_bag2(folder / "bag3", written, mode="MESSAGE") / "bag3.db3").read_bytes()
    for compression in ("NONE", "LZ4", "ZSTD"):
        yield f"MCAP {compression}", mcap_bytes(written, compression)
    yield "MCAP without chunks", mcap_bytes(written, use_chunking=False)


def _plans() -> Iterator[tuple[str, bytes]]:
    made = [("line", np.array([0.0, 0.0, 3.0, 1.0])), ("arc", np.array([1.0, 2.0, 0.3, 0.5, 3.14]))]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plan"
        for name, write in (("DXF", write_dxf), ("SVG", write_svg), ("GeoJSON", write_geojson)):
            yield name, write(path, made).read_bytes()


def _rtabmap() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        return write_rtabmap(Path(folder) / "rtabmap.db", cells(0)).read_bytes()

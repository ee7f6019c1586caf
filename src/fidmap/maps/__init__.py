"""Maps from files: whatever a robot saved becomes a `Grid`.

The format is recognised by content; docs/formats.md says exactly what is read.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from fidmap.maps import formats, images, map_server, plain, remote
from fidmap.maps.cells import Flavour
from fidmap.maps.extras import MissingLibraryError
from fidmap.maps.files import fault, printable, read_bytes
from fidmap.maps.overrides import OriginAt, Overrides
from fidmap.model import Finding, Grid, MapFileError, Pose2

__all__ = ["main_file", "read_map"]


def read_map(
    path: str | os.PathLike[str],
    *,
    resolution_m: float | None = None,
    origin: Pose2 | None = None,
    free_thresh: float | None = None,
    occupied_thresh: float | None = None,
    topic: str | None = None,
    time_s: float | None = None,
    flavour: Flavour | None = None,
    origin_at: OriginAt | None = None,
    slab_m: tuple[float, float] | None = None,
    up: str | None = None,
    layers: tuple[str, ...] | None = None,
    unit_m: float | None = None,
) -> Grid:
    """Read a map in any format that is read: a map_server YAML with its image, a plain image, a bag, ...

    Args:
        path: the YAML or the image. An image whose YAML lies beside it is read through that YAML unless a
            resolution is given.
        resolution_m: side of a cell in metres; a plain image needs it, a YAML's value gives way to it.
        origin: pose of the lower-left corner of the lower-left cell; (0, 0, 0) for a plain image.
        free_thresh: occupancy up to which a cell is free; 0.196 for a plain image.
        occupied_thresh: occupancy from which a cell is occupied; 0.65 for a plain image.
        topic: which topic of a bag; by default the only one with maps, or /map.
        time_s: seconds after the bag begins; the last map until then is read, by default the last of all.
        flavour: whose map_server's rules: "nav2" (navigation2 main, the default), "nav2-old" or "ros1".
        origin_at: whether the origin is the "corner" (the default) or the "centre" of the lower-left cell.
        slab_m: lowest and highest height above the floor of what a 3D map shows; by default 0.2 to 0.9 m.
        up: which axis of a point cloud is up, "z" or "-y" and so on; by default it is found.
        layers: layers, groups or colours (#rrggbb) of a drawing that are painted; by default all.
        unit_m: metres per unit of a drawing that does not say it.

    Raises:
        MapFileError: one sentence that names the file, what is wrong, what was expected and what to do.
    """
    name = os.fspath(path)
    overrides = Overrides(
        resolution_m, origin, free_thresh, occupied_thresh, topic, time_s, flavour, origin_at, slab_m, up,
        layers, unit_m,
    )  # fmt: skip
    overrides.check(name)
    try:
        if remote.is_url(name):
            with remote.fetched(name) as local:
                grid = _read(local, str(local), overrides)
                return replace(grid, source=replace(grid.source, name=name))
        return _read(Path(name), name, overrides)
    except MissingLibraryError as error:
        raise fault(name, str(error)) from None
    except MemoryError:
        raise fault(name, "does not fit into memory; crop it or save it with larger cells") from None


def main_file(path: str | os.PathLike[str]) -> Path:
    """The file that stands for a map, links resolved: of an image with its own YAML the YAML, else the file itself.

    Two names of one map have the same main file; a path that cannot be read stands for itself.
    """
    file = Path(path)
    try:
        if images.is_image(read_bytes(file, file, 16)):
            file = map_server.own_yaml(file, str(file)) or file
        return Path(os.path.realpath(file))  # resolve() would raise on links in a circle
    except (MapFileError, OSError):
        return file


def _read(file: Path, name: str, overrides: Overrides) -> Grid:
    """Tell the formats apart by the first bytes."""
    if (known := formats.format_of(file, name)) is not None:
        return formats.read(known, file, name, overrides)
    if not images.is_image(read_bytes(file, name, 16)):
        return map_server.read(file, name, overrides)
    if overrides.resolution_m is None and (own := map_server.own_yaml(file, name)) is not None:
        text = (
            f"{printable(file.name)} was read through {printable(own.name)} beside it, with its scale, "
            "origin and thresholds; --resolution reads the image alone"
        )
        note = Finding("note", "image-uses-yaml", text, "--resolution M_PER_CELL")
        return map_server.read(own, name, overrides, (note,))
    return plain.read(file, name, overrides)

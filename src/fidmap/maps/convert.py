"""A grid to another format, chosen by the suffix of the file to write."""

from __future__ import annotations

from pathlib import Path

from fidmap.maps.robocup.write import write_geotiff
from fidmap.maps.write import write_map
from fidmap.model import Grid, OutputError

MAP_SERVER, GEOTIFF = (".yaml", ".yml", ".pgm"), (".tif", ".tiff")


def files_of(path: Path) -> tuple[Path, ...]:
    """The files that writing to this path makes.

    Raises:
        OutputError: the suffix names no format that is written.
    """
    suffix = path.suffix.lower()
    if suffix in MAP_SERVER:
        return path.with_suffix(".yaml"), path.with_suffix(".pgm")
    if suffix in GEOTIFF:
        return path, path.with_suffix(".tfw")
    raise OutputError(
        f"{path}: no format of that name is written; end it in .yaml (map_server) or .tif (RoboCup GeoTIFF)"
    )


def write(path: Path, grid: Grid) -> tuple[Path, ...]:
    """Write a map_server YAML with its PGM, or a RoboCup GeoTIFF with its world file; existing files stay.

    Returns:
        The files written, the one that stands for the map first.

    Raises:
        OutputError: no such format, a file is there already, or the place cannot be written.
    """
    made = files_of(path)
    for file in made:
        if file.exists():
            raise OutputError(f"{file}: is there already; choose another name, or move it away")
    if path.suffix.lower() in MAP_SERVER:
        write_map(path.parent, path.stem, grid, exact=True)
    else:
        write_geotiff(path, grid)
    return made

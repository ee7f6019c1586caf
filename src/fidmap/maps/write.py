"""A `Grid` to the files that ROS map servers read: a PGM image and the YAML that explains it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import yaml

from fidmap.grid import trinarize
from fidmap.maps.cells import Meaning, code_table
from fidmap.maps.tables import look_up
from fidmap.model import Grid, Label
from fidmap.output_file import write_whole

OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196  # as ROS map savers write them: 205 is unknown
GREY_OF_UNKNOWN = 205
LOWEST = {Label.FREE: 206, Label.UNKNOWN: 90, Label.OCCUPIED: 0}  # greys that load as each label
HIGHEST = {Label.FREE: 254, Label.UNKNOWN: 205, Label.OCCUPIED: 89}


def write_map(folder: Path, name: str, grid: Grid, exact: bool = False) -> Path:
    """Write `name`.pgm and `name`.yaml; the YAML comes last, since it says that the image is there.

    Reading them back gives the same labels, and probabilities to 1/255 within the band of their label. Where `exact`
    is asked for, the grid's own thresholds are written too if its probabilities keep their labels under them, so that
    a map_server's map comes back as it was; else the labels win.

    Returns:
        The path of the YAML.

    Raises:
        OutputError: the place cannot be written.
    """
    grey, thresholds = _exact_greys(grid) if exact else (greys(grid), (FREE_THRESH, OCCUPIED_THRESH))
    grey = grey[::-1]
    header = f"P5\n{grey.shape[1]} {grey.shape[0]}\n255\n".encode()
    write_whole(folder / f"{name}.pgm", header + grey.tobytes())
    path = folder / f"{name}.yaml"
    write_whole(path, _description(f"{name}.pgm", grid, thresholds, exact).encode())
    return path


def _exact_greys(grid: Grid) -> tuple[npt.NDArray[np.uint8], tuple[float, float]]:
    """Greys that keep every probability to half a grey, and the thresholds that keep the labels with them."""
    shade = np.rint(255 * (1 - np.clip(grid.occupancy, 0, 1)))
    shade[np.isnan(shade)] = GREY_OF_UNKNOWN
    grey = shade.astype(np.uint8)
    table = code_table(Meaning(grid.resolution_m, free_thresh=grid.free_thresh, occupied_thresh=grid.occupied_thresh))
    if np.array_equal(look_up(table.labels, grey), trinarize(grid).labels):
        return grey, (grid.free_thresh, grid.occupied_thresh)
    return greys(grid), (FREE_THRESH, OCCUPIED_THRESH)


def greys(grid: Grid) -> npt.NDArray[np.uint8]:
    """(H, W) greys of a grid, row 0 lowest: 254 free, 205 unknown, 0 occupied, and shades where p says more."""
    labels = trinarize(grid).labels
    shade = np.rint(255 * (1 - grid.occupancy))
    shade[np.isnan(shade)] = GREY_OF_UNKNOWN
    result = np.empty(labels.shape, np.uint8)
    for label in Label:
        mine = labels == label
        result[mine] = np.clip(shade[mine], LOWEST[label], HIGHEST[label])
    return result


def _description(image: str, grid: Grid, thresholds: tuple[float, float], exact: bool) -> str:
    numbers = (grid.origin.x_m, grid.origin.y_m, grid.origin.yaw)
    origin = [float(value) if exact else round(value, 6) for value in numbers]
    document = {
        "image": image,
        "resolution": float(grid.resolution_m),
        "origin": origin,
        "negate": 0,
        "occupied_thresh": float(thresholds[1]),
        "free_thresh": float(thresholds[0]),
    }
    return yaml.safe_dump(document, sort_keys=False, default_flow_style=None)

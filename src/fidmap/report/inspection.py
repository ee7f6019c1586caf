"""What `fidmap inspect` shows: facts, shares, a small picture in characters, and the findings."""

from __future__ import annotations

import io

import numpy as np
import numpy.typing as npt
from rich.console import Console
from rich.text import Text

from fidmap.grid import trinarize
from fidmap.model import Finding, Grid, Label
from fidmap.report.json_line import Document, finding_document, wrapped_degrees
from fidmap.report.wording import clean

COLUMNS = 64
SIGNS = {Label.FREE: " ", Label.UNKNOWN: "·", Label.OCCUPIED: "█"}
GREYS = np.array([254, 205, 0], np.uint8)
LONGEST_SIDE = 1024


def inspect_document(
    name: str, grid: Grid, share: dict[Label, float], percent: npt.NDArray[np.int64], no_value: int,
    findings: tuple[Finding, ...],
) -> Document:  # fmt: skip
    """One line of `fidmap inspect --json`."""
    rows, columns = grid.occupancy.shape
    return {
        "map": name,
        "format": grid.source.format,
        "width": columns,
        "height": rows,
        "resolution_m": grid.resolution_m,
        "origin": [grid.origin.x_m, grid.origin.y_m, wrapped_degrees(grid.origin.yaw)],
        "share": {label.name.lower(): round(share[label], 6) for label in Label},
        "histogram": {"percent": [int(count) for count in percent], "no_value": no_value},
        "findings": [finding_document(finding) for finding in findings],
    }


def print_inspection(console: Console, document: Document, grid: Grid) -> None:
    """Facts, picture and findings of one map."""
    width, height, cell = document["width"], document["height"], document["resolution_m"]
    x, y, yaw = document["origin"]
    lines = [
        clean(document["map"]),
        f"  format      {document['format']}",
        f"  size        {width} x {height} cells, {width * cell:.2f} x {height * cell:.2f} m",
        f"  resolution  {cell:g} m per cell",
        f"  origin      {x:g} m, {y:g} m, {yaw:g}°",
        "  share       " + ", ".join(f"{name} {value:.1%}" for name, value in document["share"].items()),
        f"  occupancy   {_values(document)}",
        "",
        *(f"  {line}" for line in thumbnail_lines(trinarize(grid).labels)),
        "",
    ]
    for line in lines:
        console.print(Text(line), soft_wrap=True)
    for finding in document["findings"]:
        console.print(Text(f"  {finding_line(finding)}"), soft_wrap=True)
    if not document["findings"]:
        console.print(Text("  nothing odd"))


def finding_line(finding: Document) -> str:
    """A finding in one line, with the option that mends it."""
    option = f" ({finding['option']})" if finding.get("option") else ""
    return f"{finding['level']}: {finding['code']}: {clean(finding['text'])}{option}"


def _values(document: Document) -> str:
    """The most frequent values of occupancy in percent."""
    percent, total = document["histogram"]["percent"], document["width"] * document["height"]
    often = sorted((p for p in range(101) if percent[p]), key=lambda p: -percent[p])
    words = [f"{p} % in {percent[p] / total:.1%}" for p in often[:4]]
    words += [f"{len(often) - 4} other values"] if len(often) > 4 else []
    words += [f"none in {document['histogram']['no_value'] / total:.1%}"] if document["histogram"]["no_value"] else []
    return ", ".join(words)


def thumbnail_lines(labels: npt.NDArray[np.uint8]) -> list[str]:
    """The map in characters, twice as high as wide: a block is a wall where one is in it, else what most of it is."""
    step = max(1, -(-labels.shape[1] // COLUMNS))
    small = blocks(labels, 2 * step, step)[::-1]
    return ["".join(SIGNS[Label(value)] for value in row) for row in small]


def blocks(labels: npt.NDArray[np.uint8], rows: int, columns: int) -> npt.NDArray[np.uint8]:
    """One label per block of cells: occupied where any cell is, else free where any is, else unknown."""
    starts = [np.arange(0, size, step) for size, step in zip(labels.shape, (rows, columns), strict=True)]
    rank = np.array([1, 0, 2], np.uint8)[labels]  # unknown gives way to free, free to occupied
    top = np.maximum.reduceat(np.maximum.reduceat(rank, starts[0], axis=0), starts[1], axis=1)
    return np.array([Label.UNKNOWN, Label.FREE, Label.OCCUPIED], np.uint8)[top]


def thumbnail_png(labels: npt.NDArray[np.uint8]) -> bytes:
    """The map as a PNG of at most 1024 pixels a side."""
    from PIL import Image

    step = max(1, -(-max(labels.shape) // LONGEST_SIDE))
    buffer = io.BytesIO()
    Image.fromarray(GREYS[blocks(labels, step, step)[::-1]]).save(buffer, "PNG")
    return buffer.getvalue()

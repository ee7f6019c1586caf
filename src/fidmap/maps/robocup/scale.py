"""How long a metre is in a picture without tags: the tiles of the unexplored ground, else the drawn scale bar."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fidmap.maps.robocup.palette import Kind

Bytes = npt.NDArray[np.uint8]
Edges = npt.NDArray[np.float64]
SHORTEST_M = 8
"""Pixels: a metre shorter than this cannot be told from noise, and would make cells of over 12 cm."""

SHORTEST_BAR = 16
"""Pixels: JPEG makes shorter runs of a bar's colour along walls."""


def pixels_per_metre(kinds: Bytes, brightness: Bytes) -> float | None:
    """Length of a metre in pixels, None where neither tiles nor bar show it.

    Args:
        kinds: (H, W) of `Kind`.
        brightness: (H, W), whatever tells the two tiles apart.
    """
    if (tiles := tile_length(kinds, brightness)) is not None:
        return tiles
    bar = longest_line(kinds == Kind.BAR) - 1  # both of its ends are drawn
    return bar if bar >= SHORTEST_BAR else None


def longest_line(mask: npt.NDArray[np.bool_]) -> int:
    """Pixels of the longest horizontal or vertical run: bar and both axes are one metre long."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return 0
    box = mask[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    return max(_longest_run(box), _longest_run(np.ascontiguousarray(box.T)))


def _longest_run(mask: npt.NDArray[np.bool_]) -> int:
    """Longest run of True along a row."""
    flat = np.zeros((mask.shape[0], mask.shape[1] + 2), np.int8)
    flat[:, 1:-1] = mask
    change = np.diff(flat.ravel())
    return int((np.flatnonzero(change < 0) - np.flatnonzero(change > 0)).max(initial=0))


def tile_length(kinds: Bytes, brightness: Bytes) -> float | None:
    """Side of the tiles in pixels, from the rows and columns where their brightness changes.

    Of all distances between neighbouring edges the longest one is taken at whose multiples nearly the most edges lie,
    then fitted to these by least squares.
    """
    edges = [_edges(kinds, brightness), _edges(kinds.T, brightness.T)]
    gaps = np.concatenate([np.diff(e) for e in edges])
    gaps = gaps[gaps >= SHORTEST_M]
    fitting = {float(gap): [_raster(e, float(gap)) for e in edges] for gap in gaps}
    most = max((sum(map(len, found)) for found in fitting.values()), default=0)
    if most < max(5, 0.6 * sum(map(len, edges))):
        return None
    gap = max(gap for gap, found in fitting.items() if sum(map(len, found)) >= 0.9 * most)
    along = [(np.round((e - e[0]) / gap), e) for e in fitting[gap] if len(e) > 1]
    steps, places = (np.concatenate([v - v.mean() for v in values]) for values in zip(*along, strict=True))
    return float(steps @ places / (steps @ steps))


def _raster(edges: Edges, gap: float) -> Edges:
    """The largest set of edges that lie on one raster of this width, give or take a pixel."""
    away = np.abs((edges[:, None] - edges[None, :] + gap / 2) % gap - gap / 2) <= 1
    return edges[away[:, int(away.sum(axis=0).argmax())]] if len(edges) else edges


def _edges(kinds: npt.NDArray[np.uint8], brightness: npt.NDArray[np.uint8]) -> Edges:
    """Columns (continuous, (N,)) at which most of what is unexplored changes its tile.

    Compared over two pixels, since a scaled picture blurs the edge; JPEG's noise steps in few rows at a time.
    """
    some = slice(None, None, max(1, len(kinds) // 800))
    unknown, level = kinds[some] == Kind.UNKNOWN, brightness[some].astype(np.int16)
    both = unknown[:, 2:] & unknown[:, 1:-1] & unknown[:, :-2]
    step = (np.abs(level[:, 2:] - level[:, :-2]) >= 6) & both
    seen = both.sum(axis=0)
    edge = (step.sum(axis=0) > 0.6 * seen) & (seen >= 10)
    starts, ends = (np.flatnonzero(np.diff(np.concatenate([[0], edge.astype(np.int8), [0]])) == d) for d in (1, -1))
    return (starts + ends)[ends - starts <= 4] / 2 + 1

"""The proof of a registration: every placement is shut out by a sweep, or looked at by branch and bound."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fidmap.model import FloatArray
from fidmap.register.branch import Improve, Proof, Search, Stop
from fidmap.register.crosscheck import fiducial_sums
from fidmap.register.landscape import Landscape
from fidmap.register.majorant import quantum
from fidmap.register.near import Matcher
from fidmap.register.rivals import Rivals
from fidmap.register.sweep import Layer, Raster, Sweep, raster

# meshes of the sweep, as shares of D: a finer one where too many boxes stay open
CELL_SHARES = (1 / 8, 1 / 12, 1 / 16)
TURN_SHARE = 1.25
ENOUGH = 20_000
# layers with more open boxes are looked at from the fiducial parts too
MANY = 40
MOST_NODES = 300_000
# what a continuous value may be short of the optimum, as a share
TOLERANCE = 1e-3
FIXED_TOLERANCE = 1e-4
SLACK = 1e-4


def stop_of(land: Landscape) -> Stop:
    """Up to which bound nothing is looked for: the tolerance, or short of the next value that steps allow."""
    step = quantum(land)
    if step is not None:
        return lambda value: value + step - SLACK
    free = bool(land.problem.allowed.any())
    tolerance = TOLERANCE if free else FIXED_TOLERANCE
    return lambda value: value * (1 + tolerance)


def prove(
    land: Landscape, matcher: Matcher, value: float, improve: Improve, stop: Stop, most: int,
    rivals: Rivals | None = None,
) -> Proof:  # fmt: skip
    """Bound all values of a landscape from above; `value` is attained somewhere, `improve` climbs from a placement.

    With `rivals`, of all values of placements that are among them.
    """
    search = Search(land, matcher, value, improve, stop, most, rivals)
    shares = CELL_SHARES if rivals is None else CELL_SHARES[:1]
    boxes, bounds, shut = open_boxes(land, stop(value), most, shares)
    proof = search.run(boxes, bounds)
    upper = max(proof.upper_bound, min(shut, land.most))
    return Proof(proof.value, stepped_down(land, proof.value, upper), proof.nodes)


def stepped_down(land: Landscape, value: float, upper: float) -> float:
    """The greatest value at most `upper` that steps allow, and never below `value`."""
    step = quantum(land)
    if step is None:
        return upper
    return max(value, math.floor(upper / step + 1e-6) * step)


def open_boxes(land: Landscape, cut: float, most: int, shares: Sequence[float]) -> tuple[FloatArray, FloatArray, float]:
    """Boxes (K, 8) that may hold more than `cut`, their bounds (K,), and a bound of all that is outside of them.

    Of more than some `most` boxes the best are kept, since nobody will look at the others: they raise the last bound.
    """
    found = None
    for share in shares:
        mesh = raster(land, share * land.problem.d_max, TURN_SHARE)
        if mesh is None:
            break
        swept = _swept(land, mesh, cut, most)
        if found is None or len(swept[0]) < len(found[0]):
            found = swept
        if len(found[0]) <= ENOUGH or len(swept[0]) > len(found[0]):
            break
    if found is not None:
        return found
    low, high = land.limits
    whole = np.concatenate([(low + high) / 2, (high - low) / 2])[None]
    return whole, np.array([float(land.most)]), 0.0


def _swept(land: Landscape, mesh: Raster, cut: float, most: int) -> tuple[FloatArray, FloatArray, float]:
    """The cells of a sweep that stay open, cut to the landscape's limits."""
    sweep = Sweep(land, mesh, inflated=True)
    found, count = [(np.empty((0, 8)), np.empty(0))], 0
    for layer in sweep.layers(cut):
        found.append(_open_cells(land, mesh, layer, sweep.unit, cut))
        count += len(found[-1][1])
        if count > 2 * most:
            best, cut = _best(found, cut, most)
            found, count = [best], len(best[1])
    (boxes, bounds), cut = _best(found, cut, most)
    return _cut_to_limits(land, boxes), bounds, cut


def _best(
    some: Sequence[tuple[FloatArray, FloatArray]], cut: float, most: int
) -> tuple[tuple[FloatArray, FloatArray], float]:
    """Of some boxes (K, 8) with bounds (K,) the `most` of greatest bounds, and the cut that shuts out the others."""
    boxes, bounds = (np.concatenate(parts) for parts in zip(*some, strict=True))
    if len(bounds) > most:
        cut = max(cut, float(-np.partition(-bounds, most)[most]))
    kept = bounds > cut
    return (boxes[kept], bounds[kept]), cut


def _open_cells(land: Landscape, mesh: Raster, layer: Layer, unit: int, cut: float) -> tuple[FloatArray, FloatArray]:
    """The cells (K, 8) of one layer whose bounds (K,) are above the cut."""
    half = (mesh.half_turn, mesh.half_scale, mesh.cell / 2)
    rows, columns = np.nonzero(layer.sums > cut * unit)
    middles = layer.placements(rows, columns)
    sums = layer.sums[rows, columns] / unit
    if len(rows) > MANY:
        places = middles[:, 1] + 1j * middles[:, 2]
        sums = np.minimum(sums, fiducial_sums(land, layer.rotation, layer.scale, half, places))
        middles, sums = middles[sums > cut], sums[sums > cut]
    halves = np.broadcast_to([half[0], half[2], half[2], half[1]], middles.shape)
    return np.concatenate([middles, halves], axis=1), sums


def _cut_to_limits(land: Landscape, boxes: FloatArray) -> FloatArray:
    """Boxes without what lies outside of a start pose's limits."""
    if land.start is None:
        return boxes
    low, high = land.limits
    least = np.clip(boxes[:, :4] - boxes[:, 4:], low, high)
    greatest = np.clip(boxes[:, :4] + boxes[:, 4:], low, high)
    return np.concatenate([(least + greatest) / 2, (greatest - least) / 2], axis=1)

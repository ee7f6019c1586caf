"""Cells near rings and arcs that are the same: the fast ways agree with the plain ones."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

from fidmap.detect import find_barrel_parts
from fidmap.detect.arcs import Arcs, suppress
from fidmap.detect.cells import BandCells, band_cells
from fidmap.detect.coarse import coarser
from fidmap.detect.votes import boundary, centre_candidates
from fidmap.model import Label, TrinaryGrid


@pytest.mark.parametrize("counts", [[0, 0], [3, 0], [0, 3], [2, 0, 0, 4, 0]])
def test_rings_without_cells_count_nothing(counts: list[int]) -> None:
    """And take nothing away from the others."""
    values = np.arange(1.0, 1 + sum(counts))
    cells = BandCells(values, values, np.array(counts))

    owner = np.repeat(np.arange(len(counts)), counts)
    assert cells.sum(values) == pytest.approx(np.bincount(owner, values, len(counts)))
    some = values != 2
    assert cells.take(some).counts.tolist() == np.bincount(owner[some], minlength=len(counts)).tolist()


def test_the_cells_of_a_band_are_those_of_the_map() -> None:
    """Near the rim of the map too, where half of the ring lies outside."""
    random = np.random.default_rng(0)
    labels = random.integers(0, 3, (40, 50)).astype(np.uint8)
    centres = np.array([[20.2, 25.7], [0.4, 1.9], [39.0, 49.9], [-2.0, 10.0]])

    found = band_cells(labels, centres, radius=7.0, width=2.0)

    rows, columns = np.nonzero(labels == Label.OCCUPIED)
    for k, (row, column) in enumerate(centres):
        away = np.hypot(rows + 0.5 - row, columns + 0.5 - column)
        must = {(r + 0.5, c + 0.5) for r, c in zip(rows[abs(away - 7) <= 2], columns[abs(away - 7) <= 2], strict=True)}
        mine = set(zip(found.rows[found.ring == k].tolist(), found.columns[found.ring == k].tolist(), strict=True))
        may = {(r + 0.5, c + 0.5) for r, c in zip(rows, columns, strict=True)}
        assert must <= mine <= may


def test_of_arcs_that_are_the_same_the_first_is_kept() -> None:
    """As by comparing each with all that are kept already."""
    random = np.random.default_rng(1)
    n, radius = 300, 6.0
    arcs = Arcs(
        random.uniform(0, 90, (n, 2)),
        random.uniform(-np.pi, np.pi, n),
        np.sort(random.random(n))[::-1],
        random.choice([np.pi / 2, np.pi], n),
    )
    kept: list[int] = []
    for k in range(n):
        if not any(_same(arcs, j, k, radius) for j in kept):
            kept.append(k)

    assert suppress(arcs, radius).tolist() == kept
    assert 0 < len(kept) < n


def _same(arcs: Arcs, j: int, k: int, radius: float) -> bool:
    away = float(np.hypot(*(arcs.centres[j] - arcs.centres[k])))
    turned = abs(math.remainder(arcs.facings[j] - arcs.facings[k], 2 * math.pi))
    whole = max(arcs.reach[j], arcs.reach[k]) > 2
    if away < radius and turned < math.radians(75):
        return True
    return away < radius / 2 and (turned < math.radians(130) or whole)


def test_an_arc_drawn_too_small_is_drawn_all_the_same() -> None:
    """Mappers draw 0.278 m for 0.30 m: what is drawn is counted on the circle that the map shows."""
    labels = np.full((120, 120), Label.FREE, np.uint8)
    labels[:60] = Label.UNKNOWN
    labels[59] = Label.OCCUPIED
    turn = np.linspace(0, np.pi, 4000)
    for radius in (13.4, 13.9):
        rows, columns = 60 + radius * np.sin(turn), 60 + radius * np.cos(turn)
        labels[rows.astype(int), columns.astype(int)] = Label.OCCUPIED
    rows, columns = np.mgrid[0:120, 0:120] + 0.5
    labels[(np.hypot(rows - 60, columns - 60) < 13) & (rows > 60)] = Label.UNKNOWN

    part = find_barrel_parts(TrinaryGrid(labels, 0.02), 0.3)[0]

    assert part.confidence > 0.5
    assert math.degrees(part.drawn) > 160


@pytest.mark.parametrize("shape", [(6, 9), (7, 5), (2, 10)])
def test_coarser_cells_are_occupied_if_any_is_else_free_if_any_is(shape: tuple[int, int]) -> None:
    labels = np.random.default_rng(0).choice(list(Label), shape, p=[0.2, 0.7, 0.1]).astype(np.uint8)

    def one(block: npt.NDArray[np.uint8]) -> Label:
        return next((label for label in (Label.OCCUPIED, Label.FREE) if (block == label).any()), Label.UNKNOWN)

    blocks = [[one(labels[r : r + 3, c : c + 3]) for c in range(0, shape[1], 3)] for r in range(0, shape[0], 3)]
    assert coarser(labels, 3).tolist() == blocks
    assert coarser(labels, 1) is labels


def test_a_hatched_map_is_searched_no_longer_than_others() -> None:
    """Every cell of it gets as many votes as its neighbours along the hatching."""
    labels = np.tile(np.array([Label.FREE, Label.UNKNOWN, Label.OCCUPIED], np.uint8), (300, 100))
    assert len(centre_candidates(boundary(labels, 2.4), 2.4)) <= 300

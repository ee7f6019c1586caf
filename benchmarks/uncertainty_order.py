"""Is the mapper that `rank` says is better with 90 % truly better nine times in ten? Pairs of simulated mappers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from benchmarks.page import table
from benchmarks.uncertainty_arenas import D_MAX, Cell, Mapper, Scored, two_maps
from fidmap.model import CONTINUOUS
from fidmap.uncertainty.compare import GroupLoss, Losses, PartLoss, probability_better

CELLS = [Cell(n, 0.02, 0.04) for n in (10, 20, 50, 200)]
QUALITIES = (0.5, 4.0)
BINS = (0.5, 0.7, 0.9, 0.95, 1.0)
Claims = list[tuple[float, bool]]


def claims(cell: Cell, seed: int, pairs: int) -> Claims:
    """(probability of the likelier order, whether it is right) for pairs of mappers in one arena each.

    A mapper's errors and misses are those of the usual one times a factor, drawn evenly on a logarithmic scale.
    """
    found: Claims = []
    for k in range(pairs):
        random = np.random.default_rng([seed, 7, cell.parts, k])
        factors = QUALITIES[0] * (QUALITIES[1] / QUALITIES[0]) ** random.uniform(size=2)
        maps = two_maps(random, cell, (_mapper(factors[0]), _mapper(factors[1])), CONTINUOUS)
        said = probability_better(losses_of(maps[0]), losses_of(maps[1]))
        if said is not None:
            found.append((max(said, 1 - said), bool((said > 0.5) == (factors[0] < factors[1]))))
    return found


def _mapper(factor: float) -> Mapper:
    usual = Mapper()
    return replace(usual, shared_m=factor * usual.shared_m, own_m=factor * usual.own_m, missed=factor * usual.missed)


def losses_of(one: Scored) -> Losses:
    """What `rank` reads from a report."""
    parts = tuple(
        PartLoss(r.id, r.barrel is not None, _loss(r.relative_error_m), _loss(r.global_error_m))
        for r in one.measured.parts
    )
    groups = tuple(GroupLoss(g.group_class, g.pairs[0].parts, g.loss) for g in one.measured.groups)
    return Losses(parts, groups, CONTINUOUS.weights)


def _loss(error_m: float | None) -> float | None:
    return None if error_m is None else min(error_m, D_MAX) / D_MAX


def order_section(seed: int, pairs: int) -> str:
    """Stated and true shares, over all pairs and by what was stated, in percent."""
    lines = []
    for cell in CELLS:
        said = claims(cell, seed, pairs)
        cells = [_stated_and_right([c for c in said if low <= c[0] < high]) for low, high in _bins()]
        lines.append([cell.parts, _stated_and_right(said), *cells])
    head = ("N", "all", *(f"stated {100 * low:.0f} to {100 * min(1, high):.0f}" for low, high in _bins()))
    return (
        "### The probability that one mapper is better: stated, right (number of pairs)\n\n"
        f"Both in one arena, survey 2 cm, centres 4 cm; errors and misses {QUALITIES[0]:g} to {QUALITIES[1]:g} times "
        f"the usual mapper's, drawn on a logarithmic scale, {pairs} pairs per line.\n\n" + table(head, lines)
    )


def _bins() -> list[tuple[float, float]]:
    return [(low, math.inf if high == 1 else high) for low, high in pairwise(BINS)]


def _stated_and_right(said: Sequence[tuple[float, bool]]) -> str:
    if not said:
        return "-"
    stated, right = (100 * float(np.mean(values)) for values in zip(*said, strict=True))
    return f"{stated:.1f}, {right:.1f} ({len(said)})"

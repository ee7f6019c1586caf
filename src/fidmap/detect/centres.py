"""Centres of arcs from the votes of their directions, with the radius offset that a map's arcs share.

A half circle fixes its centre along the facing only through the radius, which mappers draw larger or smaller than it
is, all arcs of a map about alike. So the unknowns of a map with K arcs are their shifts s_k, a radius offset each, d_k,
and the map's, d: in the direction n the circle lies n . s_k + d_k outside of the fitted one, the d_k scatter about d.
That is linear, and solved by elimination. Lengths are cells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fidmap.detect.ballot import SURE, Votes
from fidmap.detect.network import weights
from fidmap.model import FloatArray


@dataclass(frozen=True)
class Centres:
    """K shifts (K, 2) along the facing and across it (counter-clockwise), and sigma (K,) per axis."""

    shifts: FloatArray
    sigma: FloatArray


def centres(votes: Votes, sure: FloatArray) -> Centres:
    """The most probable shifts of K arcs of one map, which tell its radius offset as surely (K,) as they are arcs.

    The equations are our own: docs/decisions/0016-centres-are-voted-for.md.
    """
    held, held_map, alike = np.exp(weights()["vote"]["prior"].astype(np.float64))
    towards = np.stack([np.cos(votes.relative), np.sin(votes.relative)], axis=2)
    pull = votes.weight * votes.outward
    weighed = votes.weight[..., None] * towards
    shift = weighed.transpose(0, 2, 1) @ towards + held * np.eye(2)
    to_shift = weighed.sum(axis=1)
    pulled = np.einsum("ka,kai->ki", pull, towards)
    inverse = np.linalg.inv(shift)
    turned = np.einsum("kij,kj->ki", inverse, to_shift)
    # what each arc knows of its own radius offset once its shift is free
    known = votes.weight.sum(axis=1) - (turned * to_shift).sum(axis=1)
    drawn = pull.sum(axis=1) - (turned * pulled).sum(axis=1)
    told = np.where(sure > SURE, sure, 0) * alike / (known + alike)
    map_known = held_map + (told * known).sum()
    usual = (told * drawn).sum() / map_known
    prior = 1 / (1 / alike + 1 / map_known)
    offset = (drawn + prior * usual) / (known + prior)
    shifts = np.einsum("kij,kj->ki", inverse, pulled) - turned * offset[:, None]
    spread = np.einsum("kii->k", inverse) + (turned**2).sum(axis=1) / (known + prior)
    return Centres(shifts, np.sqrt(spread / 2) * votes.widened)

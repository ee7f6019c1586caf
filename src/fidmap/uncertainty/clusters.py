"""Sums of losses per cluster: what is resampled together, since its errors belong together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.model import FloatArray

Indices = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Sums:
    """One attribute, a ratio of sums over clusters: losses (C,) and how many items carry them (C,)."""

    loss: FloatArray
    count: FloatArray

    def ratio(self, weight: FloatArray) -> FloatArray:
        """1 - mean loss under weights (B, C) of the clusters, NaN where no item is left."""
        count = weight @ self.count
        return np.asarray(1 - np.where(count > 0, weight @ self.loss, np.nan) / np.where(count > 0, count, 1.0))

    @property
    def clusters(self) -> int:
        """How many clusters have an item."""
        return int((self.count > 0).sum())


def cluster_of(part_ids: Sequence[str], groups: Sequence[Sequence[str]]) -> Indices:
    """(N,) the cluster of every part: parts that share a group belong together, directly or through others.

    Clusters are numbered by their least part id, so that the order of parts and groups does not matter.
    """
    home = {one: one for one in part_ids}

    def root(one: str) -> str:
        while home[one] != one:
            one = home[one]
        return one

    for group in groups:
        for one in group[1:]:
            a, b = sorted((root(group[0]), root(one)))
            home[b] = a
    roots = [root(one) for one in part_ids]
    number = {one: k for k, one in enumerate(sorted(set(roots)))}
    return np.array([number[one] for one in roots], np.intp)


def summed(cluster: Indices, loss: FloatArray, share: FloatArray, count: int) -> Sums:
    """Items (K,) of given clusters, with their losses and how much each counts."""
    return Sums(
        np.bincount(cluster, loss * share, minlength=count).astype(float),
        np.bincount(cluster, share, minlength=count).astype(float),
    )

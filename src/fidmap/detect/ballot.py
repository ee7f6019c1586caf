"""The learned part that measures: what each direction around an arc votes for, trained as the networks that find.

Mirrored strips give the same votes, mirrored: a direction sees its neighbours to both sides as sums.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fidmap.detect.network import BATCH, SingleArray, Weights, dense, weights
from fidmap.detect.polar import Windows
from fidmap.detect.strips import Strips
from fidmap.model import FloatArray, Label

SURE = 0.5  # arcs that tell how a map draws
BOUNDS = -8.0, 6.0  # of the logarithm of a direction's weight


@dataclass(frozen=True)
class Votes:
    """What K arcs show in D directions: how far outside of the fitted circle (cells), weights (1 / cells squared).

    relative: (K, D) directions from the facings. widened: (K,) what sigma is to be multiplied by.
    """

    outward: FloatArray
    weight: FloatArray
    relative: FloatArray
    widened: FloatArray


def vote(strips: Strips, sizes: FloatArray, sure: FloatArray) -> Votes:
    """What K arcs of one map vote for in each of their D directions.

    sizes: (K, 4) numbers about each arc and its map. sure: (K,) confidences: what the surest arcs look like on average
    tells how this map is drawn.
    """
    layer, relative = weights()["vote"], np.cos(strips.relative).astype(np.float32)
    blocks = [slice(k, k + BATCH) for k in range(0, max(1, len(sure)), BATCH)]
    seen = np.concatenate([_along(layer, strips.labels[b], relative[b], sizes[b]) for b in blocks])
    own = np.tanh(seen @ layer["pool.weight"].T + layer["pool.bias"]).mean(axis=1)
    trust = np.where(sure > SURE, sure, 0).astype(np.float32)
    usual = np.broadcast_to(trust @ own / (trust.sum() + 1e-3), own.shape)
    both, count = np.concatenate([own, usual], axis=1), seen.shape[2]
    bias = both @ layer["mid.weight"][:, count:].T + layer["mid.bias"]
    mixed = np.maximum(seen @ layer["mid.weight"][:, :count].T + bias[:, None], 0)
    out = np.asarray(mixed @ layer["out.weight"].T + layer["out.bias"], np.float64)
    z = np.concatenate([both, np.abs(own - usual), sizes.astype(np.float32)], axis=1)
    z = np.tanh(z @ layer["doubt.0.weight"].T + layer["doubt.0.bias"])
    widened = np.exp(np.asarray(z @ layer["doubt.2.weight"].T + layer["doubt.2.bias"], np.float64)[:, 0])
    return Votes(out[..., 0], np.exp(np.clip(out[..., 1], *BOUNDS)), strips.relative, widened)


def _along(layer: Weights, labels: Windows, relative: SingleArray, sizes: FloatArray) -> SingleArray:
    """(K, D, C) what each direction shows, with its neighbours; mirrored strips give mirrored answers."""
    weight, steps = layer["inp.weight"], labels.shape[2]
    seen = np.concatenate([labels == Label.OCCUPIED, labels == Label.FREE], axis=2).astype(np.float32)
    x = seen @ weight[:, : 2 * steps].T
    x += (sizes.astype(np.float32) @ weight[:, 2 * steps : -1].T)[:, None] + relative[..., None] * weight[:, -1]
    x = np.maximum(x + layer["inp.bias"], 0)
    for name, step in (("c1", 1), ("c2", 2)):
        x = dense(_beside(x, step), layer[f"{name}.weight"], layer[f"{name}.bias"])
    return x


def _beside(x: SingleArray, step: int) -> SingleArray:
    """(K, D, 3 C): each direction, the sum of its two neighbours, and of the two beyond them; nothing past the ends."""
    count, reach = x.shape[1], 2 * step
    wide = np.pad(x, ((0, 0), (reach, reach), (0, 0)))
    at = [wide[:, k * step : k * step + count] for k in range(5)]
    return np.concatenate([at[2], at[1] + at[3], at[0] + at[4]], axis=2)

"""The learned part that measures: what each direction around an arc votes for, trained as the networks that find.

Mirrored strips give the same votes, mirrored: a direction sees its neighbours to both sides as sums.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fidmap.detect.network import BATCH, SingleArray, Weights, cut_off, dense, product, weights
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
    single = sizes.astype(np.float32)
    blocks = [slice(k, k + BATCH) for k in range(0, max(1, len(sure)), BATCH)]
    seen = [_along(layer, strips.labels[b], relative[b], single[b]) for b in blocks]
    own = np.concatenate([np.tanh(product(x, layer["pool.weight"]) + layer["pool.bias"]).mean(axis=1) for x in seen])
    trust = np.where(sure > SURE, sure, 0).astype(np.float32)
    usual = np.broadcast_to(trust @ own / (trust.sum() + 1e-3), own.shape)
    both = np.concatenate([own, usual], axis=1)
    said = np.concatenate([_said(layer, x, both[b]) for x, b in zip(seen, blocks, strict=True)]).astype(np.float64)
    z = np.concatenate([both, np.abs(own - usual), single], axis=1)
    z = np.tanh(z @ layer["doubt.0.weight"].T + layer["doubt.0.bias"])
    widened = np.exp((z @ layer["doubt.2.weight"].T + layer["doubt.2.bias"])[:, 0].astype(np.float64))
    return Votes(said[..., 0], np.exp(np.clip(said[..., 1], *BOUNDS)), strips.relative, widened)


def _along(layer: Weights, labels: Windows, relative: SingleArray, sizes: SingleArray) -> SingleArray:
    """(K, D, C) what each direction shows, with its neighbours; mirrored strips give mirrored answers."""
    weight, steps = layer["inp.weight"], labels.shape[2]
    seen = np.concatenate([labels == Label.OCCUPIED, labels == Label.FREE], axis=2).astype(np.float32)
    x = product(seen, weight[:, : 2 * steps])
    x += (sizes @ weight[:, 2 * steps : -1].T + layer["inp.bias"])[:, None]
    x += relative[..., None] * weight[:, -1]
    cut_off(x)
    for name, step in (("c1", 1), ("c2", 2)):
        x = dense(_beside(x, step), layer[f"{name}.weight"], layer[f"{name}.bias"])
    return x


def _said(layer: Weights, seen: SingleArray, both: SingleArray) -> SingleArray:
    """(K, D, 2) how far outwards, and the logarithm of its weight: from what is seen and what arcs look like."""
    weight, count = layer["mid.weight"], seen.shape[2]
    z = product(seen, weight[:, :count])
    z += (both @ weight[:, count:].T + layer["mid.bias"])[:, None]
    return np.asarray(product(cut_off(z), layer["out.weight"]) + layer["out.bias"], np.float32)


def _beside(x: SingleArray, step: int) -> SingleArray:
    """(K, D, 3 C): each direction, the sum of its two neighbours, and of the two beyond them; nothing past the ends."""
    rows, count, width = x.shape
    wide = np.zeros((rows, count + 4 * step, width), np.float32)
    wide[:, 2 * step : 2 * step + count] = x
    beyond, before, after, past = (wide[:, k * step : k * step + count] for k in (0, 1, 3, 4))
    return np.concatenate([x, before + after, beyond + past], axis=2)

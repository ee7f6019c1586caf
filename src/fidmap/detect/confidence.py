"""How sure an arc is: a small network over its features, trained by `benchmarks/train_detector.py`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np

from fidmap.detect.arcs import Arcs
from fidmap.detect.features import features
from fidmap.detect.ring import RingSampler
from fidmap.model import FloatArray


@dataclass(frozen=True, eq=False)
class Network:
    """One hidden layer: sigmoid(tanh((x - mean) / scale @ hidden + hidden_bias) @ output + output_bias)."""

    mean: FloatArray
    scale: FloatArray
    hidden: FloatArray
    hidden_bias: FloatArray
    output: FloatArray
    output_bias: FloatArray

    def __call__(self, x: FloatArray) -> FloatArray:
        """Probabilities (H,) of rows (H, COUNT)."""
        inner = np.tanh((x - self.mean) / self.scale @ self.hidden + self.hidden_bias)
        return np.asarray(1 / (1 + np.exp(-(inner @ self.output + self.output_bias))))


@cache
def network() -> Network:
    """The network that comes with fidmap."""
    path = resources.files("fidmap.detect").joinpath("network.npz")
    with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
        return Network(**{name: stored[name].astype(np.float64) for name in Network.__dataclass_fields__})


def confidence(sampler: RingSampler, arcs: Arcs) -> FloatArray:
    """(H,) probability that each half circle is a part of a barrel."""
    return network()(features(sampler, arcs))

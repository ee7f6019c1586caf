"""The learned part that finds: small networks over polar windows, trained by `benchmarks/train_detector.py`.

`spot` looks at a candidate once and says for each direction whether a half circle faces it, and where its centre is;
`judge` looks at one half circle, turned to its facing. Both treat a map and its mirror image alike, up to rounding
`spot`. Single precision, batches that stay in the cache. The learned part that measures is in `ballot`.
"""

from __future__ import annotations

from functools import cache
from importlib import resources

import numpy as np
import numpy.typing as npt

from fidmap.detect.polar import Windows
from fidmap.model import FloatArray, Label

SingleArray = npt.NDArray[np.float32]
Weights = dict[str, SingleArray]
SPOT_ANGLES, SPOT_STEPS = 48, 20
JUDGE_ANGLES, JUDGE_STEPS = 64, 28
DILATIONS = (1, 3, 8)
USUAL_RADIUS = 7.0
BATCH = 64
MIRRORED = np.array([1, 1, -1, -1, 1], np.float32)  # what across and turn become in a mirror


@cache
def weights() -> dict[str, Weights]:
    """The numbers of the networks that come with fidmap, by network and layer."""
    path = resources.files("fidmap.detect").joinpath("network.npz")
    with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
        names = {name.split(".")[0] for name in stored.files}
        return {net: {n.split(".", 1)[1]: stored[n] for n in stored.files if n.startswith(f"{net}.")} for net in names}


def spot(windows: Windows, radius: float) -> FloatArray:
    """What (M, A, steps) windows show in each direction: (M, A, 4) logit, along, across (radii), turn (radians).

    A row of circular convolutions over the angles, so that turning a window turns the answer.
    """
    return _batches(_spot, windows, radius)


def judge(windows: Windows, radius: float) -> FloatArray:
    """What half circles are whose windows begin at their facing.

    (M, 5) logit, along, across (radii), turn (radians), and the logit of being a piece of a whole circle.
    """
    return _batches(_judge, windows, radius)


def probability(logit: FloatArray) -> FloatArray:
    """Logits to probabilities."""
    return np.asarray(1 / (1 + np.exp(-logit)))


def _batches(network, windows: Windows, radius: float) -> FloatArray:  # type: ignore[no-untyped-def]
    """A network over windows, few at a time."""
    found = [network(windows[k : k + BATCH], radius) for k in range(0, max(1, len(windows)), BATCH)]
    return np.asarray(np.concatenate(found), np.float64)


def _first(layer: Weights, windows: Windows, radius: float) -> SingleArray:
    """(M, A, C): each angle's steps by themselves, occupied and free cells apart, and the radius."""
    weight, steps = layer["inp.weight"], windows.shape[2]
    bias = layer["inp.bias"] + weight[:, 2 * steps] * np.float32(np.log(radius / USUAL_RADIUS))
    seen = np.concatenate([windows == Label.OCCUPIED, windows == Label.FREE], axis=2).astype(np.float32)
    return dense(seen, weight[:, : 2 * steps], bias)


def dense(x: SingleArray, weight: SingleArray, bias: SingleArray) -> SingleArray:
    """A layer over the last axis, negative answers cut off."""
    found = product(x, weight)
    found += bias
    return cut_off(found)


def cut_off(x: SingleArray) -> SingleArray:
    """Negative answers become 0, in place; against as many zeros, which numpy does twice as fast as against one."""
    return np.maximum(x, np.zeros_like(x), out=x)


def product(x: SingleArray, weight: SingleArray) -> SingleArray:
    """The product over the last axis, as one instead of one for each of the first."""
    return (x.reshape(-1, x.shape[-1]) @ weight.T).reshape(*x.shape[:-1], len(weight))


def _around(x: SingleArray, dilation: int, stride: int = 1) -> SingleArray:
    """(M, A/stride, 5, C): each angle with its two neighbours to both sides, around the circle."""
    angles = np.arange(0, x.shape[1], stride)[:, None] + dilation * np.arange(-2, 3)
    return np.asarray(x.take(angles % x.shape[1], axis=1))


def _joined(x: SingleArray) -> SingleArray:
    """The last two axes as one."""
    return x.reshape(*x.shape[:-2], x.shape[-2] * x.shape[-1])


def _spot(windows: Windows, radius: float) -> SingleArray:
    layer = weights()["spot"]
    x = _first(layer, windows, radius)
    for k, dilation in enumerate(DILATIONS):
        x = dense(_joined(_around(x, dilation)), layer[f"c.{k}.weight"], layer[f"c.{k}.bias"])
    return product(x, layer["out.weight"]) + layer["out.bias"]


def _judge(windows: Windows, radius: float) -> SingleArray:
    """The mean of what is made of windows and of their mirror images, whose angles see their neighbours swapped."""
    layer, mirror = weights()["judge"], _mirror()
    x = _around(_first(layer, windows, radius), 1, stride=2)
    x = dense(_joined(x), mirror["both.weight"], mirror["both.bias"])
    plain, mirrored = np.split(x, 2, axis=2)
    return np.asarray((_judged(plain, layer) + MIRRORED * _judged(mirrored, mirror)) / 2, np.float32)


def _judged(x: SingleArray, layer: Weights) -> SingleArray:
    """What the judge makes of (M, A, C) after its first convolution."""
    x = dense(_joined(_around(x, 1, stride=2)), layer["c2.weight"], layer["c2.bias"])
    x = dense(_joined(x), layer["h.weight"], layer["h.bias"])
    return x @ layer["out.weight"].T + layer["out.bias"]


@cache
def _mirror() -> Weights:
    """The judge's layers for mirror images whose angles stay in order; `both`: its first convolution, both ways."""
    layer = weights()["judge"]
    first, second = (layer[name].reshape(len(layer[name]), 5, -1) for name in ("c1.weight", "c2.weight"))
    last = layer["h.weight"].reshape(len(layer["h.weight"]), -1, len(second))
    return layer | {
        "both.weight": np.concatenate([layer["c1.weight"], _joined(first[:, ::-1])]),
        "both.bias": np.tile(layer["c1.bias"], 2),
        "c2.weight": _joined(second[:, ::-1]),
        "h.weight": _joined(np.roll(last[:, ::-1], 1, axis=1)),
    }

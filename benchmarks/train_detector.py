"""Trains the detector's confidence: `./run bench train_detector` writes src/fidmap/detect/network.npz.

Trained on artificial maps of the tune split and on run A2 of the real maps, on nothing else.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from scipy.optimize import minimize

from benchmarks.slam_challenge import DrawnPart, read_drawn_parts, real_data_root
from fidmap.detect.arcs import difference
from fidmap.detect.coarse import propose
from fidmap.detect.features import COUNT, features
from fidmap.grid import cells_to_metres, trinarize
from fidmap.maps import read_map
from fidmap.model import FloatArray, Label, TrinaryGrid
from fidmap.synth.poses import Tier
from fidmap.synth.suite import case_rng, make_case, random_spec
from fidmap.synth.truth import PartTruth

TARGET = Path(__file__).resolve().parents[1] / "src" / "fidmap" / "detect" / "network.npz"
SUITES: tuple[tuple[Tier, int], ...] = (
    ("clean", 140), ("noisy", 150), ("broken", 130), ("large", 3), ("office", 230), ("field", 110),
)  # fmt: skip
SEED = 1
A2 = (
    "m28",
    "m29",
    "m30",
    "m31",
    "m32",
    "m33",
    "m34",
    "m35",
    "m36",
    "m54",
    "m55",
    "m57",
    "m58",
    "m59",
    "m68",
    "m69",
)
A2_COPIES = 3
HIDDEN, RIDGE, STEPS = 32, 1e-4, 500
Table = tuple[FloatArray, FloatArray]


def table(grid: TrinaryGrid, radius_m: float, parts: Iterable[DrawnPart]) -> Table:
    """Features (H, COUNT) and labels (H,) of a map's hypotheses, those that count neither way left out."""
    sampler, arcs, factor = propose(grid.labels, radius_m / grid.resolution_m)
    places = cells_to_metres(arcs.centres * factor, grid.resolution_m, grid.origin)
    true, open_ = label(places, arcs.facings + grid.origin.yaw, radius_m, parts)
    x = features(sampler, arcs) if len(places) else np.empty((0, COUNT))
    return x[~open_], true[~open_].astype(float)


def label(
    places: FloatArray, facings: FloatArray, radius_m: float, parts: Iterable[DrawnPart]
) -> tuple[np.ndarray, np.ndarray]:
    """Which hypotheses are a drawn part (within R/4 and 30 degrees), and which are too near one to say."""
    true, unsure = np.zeros(len(places), bool), np.zeros(len(places), bool)
    for part in parts:
        for x, y in part.copies:
            unsure |= np.hypot(places[:, 0] - x, places[:, 1] - y) < 0.67 * radius_m
        if part.x_m is None or part.y_m is None:
            continue
        away = np.hypot(places[:, 0] - part.x_m, places[:, 1] - part.y_m)
        turned = np.zeros(len(places)) if part.facing is None else np.abs(difference(facings, np.array(part.facing)))
        unsure |= (away < 0.67 * radius_m) & (turned < np.radians(60))
        true |= (part.drawn == "yes") & (away < 0.25 * radius_m) & (turned < np.radians(30))
    return true, unsure & ~true


def drawn_part(truth: PartTruth) -> DrawnPart:
    """An artificial map's truth in the words of the real maps'."""
    return DrawnPart(truth.id, truth.drawn_x_m, truth.drawn_y_m, truth.drawn_facing, truth.drawn, tuple(truth.copies))


def synthetic(job: tuple[Tier, int]) -> Table:
    """The table of one artificial map of the tune split."""
    tier, index = job
    rng = case_rng("tune", SEED, tier, index)
    case = make_case(rng, random_spec(rng, tier), tier=tier)
    parts = [drawn_part(truth) for truth in case.truths]
    return table(worn(trinarize(case.grid), rng), case.arena.arena.radius_m, parts)


def worn(grid: TrinaryGrid, rng: np.random.Generator) -> TrinaryGrid:
    """Some maps in black and white, with thicker walls, or with holes in them: what programs and people do to maps."""
    labels = np.array(grid.labels)
    if rng.random() < 0.15:
        labels[labels == Label.UNKNOWN] = Label.FREE
    if rng.random() < 0.12:
        labels[cv2.dilate((labels == Label.OCCUPIED).astype(np.uint8), np.ones((2, 2), np.uint8)) > 0] = Label.OCCUPIED
    if rng.random() < 0.25:
        holes = (labels == Label.OCCUPIED) & (rng.random(labels.shape) < rng.uniform(0.03, 0.2))
        labels[holes] = rng.choice([Label.FREE, Label.UNKNOWN])
    return replace(grid, labels=labels)


def real() -> Iterator[Table]:
    """The tables of run A2."""
    folder = real_data_root() / "slam_challenge"
    for name in A2:
        grid = trinarize(read_map(folder / "maps" / f"{name}.yaml"))
        yield table(grid, 0.3, read_drawn_parts(folder, name))


def train(x: FloatArray, y: FloatArray, seed: int = 0) -> dict[str, FloatArray]:
    """Fit the network by maximum likelihood with a ridge (L-BFGS)."""
    mean, scale = x.mean(axis=0), x.std(axis=0) + 1e-3
    z = (x - mean) / scale
    random = np.random.default_rng(seed)
    shapes = [(z.shape[1], HIDDEN), (HIDDEN,), (HIDDEN,), ()]
    bounds = np.cumsum([0, *(int(np.prod(shape)) for shape in shapes)])

    def unpack(p: FloatArray) -> list[FloatArray]:
        return [p[a:b].reshape(s) for a, b, s in zip(bounds[:-1], bounds[1:], shapes, strict=True)]

    def loss(p: FloatArray) -> tuple[float, FloatArray]:
        hidden, hidden_bias, output, bias = unpack(p)
        inner = np.tanh(z @ hidden + hidden_bias)
        logit = inner @ output + bias
        error = (1 / (1 + np.exp(-logit)) - y) / len(y)
        back = error[:, None] * output * (1 - inner**2)
        value = (np.logaddexp(0, logit) - y * logit).mean() + RIDGE * ((hidden**2).sum() + (output**2).sum())
        parts = [
            z.T @ back + 2 * RIDGE * hidden,
            back.sum(axis=0),
            inner.T @ error + 2 * RIDGE * output,
            error.sum(),
        ]
        return float(value), np.concatenate([np.ravel(part) for part in parts])

    start = random.normal(size=bounds[-1]) / np.sqrt(z.shape[1])
    fitted = minimize(loss, start, jac=True, method="L-BFGS-B", options={"maxiter": STEPS}).x
    hidden, hidden_bias, output, bias = unpack(fitted)
    return {
        "mean": mean, "scale": scale, "hidden": hidden, "hidden_bias": hidden_bias, "output": output,
        "output_bias": bias,
    }  # fmt: skip


def artificial_tables() -> list[Table]:
    """The tables of all artificial maps."""
    jobs = [(tier, index) for tier, number in SUITES for index in range(number)]
    with ProcessPoolExecutor(2) as pool:
        made = list(pool.map(synthetic, jobs, chunksize=2))
    for tier, number in SUITES:
        mine = [t for t, job in zip(made, jobs, strict=True) if job[0] == tier]
        true, total = sum(t[1].sum() for t in mine), sum(len(t[1]) for t in mine)
        sys.stdout.write(f"{tier}: {number} maps, {total} hypotheses, {int(true)} of them true\n")
    return made


def main() -> int:
    """Make the maps, train, write the network."""
    both = artificial_tables() + list(real()) * A2_COPIES
    x, y = np.concatenate([t[0] for t in both]), np.concatenate([t[1] for t in both])
    if len(sys.argv) > 1:  # the numbers behind the network, to study them
        np.savez_compressed(sys.argv[1], x=x.astype(np.float32), y=y)
    stored = {name: value.astype(np.float32) for name, value in train(x, y).items()}
    np.savez(TARGET, **stored)  # type: ignore[arg-type]
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""`./run bench train_detector FOLDER`: makes artificial maps of the tune split and trains the detector's networks.

Needs PyTorch in .venv (`python3 -m pip --python .venv/bin/python install torch`), which nothing else here does. Maps
and tables are kept in FOLDER, so that a second run only trains. About two hours on two cores; writes network.npz.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

try:
    import torch
    from torch import Tensor, nn
    from torch.nn import functional
except ImportError:
    sys.exit("training needs PyTorch: python3 -m pip --python .venv/bin/python install torch")

from benchmarks.train_tables import correct_table, judge_table, make_maps, spot_table, tables
from fidmap.detect import network
from fidmap.detect.network import DILATIONS, JUDGE_STEPS, MIRRORED, SPOT_STEPS, USUAL_RADIUS

TARGET = Path(network.__file__).with_name("network.npz")
BATCH = 256
SPOT_WIDTH, JUDGE_WIDTHS, CORRECT_WIDTHS = 20, (32, 40, 40, 64), (32, 24)
EASY = 0.25  # share of the windows without anything near them that a round of `spot` looks at
TURNED = torch.tensor(MIRRORED[1:])  # along, across, turn, whole


def seen(windows: Tensor, radii: Tensor) -> Tensor:
    """(M, A, 2 steps + 1) what the networks' first layer is given: occupied, free, size."""
    size = torch.log(radii / USUAL_RADIUS)[:, None, None].expand(-1, windows.shape[1], 1)
    return torch.cat([(windows == 2).float(), (windows == 0).float(), size], -1)


class Spot(nn.Module):
    """Its layers and their names are those of `fidmap.detect.network.spot`."""

    def __init__(self) -> None:
        super().__init__()
        self.inp = nn.Linear(2 * SPOT_STEPS + 1, SPOT_WIDTH)
        self.c = nn.ModuleList([nn.Linear(5 * SPOT_WIDTH, SPOT_WIDTH) for _ in DILATIONS])
        self.out = nn.Linear(SPOT_WIDTH, 4)

    def forward(self, windows: Tensor, radii: Tensor) -> Tensor:
        """As the network of that name."""
        x = functional.relu(self.inp(seen(windows, radii)))
        for dilation, layer in zip(DILATIONS, self.c, strict=True):
            x = functional.relu(layer(torch.cat([x.roll(-k * dilation, 1) for k in range(-2, 3)], -1)))
        return self.out(x)


class Judge(nn.Module):
    """Its layers and their names are those of `fidmap.detect.network.judge`."""

    def __init__(self) -> None:
        super().__init__()
        a, b, c, d = JUDGE_WIDTHS
        self.inp = nn.Linear(2 * JUDGE_STEPS + 1, a)
        self.c1, self.c2 = nn.Linear(5 * a, b), nn.Linear(5 * b, c)
        self.h, self.out, self.drop = nn.Linear(16 * c, d), nn.Linear(d, 5), nn.Dropout(0.2)

    def forward(self, windows: Tensor, radii: Tensor) -> Tensor:
        """As the network of that name."""
        x = functional.relu(self.inp(seen(windows, radii)))
        for layer in (self.c1, self.c2):
            x = functional.relu(layer(torch.cat([x.roll(-k, 1)[:, ::2] for k in range(-2, 3)], -1)))
        return self.out(functional.relu(self.h(self.drop(x.flatten(1)))))


class Correct(nn.Module):
    """Its layers and their names are those of `fidmap.detect.network.correct`."""

    def __init__(self, even: Tensor, odd: Tensor) -> None:
        super().__init__()
        x, (a, b), self.drop = torch.cat([even, odd], 1), CORRECT_WIDTHS, nn.Dropout(0.1)
        mean = x.mean(0)
        mean[even.shape[1] :] = 0
        self.register_buffer("mean", mean)
        self.register_buffer("scale", x.std(0) + 1e-3)
        self.a, self.b, self.out = nn.Linear(x.shape[1], a), nn.Linear(a, b), nn.Linear(b, 3)

    def forward(self, even: Tensor, odd: Tensor) -> Tensor:
        """As the network of that name."""
        one, other = (self._one(torch.cat([even, sign * odd], 1)) for sign in (1, -1))
        return torch.stack([one[:, 0] + other[:, 0], one[:, 1] - other[:, 1], one[:, 2] + other[:, 2]], 1) / 2

    def _one(self, x: Tensor) -> Tensor:
        z = ((x - self.mean) / self.scale).clamp(-network.USUAL, network.USUAL)
        return self.out(torch.tanh(self.b(torch.tanh(self.a(self.drop(z))))))


def train(net: nn.Module, loss, choose, epochs: int, decay: float, rate: float = 4e-3) -> nn.Module:  # type: ignore[no-untyped-def]
    """AdamW in one cycle; `choose(generator)` gives an epoch's rows, `loss(rows, mirrored)` their mean loss."""
    generator = torch.Generator().manual_seed(0)
    steps = epochs * (len(choose(generator)) // BATCH)
    optimizer = torch.optim.AdamW(net.parameters(), lr=rate, weight_decay=decay)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, rate, total_steps=steps)
    start = time.monotonic()
    for epoch in range(epochs):
        rows, total = choose(generator), 0.0
        for k in range(len(rows) // BATCH):
            value = loss(rows[k * BATCH : (k + 1) * BATCH], bool(torch.rand(1, generator=generator) < 0.5))
            optimizer.zero_grad()
            value.backward()
            optimizer.step()
            schedule.step()
            total += value.item()
        done = total / max(1, len(rows) // BATCH)
        sys.stdout.write(f"{type(net).__name__} epoch {epoch}: loss {done:.4f}, {time.monotonic() - start:.0f} s\n")
    return net.eval()


def windows_loss(net: nn.Module, windows: Tensor, labels: Tensor, targets: Tensor, radii: Tensor, beta: float):  # type: ignore[no-untyped-def]
    """The loss of `spot` and `judge`: cross entropy of the labels, and how far true ones are from their targets."""

    def loss(rows: Tensor, mirrored: bool) -> Tensor:
        w, y, goal = windows[rows], labels[rows].float(), targets[rows]
        if mirrored:
            w, goal = w.flip(1).roll(1, 1), goal * TURNED
            if y.ndim == 2:  # one label for every direction
                y, goal = y.flip(1).roll(1, 1), goal.flip(1).roll(1, 1)
        answer = net(w, radii[rows])
        true = y == 1
        entropy = functional.binary_cross_entropy_with_logits(answer[..., 0][y >= 0], y[y >= 0])
        if not true.any():
            return entropy
        total = entropy + 0.4 * functional.smooth_l1_loss(answer[..., 1:4][true], goal[..., :3][true], beta=beta)
        if answer.shape[-1] > 4:  # the judge says whether it sees a whole barrel
            total = total + 0.2 * functional.binary_cross_entropy_with_logits(answer[..., 4][true], goal[..., 3][true])
        return total

    return loss


def stored(folder: Path, name: str, make, paths: list[Path], copies: int, worn: int = 1) -> list[Tensor]:  # type: ignore[no-untyped-def]
    """The columns of a table, made once."""
    path = folder / f"{name}.npz"
    if not path.exists():
        np.savez(path, *tables(make, paths, copies, worn))
    with np.load(path) as columns:
        found = [torch.from_numpy(columns[key]) for key in columns.files]
    return [column.float() if column.is_floating_point() else column for column in found]


def train_spot(columns: list[Tensor]) -> nn.Module:
    """On every window near something, and some of the others."""
    windows, labels, targets, radii = columns
    near = (labels != 0).any(1)
    hot, cold = torch.nonzero(near)[:, 0], torch.nonzero(~near)[:, 0]

    def choose(generator: torch.Generator) -> Tensor:
        some = cold[torch.randperm(len(cold), generator=generator)[: int(EASY * len(cold))]]
        rows = torch.cat([hot, some])
        return rows[torch.randperm(len(rows), generator=generator)]

    net = Spot()
    return train(net, windows_loss(net, windows, labels, targets, radii, 0.05), choose, epochs=10, decay=1e-4)


def train_judge(columns: list[Tensor]) -> nn.Module:
    """On every window that counts."""
    windows, labels, targets, radii = columns
    rows = torch.nonzero(labels >= 0)[:, 0]
    net = Judge()
    loss = windows_loss(net, windows, labels, targets, radii, 0.02)
    return train(net, loss, lambda g: rows[torch.randperm(len(rows), generator=g)], epochs=8, decay=3e-3)


def train_correct(columns: list[Tensor]) -> nn.Module:
    """By the likelihood of normal errors, so that sigma is honest on average."""
    even, odd, left, _ = columns
    net = Correct(even, odd)

    def loss(rows: Tensor, _: bool) -> Tensor:
        answer = net(even[rows], odd[rows])
        squares = ((left[rows] - answer[:, :2]) ** 2).sum(1) / 2
        return (squares / torch.exp(2 * answer[:, 2]) + 2 * answer[:, 2]).mean()

    return train(net, loss, lambda g: torch.randperm(len(left), generator=g), epochs=40, decay=1e-2, rate=5e-3)


def keep(name: str, net: nn.Module) -> None:
    """Put a network's numbers beside the others'."""
    kept = dict(np.load(TARGET)) if TARGET.exists() else {}
    kept = {key: value for key, value in kept.items() if not key.startswith(f"{name}.")}
    kept |= {f"{name}.{key}": value.numpy().astype(np.float32) for key, value in net.state_dict().items()}
    np.savez(TARGET, **kept)
    network.weights.cache_clear()


def main() -> int:
    """Each network learns from what those before it find."""
    if len(sys.argv) != 2:
        sys.stderr.write("usage: ./run bench train_detector FOLDER\n")
        return 2
    torch.set_num_threads(1)  # batches this small are slower on several
    torch.manual_seed(0)
    folder = Path(sys.argv[1])
    paths = make_maps(folder / "maps")
    keep("spot", train_spot(stored(folder, "spot", spot_table, paths, copies=3)))
    keep("judge", train_judge(stored(folder, "judge", judge_table, paths, copies=4, worn=2)))
    keep("correct", train_correct(stored(folder, "correct", correct_table, paths, copies=2)))
    return 0


if __name__ == "__main__":
    sys.exit(main())

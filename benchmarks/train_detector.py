"""`./run bench train_detector FOLDER`: makes artificial maps of the tune split and trains the detector's networks.

Needs PyTorch in .venv (`python3 -m pip --python .venv/bin/python install torch`), which nothing else here does. Maps
and tables are kept in FOLDER, so that a second run only trains. About three hours on two cores; writes network.npz.
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

from benchmarks.train_maps import A2, FINE, LOTS, make_maps
from benchmarks.train_tables import judge_table, spot_table, tables, vote_table
from fidmap.detect import network
from fidmap.detect.ballot import BOUNDS, SURE
from fidmap.detect.network import DILATIONS, JUDGE_STEPS, MIRRORED, SPOT_STEPS, USUAL_RADIUS
from fidmap.detect.strips import FAR, NEAR

TARGET = Path(network.__file__).with_name("network.npz")
SPOT_WIDTH, JUDGE_WIDTHS, VOTE_WIDTHS = 20, (32, 40, 40, 64), (32, 16, 24)
PLACES = len(NEAR) + len(FAR)
FOLD = 50  # maps in a row that a network sees or does not
VOTE_COPIES, REAL = 2, 16  # of the real maps in the table, and how often each counts where doubt is learned
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


class Vote(nn.Module):
    """Its layers and their names are those of `fidmap.detect.ballot.vote`, with the solution of `centres`."""

    def __init__(self) -> None:
        super().__init__()
        w, p, d = VOTE_WIDTHS
        self.inp, self.c1, self.c2 = nn.Linear(2 * PLACES + 5, w), nn.Linear(3 * w, w), nn.Linear(3 * w, w)
        self.pool, self.mid, self.out = nn.Linear(w, p), nn.Linear(w + 2 * p, w), nn.Linear(w, 2)
        self.doubt = nn.Sequential(nn.Linear(3 * p + 4, d), nn.Tanh(), nn.Linear(d, 1))
        self.prior = nn.Parameter(torch.tensor([-2.0, 0.0, 2.0]))
        with torch.no_grad():  # begin with the fitted circle
            self.out.weight *= 0.1
            self.out.bias.zero_()
            self.doubt[2].weight *= 0.1

    def forward(self, labels: Tensor, relative: Tensor, sizes: Tensor, sure: Tensor, which: Tensor) -> Tensor:
        """(K, 3) along, across and log sigma of arcs of several maps, `which` map each."""
        ahead = torch.cos(relative)[..., None]
        around = sizes[:, None].expand(-1, labels.shape[1], -1)
        x = functional.relu(self.inp(torch.cat([(labels == 2).float(), (labels == 0).float(), around, ahead], -1)))
        x = functional.relu(self.c1(beside(x, 1)))
        x = functional.relu(self.c2(beside(x, 2)))
        trust = torch.where(sure > SURE, sure, 0.0)
        own = torch.tanh(self.pool(x)).mean(1)
        usual = (summed(own * trust[:, None], which) / (summed(trust, which) + 1e-3)[:, None])[which]
        both = torch.cat([own, usual], 1)
        z = functional.relu(self.mid(torch.cat([x, both[:, None].expand(-1, x.shape[1], -1)], -1)))
        outward, weight = self.out(z).unbind(-1)
        doubt = self.doubt(torch.cat([both, (own - usual).abs(), sizes], 1))[:, 0]
        return self.solved(outward, torch.exp(weight.clamp(*BOUNDS)), relative, trust, which, doubt)

    def solved(self, outward, weight, relative, trust, which, doubt) -> Tensor:  # type: ignore[no-untyped-def]
        """As `centres`, whose names these are."""
        held, held_map, alike = torch.exp(self.prior)
        towards = torch.stack([torch.cos(relative), torch.sin(relative)], -1)
        shift = torch.einsum("ka,kai,kaj->kij", weight, towards, towards) + held * torch.eye(2)
        to_shift = torch.einsum("ka,kai->ki", weight, towards)
        pulled = torch.einsum("ka,kai->ki", weight * outward, towards)
        inverse = torch.linalg.inv(shift)
        turned = torch.einsum("kij,kj->ki", inverse, to_shift)
        known = weight.sum(1) - (turned * to_shift).sum(1)
        drawn = (weight * outward).sum(1) - (turned * pulled).sum(1)
        told = trust * alike / (known + alike)
        map_known = held_map + summed(told * known, which)
        usual, prior = summed(told * drawn, which) / map_known, 1 / (1 / alike + 1 / map_known)
        offset = (drawn + (prior * usual)[which]) / (known + prior[which])
        shifts = torch.einsum("kij,kj->ki", inverse, pulled) - turned * offset[:, None]
        spread = torch.einsum("kii->k", inverse) + (turned**2).sum(1) / (known + prior[which])
        return torch.cat([shifts, (torch.log(spread / 2) / 2 + doubt)[:, None]], 1)


def beside(x: Tensor, step: int) -> Tensor:
    """As `ballot._beside`."""
    wide = functional.pad(x, (0, 0, 2 * step, 2 * step))
    at = [wide[:, k * step : k * step + x.shape[1]] for k in range(5)]
    return torch.cat([at[2], at[1] + at[3], at[0] + at[4]], -1)


def summed(values: Tensor, which: Tensor) -> Tensor:
    """Sums of arcs' values over their maps."""
    total = torch.zeros(int(which.max()) + 1, *values.shape[1:])
    return total.index_add(0, which, values)


def train(net: nn.Module, loss, choose, epochs: int, decay: float, rate: float = 4e-3, batch: int = 256) -> nn.Module:  # type: ignore[no-untyped-def]
    """AdamW in one cycle; `choose(generator)` gives an epoch's rows, `loss(rows, mirrored)` their mean loss."""
    generator = torch.Generator().manual_seed(0)
    steps = epochs * (len(choose(generator)) // batch)
    optimizer = torch.optim.AdamW(net.parameters(), lr=rate, weight_decay=decay)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, rate, total_steps=steps)
    start = time.monotonic()
    for epoch in range(epochs):
        rows, total = choose(generator), 0.0
        for k in range(len(rows) // batch):
            value = loss(rows[k * batch : (k + 1) * batch], bool(torch.rand(1, generator=generator) < 0.5))
            optimizer.zero_grad()
            value.backward()
            nn.utils.clip_grad_norm_(net.parameters(), 5.0)
            optimizer.step()
            schedule.step()
            total += value.item()
        done = total / max(1, len(rows) // batch)
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


def train_vote(columns: list[Tensor]) -> nn.Module:
    """By the likelihood of normal errors, so that sigma is honest on average; batches are of whole maps.

    An error is what is left to where the map shows the part and, counting as much, to where its scans put it: what
    programs and people call the place where a map draws a part lies between the two.

    How much to doubt is learned again, from the scans alone, which lie farther off: what smears and erasing leave open
    is doubt that real maps have too. That is on a fifth of the maps that the rest has not seen, since a network is
    surer on its own maps than it may be, and on run A2 several times over, all that is known of real maps; it stands
    last in the table.
    """
    labels, relative, sizes, sure, left, first = columns
    begins = torch.nonzero(first)[:, 0]
    maps = torch.stack([begins, torch.cat([begins[1:], torch.tensor([len(first)])])], 1)
    unseen = torch.arange(len(maps)) // FOLD % 5 == 0  # a map's copies follow each other
    net = Vote()

    def loss(goals: Tensor, rows: Tensor) -> Tensor:
        arcs = [torch.arange(*maps[k].tolist()) for k in rows]
        which = torch.repeat_interleave(torch.arange(len(arcs)), torch.tensor([len(a) for a in arcs]))
        a = torch.cat(arcs)
        answer = net(labels[a], relative[a], sizes[a], sure[a], which)
        known = torch.isfinite(goals[a, :, 0])
        squares = ((goals[a] - answer[:, None, :2])[known] ** 2).sum(1) / 2
        log_sigma = answer[:, 2:].expand_as(known)[known]
        return (squares / torch.exp(2 * log_sigma) + 2 * log_sigma).mean()

    def some(rows: Tensor):  # type: ignore[no-untyped-def]
        return lambda g: rows[torch.randperm(len(rows), generator=g)]

    train(net, lambda rows, _: loss(left, rows), some(torch.nonzero(~unseen)[:, 0]), 45, 1e-3, rate=3e-3, batch=16)
    for name, values in net.named_parameters():
        values.requires_grad = name.startswith("doubt")
    real = torch.arange(len(maps))[-VOTE_COPIES * len(A2) :]
    rows = torch.cat([torch.nonzero(unseen)[:, 0], real.repeat(REAL)])
    return train(net, lambda rows, _: loss(left[:, 1:], rows), some(rows), 20, 1e-2, rate=3e-3, batch=16)


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
    paths = make_maps(folder / "maps", (0, FINE))  # with all of them the judge gets worse: docs/decisions, 0015
    keep("spot", train_spot(stored(folder, "spot", spot_table, paths, copies=3)))
    keep("judge", train_judge(stored(folder, "judge", judge_table, paths, copies=4, worn=2)))
    paths = make_maps(folder / "maps", LOTS)
    keep("vote", train_vote(stored(folder, "vote", vote_table, paths, copies=VOTE_COPIES, worn=2)))
    return 0


if __name__ == "__main__":
    sys.exit(main())

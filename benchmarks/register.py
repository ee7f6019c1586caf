"""`./run bench register [--quick|--all]`: registrations: how near the optimum, how well proven, how long.

CPU time of one thread. The 60 given cases are read from the folder that FIDMAP_REAL_DATA names: those of up to 50
parts, with `--all` the others too. 60 of our own follow from seeds, with `--all` 300. Peers take seconds each: they
look at every third given case of up to 20 parts, with `--all` at all of these. Writes its section but for `--quick`.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.page import table, write_section
from benchmarks.register_cases import Case, given, own
from benchmarks.register_peers import PEERS, problem_of, prototype
from fidmap.model import CONTINUOUS, SSRR2011, BarrelPart, Settings
from fidmap.register.optimum import Optimum, find
from fidmap.register.problem import make_problem
from fidmap.register.runner_up import find_runner_up

SIMILAR = replace(CONTINUOUS, transform="similarity")
CUT_SHORT = """The search for a runner-up ends after three boxes for every one of the main search, or 5,000: where that
is not enough for 1 %, its bound is what was proven by then.
"""
HEAD = ["", "cases", "within 0.1 % of the known optimum", "certified", "CPU s: median", "p95", "most"]
PEER_PARTS = 20
PEERS_SEE = 3  # every so manieth case


@dataclass(frozen=True)
class Run:
    """One search: its case, what it found, its seconds of CPU, and whether that is near the known optimum."""

    case: Case
    optimum: Optimum
    seconds: float
    known: float | None

    @property
    def value(self) -> float:
        """The greatest value found."""
        return self.optimum.maxima[0].value if self.optimum.maxima else 0.0

    def certified(self, tolerance: float) -> bool:
        """Whether the bound is that near (as a share) to the value."""
        bound = self.optimum.upper_bound
        return bound is not None and bound <= self.value * (1 + tolerance) + 1e-6


def search(case: Case, settings: Settings, key: str, fast: bool = False, fixed: bool = False) -> Run:
    """Time one search."""
    parts: tuple[BarrelPart, ...] = case.fixed() if fixed else case.parts
    start = time.process_time()
    optimum = find(make_problem(parts, case.arena, settings), None, fast)
    return Run(case, optimum, time.process_time() - start, case.best.get(key))


def row(name: str, runs: Sequence[Run], tolerance: float, share: float = 1e-3) -> list[object]:
    """A line of the table."""
    known = [run for run in runs if run.known is not None]
    near = sum(run.value >= (run.known or 0.0) * (1 - share) - 1e-6 for run in known)
    seconds = [run.seconds for run in runs]
    proven = sum(run.certified(tolerance) for run in runs)
    bounds = f"{proven} of {len(runs)}" if runs[0].optimum.upper_bound is not None else "not certified"
    return [
        name, len(runs), f"{near} of {len(known)}" if known else "-", bounds,
        *(f"{v:.3f}" for v in (np.median(seconds), np.percentile(seconds, 95), max(seconds))),
    ]  # fmt: skip


def given_rows(small: list[Case], large: list[Case]) -> list[list[object]]:
    """The table of the goals on given cases, the rigid search of small ones aside."""
    tiny = [c for c in small if len(c.arena.parts) <= 30]
    rows = []
    if large:
        rows.append(row("rigid, N > 50", [search(c, CONTINUOUS, "rigid") for c in large], 1.001e-3))
        rows.append(row("`--fast`, N > 50", [search(c, CONTINUOUS, "rigid", fast=True) for c in large], 0))
    rows.append(row("`--fast`, N <= 50", [search(c, CONTINUOUS, "rigid", fast=True) for c in small], 0))
    rows.append(
        row("steps, N <= 50 (exact)", [search(c, SSRR2011, "rigid_discretised_nearest") for c in small], 0, share=0)
    )
    fixed = [search(c, CONTINUOUS, "fixed_assignment_rigid", fixed=True) for c in small]
    rows.append(row("assignment fixed (1e-4), N <= 50", fixed, 1.01e-4, share=1e-4))
    stepped = [search(c, SSRR2011, "fixed_assignment_discretised", fixed=True) for c in small]
    rows.append(row("assignment fixed, steps (exact)", stepped, 0, share=0))
    rows.append(row("similarity, N <= 30", [search(c, SIMILAR, "similarity") for c in tiny], 1.001e-3))
    return rows


def runner_up_row(name: str, runs: Sequence[Run]) -> list[object]:
    """How often another registration is nearly as good, and what proving that took against the main search."""
    ambiguous, proven, ratios = 0, 0, []
    for run in runs:
        if not run.optimum.maxima or len(run.optimum.maxima[0].pairs) < 3:
            continue
        start = time.process_time()
        best = run.optimum.maxima[0]
        found, _ = find_runner_up(problem_of(run.case), run.case.arena, None, run.optimum, best)
        ratios.append((time.process_time() - start) / run.seconds)
        ambiguous += found.value >= 0.95 * run.value
        proven += found.upper_bound <= found.value * 1.0101
    count = len(ratios)
    return [
        name, count, f"{ambiguous} ({ambiguous / count:.0%})", f"{proven} of {count}",
        f"{np.median(ratios):.1f}", f"{np.percentile(ratios, 90):.1f}",
    ]  # fmt: skip


def prototype_row(runs: Sequence[Run]) -> tuple[list[list[object]], str]:
    """The prototype on the same cases: a line of the same table, where it is at hand, and a remark."""
    theirs = prototype([run.case for run in runs])
    if theirs is None:
        return [], "The prototype was left out: it is not beside the checkout."
    both = list(zip(runs, theirs.solved, strict=True))
    near = sum(value >= (run.known or 0.0) * 0.999 - 1e-6 for run, (value, _, _) in both)
    proven = sum(bound <= value * 1.001001 + 1e-6 for value, bound, _ in theirs.solved)
    seconds = [one for _, _, one in theirs.solved]
    times = (f"{v:.3f}" for v in (np.median(seconds), np.percentile(seconds, 95), max(seconds)))
    shares = [f"{near} of {len(runs)}", f"{proven} of {len(runs)}"]
    remark = f"The prototype compiles for {theirs.compiling_s:.0f} s at its first use, which its times leave out."
    return [["the prototype, rigid, N <= 50", len(runs), *shares, *times]], remark


def peer_rows(ours: Sequence[Run]) -> list[list[object]]:
    """The peers on small cases; how near they come to what was certified."""
    own_time = np.median([run.seconds for run in ours])
    rows: list[list[object]] = [["fidmap", len(ours), len(ours), "1.000", f"{own_time:.3f}"]]
    for name, peer in PEERS.items():
        shares, seconds = [], []
        for run in ours:
            problem, start = problem_of(run.case), time.process_time()
            shares.append(peer(run.case, problem) / run.value)
            seconds.append(time.process_time() - start)
        near = sum(share >= 0.999 for share in shares)
        rows.append([name, len(ours), near, f"{np.mean(shares):.3f}", f"{np.median(seconds):.3f}"])
    return rows


def measured(quick: bool, everything: bool) -> str:
    """The section's text."""
    most = 12 if quick else 50
    cases = given()
    small = [c for c in cases if len(c.arena.parts) <= most]
    large = [c for c in cases if len(c.arena.parts) > 50] if everything else []
    faced = [c for c in given(faced=True) if len(c.arena.parts) <= most]
    ours = [own(seed) for seed in range(10 if quick else 300 if everything else 60)]
    runs = [search(c, CONTINUOUS, "rigid") for c in small]
    seen = [run for run in runs if len(run.case.arena.parts) <= PEER_PARTS]
    seen = seen[:: 1 if everything else PEERS_SEE]
    faced_runs = [search(c, CONTINUOUS, "") for c in faced]
    own_runs = [search(c, CONTINUOUS, "") for c in ours]
    theirs, remark = prototype_row(runs)
    rows = [row("rigid, N <= 50", runs, 1.001e-3), *theirs, *given_rows(small, large)]
    rows.append(row("given, with facings, N <= 50", faced_runs, 1.001e-3))
    rows.append(row("our own with facings", own_runs, 1.001e-3))
    rivals = [
        runner_up_row("given, without facings", runs),
        runner_up_row("given, with facings", faced_runs),
        runner_up_row("our own with facings", own_runs),
    ]
    parts = [
        f"{len(small) + len(large)} of the {len(cases)} given cases and {len(ours)} of our own; with `--all` all of "
        f"them and 300. The peers see {len(seen)} of the given cases: {', '.join(run.case.name for run in seen)}.\n",
        table(HEAD, rows),
        remark + "\n",
        table(["runner-up", "cases", "ambiguous", "certified at 1 %", "time against main: median", "p90"], rivals),
        CUT_SHORT,
        table(["", "cases", "within 0.1 %", "mean share of the optimum", "CPU s: median"], peer_rows(seen)),
    ]
    return "## Registrations\n\n" + "\n".join(parts)


def main() -> int:
    """Measure and write; `--quick` looks at few and small cases, and writes nothing."""
    quick = "--quick" in sys.argv[1:]
    if not given():
        sys.stderr.write("the given cases are missing: set FIDMAP_REAL_DATA to the folder that holds them\n")
        return 1
    text = measured(quick, "--all" in sys.argv[1:])
    sys.stdout.write(text)
    if not quick:
        write_section("register", text)
    return 0


if __name__ == "__main__":
    sys.exit(main())

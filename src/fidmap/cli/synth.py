"""`fidmap synth`."""

from __future__ import annotations

import os
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fidmap.cli import options
from fidmap.cli.exits import DONE, UNUSABLE, complain, guarded, usage

if TYPE_CHECKING:
    from fidmap.study.artificial import Made, SynthJob

app = typer.Typer(
    help="Artificial arenas and maps with the truth about them.", no_args_is_help=True, rich_markup_mode=None
)


class SplitWord(StrEnum):
    """Two families of maps that share no random number."""

    TUNE = "tune"
    TEST = "test"


class TierWord(StrEnum):
    """How good the poses are, or another place than a maze."""

    EXACT = "exact"
    CLEAN = "clean"
    NOISY = "noisy"
    BROKEN = "broken"
    LARGE = "large"
    OFFICE = "office"
    FIELD = "field"


Seed = Annotated[int, typer.Option("--seed", min=0, help="Which ones: the same seed gives the same maps.")]
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Where the files go.")]
Radius = Annotated[float | None, typer.Option("--radius", metavar="M", help="Radius of the barrels in metres.")]
SUITE_TIERS = [tier for tier in TierWord if tier not in {TierWord.EXACT, TierWord.LARGE}]


def suite(
    folder: Folder,
    split: Annotated[SplitWord, typer.Option("--split", help="'tune' to develop on, 'test' to report on.")],
    seed: Seed,
    tiers: Annotated[
        list[TierWord] | None,
        typer.Option("--tier", help="Repeat for several; without it clean, noisy, broken, office, field."),
    ] = None,
    maps: Annotated[int, typer.Option("--maps", min=1, max=100_000, help="Maps of each tier.")] = 10,
    workers: options.Workers = 0,
) -> None:
    """Many random maps, each in a folder of its own with its arena and its truth; their paths on stdout."""
    from fidmap.study.artificial import SynthJob

    chosen = list(dict.fromkeys(tiers or SUITE_TIERS))
    jobs = [
        SynthJob(folder / f"{split}-{tier}-{seed}-{index:03d}", split.value, seed, tier.value, index)
        for tier in chosen
        for index in range(maps)
    ]
    _run(jobs, workers)


def one_map(
    folder: Folder,
    seed: Seed,
    tier: Annotated[TierWord, typer.Option("--tier", help="How good the poses are, or which place.")] = TierWord.CLEAN,
    split: Annotated[SplitWord, typer.Option("--split", help="Which family of random numbers.")] = SplitWord.TUNE,
    mapper: Annotated[str | None, typer.Option("--mapper", help="Manner of mapping; without it a random one.")] = None,
    resolution: Annotated[
        float | None, typer.Option("--resolution", metavar="M_PER_CELL", help="Side of a cell.")
    ] = None,
    radius: Radius = None,
    pose_errors: Annotated[
        float, typer.Option("--pose-errors", metavar="TIMES", help="What the tier's errors of poses are multiplied by.")
    ] = 1.0,
) -> None:
    """One map with its arena and its truth in DIR; what is not given is drawn at random."""
    from fidmap.study.artificial import SynthJob
    from fidmap.synth.mappers import MAPPERS

    if mapper is not None and mapper not in MAPPERS:
        raise usage(f"--mapper {mapper}: expected one of {', '.join(MAPPERS)}")
    if resolution is not None and not 0.005 <= resolution <= 0.25:
        raise usage(f"--resolution {resolution}: expected 0.005 to 0.25 metres")
    if not 0 <= pose_errors <= 10:
        raise usage(f"--pose-errors {pose_errors}: expected 0 (true poses) to 10 times those of the tier")
    _check_radius(radius)
    job = SynthJob(
        folder, split.value, seed, tier.value, mapper=mapper, resolution_m=resolution, radius_m=radius,
        pose_errors=pose_errors,
    )  # fmt: skip
    _run([job], 1)


def arena(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The arena file to write.")],
    seed: Seed,
    tier: Annotated[TierWord, typer.Option("--tier", help="'office', 'field', or any other: a maze.")] = TierWord.CLEAN,
    radius: Radius = None,
) -> None:
    """A random arena as an arena file, to try layouts and scoring settings on."""
    from fidmap.arena.write import write_arena
    from fidmap.study.artificial import SynthJob, random_arena

    _check_radius(radius)
    write_arena(file, random_arena(SynthJob(file, "tune", seed, tier.value, radius_m=radius)))
    typer.echo(file)


def _check_radius(radius: float | None) -> None:
    if radius is not None and not 0.05 <= radius <= 1:
        raise usage(f"--radius {radius}: expected 0.05 to 1 metre")


def _run(jobs: list[SynthJob], workers: int) -> None:
    """Make and write all; paths of the maps on stdout in the order of the jobs."""
    from rich.console import Console
    from rich.progress import Progress

    from fidmap.study import artificial
    from fidmap.study.pool import run

    code = DONE
    with Progress(console=Console(stderr=True), transient=True, disable=len(jobs) < 2) as progress:
        task = progress.add_task("mapping", total=len(jobs))
        for made in run(jobs, artificial.make, artificial.died, min(workers or os.cpu_count() or 1, len(jobs))):
            code = max(code, _tell(made))
            progress.advance(task)
    raise typer.Exit(code)


def _tell(made: Made) -> int:
    """The path of a map, or why there is none."""
    if made.error is not None:
        complain(made.error)
        return UNUSABLE
    typer.echo(made.map)
    return DONE


app.command("suite")(guarded(suite))
app.command("map")(guarded(one_map))
app.command("arena")(guarded(arena))

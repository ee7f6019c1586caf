"""The command line: one file per command; arguments, clock and exit codes only.

Heavy imports happen inside the commands, so that `fidmap --help` answers at once.
"""

from __future__ import annotations

import os
import sys
from typing import Annotated

import typer

from fidmap.cli import convert, demo, detect, inspect, profile, rank, score, synth
from fidmap.cli.exits import UNUSABLE, complain, guarded
from fidmap.version import __version__

app = typer.Typer(
    name="fidmap",
    help="How good is a robot's map? Scores occupancy grids by the fiducials (half barrels) drawn in them.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"fidmap {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    _version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """How good is a robot's map? Scores occupancy grids by the fiducials (half barrels) drawn in them."""


app.command("score")(guarded(score.score))
app.command("detect")(guarded(detect.detect))
app.command("inspect")(guarded(inspect.inspect))
app.command("convert")(guarded(convert.convert))
app.command("rank")(guarded(rank.rank))
app.add_typer(profile.app, name="profile")
app.add_typer(synth.app, name="synth")
app.command("demo")(guarded(demo.demo))


def main() -> None:
    """The console script."""
    # one thread a process: maps are what runs side by side, our matrices are small, and sums keep their order
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"):
        os.environ.setdefault(name, "1")
    try:
        app()
    except BrokenPipeError:
        # a pipe that is closed early (fidmap ... | head) is no fault of the user's
        sys.stderr.close()
        sys.exit(UNUSABLE)
    except OSError as error:
        if error.filename is not None:
            raise
        complain(f"the result could not be written to stdout ({error.strerror})")
        sys.exit(UNUSABLE)

"""Exit codes and how faults are told: one line on stderr each, a traceback only for our own bugs."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from typing import ParamSpec

import typer

from fidmap.report.wording import clean

DONE, UNUSABLE, USAGE, GATE_FAILED = 0, 1, 2, 3
Parameters = ParamSpec("Parameters")


def guarded(command: Callable[Parameters, None]) -> Callable[Parameters, None]:
    """The command with known faults as one line on stderr and exit code 1."""

    @functools.wraps(command)
    def run(*args: Parameters.args, **kwargs: Parameters.kwargs) -> None:
        try:
            command(*args, **kwargs)
        except typer.Exit:
            raise
        except Exception as error:
            from fidmap.model import FidmapError  # brings numpy along, so not before a command runs

            if not isinstance(error, FidmapError):
                raise
            complain(str(error))
            raise typer.Exit(UNUSABLE) from None

    return run


def complain(text: str) -> None:
    """One line for a person, whatever file names it quotes; above the progress bar where there is one."""
    sys.stderr.write(f"fidmap: {clean(text)}\n")
    sys.stderr.flush()


def usage(text: str) -> typer.Exit:
    """What to raise on wrong usage, after saying why."""
    complain(f"{text} (see --help)")
    return typer.Exit(USAGE)

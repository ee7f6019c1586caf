"""Libraries that only some formats need: a missing one is told with the command that installs it."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class MissingLibraryError(Exception):
    """What is missing and how to install it; the reader of a file names the file."""


def need(module: str, extra: str, what: str) -> Any:
    """Import a library of an extra.

    Raises:
        MissingLibraryError: it is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        library = module.partition(".")[0]
        raise MissingLibraryError(
            f"is {what}, which needs the library {library}; install it with pip install 'fidmap[{extra}]'"
        ) from None

"""Files that the program writes: whole or not at all."""

from __future__ import annotations

import secrets
from pathlib import Path

from fidmap.model import OutputError


def write_whole(path: Path, data: bytes) -> None:
    """Write a file beside its place and move it there when it is complete; missing folders are made.

    Raises:
        OutputError: the place cannot be written.
    """
    stage = path.with_name(f".{path.name}.{secrets.token_hex(6)}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            stage.write_bytes(data)
            stage.replace(path)
        finally:
            stage.unlink(missing_ok=True)
    except OSError as error:
        why = error.strerror or str(error)
        raise OutputError(f"{path}: cannot be written ({why}); choose another place") from error

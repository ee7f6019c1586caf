"""Files from outside: bounded reading, and faults told in one sentence.

A subject is how a sentence about a file starts: the path as the user named it, or `m.yaml: its image m.pgm`.
"""

from __future__ import annotations

import stat
from pathlib import Path

from fidmap.model import MapFileError

READABLE = "a map_server YAML or a PGM, PNG, BMP, JPEG or TIFF image"
MAX_IMAGE_BYTES = 1_200_000_000
MAX_CELLS = 400_000_000


def printable(text: object, limit: int = 300) -> str:
    """Text fit for one line: a file name may hold line breaks and terminal codes."""
    line = "".join(c if c.isprintable() else "?" for c in str(text))
    return line if len(line) <= limit else f"{line[:limit]}..."


def fault(subject: object, predicate: str) -> MapFileError:
    """The error whose text is one line: the subject, then what is wrong with it, expected and to be done."""
    return MapFileError(f"{printable(subject, 600)} {printable(predicate, 2000)}")


def exists(path: Path) -> bool:
    """Whether something is there; a path that cannot even be asked about (no permission, NUL) is not."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def read_bytes(path: Path, subject: object, limit: int, kind: str = "") -> bytes:
    """Read a regular file of at most `limit` bytes; without a `kind` only its beginning is read.

    Args:
        path: the file.
        subject: how sentences about it start.
        limit: largest size in bytes.
        kind: what a larger file is not.

    Raises:
        MapFileError: missing, not a regular file, unreadable, empty, or too large; nothing was read then.
    """
    try:
        size = regular_size(path, subject)
        if kind and size > limit:
            raise fault(subject, f"is not {kind} of at most {limit:,} bytes; expected {READABLE}")
        with path.open("rb") as file:
            # Asking for `limit` bytes would take that much memory for the smallest file.
            data = file.read(min(size, limit))
    except PermissionError:
        raise fault(subject, "cannot be read: permission denied; make it readable (chmod +r)") from None
    except (FileNotFoundError, NotADirectoryError):
        raise fault(subject, f"does not exist; expected {READABLE}, so check the path") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise fault(subject, f"cannot be read ({reason}); check the path") from None
    if not data:
        raise fault(subject, f"is empty (0 bytes); expected {READABLE}, so save the map again")
    return data


def regular_size(path: Path, subject: object) -> int:
    """Bytes of a regular file; anything else is refused before it is opened: a pipe would wait for ever.

    Raises:
        MapFileError: a directory, a device or a pipe.
        OSError: whatever the operating system says about the path.
    """
    status = path.stat()
    mode = status.st_mode
    if stat.S_ISDIR(mode):
        raise fault(subject, f"is a directory; expected {READABLE}, so name the file inside it")
    if not stat.S_ISREG(mode):
        raise fault(subject, f"is a device or a pipe; expected {READABLE}, so save it to a file first")
    return status.st_size


def check_size(width: int, height: int, subject: object) -> None:
    """Refuse dimensions beyond the bound before memory is taken.

    Raises:
        MapFileError: no cells, or more than `MAX_CELLS`.
    """
    if width < 1 or height < 1:
        raise fault(subject, f"has {width} x {height} cells; expected at least 1 x 1, so save the map again")
    if width * height > MAX_CELLS:
        raise fault(
            subject,
            f"announces {width} x {height} cells; at most {MAX_CELLS // 1_000_000} million are read, "
            "so crop it or save it with larger cells",
        )

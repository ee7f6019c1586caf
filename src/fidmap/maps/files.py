"""Files from outside: bounded reading, and faults told in one sentence.

A subject is how a sentence about a file starts: the path as the user named it, or `m.yaml: its image m.pgm`.
"""

from __future__ import annotations

import itertools
import stat
from pathlib import Path

from fidmap.model import MapFileError

IMAGE = "a PGM, PNG, BMP, JPEG or TIFF image"
READABLE = (
    "a map_server YAML, an image (PGM, PNG, BMP, JPEG, TIFF), a bag or MCAP file, a 3D map (PLY, PCD, LAS, LAZ, "
    "OctoMap), a drawing (SVG, DXF, GeoJSON) or an RTAB-Map database"
)
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


def read_bytes(path: Path, subject: object, limit: int, kind: str = "", expected: str = READABLE) -> bytes:
    """Read a regular file of at most `limit` bytes; without a `kind` only its beginning is read.

    Args:
        path: the file.
        subject: how sentences about it start.
        limit: largest size in bytes.
        kind: what a larger file is not.
        expected: what else it may be.

    Raises:
        MapFileError: missing, not a regular file, unreadable, empty, or too large; nothing was read then.
    """
    try:
        size = regular_size(path, subject, expected)
        if kind and size > limit:
            raise fault(subject, f"is not {kind} of at most {limit:,} bytes; expected {expected}")
        with path.open("rb") as file:
            # Asking for `limit` bytes would take that much memory for the smallest file.
            data = file.read(min(size, limit))
    except PermissionError:
        raise fault(subject, "cannot be read: permission denied; make it readable (chmod +r)") from None
    except (FileNotFoundError, NotADirectoryError):
        if path.is_symlink():
            raise fault(subject, "is a link to a file that does not exist; put that back or name the file") from None
        raise fault(subject, f"does not exist; expected {expected}, so check the path") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise fault(subject, f"cannot be read ({reason}); check the path") from None
    if not data:
        raise fault(subject, f"is empty (0 bytes); expected {expected}, so save the map again")
    return data


def regular_size(path: Path, subject: object, expected: str = READABLE) -> int:
    """Bytes of a regular file; anything else is refused before it is opened: a pipe would wait for ever.

    Raises:
        MapFileError: a directory, a device or a pipe.
        OSError: whatever the operating system says about the path.
    """
    status = path.stat()
    mode = status.st_mode
    if stat.S_ISDIR(mode):
        raise fault(subject, f"is a directory; expected {expected}, so name {_inside(path)}")
    if not stat.S_ISREG(mode):
        raise fault(subject, f"is a device or a pipe; expected {expected}, so save it to a file first")
    return status.st_size


def _inside(folder: Path) -> str:
    """What to name instead of a folder: a YAML in it, where there is one."""
    try:
        yamls = sorted(path.name for path in itertools.islice(folder.iterdir(), 1000) if path.suffix == ".yaml")
    except OSError:
        yamls = []
    return f"a file inside it, such as {printable(yamls[0], 60)}" if yamls else "the file inside it"


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

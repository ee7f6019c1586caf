"""Text files that people wrote: taken in whole within a bound, their faults told together in one sentence."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike, fspath

from fidmap.model import FidmapError

FAULTS_SHOWN = 20
BYTES_MAX = 4 << 20

FilePath = str | PathLike[str]


def read_bounded(path: FilePath, what: str, error: type[FidmapError]) -> bytes:
    """The bytes of a file of at most `BYTES_MAX`.

    Args:
        path: the file.
        what: what it should be, for the error text ('an arena file').
        error: raised for every fault.
    """
    try:
        with open(path, "rb") as file:  # noqa: PTH123 - Path(path) would hide the name as the user gave it
            data = file.read(BYTES_MAX + 1)
    except IsADirectoryError:
        raise error(one_sentence(path, [f"is a directory, expected {what}, so name the file inside it"])) from None
    except FileNotFoundError:
        raise error(one_sentence(path, [f"no such file, expected {what}, so check the path"])) from None
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or str(fault)
        raise error(one_sentence(path, [f"cannot be read ({reason}), expected {what}"])) from None
    if len(data) > BYTES_MAX:
        raise error(one_sentence(path, [f"is larger than {BYTES_MAX >> 20} MiB, too large for {what}"]))
    return data


def read_text(path: FilePath, what: str, error: type[FidmapError]) -> tuple[str, bytes]:
    """The text (UTF-8, a byte order mark is dropped) and the bytes of a file; `error` for every fault."""
    data = read_bounded(path, what, error)
    try:
        return data.decode("utf-8-sig"), data
    except UnicodeDecodeError as fault:
        line = data.count(b"\n", 0, fault.start) + 1
        raise error(one_sentence(path, [f"line {line}: not UTF-8 text, expected {what}"])) from None


def one_sentence(path: FilePath, faults: Sequence[str]) -> str:
    """'FILE: fault; fault; and 12 more', on one line whatever the faults quote."""
    shown = list(faults[:FAULTS_SHOWN])
    if len(faults) > FAULTS_SHOWN:
        shown.append(f"and {len(faults) - FAULTS_SHOWN} more")
    text = f"{fspath(path)}: {'; '.join(shown)}"
    return "".join(char if char.isprintable() else " " for char in text)


def quoted(value: object, length: int = 40) -> str:
    """A value as an error text shows it: quoted when it is text, cut when it is long."""
    if value is None:
        return "nothing"
    if isinstance(value, dict | list):
        return "a mapping" if isinstance(value, dict) else "a list"
    if isinstance(value, bool):
        return str(value).lower()
    text = str(getattr(value, "written", value))
    text = text if len(text) <= length else text[: length - 3] + "..."
    return f"'{text}'" if isinstance(value, str) else text

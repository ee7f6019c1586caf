"""Reports on disk, the only place of this room that writes: whole files or none, and nothing lost."""

from __future__ import annotations

import errno
import json
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from fidmap.model import Finding, OutputError
from fidmap.report.json_line import Document

REPORT, PAGE, DRAWING, PICTURE, POINTS = (
    "report.json",
    "report.html",
    "overlay.svg",
    "overlay.png",
    "points.csv",
)
INDEX = "index.html"


@dataclass(frozen=True)
class WrittenReport:
    """Where a report went, and what the user should know about it."""

    folder: Path
    notes: tuple[Finding, ...] = ()


@dataclass(frozen=True)
class ReportContent:
    """What one report's folder holds; `points` is the text of points.csv."""

    document: Document
    page: str
    drawing: str
    picture: bytes
    points: str

    def files(self) -> dict[str, bytes]:
        """File names and their bytes; the document comes last, since it says that the others are there."""
        text = json.dumps(self.document, indent=2, allow_nan=False) + "\n"
        return {
            PAGE: self.page.encode(),
            DRAWING: self.drawing.encode(),
            PICTURE: self.picture,
            POINTS: self.points.encode(),
            REPORT: text.encode(),
        }


def write_report(directory: Path, name: str, content: ReportContent, input_points: Path | None = None) -> WrittenReport:
    """Write one report to `directory/name`, replacing an earlier one of the same map.

    A report of another map (by hash) is kept, as is anything that is not a report; the new one then goes to
    `<name>-<first 8 of its hash>`. Everything is written beside its place and moved when it is complete. A
    points.csv that differs from the new one may hold somebody's corrections and is kept as points.csv.bak.

    Args:
        directory: the folder of all reports, made where it is missing.
        name: from `report_names`.
        content: what to write.
        input_points: the points file that the scores came from; it is never overwritten.

    Raises:
        OutputError: the place cannot be written.
    """
    with _output_errors(directory):
        directory.mkdir(parents=True, exist_ok=True)
        folder, notes = _choose_folder(directory, name, str(content.document["provenance"]["map_sha256"]))
        files = _without_input(content.files(), folder, input_points)
        if POINTS in files and _keep_points(folder / POINTS, files[POINTS]):
            text = f"{folder / POINTS} was not what is written there now; it is kept as {POINTS}.bak."
            notes += (Finding("note", "points-kept", text),)
        _move_in(folder, files)
        return WrittenReport(folder, notes)


def check_output(directory: Path) -> None:
    """See before the work whether reports can be written, without writing anything.

    Raises:
        OutputError: the place, or the nearest folder above that exists, cannot be written.
    """
    with _output_errors(directory):
        place = Path(os.path.abspath(directory))  # noqa: PTH100 resolve() would follow links
        while not place.exists():
            place = place.parent
        if not place.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, "Not a directory", str(place))
        if not os.access(place, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, "Permission denied", str(place))


def write_files(directory: Path, name: str, files: Mapping[str, bytes]) -> Path:
    """Write files to `directory/name`, each whole or not at all; other files there stay.

    Raises:
        OutputError: nothing can be written there.
    """
    with _output_errors(directory):
        directory.mkdir(parents=True, exist_ok=True)
        _move_in(directory / name, files)
    return directory / name


def write_index(directory: Path, page: str) -> Path:
    """Write the page that ranks several maps.

    Raises:
        OutputError: the place cannot be written.
    """
    with _output_errors(directory):
        directory.mkdir(parents=True, exist_ok=True)
        stage = directory / f".{INDEX}.{secrets.token_hex(6)}"
        try:
            stage.write_bytes(page.encode())
            stage.replace(directory / INDEX)
        finally:
            stage.unlink(missing_ok=True)
    return directory / INDEX


@contextmanager
def _output_errors(directory: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        why, place = error.strerror or str(error), error.filename
        same = place and os.path.abspath(place) == os.path.abspath(directory)  # noqa: PTH100 as in check_output
        where = f"{place}: " if place and not same else ""
        text = f"{directory}: no report can be written there ({where}{why}); choose another --out."
        raise OutputError(text) from error


def _choose_folder(directory: Path, name: str, sha256: str) -> tuple[Path, tuple[Finding, ...]]:
    """The folder for a report, and a note where it is not the one that its name says."""
    first = directory / name
    if _is_free_for(first, sha256):
        return first, ()
    for digits in (8, 64):
        folder = directory / f"{name}-{sha256[:digits] or 'points'}"
        if _is_free_for(folder, sha256):
            text = f"{first} does not hold a report of this map and is kept; this one is in {folder}."
            return folder, (Finding("note", "report-of-another-map", text),)
    raise OutputError(f"{first}: taken by something else, and so is {folder}; choose another --out.")


def _keep_points(points: Path, new: bytes) -> bool:
    """Put a copy of a differing points file aside; moving it would leave a moment without any."""
    if not points.is_file() or points.read_bytes() == new:
        return False
    stage = points.with_name(f".{points.name}.{secrets.token_hex(6)}")
    shutil.copyfile(points, stage)
    stage.replace(points.with_name(f"{points.name}.bak"))
    return True


def _is_free_for(folder: Path, sha256: str) -> bool:
    """Whether a report of this map may go there: nothing there, or the same map's report."""
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        return False
    if not folder.exists() or not any((folder / name).exists() for name in (REPORT, PAGE, DRAWING, PICTURE)):
        return True
    try:
        document = json.loads((folder / REPORT).read_bytes())
        return bool(document["provenance"]["map_sha256"] == sha256)
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return False


def _without_input(files: Mapping[str, bytes], folder: Path, input_points: Path | None) -> dict[str, bytes]:
    """Leave points.csv as it is where it is the very file that was scored."""
    target = folder / POINTS
    is_input = input_points is not None and target.exists() and target.samefile(input_points)
    return {name: data for name, data in files.items() if not (is_input and name == POINTS)}


def _move_in(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write to a hidden folder beside the target, then move: the folder where it is new, else each file."""
    stage = folder.with_name(f".{folder.name}.{secrets.token_hex(6)}")
    stage.mkdir()
    try:
        for name, data in files.items():
            (stage / name).write_bytes(data)
        with suppress(OSError):
            if not folder.exists():
                stage.rename(folder)
                return
        for name in files:
            Path(stage / name).replace(folder / name)
    finally:
        shutil.rmtree(stage, ignore_errors=True)

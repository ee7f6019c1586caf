"""Maps at fsspec's URLs (`s3://`, `zip://MEMBER::ARCHIVE`, ...): fetched into a folder of their own, then read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath, PureWindowsPath
from tempfile import TemporaryDirectory
from typing import Any

from fidmap.maps import description
from fidmap.maps.extras import need
from fidmap.maps.files import fault, printable
from fidmap.maps.images import is_image
from fidmap.model import MapFileError

MAX_BYTES = 2_000_000_000
BLOCK_BYTES = 1 << 20
WORLD_FILES = (".tfw", ".tifw")


def is_url(name: str) -> bool:
    """Whether a name is fsspec's to open; nobody's local paths have `://` in them."""
    return "://" in name


@contextmanager
def fetched(name: str) -> Iterator[Path]:
    """The file at a URL, with the image that it names if it is a YAML, in a folder that is gone afterwards.

    Raises:
        MapFileError: it cannot be fetched; and what its reader says, with the URL in place of the folder.
        MissingLibraryError: fsspec is not installed.
    """
    fsspec = need("fsspec", "remote", "a URL")
    with TemporaryDirectory(prefix="fidmap") as folder:
        try:
            system, path = fsspec.core.url_to_fs(name)
            local = Path(folder) / (PurePosixPath(path).name or "map")
            _copy(system, path, local, name)
            if named := _image_named(local):
                _fetch_image(system, path, named, Path(folder), name)
        except MapFileError:
            raise
        except ImportError as error:
            raise fault(
                name, f"needs a library ({error}); install it, for s3:// with pip install 'fidmap[remote]'"
            ) from None
        # what stands behind a URL raises its own errors, which fsspec does not gather
        except Exception as error:
            raise fault(name, f"cannot be fetched ({str(error)[:200] or type(error).__name__}); check it") from None
        try:
            yield local
        except MapFileError as error:
            told = MapFileError(str(error).replace(str(local), name).replace(f"{folder}/", ""))
            told.findings = error.findings
            raise told from None


def _copy(system: Any, path: str, local: Path, name: str) -> None:
    """Copy block by block up to the bound: what is announced may be less than what comes."""
    if system.isdir(path) and not system.isfile(path):
        raise fault(name, "is a folder; name the map inside")
    done = 0
    with system.open(path, "rb") as source, local.open("wb") as target:
        while block := source.read(BLOCK_BYTES):
            done += len(block)
            if done > MAX_BYTES:
                raise fault(name, f"has more than {MAX_BYTES:,} bytes; fetch it yourself and name the file")
            target.write(block)


def _image_named(local: Path) -> str | None:
    """What the `image:` of a YAML says; None for every other file."""
    with local.open("rb") as file:
        data = file.read(description.MAX_YAML_BYTES + 1)
    if len(data) > description.MAX_YAML_BYTES or is_image(data) or b"image" not in data:
        return None
    try:
        named = description.load(data, local).get("image")
    except MapFileError:
        return None  # its reader will say what is wrong
    return named if isinstance(named, str) else None


def _fetch_image(system: Any, path: str, named: str, folder: Path, name: str) -> None:
    """The image beside a YAML; anywhere else it may not be, neither there nor here."""
    windows = PureWindowsPath(named)
    if windows.is_absolute() or windows.root or windows.drive or ".." in windows.parts:
        raise fault(name, f"names the image {printable(named)}; of a URL only images beside the YAML are fetched")
    target = folder / named
    target.parent.mkdir(parents=True, exist_ok=True)
    _copy(system, str(PurePosixPath(path).parent / named), target, f"{name}: its image {printable(named)}")

"""The ROS map_server format: a YAML file that names an image and says how to read it.

Flavour unless told otherwise: nav2_map_server, `map_io.cpp` (navigation2 main, a3a97043); see docs/formats.md for
every decision.
"""

from __future__ import annotations

import hashlib
from pathlib import Path, PureWindowsPath

from fidmap.maps import images
from fidmap.maps.cells import code_table, to_grid
from fidmap.maps.description import MAX_YAML_BYTES, Description, load, refusal, understood
from fidmap.maps.files import IMAGE, MAX_IMAGE_BYTES, exists, fault, printable, read_bytes
from fidmap.maps.oddities import odd_keys, oddities, yaw_ignored
from fidmap.maps.overrides import Overrides
from fidmap.maps.robocup.read import is_rescue_map
from fidmap.model import Finding, Grid, MapFileError, Source

MAX_YAMLS_ASKED = 1000
MOST_NEIGHBOURS = 64


def read(path: Path, name: str, overrides: Overrides, noticed: tuple[Finding, ...] = ()) -> Grid:
    """Read a YAML file and its image.

    Args:
        path: the YAML file.
        name: what the user named, kept in the grid's source; the image's path when that led here.
        overrides: what the user says over the file.
        noticed: findings made on the way here.

    Raises:
        MapFileError: one sentence with everything that is wrong with the YAML, or with its image.
    """
    data = read_bytes(path, path, MAX_YAML_BYTES, "a map of a known format, nor a YAML")
    description, faults = understood(data, path, overrides)
    try:
        image_path, foreign = _located(description, path, faults)
        subject = f"{printable(path)}: its image {printable(description.image)}"
        image = read_bytes(image_path, subject, MAX_IMAGE_BYTES, "an image", IMAGE)
        picture = images.load(image, subject)
    except MapFileError as error:
        error.findings = (*noticed, *_without_image(description, overrides))
        raise
    altered = pictured(picture)
    raster = images.in_greys(picture, description.meaning.channels)
    del picture  # a colour image takes four bytes a pixel, which the grid needs now
    digest = hashlib.sha256(data)
    digest.update(image)
    del image
    table = code_table(description.meaning, raster.parts)
    findings = (*noticed, *foreign, *oddities(raster, description.meaning, table))
    if overrides.origin is None:
        findings += yaw_ignored(description.meaning.origin)
    findings += (*altered, *shared(image_path, path))
    source = Source(name, digest.hexdigest(), "map_server", findings)
    return to_grid(raster, description.meaning, table, source)


def _located(description: Description, path: Path, faults: list[str]) -> tuple[Path, tuple[Finding, ...]]:
    """The image, where the YAML has no faults; a missing image is told with them.

    Raises:
        MapFileError: faults, or no such image.
    """
    try:
        found = locate_image(description, path)
    except MapFileError:
        if not faults:
            raise
        named = [f"its image {printable(description.image)} does not exist"] if description.image else []
        raise refusal(path, [*faults, *named]) from None
    if faults:
        raise refusal(path, faults)
    return found


def _without_image(description: Description, overrides: Overrides) -> tuple[Finding, ...]:
    """What a YAML shows whose image cannot be read."""
    meaning, foreign = description.meaning, PureWindowsPath(description.image)
    found = list(odd_keys(meaning, code_table(meaning)))
    if foreign.root or foreign.drive:
        text = (
            f"the YAML names the image by a path of the machine that wrote it, {printable(description.image)}; name it "
            f"{printable(foreign.name)} and put it beside the YAML"
        )
        found.append(Finding("warning", "foreign-image-path", text))
    if overrides.origin is None:
        found += yaw_ignored(meaning.origin)
    return tuple(found)


def pictured(picture: images.Picture) -> tuple[Finding, ...]:
    """`lossy-jpeg`, and `rescue-colours` where greys say little about a picture."""
    found = []
    if picture.format == "JPEG":
        text = (
            "the image is a JPEG, which blurs edges and leaves specks around walls: their places shift by parts of a "
            "cell; save the map as PGM or PNG"
        )
        found.append(Finding("warning", "lossy-jpeg", text))
    if is_rescue_map(picture):
        text = (
            "the image is in the colours of rescue maps, of which thresholds on greys make unexplored ground free and "
            "marks occupied; --resolution reads the image alone, by its colours, when the image is given as MAP"
        )
        found.append(Finding("warning", "rescue-colours", text, "--resolution M_PER_CELL"))
    return tuple(found)


def shared(image_path: Path, yaml_path: Path) -> tuple[Finding, ...]:
    """`shared-image` where other YAML files in the folder name the same image; large folders are not searched."""
    try:
        others = [p for p in yaml_path.parent.iterdir() if p.suffix.lower() in {".yaml", ".yml"} and p != yaml_path]
    except OSError:
        return ()
    if len(others) > MOST_NEIGHBOURS:
        return ()
    naming = sorted(printable(other.name) for other in others if _names(other, image_path))
    if not naming:
        return ()
    text = (
        f"its image {printable(image_path.name)} is also named by {', '.join(naming[:5])}: if these are meant to be "
        "different maps, one was overwritten"
    )
    return (Finding("note", "shared-image", text),)


def locate_image(description: Description, yaml_path: Path) -> tuple[Path, tuple[Finding, ...]]:
    """Find the image: relative to the YAML's folder, absolute where it exists, else its base name beside it.

    Raises:
        MapFileError: no such image.
    """
    named = description.image
    path = yaml_path.parent / named
    if exists(path):
        return path, ()
    # PureWindowsPath knows both kinds of separators and drives.
    foreign = PureWindowsPath(named)
    beside = yaml_path.parent / foreign.name
    if (foreign.root or foreign.drive) and foreign.name and exists(beside):
        text = (
            f"the YAML names the image {printable(named)}, which is not on this machine: "
            f"{printable(foreign.name)} beside the YAML was scored in its place; is it the same map?"
        )
        return beside, (Finding("warning", "foreign-image-path", text),)
    raise fault(
        yaml_path,
        f"names the image {printable(named)}, which does not exist; expected it at that path (seen from the "
        "YAML's folder), so put it there or correct `image:`",
    )


def own_yaml(image_path: Path, name: str) -> Path | None:
    """The YAML beside an image that names it: the one with the same stem first, else the only other one.

    Raises:
        MapFileError: several name it, so it is not known which one is meant.
    """
    for suffix in (".yaml", ".yml"):
        twin = image_path.with_suffix(suffix)
        if twin != image_path and _names(twin, image_path):
            return twin
    try:
        others = [p for p in image_path.parent.iterdir() if p.suffix.lower() in {".yaml", ".yml"}]
    except OSError:
        # A folder that may be entered but not listed: nothing beside the image can be found.
        return None
    naming = [other for other in sorted(others)[:MAX_YAMLS_ASKED] if _names(other, image_path)]
    if len(naming) > 1:
        listed = " and ".join(printable(yaml_path.name) for yaml_path in naming[:5])
        raise fault(name, f"is named by {listed}; expected one: give the YAML that is meant, or --resolution")
    return naming[0] if naming else None


def _names(yaml_path: Path, image_path: Path) -> bool:
    """Whether a file is YAML whose `image:` leads to this image; files that cannot be read do not."""
    try:
        if not yaml_path.is_file() or yaml_path.stat().st_size > MAX_YAML_BYTES:
            return False
        data = yaml_path.read_bytes()
        if image_path.name.encode() not in data:
            return False
        named = load(data, yaml_path).get("image")
        return isinstance(named, str) and (yaml_path.parent / named).samefile(image_path)
    except (OSError, ValueError, MapFileError):
        return False

"""An arena file to an `Arena`, or all its faults in one sentence."""

from __future__ import annotations

import math
from os import fspath
from typing import Any

from pydantic import ValidationError

from fidmap.arena.check import cross_faults
from fidmap.arena.schema import ArenaFile, GroupRow, PartRow
from fidmap.file_schema import faults_of
from fidmap.model import Arena, ArenaFileError, FiducialPart, Group
from fidmap.text_file import FilePath, one_sentence
from fidmap.yaml_file import load_yaml


def read_arena(path: FilePath, long_if_walking_pallets_over: float | None = 6.0) -> Arena:
    """Read and check an arena file (YAML or JSON).

    Args:
        path: the file; kept in the arena as given.
        long_if_walking_pallets_over: the profile's limit between short and long (SSRR 2011, III: six),
            against which named classes are checked; None skips that check.

    Returns:
        The arena, angles in radians.

    Raises:
        ArenaFileError: all faults in one sentence, each with its place in the file.
    """
    document, sha256 = load_yaml(path, "an arena file", ArenaFileError)
    faults: list[str] = []
    file: ArenaFile | None = None
    if "fidmap_arena" not in document:
        faults.append("fidmap_arena: is missing, write 'fidmap_arena: 1' on top of an arena file")
    try:
        file = ArenaFile.model_validate(document)
    except ValidationError as problems:
        told = faults_of(problems, document, ArenaFile)
        faults += [fault for fault in told if fault != "fidmap_arena: is missing"]
    faults += cross_faults(document, long_if_walking_pallets_over)
    if file is None or faults:
        raise ArenaFileError(one_sentence(path, faults))
    return Arena(
        name=file.name,
        radius_m=float(file.radius_m),
        parts=tuple(_part(row) for row in file.parts),
        groups=tuple(_group(row) for row in file.groups),
        frame=file.frame,
        pallet_m=_plain(file.pallet_m),
        path=fspath(path),
        sha256=sha256,
    )


def arena_json_schema() -> dict[str, Any]:
    """The JSON Schema of an arena file (what a schema can say; `read_arena` checks more)."""
    return ArenaFile.model_json_schema(by_alias=True)


def _plain(number: float | None) -> float | None:
    return None if number is None else float(number)


def _part(row: PartRow) -> FiducialPart:
    """Degrees to radians; a part with a facing shows half a barrel if nothing else is said, else a whole."""
    facing = None if row.facing_deg is None else math.radians(math.remainder(row.facing_deg, 360))
    opening_deg = row.opening_deg or (360 if facing is None else 180)
    return FiducialPart(
        id=row.id,
        x_m=_plain(row.x_m),
        y_m=_plain(row.y_m),
        facing=facing,
        opening=math.radians(opening_deg),
        sigma_m=_plain(row.sigma_m),
        z_m=_plain(row.z_m),
    )


def _group(row: GroupRow) -> Group:
    return Group(
        id=row.id,
        parts=tuple(row.parts),
        named_class=row.group_class,
        walking_pallets=_plain(row.walking_pallets),
        distance_m=_plain(row.distance_m),
    )

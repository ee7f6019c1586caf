"""The arena file's form as pydantic models: what each value may be, for itself."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from fidmap.file_schema import FileModel, Length, Metres, PositiveLength, Version, Word

PARTS_MAX = 10_000


class PartRow(FileModel):
    """One part as written: metres and degrees."""

    id: Word
    x_m: Metres | None = None
    y_m: Metres | None = None
    z_m: Metres | None = None
    facing_deg: float | None = Field(
        None, description="outward direction of the visible half, counter-clockwise from +x"
    )
    opening_deg: Annotated[float, Field(gt=0, le=360)] | None = Field(
        None, description="physical angle that the part shows; 180 with a facing, else 360"
    )
    sigma_m: Length | None = Field(None, description="standard deviation of the survey per axis")


class GroupRow(FileModel):
    """One group as written."""

    id: Word
    parts: list[Word] = Field(min_length=2)
    group_class: Word | None = Field(None, alias="class")
    walking_pallets: Annotated[float, Field(ge=0, le=1e6)] | None = None
    distance_m: Length | None = Field(None, description="overrides the positions; two parts only")


def _none_left(groups: object) -> object:
    """A bare `groups:`, as it stays when its entries are deleted or commented out."""
    return [] if groups is None else groups


class ArenaFile(FileModel):
    """A whole arena file."""

    fidmap_arena: Version
    name: Word
    radius_m: PositiveLength
    frame: Literal["relative", "map"] = Field("relative", description="map: positions are in the maps' agreed frame")
    pallet_m: PositiveLength | None = None
    parts: list[PartRow] = Field(min_length=1, max_length=PARTS_MAX)
    groups: Annotated[list[GroupRow], BeforeValidator(_none_left)] = Field(default_factory=list)

"""The words of fidmap: frozen values that the rooms hand to each other, and the error tree.

Lengths are metres, angles radians counter-clockwise from +x, scores fractions in [0, 1]. Percent and degrees
exist only in files and on output. Arrays inside these values are read-only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
Level = Literal["note", "warning", "error"]
Rounding = Literal["none", "nearest", "down", "up"]

SHORT, LONG = "short", "long"


class FidmapError(Exception):
    """A fault that the user can mend; its text is one sentence naming file, fault and remedy.

    FidmapError
     ├── MapFileError       a map that cannot be read
     ├── ArenaFileError     an arena file with faults (all of them in one text)
     ├── SettingsError      a profile file or setting with faults
     ├── PointsFileError    a points file with faults
     ├── HumanFileError     a human ranking with faults
     ├── ReportFileError    a report that cannot be read back
     └── OutputError        a place that cannot be written
    """

    code = "error"


class MapFileError(FidmapError):
    """A map file that cannot be read; `findings`: what can be said about the map all the same."""

    code = "map-file"
    findings: tuple[Finding, ...] = ()


class ArenaFileError(FidmapError):
    """An arena file with faults, or one that lacks what the scoring needs."""

    code = "arena-file"


class SettingsError(FidmapError):
    """A profile file or setting with faults."""

    code = "settings"


class PointsFileError(FidmapError):
    """A points file with faults."""

    code = "points-file"


class HumanFileError(FidmapError):
    """A human ranking with faults."""

    code = "human-file"


class ReportFileError(FidmapError):
    """A report that cannot be read back."""

    code = "report-file"


class OutputError(FidmapError):
    """A place that cannot be written."""

    code = "output"


class Label(np.uint8, Enum):
    """The three labels of a trinarized cell (SSRR 2011, II-A-2), as stored in `TrinaryGrid.labels`.

    Of the labels' own type: numpy turns a map into wide integers, at ten times the time, to compare it with an IntEnum.
    """

    FREE = 0
    UNKNOWN = 1
    OCCUPIED = 2


@dataclass(frozen=True)
class Finding:
    """Something odd about a map or a score, with what it does and the option that mends it."""

    level: Level
    code: str
    text: str
    option: str | None = None


@dataclass(frozen=True)
class Pose2:
    """A pose in the plane: metres and radians."""

    x_m: float = 0.0
    y_m: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True)
class Source:
    """Where a grid came from: the path as the user named it, the hash of its content, what its reader noticed."""

    name: str = "<memory>"
    sha256: str = ""
    format: str = "memory"
    findings: tuple[Finding, ...] = ()


def _read_only(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return a view that cannot be written through; the caller's own array stays as it is."""
    view = array.view()
    view.setflags(write=False)
    return view


@dataclass(frozen=True, eq=False)
class Grid:
    """An occupancy grid as its file gives it.

    occupancy: (H, W) float32, p in [0, 1], NaN where unknown. Row 0 is the lowest row (y up), as in a
        nav_msgs/OccupancyGrid, not the top row of an image.
    resolution_m: side of a cell.
    origin: world pose of the lower-left corner of cell (0, 0); yaw turns about that corner.
    free_thresh, occupied_thresh: p <= free is free (free wins), p >= occupied is occupied, else unknown.
    labels: (H, W) uint8 of `Label` where the format itself knows the three values; None elsewhere.
    """

    occupancy: npt.NDArray[np.float32]
    resolution_m: float
    origin: Pose2 = Pose2()
    free_thresh: float = 0.196
    occupied_thresh: float = 0.65
    labels: npt.NDArray[np.uint8] | None = None
    source: Source = Source()

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "occupancy", _read_only(self.occupancy))
        if self.labels is not None:
            object.__setattr__(self, "labels", _read_only(self.labels))


@dataclass(frozen=True, eq=False)
class TrinaryGrid:
    """A grid of free / unknown / occupied; only `fidmap.grid.trinarize` makes one (SSRR 2011, II-A-2).

    labels: (H, W) uint8 of `Label`, row 0 lowest.
    occupancy: the grid's p, riding along to refine centres; existence and labels never come from it. None
        where the file held nothing but the three values.
    """

    labels: npt.NDArray[np.uint8]
    resolution_m: float
    origin: Pose2 = Pose2()
    occupancy: npt.NDArray[np.float32] | None = None
    source: Source = Source()

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "labels", _read_only(self.labels))
        if self.occupancy is not None:
            object.__setattr__(self, "occupancy", _read_only(self.occupancy))


@dataclass(frozen=True)
class BarrelPart:
    """A detected arc of the known radius, in the map's frame (SSRR 2011, II-A-3).

    n: its number in picture, page, points file and JSON. facing: outward direction of the drawn arc's
    middle, None for an arc of 300 degrees and more. drawn: visible angle. sigma_m: standard deviation per axis.
    spread_m: robust radial spread of its cells beyond what the raster causes; None where no map was looked at.
    fixed_id: what a human said: a part id, "-" for no part, None to let the program find it.
    """

    n: int
    x_m: float
    y_m: float
    facing: float | None = None
    drawn: float = 2 * math.pi
    sigma_m: float | None = None
    confidence: float = 1.0
    spread_m: float | None = None
    fixed_id: str | None = None


@dataclass(frozen=True)
class FiducialPart:
    """One surveyed part of a fiducial, in the arena's frame; x_m and y_m are None where nobody measured them."""

    id: str
    x_m: float | None = None
    y_m: float | None = None
    facing: float | None = None
    opening: float = 2 * math.pi
    sigma_m: float | None = None
    z_m: float | None = None


@dataclass(frozen=True)
class Group:
    """Fiducial parts whose mutual distances are compared; `distance_m` overrides the positions (two parts)."""

    id: str
    parts: tuple[str, ...]
    named_class: str | None = None
    walking_pallets: float | None = None
    distance_m: float | None = None

    def resolved_class(self, limit: float) -> str:
        """The class as named, else by the way a robot must go: over `limit` pallets is long (SSRR 2011, III).

        Raises:
            ArenaFileError: the group has neither a class nor a walking distance.
        """
        if self.named_class is not None:
            return self.named_class
        if self.walking_pallets is None:
            raise ArenaFileError(f"group '{self.id}' has neither a class nor walking_pallets; give one of them")
        return LONG if self.walking_pallets > limit else SHORT


@dataclass(frozen=True)
class Arena:
    """The ground truth: fiducial parts, their groups, the radius, and whether a frame was agreed."""

    name: str
    radius_m: float
    parts: tuple[FiducialPart, ...]
    groups: tuple[Group, ...] = ()
    frame: Literal["relative", "map"] = "relative"
    pallet_m: float | None = None
    path: str = "<memory>"
    sha256: str = ""

    @property
    def has_positions(self) -> bool:
        """Whether every part has a surveyed position."""
        return all(part.x_m is not None for part in self.parts)


DISTANCE_ATTRIBUTES = ("global_accuracy", "relative_accuracy", "consistency")
ATTRIBUTES = ("coverage", "relative_accuracy", "consistency", "global_accuracy", "resolution_quality")


def _four_radii() -> dict[str, float]:
    return dict.fromkeys(DISTANCE_ATTRIBUTES, 4.0)


@dataclass(frozen=True)
class Settings:
    """Every setting of one evaluation (the profile file's words); angles in radians.

    d_max_radii, d_max_m: per distance attribute, the error at which it reaches 0; metres win over radii.
    min_opening: least drawn share of a part's opening. weights: of the attributes and of any group class.
    """

    profile: str = "continuous"
    d_max_radii: dict[str, float] = field(default_factory=_four_radii)
    d_max_m: dict[str, float] = field(default_factory=dict)
    rounding: Rounding = "none"
    min_opening: float = 2 / 3
    min_confidence: float = 0.5
    long_if_walking_pallets_over: float = 6.0
    transform: Literal["rigid", "similarity"] = "rigid"
    scale_range: tuple[float, float] = (0.9, 1.1)
    mirror: bool = False
    facing_tolerance: float = math.pi / 3
    survey_sigma_m: float = 0.02
    weights: dict[str, float] = field(
        default_factory=lambda: dict(zip(ATTRIBUTES, (1.0, 1.0, 1.0, 0.0, 0.0), strict=True))
    )

    def d_max(self, attribute: str, radius_m: float) -> float:
        """D of an attribute, in metres (SSRR 2011, III: four radii)."""
        return self.d_max_m.get(attribute, self.d_max_radii.get(attribute, 4.0) * radius_m)


CONTINUOUS = Settings()
SSRR2011 = replace(CONTINUOUS, profile="ssrr2011", rounding="nearest")


@dataclass(frozen=True)
class StartPose:
    """Where the map frame's origin stands in the arena, with its uncertainty; limits the search to 3 sigma."""

    pose: Pose2
    sigma_m: float = 0.5
    sigma_yaw: float = math.radians(10)


@dataclass(frozen=True)
class Transform:
    """T_truth_map: p_truth = scale * R(rotation) * diag(1, -1 if mirrored else 1) * p_map + (tx_m, ty_m)."""

    rotation: float = 0.0
    tx_m: float = 0.0
    ty_m: float = 0.0
    scale: float = 1.0
    mirrored: bool = False


@dataclass(frozen=True)
class RunnerUp:
    """The greatest value found of another registration than the best one, and an upper bound of all of them."""

    value: float
    upper_bound: float


@dataclass(frozen=True)
class Displaced:
    """A piece of a broken map: unassigned barrel parts that fit unassigned fiducial parts under a second rigid move.

    parts: ids of the fiducial parts; barrels: indices of their barrel parts, in the same order. home: the second
    move, in the arena's frame, from where T_truth_map puts the barrel parts to where they belong.
    """

    parts: tuple[str, ...]
    barrels: tuple[int, ...]
    home: Transform


@dataclass(frozen=True)
class Assignment:
    """Which barrel part is which fiducial part; only `fidmap.register.register` makes one (SSRR 2011, II-A-4).

    barrel_of: per fiducial part (in the arena's order) the index of its barrel part, or None.
    fixed: per fiducial part whether a human said so. transform: T_truth_map of the maximum, None where the
    arena has no positions or nothing was assigned. value: the maximised sum of 1 - min(q(d), D)/D. upper_bound: no
    placement within the settings has a greater one, None where none was proven. runner_up: the best of the other
    placements, None where it was not searched. displaced: pieces of a broken map, not searched by the quick search.
    """

    barrel_of: tuple[int | None, ...]
    fixed: tuple[bool, ...]
    transform: Transform | None
    value: float
    upper_bound: float | None = None
    runner_up: RunnerUp | None = None
    findings: tuple[Finding, ...] = ()
    displaced: tuple[Displaced, ...] = ()


@dataclass(frozen=True)
class Span:
    """Bounds of a 95 % interval of a score, both in [0, 1], or both None with the reason."""

    low: float | None = None
    high: float | None = None
    reason: str | None = None


@dataclass(frozen=True)
class Interval:
    """How sure a score is: about this map in this arena, and about this mapper in arenas of this kind."""

    measurement: Span
    population: Span


@dataclass(frozen=True)
class Value:
    """A score in [0, 1], or None with the reason why it cannot be computed: never 0, never NaN."""

    value: float | None
    reason: str | None = None
    interval: Interval | None = None


@dataclass(frozen=True)
class PartResult:
    """What became of one fiducial part; positions in the map's frame, errors in metres."""

    id: str
    barrel: BarrelPart | None
    relative_error_m: float | None
    global_error_m: float | None
    expected_x_m: float | None
    expected_y_m: float | None


@dataclass(frozen=True)
class PairResult:
    """One compared distance of a group; loss in [0, 1], None where both parts are missing."""

    parts: tuple[str, str]
    distance_m: float | None
    expected_m: float
    error_m: float | None
    loss: float | None


@dataclass(frozen=True)
class GroupResult:
    """One group, its class after the profile's limit, and its pairs; loss is None where no part was assigned."""

    id: str
    group_class: str
    pairs: tuple[PairResult, ...]
    loss: float | None


@dataclass(frozen=True)
class Attributes:
    """The attributes of one map (SSRR 2011, II-B), the parts and groups they came from, and the weighted mean."""

    by_name: dict[str, Value]
    classes: dict[str, Value]
    overall: Value
    missing: tuple[str, ...]
    parts: tuple[PartResult, ...]
    groups: tuple[GroupResult, ...]


@dataclass(frozen=True, eq=False)
class Report:
    """Everything one evaluation found, with what is needed to make it again."""

    map: Source
    arena: Arena
    settings: Settings
    detections: tuple[BarrelPart, ...]
    assignment: Assignment
    attributes: Attributes
    findings: tuple[Finding, ...]
    version: str
    start_pose: StartPose | None = None

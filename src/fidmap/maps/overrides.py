"""What the user says about a map, over what its file says."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from fidmap.maps.cells import FLAVOURS, Flavour
from fidmap.maps.files import fault
from fidmap.model import Pose2

MAX_RESOLUTION_M = 1000.0
MIN_RESOLUTION_M = 1e-5
MAX_TIME_S = 1e9
OriginAt = Literal["corner", "centre"]
ORIGINS: tuple[OriginAt, ...] = get_args(OriginAt)
MAX_HEIGHT_M = 1e4
AXES = {"x": (1, 0, 0), "-x": (-1, 0, 0), "y": (0, 1, 0), "-y": (0, -1, 0), "z": (0, 0, 1), "-z": (0, 0, -1)}


@dataclass(frozen=True)
class Overrides:
    """The options --resolution, --origin and so on; None: as the file says, and nav2's way where it says nothing.

    topic, time_s: which map of a bag; seconds after the recording began, None for the last map.
    flavour: whose map_server's rules. origin_at: what of the lower-left cell the origin is.
    slab_m: what of a 3D map is looked at, lowest and highest height above the floor. up: the axis that is up.
    layers: what of a drawing is painted: layers, groups or colours. unit_m: metres per unit of a drawing.
    """

    resolution_m: float | None = None
    origin: Pose2 | None = None
    free_thresh: float | None = None
    occupied_thresh: float | None = None
    topic: str | None = None
    time_s: float | None = None
    flavour: Flavour | None = None
    origin_at: OriginAt | None = None
    slab_m: tuple[float, float] | None = None
    up: str | None = None
    layers: tuple[str, ...] | None = None
    unit_m: float | None = None

    def corner(self, origin: Pose2, resolution_m: float) -> Pose2:
        """The pose of the lower-left cell's corner, from an origin that is meant as `origin_at` says."""
        if self.origin_at != "centre":
            return origin
        half, c, s = resolution_m / 2, math.cos(origin.yaw), math.sin(origin.yaw)
        return Pose2(origin.x_m - c * half + s * half, origin.y_m - s * half - c * half, origin.yaw)

    def check(self, subject: object) -> None:
        """Refuse values no map can have; the subject is the map they were given for.

        Raises:
            MapFileError: naming the option.
        """
        if self.resolution_m is not None and not is_resolution(self.resolution_m):
            raise fault(
                subject,
                f"cannot be read with --resolution {self.resolution_m:g}; expected the side of a cell in "
                f"metres, {MIN_RESOLUTION_M:g} to {MAX_RESOLUTION_M:g}, such as --resolution 0.05",
            )
        origin = self.origin or Pose2()
        if not all(map(math.isfinite, (origin.x_m, origin.y_m, origin.yaw))):
            raise fault(subject, "cannot be read with an --origin that is not finite; give --origin X_M,Y_M,YAW_DEG")
        for option, value in (("free", self.free_thresh), ("occupied", self.occupied_thresh)):
            if value is not None and not math.isfinite(value):
                raise fault(subject, f"cannot be read with --{option}-thresh {value:g}; expected a number from 0 to 1")
        self._check_contents(subject)

    def _check_contents(self, subject: object) -> None:
        """What chooses among the contents of a file."""
        if self.time_s is not None and not 0 <= self.time_s <= MAX_TIME_S:
            raise fault(subject, f"cannot be read with --time {self.time_s:g}; expected seconds after its beginning")
        for option, word, known in (("flavour", self.flavour, FLAVOURS), ("origin-at", self.origin_at, ORIGINS)):
            if word is not None and word not in known:
                raise fault(subject, f"cannot be read with --{option} {word}; expected {' or '.join(known)}")
        if self.slab_m is not None and not -MAX_HEIGHT_M <= self.slab_m[0] < self.slab_m[1] <= MAX_HEIGHT_M:
            low, high = self.slab_m
            raise fault(
                subject,
                f"cannot be read with --slab {low:g},{high:g}; expected the lowest and the highest height above the "
                "floor in metres, such as --slab 0.2,0.9",
            )
        if self.unit_m is not None and not 1e-9 <= self.unit_m <= 1e6:
            raise fault(subject, f"cannot be read with --unit {self.unit_m:g}; expected metres, 0.001 for millimetres")
        if self.up is not None and self.up not in AXES:
            raise fault(subject, f"cannot be read with --up {self.up}; expected one of {', '.join(AXES)}")


def is_resolution(value: float) -> bool:
    """Whether a number can be the side of a cell in metres; NaN and infinity cannot."""
    return MIN_RESOLUTION_M <= value <= MAX_RESOLUTION_M

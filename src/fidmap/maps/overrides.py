"""What the user says about a map, over what its file says."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fidmap.maps.files import fault
from fidmap.model import Pose2

MAX_RESOLUTION_M = 1000.0
MIN_RESOLUTION_M = 1e-5
MAX_TIME_S = 1e9


@dataclass(frozen=True)
class Overrides:
    """The options --resolution, --origin, --free-thresh and --occupied-thresh; None: as the file says.

    topic, time_s: which map of a bag; seconds after the recording began, None for the last map.
    """

    resolution_m: float | None = None
    origin: Pose2 | None = None
    free_thresh: float | None = None
    occupied_thresh: float | None = None
    topic: str | None = None
    time_s: float | None = None

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
        if self.time_s is not None and not 0 <= self.time_s <= MAX_TIME_S:
            raise fault(subject, f"cannot be read with --time {self.time_s:g}; expected seconds after its beginning")


def is_resolution(value: float) -> bool:
    """Whether a number can be the side of a cell in metres; NaN and infinity cannot."""
    return MIN_RESOLUTION_M <= value <= MAX_RESOLUTION_M

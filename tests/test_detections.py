"""The table of `fidmap detect`."""

from __future__ import annotations

import io
import math

from rich.console import Console

from fidmap.model import BarrelPart
from fidmap.report.detections import print_detections


def test_angles_are_shown_in_degrees():
    """Once the radians of a detection were printed with a degree sign."""
    console = Console(file=io.StringIO(), width=100)
    part = BarrelPart(1, 1.0, 2.0, -math.pi / 2, math.radians(170), 0.01, 0.9)
    print_detections(console, "m.yaml", [part, BarrelPart(2, 0.0, 0.0, None, 2 * math.pi)])

    shown = console.file.getvalue()

    assert all(word in shown for word in ("-90.0°", "170.0°", "whole", "360.0°", "0.90"))

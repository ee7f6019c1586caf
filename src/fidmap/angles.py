"""Degrees in files, radians inside, without losing a bit on the way.

Settings come from short numbers of degrees (`math.radians`) and shall be shown as the numbers they came from:
`degrees_of`. Facings of barrel parts are computed, and `math.radians` misses about one
double in ten, so that a facing written in degrees and read back could differ in its last bit, and with it a
report. `degrees_text` and `radians_of_text` go through decimals: the radians are the double nearest to the
written angle, and the written angle is the shortest that gives the same double back.
"""

from __future__ import annotations

import math
from decimal import Context, Decimal

_CONTEXT = Context(prec=40)
_RADIANS_PER_DEGREE = Decimal("0.01745329251994329576923690768488612713442871888541725456")


def degrees_of(radians: float) -> float:
    """The shortest number of degrees that `math.radians` turns into these radians, else the nearest."""
    degrees = math.degrees(radians)
    shorter = (float(f"{degrees:.{digits}g}") for digits in range(1, 18))
    return next((short for short in shorter if math.radians(short) == radians), degrees)


def radians_of_text(degrees: str) -> float:
    """The double nearest to an angle written in degrees."""
    return float(_CONTEXT.multiply(Decimal(degrees), _RADIANS_PER_DEGREE))


def degrees_text(radians: float) -> str:
    """The shortest text of an angle in degrees that `radians_of_text` turns back into the same double."""
    exact = _CONTEXT.divide(Decimal(radians), _RADIANS_PER_DEGREE)
    for digits in range(1, 25):
        text = f"{Context(prec=digits).plus(exact):f}"
        if radians_of_text(text) == radians:
            break
    return text

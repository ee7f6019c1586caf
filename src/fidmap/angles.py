"""Degrees in files, radians inside, without losing a bit on the way.

Degrees become radians by `math.radians` everywhere, and are shown as the shortest number that gives the same
radians back. But `math.radians` misses about one double in ten, and facings of barrel parts are computed: one
that it misses is written with more digits than a double holds, and such texts are multiplied out as decimals.
So a facing that is written and read back is the same to the last bit, and with it the report.
"""

from __future__ import annotations

import math
from decimal import Context, Decimal

_DOUBLE_DIGITS = 17
_CONTEXT = Context(prec=40)
_RADIANS_PER_DEGREE = Decimal("0.01745329251994329576923690768488612713442871888541725456")


def degrees_of(radians: float) -> float:
    """The shortest number of degrees that `math.radians` turns into these radians, else the nearest."""
    degrees = math.degrees(radians)
    shorter = [float(f"{degrees:.{digits}g}") for digits in range(1, 18)]
    beside = [math.nextafter(degrees, way) for way in (-math.inf, math.inf)]  # both ways round on their own
    return next((one for one in (*shorter, *beside) if math.radians(one) == radians), degrees)


def radians_of_text(degrees: str) -> float:
    """An angle written in degrees, in radians; of more than 17 digits all count."""
    written = Decimal(degrees)
    if len(written.as_tuple().digits) <= _DOUBLE_DIGITS:
        return math.radians(float(degrees))
    return float(_CONTEXT.multiply(written, _RADIANS_PER_DEGREE))


def degrees_text(radians: float) -> str:
    """The shortest text of an angle in degrees that `radians_of_text` turns back into the same double."""
    degrees = degrees_of(radians)
    if math.radians(degrees) == radians:
        return repr(degrees).removesuffix(".0")
    exact = _CONTEXT.divide(Decimal(radians), _RADIANS_PER_DEGREE)
    texts = (str(Context(prec=digits).plus(exact)) for digits in range(_DOUBLE_DIGITS + 1, 40))
    return next((text for text in texts if radians_of_text(text) == radians), str(exact))

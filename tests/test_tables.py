"""Look-up tables over whole maps."""

from __future__ import annotations

import numpy as np
import pytest

from fidmap.maps.tables import look_up

TABLES = {
    "float32": np.append(np.random.default_rng(0).random(255), np.nan).astype(np.float32),
    "bytes": np.arange(256, dtype=np.uint8)[::-1].copy(),
    "flags": np.arange(256) % 3 == 0,
    "short": np.array([0, np.nan, 1], np.float32),
    "long": np.arange(1000).astype(np.uint8),
}


@pytest.mark.parametrize("kind", TABLES)
@pytest.mark.parametrize("shape", [(1, 1), (1, 70), (70, 1), (129, 33), (65, 7, 3), (65, 7, 1)])
@pytest.mark.parametrize("width", [np.uint8, np.uint16])
def test_every_code_gets_its_entry(kind: str, shape: tuple[int, ...], width: type[np.unsignedinteger]) -> None:
    """Also upside down, in blocks that are not full, and past the table's end."""
    table = TABLES[kind]
    codes = np.random.default_rng(1).integers(0, 256, shape).astype(width)
    for seen in (codes, codes[::-1]):
        wanted = table[np.minimum(seen.astype(int), len(table) - 1)]
        found = look_up(table, seen)
        assert found.dtype == table.dtype
        np.testing.assert_array_equal(found, wanted)

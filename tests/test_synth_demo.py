from __future__ import annotations

import numpy as np
import pytest
from benchmarks.make_demo import DEMO_DATA, write_demo
from PIL import Image

from fidmap.synth.demo import demo_maps

MAPS = ("good", "noisy", "broken")


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The demo files, made anew."""
    folder = tmp_path_factory.mktemp("demo")
    write_demo(folder)
    return folder


def test_the_demo_has_short_and_long_ways_and_voids():
    """Seven pairs, two of them over a void; both classes of consistency can be shown."""
    arena, maps = demo_maps()
    ways = [group.walking_pallets for group in arena.arena.groups]

    assert [name for name, _ in maps] == list(MAPS)
    assert len(ways) == 7
    assert sum(group.distance_m > 1 for group in arena.arena.groups) == 2
    assert min(ways) <= 6 < max(ways)


def test_the_shipped_texts_are_those_the_program_makes(written):
    """The same bytes; a difference means that `./run bench make_demo` was forgotten."""
    for name in ("arena", *MAPS):
        assert (written / f"{name}.yaml").read_bytes() == (DEMO_DATA / f"{name}.yaml").read_bytes()


@pytest.mark.parametrize("name", MAPS)
def test_the_shipped_maps_are_those_the_program_makes(written, name):
    """The same picture but for one cell in a thousand: other processors may round a beam to the next cell."""
    new, shipped = (np.asarray(Image.open(folder / f"{name}.pgm")) for folder in (written, DEMO_DATA))

    assert new.shape == shipped.shape
    assert (new != shipped).mean() <= 1e-3
    assert set(np.unique(shipped)) == {0, 205, 254}
    assert (DEMO_DATA / f"{name}.pgm").stat().st_size < 100_000

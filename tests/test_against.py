"""Maps beside their arena: wrong resolution, wrong radius, mirrored, another arena; and what mends each."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from command_line import DEMO_DATA, ONE, documents, evening, fidmap
from fidmap.arena import read_arena
from fidmap.arena.write import write_arena
from fidmap.detect import find_barrel_parts
from fidmap.grid import trinarize
from fidmap.inspect.against import arena_findings, radius_findings
from fidmap.inspect.radius import seen_arcs
from fidmap.maps import read_map
from fidmap.model import CONTINUOUS, SSRR2011, Arena, BarrelPart, Finding, Grid, Label, Settings, Transform, TrinaryGrid
from fidmap.register import register
from fidmap.synth.suite import CaseSpec, SynthCase, case_rng, make_case, suite
from fiducials import arc, arena_of, drawn, half, pairs_arena
from real_data import real_data


@pytest.fixture(scope="module")
def case() -> SynthCase:
    """A clean map of a maze with barrels of 0.3 m, six cells."""
    return make_case(case_rng("tune", 5, "clean", 0), CaseSpec(resolution_m=0.05))


def of_map(grid: Grid, arena: Arena) -> tuple[Finding, ...]:
    """The findings as `inspect --arena` makes them."""
    parts = find_barrel_parts(trinarize(grid), arena.radius_m)
    return arena_findings(parts, register(parts, arena, CONTINUOUS, fast=True), arena, CONTINUOUS, grid)


def of_parts(parts: tuple[BarrelPart, ...], arena: Arena, settings: Settings = CONTINUOUS) -> list[str]:
    """The codes for parts located by hand."""
    return [f.code for f in arena_findings(parts, register(parts, arena, settings), arena, settings, None)]


def demo_arena() -> Arena:
    """Fourteen parts in no symmetry."""
    return read_arena(DEMO_DATA / "arena.yaml")


def flipped(grid: Grid) -> Grid:
    """The map with its rows upside down."""
    labels = None if grid.labels is None else grid.labels[::-1]
    return replace(grid, occupancy=grid.occupancy[::-1], labels=labels)


@pytest.mark.parametrize("tier", ["clean", "broken", "office", "field"])
def test_sound_maps_are_silent(tier: str) -> None:
    """Broken ones too: their pieces fit at scale 1."""
    for made in suite("tune", 8, 2, tier):  # type: ignore[arg-type]
        assert of_map(made.grid, made.arena.arena) == (), made.name


@pytest.mark.parametrize("factor", [0.8, 0.9, 0.95, 1.1, 1.25])
def test_wrong_resolution(case: SynthCase, factor: float) -> None:
    """Told alone, with the true one, though the arcs' radius is as wrong; also where few arcs are seen with it."""
    grid = replace(case.grid, resolution_m=case.grid.resolution_m * factor)
    (finding,) = of_map(grid, case.arena.arena)

    assert (finding.code, finding.level) == ("scale-off", "warning")
    assert finding.option is not None
    assert float(finding.option.removeprefix("--resolution ")) == pytest.approx(0.05, rel=5e-3)
    assert f"too {'large' if factor > 1 else 'small'}" in finding.text


@pytest.mark.parametrize("factor", [0.75, 1.3])
def test_wrong_radius(case: SynthCase, factor: float) -> None:
    """Distances fit, so the arena's radius is to be mended, not the resolution; without an arena nobody knows."""
    arena = replace(case.arena.arena, radius_m=0.3 * factor)
    (finding,) = of_map(case.grid, arena)
    (alone,) = radius_findings(case.grid, 0.3 * factor)

    assert (finding.code, finding.level) == ("radius-off", "warning")
    assert finding.option is not None
    assert float(finding.option.split()[1]) == pytest.approx(0.3, rel=0.05)
    assert "distances fit" in finding.text
    assert "either the radius is another one, or the resolution is wrong" in alone.text


@pytest.mark.parametrize(("factor", "levels"), [(1.0, []), (0.88, ["note"]), (1.14, ["note"])])
def test_a_radius_a_tenth_off_is_a_note_where_it_is_asked_for(
    case: SynthCase, factor: float, levels: list[str]
) -> None:
    """Mappers draw arcs nearly as far off by themselves, so no score is doubted for it."""
    found = radius_findings(case.grid, 0.3 * factor)

    assert [f.level for f in found] == levels
    assert all(f.code == "radius-off" for f in found)
    assert of_map(case.grid, replace(case.arena.arena, radius_m=0.3 * factor)) == ()


def test_arenas_without_positions_have_a_radius(case: SynthCase) -> None:
    """Nothing is placed, so nothing says whether the radius or the resolution is wrong."""
    parts = tuple(replace(p, x_m=None, y_m=None) for p in case.arena.arena.parts)
    arena = replace(case.arena.arena, parts=parts)

    assert of_map(case.grid, arena) == ()
    assert [f.code for f in of_map(case.grid, replace(arena, radius_m=0.22))] == ["radius-off"]


def test_mirrored_and_another_arena(case: SynthCase) -> None:
    """Rows upside down; and both faults at once, which is another arena sooner than two mistakes."""
    arena = case.arena.arena
    both = replace(flipped(case.grid), resolution_m=0.055)

    assert [(f.code, f.option) for f in of_map(flipped(case.grid), arena)] == [("mirrored", "--mirror")]
    assert [f.code for f in of_map(both, arena)] == ["another-arena"]


def test_parts_that_fit_nothing() -> None:
    """Arcs anywhere beside the demo's arena; five of them are too few to be known."""
    arena = demo_arena()
    random = np.random.default_rng(3)
    strange = tuple(
        replace(part, x_m=float(random.uniform(0, 9)), y_m=float(random.uniform(0, 9)), facing=random.uniform(-3, 3))
        for part in drawn(arena)
    )

    assert of_parts(strange, arena) == ["another-arena"]
    assert of_parts(strange[:5], arena) == []


@pytest.mark.parametrize("settings", [CONTINUOUS, SSRR2011])
def test_what_is_allowed_is_no_finding(settings: Settings) -> None:
    """A profile that frees the scale or the sides has said so; steps in the score change nothing."""
    arena = demo_arena()
    scaled, mirrored = drawn(arena, Transform(0.4, 1, 2, scale=1.08)), drawn(arena, Transform(0.4, 1, 2, mirrored=True))

    assert of_parts(drawn(arena, noise_m=0.05), arena, settings) == []
    assert of_parts(scaled, arena, settings) == ["scale-off"]
    assert of_parts(mirrored, arena, settings) == ["mirrored"]
    assert of_parts(scaled, arena, replace(settings, transform="similarity")) == []
    assert of_parts(mirrored, arena, replace(settings, mirror=True)) == []


def test_symmetric_arenas_are_never_mirrored() -> None:
    """A rectangle of pillars fits either way: silent as it is, and only the scale is told where that is wrong."""
    pillars = [half(f"{x}{y}", 1.5 * x, 1.1 * y, None) for x in range(3) for y in range(3)]
    arena = arena_of(*pillars)

    assert of_parts(drawn(arena, Transform(mirrored=True)), arena) == []
    assert of_parts(drawn(arena, Transform(0.3, scale=1.15, mirrored=True)), arena) == ["scale-off"]


def test_few_parts_say_nothing() -> None:
    """Four parts fit too much by chance, whatever their scale."""
    arena = pairs_arena()

    assert of_parts(drawn(arena, Transform(scale=1.1))[:4], arena) == []


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The demo, with its good map once more upside down and once at a resolution 10 % too small."""
    evening(tmp_path, monkeypatch)
    good = (tmp_path / "good.yaml").read_text()
    (tmp_path / "small.yaml").write_text(good.replace("resolution: 0.05", "resolution: 0.045"))
    head, size, depth, pixels = (tmp_path / "good.pgm").read_bytes().split(b"\n", 3)
    width = int(size.split()[0])
    rows = [pixels[k : k + width] for k in range(0, len(pixels), width)]
    (tmp_path / "flipped.pgm").write_bytes(b"\n".join([head, size, depth, b"".join(rows[::-1])]))
    (tmp_path / "flipped.yaml").write_text(good.replace("good.pgm", "flipped.pgm"))
    arena = read_arena("arena.yaml")
    write_arena(tmp_path / "wide.yaml", replace(arena, radius_m=0.375))
    return tmp_path


def overall_and_findings(*words: str) -> tuple[float, dict[str, str]]:
    """The overall score of one map, and its warnings with their option."""
    (document,) = documents(fidmap("score", *words, "--workers", "1", "--json").stdout)
    told = {f["code"]: f.get("option", "") for f in document["findings"] if f["level"] == "warning"}
    return document["attributes"]["overall"]["value"], told


@pytest.mark.usefixtures("folder")
def test_the_option_mends_it() -> None:
    """Each finding names words that, given to `score`, give the score of the sound map without the finding."""
    sound, nothing = overall_and_findings("good.yaml", "--arena", "arena.yaml")
    assert nothing == {}
    for name, code in (("small", "scale-off"), ("flipped", "mirrored")):
        words = (f"{name}.yaml", "--arena", "arena.yaml")
        bad, told = overall_and_findings(*words)
        mended, rest = overall_and_findings(*words, *told[code].split())

        assert bad < sound - 0.05
        assert mended == pytest.approx(sound, abs=0.005)
        assert rest == {}


def test_the_radius_mends_it(folder: Path) -> None:
    """`radius_m: R` in the arena file, as the finding says."""
    bad, told = overall_and_findings("good.yaml", "--arena", "wide.yaml")
    line = told["radius-off"].removesuffix(" in the arena file")
    text = (folder / "wide.yaml").read_text()
    (folder / "right.yaml").write_text(text.replace("radius_m: 0.375", line))
    mended, rest = overall_and_findings("good.yaml", "--arena", "right.yaml")

    assert bad < 0.95 < mended
    assert rest == {}


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(("name", "code"), [("good", None), ("small", "scale-off"), ("flipped", "mirrored")])
def test_inspect_and_score_say_the_same(name: str, code: str | None) -> None:
    """The same findings, word for word."""
    codes = {"scale-off", "mirrored", "radius-off", "another-arena"}
    (scored,) = documents(fidmap("score", f"{name}.yaml", *ONE, "--json").stdout)
    (seen,) = documents(fidmap("inspect", f"{name}.yaml", "--arena", "arena.yaml", "--json").stdout, "inspect")
    told, inspected = ([f for f in d["findings"] if f["code"] in codes] for d in (scored, seen))

    assert told == inspected
    assert [f["code"] for f in told] == ([] if code is None else [code])


def test_the_referee_sees_it(folder: Path) -> None:
    """On the terminal, on the page, and once more when reports are ranked."""
    table = fidmap("score", "good.yaml", "flipped.yaml", *ONE, "--out", "reports").stdout
    page = (folder / "reports/flipped/report.html").read_text(encoding="utf-8")
    ranked = fidmap("rank", "reports").stderr

    assert "Warning, flipped.yaml: 14 parts fit the arena only when the map is mirrored" in table
    assert "(mirrored)" in page
    assert "<code>--mirror</code>" in page
    assert "warning: flipped: 14 parts fit the arena only when the map is mirrored" in ranked
    assert "good:" not in ranked


REAL = {
    "playpen/playpen_map.yaml": "playpen/arena.yaml",
    "tb3_world/1r_ws_turtlebot3_world.yaml": "tb3_world/arena.yaml",
    "tb3_world/2006wu_turtlebot3_world.yaml": "tb3_world/arena.yaml",
    "slam_challenge/maps/m28.yaml": "slam_challenge/A2.arena.yaml",
    "slam_challenge/maps/m55.yaml": "slam_challenge/A2.arena.yaml",
    "slam_challenge/maps/m62.yaml": "slam_challenge/R2.arena.yaml",
    "slam_challenge/maps/m63.yaml": "slam_challenge/R2.arena.yaml",
}


@pytest.mark.parametrize("name", REAL)
def test_real_maps_are_silent(name: str) -> None:
    """Bent, broken, sparse and symmetric ones; the resolution 10 % off is told where five parts are placed."""
    grid, arena = read_map(real_data(name)), read_arena(real_data(REAL[name]))

    assert of_map(grid, arena) == ()
    if name.endswith(("m28.yaml", "m63.yaml", "world.yaml")):
        small = of_map(replace(grid, resolution_m=grid.resolution_m * 1.1), arena)
        assert [f.code for f in small] == ["scale-off"]


@pytest.mark.parametrize(("last_m", "off"), [(0.36, False), (0.435, True)])
def test_few_arcs_tell_a_radius_only_if_they_agree(last_m: float, off: bool) -> None:
    """Two of three rings a fifth too large may be something else; three may not."""
    labels = np.zeros((75, 200), np.uint8)
    y, x = np.mgrid[0:75, 0:200] * 0.02 + 0.01
    centres, radii = [(0.7 + 1.2 * k, 0.75) for k in range(3)], (0.44, 0.445, last_m)
    for (x_m, y_m), radius_m in zip(centres, radii, strict=True):
        labels[np.abs(np.hypot(x - x_m, y - y_m) - radius_m) < 0.015] = Label.OCCUPIED
    parts = [replace(arc(n, *at, None), confidence=1.0) for n, at in enumerate(centres)]

    arcs = seen_arcs(TrinaryGrid(labels, 0.02), 0.36, parts)

    assert arcs.is_off(18.0) is off

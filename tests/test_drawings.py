"""Maps from drawings: DXF by ezdxf, SVG, GeoJSON."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from benchmarks.arena_shapes import arena, strokes
from benchmarks.drawing_files import write_dxf, write_geojson, write_svg

from command_line import fidmap
from fidmap.evaluate import evaluate
from fidmap.grid import metres_to_cells, trinarize
from fidmap.maps import read_map
from fidmap.maps.drawing import flatness
from fidmap.maps.overrides import Overrides
from fidmap.model import Grid, Label
from map_files import sentence

WRITERS: dict[str, Callable[..., Path]] = {"dxf": write_dxf, "svg": write_svg, "geojson": write_geojson}
CIRCLE = [("line", np.array([0.0, 0.0, 9.0, 9.0])), ("arc", np.array([5.0, 4.0, 0.75, 0.3, 2 * math.pi]))]


def label_at(grid: Grid, x: float, y: float) -> Label:
    row, column = metres_to_cells(np.array([[x, y]]), grid.resolution_m, grid.origin)[0].astype(int)
    return Label(trinarize(grid).labels[row, column])


def svg(folder: Path, body: str, head: str = 'width="10m" height="10m" viewBox="0 0 1000 1000"') -> Path:
    path = folder / "plan.svg"
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {head}>{body}</svg>')
    return path


def geojson(folder: Path, *geometries: dict[str, object], **properties: object) -> Path:
    features = [{"type": "Feature", "properties": properties, "geometry": geometry} for geometry in geometries]
    path = folder / "plan.json"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


@pytest.mark.parametrize("kind", WRITERS)
def test_a_drawn_arena_scores_like_its_plan(tmp_path: Path, kind: str) -> None:
    """All parts are found, nothing else is, and they lie where they are; the suffix does not matter."""
    made = arena()
    path = WRITERS[kind](tmp_path / f"plan.{kind}", list(strokes(made))).rename(tmp_path / "plan")
    report = evaluate(read_map(path), made.arena, fast=True)
    values = report.attributes.by_name
    assert values["coverage"].value == 1
    assert values["relative_accuracy"].value > 0.98
    assert len(report.detections) == len(made.arena.parts)
    assert report.map.format == kind


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.parametrize("resolution", [0.02, 0.05])
def test_arcs_lie_where_they_are_drawn(tmp_path: Path, kind: str, resolution: float) -> None:
    """The circle runs within a twentieth of a cell of every cell that is painted, and those it runs through are."""
    grid = read_map(WRITERS[kind](tmp_path / "plan", CIRCLE[1:]), resolution_m=resolution)
    angles = np.linspace(0, 2 * math.pi, 20_000)
    circle = np.stack([5 + 0.75 * np.cos(angles), 4 + 0.75 * np.sin(angles)], axis=1)
    places = metres_to_cells(circle, resolution, grid.origin)
    painted = grid.occupancy == 1
    deep = np.abs(places % 1 - 0.5).max(axis=1) < 0.45
    assert painted[tuple(places[deep].astype(int).T)].all()
    for row, column in np.argwhere(painted):
        beyond = np.maximum(np.abs(places - [row + 0.5, column + 0.5]) - 0.5, 0)
        assert np.hypot(*beyond.T).min() < 1 / 20


def test_curves_are_cut_finely_enough() -> None:
    """The chord of a piece is a fortieth of a cell from the curve at most; ezdxf and SVG are told that length."""
    assert flatness(0.001, Overrides(resolution_m=0.05)) == pytest.approx(1.25)
    assert flatness(1.0, Overrides()) == pytest.approx(0.0005)


CURVES = {
    "cubic": ("M 100 500 C 100 100 900 100 900 500", 0.5, (5.0, 8.0)),
    "quadratic": ("M 100 500 Q 500 -300 900 500", 0.5, (5.0, 9.0)),
    "arc": ("M 100 500 A 400 400 0 0 1 900 500", 0.5, (5.0, 9.0)),
}


@pytest.mark.parametrize("kind", CURVES)
def test_curves_of_svg(tmp_path: Path, kind: str) -> None:
    """The top of each curve is where mathematics has it; y counts upwards from the page's lower edge."""
    path, _, (x, y) = CURVES[kind]
    grid = read_map(svg(tmp_path, f'<path d="{path}" fill="none" stroke="black"/>'))
    assert label_at(grid, x, y - 0.001) == Label.OCCUPIED
    assert label_at(grid, x, y - 0.1) == label_at(grid, x, y + 0.1) == Label.FREE
    assert label_at(grid, 1.001, 5.001) == Label.OCCUPIED


def test_transforms_and_painting_order(tmp_path: Path) -> None:
    """Groups move what is in them, a light area clears a dark one, and strokes need to be dark."""
    body = (
        '<g transform="translate(100 0) scale(2)"><rect x="0" y="0" width="200" height="100"/>'
        '<rect x="50" y="25" width="50" height="50" fill="white"/></g>'
        '<g transform="rotate(90)"><line x1="600" y1="-301" x2="800" y2="-301" stroke="#333"/></g>'
        '<line x1="600" y1="700" x2="900" y2="700" stroke="#eee"/>'
        '<g style="display: none"><circle cx="800" cy="900" r="50"/></g>'
        '<ellipse cx="800" cy="500" rx="80" ry="20" fill="none" stroke="black" transform="skewX(10)"/>'
    )
    grid = read_map(svg(tmp_path, body))
    assert label_at(grid, 1.5, 9) == label_at(grid, 4.9, 8.1) == Label.OCCUPIED
    assert label_at(grid, 2.5, 9) == Label.FREE
    assert label_at(grid, 3.01, 3.5) == Label.OCCUPIED
    assert label_at(grid, 7.5, 3.0) == Label.FREE
    skew = math.tan(math.radians(10)) * 520
    assert label_at(grid, (800 + skew) / 100, 4.8 + 0.001) == Label.OCCUPIED


@pytest.mark.parametrize("kind", WRITERS)
def test_layers_are_chosen_by_name(tmp_path: Path, kind: str) -> None:
    """Only the barrels, or only the walls; an unknown layer lists what there is."""
    path = WRITERS[kind](tmp_path / "plan", CIRCLE)
    barrels = {"dxf": "barrels", "svg": "barrel", "geojson": "barrels"}[kind]
    grid = read_map(path, layers=(barrels,))
    assert label_at(grid, 5.75, 4.0) == Label.OCCUPIED
    assert label_at(grid, 4.8, 4.5) == Label.FREE
    assert grid.occupancy.shape[1] < 2.6 / 0.02
    assert "has no layer or colour stairs; choose with --layer among: " in sentence(path, layers=("stairs",))


def test_layers_are_chosen_by_colour(tmp_path: Path) -> None:
    """DXF colours come from the layer, SVG colours from the stroke."""
    for path, colour in (
        (write_dxf(tmp_path / "plan.dxf", CIRCLE), "#FF0000"),
        (
            svg(tmp_path, '<g fill="none"><path d="M0 0H500" stroke="red"/><path d="M0 9H500" stroke="blue"/></g>'),
            "#F00",
        ),
    ):
        wanted = "#ff0000" if colour == "#F00" else colour
        assert read_map(path, layers=(wanted,)).occupancy.any()


def test_units(tmp_path: Path) -> None:
    """A unit is read from the file or has to be said; what is said wins."""
    metres = write_dxf(tmp_path / "m.dxf", CIRCLE, units=6)
    assert label_at(read_map(metres), 5.75, 4) == Label.OCCUPIED
    none = write_dxf(tmp_path / "none.dxf", CIRCLE, units=0)
    assert sentence(none) == (f"{none} does not say its unit ($INSUNITS); say it with --unit M_PER_UNIT, 0.001 for mm")
    assert label_at(read_map(none, unit_m=2.0), 11.5, 8) == Label.OCCUPIED
    plain = svg(tmp_path, '<path d="M0 49.95H50" stroke="red"/>', 'viewBox="0 0 100 100"')
    assert "say how large one unit is with --unit M_PER_UNIT" in sentence(plain)
    assert label_at(read_map(plain, unit_m=0.1), 4, 5.005) == Label.OCCUPIED
    assert "--unit -1; expected metres" in sentence(plain, unit_m=-1)


def test_degrees(tmp_path: Path) -> None:
    """Within half a degree coordinates are degrees: a thousandth of one to the north is 111.19 m."""
    line = {"type": "LineString", "coordinates": [[8.0, 60.0], [8.0, 60.001]]}
    across = {"type": "LineString", "coordinates": [[8.0, 60.0], [8.001, 60.0]]}
    grid = read_map(geojson(tmp_path, line, across), resolution_m=0.1)
    rows, columns = np.nonzero(grid.occupancy)
    assert np.ptp(rows) * 0.1 == pytest.approx(111.19, abs=0.15)
    assert np.ptp(columns) * 0.1 == pytest.approx(111.19 / 2, abs=0.15)
    assert grid.source.findings[0].code == "unit"


def test_solid_areas(tmp_path: Path) -> None:
    """A polygon is solid, a closed line is not; hatches of DXF are."""
    ring = [[0, 0], [4, 0], [4, 3], [0, 3], [0, 0]]
    solid = read_map(geojson(tmp_path, {"type": "Polygon", "coordinates": [ring]}))
    hollow = read_map(geojson(tmp_path, {"type": "LineString", "coordinates": ring}))
    assert (label_at(solid, 2, 1), label_at(hollow, 2, 1)) == (Label.OCCUPIED, Label.FREE)

    from ezdxf.filemanagement import new

    document = new()
    document.header["$INSUNITS"] = 6
    hatch = document.modelspace().add_hatch()
    hatch.paths.add_polyline_path(ring, is_closed=True)
    block = document.blocks.new("POST")
    block.add_circle((0, 0), 0.5)
    document.modelspace().add_blockref("POST", (8, 1), dxfattribs={"xscale": 2, "yscale": 2})
    document.saveas(tmp_path / "hatch.dxf")
    grid = read_map(tmp_path / "hatch.dxf")
    assert label_at(grid, 2, 1) == Label.OCCUPIED
    assert label_at(grid, 9, 1.0) == Label.OCCUPIED
    assert label_at(grid, 8, 1.0) == Label.FREE


def test_the_command_line_reads_drawings(tmp_path: Path) -> None:
    """`--layer`, repeated, and `--unit` reach the reader."""
    path = write_dxf(tmp_path / "plan.dxf", CIRCLE, units=0)
    words = ("detect", path, "--radius", 0.75, "--unit", 1, "--layer", "walls", "--layer", "#FF0000", "--json")
    result = fidmap(*words)
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout)["detections"][0]["x_m"] == pytest.approx(5, abs=0.02)


def nested_blocks(folder: Path) -> Path:
    """Twenty blocks, each of which holds the next one ten times."""
    from ezdxf.filemanagement import new

    document = new()
    document.header["$INSUNITS"] = 6
    for k in range(20):
        block = document.blocks.new(f"B{k}")
        for _ in range(10):
            if k < 19:
                block.add_blockref(f"B{k + 1}", (0, 0))
            else:
                block.add_line((0, 0), (1, 1))
    document.modelspace().add_blockref("B0", (0, 0))
    document.saveas(folder / "bomb.dxf")
    return folder / "bomb.dxf"


def test_blocks_that_explode(tmp_path: Path) -> None:
    """10^20 lines end in a sentence."""
    assert "its blocks come to more than 20,000 entities" in sentence(nested_blocks(tmp_path))


HEAD = 'xmlns="http://www.w3.org/2000/svg" width="1m" viewBox="0 0 1 1"'
LAUGHS = '<!DOCTYPE svg [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]>'
BROKEN = {
    "entities": (f'<?xml version="1.0"?>{LAUGHS}<svg {HEAD}>&b;</svg>', "it defines entities"),
    "depth": (f"<svg {HEAD}>" + "<g>" * 60 + "</g>" * 60 + "</svg>", "it is nested deeper than 50 levels"),
    "cut off": (f"<svg {HEAD}><path", "it is not XML"),
    "endless curve": (f'<svg {HEAD}><circle r="1e300" stroke="red"/></svg>', "of it"),
    "nothing": (f"<svg {HEAD}></svg>", "holds no lines or areas"),
    "path": (f'<svg {HEAD}><path d="M 1 nonsense"/></svg>', "a path of it cannot be read"),
    "json": ('{"type": "FeatureCollection"', "it is not JSON"),
    "json depth": ('{"type": "GeometryCollection", "geometries": [' * 5000, "it is not JSON"),
    "json nesting": (
        '{"type": "GeometryCollection", "geometries": [' * 20 + "]}" * 20, "it is nested deeper than 10 levels"
    ),
    "json places": ('{"type": "LineString", "coordinates": [[0, "x"]]}', "a line of it is no list of places"),
    "json infinity": ('{"type": "LineString", "coordinates": [[0, Infinity], [1, 1]]}', "its places are not finite"),
    "json far": ('{"type": "LineString", "coordinates": [[0, 0], [1e7, 1e7]]}', "cells of 0.02 m"),
    "json object": ('{"type": "Feature", "geometry": {"type": "Blob"}}', "it holds 'Blob'"),
    "dxf": ("0\nSECTION\n2\nENTITIES\n0\nLINE\nnonsense\n", "ezdxf says"),
    "dxf binary": ("AutoCAD Binary DXF\r\n\x1a\0\x01", "ezdxf says"),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN)
def test_drawings_that_lie(tmp_path: Path, case: str) -> None:
    """One sentence each, before memory or time is taken."""
    content, says = BROKEN[case]
    (tmp_path / "broken").write_bytes(content.encode("latin-1"))
    assert says in sentence(tmp_path / "broken")


def test_ezdxf_says_nothing_of_its_own(tmp_path: Path) -> None:
    """A line between two sections: ezdxf logs a warning, which Python prints where nobody handles it."""
    path = write_dxf(tmp_path / "plan.dxf", CIRCLE)
    tables = b"  0\nSECTION\n  2\nTABLES\n"
    path.write_bytes(path.read_bytes().replace(tables, b"  0\nLINE\n  8\n0\n" + tables))
    command = [sys.executable, "-m", "fidmap", "detect", str(path), "--radius", "0.3", "--layer", "none"]
    told = subprocess.run(command, capture_output=True, text=True, check=False)
    assert told.returncode == 1
    assert told.stderr.count("\n") == 1
    assert told.stderr.startswith(f"fidmap: {path} has no layer")

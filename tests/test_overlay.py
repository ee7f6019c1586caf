"""The drawing: true places, arcs with the right ends, labels apart, hostile names harmless, bounded."""

from __future__ import annotations

import base64
import io
import itertools
import math
import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from fidmap.geometry import apply, apply_inverse
from fidmap.grid import trinarize
from fidmap.model import (
    Assignment,
    BarrelPart,
    Displaced,
    FiducialPart,
    Grid,
    Pose2,
    Report,
    Source,
    Transform,
    TrinaryGrid,
)
from fidmap.report import fonts, svg
from fidmap.report.labels import Caption, place_labels
from fidmap.report.overlay import draw_overlay
from fidmap.report.overlay_frame import nice_length
from fidmap.report.overlay_scene import LABELLED_UP_TO
from fidmap.report.states import State, facing_in_map, marks
from fidmap.report.view import make_view, picture
from sample_report import (
    ERRORS,
    ORIGIN,
    PLACES,
    RADIUS_M,
    sample_arena,
    sample_attributes,
    sample_grid,
    sample_report,
)

NS = {"s": "http://www.w3.org/2000/svg"}
XLINK = "{http://www.w3.org/1999/xlink}href"


def drawing_of(report: Report, grid: TrinaryGrid | None) -> str:
    return draw_overlay(report, grid).svg()


def parsed(drawing: str) -> ET.Element:
    return ET.fromstring(drawing)


def arc_of(drawing: str, label: str) -> ET.Element:
    """The group of the arc whose tip starts with a label."""
    for group in parsed(drawing).iterfind(".//s:g[@class]", NS):
        title = group.find("s:title", NS)
        if title is not None and (title.text or "").startswith(f"{label}:"):
            return group
    raise AssertionError(label)


def texts(drawing: str) -> list[str]:
    return [element.text or "" for element in parsed(drawing).iterfind(".//s:text", NS)]


def numbers(path: str) -> list[float]:
    return [float(number) for number in re.findall(r"-?\d+\.?\d*", path)]


def sample_view(report: Report) -> object:
    return make_view(sample_grid(), np.array([(mark.x_m, mark.y_m) for mark in marks(report)]), RADIUS_M)


@pytest.mark.parametrize(
    ("facing_deg", "start", "end"),
    [(0, (0, 10), (0, -10)), (90, (10, 0), (-10, 0)), (180, (0, -10), (0, 10)), (-90, (-10, 0), (10, 0))],
)
def test_a_half_circle_ends_a_quarter_turn_beside_its_facing(
    facing_deg: float, start: tuple[float, float], end: tuple[float, float]
) -> None:
    """Y points down in the drawing; the arc runs counter-clockwise as seen, which is sweep 0."""
    path = svg.arc_path(np.array([100.0, 50.0]), 10.0, math.radians(facing_deg), math.pi)
    x0, y0, rx, ry, _, _, sweep, x1, y1 = numbers(path)

    assert (x0 - 100, y0 - 50) == pytest.approx(start)
    assert (x1 - 100, y1 - 50) == pytest.approx(end)
    assert (rx, ry, sweep) == (10, 10, 0)


@pytest.mark.parametrize(("drawn_deg", "large"), [(90, 0), (179, 0), (181, 1), (240, 1)])
def test_arcs_over_half_a_turn_take_the_long_way(drawn_deg: float, large: int) -> None:
    path = svg.arc_path(np.array([0.0, 0.0]), 10.0, 0.0, math.radians(drawn_deg))

    assert numbers(path)[5] == large


def test_an_arc_is_drawn_at_its_place_and_size() -> None:
    """1A faces -x: its arc's two ends lie above and below its centre, at the radius of the map's scale."""
    drawing = drawing_of(sample_report(), sample_grid())
    path = arc_of(drawing, "1A").findall("s:path", NS)[-1].attrib["d"]
    x0, y0, r, *_, x1, y1 = numbers(path)
    other = arc_of(drawing, "3A").findall("s:path", NS)[-1].attrib["d"]
    scale = r / RADIUS_M

    half = math.radians(170 / 2)
    assert (x1 - x0, abs(y1 - y0)) == pytest.approx((0, 2 * r * math.sin(half)), abs=0.05)
    assert y1 > y0  # counter-clockwise around -x runs from above to below
    assert numbers(other)[0] - x0 == pytest.approx((9.04 - 2.02) * scale, abs=0.1)
    assert numbers(other)[1] - y0 == pytest.approx(-(0.95 - 1.01) * scale, abs=0.1)


def test_the_drawing_keeps_the_image_upright_and_turns_the_points() -> None:
    """With a turned origin the picture is the same; facings turn back by the origin's yaw."""
    turned = Pose2(0.0, 0.0, math.pi / 2)
    grid = sample_grid(origin=turned)
    arc = BarrelPart(1, -2.0, 5.0, math.pi / 2, math.pi)  # 5 m along the image's x, 2 m up, facing its x
    report = replace(sample_report(), detections=(arc,), attributes=replace(sample_attributes(()), parts=()))
    drawing = drawing_of(report, grid)
    x0, y0, r, *_, x1, y1 = numbers(arc_of(drawing, "#1").findall("s:path", NS)[-1].attrib["d"])

    assert x1 == pytest.approx(x0, abs=0.05)
    assert y0 - y1 == pytest.approx(2 * r, abs=0.05)
    assert {"x", "y"} <= set(texts(drawing))  # the axes say where the frame points


def test_missing_parts_face_where_the_registration_turns_them() -> None:
    assert facing_in_map(math.radians(100), Transform(rotation=math.radians(10))) == pytest.approx(math.pi / 2)
    assert facing_in_map(math.radians(100), Transform(math.radians(10), mirrored=True)) == pytest.approx(-math.pi / 2)
    arc = arc_of(drawing_of(sample_report(), sample_grid()), "3B")
    line = arc.findall("s:path", NS)[1]
    x0, y0, *_, x1, y1 = numbers(line.attrib["d"])

    assert x0 == pytest.approx(x1, abs=0.05)
    assert y0 > y1  # facing +x
    assert line.attrib["stroke-dasharray"]


def test_a_missing_part_without_facing_is_a_dashed_circle() -> None:
    whole = replace(sample_arena().parts[5], facing=None, opening=2 * math.pi)
    parts = (*sample_arena().parts[:5], whole, *sample_arena().parts[6:])
    report = replace(sample_report(), arena=replace(sample_arena(), parts=parts))

    assert arc_of(drawing_of(report, sample_grid()), "3B").findall("s:circle", NS)[1].attrib["stroke-dasharray"]


def test_states_are_counted_in_the_legend() -> None:
    found = texts(drawing_of(sample_report(), sample_grid()))

    assert {
        "assigned: 3", "assigned by hand: 1", "assigned, doubtful: 1", "missing, expected here: 3",
        "detected, no part: 2",
    } <= set(found)  # fmt: skip


def test_only_states_that_occur_are_in_the_legend() -> None:
    report = replace(sample_report(), detections=sample_report().detections[:5])

    assert not any(text.startswith("detected, no part") for text in texts(drawing_of(report, sample_grid())))


def test_parts_without_a_place_are_counted_too() -> None:
    attributes = sample_report().attributes
    lost = tuple(replace(part, barrel=None, expected_x_m=None, expected_y_m=None) for part in attributes.parts)
    report = replace(
        sample_report(),
        attributes=replace(attributes, parts=lost),
        assignment=Assignment((None,) * 8, (False,) * 8, None, 0.0),
    )

    assert "missing, place unknown: 8" in texts(drawing_of(report, sample_grid()))


def test_every_part_and_detection_is_labelled_once() -> None:
    found = texts(drawing_of(sample_report(), sample_grid()))

    for label in ["1A", "1B", "2A?", "2B", "3A", "3B", "4A", "4B", "#6", "#7"]:
        assert found.count(label) == 1, label


def with_many_arcs(count: int, spread_m: float) -> Report:
    generator = np.random.default_rng(4)
    places = generator.uniform(0, spread_m, (count, 2))
    facings = generator.uniform(-math.pi, math.pi, count)
    arcs = tuple(
        BarrelPart(n, float(x), float(y), float(f), math.pi)
        for n, ((x, y), f) in enumerate(zip(places, facings, strict=True), start=1)
    )
    return replace(sample_report(), detections=arcs, attributes=replace(sample_attributes(()), parts=()))


def label_boxes(drawing: str) -> list[tuple[float, float, float, float]]:
    """Boxes of the labels: the halo tells them from other text."""
    boxes = []
    for element in parsed(drawing).iterfind(".//s:text[@paint-order]", NS):
        x, y, size = (float(element.attrib[key]) for key in ("x", "y", "font-size"))
        half = fonts.text_width(element.text or "", size, bold=True) / 2
        boxes.append((x - half, y - 0.76 * size, x + half, y + 0.24 * size))
    return boxes


@pytest.mark.parametrize(("count", "spread_m"), [(20, 2.0), (60, 6.0), (200, 10.0)])
def test_labels_do_not_overlap_and_stay_inside(count: int, spread_m: float) -> None:
    drawing = drawing_of(with_many_arcs(count, spread_m), sample_grid())
    boxes = label_boxes(drawing)
    _, _, width, height = map(float, parsed(drawing).attrib["viewBox"].split())

    assert len(boxes) == count
    for a, b in itertools.combinations(boxes, 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
    assert all(a[0] >= 0 and a[1] >= 0 and a[2] <= width and a[3] <= height for a in boxes)


def test_a_label_without_room_is_left_out() -> None:
    captions = [Caption("a", 10, 10, 18, 18, 0)] * 3

    places = place_labels(captions, np.empty((0, 2)), (0, 0, 20, 40))

    assert [place is not None for place in places] == [True, False, False]


def test_labels_keep_off_what_is_drawn() -> None:
    inked = np.stack([np.full(50, 20.0), np.linspace(-10, 10, 50)], axis=1)
    (place,) = place_labels([Caption("a", 0, 0, 20, 10, 8)], inked, (-100, -100, 100, 100))

    assert place is not None
    assert not (place.box[0] < 20 < place.box[2] and place.box[1] < 10 and place.box[3] > -10)


def test_thousands_of_arcs_stay_a_drawing() -> None:
    drawing = drawing_of(with_many_arcs(4000, 12.0), sample_grid())

    assert len(label_boxes(drawing)) <= LABELLED_UP_TO
    assert "not drawn: 2500" in texts(drawing)
    assert len(drawing) < 1_500_000


def error_arrows(drawing: str) -> list[tuple[float, float]]:
    """Vectors of the error arrows."""
    paths = [numbers(path.attrib["d"]) for path in parsed(drawing).iterfind(".//s:path[@class='error']", NS)]
    return [(path[2] - path[0], path[3] - path[1]) for path in paths]


def test_error_arrows_end_where_the_part_should_be() -> None:
    """2A is 0.5 m off in both directions: with so long an arrow, all are true to scale."""
    drawing = drawing_of(sample_report(), sample_grid())
    r = numbers(arc_of(drawing, "1A").findall("s:path", NS)[-1].attrib["d"])[2]

    longest = max(error_arrows(drawing), key=lambda arrow: math.hypot(*arrow))
    assert longest == pytest.approx((-0.5 * r / RADIUS_M, 0.5 * r / RADIUS_M), abs=0.1)
    assert "arrow to where the part should be" in texts(drawing)


def test_short_errors_are_enlarged_and_the_legend_says_so() -> None:
    attributes = sample_report().attributes
    near = tuple(part for part in attributes.parts if part.id != "2A")
    report = replace(sample_report(), attributes=replace(attributes, parts=near))
    drawing = drawing_of(report, sample_grid())

    assert "position error, drawn 10 times as long" in texts(drawing)
    lengths = [math.hypot(*arrow) for arrow in error_arrows(drawing)]
    assert min(length for length in lengths if length > 0) >= 10


def broken_report() -> Report:
    """Detections 6 and 7 would be 3B and 4A, after a quarter turn and a shift; the other errors are short."""
    report = sample_report()
    near = tuple(part for part in report.attributes.parts if part.id != "2A")
    report = replace(report, attributes=replace(report.attributes, parts=near))
    turned = Transform(math.pi / 2, 3.0, 1.0)
    piece = Displaced(("3B", "4A"), (5, 6), turned)
    return replace(report, assignment=replace(report.assignment, displaced=(piece,)))


def test_displaced_parts_are_drawn_with_the_move_that_would_mend_them() -> None:
    """From each arc to where the second move takes it, to scale, though errors are enlarged; named, and counted."""
    report = broken_report()
    drawing = drawing_of(report, sample_grid())
    move = report.assignment.transform
    assert move is not None
    scale = numbers(arc_of(drawing, "1A").findall("s:path", NS)[-1].attrib["d"])[2] / RADIUS_M

    expected = []
    for arc in report.detections[5:7]:
        seen = np.array([[arc.x_m, arc.y_m]])
        home = apply_inverse(move, apply(Transform(math.pi / 2, 3.0, 1.0), apply(move, seen)))
        expected.append(((home - seen)[0] * [scale, -scale]).tolist())
    paths = [numbers(p.attrib["d"]) for p in parsed(drawing).iterfind(".//s:path[@class='mending']", NS)]
    assert [[p[2] - p[0], p[3] - p[1]] for p in paths] == [pytest.approx(e, abs=0.1) for e in expected]
    found = texts(drawing)
    assert "position error, drawn 10 times as long" in found
    assert {"3B!", "4A!", "displaced, the map is broken here: 2", "second move that would mend the map"} <= set(found)
    assert {"#6", "#7"}.isdisjoint(found)
    tips = [title.text or "" for title in parsed(drawing).iterfind(".//s:title", NS)]
    assert any(tip.startswith("3B: displaced, the map is broken here, detection 6, away by ") for tip in tips)


def test_a_whole_map_has_nothing_to_mend() -> None:
    drawing = drawing_of(sample_report(), sample_grid())

    assert "mending" not in drawing
    assert not any("broken" in text for text in texts(drawing))


def embedded(drawing: str) -> Image.Image:
    image = parsed(drawing).find(".//s:image", NS)
    assert image is not None
    return Image.open(io.BytesIO(base64.b64decode(image.attrib[XLINK].split(",", 1)[1])))


def test_the_map_is_cropped_to_what_is_known() -> None:
    grid = sample_grid(size_m=(60, 60))
    image = embedded(drawing_of(sample_report(), grid))

    assert image.width < 400
    assert len(image.getcolors() or []) == 3


def test_the_picture_has_its_top_row_on_top() -> None:
    p = np.zeros((40, 40), np.float32)
    p[39, 0] = 1.0  # the last row is the highest
    p[0, :] = np.nan
    grid = trinarize(Grid(p, 0.05))
    image = embedded(drawing_of(with_many_arcs(0, 1.0), grid)).convert("L")

    dark = np.argwhere(np.asarray(image) < 100)
    assert dark.tolist() == [[0, 0]]


def test_a_map_without_unknown_cells_is_cropped_to_its_walls() -> None:
    p = np.zeros((2000, 2000), np.float32)
    p[900:1000, 900:1000] = 1.0
    view = make_view(trinarize(Grid(p, 0.05)), np.empty((0, 2)), RADIUS_M)

    assert view.right_column - view.left_column < 200


def test_parts_outside_the_map_widen_the_drawing() -> None:
    far = BarrelPart(1, 40.0, -30.0, 0.0, math.pi)
    report = replace(sample_report(), detections=(far,), attributes=replace(sample_attributes(()), parts=()))
    drawing = drawing_of(report, sample_grid())
    _, _, width, height = map(float, parsed(drawing).attrib["viewBox"].split())
    x0, y0, *_ = numbers(arc_of(drawing, "#1").findall("s:path", NS)[-1].attrib["d"])

    assert 0 < x0 < width
    assert 0 < y0 < height


def test_large_maps_share_pixels_without_losing_walls() -> None:
    p = np.zeros((6000, 6000), np.float32)
    p[3000, :] = 1.0
    p[0, 0] = p[-1, -1] = 1.0
    grid = trinarize(Grid(p, 0.01))
    image = picture(grid, make_view(grid, np.empty((0, 2)), RADIUS_M))

    assert image is not None
    pixels = np.asarray(Image.open(io.BytesIO(image.png)).convert("L"))
    assert max(pixels.shape) <= 2400
    assert (pixels.min(axis=0) < 100).mean() > 0.99


@pytest.mark.parametrize("grid", [None, trinarize(Grid(np.full((5, 7), np.nan, np.float32), 0.05))])
def test_drawings_without_a_map_or_without_known_cells(grid: object) -> None:
    drawing = drawing_of(sample_report(), grid)  # type: ignore[arg-type]

    assert any(text.endswith(" m") for text in texts(drawing))
    assert draw_overlay(sample_report(), grid).png().startswith(b"\x89PNG")


def test_nothing_at_all_still_gives_a_drawing() -> None:
    report = replace(sample_report(), detections=(), attributes=replace(sample_attributes(()), parts=()))

    assert draw_overlay(report, None).png().startswith(b"\x89PNG")


HOSTILE = "a<script>alert(1)</script>&\"'\x00\x1b[31m\u202e\udcff/]]>.yaml"


def test_hostile_names_are_text() -> None:
    part = replace(sample_arena().parts[5], id="<b>&\x07")
    arena = replace(sample_arena(), name=HOSTILE, parts=(*sample_arena().parts[:5], part, *sample_arena().parts[6:]))
    attributes = sample_report().attributes
    results = (*attributes.parts[:5], replace(attributes.parts[5], id=part.id), *attributes.parts[6:])
    report = replace(sample_report(HOSTILE), arena=arena, attributes=replace(attributes, parts=results))
    drawing = drawing_of(report, sample_grid())

    drawing.encode()  # no lone surrogates
    assert "<script" not in drawing
    assert "<b>&\ufffd" in texts(drawing)
    assert draw_overlay(report, sample_grid()).png().startswith(b"\x89PNG")


def test_text_is_drawn_without_any_system_font() -> None:
    """A fresh Debian has no fonts, and resvg then leaves texts out without a word."""
    size = 'viewBox="0 0 200 40"'
    sheet = f'<svg xmlns="http://www.w3.org/2000/svg" {size}><rect width="200" height="40" fill="#fff"/>'
    letters = svg.text("1A ä € 93.2 %", 5, 28, 24, font_family=fonts.FAMILY)
    png = fonts.svg_to_png(f"{sheet}{letters}</svg>", 200, 40)

    dark = np.asarray(Image.open(io.BytesIO(png)).convert("L")) < 128
    assert dark.sum() > 200
    assert dark.any(axis=0).nonzero()[0].max() == pytest.approx(5 + fonts.text_width("1A ä € 93.2 %", 24), abs=4)


def test_png_is_bounded_and_the_drawing_does_not_change_from_run_to_run() -> None:
    drawing = drawing_of(sample_report(), sample_grid())
    image = Image.open(io.BytesIO(draw_overlay(sample_report(), sample_grid()).png()))

    assert max(image.size) == 1400
    assert drawing == drawing_of(sample_report(), sample_grid())


def test_arcs_stay_visible_on_the_map_of_a_whole_building() -> None:
    p = np.zeros((4000, 4000), np.float32)
    p[0, 0] = p[-1, -1] = 1.0
    drawing = drawing_of(sample_report(), trinarize(Grid(p, 0.05, ORIGIN)))

    assert numbers(arc_of(drawing, "1A").findall("s:path", NS)[-1].attrib["d"])[2] == 8
    assert "arcs larger than true" in texts(drawing)
    assert "arcs larger than true" not in texts(drawing_of(sample_report(), sample_grid()))


def test_pixels_show_what_the_drawing_shows() -> None:
    """The PNG averages fine cells itself; a wall must end up at the same place as in the drawing."""
    p = np.zeros((3000, 3000), np.float32)
    p[1000:1040, :] = 1.0
    p[0, 0] = p[-1, -1] = 1.0
    overlay = draw_overlay(replace(sample_report(), attributes=sample_attributes(())), trinarize(Grid(p, 0.05)))
    ours = np.asarray(Image.open(io.BytesIO(overlay.png())).convert("L"), float)
    plain = fonts.svg_to_png(overlay.svg(), ours.shape[1], ours.shape[0])
    theirs = np.asarray(Image.open(io.BytesIO(plain)).convert("L"), float)

    assert np.abs(ours - theirs).mean() < 1.5


@pytest.mark.parametrize(("longest", "nice"), [(1.0, 1.0), (1.99, 1.0), (2.0, 2.0), (7.3, 5.0), (0.03, 0.02)])
def test_scale_bars_are_round(longest: float, nice: float) -> None:
    assert nice_length(longest) == pytest.approx(nice)


def test_noise_of_2000_by_2000_cells_stays_below_two_megabytes() -> None:
    p = np.random.default_rng(1).choice(np.array([0.0, 1.0, np.nan], np.float32), (2000, 2000))
    grid = trinarize(Grid(p, 0.05, Pose2(), source=Source("noise", "00" * 32)))

    assert len(drawing_of(sample_report(), grid)) < 1_500_000


def test_sample_is_in_order() -> None:
    """The sample's own states, so that tests here mean what they say."""
    found = {mark.label: mark.state for mark in marks(sample_report())}

    assert found["#6"] is State.UNASSIGNED
    assert set(ERRORS) < set(PLACES)
    assert ORIGIN.yaw == 0
    assert isinstance(sample_arena().parts[0], FiducialPart)

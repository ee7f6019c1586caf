"""Points files: corrections by hand come back to the last bit, and every fault has its line."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fidmap.model import Arena, BarrelPart, FiducialPart, PointsFileError
from fidmap.points import check_ids, points_csv, read_points


def read(folder: Path, text: str | bytes) -> tuple[BarrelPart, ...]:
    path = folder / "p.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_points(path)


def fault(folder: Path, text: str | bytes) -> str:
    with pytest.raises(PointsFileError) as told:
        read(folder, text)
    assert "\n" not in str(told.value)
    return str(told.value).removeprefix(f"{folder / 'p.csv'}: ")


def test_positions_alone_are_whole_barrels(tmp_path: Path) -> None:
    """Two columns are enough: numbered from 1, whole, found by nobody in particular."""
    assert read(tmp_path, "x_m,y_m\n1,2\n-3.5,4e-1\n") == (
        BarrelPart(1, 1.0, 2.0, None, 2 * math.pi),
        BarrelPart(2, -3.5, 0.4, None, 2 * math.pi),
    )


def test_every_column_is_read(tmp_path: Path) -> None:
    """Columns in any order; `part` is the program's word and ignored, `id` the human's."""
    text = (
        "id,part,n,x_m,y_m,facing_deg,drawn_deg,sigma_m,confidence\n"
        "1A,9Z,7,1,2,180,165,0.01,0.97\n-,,3,1,2,90,,,\n,1A,,0,0,,240,,\n"
    )
    assert read(tmp_path, text) == (
        BarrelPart(7, 1.0, 2.0, math.pi, math.radians(165), 0.01, 0.97, fixed_id="1A"),
        BarrelPart(3, 1.0, 2.0, math.pi / 2, math.pi, fixed_id="-"),
        BarrelPart(8, 0.0, 0.0, None, math.radians(240)),
    )


def test_rows_without_a_number_follow_the_largest(tmp_path: Path) -> None:
    """A row that somebody added gets the next free number."""
    assert [part.n for part in read(tmp_path, "n,x_m,y_m\n,0,0\n5,1,1\n,2,2\n2,3,3\n")] == [6, 5, 7, 2]


def test_what_a_spreadsheet_makes_of_it_is_read(tmp_path: Path) -> None:
    """Byte order mark, semicolons, decimal commas, CRLF, blank lines and empty cells at the end."""
    text = b"\xef\xbb\xbfX_m; y_m ;id;;\r\n1,5;-2;1A;;\r\n;;;;\r\n\r\n3;4\r\n"
    assert read(tmp_path, text) == (BarrelPart(1, 1.5, -2.0, fixed_id="1A"), BarrelPart(2, 3.0, 4.0))


def test_a_table_without_rows_has_no_parts(tmp_path: Path) -> None:
    """A map on which nothing was found gives such a file."""
    assert read(tmp_path, points_csv([], [])) == ()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "is empty, expected a points file with a first line x_m,y_m"),
        (",,\n", "is empty, expected a points file with a first line x_m,y_m"),
        ('""\n;\n', "is empty, expected a points file with a first line x_m,y_m"),
        (b"\xff\xfe", "line 1: not UTF-8 text, expected a points file"),
        ("x_m,z\n", "column 'y_m' is missing; unknown column 'z', known are x_m, y_m, n, facing_deg, "
         "drawn_deg, sigma_m, confidence, part, id"),
        ("x_m,y_m,u,v\n", "unknown columns 'u', 'v', known are x_m, y_m, n, facing_deg, drawn_deg, sigma_m, "
         "confidence, part, id"),
        ("x_m,y_m,x_m\n", "column 'x_m' is there twice"),
        ("x_m,y_m\n1,2,3\n", "line 2: has 3 cells for 2 columns"),
        ('x_m,y_m\n"1,2\n', "not CSV: unexpected end of data"),
        ("x_m,y_m\n,2\n", "line 2: x_m is missing"),
        ("x_m,y_m\nnan,1_0\n", "line 2: x_m must be a number, not 'nan'; "
         "line 2: y_m must be a number, not '1_0'"),
        ("x_m,y_m\n1e99,0\n", "line 2: x_m must be from -1e+08 to 1e+08, not '1e99'"),
        ("x_m,y_m,n\n0,0,0\n", "line 2: n must be a whole number from 1, not '0'"),
        ("x_m,y_m,n\n0,0,2.5\n", "line 2: n must be a whole number from 1, not '2.5'"),
        ("x_m,y_m,n\n0,0,4\n\n1,1,04\n", "line 4: n 4 stands already on line 2"),
        ("x_m,y_m,id\n0,0,1A\n1,1,-\n2,2,-\n3,3,1A\n", "line 5: id '1A' stands already on line 2"),
        ("x_m,y_m,drawn_deg\n0,0,0\n", "line 2: drawn_deg must be from more than 0 to 360, not '0'"),
        ("x_m,y_m,facing_deg\n0,0,400\n", "line 2: facing_deg must be from -360 to 360, not '400'"),
        ("x_m,y_m,sigma_m\n0,0,-1\n", "line 2: sigma_m must be from 0 to 1e+08, not '-1'"),
        ("x_m,y_m,confidence\n0,0,97\n", "line 2: confidence must be from 0 to 1, not '97'"),
        ("x_m,y_m\nx,0\n0,0\n1,y\n", "line 2: x_m must be a number, not 'x'; "
         "line 4: y_m must be a number, not 'y'"),
    ],
)  # fmt: skip
def test_a_fault_is_told_with_its_line(tmp_path: Path, text: str | bytes, told: str) -> None:
    """All faults at once, in the order of the lines."""
    assert fault(tmp_path, text) == told


def test_ids_are_checked_against_the_arena() -> None:
    """Unknown ids are named with the nearest known one; '-' and empty are no ids."""
    arena = Arena("A2", 0.3, (FiducialPart("1A"), FiducialPart("barrel-7")))
    fine = (BarrelPart(1, 0, 0, fixed_id="1A"), BarrelPart(2, 0, 0, fixed_id="-"), BarrelPart(3, 0, 0))
    check_ids(fine, arena, "p.csv")
    wrong = (*fine, BarrelPart(4, 0, 0, fixed_id="barrel7"), BarrelPart(5, 0, 0, fixed_id="XY"))
    with pytest.raises(PointsFileError) as told:
        check_ids(wrong, arena, "p.csv")
    assert str(told.value) == (
        "p.csv: n 4: id 'barrel7' is no part of arena 'A2' (did you mean barrel-7?); "
        "n 5: id 'XY' is no part of arena 'A2'"
    )


def test_the_file_is_what_people_expect() -> None:
    """Columns in the promised order, plain numbers, `id` empty."""
    parts = [BarrelPart(1, 3.1, 2.2, math.pi / 2, math.radians(165), 0.01, 0.97, 0.003), BarrelPart(2, 0, 1)]
    assert points_csv(parts, ["1A", None]) == (
        "n,x_m,y_m,facing_deg,drawn_deg,sigma_m,confidence,part,id\n"
        "1,3.1,2.2,90,165,0.01,0.97,1A,\n"
        "2,0.0,1.0,,360,,1.0,,\n"
    )


_FLOATS = st.floats(-1e6, 1e6)
_PARTS = st.lists(
    st.builds(
        BarrelPart,
        n=st.integers(1, 10**6),
        x_m=_FLOATS,
        y_m=_FLOATS,
        facing=st.none() | st.floats(-math.pi, 2 * math.pi, allow_subnormal=False),
        drawn=st.floats(0.1, 2 * math.pi),
        sigma_m=st.none() | st.floats(0, 10),
        confidence=st.floats(0, 1),
        fixed_id=st.sampled_from([None, "-"]),
    ),
    max_size=6,
    unique_by=lambda part: part.n,
)


@settings(derandomize=True, deadline=None, max_examples=200)
@given(_PARTS)
def test_reading_back_gives_the_same_parts(tmp_path_factory: pytest.TempPathFactory, parts: list[BarrelPart]) -> None:
    """To the last bit, so that an unchanged file gives the same scores and the same JSON."""
    folder = tmp_path_factory.getbasetemp()
    assert read(folder, points_csv(parts, [None] * len(parts))) == tuple(parts)

"""Arena files: what is read, and the exact text of every fault."""

from __future__ import annotations

import hashlib
import json
import math
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fidmap.arena import read_arena
from fidmap.model import Arena, ArenaFileError, FiducialPart, Group
from real_data import real_data

HEAD = "fidmap_arena: 1\nname: A2\nradius_m: 0.3\n"
PAIR = "parts:\n  - {id: 1A, x_m: 1, y_m: 2, facing_deg: 0}\n  - {id: 1B, x_m: 1, y_m: 3, facing_deg: 180}\n"
GROUP = "groups:\n  - {id: 1, parts: [1A, 1B], class: long}\n"


def read(folder: Path, text: str, limit: float | None = 6.0) -> Arena:
    path = folder / "a.yaml"
    path.write_text(text, encoding="utf-8")
    return read_arena(path, limit)


def fault(folder: Path, text: str, limit: float | None = 6.0) -> str:
    with pytest.raises(ArenaFileError) as told:
        read(folder, text, limit)
    assert "\n" not in str(told.value)
    return str(told.value).removeprefix(f"{folder / 'a.yaml'}: ")


def test_a_whole_arena_is_read(tmp_path: Path) -> None:
    """Every key of the file reaches the model, angles in radians, path and hash kept."""
    text = """
fidmap_arena: 1
name: A2
radius_m: 0.30
frame: map
pallet_m: 1.2
parts:
  - {id: 1A, x_m: 5.975, y_m: 5.413, z_m: 1, facing_deg: 180, opening_deg: 120, sigma_m: 0.005}
  - {id: 1B, x_m: 5.975, y_m: 5.513, facing_deg: -450}
  - {id: W, x_m: 0, y_m: 0}
groups:
  - {id: "1", parts: [1A, 1B], class: long}
  - {id: "7", parts: [1A, W], walking_pallets: 3.5, distance_m: 0.05}
"""
    arena = read(tmp_path, text)
    assert arena == Arena(
        name="A2",
        radius_m=0.3,
        frame="map",
        pallet_m=1.2,
        parts=(
            FiducialPart("1A", 5.975, 5.413, math.pi, math.radians(120), 0.005, 1.0),
            FiducialPart("1B", 5.975, 5.513, -math.pi / 2, math.pi),
            FiducialPart("W", 0.0, 0.0, None, 2 * math.pi),
        ),
        groups=(
            Group("1", ("1A", "1B"), "long"),
            Group("7", ("1A", "W"), None, 3.5, 0.05),
        ),
        path=str(tmp_path / "a.yaml"),
        sha256=hashlib.sha256(text.encode()).hexdigest(),
    )


def test_json_is_read_like_yaml(tmp_path: Path) -> None:
    """YAML, so JSON too, with tabs."""
    document = {
        "fidmap_arena": 1,
        "name": "j",
        "radius_m": 0.3,
        "parts": [{"id": "1", "x_m": 1.5e-3, "y_m": -2}],
    }
    (part,) = read(tmp_path, json.dumps(document, indent="\t")).parts
    assert (part.id, part.x_m, part.y_m) == ("1", 0.0015, -2.0)


def test_ids_are_the_words_of_the_file(tmp_path: Path) -> None:
    """YAML 1.1 would read these ids as 8, False, 10.0 and a date."""
    ids = ["010", "no", "1E1", "2026-05-01", "1_0", "12:30"]
    parts = "".join(f"  - {{id: {word}}}\n" for word in ids)
    assert [part.id for part in read(tmp_path, f"{HEAD}parts:\n{parts}").parts] == ids


def test_numbers_that_yaml_1_1_takes_for_text_are_numbers(tmp_path: Path) -> None:
    """25e-3 is a string for YAML 1.1 and a number for everybody else."""
    arena = read(tmp_path, "fidmap_arena: 1\nname: n\nradius_m: 25e-3\nparts: [{id: a, x_m: -4E-17, y_m: +.5}]")
    assert (arena.radius_m, arena.parts[0].x_m, arena.parts[0].y_m) == (0.025, -4e-17, 0.5)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "is empty, expected an arena file: a mapping of keys to values"),
        ("- 1", "holds a list, expected an arena file: a mapping of keys to values"),
        ("a: 1\na: 2", "line 2: key 'a' is given twice"),
        ("a: [1,\n", "line 2: did not find expected node content"),
        (
            "a: !!python/name:os.system x",
            "line 1: tag !!python/name:os.system is not allowed, write plain values",
        ),
        ("a: &x [*x]", "line 1: alias '*x' stands before or inside what it names"),
        ("[" * 99, "line 1: nested deeper than 20 levels"),
        ("a: 1\n---\nb: 2", "line 2: but found another document"),
        ("? [1]\n: 2", "line 1: a key must be a word"),
        (HEAD, "parts: is missing"),
        (HEAD + "parts: []", "parts: must have at least 1, not 0"),
        (HEAD + "parts: 3", "parts: must be a list, not 3"),
        (HEAD + "parts: [3]", "parts[0]: must be a mapping, not 3"),
        (HEAD.replace("1", "2", 1) + PAIR, "fidmap_arena: must be 1, the only version so far, not 2"),
        (HEAD.replace("1", "true", 1) + PAIR, "fidmap_arena: must be 1, the only version so far, not true"),
        (
            PAIR + "name: x\nradius_m: 1",
            "fidmap_arena: is missing, write 'fidmap_arena: 1' on top of an arena file",
        ),
        (HEAD.replace("0.3", "0") + PAIR, "radius_m: must be greater than 0, not 0"),
        (HEAD.replace("0.3", "-.inf") + PAIR, "radius_m: must be a finite number, not -.inf"),
        (HEAD.replace("0.3", "1e999") + PAIR, "radius_m: must be a finite number, not 1e999"),
        (HEAD.replace("0.3", "9" * 400) + PAIR, f"radius_m: must be a finite number, not {'9' * 37}..."),
        (HEAD.replace("0.3", "yes") + PAIR, "radius_m: must be a number, not 'yes'"),
        (HEAD.replace("0.3", "true") + PAIR, "radius_m: must be a number, not true"),
        (HEAD + PAIR + "frame: world", "frame: must be 'relative' or 'map', not 'world'"),
        (HEAD + PAIR + "pallets_m: 1.2", "pallets_m: unknown key (did you mean pallet_m?)"),
        (
            HEAD + PAIR.replace("x_m: 1,", "x_m: .nan,", 1),
            "parts[0].x_m (part 1A): must be a finite number, not .nan",
        ),
        (HEAD + PAIR.replace("1B", "1A"), "parts[1].id: '1A' is already the id of parts[0]"),
        (
            HEAD + PAIR.replace("1B", "'-'"),
            "parts[1].id: '-' means 'no part' in points files, choose another id",
        ),
        (HEAD + PAIR.replace("1B", "''"), "parts[1].id: must not be empty, not ''"),
        (HEAD + PAIR.replace("1B", "~"), "parts[1].id: must be a word, not nothing"),
        (
            HEAD + PAIR.replace("1B", "'1B '"),
            "parts[1].id (part 1B ): must be at most 200 printable characters without spaces at its ends, not '1B '",
        ),
        (
            HEAD + PAIR.replace("facing_deg: 0", "opening_deg: 0"),
            "parts[0].opening_deg (part 1A): must be greater than 0, not 0",
        ),
        (
            HEAD + PAIR.replace("facing_deg: 0", "opening_deg: 361"),
            "parts[0].opening_deg (part 1A): must be at most 360, not 361",
        ),
        (HEAD + PAIR.replace(", y_m: 3", ""), "parts[1] (part 1B): x_m without y_m, give both or none"),
        (
            HEAD + PAIR.replace("x_m: 1, y_m: 3, ", ""),
            "parts[1] (part 1B): has no position though others have, give x_m and y_m for all parts or for none",
        ),
        (
            HEAD + "frame: map\nparts: [{id: a}]",
            "frame: 'map' needs positions, give x_m and y_m for all parts",
        ),
        (
            HEAD + PAIR + GROUP.replace("1B", "2B"),
            "groups[0] (group 1): part '2B' is not in parts",
        ),
        (HEAD + PAIR + GROUP.replace("1B", "1B, 1B"), "groups[0] (group 1): part '1B' is named twice"),
        (HEAD + PAIR + GROUP.replace(", 1B", ""), "groups[0].parts (group 1): must have at least 2, not 1"),
        (
            HEAD + PAIR + GROUP.replace(", class: long", ""),
            "groups[0] (group 1): needs class or walking_pallets",
        ),
        (
            HEAD + PAIR + GROUP.replace("long", "coverage"),
            "groups[0] (group 1): class 'coverage' is the name of an attribute, choose another",
        ),
        (
            HEAD + PAIR + GROUP.replace("long", "long, walking_pallets: 6"),
            "groups[0] (group 1): class long contradicts walking_pallets 6 (over 6 is long)",
        ),
        (
            HEAD + PAIR + GROUP.replace("long", "short, walking_pallets: 6.5"),
            "groups[0] (group 1): class short contradicts walking_pallets 6.5 (over 6 is long)",
        ),
        (
            HEAD + PAIR + GROUP.replace("long", "long, walking_pallets: -1"),
            "groups[0].walking_pallets (group 1): must be at least 0, not -1; "
            "groups[0] (group 1): class long contradicts walking_pallets -1 (over 6 is long)",
        ),
        (
            HEAD + PAIR + GROUP + "  - {id: 1, parts: [1A, 1B], class: short}",
            "groups[1].id: '1' is already the id of groups[0]",
        ),
        (
            HEAD + PAIR + GROUP + "  - {id: 2, parts: [1B, 1A], walking_pallets: 7}",
            "groups[1] (group 2): compares the same parts in the same class as groups[0] (group 1)",
        ),
        (
            HEAD + "parts: [{id: 1A}, {id: 1B}]\n" + GROUP,
            "groups[0] (group 1): part '1A' has no position, so the group needs distance_m",
        ),
        (
            HEAD + "parts: [{id: 1A}, {id: 1B}, {id: 1C}]\n" + GROUP.replace("1B]", "1B, 1C], distance_m: 1"),
            "groups[0] (group 1): distance_m is for two parts, not 3",
        ),
        (
            HEAD + "parts: [{id: 1A}, {id: 1B}, {id: 1C}]\n" + GROUP.replace("1B]", "1B, 1C]"),
            "groups[0] (group 1): part '1A' has no position, so the group needs positions or split it into "
            "pairs with distance_m",
        ),
    ],
)
def test_a_fault_is_told_with_its_place(tmp_path: Path, text: str, told: str) -> None:
    """One sentence: where in the file, what is wrong, what was expected."""
    assert fault(tmp_path, text) == told


def test_all_faults_are_told_at_once(tmp_path: Path) -> None:
    """A wrong number in one place does not hide an unknown part in another."""
    text = HEAD + PAIR.replace("x_m: 1", "x_m: one", 1) + GROUP.replace("1B", "1C")
    assert fault(tmp_path, text) == (
        "parts[0].x_m (part 1A): must be a number, not 'one'; groups[0] (group 1): part '1C' is not in parts"
    )


def test_the_number_of_faults_shown_is_bounded(tmp_path: Path) -> None:
    """A file of the wrong kind does not fill the terminal."""
    parts = "".join(f"  - {{id: {i}, x_m: x, y_m: 0}}\n" for i in range(32))
    told = fault(tmp_path, f"{HEAD}parts:\n{parts}")
    assert told.endswith("parts[19].x_m (part 19): must be a number, not 'x'; and 12 more")


def test_an_alias_bomb_ends_in_a_sentence(tmp_path: Path) -> None:
    """Nine lines that stand for 10^9 values are refused before they are built."""
    lines = [f"{name}: &{name} [{', '.join([inner] * 10)}]" for inner, name in zip(
        ["1", *(f"*{c}" for c in "abcdefgh")], "abcdefghi", strict=True
    )]  # fmt: skip
    assert fault(tmp_path, "\n".join(lines)) == "line 6: more than 500000 values"


def test_aliases_and_merges_are_fine(tmp_path: Path) -> None:
    """People who know YAML may use it."""
    text = HEAD + "parts:\n  - &a {id: 1A, x_m: 1, y_m: 2}\n  - {<<: *a, id: 1B}\n"
    assert [(part.id, part.x_m) for part in read(tmp_path, text).parts] == [("1A", 1.0), ("1B", 1.0)]


def test_files_that_are_no_text_are_told(tmp_path: Path) -> None:
    """A directory, a missing file, a picture and a file of many megabytes end in one sentence each."""
    picture, large = tmp_path / "p.png", tmp_path / "large"
    picture.write_bytes(b"\x89PNG\r\n\x1a\n")
    with large.open("wb") as file:
        file.truncate(5 << 20)
    for path, told in (
        (tmp_path, "is a directory, expected an arena file, so name the file inside it"),
        (tmp_path / "none", "no such file, expected an arena file, so check the path"),
        (picture, "line 1: not UTF-8 text, expected an arena file"),
        (large, "is larger than 4 MiB, too large for an arena file"),
    ):
        with pytest.raises(ArenaFileError) as error:
            read_arena(path)
        assert str(error.value) == f"{path}: {told}"


def test_the_limit_of_the_profile_decides(tmp_path: Path) -> None:
    """Class and walking distance are compared at the profile's limit, and not at all without one."""
    text = HEAD + PAIR + GROUP.replace("long", "long, walking_pallets: 4")
    assert read(tmp_path, text, 3).groups[0].resolved_class(3) == "long"
    assert read(tmp_path, text, None).groups[0].walking_pallets == 4
    assert fault(tmp_path, text, 4).endswith("class long contradicts walking_pallets 4 (over 4 is long)")


def test_other_classes_may_carry_a_walking_distance(tmp_path: Path) -> None:
    """A room is a class of its own, however far its parts are apart."""
    (group,) = read(tmp_path, HEAD + PAIR + GROUP.replace("long", "room, walking_pallets: 2")).groups
    assert group.resolved_class(6) == "room"


@pytest.mark.parametrize(("pallets", "expected"), [(6.0, "short"), (6.01, "long"), (0.0, "short")])
def test_more_than_six_pallets_is_long(pallets: float, expected: str) -> None:
    """Six or less is short (SSRR 2011, III)."""
    assert Group("1", ("a", "b"), walking_pallets=pallets).resolved_class(6) == expected


def test_a_group_without_class_and_distance_is_an_error() -> None:
    """Groups that were not read from a file are told too."""
    with pytest.raises(ArenaFileError, match="group '1' has neither a class nor walking_pallets"):
        Group("1", ("a", "b")).resolved_class(6)


def test_a_bare_groups_key_is_no_groups(tmp_path: Path) -> None:
    """It stays when somebody comments out the entries."""
    assert read(tmp_path, HEAD + PAIR + "groups:\n  # - {id: 1}\n").groups == ()


def test_positions_may_be_missing_for_consistency_alone(tmp_path: Path) -> None:
    """Only the thickness of the wall is needed then (SSRR 2011, V)."""
    text = HEAD + "parts: [{id: 1A}, {id: 1B}]\n" + GROUP.replace("long", "long, distance_m: 0.02")
    arena = read(tmp_path, text)
    assert not arena.has_positions
    assert arena.groups[0].distance_m == 0.02


@settings(derandomize=True, deadline=None, max_examples=50)
@given(
    st.lists(
        st.tuples(
            st.floats(-1e6, 1e6),
            st.floats(-1e6, 1e6),
            st.none() | st.floats(-180, 180),
            st.floats(0, 360, exclude_min=True),
        ),
        min_size=1,
        max_size=5,
    )
)
def test_what_is_written_is_read(tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[float, ...]]) -> None:
    """Positions come back to the last bit, angles as their radians."""
    keys = ("x_m", "y_m", "facing_deg", "opening_deg")
    parts = [{"id": f"p{i}", **dict(zip(keys, row, strict=True))} for i, row in enumerate(rows)]
    document = {"fidmap_arena": 1, "name": "p", "radius_m": 0.3, "parts": parts}
    arena = read(tmp_path_factory.getbasetemp(), json.dumps(document))
    for part, (x_m, y_m, facing_deg, opening_deg) in zip(arena.parts, rows, strict=True):
        assert (part.x_m, part.y_m) == (x_m, y_m)
        assert part.facing == (None if facing_deg is None else math.radians(facing_deg))
        assert part.opening == math.radians(opening_deg)


def test_every_real_arena_file_is_read() -> None:
    """The arena files beside the real maps: sizes as their README tells."""
    found = {path: read_arena(path) for path in sorted(real_data().rglob("*arena.yaml"))}
    sizes = {arena.name: (len(arena.parts), len(arena.groups), arena.frame) for arena in found.values()}
    assert sizes == {
        "A2": (14, 7, "relative"),
        "R2": (18, 9, "relative"),
        "playpen": (9, 0, "map"),
        "tb3_world": (9, 0, "relative"),
    }
    assert all(arena.has_positions for arena in found.values())


def test_a_large_arena_is_read_quickly(tmp_path: Path) -> None:
    """Ten thousand parts and five thousand groups, in seconds and not in minutes."""
    parts = [{"id": str(i), "x_m": i, "y_m": 0, "facing_deg": 90} for i in range(10_000)]
    groups = [{"id": str(i), "parts": [str(2 * i), str(2 * i + 1)], "class": "short"} for i in range(5_000)]
    document = {"fidmap_arena": 1, "name": "large", "radius_m": 0.3, "parts": parts, "groups": groups}
    start = time.process_time()
    assert len(read(tmp_path, json.dumps(document)).groups) == 5_000
    assert time.process_time() - start < 10

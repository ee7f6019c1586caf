"""`fidmap score`: options, JSON Lines, exit codes, as scripts rely on them."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from command_line import ARENA, ONE, documents, evening, fidmap, without_seconds
from fidmap.cli.options import parse_origin, parse_start_pose
from fidmap.model import Pose2


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return evening(tmp_path, monkeypatch)


def scores(document: dict[str, Any]) -> dict[str, float | None]:
    return {name: entry["value"] for name, entry in document["attributes"].items()}


def test_without_options_there_is_a_table_and_nothing_is_written(here: Path) -> None:
    before = sorted(here.rglob("*"))
    result = fidmap("score", "good.yaml", *ARENA)

    assert result.exit_code == 0
    assert result.stderr == ""
    assert [line.split() for line in result.stdout.splitlines()[1:2]] == [
        ["Map", "Coverage", "accuracy", "Consistency", "Overall"]
    ]
    assert "good.yaml" in result.stdout
    assert sorted(here.rglob("*")) == before


def test_json_is_one_valid_line_per_map_in_the_order_given_and_nothing_else() -> None:
    result = fidmap("score", "noisy.yaml", "missing.yaml", "good.yaml", *ONE, "--json")

    assert result.exit_code == 1
    assert [line["map"] for line in documents(result.stdout)] == ["noisy.yaml", "missing.yaml", "good.yaml"]
    error = documents(result.stdout)[1]
    assert error == {"map": "missing.yaml", "error": {"code": "map-file", "text": error["error"]["text"]}}
    assert result.stderr == f"fidmap: {error['error']['text']}\n"
    assert error["error"]["text"].startswith("missing.yaml does not exist; ")


def test_the_document_names_what_it_came_from() -> None:
    """Hashes, every setting and the version: a report can be made again."""
    document = documents(fidmap("score", "good.yaml", *ONE, "--json", "--profile", "ssrr2011").stdout)[0]

    assert (document["fidmap_report"], document["arena"], document["profile"]) == (1, "demo", "ssrr2011")
    provenance = document["provenance"]
    assert len(provenance["map_sha256"]) == len(provenance["arena_sha256"]) == 64
    assert provenance["settings"]["rounding"] == "nearest"
    assert provenance["seconds"] > 0
    assert document["attributes"]["global_accuracy"] == {"value": None, "reason": "the arena's frame is relative"}


def test_workers_and_the_order_of_maps_change_nothing() -> None:
    """Byte-identical JSON but for `seconds` with one process and with two (which start afresh)."""
    maps = ["good.yaml", "missing.yaml", "noisy.yaml"]
    texts = []
    for workers, order in ((1, maps), (2, maps[::-1])):
        found = documents(fidmap("score", *order, *ARENA, "--json", "--workers", workers).stdout)
        assert [document["map"] for document in found] == order
        plain = {d["map"]: d if "error" in d else without_seconds(d) for d in found}
        texts.append(json.dumps([plain[name] for name in maps]))
    assert texts[0] == texts[1]


def test_a_map_named_twice_is_scored_once() -> None:
    """A glob that names image and YAML, or the same file by two names."""
    result = fidmap("score", "good.pgm", "noisy.yaml", "good.yaml", "./good.yaml", *ONE, "--json")

    assert result.exit_code == 0
    assert [document["map"] for document in documents(result.stdout)] == ["noisy.yaml", "good.yaml"]
    assert "fidmap: note: good.pgm is the same map as good.yaml; it is taken once\n" in result.stderr
    assert "fidmap: note: ./good.yaml is the same map as good.yaml; it is taken once\n" in result.stderr


def test_an_image_uses_the_yaml_beside_it() -> None:
    alone = documents(fidmap("score", "good.pgm", *ONE, "--json").stdout)[0]
    yaml = documents(fidmap("score", "good.yaml", *ONE, "--json").stdout)[0]

    assert [finding["code"] for finding in alone["findings"]] == ["image-uses-yaml"]
    assert alone["provenance"]["map_sha256"] == yaml["provenance"]["map_sha256"]
    assert scores(alone) == scores(yaml)


def test_a_plain_image_needs_its_resolution_and_takes_an_origin(here: Path) -> None:
    """Relative scores do not depend on the origin, so they are those of the YAML with the same cells."""
    (here / "good.yaml").rename(here / "good.yml.txt")
    bare = fidmap("score", "good.pgm", *ONE, "--json")
    assert bare.exit_code == 1
    assert "give its scale with --resolution M_PER_CELL" in bare.stderr

    result = fidmap("score", "good.pgm", *ONE, "--json", "--resolution", "0.05", "--origin", "1,2,90")
    (document,) = documents(result.stdout)
    assert document["attributes"]["coverage"]["value"] == 1
    assert document["provenance"]["overrides"] == {
        "resolution_m": 0.05,
        "origin": {"x_m": 1.0, "y_m": 2.0, "yaw_deg": 90.0},
    }
    unturned = documents(fidmap("score", "good.pgm", *ONE, "--json", "--resolution", "0.05").stdout)[0]
    turned = (document["registration"]["rotation_deg"] - unturned["registration"]["rotation_deg"] + 180) % 360 - 180
    assert turned == pytest.approx(-90, abs=1e-6)


def test_thresholds_override_the_file(here: Path) -> None:
    """With free_thresh 0.25 grey 205 loads as free, which is told with the option that mends it."""
    text = (here / "good.yaml").read_text().replace("free_thresh: 0.196", "free_thresh: 0.25")
    (here / "good.yaml").write_text(text)
    odd = documents(fidmap("score", "good.yaml", *ONE, "--json").stdout)[0]
    (finding,) = [finding for finding in odd["findings"] if finding["code"] == "unknown-loads-as-free"]
    option, value = finding["option"].split()
    assert option == "--free-thresh"

    mended = documents(fidmap("score", "good.yaml", *ONE, "--json", option, value).stdout)[0]
    assert "unknown-loads-as-free" not in [finding["code"] for finding in mended["findings"]]
    assert mended["provenance"]["overrides"] == {"free_thresh": float(value)}
    walls = fidmap("score", "good.yaml", *ONE, "--json", "--occupied-thresh", "1.5")
    assert documents(walls.stdout)[0]["attributes"]["coverage"]["value"] == 0


def test_a_start_pose_limits_the_search() -> None:
    """Where the map's origin stands in the arena: the true pose changes nothing, a far one finds nothing."""
    free = documents(fidmap("score", "good.yaml", *ONE, "--json").stdout)[0]
    (x, y), turn = free["registration"]["translation_m"], free["registration"]["rotation_deg"]
    true = documents(fidmap("score", "good.yaml", *ONE, "--json", "--start-pose", f"{x},{y},{turn},0.2,5").stdout)[0]
    assert true["attributes"]["coverage"]["value"] == 1
    assert true["provenance"]["start_pose"]["sigma_deg"] == pytest.approx(5)
    far = documents(fidmap("score", "good.yaml", *ONE, "--json", "--start-pose", f"{x + 50},{y},{turn}").stdout)[0]
    assert far["attributes"]["overall"]["value"] == 0
    assert far["provenance"]["start_pose"]["sigma_m"] == 0.5


def test_poses_are_metres_and_degrees() -> None:
    assert parse_origin("1,-2.5,90") == Pose2(1, -2.5, math.pi / 2)
    start = parse_start_pose("1,2,-90,0.3,5")
    assert start is not None
    assert (start.pose, start.sigma_m, start.sigma_yaw) == (Pose2(1, 2, -math.pi / 2), 0.3, math.radians(5))
    assert parse_origin(None) is parse_start_pose(None) is None


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (ARENA, "fidmap: no map: give at least one MAP, or --points FILE (see --help)\n"),
        (("good.yaml",), "Missing option '--arena'"),
        (
            ("good.yaml", "noisy.yaml", *ARENA, "--points", "p.csv"),
            "fidmap: --points goes with at most one MAP (see --help)\n",
        ),
        (
            ("good.yaml", *ARENA, "--origin", "1,2"),
            "fidmap: --origin 1,2: expected 3 numbers separated by commas, without spaces (see --help)\n",
        ),
        (("good.yaml", *ARENA, "--start-pose", "1,2,nan"), "expected 3 or 5 numbers separated by commas"),
        (("good.yaml", *ARENA, "--start-pose", "1,2,3,0,1"), "the sigmas must be positive"),
        (("good.yaml", *ARENA, "--workers", "-1"), "--workers"),
        (("good.yaml", *ARENA, "--resolution", "x"), "--resolution"),
        (
            ("good.yaml", *ARENA, "--fail-under", "speed=0.5"),
            "fidmap: --fail-under speed=0.5: no attribute 'speed'; known are ",
        ),
        (
            ("good.yaml", *ARENA, "--fail-under", "80"),
            "fidmap: --fail-under 80: the limit must be a fraction between 0 and 1 (see --help)\n",
        ),
        (("good.yaml", *ARENA, "--fail-under", "nan"), "the limit must be a fraction between 0 and 1"),
        (("good.yaml", *ARENA, "--no-such-option"), "--no-such-option"),
    ],
)
def test_wrong_usage_is_exit_2_with_empty_stdout(words: tuple[str, ...], told: str) -> None:
    result = fidmap("score", *words)

    assert result.exit_code == 2
    assert told in result.stderr
    assert result.stdout == ""


@pytest.mark.parametrize(
    ("gates", "code", "told"),
    [
        (("0.95",), 0, ""),
        (("0.999",), 3, "is under 0.999"),
        (("coverage=1", "--fail-under", "relative_accuracy=0.9"), 0, ""),
        (("coverage=1", "--fail-under", "0.999"), 3, "is under 0.999"),
        (("short=0.9", "long=0.9"), 0, ""),
        (("long=1", "short=1"), 3, "is under 1.000"),
        (
            ("global_accuracy=0",),
            3,
            "global_accuracy is not computable (the arena's frame is relative); the gate asks for 0.000",
        ),
    ],
)
def test_gates(gates: tuple[str, ...], code: int, told: str) -> None:
    """Overall or a named attribute or class, repeated or in a row; what cannot be computed fails."""
    result = fidmap("score", "good.yaml", *ONE, "--fail-under", *gates)

    assert result.exit_code == code
    assert told in result.stderr
    assert result.stderr.count("gate failed") == (2 if gates[0] == "long=1" else code // 3)
    assert "good.yaml" in result.stdout


def test_an_unusable_map_wins_over_a_failed_gate() -> None:
    """Exit 1, and still every gate is told."""
    result = fidmap("score", "missing.yaml", "broken.yaml", "noisy.yaml", *ONE, "--fail-under", "0.98")

    assert result.exit_code == 1
    assert result.stderr.count("gate failed: ") == 2


def test_ranks_are_shown_for_several_maps_best_first() -> None:
    result = fidmap("score", "broken.yaml", "good.yaml", "noisy.yaml", *ONE)

    rows = [line.split()[:2] for line in result.stdout.splitlines()[3:6]]
    assert rows == [["1", "good.yaml"], ["2", "noisy.yaml"], ["3", "broken.yaml"]]
    assert all(len(line) <= 80 for line in result.stdout.splitlines())


def test_a_profile_file_is_taken(here: Path) -> None:
    (here / "strict.yaml").write_text("fidmap_profile: 1\nmin_opening: 0.9\n")
    document = documents(fidmap("score", "good.yaml", *ONE, "--json", "--profile", "strict.yaml").stdout)[0]

    assert document["profile"] == "strict.yaml"
    assert document["provenance"]["settings"]["min_opening"] == 0.9


def test_an_arena_is_json_too(here: Path) -> None:
    import yaml

    (here / "arena.json").write_text(json.dumps(yaml.safe_load((here / "arena.yaml").read_text())))
    result = fidmap("score", "good.yaml", "--arena", "arena.json", "--json")
    assert documents(result.stdout)[0]["attributes"]["coverage"]["value"] == 1


@pytest.mark.parametrize("name", ["a [red]b[bold].yaml", "Zürich ☃.yaml", "two\nlines.yaml", "-dash.yaml"])
def test_names_are_only_names(here: Path, name: str) -> None:
    """Brackets are no markup, a line break breaks no line, unicode stays itself."""
    (here / "good.yaml").rename(here / name)
    line = fidmap("score", *ONE, "--json", "--out", "out", "--", name)
    (document,) = documents(line.stdout)
    assert document["map"] == name
    assert line.stderr.count("\n") == 1

    table = fidmap("score", *ONE, "--", name).stdout.splitlines()
    assert len(table) == 4
    assert table[3].startswith(name.replace("\n", "\ufffd"))
    (missing,) = fidmap("score", *ONE, "--", f"no {name}").stderr.splitlines()
    assert "does not exist" in missing

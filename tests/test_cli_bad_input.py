"""Bad input, end to end: one sentence on stderr with file, fault and remedy, exit 1, nothing half-written."""

from __future__ import annotations

import os
import struct
import tracemalloc
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest

from command_line import ONE, documents, evening, fault, fidmap

READABLE = (
    "a map_server YAML, an image (PGM, PNG, BMP, JPEG, TIFF), a bag or MCAP file, a 3D map (PLY, PCD, LAS, LAZ, "
    "OctoMap), a drawing (SVG, DXF, GeoJSON) or an RTAB-Map database"
)
IMAGE = "a PGM, PNG, BMP, JPEG or TIFF image"


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return evening(tmp_path, monkeypatch)


def replaced(file: str, old: str, new: str) -> Callable[[], None]:
    def edit() -> None:
        text = Path(file).read_text(encoding="utf-8")
        assert old in text
        Path(file).write_text(text.replace(old, new), encoding="utf-8")

    return edit


def bytes_of(file: str, data: bytes) -> Callable[[], None]:
    return lambda: Path(file).write_bytes(data) and None


def huge_png() -> bytes:
    """The header of 100,000 x 100,000 cells, and no more than a few bytes behind it."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", 100_000, 100_000, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"\0" * 1000))


def truncated() -> None:
    data = Path("good.pgm").read_bytes()
    Path("good.pgm").write_bytes(data[: len(data) // 2])


MAPS: list[tuple[str, Callable[[], object], str]] = [
    ("missing image", lambda: Path("good.pgm").unlink(),
     "good.yaml names the image good.pgm, which does not exist; expected it at that path (seen from the YAML's "
     "folder), so put it there or correct `image:`"),
    ("truncated image", truncated,
     "good.yaml: its image good.pgm is truncated: 229 x 188 cells need 43052 values or bytes, 21518 are there; copy "
 "or save the map again"),
    ("wrong magic", bytes_of("good.pgm", b"P9\n1 1\n255\n\0"),
     "good.yaml: its image good.pgm is not a PGM, PNG, BMP, JPEG or TIFF image; save the map in one of these formats"),
    ("empty image", bytes_of("good.pgm", b""),
     f"good.yaml: its image good.pgm is empty (0 bytes); expected {IMAGE}, so save the map again"),
    ("too large", bytes_of("good.pgm", huge_png()),
     "good.yaml: its image good.pgm announces 100000 x 100000 cells; at most 400 million are read, so crop it or "
     "save it with larger cells"),
    ("NaN resolution", replaced("good.yaml", "resolution: 0.05", "resolution: .nan"),
     "good.yaml is not a valid map_server YAML: resolution is nan, expected metres per cell from 1e-05 to 1000; "
     "correct the file"),
    ("negative resolution", replaced("good.yaml", "resolution: 0.05", "resolution: -0.05"),
     "good.yaml is not a valid map_server YAML: resolution is -0.05, expected metres per cell from 1e-05 to 1000; "
     "correct the file"),
    ("directory", lambda: (Path("good.yaml").unlink(), Path("good.yaml").mkdir()),
     f"good.yaml is a directory; expected {READABLE}, so name the file inside it"),
    ("no YAML", bytes_of("good.yaml", b"image: [good.pgm\n"),
     "good.yaml is not valid YAML in line 2 (expected ',' or ']', but got '<stream end>'); correct that line"),
]  # fmt: skip


@pytest.mark.parametrize(("bad", "told"), [case[1:] for case in MAPS], ids=[case[0] for case in MAPS])
@pytest.mark.parametrize("command", [("score", *ONE, "--out", "out"), ("detect", "--radius", "0.3", "--out", "out")])
def test_bad_maps(bad: Callable[[], object], told: str, command: tuple[str, ...]) -> None:
    """The same sentence from every command; `--out` is not even made; no memory is taken."""
    fidmap("--version")  # imports are not what is measured
    bad()
    tracemalloc.start()
    text = fault(*command, "good.yaml")
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()

    assert text == told
    assert not Path("out").exists()
    assert peak < 50e6
    result = fidmap(*command[: command.index("--out")], "good.yaml", "--json")
    name = "detect" if command[0] == "detect" else "report"
    assert documents(result.stdout, name) == [{"map": "good.yaml", "error": {"code": "map-file", "text": text}}]
    assert result.exit_code == 1


ARENAS = [
    ("id: 1B", "id: 1A", "arena.yaml: parts[1].id: '1A' is already the id of parts[0]; groups[0] (group 1): part '1B' "
     "is not in parts"),
    ("[1A, 1B]", "[1A, 9Z]", "arena.yaml: groups[0] (group 1): part '9Z' is not in parts"),
    ("x_m: 5.4092, y_m: 4.79, ", "", "arena.yaml: parts[0] (part 1A): has no position though others have, give x_m "
     "and y_m for all parts or for none; groups[0] (group 1): part '1A' has no position, so the group needs "
     "distance_m"),
    ("radius_m: 0.3", "radius_m: -0.3", "arena.yaml: radius_m: must be greater than 0, not -0.3"),
    ("fidmap_arena: 1", "fidmap_arena: 2", "arena.yaml: fidmap_arena: must be 1, the only version so far, not 2"),
    ("frame: relative", "frame: world", "arena.yaml: frame: must be 'relative' or 'map', not 'world'"),
    ("pallet_m: 1.2", "pallet: 1.2", "arena.yaml: pallet: unknown key (did you mean pallet_m?)"),
    ("name: demo", "name: [demo", "arena.yaml: line 3: did not find expected ',' or ']'"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "told"), ARENAS)
def test_bad_arenas_are_one_sentence_and_an_empty_stdout(old: str, new: str, told: str) -> None:
    """Told once, however many maps were named; nothing is scored."""
    replaced("arena.yaml", old, new)()
    text = fault("score", "good.yaml", "noisy.yaml", *ONE, "--json", "--out", "out")
    assert text == told
    assert not Path("out").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--arena", "nope.yaml"), "nope.yaml: no such file, expected an arena file, so check the path"),
        (("--arena", "."), ".: is a directory, expected an arena file, so name the file inside it"),
        (("--arena", "good.pgm"), "good.pgm: line 4: not UTF-8 text, expected an arena file"),
        ((*ONE, "--profile", "nope"), "nope: neither a profile (continuous, ssrr2011) nor a file"),
        (
            (*ONE, "--profile", "arena.yaml"),
            "arena.yaml: is an arena file, not a profile file, so give it with --arena",
        ),
        ((*ONE, "--profile", "p.yaml"), "p.yaml: min_opening: must be at least 0.5, not 0.3"),
        ((*ONE, "--resolution", "nan"), "good.yaml cannot be read with --resolution nan; expected the side of a cell"),
        ((*ONE, "--resolution", "-1"), "good.yaml cannot be read with --resolution -1; expected the side of a cell"),
        ((*ONE, "--resolution", "0.2"), "good.yaml: a radius of 0.3 m is 1.5 cells of 0.2 m: "),
    ],
)
def test_bad_options_that_name_files_or_values(words: tuple[str, ...], told: str) -> None:
    Path("p.yaml").write_text("fidmap_profile: 1\nmin_opening: 0.3\n", encoding="utf-8")
    text = fault("score", "good.yaml", *words)
    assert text.startswith(told), text


def test_a_pipe_and_a_file_without_permission_are_refused() -> None:
    """A pipe would wait for ever."""
    os.mkfifo("pipe.yaml")
    assert fault("score", "pipe.yaml", *ONE) == (
        f"pipe.yaml is a device or a pipe; expected {READABLE}, so save it to a file first"
    )


def test_a_map_in_place_of_an_arena_and_the_other_way_round() -> None:
    """The classic slip is told as such."""
    assert fault("score", "arena.yaml", "--arena", "arena.yaml") == (
        "arena.yaml is an arena file, not a map; give it with --arena and name a map here"
    )
    assert fault("score", "good.yaml", "--arena", "good.yaml") == (
        "good.yaml: is a map_server YAML, not an arena file, so name it as a MAP"
    )

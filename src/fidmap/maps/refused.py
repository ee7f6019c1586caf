"""Files of mapping programs that are no maps, or bound to the program that wrote them: what to do instead."""

from __future__ import annotations

from pathlib import Path

from fidmap.maps.files import fault
from fidmap.maps.overrides import Overrides
from fidmap.model import Grid

BOOST_ARCHIVE = b"\x16\0\0\0\0\0\0\0serialization::archive"
PBSTREAM = 0x7B1D1F7B5BF501DB.to_bytes(8, "little")
CARMEN_LOG = (b"PARAM ", b"FLASER ", b"RLASER ", b"ROBOTLASER1 ", b"RAWLASER1 ", b"ODOM ", b"SYNC ", b"# message_name ")
ADVICE = {
    BOOST_ARCHIVE: "is a pose graph of slam_toolbox, which only the build that wrote it can read; load it there and "
    "save the map with `ros2 run nav2_map_server map_saver_cli -f NAME`",
    b"22 serialization::archive": "is a pose graph of slam_toolbox, which only the build that wrote it can read; load "
    "it there and save the map with `ros2 run nav2_map_server map_saver_cli -f NAME`",
    PBSTREAM: "is a state of Cartographer, not a map; write one with `ros2 run cartographer_ros "
    "cartographer_pbstream_to_ros_map -pbstream_filename FILE -map_filestem NAME` and name its YAML here",
    b"CARMENMAPFILE": "is a map of CARMEN; export it as an image with CARMEN's map editor and give its --resolution",
    **dict.fromkeys(
        CARMEN_LOG,
        "is a log of CARMEN, which holds scans and no map; run a mapping program on it and name the map here",
    ),
    b"\x28\xb5\x2f\xfd": "is compressed by zstd as a whole; unpack it with `zstd -d` first",
    b"\x1f\x8b": "is compressed by gzip; unpack it with `gunzip` first",
    b"BZh": "is compressed by bzip2; unpack it with `bunzip2` first",
    b"\xfd7zXZ\0": "is compressed by xz; unpack it with `unxz` first",
    b"7z\xbc\xaf\x27\x1c": "is a 7z archive; unpack it and name the map inside",
    b"%PDF": "is a PDF, which holds no cells; export the map as PNG and give its --resolution",
    b"GIF8": "is a GIF image, which is not read; save it as PNG and give its --resolution",
    b"RIFF": "is a WebP image or another RIFF file, which is not read; save the map as PNG and give its --resolution",
    b"version https://git-lfs": "is a Git LFS pointer, not the file itself; fetch it with `git lfs pull`",
    **dict.fromkeys(
        (b"<!DOCTYPE html", b"<!doctype html", b"<html"),
        "is a web page, perhaps in place of a download; download the file itself",
    ),
    b"PK\x03\x04": "is a zip archive; name the map inside as zip://MAP::ARCHIVE, or unpack it",
}


def is_refused(head: bytes) -> bool:
    """Whether a file begins like one of those."""
    return head.startswith(tuple(ADVICE))


def read(path: Path, name: str, overrides: Overrides) -> Grid:  # noqa: ARG001 - as every reader
    """Say what to do instead.

    Raises:
        MapFileError: always.
    """
    with path.open("rb") as file:
        head = file.read(64)
    raise fault(name, next(advice for begin, advice in ADVICE.items() if head.startswith(begin)))

"""Recordings of ROS 1 and ROS 2 with nav_msgs/OccupancyGrid: which map of which topic, and what it says."""

from __future__ import annotations

import hashlib
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from fidmap.maps import db3, mcap, rosbag1
from fidmap.maps.cursor import BrokenRecordError
from fidmap.maps.files import fault, printable
from fidmap.maps.occupancy_message import FREE_THRESH, OCCUPIED_THRESH, TYPES, OccupancyMessage, decode_cdr, decode_ros1
from fidmap.maps.oddities import label_oddities
from fidmap.maps.overrides import Overrides
from fidmap.maps.recording import Message, Recording, unpacked_message
from fidmap.maps.sqlite_file import MAGIC as SQLITE_MAGIC
from fidmap.model import Finding, Grid, Source

MAX_FILES = 1000
SUFFIXES = (".mcap", ".db3")


@dataclass(frozen=True)
class Found:
    """A map's message, the recording that it lies in, and its topic."""

    message: Message
    recording: Recording
    topic: str


def is_bag_folder(path: Path) -> bool:
    """Whether a folder is a ROS 2 bag: it holds metadata.yaml and recordings."""
    try:
        return (path / "metadata.yaml").is_file() and bool(_files_in(path))
    except OSError:
        return False


def _files_in(folder: Path) -> list[Path]:
    return sorted(p for p in folder.iterdir() if p.suffix in SUFFIXES and p.is_file())[:MAX_FILES]


def read(path: Path, name: str, overrides: Overrides) -> Grid:
    """Read one map of a bag: a file, or a ROS 2 bag's folder with all its files.

    Raises:
        MapFileError: no map, several topics and none chosen, or a broken file.
        BrokenRecordError: records that are not what they announce.
    """
    with ExitStack() as stack:
        recordings = [_opened(p, stack) for p in (_files_in(path) if path.is_dir() else [path])]
        topic, note = choose_topic(recordings, name, overrides.topic)
        found = _last(recordings, topic, name, overrides.time_s)
        return _grid(found, name, overrides, note)


def _opened(path: Path, stack: ExitStack) -> Recording:
    """The recording in a file, by its content."""
    file = stack.enter_context(path.open("rb"))
    magic = file.read(16)
    if magic == SQLITE_MAGIC:
        return db3.Db3Recording(path)
    return mcap.open_bag(file) if magic.startswith(mcap.MAGIC) else rosbag1.open_bag(file)


def choose_topic(recordings: list[Recording], name: str, wanted: str | None) -> tuple[str, tuple[Finding, ...]]:
    """The topic that the user wants, the only one with maps, or /map; with a note where others were left out.

    Raises:
        MapFileError: the recording has no such topic, no maps at all, or several topics and none is /map.
    """
    all_topics = {c.topic: c.type for r in recordings for c in r.channels.values()}
    topics = sorted(topic for topic, kind in all_topics.items() if kind in TYPES)
    listed = ", ".join(topics[:10]) + ", ..." * (len(topics) > 10)
    if wanted is not None:
        same = [topic for topic in topics if topic.strip("/") == wanted.strip("/")]
        if same:
            return same[0], ()
        kind = f"holds {all_topics[wanted]}, not maps" if wanted in all_topics else "is not in it"
        raise fault(name, f"cannot be read with --topic {wanted}, which {kind}; its maps are on {listed or 'no topic'}")
    if not topics:
        raise fault(name, "holds no nav_msgs/OccupancyGrid; record the topic of the map, such as /map, as well")
    if len(topics) == 1:
        return topics[0], ()
    if "/map" not in topics:
        raise fault(name, f"holds maps on {len(topics)} topics: {listed}; choose one with --topic")
    text = f"the map on /map was taken; there are others on {', '.join(t for t in topics if t != '/map')}"
    return "/map", (Finding("note", "several-topics", printable(text), "--topic NAME"),)


def _last(recordings: list[Recording], topic: str, name: str, time_s: float | None) -> Found:
    """The last map of a topic, at most `time_s` seconds after the recording began."""
    begin = min((stamp for r in recordings if (stamp := r.begin()) is not None), default=0)
    until = None if time_s is None else min(begin + round(time_s * 1e9), 2**63 - 1)
    best: Found | None = None
    for recording in recordings:
        chosen = [n for n, c in recording.channels.items() if c.topic == topic and c.type in TYPES]
        message = recording.last(chosen, until)
        if message is not None and (best is None or message.stamp > best.message.stamp):
            best = Found(message, recording, topic)
    if best is None:
        when = "" if time_s is None else f" in its first {time_s:g} s; give a later --time, or none for the last one"
        raise fault(name, f"holds no map on {topic}{when or '; record longer, until the first map is published'}")
    return best


def _grid(found: Found, name: str, overrides: Overrides, notes: tuple[Finding, ...]) -> Grid:
    encoding = found.recording.channels[found.message.channel].encoding
    if encoding not in {"ros1", "cdr"}:
        raise BrokenRecordError(f"its messages have the encoding {encoding[:20]!r}, expected cdr or ros1")
    decode = decode_ros1 if encoding == "ros1" else decode_cdr
    message = decode(unpacked_message(found.message.data))
    digest = hashlib.sha256(found.message.data).hexdigest()
    return message_grid(message, digest, name, f"bag:{found.topic}", overrides, notes)


def message_grid(
    message: OccupancyMessage,
    digest: str,
    name: str,
    kind: str,
    overrides: Overrides,
    notes: tuple[Finding, ...] = (),
) -> Grid:
    """The grid of a message: thresholds as the map savers of ROS have them, unless the user says otherwise."""
    occupancy = message.occupancy()
    free = FREE_THRESH if overrides.free_thresh is None else overrides.free_thresh
    occupied = OCCUPIED_THRESH if overrides.occupied_thresh is None else overrides.occupied_thresh
    findings = (*notes, *label_oddities(*message.labels(free, occupied)))
    source = Source(name, digest, kind, findings)
    resolution = message.resolution_m if overrides.resolution_m is None else overrides.resolution_m
    origin = overrides.corner(overrides.origin or message.origin, resolution)
    return Grid(occupancy, resolution, origin, free, occupied, None, source)

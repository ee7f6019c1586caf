"""ROS 2 bags in SQLite (`.db3`), with or without their metadata.yaml."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from fidmap.maps.cursor import BrokenRecordError
from fidmap.maps.recording import Channel, Message, Recording
from fidmap.maps.sqlite_file import opened

TABLES = frozenset({"topics", "messages"})


class Db3Recording(Recording):
    """A file that is opened for each question, so that nothing has to be closed."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with opened(path) as database:
            if not database.tables >= TABLES:
                raise BrokenRecordError("its tables are not those of a ROS 2 bag")
            rows = database.rows("SELECT id, name, type, serialization_format FROM topics")
        if not all(isinstance(row[0], int) for row in rows):
            raise BrokenRecordError("a topic has no number")
        self.channels = {row[0]: Channel(str(row[1]), str(row[2]), str(row[3])) for row in rows}

    def begin(self) -> int | None:
        """Stamp of the first message."""
        with opened(self.path) as database:
            ((stamp,),) = database.rows("SELECT min(timestamp) FROM messages")
        return stamp if isinstance(stamp, int) else None

    def last(self, channels: Collection[int], until: int | None) -> Message | None:
        """The last message of these channels that is not after `until`."""
        marks = ", ".join("?" for _ in channels)
        with opened(self.path) as database:
            rows = database.rows(
                f"SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN ({marks}) AND timestamp <= ? "  # noqa: S608 - only question marks are filled in
                "ORDER BY timestamp DESC, id DESC LIMIT 1",
                *channels,
                2**63 - 1 if until is None else until,
            )
        if not rows:
            return None
        channel, stamp, data = rows[0]
        if not (isinstance(stamp, int) and isinstance(data, bytes)):
            raise BrokenRecordError("a message has no bytes or no time")
        return Message(channel, stamp, memoryview(data))

"""SQLite files from outside: read only, plain tables only, with a bound on the work of each question.

A hostile file may define a view under the name of an expected table that never ends; views are therefore refused.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fidmap.maps.cursor import BrokenRecordError

MAGIC = b"SQLite format 3\0"
MAX_STEPS = 200_000_000
MAX_VALUE_BYTES = 512 << 20
STEPS_BETWEEN = 100_000


@contextmanager
def opened(path: Path) -> Iterator[Database]:
    """A database for reading; nothing is written beside it, not even a journal.

    Raises:
        BrokenRecordError: for whatever SQLite says against the file, here and inside the `with`.
    """
    connection = None
    try:
        # absolute() keeps symbolic links; quote marks and question marks in names are for as_uri to take care of
        connection = sqlite3.connect(path.absolute().as_uri() + "?mode=ro&immutable=1", uri=True)
        yield Database(connection)
    except (sqlite3.Error, OverflowError, UnicodeError) as error:
        raise BrokenRecordError(f"SQLite says: {error}") from None
    finally:
        if connection is not None:
            connection.close()


class Database:
    """Tables and questions about them."""

    def __init__(self, connection: sqlite3.Connection) -> None:
        self._connection = connection
        self._steps = 0
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_VALUE_BYTES)
        connection.set_progress_handler(self._tick, STEPS_BETWEEN)
        connection.execute("PRAGMA trusted_schema = OFF")
        connection.execute("PRAGMA cell_size_check = ON")
        rows = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table' AND sql LIKE 'CREATE TABLE%'")
        self.tables = frozenset(str(row[0]) for row in rows.fetchmany(1000))

    def _tick(self) -> int:
        self._steps += STEPS_BETWEEN
        return self._steps > MAX_STEPS

    def rows(self, question: str, *values: object, most: int = 10_000) -> list[tuple[Any, ...]]:
        """The answer's first rows.

        Raises:
            BrokenRecordError: more work than a map can need.
        """
        try:
            return self._connection.execute(question, values).fetchmany(most)
        except sqlite3.OperationalError as error:
            if "interrupted" in str(error):
                raise BrokenRecordError("it would take too long to search") from None
            raise

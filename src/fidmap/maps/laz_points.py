"""The child that decodes a LAZ file: X, Y and Z of every point as 32-bit integers on stdout.

python -m fidmap.maps.laz_points FILE
"""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import numpy as np

CHUNK_POINTS = 500_000
MAX_BYTES = 1 << 30
LEAST_SECONDS, MAX_SECONDS = 5, 600
SLOWEST_BYTES_PER_S = 20_000  # a fiftieth of what decoding usually does


def main(path: str) -> None:
    """Decode block by block; whatever goes wrong ends this process, and only this one."""
    limit_resources(Path(path).stat().st_size)
    with import_module("laspy").open(path) as reader:
        for block in reader.chunk_iterator(CHUNK_POINTS):
            sys.stdout.buffer.write(np.stack([block.X, block.Y, block.Z], axis=1).astype("<i4").tobytes())


def limit_resources(size: int) -> None:
    """At most 1 GiB of own memory, and time by the file's bytes, where the operating system knows such bounds.

    A kilobyte of nonsense can announce millions of points, which would be decoded for minutes.
    """
    try:
        resource = import_module("resource")
    except ImportError:  # Windows
        return
    resource.setrlimit(resource.RLIMIT_DATA, (MAX_BYTES, MAX_BYTES))
    seconds = min(MAX_SECONDS, LEAST_SECONDS + size // SLOWEST_BYTES_PER_S)
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


if __name__ == "__main__":
    main(sys.argv[1])

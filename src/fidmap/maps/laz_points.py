"""The child that decodes a LAZ file: X, Y and Z of every point as 32-bit integers on stdout.

python -m fidmap.maps.laz_points FILE
"""

from __future__ import annotations

import sys
from importlib import import_module

import numpy as np

CHUNK_POINTS = 500_000
MAX_BYTES = 1 << 30
MAX_SECONDS = 600


def main(path: str) -> None:
    """Decode block by block; whatever goes wrong ends this process, and only this one."""
    limit_resources()
    with import_module("laspy").open(path) as reader:
        for block in reader.chunk_iterator(CHUNK_POINTS):
            sys.stdout.buffer.write(np.stack([block.X, block.Y, block.Z], axis=1).astype("<i4").tobytes())


def limit_resources() -> None:
    """At most 1 GiB of own memory and ten minutes, where the operating system knows such bounds."""
    try:
        resource = import_module("resource")
    except ImportError:  # Windows
        return
    resource.setrlimit(resource.RLIMIT_DATA, (MAX_BYTES, MAX_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (MAX_SECONDS, MAX_SECONDS))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


if __name__ == "__main__":
    main(sys.argv[1])

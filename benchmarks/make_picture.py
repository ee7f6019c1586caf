"""Writes the picture of the README from the maps that come with fidmap: `./run bench make_picture [FILE]`."""

from __future__ import annotations

import contextlib
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "images" / "overlay.png"
LARGEST_BYTES = 150_000


def write_picture(target: Path) -> None:
    """The overlay that `fidmap demo` draws of its broken map."""
    target = target.resolve()
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        subprocess.run([sys.executable, "-m", "fidmap", "demo"], check=True)
        picture = Path("fidmap-demo/broken/overlay.png")
        assert picture.stat().st_size <= LARGEST_BYTES, "too large for a README"
        shutil.copyfile(picture, target)


if __name__ == "__main__":
    write_picture(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE)

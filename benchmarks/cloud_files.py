"""Point clouds and octrees for tests, fuzzing and benchmarks, written by other libraries where there is one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

Points = npt.NDArray[np.float64]


def write_ply(path: Path, points: Points, form: str = "binary_little_endian", kind: str = "float") -> Path:
    """A PLY file with a colour, a camera before and faces after the vertices, as mesh programs write them."""
    order = ">" if form == "binary_big_endian" else "<"
    number = order + {"float": "f4", "double": "f8"}[kind]
    header = (
        f"ply\nformat {form} 1.0\ncomment made for a test\nelement camera 1\nproperty float px\nproperty uchar used\n"
        f"element vertex {len(points)}\nproperty uchar red\nproperty {kind} x\nproperty {kind} y\nproperty {kind} z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    if form == "ascii":
        rows = "".join(f"7 {x!r} {y!r} {z!r}\n" for x, y, z in points.tolist())
        path.write_text(f"{header}1.5 3\n{rows}3 0 1 2\n")
        return path
    table = np.zeros(len(points), [("red", "u1"), ("x", number), ("y", number), ("z", number)])
    for k, axis in enumerate("xyz"):
        table[axis] = points[:, k]
    camera = np.array([(1.5, 3)], [("px", order + "f4"), ("used", "u1")])
    face = b"\3" + np.arange(3, dtype=order + "i4").tobytes()
    path.write_bytes(header.encode() + camera.tobytes() + table.tobytes() + face)
    return path


def write_pcd(path: Path, points: Points, encoding: str = "binary") -> Path:
    """A PCD file by pypcd4."""
    from pypcd4.pypcd4 import Encoding, PointCloud

    cloud = PointCloud.from_xyzi_points(np.column_stack([points, np.arange(len(points))]).astype(np.float32))
    cloud.save(path, encoding=Encoding[encoding.upper()])
    return path


def write_las(path: Path, points: Points) -> Path:
    """A LAS file by laspy, or LAZ by its suffix; millimetres."""
    import laspy

    header = laspy.LasHeader(version="1.4", point_format=6)
    header.offsets, header.scales = points.min(axis=0), np.full(3, 0.001)
    las = laspy.LasData(header)
    las.x, las.y, las.z = points.T
    las.write(path)
    return path


def write_octree(path: Path, occupied: Points, free: Points, side: float = 0.05) -> Path:
    """An octree by OctoMap itself, pruned; `.bt` or `.ot` by the suffix."""
    import pyoctomap

    tree = pyoctomap.OcTree(side)
    for points, hit in ((free, False), (occupied, True)):
        for point in points:
            tree.updateNode(np.asarray(point, float), hit)
    tree.updateInnerOccupancy()
    written = tree.writeBinary(str(path)) if path.suffix == ".bt" else tree.write(str(path))
    assert written
    return path

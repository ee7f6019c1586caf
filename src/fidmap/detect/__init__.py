"""TrinaryGrid + radius -> barrel parts (SSRR 2011, II-A-3)."""

from __future__ import annotations
import numpy as np
from fidmap.detect.votes import centre_candidates
from fidmap.detect.ring import RingSampler
from fidmap.detect.arcs import hypotheses, support, windows
from fidmap.grid import cells_to_metres
from fidmap.model import BarrelPart, TrinaryGrid


def find_barrel_parts(grid, radius_m):
    R = radius_m / grid.resolution_m
    c = centre_candidates(grid.labels, R)
    s = RingSampler(grid.labels, R)
    a = hypotheses(s, c)
    w = windows(a.facings, np.radians(85))
    st = support(a.ring, max(1.3, 0.15 * R))
    score = (st * w).sum(1) / w.sum(1)
    parts = np.stack(
        [
            (st * windows(a.facings + k, np.radians(22))).sum(1)
            / windows(a.facings + k, np.radians(22)).sum(1)
            for k in np.radians([-66, -33, 0, 33, 66])
        ]
    )
    parts.sort(0)
    score = 0.5 * score + 0.5 * parts[:2].mean(0)
    w2 = windows(a.facings, np.radians(70))
    inner = (a.ring.inner * w2).sum(1) / w2.sum(1)
    outer = (a.ring.outer * w2).sum(1) / w2.sum(1)
    conf = score * np.clip(1 - 1.0 * inner, 0, 1) * np.clip(0.5 + 0.5 * outer, 0, 1)
    order = np.argsort(-conf)
    keep = []
    for i in order:
        if all(
            np.hypot(*(a.centres[i] - a.centres[j])) > R * 0.7
            or abs((a.facings[i] - a.facings[j] + np.pi) % (2 * np.pi) - np.pi) > np.radians(75)
            for j in keep
        ):
            keep.append(i)
    keep = [i for i in keep if conf[i] > 0.4]
    xy = cells_to_metres(a.centres[keep], grid.resolution_m, grid.origin)
    return tuple(
        BarrelPart(n + 1, x, y, float(a.facings[i] + grid.origin.yaw), np.pi, 0.01, float(conf[i]))
        for n, (i, (x, y)) in enumerate(zip(keep, xy))
    )

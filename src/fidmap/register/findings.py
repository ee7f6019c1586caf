"""What a referee should know about a registration."""

from __future__ import annotations

import math

import numpy as np

from fidmap.geometry import apply
from fidmap.model import Arena, BarrelPart, Finding, Settings
from fidmap.register.polish import Placement

# share of the best value from which on another registration makes it ambiguous
NEARLY = 0.95
WHOLE = 2 * math.pi - 1e-9


def name_findings(
    chosen: Placement, best: Placement, parts: tuple[BarrelPart, ...], arena: Arena, settings: Settings
) -> tuple[Finding, ...]:
    """`degenerate`, `doubtful-assignment`, `nearest-placement` and `frame-mismatch`, where they apply."""
    d_max = settings.d_max("relative_accuracy", arena.radius_m)
    found = [_degenerate(chosen), _doubtful(chosen, parts, arena, d_max)]
    if arena.frame == "map":
        found += [_nearest(chosen, best), _mismatch(chosen, parts, settings, arena)]
    return tuple(f for f in found if f is not None)


def ambiguous(
    best: Placement, rival: Placement | None, parts: tuple[BarrelPart, ...], arena: Arena
) -> tuple[Finding, ...]:
    """Finding `ambiguous` when another registration is worth 95 % of the best one, and what would tell them apart."""
    if rival is None or rival.value < NEARLY * best.value:
        return ()
    remedies = [
        "a start pose (--start-pose)",
        *(["facings of the parts (facing_deg)"] if _facings_would_tell(best, parts, arena) else []),
        "an arena whose parts are laid out without symmetry",
    ]
    turn = math.degrees(math.remainder(rival.transform.rotation - best.transform.rotation, 2 * math.pi))
    return (
        Finding(
            "warning", "ambiguous",
            f"another registration, turned by {turn:+.0f} degrees against this one, is nearly as good "
            f"({rival.value:.3f} against {best.value:.3f}): which part is which is not certain; what would tell: "
            f"{', or '.join(remedies)}",
            "--start-pose X_M,Y_M,YAW_DEG",
        ),
    )  # fmt: skip


def _facings_would_tell(best: Placement, parts: tuple[BarrelPart, ...], arena: Arena) -> bool:
    """Whether a half that is assigned has no facing, in the arena or in the map; whole barrels have none to give."""
    pairs = [(arena.parts[i], parts[j]) for i, j in best.pairs]
    return any(f.opening < WHOLE and (f.facing is None or b.facing is None) for f, b in pairs)


def _degenerate(placement: Placement) -> Finding | None:
    if len(placement.pairs) > 2:
        return None
    return Finding(
        "warning", "degenerate",
        f"only {len(placement.pairs)} part(s) assigned: a transform fits so few nearly always, so relative accuracy "
        "says little",
    )  # fmt: skip


def _doubtful(placement: Placement, parts: tuple[BarrelPart, ...], arena: Arena, d_max: float) -> Finding | None:
    i, j = placement.pairs[:, 0], placement.pairs[:, 1]
    truth = np.array([(f.x_m, f.y_m) for f in arena.parts], float)
    moved = apply(placement.transform, np.array([(b.x_m, b.y_m) for b in parts], float))
    distance = np.linalg.norm(truth[i] - moved[j], axis=1)
    names = [
        f"{arena.parts[a].id} ({d:.2f} m)"
        for a, b, d in sorted(zip(i, j, distance, strict=True), key=lambda t: arena.parts[t[0]].id)
        if d > d_max / 2 and parts[b].fixed_id is None
    ]
    if not names:
        return None
    return Finding(
        "warning", "doubtful-assignment",
        f"assigned although far from the expected place: {', '.join(names)}; look at the picture and, where it is "
        "wrong, say so in the points file",
        "--points points.csv",
    )  # fmt: skip


def _nearest(chosen: Placement, best: Placement) -> Finding | None:
    if chosen is best:
        return None
    return Finding(
        "note", "nearest-placement",
        f"another placement is as good ({best.value:.3f} against {chosen.value:.3f}); the one nearest to the agreed "
        "frame was taken",
    )  # fmt: skip


def _mismatch(chosen: Placement, parts: tuple[BarrelPart, ...], settings: Settings, arena: Arena) -> Finding | None:
    d_max = settings.d_max("global_accuracy", arena.radius_m)
    own = np.array([(parts[j].x_m, parts[j].y_m) for j in chosen.pairs[:, 1]], float)
    shift = float(np.linalg.norm(apply(chosen.transform, own) - own, axis=1).max())
    if shift <= d_max:
        return None
    return Finding(
        "warning", "frame-mismatch",
        f"the best placement moves parts by up to {shift:.2f} m: the map is not in the agreed frame, so global "
        "accuracy is low for that reason alone",
    )  # fmt: skip

"""The greatest value of another registration than the best one, searched and bounded like the best."""

from __future__ import annotations

from fidmap.model import Arena, FloatArray, RunnerUp, StartPose
from fidmap.register.branch import Improve, Stop
from fidmap.register.certify import SLACK, prove
from fidmap.register.landscape import Landscape
from fidmap.register.majorant import quantum
from fidmap.register.near import Matcher
from fidmap.register.optimum import Optimum, improver, landscapes
from fidmap.register.polish import Placement
from fidmap.register.problem import Problem
from fidmap.register.rivals import Rivals, same_objects

TOLERANCE = 0.01
# boxes for the runner-up: some for every box that the best one took, and never fewer than
NODES_PER_NODE = 3
LEAST_NODES = 5_000


def find_runner_up(
    problem: Problem, arena: Arena, start: StartPose | None, optimum: Optimum, best: Placement
) -> tuple[RunnerUp, Placement | None]:
    """Value and bound of the runner-up to `best`, and its placement where one was found."""
    limit = problem.settings.long_if_walking_pallets_over
    pairs = [g.parts for g in arena.groups if len(g.parts) == 2 and g.resolved_class(limit) in {"short", "long"}]
    rivals = Rivals(problem, best, same_objects([part.id for part in arena.parts], pairs))
    found = [one for one in optimum.met if rivals.includes(one)]
    value, upper = max((one.value for one in found), default=0.0), 0.0
    most = max(LEAST_NODES, NODES_PER_NODE * optimum.nodes)
    for land, matcher in zip(*landscapes(problem, start), strict=True):
        improve = _rival_improver(land, matcher, found, rivals)
        proof = prove(land, matcher, value, improve, stop_of(land), most, rivals)
        value, upper = max(value, proof.value), max(upper, proof.upper_bound)
    best_rival = min(found, key=lambda one: one.order, default=None)
    if optimum.upper_bound is not None:
        upper = min(upper, optimum.upper_bound)
    return RunnerUp(value, max(value, upper)), best_rival


def stop_of(land: Landscape) -> Stop:
    """One percent, or short of the next value that steps allow where that is more."""
    step = (quantum(land) or SLACK) - SLACK
    return lambda value: value + max(step, TOLERANCE * value)


def _rival_improver(land: Landscape, matcher: Matcher, found: list[Placement], rivals: Rivals) -> Improve:
    """Climbs as usual; of what is reached only other placements than the best are kept."""
    met: list[Placement] = []
    climb = improver(land, matcher, met, both=True)

    def improve(placement: FloatArray) -> tuple[float, FloatArray]:
        met.clear()
        _, top = climb(placement)
        others = [one for one in met if rivals.includes(one)]
        found.extend(others)
        return max((one.value for one in others), default=0.0), top

    return improve

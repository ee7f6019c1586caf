"""How others would look for the same maximum: least squares, RANSAC, and general optimisers with Hungarian matching."""

from __future__ import annotations

import json
import math
import os
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.optimize import differential_evolution, direct, minimize

from benchmarks.peer_env import set_up
from benchmarks.register_cases import Case
from benchmarks.slam_challenge import real_data_root
from fidmap.geometry import as_complex, weighted_similarity
from fidmap.model import CONTINUOUS, Transform
from fidmap.register.problem import Problem, make_problem

Peer = Callable[[Case, Problem], float]


def value(problem: Problem, x: np.ndarray) -> float:
    """The best assignment's value at rotation, x, y of the middle of the barrel parts."""
    middle = complex(*problem.barrels.mean(axis=0))
    shift = complex(x[1], x[2]) - np.exp(1j * x[0]) * middle
    return problem.match(Transform(float(x[0]), shift.real, shift.imag))[0]


def umeyama(case: Case, problem: Problem) -> float:
    """Least squares on the true pairs, which nobody tells it in practice."""
    known = [(k, j) for j, k in enumerate(case.true_part_of) if k >= 0]
    return _fitted(problem, known) if len(known) > 1 else 0.0


def _fitted(problem: Problem, pairs: list[tuple[int, int]]) -> float:
    i, j = np.array(pairs).T
    target, source = as_complex(problem.fiducials[i]), as_complex(problem.barrels[j])
    z, t = weighted_similarity(source, target, np.ones(len(i)), (1.0, 1.0))
    return problem.match(Transform(float(np.angle(z)), t.real, t.imag))[0]


def ransac(case: Case, problem: Problem) -> float:
    """Two true pairs at a time, 200 times; those that agree within half of D are fitted by least squares."""
    random = np.random.default_rng(0)
    known = np.array([(k, j) for j, k in enumerate(case.true_part_of) if k >= 0])
    if len(known) < 2:
        return 0.0
    target, source = as_complex(problem.fiducials[known[:, 0]]), as_complex(problem.barrels[known[:, 1]])
    most = np.zeros(len(known), bool)
    for _ in range(200):
        two = random.choice(len(known), 2, replace=False)
        z, t = weighted_similarity(source[two], target[two], np.ones(2), (1.0, 1.0))
        near = np.abs(z * source + t - target) < problem.d_max / 2
        most = near if near.sum() > most.sum() else most
    return _fitted(problem, [tuple(pair) for pair in known[most].tolist()]) if most.sum() > 1 else 0.0


def nelder_mead(_case: Case, problem: Problem) -> float:
    """From 12 headings, the middles of both sets on each other; the Hungarian method inside."""
    middle = problem.fiducials.mean(axis=0)
    found = [
        minimize(lambda x: -value(problem, x), [k * math.pi / 6, *middle], method="Nelder-Mead").fun
        for k in range(12)
    ]  # fmt: skip
    return -float(min(found))


def _bounds(problem: Problem) -> list[tuple[float, float]]:
    low, high = problem.fiducials.min(axis=0) - 2, problem.fiducials.max(axis=0) + 2
    return [(-math.pi, math.pi), *((float(a), float(b)) for a, b in zip(low, high, strict=True))]


def dividing_rectangles(_case: Case, problem: Problem) -> float:
    """Scipy's DIRECT with 7,000 evaluations."""
    return -float(direct(lambda x: -value(problem, x), _bounds(problem), maxfun=7000).fun)


def evolution(_case: Case, problem: Problem) -> float:
    """Scipy's differential evolution with its defaults, seeded."""
    return -float(differential_evolution(lambda x: -value(problem, x), _bounds(problem), seed=0).fun)


PEERS: dict[str, Peer] = {
    "Umeyama on the true pairs": umeyama,
    "RANSAC on the true pairs": ransac,
    "Nelder-Mead + Hungarian, 12 headings": nelder_mead,
    "DIRECT, 7,000 evaluations": dividing_rectangles,
    "differential evolution": evolution,
}


@dataclass(frozen=True)
class Prototype:
    """Seconds that the prototype's first use takes to compile; value, upper bound and CPU seconds of every case."""

    compiling_s: float
    solved: list[tuple[float, float, float]]


def prototype(cases: Sequence[Case]) -> Prototype | None:
    """The prototype beside the checkout, certifying to 0.1 %; None where it is missing."""
    path = real_data_root().parent / "prototypes" / "registration_prototype.py"
    if not path.is_file():
        return None
    problems = [problem_of(case) for case in cases]
    rows = [{"fiducials": p.fiducials.tolist(), "barrels": p.barrels.tolist(), "d_max": p.d_max} for p in problems]
    with TemporaryDirectory() as folder:
        todo, done = Path(folder) / "problems.json", Path(folder) / "answers.json"
        todo.write_text(json.dumps(rows), encoding="utf-8")
        script = Path(__file__).with_name("prototype_peer.py")
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder, "NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        subprocess.run([set_up(), script, path, todo, done], check=True, env=environment)
        answers = json.loads(done.read_text(encoding="utf-8"))
    return Prototype(answers["compiling"], [(v, bound, seconds) for v, bound, seconds in answers["solved"]])


def problem_of(case: Case) -> Problem:
    """The continuous rigid problem of a case."""
    return make_problem(case.parts, case.arena, CONTINUOUS)

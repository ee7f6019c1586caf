"""Simulated arenas whose truth is known: surveys with errors, a mapper with habits, centres with noise."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from fidmap.attributes import attributes
from fidmap.geometry import ComplexArray
from fidmap.model import Arena, Assignment, Attributes, BarrelPart, FiducialPart, Group, Settings, Transform
from fidmap.uncertainty.population import fitted

RADIUS_M = 0.3
D_MAX = 4 * RADIUS_M
WALL_M, LONG_M = 0.05, 6.0
POLISH = 30
Random = np.random.Generator
Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Mapper:
    """A mapping program: errors that the two halves of a fiducial share and those of each half, metres per axis.

    bend_m: greatest shift of a bent map. broken: share of fiducials far from their place, by `far_m`. missed: share
    of fiducials, and again of halves, that it does not draw. offset_m: of its frame.
    """

    shared_m: float = 0.04
    own_m: float = 0.03
    bend_m: float = 0.06
    broken: float = 0.0
    far_m: float = 0.3
    missed: float = 0.05
    offset_m: float = 0.08


@dataclass(frozen=True)
class Cell:
    """What one row of the study is about."""

    parts: int
    survey_m: float
    centre_m: float


@dataclass(frozen=True, eq=False)
class Scored:
    """Scores of one simulated map: as measured (with what intervals need), and without survey and centre errors."""

    arena: Arena
    assignment: Assignment
    measured: Attributes
    true: Attributes


def noise(random: Random, sigma: float, count: int) -> ComplexArray:
    """Errors x + iy (count,), sigma per axis."""
    return np.asarray(sigma * (random.normal(size=count) + 1j * random.normal(size=count)))


def places(random: Random, count: int) -> tuple[ComplexArray, float]:
    """Fiducials at random places of a square that grows with them, their two halves one after the other.

    The halves of every second fiducial stand on either side of a wall, those of the others LONG_M apart.
    """
    side = 1.8 * math.sqrt(count)
    middles = random.uniform(0, side, count // 2) + 1j * random.uniform(0, side, count // 2)
    apart = np.where(np.arange(count // 2) % 2 == 0, WALL_M, LONG_M)
    across = apart / 2 * np.exp(2j * math.pi * random.uniform(size=count // 2))
    return np.stack([middles + across, middles - across], axis=1).ravel(), side


def drawn_by(random: Random, mapper: Mapper, truth: ComplexArray, side: float) -> tuple[ComplexArray, Flags]:
    """Where a mapper draws the parts, and which it draws at all; halves on one wall share most of their error."""
    count = len(truth)
    on_one_wall = np.repeat(np.arange(count // 2) % 2 == 0, 2)

    def shared(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return np.where(on_one_wall, np.repeat(values[::2], 2), values)

    broken = shared(random.uniform(size=count)) < mapper.broken
    error = shared(noise(random, mapper.shared_m, count)) + broken * shared(noise(random, mapper.far_m, count))
    bend = 1j * mapper.bend_m * (truth.real / side) ** 2
    missed = (shared(random.uniform(size=count)) < mapper.missed) | (random.uniform(size=count) < mapper.missed)
    return truth + mapper.offset_m + bend + error + noise(random, mapper.own_m, count), ~missed


def groups_of(count: int) -> tuple[Group, ...]:
    """One group per fiducial, short or long."""
    names = [f"{k:03d}" for k in range(count)]
    return tuple(
        Group(f"g{k}", (names[k], names[k + 1]), "short" if k % 4 == 0 else "long") for k in range(0, count, 2)
    )


def arena_of(places_xy: ComplexArray, survey_m: float) -> Arena:
    """An arena file's content; the agreed frame is the maps'."""
    parts = tuple(
        FiducialPart(f"{k:03d}", float(p.real), float(p.imag), sigma_m=survey_m) for k, p in enumerate(places_xy)
    )
    return Arena("simulated", RADIUS_M, parts, groups_of(len(parts)), frame="map")


def placed(arena: Arena, drawn: ComplexArray, seen: Flags, centre_m: float) -> tuple[
    tuple[BarrelPart, ...], Assignment
]:  # fmt: skip
    """The barrel parts and their registration, polished from the true placement with the true pairs."""
    index = np.flatnonzero(seen)
    parts = tuple(
        BarrelPart(n + 1, float(drawn[i].real), float(drawn[i].imag), sigma_m=centre_m) for n, i in enumerate(index)
    )
    target = np.array([complex(p.x_m or 0, p.y_m or 0) for p in arena.parts])[index]
    source = drawn[index]
    z, t, weight = np.ones(1, complex), np.zeros(1, complex), np.ones((1, len(index)))
    for _ in range(POLISH):
        z, t = fitted(source, target, z, t, weight, D_MAX, (1.0, 1.0))
    near = np.abs(z[0] * source + t[0] - target) < D_MAX
    barrel_of: list[int | None] = [None] * len(arena.parts)
    for n, i in enumerate(index):
        barrel_of[i] = n if near[n] else None
    move = Transform(float(np.angle(z[0])), float(t[0].real), float(t[0].imag))
    value = float((1 - np.minimum(np.abs(z[0] * source + t[0] - target), D_MAX) / D_MAX)[near].sum())
    return parts, Assignment(tuple(barrel_of), (False,) * len(barrel_of), move, value)


def scored(random: Random, cell: Cell, mapper: Mapper, settings: Settings) -> Scored:
    """One arena, surveyed and mapped once."""
    truth, side = places(random, cell.parts)
    drawn, seen = drawn_by(random, mapper, truth, side)
    return _scored(random, cell, truth, drawn, seen, settings)


def two_maps(random: Random, cell: Cell, mappers: tuple[Mapper, Mapper], settings: Settings) -> list[Scored]:
    """One arena, surveyed once and mapped by two."""
    truth, side = places(random, cell.parts)
    survey = noise(random, cell.survey_m, cell.parts)
    both = [drawn_by(random, mapper, truth, side) for mapper in mappers]
    return [_scored(random, cell, truth, drawn, seen, settings, survey) for drawn, seen in both]


def _scored(
    random: Random,
    cell: Cell,
    truth: ComplexArray,
    drawn: ComplexArray,
    seen: Flags,
    settings: Settings,
    survey: ComplexArray | None = None,
) -> Scored:
    survey = noise(random, cell.survey_m, cell.parts) if survey is None else survey
    exact, measured = arena_of(truth, 0.0), arena_of(truth + survey, cell.survey_m)
    parts, assignment = placed(measured, drawn + noise(random, cell.centre_m, cell.parts), seen, cell.centre_m)
    true_parts, true_assignment = placed(exact, drawn, seen, 0.0)
    return Scored(
        measured,
        assignment,
        attributes(parts, measured, assignment, settings),
        attributes(true_parts, exact, true_assignment, settings),
    )


def perfect(mapper: Mapper) -> Mapper:
    """A mapper that draws everything where it is."""
    return replace(mapper, shared_m=0.0, own_m=0.0, bend_m=0.0, broken=0.0, missed=0.0, offset_m=0.0)

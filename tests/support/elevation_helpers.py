"""Small road networks and surfaces of known shape for the tests of heights."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from osm2xodr.curves.cubics import cubic_slope, cubic_value
from osm2xodr.curves.plan_views import lengths
from osm2xodr.curves.records import pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import (
    ConnectorProblem,
    ProfileProblem,
    ProfileSolution,
    solve_profiles,
)
from osm2xodr.geometry.options import ElevationOptions
from osm2xodr.model import BoolArray, FloatArray, PlanView, SurfaceQuality

Height = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass
class Ground:
    """A surface of known shape, measured where `known` says so.

    `cell_size` and `sigma` may depend on the place.
    """

    height: Height
    cell_size: float = 0.0
    sigma: float = 0.0
    known: Callable[[FloatArray, FloatArray], BoolArray] | None = None
    covered: bool = False
    cells: Height | None = None
    sigmas: Height | None = None

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        return np.asarray(self.height(x, y), np.float64), self.measured(x, y)

    def measured(self, x: FloatArray, y: FloatArray) -> BoolArray:
        return np.ones(len(x), np.bool_) if self.known is None else self.known(x, y)

    def quality(self, x: FloatArray, y: FloatArray) -> SurfaceQuality:
        n = len(x)
        cell = np.full(n, self.cell_size) if self.cells is None else np.asarray(self.cells(x, y), np.float64)
        sigma = np.full(n, self.sigma) if self.sigmas is None else np.asarray(self.sigmas(x, y), np.float64)
        return SurfaceQuality(cell, sigma, np.full(n, self.covered))


@dataclass
class RoadSpec:
    """A straight or circular road, its ends and its spans (s, structure, layer)."""

    x: float
    y: float
    hdg: float
    length: float
    curvature: float = 0.0
    start: int = -1
    end: int = -1
    start_link: int = -1
    end_link: int = -1
    spans: Sequence[tuple[float, int, int]] = ((0.0, 0, 0),)
    highway: str = "residential"
    grade: float = np.nan
    oneway: int = 0
    name: int = -1


def straight(a: tuple[float, float], b: tuple[float, float], **more: object) -> RoadSpec:
    """Return the straight road from a to b."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    return RoadSpec(a[0], a[1], float(np.arctan2(dy, dx)), float(np.hypot(dx, dy)), **more)  # type: ignore[arg-type]


def plan_view(roads: Sequence[RoadSpec]) -> PlanView:
    """Return one record per road."""
    n = len(roads)
    return PlanView(
        np.arange(n + 1, dtype=np.int64),
        np.zeros(n),
        np.array([r.x for r in roads], np.float64),
        np.array([r.y for r in roads], np.float64),
        np.array([r.hdg for r in roads], np.float64),
        np.array([r.length for r in roads], np.float64),
        np.array([r.curvature for r in roads], np.float64),
    )


def make_problem(roads: Sequence[RoadSpec], junctions: Sequence[tuple[float, float]] = ()) -> ProfileProblem:
    """Return the problem that the roads pose."""
    spans = [(k, *span) for k, road in enumerate(roads) for span in road.spans]
    owner = np.array([span[0] for span in spans], np.int64)
    return ProfileProblem(
        plan_view=plan_view(roads),
        end_junction=np.array([(r.start, r.end) for r in roads], np.int64).reshape(-1, 2),
        end_link=np.array([(r.start_link, r.end_link) for r in roads], np.int64).reshape(-1, 2),
        junction_xy=np.array(junctions, np.float64).reshape(-1, 2),
        span_start=np.searchsorted(owner, np.arange(len(roads) + 1)).astype(np.int64),
        span_s=np.array([span[1] for span in spans], np.float64),
        span_structure=np.array([span[2] for span in spans], np.int64),
        span_layer=np.array([span[3] for span in spans], np.int64),
        span_highway=tuple(roads[k].highway for k in owner),
        span_grade=np.array([roads[k].grade for k in owner], np.float64),
        span_way=100 + np.arange(len(spans), dtype=np.int64),
        span_name=np.array([roads[k].name for k in owner], np.int64),
        span_oneway=np.array([roads[k].oneway for k in owner], np.int64),
    )


def connector_between(
    a: tuple[float, float], b: tuple[float, float], ends: tuple[int, int], half_width: float = 1.75
) -> ConnectorProblem:
    """Return the problem of one straight connecting road from a to b, between two road ends of junction 0."""
    zero = np.zeros(1)
    one, other = (np.array([end], np.int64) for end in ends)
    plan = plan_view([straight(a, b)])
    return ConnectorProblem(plan, np.zeros(1, np.int64), one, other, zero, zero, np.array([half_width]))


@dataclass
class Solved:
    """A solution and how to look at it."""

    problem: ProfileProblem
    solution: ProfileSolution
    diagnostics: Diagnostics = field(default_factory=Diagnostics)

    def z(self, road: int, s: float | FloatArray) -> FloatArray:
        at = np.atleast_1d(np.asarray(s, np.float64))
        return cubic_value(self.solution.elevation, np.full(len(at), road), at)

    def grade(self, road: int, s: float | FloatArray) -> FloatArray:
        at = np.atleast_1d(np.asarray(s, np.float64))
        return cubic_slope(self.solution.elevation, np.full(len(at), road), at)

    def along(self, road: int, step: float = 1.0) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return s, x, y and z along a road."""
        length = float(lengths(self.problem.plan_view)[road])
        s = np.linspace(0.0, length, max(2, int(length / step) + 1))
        x, y, _ = pose(self.problem.plan_view, np.full(len(s), road), s)
        return s, x, y, self.z(road, s)

    def codes(self) -> set[str]:
        return {item.code for item in self.diagnostics}


def solve(
    roads: Sequence[RoadSpec],
    ground: Ground,
    junctions: Sequence[tuple[float, float]] = (),
    options: ElevationOptions | None = None,
    connectors: Callable[[ProfileProblem], ConnectorProblem] | None = None,
    warped: bool = False,
) -> Solved:
    """Solve for the heights of the roads, with connecting roads through all junctions, whose arms may be warped."""
    problem = make_problem(roads, junctions)
    if connectors is not None:
        problem = replace(problem, connectors=connectors(problem))
    if warped:
        problem = replace(problem, warped=np.ones(len(problem.junction_xy), bool))
    diagnostics = Diagnostics()
    return Solved(problem, solve_profiles(problem, ground, diagnostics, options), diagnostics)


def cross(size: float = 200.0, trim: float = 8.0, angle: float = 0.3) -> list[RoadSpec]:
    """Return four roads toward junction 0 at the origin; the first two lead to it, the others away from it."""
    roads = []
    for k in range(4):
        u = np.array([np.cos(angle + k * np.pi / 2), np.sin(angle + k * np.pi / 2)])
        far, near = tuple(size * u), tuple(trim * u)
        roads.append(straight(far, near, end=0) if k < 2 else straight(near, far, start=0))
    return roads


def in_cells(x: FloatArray, cell: float, seed: int, sigma: float) -> FloatArray:
    """Return noise of independent cells along x, interpolated between their centres."""
    nodes = sigma * np.random.default_rng(seed).standard_normal(4000)
    return np.interp(x / cell, np.arange(-2000.0, 2000.0), nodes)

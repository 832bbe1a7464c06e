"""Heights where roads are cut at the borders between areas, the same for both areas.

The height that a solve finds at one place depends on all its data: two areas see different noise and different roads,
and their heights would differ by decimetres. So both areas solve the same small problem first, the roads along their
common border, and pin their roads to its heights where they are cut. Areas that are laid out together, as a block,
share one solve, and need this at the borders of the block alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final, TypeAlias

import numpy as np

from osm2xodr.curves import (
    cubic_slope,
    cubic_value,
    distance_to_outline,
    owners,
    places_along,
    pose,
    sorted_unique,
    unique_rows,
)
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import CoverageError
from osm2xodr.geometry.heights import (
    Pins,
    ProfileProblem,
    chosen_roads,
    ground_around,
    solve_profiles,
)
from osm2xodr.geometry.options import ElevationOptions
from osm2xodr.model import Borders, FloatArray, IntArray, Partition, Surface
from osm2xodr.system import record

# Heights where roads are cut follow from the roads that come this near to both areas, m. Data farther off than the
# length over which a road bends (some 100 m on coarse elevation models, `ROAD_FLEXIBILITY`) hardly move them.
_BORDER_HEIGHT_REACH: Final = 270.0
# Roads are sampled this densely for their distance from areas, m.
_REACH_SAMPLES_EVERY: Final = 20.0
# Origin of the lattice of ground windows, the same for all areas of a partition: estimates depend on it.
COMMON_ORIGIN: Final = (0.0, 0.0)

SurfaceAround: TypeAlias = Callable[[FloatArray, FloatArray], Surface]
# Road, x and y of samples along roads, local, m, all (n,).
_Points: TypeAlias = tuple[IntArray, FloatArray, FloatArray]


@record
class Neighbourhood:
    """Areas side by side, and their common ground."""

    partition: Partition  # The areas
    # Makes the surface around points x, y, (n,), local, m, from nothing but the data there
    surface_around: SurfaceAround


def with_border_heights(
    problem: ProfileProblem,
    borders: Borders,
    surface_around: SurfaceAround,
    options: ElevationOptions | None,
    diagnostics: Diagnostics,
) -> ProfileProblem:
    """Return the problem with roads pinned to common heights where the own area ends and a neighbour begins.

    The problem is that of the area, or of the block that it is laid out with, and its surroundings. `surface_around`
    is that of `Neighbourhood`; `diagnostics` gets a note for each border that no elevation model reaches.
    """
    together = np.array(borders.partition.together())
    road = owners(borders.piece_start)
    cut = np.flatnonzero(road[1:] == road[:-1]) + 1
    before, after = borders.piece_area[cut - 1], borders.piece_area[cut]
    own_first = np.isin(before, together)
    ours = (own_first != np.isin(after, together)) & (before >= 0) & (after >= 0)
    pair = np.column_stack([np.where(own_first, before, after), np.where(own_first, after, before)])[ours]
    cut = cut[ours]
    sampled, s = places_along(problem.plan_view, _REACH_SAMPLES_EVERY)
    points = sampled, *pose(problem.plan_view, sampled, s)[:2]
    found: list[tuple[IntArray, FloatArray, FloatArray]] = []
    for own, area in unique_rows(pair).values.tolist():
        here = cut[(pair == (own, area)).all(axis=1)]
        near = np.union1d(_roads_near(points, borders.partition, sorted((own, area))), road[here])
        heights = _heights(problem, near, points, road[here], borders.piece_s[here], surface_around, options)
        if heights is None:
            name = borders.partition.names[area]
            diagnostics.note("border-heights", "", f"no elevation model reaches the border with {name}")
            continue
        found.append((here, *heights))
    if not found:
        return problem
    at = np.concatenate([item[0] for item in found])
    order = np.argsort(at)
    z, grade = (np.concatenate([item[k] for item in found])[order] for k in (1, 2))
    return replace(problem, pins=Pins(road[at][order], borders.piece_s[at][order], z, grade))


def _roads_near(points: _Points, partition: Partition, areas: list[int]) -> IntArray:
    """Return the roads that come within `_BORDER_HEIGHT_REACH` of both areas, ascending."""
    road, x, y = points
    near, reach = np.arange(len(road)), _BORDER_HEIGHT_REACH
    for area in areas:
        near = near[distance_to_outline(partition.outlines[area], x[near], y[near], reach) <= reach]
    return sorted_unique(road[near])


def _heights(
    problem: ProfileProblem,
    near: IntArray,
    points: _Points,
    road: IntArray,
    s: FloatArray,
    surface_around: SurfaceAround,
    options: ElevationOptions | None,
) -> tuple[FloatArray, FloatArray] | None:
    """Return heights and grades at places (n,) of roads, solved for roads near them alone; None without heights.

    Nothing here may depend on which of the two areas asks.
    """
    index = np.searchsorted(near, road)
    unknown = np.full(len(road), np.nan)
    # Both areas know the same roads near their border, but not the same junctions.
    part = chosen_roads(replace(problem, connectors=None, carried=None), near)
    alone = replace(part, pins=Pins(index, s, unknown, unknown))
    x, y = (column[np.isin(points[0], near)] for column in points[1:])
    try:
        surface = surface_around(x, y)
    except CoverageError:
        return None
    ground = ground_around(surface, x, y, options, COMMON_ORIGIN)
    solution = solve_profiles(alone, surface, Diagnostics(), options, ground)
    return cubic_value(solution.elevation, index, s), cubic_slope(solution.elevation, index, s)

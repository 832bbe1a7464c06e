"""What the elevation solve is asked and what it answers, as flat arrays over the whole network."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from osm2xodr.curves import find_record
from osm2xodr.defaults import GRADE_LIMIT
from osm2xodr.model import BoolArray, CubicProfile, ElevationReport, FloatArray, IntArray, PlanView


@dataclass(frozen=True, slots=True, eq=False)
class Pins:
    """Places at which profiles have knots for certain, and what roads are held to there.

    Parameters
    ----------
    road, s : (P,)
        Road and place along it, m.
    z, grade : (P,)
        Height, m, and rise per metre along +s; NaN for none.
    """

    road: IntArray
    s: FloatArray
    z: FloatArray
    grade: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class ProfileProblem:
    """Roads outside junctions whose heights are wanted.

    R roads, J junctions, K spans (pieces of roads with the same attributes). A road end is named by one number,
    2 * road + (0 for its start, 1 for its end).

    Parameters
    ----------
    plan_view
        Reference lines of the R roads, already trimmed at junctions.
    end_junction : (R, 2)
        Junction at each road's start and end, -1 where there is none.
    end_link : (R, 2)
        The road end that each road end touches directly, -1 where there is none. Symmetric.
    junction_xy : (J, 2)
        Origin of each junction, local x, y, m.
    span_start : (R + 1,)
        Index of each road's first span; every road has at least one.
    span_s : (K,)
        Where each span starts along its road, m; it holds to the next one or to the road's end.
    span_structure, span_layer : (K,)
        `Structure` values and OSM's ``layer``.
    span_highway
        K values of OSM's ``highway``.
    span_grade : (K,)
        Rise per metre along +s that OSM's ``incline`` gives, NaN where it gives none.
    span_way : (K,)
        OSM way ids, for reports.
    span_name : (K,), optional
        Equal numbers for equal names or refs, -1 for none; carriageways of one street are found by it.
    span_oneway : (K,), optional
        1 where traffic runs along +s only, -1 against it only, 0 both ways.
    span_width : (K,), optional
        Width of the carriageway, m.
    span_middle : (K,), optional
        t of the carriageway's middle, m; 0 where not given.
    ele_road, ele_s, ele_z : (M,), optional
        Heights that OSM's ``ele`` gives: road, place along it and height, m.
    road_id : (R,), optional
        Ids of the roads, for reports; their index where not given.
    pins
        Where profiles have knots for certain.
    """

    plan_view: PlanView
    end_junction: IntArray
    end_link: IntArray
    junction_xy: FloatArray
    span_start: IntArray
    span_s: FloatArray
    span_structure: IntArray
    span_layer: IntArray
    span_highway: tuple[str, ...]
    span_grade: FloatArray
    span_way: IntArray
    span_name: IntArray | None = None
    span_oneway: IntArray | None = None
    span_width: FloatArray | None = None
    span_middle: FloatArray | None = None
    ele_road: IntArray | None = None
    ele_s: FloatArray | None = None
    ele_z: FloatArray | None = None
    road_id: IntArray | None = None
    pins: Pins | None = None


@dataclass(frozen=True, slots=True)
class ElevationOptions:
    """What a user may choose about heights.

    Parameters
    ----------
    smoothing
        Factor on the length over which heights are smoothed; 1 is what the elevation model itself calls for.
    grade_limit
        Largest grade by OSM's ``highway`` value, rise per metre.
    structures
        Whether bridges and tunnels leave the ground, and roads of different layers keep clear of each other.
    superelevation
        Whether motorways and trunk roads get the cross slope that an elevation model of the ground with cells of 2 m
        and less shows.
    """

    smoothing: float = 1.0
    grade_limit: Mapping[str, float] = field(default_factory=lambda: GRADE_LIMIT)
    structures: bool = True
    superelevation: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class ProfileSolution:
    """Heights of roads and junctions.

    Parameters
    ----------
    elevation
        R curves over the roads' s, m; value and slope are continuous along every road and across every link.
    junction_plane : (J, 3)
        Height and gradient (x, y) of each junction's plane about its origin, m and rise per metre. Every road
        that ends at the junction ends on the plane and runs along it there.
    end_z, end_grade : (R, 2)
        Height, m, and grade along +s at each road's start and end.
    statistics
        Figures about the solution, for reports.
    report
        The same, place by place; None on a level world.
    superelevation
        R curves, rad, 0 with slope 0 at junctions; None where it was not asked for.
    """

    elevation: CubicProfile
    junction_plane: FloatArray
    end_z: FloatArray
    end_grade: FloatArray
    statistics: Mapping[str, float] = field(default_factory=dict)
    report: ElevationReport | None = None
    superelevation: CubicProfile | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ConnectorProblem:
    """Connecting roads whose heights are wanted.

    Parameters
    ----------
    plan_view
        Reference lines of the C connecting roads; they run along the middle of what is driven on.
    junction : (C,)
        Junction that each belongs to.
    start_end, end_end : (C,)
        Road end (2 * road + 0 | 1) that each touches with its start and with its end.
    start_t, end_t : (C,)
        Where the connecting road's reference line touches, t in the touched road's own frame, m.
    half_width : (C,)
        Half the width of what is driven on, m.
    beside : (C,), optional
        Those that lie beside what is driven on and follow its surface.
    """

    plan_view: PlanView
    junction: IntArray
    start_end: IntArray
    end_end: IntArray
    start_t: FloatArray
    end_t: FloatArray
    half_width: FloatArray
    beside: BoolArray | None = None


def span_at(problem: ProfileProblem, road: IntArray, s: FloatArray) -> IntArray:
    """Return the index of the span that holds at s of roads, both (n,)."""
    return find_record(problem.span_start, problem.span_s, road, s)


def span_roads(problem: ProfileProblem) -> IntArray:
    """Return the road of each span, (K,)."""
    counts = np.diff(problem.span_start)
    return np.repeat(np.arange(len(counts), dtype=np.int64), counts)

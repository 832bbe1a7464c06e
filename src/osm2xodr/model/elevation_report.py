"""How the heights of a road network came out, place by place: what geometry tells whoever writes reports."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RoadPlace:
    """A place on a road, and how far something is from what it should be there.

    Parameters
    ----------
    road
        OpenDRIVE id.
    osm_way_id
        The way that holds there.
    s
        m.
    value, wanted
        What is found, and what should be: m or rise per metre.
    """

    road: int
    osm_way_id: int
    s: float
    value: float
    wanted: float


@dataclass(frozen=True, slots=True)
class LayerCrossing:
    """A place where one road passes over another.

    Parameters
    ----------
    upper, lower
        OpenDRIVE ids of the roads.
    upper_way, lower_way
        OSM ways.
    clearance, wanted
        Height from road to road that was found, and that there should be, m.
    """

    upper: int
    lower: int
    upper_way: int
    lower_way: int
    clearance: float
    wanted: float


@dataclass(frozen=True, slots=True)
class StructureRecord:
    """A bridge or tunnel: one chain of bridge or tunnel ways without a junction in between.

    Parameters
    ----------
    kind
        ``bridge`` or ``tunnel``.
    osm_way_ids, roads
        The ways and OpenDRIVE roads that it consists of.
    length
        m.
    above_ground
        Height above the elevation model where it is largest (in a tunnel: where it is lowest, negative), m; None
        where nothing is measured.
    clearance, crossed_way
        Least height, m, from road to road where it crosses another one, and that OSM way; None where it crosses none.
    grade, grade_limit
        Largest grade on it, and the limit of its class, rise per metre.
    """

    kind: str
    osm_way_ids: tuple[int, ...]
    roads: tuple[int, ...]
    length: float
    above_ground: float | None
    clearance: float | None
    crossed_way: int | None
    grade: float
    grade_limit: float


@dataclass(frozen=True, slots=True)
class ElevationReport:
    """How the heights of a road network came out.

    Parameters
    ----------
    measured_share
        Share of the roads' length where the elevation model has heights.
    bias, rms, p95
        Height of roads on the ground above the elevation model: mean, root of the mean square and 95th percentile of
        its magnitude, m.
    farthest
        The roads that lie farthest from the elevation model: height above it, wanted 0; the worst first.
    steep
        Roads that are steeper than their class's limit, at their steepest place; the worst first.
    structures
        All bridges and tunnels, in order of their first OSM way.
    tight
        Crossings whose clearance is not met, the worst first.
    """

    measured_share: float
    bias: float
    rms: float
    p95: float
    farthest: tuple[RoadPlace, ...]
    steep: tuple[RoadPlace, ...]
    structures: tuple[StructureRecord, ...]
    tight: tuple[LayerCrossing, ...]

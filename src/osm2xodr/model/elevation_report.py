"""Report on the heights of a road network, place by place, as geometry hands it on."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RoadPlace:
    """A place on a road where something is not as it should be."""

    road: int  # OpenDRIVE id
    osm_way_id: int  # The way that holds there
    s: float  # m
    # Found and wanted value, m or rise per metre
    value: float
    wanted: float


@dataclass(frozen=True, slots=True)
class LayerCrossing:
    """A place where one road passes over another."""

    # OpenDRIVE ids of the roads
    upper: int
    lower: int
    # OSM ways
    upper_way: int
    lower_way: int
    # Found and wanted height from road to road, m
    clearance: float
    wanted: float


@dataclass(frozen=True, slots=True)
class StructureRecord:
    """A bridge or tunnel: one chain of bridge or tunnel ways without a junction in between."""

    kind: str  # ``bridge`` or ``tunnel``
    # The ways and OpenDRIVE roads that it consists of
    osm_way_ids: tuple[int, ...]
    roads: tuple[int, ...]
    length: float  # m
    # Largest height above the elevation model (in a tunnel: the lowest, negative), m; None where nothing is measured
    above_ground: float | None
    # Least height, m, from road to road where it crosses another one, and that OSM way; None where it crosses none
    clearance: float | None
    crossed_way: int | None
    # Largest grade on it, and the limit of its class, rise per metre
    grade: float
    grade_limit: float


@dataclass(frozen=True, slots=True)
class ElevationReport:
    """The heights of a road network against the elevation model and the limits."""

    measured_share: float  # Share of the roads' length where the elevation model has heights
    # Height of roads on the ground above the elevation model: mean, root of the mean square and 95th percentile of
    # its magnitude, m.
    bias: float
    rms: float
    p95: float
    # The roads that lie farthest from the elevation model: height above it, wanted 0; the worst first
    farthest: tuple[RoadPlace, ...]
    # Roads that are steeper than their class's limit, at their steepest place; the worst first
    steep: tuple[RoadPlace, ...]
    structures: tuple[StructureRecord, ...]  # All bridges and tunnels, in order of their first OSM way
    tight: tuple[LayerCrossing, ...]  # Crossings whose clearance is not met, the worst first

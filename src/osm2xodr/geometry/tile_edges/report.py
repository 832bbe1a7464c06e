"""The elevation report and the statistics of an area without its surroundings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import PointTree, lengths, owners, pose
from osm2xodr.geometry.heights import tolerated_grade
from osm2xodr.geometry.tile_edges.pieces import Pieces
from osm2xodr.model import (
    BoolArray,
    CubicProfile,
    ElevationReport,
    FloatArray,
    LaneType,
    LayerCrossing,
    PlanView,
    Road,
    RoadMap,
    RoadPlace,
)

# Roads that cross on two levels are sampled this densely to find the crossing, m.
_CROSSING_SAMPLES_EVERY: Final = 2.0
# Grades exceed a limit only beyond this, rise per metre: rounding of cubics.
_GRADE_TOLERANCE: Final = 0.002


def kept_report(road_map: RoadMap, pieces: Pieces) -> ElevationReport | None:
    """Return the elevation report of the own area; a structure is kept if any piece of its roads is.

    Average distances from the elevation model include the surroundings, whose heights were found with the area's.
    """
    report = road_map.elevation_report
    if report is None:
        return None
    structures = [
        replace(item, roads=tuple(piece.id for road in item.roads for piece in pieces.of(road) if piece.id))
        for item in report.structures
    ]
    return replace(
        report,
        farthest=_places(report.farthest, pieces),
        steep=_places(report.steep, pieces),
        structures=tuple(item for item in structures if item.roads),
        tight=tuple(item for item in (_crossing(one, road_map, pieces) for one in report.tight) if item is not None),
    )


def default_speed_km(roads: Sequence[Road], length: FloatArray) -> float:
    """Return the length of roads, (roads,) m each, on which a limit had to be guessed, km."""
    return float(length[np.array(["speed" in road.guesses for road in roads], np.bool_)].sum()) / 1000


def kept_statistics(road_map: RoadMap, whole: Mapping[str, float]) -> dict[str, float]:
    """Return the statistics of an area from those of the area and its surroundings (`whole`), in the same order.

    What `road_map`, cut off already, lets count is counted again; else only figures about heights as a whole are
    kept.
    """
    length = lengths(road_map.plan_view)
    inside = np.array([road.junction is not None for road in road_map.roads], np.bool_)
    walked = np.array([road.junction is not None and _is_for_people(road) for road in road_map.roads], np.bool_)
    report = road_map.elevation_report
    counted: dict[str, float] = {
        "road_km": float(length[~inside].sum()) / 1000,
        "connecting_road_km": float(length[inside & ~walked].sum()) / 1000,
        "default_speed_km": default_speed_km(road_map.roads, length),
        "grade_max": _steepest(road_map.elevation, length, ~inside),
        "priorities": float(sum(len(junction.priorities) for junction in road_map.junctions)),
    }
    if report is not None:
        counted["layer_crossings_too_close"] = float(len(report.tight))
        counted["structures"] = float(len(report.structures))
        counted["structures_too_steep"] = float(
            sum(item.grade > tolerated_grade(item.grade_limit) for item in report.structures)
        )
    kept = [name for name in whole if name in counted or name.startswith("height_")]
    return {name: counted.get(name, whole[name]) for name in kept}


def _is_for_people(road: Road) -> bool:
    """Say whether a connecting road is for people on foot: whether one of its lanes is a sidewalk that leads on."""
    lanes = road.lane_sections[-1].lanes
    return any(lane.type is LaneType.SIDEWALK and lane.successor is not None for lane in lanes)


def _steepest(profile: CubicProfile, length: FloatArray, wanted: BoolArray) -> float:
    """Return the largest magnitude of the slope of some curves, (curves,)."""
    owner = owners(profile.start)
    last = np.append(owner[1:] != owner[:-1], True)
    span = np.where(last, length[owner], np.append(profile.s[1:], 0.0)) - profile.s
    # The slope is a parabola; where its vertex lies within the record it may be largest.
    with np.errstate(divide="ignore", invalid="ignore"):
        vertex = np.nan_to_num(-profile.c / (3 * profile.d), nan=0.0, posinf=0.0, neginf=0.0)
    u = np.stack([np.zeros_like(span), span, np.clip(vertex, 0.0, span)])[:, wanted[owner]]
    b, c, d = (column[wanted[owner]] for column in (profile.b, profile.c, profile.d))
    return float(np.abs(b + u * (2 * c + 3 * u * d)).max(initial=0.0))


def _places(places: tuple[RoadPlace, ...], pieces: Pieces) -> tuple[RoadPlace, ...]:
    found = ((place, pieces.at(place.road, place.s)) for place in places)
    return tuple(replace(place, road=piece.id, s=place.s - piece.begin) for place, piece in found if piece.id)


def _crossing(item: LayerCrossing, road_map: RoadMap, pieces: Pieces) -> LayerCrossing | None:
    """Return a crossing with the pieces that cross, None if either is another area's."""
    upper, lower = pieces.of(item.upper), pieces.of(item.lower)
    s = _nearest(road_map.plan_view, upper[0].curve, lower[0].curve) if len(upper) + len(lower) > 2 else (0.0, 0.0)
    above, below = pieces.at(item.upper, s[0]), pieces.at(item.lower, s[1])
    return replace(item, upper=above.id, lower=below.id) if above.id and below.id else None


def _nearest(plan: PlanView, one: int, other: int) -> tuple[float, float]:
    """Return where two curves are closest to each other, s on both, m."""
    length = lengths(plan)
    along = [np.linspace(0.0, length[k], int(length[k] / _CROSSING_SAMPLES_EVERY) + 2) for k in (one, other)]
    here, there = (
        np.column_stack(pose(plan, np.full(len(s), k, np.int64), s)[:2])
        for k, s in zip((one, other), along, strict=True)
    )
    distance, index = PointTree(there).nearest(here)
    k = int(np.argmin(distance))
    return float(along[0][k]), float(along[1][index[k]])

"""Cut off the surroundings of an area, so that it fits together with the areas beside it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from osm2xodr.curves import cubic_value, cut_curves, lengths, part_of_profile, pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.borders.furniture import kept_furniture
from osm2xodr.geometry.borders.pieces import Piece, Pieces
from osm2xodr.geometry.borders.report import kept_report, kept_statistics
from osm2xodr.geometry.borders.roads import kept_junctions, kept_roads, link_beyond
from osm2xodr.model import BorderEnd, Borders, CubicProfile, Partition, RoadMap


def keep_own_area(road_map: RoadMap, diagnostics: Diagnostics, own: int | None = None) -> RoadMap:
    """Return the area that a conversion is for, without its surroundings.

    Each piece of a road that belongs to it becomes a road, without a link where its area ends. Lines, arcs and cubics
    keep their values, so the halves of a road that is cut between two areas meet, up to rounding. Roads, connecting
    roads and junctions get ids from the area's first id on, in this order; so do signals and objects; so do
    controllers.

    Parameters
    ----------
    road_map
        Areas and their surroundings, with `RoadMap.borders` and all furniture. One without borders is returned as is.
    diagnostics
        Receives what had to be changed.
    own
        Index of the area, where it is another one than that of the partition: one of the same block.

    Raises
    ------
    InputError
        If no road belongs to the area, or it has more roads, junctions, signals and objects than ids for them.
    """
    if road_map.borders is None:
        return road_map
    borders = road_map.borders
    if own is not None:
        borders = replace(borders, partition=replace(borders.partition, own=own))
    pieces = Pieces(road_map, borders)
    cut = _cut(road_map, pieces, diagnostics)
    ends = _border_ends(road_map, cut, pieces)
    return replace(cut, statistics=kept_statistics(cut, road_map.statistics), border_ends=ends)


def cut_at_names(road_map: RoadMap, diagnostics: Diagnostics) -> RoadMap:
    """Return an area by itself with its roads cut where their names change; lines and cubics keep their values."""
    outside = sum(road.junction is None for road in road_map.roads)
    if not any(road.names for road in road_map.roads[:outside]):
        return road_map
    nothing = np.zeros(outside, np.int64)
    borders = Borders(
        Partition(road_map.frame, ("",), (), (1,), 0),
        *(np.arange(outside + 1), np.zeros(outside), nothing, np.zeros(len(road_map.junctions), np.int64)),
    )
    return _cut(road_map, Pieces(road_map, borders), diagnostics)


def _cut(road_map: RoadMap, pieces: Pieces, diagnostics: Diagnostics) -> RoadMap:
    """Return the pieces of the own area as a road map."""
    begin, end = np.array([(piece.begin, piece.end) for piece in pieces.kept]).T.copy()
    curve = np.array([piece.curve for piece in pieces.kept], np.int64)

    def part(profile: CubicProfile) -> CubicProfile:
        return part_of_profile(profile, curve, begin, end)

    return replace(
        road_map,
        roads=kept_roads(road_map, pieces),
        junctions=kept_junctions(road_map, pieces),
        plan_view=cut_curves(road_map.plan_view, begin, end, curve),
        elevation=part(road_map.elevation),
        superelevation=part(road_map.superelevation),
        lane_offset=part(road_map.lane_offset),
        elevation_report=kept_report(road_map, pieces),
        places=None,
        furniture=kept_furniture(road_map.furniture, pieces, diagnostics),
        borders=None,
    )


def _border_ends(road_map: RoadMap, cut: RoadMap, pieces: Pieces) -> tuple[BorderEnd, ...]:
    """Return where the roads of the own area continue in others, in the order of roads."""
    found: list[tuple[int, bool, int]] = []
    for k, piece in enumerate(pieces.kept):
        for at_start in (True, False):
            area = _beyond(road_map, piece, pieces, at_start=at_start)
            if area is not None:
                found.append((k, at_start, area))
    row = np.array([k for k, _, _ in found], np.int64)
    s = np.where([at_start for _, at_start, _ in found], 0.0, lengths(cut.plan_view, row))
    along_x, along_y, along_hdg = pose(cut.plan_view, row, s)
    columns = (along_x, along_y, cubic_value(cut.elevation, row, s), along_hdg)
    places = zip(*(column.tolist() for column in columns), strict=True)
    names = pieces.partition.names
    return tuple(
        BorderEnd(cut.roads[k].id, at_start, names[area] if area >= 0 else "", x, y, z, hdg, cut.roads[k].osm_way_ids)
        for (k, at_start, area), (x, y, z, hdg) in zip(found, places, strict=True)
    )


def _beyond(road_map: RoadMap, piece: Piece, pieces: Pieces, *, at_start: bool) -> int | None:
    """Return the area in which a piece continues at one of its ends, None where it does not leave the own one."""
    other = pieces.beside(piece, at_start=at_start)
    if other is not None:
        # Where its name changes, a road goes on in its own area.
        return None if other.id else other.area
    road = road_map.roads[piece.curve]
    link = road.predecessor if at_start else road.successor
    if link is None or link.to_junction or link_beyond(road, piece, pieces, at_start=at_start) is not None:
        return None
    return pieces.touched(link).area

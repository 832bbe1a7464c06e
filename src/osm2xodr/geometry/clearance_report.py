"""Carriageways that come too close above each other in the finished road map, found as `check` finds them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import (
    CLEARANCE_STEP,
    ClosePlaces,
    RoadGraph,
    Stations,
    Table,
    close_places,
    cosine_sine,
    cubic_value,
    find_record,
    hypot,
    join_tables,
    lengths,
    pose,
    profile_of,
    ranks,
    segments_cross,
    starts,
)
from osm2xodr.defaults import CLEARANCE_LEAST
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import ProfileProblem, curve_spans, levels_at, tolerated_clearance, wanted_clearances
from osm2xodr.model import (
    VEHICLE_LANES,
    CubicProfile,
    FloatArray,
    IntArray,
    Lane,
    LaneSection,
    LayerCrossing,
    RoadMap,
    StreetNetwork,
)
from osm2xodr.system import record

# Only what ways do within this distance of a place counts there, m: the widest junctions. A choice.
_AROUND: Final = 100.0
# Lines nearer than this touch, m: OSM's coordinates have steps of 1 cm.
_TOUCH: Final = 0.02


@record
class LinesInOsm:
    """How the lines of two ways lie to each other around a place."""

    crossing: tuple[int, int] | None  # Two of them that cross or touch where they share no node
    node: int | None  # OSM id of the node that they share nearest to the place
    away: float  # How far that is from the place, m
    apart: float  # Distance of the lines, m


@record(eq=False)
class _Segments(Table):
    """Straight pieces of ways."""

    way: IntArray  # (n,) OSM ids
    node: IntArray  # (n, 2) OSM ids of the nodes at both ends
    xy: FloatArray  # (n, 2, 2) Where these are, m


class WayLines:
    """The lines of some of a network's ways, by their OSM ids."""

    def __init__(self, network: StreetNetwork, ways: Set[int]) -> None:
        found: dict[int, tuple[list[IntArray], list[FloatArray]]] = {way: ([], []) for way in ways}
        for street in network.streets:
            begins = [*(first for first, _ in street.pieces), len(street.node_ids) - 1]
            for (first, last), (_, attributes) in zip(pairwise(begins), street.pieces, strict=True):
                if attributes.osm_way_id in found:
                    nodes, points = found[attributes.osm_way_id]
                    nodes.append(
                        np.column_stack([street.node_ids[first:last], street.node_ids[first + 1 : last + 1]])
                    )
                    points.append(np.stack([street.points[first:last], street.points[first + 1 : last + 1]], axis=1))
        self._segments = {
            way: _Segments(np.full(sum(map(len, nodes)), way), np.concatenate(nodes), np.concatenate(points))
            for way, (nodes, points) in found.items()
        }

    def between(self, one: Set[int], other: Set[int], place: FloatArray) -> LinesInOsm:
        """Return how the ways of one set lie to those of another around a place, (2,), m."""
        a, b = self._around(one, place), self._around(other, place)
        shared = (a.node[:, None, :, None] == b.node[None, :, None, :]).any(axis=(2, 3))
        (p, q), (r, s) = (np.moveaxis(item.xy, 1, 0) for item in (a, b))
        apart = np.minimum(_distances(a, b), _distances(b, a).T)
        apart[segments_cross(p[:, None], q[:, None], r[None], s[None])] = 0.0
        crossing = np.argwhere((apart < _TOUCH) & ~shared)
        nodes = np.intersect1d(a.node, b.node)
        away = hypot(*(a.xy - place).T).T
        away[~np.isin(a.node, nodes)] = np.inf
        nearest = np.unravel_index(int(away.argmin()), away.shape)
        return LinesInOsm(
            (int(a.way[crossing[0, 0]]), int(b.way[crossing[0, 1]])) if len(crossing) else None,
            int(a.node[nearest]) if len(nodes) else None,
            float(away[nearest]),
            float(apart.min()),
        )

    def _around(self, ways: Set[int], place: FloatArray) -> _Segments:
        """Return what ways have near a place; where that is nothing, all of them."""
        every = join_tables(self._segments[way] for way in sorted(ways))
        near = _to_segments(place[None], every.xy)[0] < _AROUND
        return every.chosen(near) if near.any() else every


def _distances(one: _Segments, other: _Segments) -> FloatArray:
    """Return the distances of segments' nearer ends from other segments, (n, m), m."""
    ends = _to_segments(one.xy.reshape(-1, 2), other.xy)
    return np.asarray(ends.reshape(-1, 2, len(other.xy)).min(axis=1), np.float64)


def _to_segments(points: FloatArray, segments: FloatArray) -> FloatArray:
    """Return the distances of points, (n, 2), from segments, (m, 2, 2), as (n, m), m."""
    begin, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    off = points[:, None] - begin
    share = np.clip((off * along).sum(axis=2) / np.maximum((along**2).sum(axis=1), 1e-12), 0.0, 1.0)
    out: FloatArray = hypot(*np.moveaxis(off - share[..., None] * along, 2, 0))
    return out


# ---------------------------------------------------------------- the report

# Number of stations that are worked out at once: some 10 MB.
_STATIONS_AT_ONCE: Final = 1 << 16


def with_clearances(
    network: StreetNetwork, road_map: RoadMap, problem: ProfileProblem, diagnostics: Diagnostics
) -> RoadMap:
    """Report places with less than the least clearance that the solve does not know of, and return the map with them.

    The solve knows where layers cross; what it could not keep apart is in the map's report already. What lies on one
    level has no clearance: it is reported by how the ways lie to each other in OSM.
    """
    found = close_places(_stations(road_map), _graph(road_map), CLEARANCE_LEAST)
    if not len(found.road):
        return road_map
    report = road_map.elevation_report
    known = {frozenset((item.upper, item.lower)) for item in report.tight} if report else set()
    places = _Places(network, road_map, problem, found)
    tight = []
    for k, crossing in enumerate(_crossings(road_map, problem, found)):
        if frozenset((crossing.upper, crossing.lower)) in known:
            continue
        tight.append(crossing)
        places.report(k, crossing, diagnostics)
    if report is None:
        return road_map
    every = tuple(sorted((*report.tight, *tight), key=lambda item: item.clearance - item.wanted))
    figures = {**road_map.statistics, "layer_crossings_too_close": float(len(every))}
    return replace(road_map, elevation_report=replace(report, tight=every), statistics=figures)


class _Places:
    """What is known about places that are too close."""

    def __init__(
        self, network: StreetNetwork, road_map: RoadMap, problem: ProfileProblem, found: ClosePlaces
    ) -> None:
        self._road_map, self._problem, self._found = road_map, problem, found
        self._index = {road.id: k for k, road in enumerate(road_map.roads)}
        self._node = {junction.id: junction.osm_node_ids[0] for junction in road_map.junctions}
        self._xy = np.column_stack(pose(road_map.plan_view, found.road, found.s)[:2])
        both = [[self._ways_of(*place) for place in zip(*side, strict=True)] for side in _both(found)]
        self._ways = list(zip(both[0], both[1], strict=True))
        self._lines = WayLines(network, {way for side in both for ways in side for way in ways})

    def _ways_of(self, road: int, s: float) -> frozenset[int]:
        """Return the way of a road at s, or the ways that a connecting road leads from and to."""
        item, at = self._road_map.roads[road], [(road, s)]
        if item.junction is not None:
            ends = [(self._index[link.id], link.at_start) for link in (item.predecessor, item.successor) if link]
            length = lengths(self._problem.plan_view)
            at = [(k, 0.0 if at_start else float(length[k])) for k, at_start in ends]
        spans = curve_spans(self._problem, np.array([k for k, _ in at]), np.array([s for _, s in at]))
        return frozenset(self._problem.span_way[spans].tolist())

    def report(self, k: int, crossing: LayerCrossing, diagnostics: Diagnostics) -> None:
        """Report a place, by the ways that it is about."""
        found, upper = self._found, f"way/{crossing.upper_way}"
        gap = f"{crossing.clearance:.1f} m above" if crossing.clearance >= 0.05 else "at the height of"
        level = levels_at(
            self._problem, np.array([found.road[k], found.other[k]]), np.array([found.s[k], found.other_s[k]])
        )
        lines = self._lines.between(*self._ways[k], self._xy[k])
        flat = self._road_map.elevation_report is None
        if level[0] != level[1] and not (flat and lines.node is not None):
            reason = "all ground is at one height" if flat else self._reason(k, level)
            diagnostics.note("clearance", upper, f"it passes {gap} way/{crossing.lower_way}: {reason}")
            return
        if lines.crossing is not None:
            text = f"it passes {gap} way/{lines.crossing[1]}: both are on one layer and have no node in common there"
            diagnostics.note("crossing-without-node", f"way/{lines.crossing[0]}", text)
            return
        inside = self._junction(crossing.upper), self._junction(crossing.lower)
        they, their = ("ways of both", "lines of their ways") if any(inside) else ("they", "their lines")
        if lines.node is not None:
            text = f"{they} meet at node/{lines.node}, {lines.away:.0f} m from there"
        else:
            text = f"{their} are {lines.apart:.1f} m apart and do not cross"
        text = f"its carriageway{inside[0]} lies on that of way/{crossing.lower_way}{inside[1]}: in OSM {text}"
        diagnostics.note("carriageways-overlap", upper, text)

    def _junction(self, road: int) -> str:
        """Return in which junction a road lies."""
        junction = self._road_map.roads[self._index[road]].junction
        return "" if junction is None else f" in the junction at node/{self._node[junction]}"

    def _reason(self, k: int, level: IntArray) -> str:
        """Return why the solve did not keep two roads of different levels apart."""
        spans = [curve_spans(self._problem, road[[k]], s[[k]]) for road, s in _both(self._found)]
        over, under = spans if level[0] > level[1] else spans[::-1]
        wanted = float(wanted_clearances(self._problem, over, under)[0][0])
        if wanted < CLEARANCE_LEAST and self._found.height[k] >= tolerated_clearance(wanted):
            return f"{wanted:.1f} m are enough there, by its maxheight or a correction"
        return "they meet, or their bridge or tunnel ends, too near to there"


def _crossings(road_map: RoadMap, problem: ProfileProblem, found: ClosePlaces) -> list[LayerCrossing]:
    """Return places as crossings, with the ids of the roads and ways."""
    z = [cubic_value(road_map.elevation, road, s) for road, s in _both(found)]
    ways = [problem.span_way[curve_spans(problem, road, s)] for road, s in _both(found)]
    over = z[0] >= z[1]
    upper, lower = np.where(over, found.road, found.other), np.where(over, found.other, found.road)
    upper_way, lower_way = np.where(over, *ways), np.where(over, *reversed(ways))
    ids = [road.id for road in road_map.roads]
    return [
        LayerCrossing(ids[upper[k]], ids[lower[k]], int(upper_way[k]), int(lower_way[k]), height, CLEARANCE_LEAST)
        for k, height in enumerate(found.height.tolist())
    ]


def _both(found: ClosePlaces) -> tuple[tuple[IntArray, FloatArray], tuple[IntArray, FloatArray]]:
    return (found.road, found.s), (found.other, found.other_s)


def _stations(road_map: RoadMap) -> Iterator[Stations]:
    """Yield the carriageways of all roads that cars drive on: those of some roads at once, which saves memory."""
    length = lengths(road_map.plan_view)
    count = np.maximum((length / CLEARANCE_STEP).astype(np.int64) + 1, 2)
    every = [section for item in road_map.roads for section in item.lane_sections]
    first = starts([len(item.lane_sections) for item in road_map.roads])
    # Roads share sections that are alike.
    number: dict[int, int] = {}
    shared = np.array([number.setdefault(id(item), len(number)) for item in every], np.int64)
    sections = [every[k] for k in np.unique(shared, return_index=True)[1].tolist()]
    begin = np.array([item.s for item in sections])
    is_driven = np.array([any(lane.type in VEHICLE_LANES for lane in item.lanes) for item in sections], bool)
    borders = [_Border.of(sections, side) for side in (-1, 1)]
    block = np.cumsum(count) // _STATIONS_AT_ONCE
    for roads in np.split(np.arange(len(count)), np.flatnonzero(np.diff(block)) + 1):
        road = np.repeat(roads, count[roads])
        s = length[road] * ranks(count[roads]) / (count[road] - 1)
        section = shared[find_record(first, begin[shared], road, s)]
        driven = is_driven[section]
        road, s, section = road[driven], s[driven], section[driven]
        x, y, hdg = pose(road_map.plan_view, road, s)
        z, bank = cubic_value(road_map.elevation, road, s), cubic_value(road_map.superelevation, road, s)
        offset = cubic_value(road_map.lane_offset, road, s)
        (cos, sin), (level, tilt) = cosine_sine(hdg), cosine_sine(bank)
        edges = []
        for border in borders:
            t = offset + border.t(section, s - begin[section])
            across = t * level
            edges.append(np.column_stack([x - sin * across, y + cos * across, z + t * tilt]))
        yield Stations(road, s, hdg, *edges)


@record(eq=False)
class _Border:
    """The edge of the carriageway on one side of sections."""

    start: IntArray  # (sections + 1,) Where the lanes between the reference line and the edge begin
    sign: FloatArray  # (lanes,) 1 for those on the left, -1 on the right
    widths: CubicProfile  # Of each lane

    @classmethod
    def of(cls, sections: Sequence[LaneSection], side: int) -> _Border:
        """Return the edges on the left, 1, or the right, -1."""
        within = [_within(item, side) for item in sections]
        # Lanes count away from the reference line: positive on the left.
        sign = np.array([1.0 if lane.id > 0 else -1.0 for lanes in within for lane in lanes])
        widths = profile_of([lane.widths for lanes in within for lane in lanes])
        return cls(starts([len(lanes) for lanes in within]), sign, widths)

    def t(self, section: IntArray, ds: FloatArray) -> FloatArray:
        """Return t, less the lane offset, at ds of sections, (n,), m."""
        size = np.diff(self.start)[section]
        row = np.repeat(np.arange(len(section)), size)
        lane = np.repeat(self.start[section], size) + ranks(size)
        widths = self.sign[lane] * cubic_value(self.widths, lane, ds[row])
        return np.asarray(np.bincount(row, widths, len(section)), np.float64)


def _within(section: LaneSection, side: int) -> list[Lane]:
    """Return the lanes between the reference line and the edge of the carriageway on a side."""
    ids = [lane.id for lane in section.lanes if lane.type in VEHICLE_LANES]
    if not ids:
        return []
    outer = max(ids) if side > 0 else min(ids)
    # Where all lanes for cars are on the other side, the edge is the inner one of the innermost.
    last = outer if outer * side > 0 else outer + side
    low, high = min(last, 0), max(last, 0)
    return [lane for lane in section.lanes if lane.id != 0 and low <= lane.id <= high]


def _graph(road_map: RoadMap) -> RoadGraph:
    """Return which roads of a map meet."""
    roads, index = road_map.roads, {road.id: k for k, road in enumerate(road_map.roads)}
    junctions = {junction.id: k for k, junction in enumerate(road_map.junctions)}
    inside = np.array([road.junction is not None for road in roads], bool)
    at = np.full((len(roads), 2), -1, np.int64)
    links: list[tuple[int, int]] = []
    for k, road in enumerate(roads):
        if road.junction is not None:
            at[k] = junctions[road.junction]
        for end, link in enumerate((road.predecessor, road.successor)):
            if link is not None and not link.to_junction:
                links.append((k, index[link.id]))
            elif link is not None and road.junction is None:
                at[k, end] = junctions[link.id]
    pairs = np.array(links, np.int64).reshape(-1, 2)
    return RoadGraph(lengths(road_map.plan_view), inside, at, pairs[:, 0], pairs[:, 1])

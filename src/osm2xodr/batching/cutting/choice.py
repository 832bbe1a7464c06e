"""Chooses the ways, nodes and relations of a cut, on request with the surroundings that shape roads at its border.

Points and segments within reach of an outline or of places.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, Final

import numpy as np

from osm2xodr import projection
from osm2xodr.batching.cutting.source import (
    Cells,
    Driven,
    Segments,
    Source,
    Streets,
    find_in_boxes,
    make_node_cells,
    make_segments,
    make_streets,
    make_way_cells,
    only,
)
from osm2xodr.batching.model import CutRequest
from osm2xodr.curves import (
    PointTree,
    cosine,
    distance_to_outline,
    hypot,
    outline_bounds,
    ranks,
    repeated,
    runs,
    sorted_unique,
    unique_inverse,
)
from osm2xodr.defaults import OUTLINE_REACH
from osm2xodr.model import BoolArray, FloatArray, IntArray, LocalFrame, Outline, freeze_arrays
from osm2xodr.system import record

# Streets this near to the border are cut out whole for both areas, m: roads lie some metres off OSM's lines.
_BORDER_REACH: Final = 300.0
# What lies this near to the ends of those streets belongs to the cut as well, m: junctions farther off do not shape
# each other (twice the longest connecting road through a large junction).
_CONTEXT_REACH: Final = 200.0
# And what lies this near to the middle of those streets, m: sidewalks tell of built-up areas and their speed limits
# over the whole length of a street (half of the widest carriageway, `ROADSIDE_REACH`, and some room).
_CONTEXT_BESIDE: Final = 50.0

# Boxes of degrees are larger by this, m, than the distance between straight lines in the local frame and in degrees,
# which meet in `_SAMPLES` points of each side.
_SLACK: Final = 100.0
_SAMPLES: Final = 33
# Least length of a degree of latitude, m (WGS 84, at the equator).
_DEGREE: Final = 110_574.0
# Distance of the points along streets around which is searched, m, and the largest number of them on one segment.
_SPACING: Final = 40.0
_PARTS_MAX: Final = 10_000
# Coordinate of points that the projection cannot place, m.
_NOWHERE: Final = 1e8

# Length of the parts that long segments are divided into, m, and the largest number of them.
_PART: Final = 200.0


@record(eq=False)
class Choice:
    """What belongs to a cut."""

    # Rows of `Source.way_ids`, `Source.relation_ids` and `Source.node_ids`, ascending
    ways: IntArray
    relations: IntArray
    nodes: IntArray
    # Ways and nodes that are only there for what scenes have beside roads
    more_ways: IntArray
    more_nodes: IntArray
    driven: Mapping[str, int]  # Number of ways that become streets in the area itself or in each part, by name
    bounds_deg: tuple[float, float, float, float]  # West, south, east, north of the area, degrees

    def __post_init__(self) -> None:
        freeze_arrays(self)


@record(eq=False)
class Members:
    """Ways and nodes that are members of relations."""

    # Ways of each relation, from `first_way` [relation] to `first_way` [relation + 1]
    first_way: IntArray
    ways: IntArray
    # Ways or nodes, ascending, and the relation of each
    way: tuple[IntArray, IntArray]
    node: tuple[IntArray, IntArray]


@record(eq=False)
class Plan:
    """A map, prepared for choosing."""

    source: Source  # The map
    segments: Segments
    # Where ways that conversions read, what scenes show, and things are
    way_cells: Cells
    outline_cells: Cells
    thing_cells: Cells
    # Of relations that conversions read, and of multipolygons of scenes
    members: Members
    outlines: Members
    streets: Mapping[Driven, Streets]  # By what becomes a street; none unless a request has a context


def make_plan(source: Source, *, context: bool) -> Plan:
    """Prepare a map for choosing; `context` says whether any request has one."""
    segments = make_segments(source)
    chosen = source.driven if context else {}
    streets = {driven: make_streets(source, segments, ways) for driven, ways in chosen.items()}
    things = make_node_cells(source, np.flatnonzero(source.thing))
    cells = make_way_cells(source, segments)
    return Plan(
        source,
        segments,
        only(cells, source.way_read),
        cells,
        things,
        _make_members(source, source.relation_read, source.way_read),
        _make_members(source, ~source.relation_read, np.ones(len(source.way_ids), np.bool_)),
        streets,
    )


def choose(plan: Plan, request: CutRequest, driven: Driven) -> Choice:
    """Choose what belongs to a cut; `driven` says what becomes a street."""
    source = plan.source
    reach = _BORDER_REACH + _CONTEXT_REACH if request.context else 0.0
    bounds, box = _boxes(request, reach)
    candidates = find_in_boxes(plan.way_cells, box)
    near = _Near(plan, request, candidates, reach)
    kept = near.ways(reach)
    things = find_in_boxes(plan.thing_cells, box)
    at = _local(source, request.frame, things)
    things = things[distance_to_outline(request.outline, at[:, 0], at[:, 1], reach) <= reach]
    if request.context:
        ways, segments, ends = _find_streets(plan, near.segments(_BORDER_REACH), driven)
        beside = _points_along(plan, request.frame, segments)
        # All that is near the area is kept anyway.
        off = distance_to_outline(request.outline, beside[:, 0], beside[:, 1], reach)
        beside = beside[off > reach - _CONTEXT_BESIDE - _SPACING]
        at_ends = _around(plan, request.frame, _local(source, request.frame, ends), _CONTEXT_REACH)
        along = _around(plan, request.frame, beside, _CONTEXT_BESIDE + 0.5 * _SPACING)
        kept = sorted_unique(np.concatenate([kept, ways, at_ends[0], along[0]]))
        things = sorted_unique(np.concatenate([things, at_ends[1], along[1]]))
    kept, relations = _with_relations(plan, kept)
    nodes = np.union1d(source.row[_ranges(source.first, kept)], things)
    outlines, areas = _surroundings(plan, request) if request.surroundings else (kept[:0], kept[:0])
    more_ways = np.setdiff1d(outlines, kept)
    more_nodes = np.setdiff1d(source.row[_ranges(source.first, more_ways)], nodes)
    relations = np.union1d(relations, areas)
    counted = _count_driven(plan, request, driven, near)
    return Choice(kept, relations, nodes, more_ways, more_nodes, counted, bounds)


def _surroundings(plan: Plan, request: CutRequest) -> tuple[IntArray, IntArray]:
    """Return the ways and the multipolygons that scenes have in the rectangle around an area.

    Scenes close what reaches beyond along the sides of this rectangle, which the file states.
    """
    corners = np.concatenate(request.outline.rings)
    (west, south), (east, north) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    rectangle = Outline((np.array([[west, south], [east, south], [east, north], [west, north]]),))
    whole = replace(request, outline=rectangle, parts={})
    _, box = _boxes(whole, OUTLINE_REACH)
    near = _Near(plan, whole, find_in_boxes(plan.outline_cells, box), OUTLINE_REACH)
    inside, members = near.ways(0.0), plan.outlines
    areas = _among(members.way, inside)
    named = members.ways[_ranges(members.first_way, areas)]
    shown = inside[plan.source.way_shown[inside]]
    return np.union1d(shown, np.intersect1d(named, near.ways(OUTLINE_REACH))), areas


def _count_driven(plan: Plan, request: CutRequest, driven: Driven, near: _Near) -> dict[str, int]:
    """Return the number of ways in the area, or in each part of it, that become streets."""
    counted = plan.source.driven[driven]
    if not request.parts:
        return {request.name: int(counted[near.ways(0.0)].sum())}
    found = {}
    for name, outline in request.parts.items():
        part = replace(request, outline=outline, parts={})
        candidates = find_in_boxes(plan.way_cells, _boxes(part, 0.0)[1])
        found[name] = int(counted[_Near(plan, part, candidates[counted[candidates]], 0.0).ways(0.0)].sum())
    return found


class _Near:
    """Distances of ways from an area."""

    def __init__(self, plan: Plan, request: CutRequest, candidates: IntArray, reach: float) -> None:
        source, segments = plan.source, plan.segments
        self._request = request
        self._at = _ranges(segments.first, candidates)
        self._of_segment = np.repeat(candidates, np.diff(segments.first)[candidates])
        refs = _ranges(source.first, candidates)
        self._of_ref = np.repeat(candidates, np.diff(source.first)[candidates])
        rows, self._ref = unique_inverse(source.row[refs])
        points = _local(source, request.frame, rows)
        self._off = distance_to_outline(request.outline, points[:, 0], points[:, 1], reach)
        start, end = (np.searchsorted(rows, nodes[self._at]) for nodes in (segments.start, segments.end))
        self._start, self._end = points[start], points[end]
        self._nearer = np.minimum(self._off[start], self._off[end])

    def segments(self, reach: float) -> IntArray:
        """Return the segments within `reach`, m."""
        return self._at[self._hit(reach)]

    def ways(self, reach: float) -> IntArray:
        """Return the ways within `reach`, m, ascending."""
        near = self._off[self._ref] <= reach
        return sorted_unique(np.concatenate([self._of_ref[near], self._of_segment[self._hit(reach)]]))

    def _hit(self, reach: float) -> BoolArray:
        return reached(self._request.outline, self._start, self._end, self._nearer, reach)


def _boxes(request: CutRequest, reach: float) -> tuple[tuple[float, float, float, float], FloatArray]:
    """Return the bounds of the area, and those of all within reach of it, (1, 4), degrees."""
    corners = np.concatenate(request.outline.rings)
    low, high = corners.min(axis=0), corners.max(axis=0)
    wide = _bounds(request.frame, low - reach - _SLACK, high + reach + _SLACK)
    return _bounds(request.frame, low, high), np.array([wide])


def _bounds(frame: LocalFrame, low: FloatArray, high: FloatArray) -> tuple[float, float, float, float]:
    """Return west, south, east, north of a rectangle, degrees; west may be below -180, east above 180."""
    share = np.linspace(0.0, 1.0, _SAMPLES)
    x, y = (low + share[:, None] * (high - low)).T
    side = np.ones(_SAMPLES)
    lon, lat = _to_degrees(frame).transform(
        np.concatenate([x, x, side * x[0], side * x[-1]]), np.concatenate([side * y[0], side * y[-1], y, y])
    )
    lon = frame.lon_0_deg + (lon - frame.lon_0_deg + 180.0) % 360.0 - 180.0
    return float(lon.min()), float(lat.min()), float(lon.max()), float(lat.max())


@lru_cache(maxsize=4)
def _to_degrees(frame: LocalFrame) -> Any:
    # Cached, because making it takes longer than choosing a tile.
    return projection.transformer_to(frame, projection.WGS84)


def _local(source: Source, frame: LocalFrame, rows: IntArray) -> FloatArray:
    """Return local x, y of nodes, (n, 2), m."""
    if not len(rows):
        return np.zeros((0, 2))
    # Padded, because pyproj takes an array of one for a number.
    padded = np.append(rows, rows[:1])
    points = np.column_stack(_to_degrees(frame).transform(*source.degrees(padded), direction="INVERSE"))[:-1]
    points[~(np.abs(points) < _NOWHERE).all(axis=1)] = _NOWHERE
    return points


def _ranges(first: IntArray, groups: IntArray) -> IntArray:
    """Return the indices of all members of some groups; those of a group begin at `first` [group]."""
    return runs(first[groups], first[groups + 1] - first[groups])


def _find_streets(plan: Plan, near: IntArray, driven: Driven) -> tuple[IntArray, IntArray, IntArray]:
    """Return the ways and segments of the streets that segments belong to, and the nodes at their ends."""
    streets = plan.streets[driven]
    found = sorted_unique(streets.of_segment[near])
    found = found[found >= 0]
    ways = sorted_unique(streets.ways[_ranges(streets.first_way, found)])
    ends = sorted_unique(streets.ends[_ranges(streets.first_end, found)])
    segments = _ranges(plan.segments.first, ways)
    return ways, segments[np.isin(streets.of_segment[segments], found)], ends


def _points_along(plan: Plan, frame: LocalFrame, segments: IntArray) -> FloatArray:
    """Return points (n, 2) along segments, `_SPACING` apart."""
    start = _local(plan.source, frame, plan.segments.start[segments])
    along = _local(plan.source, frame, plan.segments.end[segments]) - start
    parts = np.clip(np.ceil(hypot(along[:, 0], along[:, 1]) / _SPACING), 1, _PARTS_MAX).astype(np.int64)
    share = (ranks(parts) + 0.5) / np.repeat(parts, parts)
    out: FloatArray = np.repeat(start, parts, axis=0) + share[:, None] * np.repeat(along, parts, axis=0)
    return out


def _around(plan: Plan, frame: LocalFrame, places: FloatArray, reach: float) -> tuple[IntArray, IntArray]:
    """Return the ways and the things within `reach` of places (n, 2), m."""
    source, segments = plan.source, plan.segments
    if not len(places):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    # As in `_local`.
    lon, lat = _to_degrees(frame).transform(*np.append(places, places[:1], axis=0).T)
    lon, lat = lon[:-1], lat[:-1]
    high = (reach + _SLACK) / _DEGREE
    wide = high / np.maximum(cosine(np.radians(np.abs(lat) + high)), 1e-3)
    boxes = np.column_stack([lon - wide, lat - high, lon + wide, lat + high])
    boxes = boxes[np.isfinite(boxes).all(axis=1)]
    ways = find_in_boxes(plan.way_cells, boxes)
    at = _ranges(segments.first, ways)
    of_segment = np.repeat(ways, np.diff(segments.first)[ways])
    rows = sorted_unique(np.concatenate([segments.start[at], segments.end[at]]))
    points = _local(source, frame, rows)
    start, end = (points[np.searchsorted(rows, nodes[at])] for nodes in (segments.start, segments.end))
    hit = near_places(start, end, places, reach)
    things = find_in_boxes(plan.thing_cells, boxes)
    close = points_near_places(_local(source, frame, things), places, reach)
    return sorted_unique(of_segment[hit]), things[close]


def _with_relations(plan: Plan, ways: IntArray) -> tuple[IntArray, IntArray]:
    """Return the ways with those that their relations need, and these relations."""
    source, members = plan.source, plan.members
    nodes = sorted_unique(source.row[_ranges(source.first, ways)])
    hit = np.union1d(_among(members.way, ways), _among(members.node, nodes))
    ways = np.union1d(ways, members.ways[_ranges(members.first_way, hit)])
    # The added ways may complete further relations.
    more = np.setdiff1d(_among(members.way, ways), hit)
    held = np.isin(members.ways[_ranges(members.first_way, more)], ways)
    count = np.diff(members.first_way)[more]
    missing = np.bincount(repeated(count)[~held], minlength=len(more))
    return ways, np.union1d(hit, more[missing == 0])


def _among(pairs: tuple[IntArray, IntArray], chosen: IntArray) -> IntArray:
    """Return the relations that are paired with the chosen items, ascending."""
    keys, relations = pairs
    first, last = np.searchsorted(keys, chosen), np.searchsorted(keys, chosen, side="right")
    return sorted_unique(relations[runs(first, last - first)])


def _make_members(source: Source, relations: BoolArray, among: BoolArray) -> Members:
    """Return the members of some relations (relations,) that are among some ways (ways,)."""
    current = np.flatnonzero(source.relation_current & relations)
    order = np.flatnonzero(source.way_current & among)
    order = order[np.argsort(source.way_ids[order], kind="stable")]
    ways, of_way = _present(source.way_ids[order], [source.member_ways[index] for index in current.tolist()])
    nodes, of_node = _present(source.node_ids, [source.member_nodes[index] for index in current.tolist()])
    ways, of_way, of_node = order[ways], current[of_way], current[of_node]
    first = np.searchsorted(of_way, np.arange(len(source.relation_ids) + 1))
    by_way, by_node = np.argsort(ways, kind="stable"), np.argsort(nodes, kind="stable")
    return Members(first, ways, (ways[by_way], of_way[by_way]), (nodes[by_node], of_node[by_node]))


def _present(ids: IntArray, members: Sequence[IntArray]) -> tuple[IntArray, IntArray]:
    """Return the members that are among the ids, as indices of these, and the list that each is from."""
    number = np.concatenate([np.zeros(0, np.int64), *members])
    owner = repeated([len(refs) for refs in members])
    present = np.isin(number, ids)
    return np.searchsorted(ids, number[present]), owner[present]


def reached(outline: Outline, start: FloatArray, end: FloatArray, far: FloatArray, reach: float) -> BoolArray:
    """Return which segments have a point within `reach` of an area, m; 0 for those that touch it.

    `start` and `end` (n, 2) are their ends, local x, y, m, `far` (n,) the distance of the nearer end from the area.
    """
    out = far <= reach
    west, south, east, north = outline_bounds(outline)
    beside = np.minimum(start, end) <= (east + reach, north + reach)
    beside &= np.maximum(start, end) >= (west - reach, south - reach)
    rest = np.flatnonzero(~out & beside.all(axis=1))
    # Segments without an end within reach come nearest to a corner, or cross an edge.
    for ring in outline.rings:
        for corner, following in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            if not len(rest):
                return out
            a, b = start[rest], end[rest]
            hit = (_to_point(a, b, corner) <= reach) | _crosses(a, b, corner, following)
            out[rest[hit]] = True
            rest = rest[~hit]
    return out


def _to_point(start: FloatArray, end: FloatArray, point: FloatArray) -> FloatArray:
    """Return the distance of segments (n, 2) from a point (2,), or from one each (n, 2), m."""
    along = end - start
    square = np.maximum((along * along).sum(axis=1), 1e-12)
    share = np.clip(((point - start) * along).sum(axis=1) / square, 0.0, 1.0)
    off = point - start - share[:, None] * along
    out: FloatArray = hypot(off[:, 0], off[:, 1])
    return out


def _crosses(start: FloatArray, end: FloatArray, corner: FloatArray, following: FloatArray) -> BoolArray:
    """Return which segments (n, 2) cross an edge; those in line with it meet it in a corner or not at all."""
    of_start, of_end = _side(corner, following, start), _side(corner, following, end)
    of_corner, of_following = _side(start, end, corner), _side(start, end, following)
    beside = (of_start != 0.0) | (of_end != 0.0)
    out: BoolArray = (of_start * of_end <= 0.0) & (of_corner * of_following <= 0.0) & beside
    return out


def _side(start: FloatArray, end: FloatArray, point: FloatArray) -> FloatArray:
    """Return the side of lines that points lie on: the sign of a cross product."""
    along, off = end - start, point - start
    out: FloatArray = np.sign(along[..., 0] * off[..., 1] - along[..., 1] * off[..., 0])
    return out


def near_places(start: FloatArray, end: FloatArray, places: FloatArray, reach: float) -> BoolArray:
    """Return which segments (n, 2) have a point within `reach` of any place (m, 2), m."""
    out = np.zeros(len(start), np.bool_)
    if not len(start) or not len(places):
        return out
    length = hypot(*(end - start).T)
    parts = np.clip(np.ceil(length / _PART), 1, _PARTS_MAX).astype(np.int64)
    segment = repeated(parts)
    share = ((ranks(parts) + 0.5) / parts[segment])[:, None]
    middle = start[segment] + share * (end[segment] - start[segment])
    index, found = PointTree(middle).within(places, reach + 0.5 * _PART)
    chosen = segment[found]
    out[chosen[_to_point(start[chosen], end[chosen], places[index]) <= reach]] = True
    return out


def points_near_places(points: FloatArray, places: FloatArray, reach: float) -> BoolArray:
    """Return which points (n, 2) are within `reach` of any place (m, 2), m."""
    if not len(points) or not len(places):
        return np.zeros(len(points), np.bool_)
    nearest, _ = PointTree(places).nearest(points)
    return np.asarray(nearest <= reach, np.bool_)

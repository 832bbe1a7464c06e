"""Barriers, walls, fences, hedges, kerbs, bollards, lamps and trees beside roads, and tram tracks in them.

Lines along roads become strips, over which t changes linearly with s, and objects along these.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from osm2xodr.curves import (
    arctan2,
    cosine,
    pose,
    ranks,
    repeated,
    running_lengths,
    sine,
    unique_first,
    wrapped,
)
from osm2xodr.diagnostics import Kind
from osm2xodr.furniture import defaults
from osm2xodr.furniture.world import LaneAt, RoadsideFinder, RoadsidePlaces, World, pieces_on_road
from osm2xodr.model import (
    VEHICLE_LANES,
    BoolArray,
    FloatArray,
    IntArray,
    ObjectRepeat,
    RoadObject,
    RoadsideKind,
    RoadsideThing,
)
from osm2xodr.system import record

# OpenDRIVE's type and subtype, and a name.
_WORDS: Final = {
    RoadsideKind.GUARD_RAIL: ("barrier", "guardRail", "guard rail"),
    RoadsideKind.WALL: ("barrier", "wall", "wall"),
    RoadsideKind.FENCE: ("railing", "fence", "fence"),
    RoadsideKind.HEDGE: ("vegetation", "hedge", "hedge"),
    RoadsideKind.BOLLARD: ("pole", "bollard", "bollard"),
    RoadsideKind.KERB: ("none", "kerb", "kerb"),
    RoadsideKind.STREET_LAMP: ("streetLamp", "", "street lamp"),
    RoadsideKind.TREE: ("tree", "", "tree"),
}
# Width and height where tags give none, m: guard rails of steel (0.75 m) and kerbs (0.12 m) as in most of Germany
# (RPS 2009, RASt 06); garden walls, fences and hedges, street lamps, young trees: choices.
_SIZES: Final = {
    RoadsideKind.GUARD_RAIL: (0.3, 0.75),
    RoadsideKind.WALL: (0.3, 1.5),
    RoadsideKind.FENCE: (0.1, 1.2),
    RoadsideKind.HEDGE: (0.6, 1.2),
    RoadsideKind.BOLLARD: (0.2, 0.9),
    RoadsideKind.KERB: (0.15, 0.12),
    RoadsideKind.STREET_LAMP: (0.2, 6.0),
    RoadsideKind.TREE: (0.6, 8.0),
}
# Kinds that are placed on request only, and their names in the options.
_ON_REQUEST: Final = {RoadsideKind.STREET_LAMP: "lamps", RoadsideKind.TREE: "trees"}
_SINGLE: Final = (RoadsideKind.BOLLARD, RoadsideKind.GUARD_RAIL)
# Spacing in rows that are mapped as a line, m: bollards, so that no car passes between them, and trees. Choices.
_BOLLARD_SPACING: Final = 1.5
_TREE_SPACING: Final = 10.0

# Distance of the points of a line that are placed beside roads, m; a choice.
POINT_SPACING: Final = 3.0
# Distance of those of lines on carriageways, m, so that they run on through junctions without gaps; a choice.
_SPACING_ON_ROADS: Final = 0.5
# Points nearer to each other are the same, m: rounding.
_SAME_PLACE: Final = 1e-6
# Shorter parts of lines are left out, m; a choice.
SHORTEST_RUN: Final = 1.0
# How far lines are moved at most to have fewer points, m; a choice.
_TOLERANCE: Final = 0.1
# Parts that turn away from the road by more do not run along it, m per m; a choice.
_SLOPE_MAX: Final = 1.0
# How far objects may reach onto the carriageway, m: rounding, and the tolerance of lines between their points.
_ON_CARRIAGEWAY: Final = 0.01


def line_objects(world: World, finder: RoadsideFinder) -> list[RoadObject]:
    """Make the objects of lines along roads, road by road as far as they run along it."""
    kinds = _WORDS.keys() - _ON_REQUEST.keys()
    lines = [thing for thing in world.network.roadside if thing.kind in kinds and len(thing.points) > 1]
    if not lines:
        return []
    sizes = [_size(thing) for thing in lines]
    strips = strips_outside(finder, [thing.points for thing in lines], [0.5 * width for width, _ in sizes])
    left_out: defaultdict[str, list[str]] = defaultdict(list)
    for k in sorted(set(range(len(lines))) - {strip.line for strip in strips}):
        left_out[lines[k].kind.value.replace("_", " ")].append(lines[k].osm_id)
    for name, ids in sorted(left_out.items()):
        finding = f"with a {name} left out: no part runs beside a carriageway within {defaults.OBJECT_REACH:g} m"
        world.diagnostics.count(Kind.DROPPED, "roadside-left-out", ids, "way", finding)
    out = []
    for strip in strips:
        thing = lines[strip.line]
        spacing = _BOLLARD_SPACING if thing.kind is RoadsideKind.BOLLARD else 0.0
        size = sizes[strip.line]
        out.append(object_along(world, strip, _WORDS[thing.kind], size, thing.osm_id, distance=spacing))
    return out


def point_objects(world: World, finder: RoadsideFinder) -> list[RoadObject]:
    """Make the objects of single things beside roads."""
    chosen = [thing for thing in world.network.roadside if _is_wanted(world, thing)]
    if not chosen:
        return []
    rows = [(thing, x, y) for thing in chosen for x, y in _points(thing)]
    places = finder.places(np.array([x for _, x, _ in rows]), np.array([y for _, _, y in rows]))
    leftwards = places.t - places.left > places.right - places.t
    out: list[RoadObject] = []
    left_out: defaultdict[tuple[str, str], list[str]] = defaultdict(list)
    for k, (thing, _, _) in enumerate(rows):
        if places.road[k] < 0 or places.beyond[k] < -defaults.OBJECT_INSIDE:
            far = places.road[k] < 0
            why = f"no road lies within {defaults.OBJECT_REACH:g} m" if far else "on the carriageway"
            left_out[thing.kind.value, why].append(thing.osm_id)
            continue
        width, height = _size(thing)
        off = 0.5 * width + defaults.OBJECT_GAP
        t = max(places.t[k], places.left[k] + off) if leftwards[k] else min(places.t[k], places.right[k] - off)
        road = world.road_map.roads[int(places.road[k])].id
        found = world.object_at(road, _WORDS[thing.kind], float(places.s[k]), float(t), thing.osm_id)
        out.append(replace(found, height=height, radius=0.5 * width))
    for (kind, why), names in sorted(left_out.items()):
        noun = kind.replace("_", " ")
        world.diagnostics.count(Kind.DROPPED, "roadside-left-out", names, noun, f"left out: {why}")
    return out


def _size(thing: RoadsideThing) -> tuple[float, float]:
    """Return width and height, m: as tagged, else usual."""
    width, height = _SIZES[thing.kind]
    facts = thing.facts
    return width if facts.width is None else facts.width, height if facts.height is None else facts.height


def _is_wanted(world: World, thing: RoadsideThing) -> bool:
    if thing.kind in _ON_REQUEST:
        return _ON_REQUEST[thing.kind] in world.options.extra_objects
    return thing.kind in _SINGLE and len(thing.points) == 1


def _points(thing: RoadsideThing) -> list[list[float]]:
    """Return where a thing stands, m, or each one of a row."""
    points = thing.points
    if len(points) > 1:
        along = running_lengths(points)
        at = np.linspace(0.0, along[-1], max(round(along[-1] / _TREE_SPACING), 1) + 1)
        points = np.column_stack([np.interp(at, along, column) for column in points.T])
    out: list[list[float]] = points.tolist()
    return out


# Standard gauge, and width of the head of a grooved rail, m.
_GAUGE: Final = 1.435
_TRACK: Final = ("patch", "tramTrack", "tram track")
_RAIL_WIDTH: Final = 0.07


def tram_objects(world: World, finder: RoadsideFinder) -> list[RoadObject]:
    """Make the rails of tram tracks on carriageways.

    Tracks that are mapped as ways of their own lie where they are mapped, also through junctions; those that only the
    street's tags name lie in the lanes for cars next to the centre.
    """
    tracks = [thing for thing in world.network.roadside if thing.kind is RoadsideKind.TRAM_TRACK]
    lines = [thing for thing in tracks if len(thing.points) > 1]
    half = 0.5 * (_GAUGE + _RAIL_WIDTH)
    mapped, across = strips_on(finder, [thing.points for thing in lines], _nodes_on_streets(world, lines), half)
    gauges = [thing.facts.gauge or _GAUGE for thing in lines]
    out: list[RoadObject] = []
    for strip in mapped:
        out += _rails(world, strip, gauges[strip.line], lines[strip.line].osm_id)
    out += _rails_across(world, finder, across, gauges, [thing.osm_id for thing in lines])
    with_tracks = {item.road for item in out}
    for k, street in enumerate(world.places.road_street.tolist()):
        road = world.road_map.roads[k].id
        if road in with_tracks or not any(piece.tram for _, piece in world.network.streets[street].pieces):
            continue
        for begin, end, attributes in pieces_on_road(world, world.network.streets[street], road):
            if attributes.tram:
                for strip in _in_lanes(world, k, begin, end):
                    out += _rails(world, strip, _GAUGE, f"way/{attributes.osm_way_id}")
    return out


def _nodes_on_streets(world: World, lines: Sequence[RoadsideThing]) -> list[FloatArray]:
    """Return the nodes of each line that are nodes of streets as well, (n, 2), m."""
    none = np.zeros(0, np.int64)
    own, of_streets = (
        np.concatenate([none, *(item.node_ids for item in items)]) for items in (lines, world.network.streets)
    )
    end = np.cumsum([len(item.points) for item in lines])
    shared = np.split(np.isin(own, of_streets), end[:-1]) if lines else []
    return [item.points[rows] for item, rows in zip(lines, shared, strict=True)]


def _in_lanes(world: World, curve: int, begin: float, end: float) -> list[Strip]:
    """Return the middle lines of tracks in the lanes for cars next to the centre, on both sides."""
    if end - begin < SHORTEST_RUN:
        return []
    road = world.road_map.roads[curve].id
    count = max(int(np.ceil((end - begin) / POINT_SPACING)), 1) + 1
    stations = np.linspace(begin, end, count)
    lanes = [world.lanes.at(road, s) for s in stations.tolist()]
    out: list[Strip] = []
    for left in (True, False):
        middles = np.array([_innermost(here, left) for here in lanes])
        there = np.flatnonzero(np.isfinite(middles))
        for rows in np.split(there, np.flatnonzero(np.diff(there) > 1) + 1):
            if len(rows) > 1:
                out += simplified(Run(0, curve, stations[rows], middles[rows]))
    return out


def _innermost(lanes: Iterable[LaneAt], left: bool) -> float:
    """Return t of the middle of the lane for cars next to the centre on one side, NaN where there is none."""
    found = [
        lane for lane in lanes if (lane.id > 0) == left and lane.type in VEHICLE_LANES and lane.left > lane.right
    ]
    return min(found, key=lambda lane: abs(lane.id)).middle if found else float("nan")


def _rails(world: World, strip: Strip, gauge: float, osm_id: str) -> list[RoadObject]:
    return [object_along(world, strip, _TRACK, (_RAIL_WIDTH, 0.0), osm_id, side * gauge) for side in (0.5, -0.5)]


def _rails_across(
    world: World, finder: RoadsideFinder, pieces: Sequence[Piece], gauges: Sequence[float], osm_ids: Sequence[str]
) -> list[RoadObject]:
    """Make rails along straight pieces of lines, each on the road that its middle lies on."""
    rails = [(piece, side * gauges[piece.line]) for piece in pieces for side in (0.5, -0.5)]
    if not rails:
        return []
    x0, y0, x1, y1, left = np.array([(*piece.begin, *piece.end, offset) for piece, offset in rails]).T
    length, hdg = np.hypot(x1 - x0, y1 - y0), arctan2(y1 - y0, x1 - x0)
    x, y = 0.5 * (x0 + x1) - left * sine(hdg), 0.5 * (y0 + y1) + left * cosine(hdg)
    road, s, t = _on_any_road(finder, finder.places(x, y, 0.0), x, y)
    on = np.flatnonzero(road >= 0)
    turn = wrapped(hdg[on] - pose(world.road_map.plan_view, road[on], s[on])[2])
    columns = (column.tolist() for column in (on, road[on], s[on], t[on], turn, length[on]))
    return [
        replace(
            world.object_at(world.road_map.roads[k].id, _TRACK, at, across, osm_ids[rails[row][0].line]),
            hdg=angle,
            length=along,
            width=_RAIL_WIDTH,
        )
        for row, k, at, across, angle, along in zip(*columns, strict=True)
    ]


@record
class Strip:
    """Part of a line that runs along a road."""

    line: int  # Index of the line
    road: int  # Index of the road
    s: float  # Where it begins, m
    length: float  # m
    t_start: float  # At its start, m
    t_end: float  # At its end, m


@record
class Piece:
    """Straight part of a line on carriageways."""

    line: int  # Index of the line
    # x, y, m
    begin: tuple[float, float]
    end: tuple[float, float]


@record
class Run:
    """Consecutive points of a line that run along one road, in ascending s."""

    line: int  # Index of the line
    road: int  # Index of the road
    s: FloatArray  # m
    t: FloatArray  # m
    points: tuple[int, int] = 0, 0  # The first of the points and that behind the last


def strips_outside(finder: RoadsideFinder, lines: Sequence[FloatArray], half_widths: Sequence[float]) -> list[Strip]:
    """Cut lines to the roads that they run along, and move them off the carriageways.

    Lines are local x, y of their points, (n, 2), m; half widths are those of what is built along each, m.
    """
    line, x, y = _points_along(lines, POINT_SPACING)
    places = finder.places(x, y)
    half = np.array(half_widths)[line]
    off = defaults.OBJECT_GAP + half
    kept = (places.road >= 0) & (places.beyond >= -defaults.OBJECT_INSIDE)
    leftwards = places.t - places.left > places.right - places.t
    t = np.where(leftwards, np.maximum(places.t, places.left + off), np.minimum(places.t, places.right - off))
    strips = [strip for run in _runs(line, places, t, kept, leftwards) for strip in simplified(run)]
    return _staying_off(finder, strips, half_widths)


def strips_on(
    finder: RoadsideFinder, lines: Sequence[FloatArray], on_streets: Sequence[FloatArray], half_width: float
) -> tuple[list[Strip], list[Piece]]:
    """Cut lines (n, 2) to the carriageways on which they run with their half width, m.

    Where they cross carriageways, or lead through junctions, they are straight pieces: if they run along a road next
    to that, or one of their nodes that are `on_streets` as well, (m, 2), lies there. Others pass above or below.
    """
    line, x, y = _points_along(lines, _SPACING_ON_ROADS)
    places = finder.places(x, y, 0.0)
    inside = places.beyond <= -half_width
    one_side = np.zeros(len(line), np.bool_)
    runs = list(_runs(line, places, places.t, inside, one_side))
    on = _on_any_road(finder, places, x, y)[0] >= 0
    at_level = _are_among(line, x, y, on_streets)
    # From each point to the next.
    rest = on[1:] & on[:-1] & (line[1:] == line[:-1])
    for run in runs:
        first, stop = run.points
        rest[first : stop - 1] = False
        at_level[first] = at_level[stop - 1] = True
    rows = np.flatnonzero(rest)
    pieces = [
        Piece(int(line[one]), (float(x[one]), float(y[one])), (float(x[other]), float(y[other])))
        for part in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
        if len(part) and at_level[part[0] : part[-1] + 2].any()
        for one, other in pairwise(_corners(x, y, int(part[0]), int(part[-1]) + 1))
    ]
    return [strip for run in runs for strip in simplified(run)], pieces


def _are_among(line: IntArray, x: FloatArray, y: FloatArray, nodes: Sequence[FloatArray]) -> BoolArray:
    """Say which points on lines are nodes of these, (n,); `nodes` are some of each line, (m, 2), m."""
    out = np.zeros(len(line), np.bool_)
    for k, some in enumerate(nodes):
        first, stop = np.searchsorted(line, [k, k + 1])
        apart = np.hypot(x[first:stop, None] - some[:, 0], y[first:stop, None] - some[:, 1])
        out[first:stop] = (apart < _SAME_PLACE).any(axis=1)
    return out


def _on_any_road(
    finder: RoadsideFinder, places: RoadsidePlaces, x: FloatArray, y: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the road that points lie on, -1 for none, s and t, (n,): outside junctions, else through them.

    Of several it is the one whose reference line is nearest.
    """
    road, s, t = places.road.copy(), places.s.copy(), places.t.copy()
    inside = np.flatnonzero(road < 0)
    point, curve, along, across = finder.on_connecting_roads(x[inside], y[inside])
    order = np.lexsort((curve, np.abs(across), point))
    first = order[unique_first(point[order])[1]]
    at = inside[point[first]]
    road[at], s[at], t[at] = curve[first], along[first], across[first]
    return road, s, t


def _corners(x: FloatArray, y: FloatArray, first: int, last: int) -> list[int]:
    """Return the points, from a first to a last one, that straight pieces lead between within the tolerance.

    They are found as Douglas and Peucker (1973) did.
    """
    kept, todo = {first, last}, [(first, last)]
    while todo:
        one, other = todo.pop()
        dx, dy = x[other] - x[one], y[other] - y[one]
        rows = slice(one, other + 1)
        off = np.abs((x[rows] - x[one]) * dy - (y[rows] - y[one]) * dx)
        worst = one + int(np.argmax(off))
        if off[worst - one] > _TOLERANCE * np.hypot(dx, dy):
            kept.add(worst)
            todo += [(one, worst), (worst, other)]
    return sorted(kept)


def _points_along(lines: Sequence[FloatArray], spacing: float) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return points along lines, vertices included: the index of each one's line, x and y, (n,), m."""
    xs, ys, owner = [np.zeros(0)], [np.zeros(0)], [np.zeros(0, np.int64)]
    for k, points in enumerate(lines):
        along = running_lengths(points)
        count = max(int(np.ceil(along[-1] / spacing)), 1) + 1
        at = np.unique(np.concatenate([np.linspace(0.0, along[-1], count), along]))
        xs.append(np.interp(at, along, points[:, 0]))
        ys.append(np.interp(at, along, points[:, 1]))
        owner.append(np.full(len(at), k, np.int64))
    return np.concatenate(owner), np.concatenate(xs), np.concatenate(ys)


def _runs(line: IntArray, places: RoadsidePlaces, t: FloatArray, kept: BoolArray, side: BoolArray) -> Iterator[Run]:
    """Split points where the line, the road, its side or the direction along it changes."""
    if not len(line):
        return
    ds, dt = np.diff(places.s), np.diff(t)
    linked = (
        kept[1:]
        & kept[:-1]
        & (line[1:] == line[:-1])
        & (places.road[1:] == places.road[:-1])
        & (side[1:] == side[:-1])
        & (ds != 0.0)
        & (np.abs(dt) <= _SLOPE_MAX * np.abs(ds))
    )
    # Consecutive links in the same direction are one run.
    turn = np.sign(ds)
    begins = linked & ~np.concatenate([[False], linked[:-1] & (turn[1:] == turn[:-1])])
    stops = np.append(np.flatnonzero(begins | ~linked), len(linked))
    firsts = np.flatnonzero(begins)
    ends = stops[np.searchsorted(stops, firsts, side="right")]
    for first, end in zip(firsts.tolist(), ends.tolist(), strict=True):
        rows = slice(first, end + 1)
        s, lateral = places.s[rows], t[rows]
        if s[-1] < s[0]:
            s, lateral = s[::-1], lateral[::-1]
        if s[-1] - s[0] >= SHORTEST_RUN:
            yield Run(int(line[first]), int(places.road[first]), s, lateral, (first, end + 1))


def simplified(run: Run) -> Iterator[Strip]:
    """Yield a run as few strips as the tolerance allows."""
    for one, other in pairwise(_corners(run.s, run.t, 0, len(run.s) - 1)):
        length, ends = float(run.s[other] - run.s[one]), (float(run.t[one]), float(run.t[other]))
        yield Strip(run.line, run.road, float(run.s[one]), length, *ends)


def _staying_off(finder: RoadsideFinder, strips: Sequence[Strip], half_widths: Sequence[float]) -> list[Strip]:
    """Return the strips that stay off the carriageway where that widens between their points, too."""
    count = np.maximum(np.ceil([strip.length for strip in strips]).astype(np.int64), 1) + 1
    owner = repeated(count)
    share = ranks(count) / (count[owner] - 1)
    columns = ((strip.road, strip.s, strip.length, strip.t_start, strip.t_end) for strip in strips)
    road, s, length, start, end = (column[owner] for column in np.array([*columns]).reshape(-1, 5).T)
    left, right = finder.edges(road.astype(np.int64), s + share * length)
    t = start + share * (end - start)
    half = np.array([half_widths[strip.line] for strip in strips])
    on = np.maximum(t - left, right - t) < half[owner] - _ON_CARRIAGEWAY
    reaching = set(owner[on].tolist())
    return [strip for k, strip in enumerate(strips) if k not in reaching]


def object_along(
    world: World,
    strip: Strip,
    words: tuple[str, str, str],
    size: tuple[float, float],
    osm_id: str,
    lateral: float = 0.0,
    distance: float = 0.0,
) -> RoadObject:
    """Make an object of a type, subtype and name (words) along a strip of road.

    Size is its width and height; aside how far its middle lies to the left of the strip; distance that between round
    copies, 0 for one continuous object; all m.
    """
    width, height = size
    edges = strip.t_start + lateral, strip.t_end + lateral
    found = world.object_at(world.road_map.roads[strip.road].id, words, strip.s, edges[0], osm_id)
    repeat = ObjectRepeat(strip.s, strip.length, distance, *edges, width, height)
    if distance:
        return replace(found, height=height, radius=0.5 * width, repeat=repeat)
    return replace(found, length=strip.length, width=width, height=height, repeat=repeat)

"""What is done with a road map before it is written: checks, and other forms of what readers cannot take.

Tables must fit together, and nothing may get lost in the text.

**Flat arcs and spirals** become lines and arcs. CARLA goes to the centre of an arc and back
(``GeometryArc::PosFromDist``) in numbers of single precision: with a radius of 30,000 km the places along such a road
lie 2 m apart, with 1000 km still 3 cm beside it. esmini 3.6 (``Spiral`` in ``RoadManager.cpp``) and libOpenDRIVE 0.6
(``OpenDriveMap.cpp``) take curvatures, and changes of curvature, below 1e-6 / m for 0: a spiral is an arc or a line
then, or begins straight. The end of a nearly straight road of 784 m lay 5 cm aside.

**Shared exits.** Where several lanes of a road lead to one lane, SUMO's netconvert keeps the way whose road comes
first by its id as a text (measured with 1.28). If that one begins on a lane for buses, no car gets there any more.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final, NamedTuple, TypeAlias

import numpy as np

from osm2xodr.curves import advance, cube_root, cut_records, lengths, lines_that_go_on, owners, ranks, wrapped
from osm2xodr.errors import OutputError
from osm2xodr.model import (
    CAR_LANES,
    Connection,
    FloatArray,
    IntArray,
    LaneType,
    PlanView,
    Road,
    RoadLink,
    RoadMap,
    RoadObject,
    RoadStructure,
    Signal,
    SignalReference,
)
from osm2xodr.xodrWriter.formatting import Words

_Thing: TypeAlias = Signal | SignalReference | RoadObject | RoadStructure

_TABLES: Final = ("plan_view", "elevation", "superelevation", "lane_offset")
# Furniture may lie beyond a road's end by this, m: rounding. The writer puts it back onto the road.
_ROUNDING: Final = 1e-3

# Radius beyond which arcs become lines, m: numbers of single precision are 1.6 cm apart there.
LARGEST_RADIUS: Final = 200e3
# How far what is written may lie beside the curve, m; a choice. Headings of lines differ by less than 0.01 degrees.
_BESIDE: Final = 0.0007
# Curvatures that readers take for 0, 1/m, and a tenth more: what is written is rounded.
_STRAIGHT: Final = 1.1e-6
# Spirals that readers misplace by less stay as they are, and arcs lie no farther beside them, m. A choice.
_MISPLACED: Final = 1e-4
# Lines whose headings differ by less, rad, go on in the same direction. A choice: twice what ASAM's checker takes.
_SAME_HEADING: Final = 2e-6
# Where a part of a spiral is replaced, it is at least so long, m. A choice.
_SHORTEST: Final = 0.5

# What such a way is written as: nothing is driven on, but the surface stays.
_CLOSED = LaneType.SHOULDER


def check_road_map(road_map: RoadMap) -> FloatArray:
    """Check that a road map can be written, and return the lengths of its roads, m.

    Raises
    ------
    OutputError
        If tables and roads do not fit, numbers are not finite, roads have no length or no height, ids of roads and
        junctions repeat, or furniture does not stand on a road.
    """
    # Later checks rely on earlier ones.
    for defect in _table_defects(road_map):
        raise _error(defect)
    length = lengths(road_map.plan_view)
    for defect in _furniture_defects(road_map, length):
        raise _error(defect)
    return length


def _error(defect: str) -> OutputError:
    return OutputError(f"{defect}; this is a defect of osm2xodr, please report it with the area")


def _table_defects(road_map: RoadMap) -> Iterator[str]:
    """Yield what is wrong with roads and their tables."""
    count = len(road_map.roads)
    if count == 0:
        yield "there is no road to write"
    ids = [road.id for road in road_map.roads] + [junction.id for junction in road_map.junctions]
    if len(set(ids)) != len(ids) or min(ids) <= 0:
        yield "roads and junctions need ids of their own above 0"
    for name in _TABLES:
        start = getattr(road_map, name).start
        if len(start) != count + 1 or start[0] != 0 or (np.diff(start) < 0).any():
            yield "the tables of a road map do not fit its roads"
    for name in _TABLES:
        table = getattr(road_map, name)
        columns = [getattr(table, column) for column in type(table).__dataclass_fields__ if column != "start"]
        bad = np.flatnonzero(~np.logical_and.reduce([np.isfinite(column) for column in columns]))
        if len(bad):
            road = int(np.searchsorted(table.start, bad[0], side="right")) - 1
            yield f"{_road(road_map, road)} has a number that is not finite in its {name.replace('_', ' ')}"
    for table, what in ((road_map.plan_view, "geometry"), (road_map.elevation, "height")):
        empty = np.flatnonzero(np.diff(table.start) == 0)
        if len(empty):
            yield f"{_road(road_map, int(empty[0]))} has no {what}"
    if not (road_map.plan_view.length > 0.0).all() or not (lengths(road_map.plan_view) > 0.0).all():
        yield "a road or a piece of one has no length"


def _furniture_defects(road_map: RoadMap, length: FloatArray) -> Iterator[str]:
    """Yield what does not stand on a road, and controllers that the schema does not allow."""
    placed = road_map.furniture
    things: tuple[_Thing, ...] = (*placed.signals, *placed.references, *placed.objects, *placed.structures)
    length_of = dict(zip((road.id for road in road_map.roads), length.tolist(), strict=True)) if things else {}
    for thing in things:
        end = length_of.get(thing.road)
        if end is None:
            yield f"{_name(thing)} stands on road {thing.road}, which is not there"
            return
        places = [thing.s]
        if isinstance(thing, RoadObject) and thing.repeat is not None:
            places += [thing.repeat.s, thing.repeat.s + thing.repeat.length]
        elif isinstance(thing, RoadStructure):
            places.append(thing.s + thing.length)
        if not all(-_ROUNDING <= s <= end + _ROUNDING for s in places):
            yield f"{_name(thing)} does not stand within the {end:.3f} m of road {thing.road}: s {thing.s:.3f}"
    for controller in placed.controllers:
        if not controller.signals:
            yield f"controller {controller.id} has no signal"


def _road(road_map: RoadMap, index: int) -> str:
    """Name a road so that its origin can be found."""
    road = road_map.roads[index]
    ways = ", ".join(f"way/{way}" for way in road.osm_way_ids[:3])
    return f"road {road.id} ({ways})" if ways else f"road {road.id}"


def _name(thing: _Thing) -> str:
    """Name a thing so that its origin can be found."""
    if isinstance(thing, SignalReference):
        return f"a reference to signal {thing.signal}"
    if isinstance(thing, RoadStructure):
        return f"{thing.kind} {thing.id}"
    what = "signal" if isinstance(thing, Signal) else "object"
    return f"{what} {thing.id} ({thing.osm_id})" if thing.osm_id else f"{what} {thing.id}"


def without_flat_curves(plan: PlanView) -> PlanView:
    """Replace flat spirals by arcs, and arcs of large radii by lines."""
    out = _without_flat_arcs(_without_flat_spirals(plan))
    return plan if out is plan else _with_joined_lines(out)


def _without_flat_spirals(plan: PlanView) -> PlanView:
    """Replace spirals, or their first parts, that readers take for another curve by pairs of arcs.

    Two arcs of equal length, whose curvatures differ from the mean of the spiral by a third of its change, have the
    spiral's ends, its middle and its headings at the ends; in between they leave it by 1/324 of the change times the
    length squared.
    """
    part = _flat_part(plan)
    rows = np.flatnonzero(part)
    if not len(rows):
        return plan
    beside = np.abs(plan.rate[rows]) * part[rows] * np.square(part[rows]) / 324.0
    pairs = np.maximum(np.ceil(cube_root(beside / _MISPLACED)), 1.0).astype(np.int64)
    cuts = 2 * pairs - (part[rows] >= plan.length[rows])
    out = _cut_evenly(plan, rows, part[rows] / (2 * pairs), cuts)
    first = np.repeat(rows + np.cumsum(cuts) - cuts, pairs) + 2 * ranks(pairs)
    half, rate = out.length[first], out.rate[first]
    third = 2.0 * rate * half / 3.0
    mean = out.curvature[first] + rate * half
    x, y, hdg, curvature, rates = (item.copy() for item in (out.x, out.y, out.hdg, out.curvature, out.rate))
    curvature[first], curvature[first + 1] = mean - third, mean + third
    rates[first] = rates[first + 1] = 0.0
    start = x[first], y[first], hdg[first]
    x[first + 1], y[first + 1], hdg[first + 1] = advance(*start, curvature[first], half)
    return replace(out, x=x, y=y, hdg=hdg, curvature=curvature, rate=rates)


def _cut_evenly(plan: PlanView, rows: IntArray, every: FloatArray, cuts: IntArray) -> PlanView:
    """Cut records (n,) so many times each, at every so many metres from their starts."""
    return cut_records(plan, np.repeat(rows, cuts), np.repeat(every, cuts) * (ranks(cuts) + 1))


def _with_joined_lines(plan: PlanView) -> PlanView:
    """Make one line of lines that go on in the same direction: ASAM's checker calls them redundant."""
    goes_on = lines_that_go_on(plan, owners(plan.start), _SAME_HEADING)
    kept = np.flatnonzero(np.concatenate([[True], ~goes_on]))
    length = np.add.reduceat(plan.length, kept)
    more = wrapped(plan.hdg - np.repeat(plan.hdg[kept], np.diff(np.append(kept, len(plan.s)))))
    # From the first one's start to the last one's end.
    hdg = plan.hdg[kept] + np.add.reduceat(more * plan.length, kept) / length
    s, x, y, curvature, rate = (getattr(plan, name)[kept] for name in ("s", "x", "y", "curvature", "rate"))
    return PlanView(np.searchsorted(kept, plan.start), s, x, y, hdg, length, curvature, rate)


def _flat_part(plan: PlanView) -> FloatArray:
    """Return what readers misplace of each record, from its start on, (records,), m; 0 for nothing."""
    start, change = plan.curvature, plan.rate * plan.length
    straight = np.abs(start) < _STRAIGHT
    beside = np.where(np.abs(change) < _STRAIGHT, np.abs(change) / 6.0, 0.0)
    beside = np.maximum(beside, np.where(straight, np.abs(start) / 2.0, 0.0)) * plan.length**2
    # As far as curvature stays small; what is left then must change by more.
    with np.errstate(divide="ignore", invalid="ignore"):
        reached = np.maximum((np.copysign(_STRAIGHT, change) - start) / plan.rate, _SHORTEST)
    rest = np.abs(start + change) - _STRAIGHT
    whole = ~straight | (rest < _STRAIGHT)
    return np.where((plan.rate != 0.0) & (beside > _MISPLACED), np.where(whole, plan.length, reached), 0.0)


def _without_flat_arcs(plan: PlanView) -> PlanView:
    """Replace arcs of large radii by lines between places on them."""
    bent = (plan.rate == 0.0) & (plan.curvature != 0.0)
    flat = np.flatnonzero(bent & (np.abs(plan.curvature) * LARGEST_RADIUS < 1.0))
    if not len(flat):
        return plan
    count = np.ceil(plan.length[flat] * np.sqrt(np.abs(plan.curvature[flat]) / (8.0 * _BESIDE))).astype(np.int64)
    count = np.maximum(count, 1)
    out = _cut_evenly(plan, flat, plan.length[flat] / count, count - 1)
    lines = (out.rate == 0.0) & (np.abs(out.curvature) * LARGEST_RADIUS < 1.0)
    # Chords: the ends of arcs as flat as these lie less than a micrometre farther along the line.
    hdg = np.where(lines, out.hdg + 0.5 * out.curvature * out.length, out.hdg)
    return replace(out, hdg=hdg, curvature=np.where(lines, 0.0, out.curvature))


class _Way(NamedTuple):
    """A way through a junction from one lane to another."""

    entry: RoadLink
    exit: tuple[RoadLink, int | None]  # The road that it leads to, and the id of its lane
    for_all: bool  # Whether it begins on a lane for all
    lane: tuple[int, int]  # Ids of the connecting road and of its lane


def with_exits_for_all(road_map: RoadMap, words: Words) -> RoadMap:
    """Close ways from lanes for some to lanes that lanes for all lead to from the same road.

    They become shoulders. Lanes for some are those that `words` writes as lanes for all with an ``<access>``.
    """
    some = frozenset(kind for kind in LaneType if words.lane_users(kind.value))
    roads = {road.id: road for road in road_map.roads}
    closed: set[tuple[int, int]] = set()
    for junction in road_map.junctions if some else ():
        ways = [way for item in junction.connections for way in _ways(item, roads, some)]
        if all(way.for_all for way in ways):
            continue
        free = {(way.entry, way.exit) for way in ways if way.for_all}
        closed |= {way.lane for way in ways if not way.for_all and (way.entry, way.exit) in free}
    if not closed:
        return road_map
    changed = {road for road, _ in closed}
    made = [_with_closed(road, closed) if road.id in changed else road for road in road_map.roads]
    return replace(road_map, roads=tuple(made))


def _ways(connection: Connection, roads: Mapping[int, Road], some: frozenset[LaneType]) -> list[_Way]:
    """Return the ways of a connection that begin on lanes for vehicles."""
    road = roads[connection.connecting_road]
    entry, leaves = road.predecessor, road.successor
    if entry is None or leaves is None:
        return []
    before = roads[entry.id].lane_sections[0 if entry.at_start else -1]
    types = {lane.id: lane.type for lane in before.lanes}
    open_ = some | CAR_LANES
    return [
        _Way(entry, (leaves, _exit_lane(road, lane)), types[begin] not in some, (road.id, lane))
        for begin, lane in connection.lane_links
        if types.get(begin) in open_
    ]


def _exit_lane(road: Road, lane: int) -> int | None:
    """Return the lane that a lane of a connecting road leads to at its end."""
    found: int | None = lane
    for section in road.lane_sections:
        found = next((item.successor for item in section.lanes if item.id == found), None)
    return found


def _with_closed(road: Road, closed: set[tuple[int, int]]) -> Road:
    """Return a connecting road with some of its lanes, by (id of the road, id of the lane), closed."""
    sections = []
    ids = {lane for other, lane in closed if other == road.id}
    for section in road.lane_sections:
        lanes = [replace(lane, type=_CLOSED) if lane.id in ids else lane for lane in section.lanes]
        ids = {lane.successor for lane in section.lanes if lane.id in ids and lane.successor is not None}
        sections.append(replace(section, lanes=tuple(lanes)))
    return replace(road, lane_sections=tuple(sections))

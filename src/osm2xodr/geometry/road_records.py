"""Roads, connecting roads and junctions as records of a road map: ids, links, lane sections.

Roads also get the names that they have along them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from osm2xodr.curves import lengths, owners, part_of_cubics, smooth_cubic, sorted_unique, starts
from osm2xodr.geometry.connections import ConnectingRoads, InnerLane, Priorities
from osm2xodr.geometry.crossfall_lines import CrossfallLines, lane_offsets_beside, lane_widths_on
from osm2xodr.geometry.defaults import SHORTEST_NAME
from osm2xodr.geometry.junction_floor import Floor
from osm2xodr.geometry.junctions import JunctionLayout, RoadParts
from osm2xodr.geometry.lanes import NO_MARK, LaneLayout
from osm2xodr.geometry.roadside import SidewalkEnds, has_width, inner_width
from osm2xodr.model import (
    VEHICLE_LANES,
    Access,
    Connection,
    Cubic,
    CubicProfile,
    Direction,
    IntArray,
    Junction,
    Lane,
    LaneSection,
    LaneType,
    Road,
    RoadLink,
    RoadMap,
    RoadMark,
    RoadName,
    RoadType,
    Rule,
    StreetNetwork,
)

# A name that changes nearer than this to where lanes change does so there, m: half a dash, and no sliver is left.
_AT_SECTION: Final = 1.5


class RoadIds:
    """Ids in OpenDRIVE, from 1 in one range: roads, then connecting roads, then junctions.

    Road end number 2 k is the start of road k, 2 k + 1 its end.
    """

    def __init__(self, roads: int, connecting: int) -> None:
        self._roads, self._connecting = roads, connecting

    def road(self, index: int) -> int:
        """Return the id of a road outside junctions."""
        return index + 1

    def connecting(self, index: int) -> int:
        """Return the id of a connecting road."""
        return self._roads + index + 1

    def junction(self, index: int) -> int:
        """Return the id of a junction."""
        return self._roads + self._connecting + index + 1

    def link(self, end: int) -> RoadLink:
        """Return the link to a road end."""
        return RoadLink(False, self.road(end // 2), end % 2 == 0)

    def driven_junctions(self, layout: JunctionLayout, connecting: ConnectingRoads) -> IntArray:
        """Return the ids of junctions, -1 for those that nobody drives through and at the end, (junctions + 1,)."""
        out = np.full(len(layout.nodes) + 1, -1, np.int64)
        driven = sorted_unique(connecting.junction)
        out[driven] = [self.junction(junction) for junction in driven.tolist()]
        return out


# ---------------------------------------------------------------- roads outside junctions


def road_records(
    parts: RoadParts,
    lanes: Sequence[LaneLayout],
    connecting: ConnectingRoads,
    ids: RoadIds,
    guesses: Mapping[int, frozenset[str]],
    head_on: Mapping[int, int],
) -> list[Road]:
    """Return the roads outside junctions; `guesses` says what was guessed about OSM's ways.

    Ends that meet `head_on` are linked as roads, but none of their lanes is.
    """
    beyond, touching = _links(parts, connecting, ids, head_on), parts.end_link.ravel().tolist()
    out: list[Road] = []
    for k, layout in enumerate(lanes):
        stretches = parts.stretches[k]
        longest = max(stretches, key=lambda item: item.end - item.start) if len(stretches) > 1 else stretches[0]
        ways = dict.fromkeys(way for item in stretches for way in item.ways)
        before, after = (_lanes_at(end, lanes, parts) for end in touching[2 * k : 2 * k + 2])
        out.append(
            Road(
                id=ids.road(k),
                name=longest.attributes.name or longest.attributes.ref,
                junction=None,
                predecessor=beyond[2 * k],
                successor=beyond[2 * k + 1],
                types=layout.types,
                lane_sections=_linked(layout.sections, float(parts.length[k]), before, after),
                osm_way_ids=tuple(ways),
                guesses=guesses_about(ways, guesses),
                names=road_names(parts, k, layout.sections, guesses),
            )
        )
    return out


def _links(
    parts: RoadParts, connecting: ConnectingRoads, ids: RoadIds, head_on: Mapping[int, int]
) -> list[RoadLink | None]:
    """Return what lies beyond each road end; a junction only if one can drive into it or out of it there."""
    driven = set(connecting.entry.tolist()) | set(connecting.exit.tolist())
    out: list[RoadLink | None] = []
    for end, junction in enumerate(parts.end_junction.ravel().tolist()):
        other = head_on.get(end, int(parts.end_link[end // 2, end % 2]))
        if junction >= 0 and end in driven:
            out.append(RoadLink(True, ids.junction(junction)))
        else:
            out.append(ids.link(other) if other >= 0 else None)
    return out


def _lanes_at(end: int, lanes: Sequence[LaneLayout], parts: RoadParts) -> dict[int, LaneType] | None:
    """Return the types by id of the lanes at an end with which another road goes on (halves of a ring or loop)."""
    if end < 0:
        return None
    sections = lanes[end // 2].sections
    if end % 2 == 0:
        return _with_width(sections[0], 0.0)
    return _with_width(sections[-1], float(parts.length[end // 2]) - sections[-1].s)


def _with_width(section: LaneSection, s: float) -> dict[int, LaneType]:
    """Return the types by id of the lanes of a section that have any width at a place of it, m."""
    return {lane.id: lane.type for lane in section.lanes if lane.id and has_width(lane.widths, s)}


def _linked(
    sections: tuple[LaneSection, ...],
    length: float,
    before: Mapping[int, LaneType] | None,
    after: Mapping[int, LaneType] | None,
) -> tuple[LaneSection, ...]:
    """Link lanes of a road of some length to those of the same id and type beyond its ends.

    ASAM OpenDRIVE 1.7, 11.6: a lane without width at the border of its section has no link beyond it.
    """
    out = list(sections)
    if before is not None:
        same = before.items() & _with_width(out[0], 0.0).items()
        lanes = (replace(a, predecessor=a.id if (a.id, a.type) in same else None) for a in out[0].lanes)
        out[0] = LaneSection(out[0].s, tuple(lanes))
    if after is not None:
        same = after.items() & _with_width(out[-1], length - out[-1].s).items()
        lanes = (replace(a, successor=a.id if (a.id, a.type) in same else None) for a in out[-1].lanes)
        out[-1] = LaneSection(out[-1].s, tuple(lanes))
    return tuple(out)


# ---------------------------------------------------------------- connecting roads


def connecting_road_records(
    connecting: ConnectingRoads,
    parts: RoadParts,
    lanes: Sequence[LaneLayout],
    ids: RoadIds,
    rule: Rule,
    lines: CrossfallLines,
    marks: Mapping[int, tuple[RoadMark, RoadMark]],
) -> list[Road]:
    """Return the roads through junctions, some on `lines`; those with equal lanes share their lane sections.

    `marks` has those on the inner and the outer edges of lanes, by the roads' indices.
    """
    links = {end: ids.link(end) for end in sorted_unique([connecting.entry, connecting.exit]).tolist()}
    types = _types_between(connecting, parts, lanes)
    known: dict[tuple[object, ...], tuple[LaneSection, ...]] = {}
    columns = (
        connecting.junction,
        connecting.entry,
        connecting.exit,
        connecting.entry_lane,
        connecting.exit_lane,
        connecting.entry_width,
        connecting.exit_width,
        connecting.change_start(),
        connecting.length,
        _own_lanes(connecting, rule),
        connecting.height,
    )
    out: list[Road] = []
    widths, unmarked = lane_widths_on(lines, connecting), (NO_MARK, NO_MARK)
    rows = zip(*(column.tolist() for column in columns), strict=True)
    for k, (junction, entry, exit_, lane_in, lane_out, w0, w1, start, length, own, height) in enumerate(rows):
        inner, outermost = connecting.inner[k], (connecting.lane_type[k], w0, w1, height, lane_in, lane_out)
        tapers = w0 != w1 or (inner and any(item.entry_width != item.exit_width for item in inner))
        kind, width, edges = types[entry, exit_], widths.get(k), marks.get(k, unmarked)
        rest = (start, length) if tapers else (0.0, 0.0), kind[0].speed, connecting.access[k]
        key = own, inner, outermost, rest, width, None if edges is unmarked else edges
        sections = known.get(key)
        if sections is None:
            across = (*reversed(inner), InnerLane(*outermost))
            sections = known[key] = _lanes_through(own, across, *rest, width, edges)
        ends = links[entry], links[exit_]
        out.append(Road(ids.connecting(k), "", ids.junction(junction), *ends, kind, sections, ()))
    return out


def _types_between(
    connecting: ConnectingRoads, parts: RoadParts, lanes: Sequence[LaneLayout]
) -> dict[tuple[int, int], tuple[RoadType, ...]]:
    """Return the road types between road ends: that of the entry, with the lower one of both speed limits."""
    pairs = dict.fromkeys(zip(connecting.entry.tolist(), connecting.exit.tolist(), strict=True))
    at = {end: parts.at_end(end).attributes for end in {end for pair in pairs for end in pair}}
    shared: dict[tuple[str, float | None], tuple[RoadType, ...]] = {}
    out: dict[tuple[int, int], tuple[RoadType, ...]] = {}
    for entry, exit_ in pairs:
        limits = (
            at[entry].speed_along(Direction.FORWARD if entry % 2 else Direction.BACKWARD),
            at[exit_].speed_along(Direction.BACKWARD if exit_ % 2 else Direction.FORWARD),
        )
        speed = min((limit for limit in limits if limit is not None), default=None)
        key = lanes[entry // 2].types[-1 if entry % 2 else 0].type, speed
        out[entry, exit_] = shared.setdefault(key, (RoadType(0.0, *key),))
    return out


def _own_lanes(connecting: ConnectingRoads, rule: Rule) -> IntArray:
    """Return the id of each connecting road's lane, (n,); others lie between a sidewalk and the carriageway."""
    usual = -1 if rule is Rule.RIGHT_HAND else 1
    side: IntArray = np.where(connecting.against, -usual, usual)
    return side * np.array([len(lanes) + 1 for lanes in connecting.inner], np.int64)


def _lanes_through(
    own: int,
    across: tuple[InnerLane, ...],
    change: tuple[float, float],
    speed: float | None,
    access: Access,
    widths: tuple[Cubic, ...] | None,
    edges: tuple[RoadMark, RoadMark],
) -> tuple[LaneSection, ...]:
    """Return the lane section of a connecting road, with lanes from its reference line to the one that it is for.

    Lanes change their width from one s to the other of `change`, m. `speed` (m/s) is the limit of those for vehicles;
    `access` and `widths` are those of the lane that it is for; without the latter its width is blended. `edges` are
    the marks on the reference line and on that lane's outer edge.
    """
    side = 1 if own > 0 else -1
    lanes = [
        Lane(
            side * number,
            item.type,
            widths or _blend(*change, item.entry_width, item.exit_width),
            item.entry_lane,
            item.exit_lane,
            edges[1] if number == abs(own) else NO_MARK,
            speed=speed if item.type in VEHICLE_LANES else None,
            height=item.height,
            access=access if number == abs(own) else Access.ALL,
        )
        for number, item in enumerate(across, start=1)
    ]
    centre = Lane(0, LaneType.NONE, (), road_mark=edges[0])
    return (LaneSection(0.0, (centre, *lanes) if own < 0 else (*reversed(lanes), centre)),)


def with_floor(road_map: RoadMap, first: int, floor: Floor, ends: SidewalkEnds) -> RoadMap:
    """Return a road map with the floor of junctions beside connecting roads, which begin at road number `first`.

    Sidewalks end beside lanes as well, up to two of them beside one edge; what the floor covers of them is left out.
    """
    roads = list(road_map.roads)
    length = lengths(road_map.plan_view)
    # Both types of the floor are as high as the lanes for cars beside them (ASAM OpenDRIVE 1.8, 11.7.1).
    beside: dict[tuple[int, int], list[tuple[LaneType, tuple[Cubic, ...], float]]] = {
        (k, side): [(LaneType.SHOULDER if k in paved else LaneType.BORDER, strip, 0.0)]
        for side, widths, paved in ((1, floor.left, floor.paved_left), (-1, floor.right, floor.paved_right))
        for k, strip in widths.items()
    }
    for item, (k, side) in enumerate(zip(ends.row.tolist(), ends.side.tolist(), strict=True)):
        covered = (floor.left if side > 0 else floor.right).get(k, ())
        beside.setdefault((k, side), []).extend(ends.lanes(item, float(length[first + k]), covered))
    for k in sorted({k for k, _ in beside}):
        road = roads[first + k]
        section = road.lane_sections[0]
        outer = [
            [
                Lane(lane + side * number, kind, widths, road_mark=NO_MARK, height=height)
                for number, (kind, widths, height) in enumerate(beside.get((k, side), ()), start=1)
            ]
            for lane, side in ((section.lanes[0].id, 1), (section.lanes[-1].id, -1))
        ]
        section = LaneSection(section.s, (*reversed(outer[0]), *section.lanes, *outer[1]))
        roads[first + k] = replace(road, lane_sections=(section,))
    return replace(road_map, roads=tuple(roads))


def with_bicycles_among_cars(road_map: RoadMap, first: int, connecting: ConnectingRoads) -> RoadMap:
    """Return a road map in whose junctions bicycle lanes are for cars from where they widen to a lane of these.

    Connecting roads begin at road number `first`.
    """
    roads = list(road_map.roads)
    start = connecting.change_start()
    for k in np.flatnonzero(connecting.leads_among_cars()).tolist():
        road = roads[first + k]
        sections = _halves(road.lane_sections[0], float(start[k]), road.types[0].speed)
        roads[first + k] = replace(road, lane_sections=sections)
    return replace(road_map, roads=tuple(roads))


def _halves(section: LaneSection, s: float, speed: float | None) -> tuple[LaneSection, LaneSection]:
    """Cut a road's only section at s, m; lanes for bicycles are for cars behind, with a speed limit, m/s."""
    before, behind = [], []
    for lane in section.lanes:
        beyond = lane
        if lane.type is LaneType.BIKING and lane.successor is not None:
            beyond = replace(lane, type=LaneType.DRIVING, speed=speed)
        # A lane of width 0 where sections touch has no link (ASAM OpenDRIVE 1.7, 11.6).
        link = lane.id if lane.id and has_width(lane.widths, s) else None
        before.append(replace(lane, widths=part_of_cubics(lane.widths, 0.0, s), successor=link))
        behind.append(replace(beyond, widths=part_of_cubics(lane.widths, s, np.inf), predecessor=link))
    return LaneSection(0.0, tuple(before)), LaneSection(s, tuple(behind))


def _blend(begin: float, end: float, before: float, after: float) -> tuple[Cubic, ...]:
    """Return cubics of what changes between two places in a smooth step, from s = 0 on."""
    if before == after:
        return (Cubic(0.0, before),)
    step = smooth_cubic(begin, end - begin, before, after)
    return (Cubic(0.0, before), step) if begin > 0.0 else (step,)


def connecting_lane_offsets(connecting: ConnectingRoads, rule: Rule, lines: CrossfallLines) -> CubicProfile:
    """Return the lane offsets that put a connecting road's lane around its reference line, or beside it."""
    n = len(connecting.length)
    side = -0.5 * np.sign(_own_lanes(connecting, rule))
    inner = inner_width(connecting)
    start = side * (connecting.entry_width + 2 * inner[0]) + connecting.entry_aside
    end = side * (connecting.exit_width + 2 * inner[1]) + connecting.exit_aside
    bent = np.flatnonzero(start != end)
    begin = np.zeros(n)
    begin[bent] = connecting.change_start()[bent]
    columns = (column[bent].tolist() for column in (connecting.length - begin, start, end))
    steps = [smooth_cubic(0.0, *values) for values in zip(*columns, strict=True)]
    # Where it begins to change behind the start, a record before it holds until then.
    first = starts(1 + (begin > 0.0))
    row = owners(first)
    s, c, d = np.zeros(len(row)), np.zeros(len(row)), np.zeros(len(row))
    changing = first[1:] - 1
    s[changing] = begin
    c[changing[bent]], d[changing[bent]] = [step.c for step in steps], [step.d for step in steps]
    usual = CubicProfile(first, s, start[row], np.zeros(len(row)), c, d)
    if not len(lines.row):
        return usual
    return lane_offsets_beside(lines, connecting, 2.0 * side, usual)


# ---------------------------------------------------------------- junctions


def junction_records(
    network: StreetNetwork, layout: JunctionLayout, connecting: ConnectingRoads, priorities: Priorities, ids: RoadIds
) -> tuple[Junction, ...]:
    """Return the junctions that somebody drives or walks through, in the order of their first connecting road."""
    own = _own_lanes(connecting, network.rule).tolist()
    junction_of = connecting.junction.tolist()
    pairs: dict[int, list[tuple[int, int]]] = {}
    for high, low in zip(priorities.high.tolist(), priorities.low.tolist(), strict=True):
        pairs.setdefault(junction_of[high], []).append((ids.connecting(high), ids.connecting(low)))
    entry, entry_lane, inner = connecting.entry.tolist(), connecting.entry_lane.tolist(), connecting.inner
    rows: dict[int, list[int]] = {}
    for k, junction in enumerate(junction_of):
        rows.setdefault(junction, []).append(k)
    out: list[Junction] = []
    for junction, group in rows.items():
        connections = tuple(
            Connection(
                number, ids.road(entry[k] // 2), ids.connecting(k), _lane_links(entry_lane[k], own[k], inner[k])
            )
            for number, k in enumerate(group)
        )
        nodes = tuple(network.intersections[node].osm_node_id for node in layout.nodes[junction])
        yielding = tuple(sorted(pairs.get(junction, ())))
        out.append(Junction(ids.junction(junction), "", connections, nodes, yielding))
    return tuple(out)


def _lane_links(entry_lane: int, own: int, inner: tuple[InnerLane, ...]) -> tuple[tuple[int, int], ...]:
    """Return (lane of the incoming road, lane of the connecting road), the lane that it is for first."""
    side = 1 if own > 0 else -1
    rest = [(item.entry_lane, own - side * k) for k, item in enumerate(inner, start=1) if item.entry_lane is not None]
    return ((entry_lane, own), *rest)


def guesses_about(ways: Iterable[int], guesses: Mapping[int, frozenset[str]]) -> tuple[str, ...]:
    """Return the codes of the guesses about ways, in ascending order."""
    return tuple(sorted(frozenset[str]().union(*(guesses.get(way, ()) for way in ways))))


def road_names(
    parts: RoadParts, road: int, sections: Sequence[LaneSection], guesses: Mapping[int, frozenset[str]]
) -> tuple[RoadName, ...]:
    """Return the names along a road by its index, none where it has one alone; short pieces bear a neighbour's."""
    pieces = parts.fitted.pieces[int(parts.street[road])]
    if len(pieces) == 1:
        return ()
    begin, length = float(parts.begin[road]), float(parts.length[road])
    starts_at = [s - begin for s, _, _ in pieces]
    ends_at = [*starts_at[1:], np.inf]
    # (begin, name and number, ways) of each name
    found: list[tuple[float, tuple[str, str], list[int]]] = []
    for (_, item, _), start, end in zip(pieces, starts_at, ends_at, strict=True):
        lower, upper = max(start, 0.0), min(end, length)
        if upper <= lower:
            continue
        said = (item.name, item.ref)
        if len(found) == 1 and lower < SHORTEST_NAME:
            found[0] = (0.0, said, [*found[0][2], item.osm_way_id])
        elif not found or (found[-1][1] != said and upper - lower >= SHORTEST_NAME):
            found.append((lower if found else 0.0, said, [item.osm_way_id]))
        else:
            found[-1][2].append(item.osm_way_id)
    if len(found) < 2:
        return ()
    borders = np.array([section.s for section in sections])
    out: list[RoadName] = []
    for s, (name, ref), ways in found:
        near = float(borders[np.argmin(np.abs(borders - s))])
        place = near if abs(near - s) < _AT_SECTION else s
        out.append(RoadName(place, name or ref, tuple(dict.fromkeys(ways)), guesses_about(ways, guesses)))
    return tuple(out)

"""Lanes where roads meet: every step from a lane to a lane of the next road, and what is wrong with it.

Gaps, steps and kinks at links, wrong ends and directions, lanes and links that lead nowhere.
"""

from __future__ import annotations

import numpy as np

from osm2xodr.checking.checks.common import LaneIndex, above, degrees, end_station, lane_place, road_place
from osm2xodr.checking.checks.references import ENDS, connection_name
from osm2xodr.checking.findings import GAP_ERROR, TAPERED_WIDTH, Findings
from osm2xodr.curves import Table, owners, sorted_unique
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, End, LinkKind, OpenDrive, grade, lane_borders, pose, surface_points
from osm2xodr.system import record

_PERCENT = 100.0
# The reference line of the other road may lie on either side of the carriageway. An end touches if it is nearer than
# this share of the other road's length; and than `GAP_ERROR`.
_TOUCHING_SHARE = 0.1


@record
class _LaneEnds:
    """Lanes at ends of their roads."""

    # (n, 3) Points of the borders, m
    inner: FloatArray
    outer: FloatArray
    hdg: FloatArray  # (n,) Heading of traffic, rad
    grade: FloatArray  # (n,) In the direction of traffic, rise per metre


def _lane_ends(drive: OpenDrive, lanes: LaneIndex, lane: IntArray, end: IntArray) -> _LaneEnds:
    """Return the ends of lanes, (n,)."""
    out = _LaneEnds(np.empty((len(lane), 3)), np.empty((len(lane), 3)), np.empty(len(lane)), np.empty(len(lane)))
    for side in (End.START, End.END):
        at = np.flatnonzero(end == side)
        row, road = lane[at], lanes.road[lane[at]]
        s, before = end_station(drive, road, side), side == End.END
        inner, outer = lane_borders(drive, row, s, before=before)
        for points, t in ((out.inner, inner), (out.outer, outer)):
            points[at] = np.column_stack(surface_points(drive, road, s, t, before=before))
        out.hdg[at] = pose(drive, road, s, before=before)[2]
        out.grade[at] = grade(drive, road, s, before=before)
    back = ~lanes.forward[lane]
    out.hdg[back] += np.pi
    out.grade[back] *= -1
    return out


def check_links(drive: OpenDrive, lanes: LaneIndex, steps: Transitions, findings: Findings) -> None:
    """Check every link from lane to lane."""
    a, b = steps.lane_a, steps.lane_b

    def add(rule: str, row: IntArray, value: FloatArray | None = None) -> None:
        if value is not None:
            row = row[above(rule, value[row])]
        lane = a[row]
        findings.add(
            rule,
            road=lanes.road[lane],
            lane=drive.lanes.id[lane],
            s=end_station(drive, lanes.road[lane], steps.end_a[row]),
            value=None if value is None else value[row],
            line=steps.line[row],
            other=lambda k: _lane_name(drive, lanes, int(b[row[k]])),
        )

    one, other = _lane_ends(drive, lanes, a, steps.end_a), _lane_ends(drive, lanes, b, steps.end_b)
    leaves = lanes.forward[a] == (steps.end_a == End.END)
    enters = lanes.forward[b] == (steps.end_b == End.START)
    inner, outer = one.inner - other.inner, one.outer - other.outer
    edge = np.maximum(np.hypot(inner[:, 0], inner[:, 1]), np.hypot(outer[:, 0], outer[:, 1]))
    height = np.maximum(np.abs(inner[:, 2]), np.abs(outer[:, 2]))
    # A grade changes its sign with the direction of travel, and so it does where a link leads against traffic.
    grade_step = np.abs(one.grade - np.where(leaves == enters, other.grade, -other.grade))
    driving = np.flatnonzero(lanes.driving[a])
    add("lane-gap", driving, np.hypot(*((inner + outer) / 2)[:, :2].T))
    add("lane-edge-gap", driving, edge)
    add("lane-height-step", driving, height)
    add("link-kink", driving, degrees(one.hdg - other.hdg))
    add("link-grade-step", driving, _PERCENT * grade_step)
    # Centre lanes have no width.
    add("side-lane-gap", np.flatnonzero(~lanes.driving[a] & (drive.lanes.id[a] != 0)), np.maximum(edge, height))
    one_way = lanes.driving[a] & lanes.driving[b] & ~lanes.both_ways[a] & ~lanes.both_ways[b]
    add("lane-link-other-way", np.flatnonzero((leaves != enters) & one_way))
    _check_road_contacts(drive, findings)
    _check_connection_contacts(drive, findings)


def _lane_name(drive: OpenDrive, lanes: LaneIndex, lane: int) -> str:
    return f"lane {drive.lanes.id[lane]} of road {drive.roads.id[int(lanes.road[lane])]}"


def _check_road_contacts(drive: OpenDrive, findings: Findings) -> None:
    """Check for links of roads that name the wrong end of the other road: the end that they do not name touches."""
    roads = drive.roads
    stated = (roads.link_kind == LinkKind.ROAD) & (roads.link != ABSENT) & (roads.contact != End.UNSAID)
    road, end = np.nonzero(stated)
    other, contact = roads.link[road, end], roads.contact[road, end]
    x, y, _ = pose(drive, road, end_station(drive, road, end))
    gap = []
    for side in (contact, 1 - contact):
        at_x, at_y, _ = pose(drive, other, end_station(drive, other, side))
        gap.append(np.hypot(at_x - x, at_y - y))
    touching = gap[1] <= np.minimum(_TOUCHING_SHARE * roads.length[other], GAP_ERROR)
    bad = np.flatnonzero(touching & above("wrong-contact-point", gap[0]))
    findings.add(
        "wrong-contact-point",
        value=gap[0][bad],
        other=lambda k: f"the road's link to road {roads.id[int(other[bad[k]])]}",
        **road_place(drive, road[bad], end_station(drive, road[bad], end[bad])),
    )


def _check_connection_contacts(drive: OpenDrive, findings: Findings) -> None:
    """Check whether connections name that end of the connecting road at which it names the incoming road."""
    roads, table = drive.roads, drive.connections
    row = np.flatnonzero((table.incoming != ABSENT) & (table.connecting != ABSENT) & (table.contact != End.UNSAID))
    links = roads.link[table.connecting[row]] == table.incoming[row][:, None]
    links &= roads.link_kind[table.connecting[row]] == LinkKind.ROAD
    named = np.where(links[:, 0], 0, 1)
    wrong = row[(links.sum(1) == 1) & (named != table.contact[row])]
    road = table.connecting[wrong]
    far = end_station(drive, road, table.contact[wrong])
    near = end_station(drive, road, 1 - table.contact[wrong])
    gap = np.hypot(*(pose(drive, road, far)[k] - pose(drive, road, near)[k] for k in (0, 1)))
    findings.add(
        "wrong-contact-point",
        road=road,
        s=far,
        value=gap,
        line=table.line[wrong],
        other=lambda k: f"the connection from road {roads.id[int(table.incoming[wrong[k]])]}",
    )


def check_ways_on(drive: OpenDrive, lanes: LaneIndex, steps: Transitions, findings: Findings) -> None:
    """Check for lanes that lead nowhere although their road goes on."""
    if not findings.wants("dead-lane", "dead-end-junction", "unfed-lane", "lane-ends"):
        return
    exits = _exits(drive, lanes)
    linked = _used_lanes(len(drive.lanes.id), steps, ~steps.incoming)
    connected = _used_lanes(len(drive.lanes.id), steps, steps.incoming)
    table, roads = drive.lanes, drive.roads
    for end in (End.START, End.END):
        row = np.flatnonzero(lanes.is_outermost(table.section, end) & lanes.driving & ~lanes.both_ways)
        road = lanes.road[row]
        s = end_station(drive, road, end)
        width = _widths(drive, row, s, before=end == End.END)
        leaves = lanes.forward[row] == (end == End.END)
        kind, known = roads.link_kind[road, end], roads.link[road, end] != ABSENT
        at_junction = (width > TAPERED_WIDTH) & (kind == LinkKind.JUNCTION) & known
        # Connections lead into a junction, the links of connecting roads lead out of it.
        stuck = at_junction & leaves & ~connected[row, end]
        unfed = at_junction & ~leaves & ~linked[row, end]
        # Turning round into the road one comes from does not count.
        others = exits[road, end] > 0
        for rule, which in (
            ("dead-lane", stuck & others),
            ("dead-end-junction", stuck & ~others),
            ("unfed-lane", unfed),
        ):
            _add_ends(rule, drive, lanes, row[which], s[which], None, findings)
        at_road = leaves & (kind == LinkKind.ROAD) & known
        _check_lane_ends(drive, lanes, row, at_road, (linked | connected)[row, end], width, s, findings)
    _check_inner_ends(drive, lanes, findings)


def _exits(drive: OpenDrive, lanes: LaneIndex) -> IntArray:
    """Return how many other ends of roads lead out of the junction at each end of a road, (roads, 2)."""
    roads = drive.roads
    leads = np.zeros((len(roads.id), 2), bool)
    for end in (End.START, End.END):
        enters = lanes.both_ways | (lanes.forward == (end == End.START))
        leads[lanes.road[lanes.is_outermost(drive.lanes.section, end) & lanes.driving & enters], end] = True
    at_junction = (roads.link_kind == LinkKind.JUNCTION) & (roads.link != ABSENT)
    junction = np.where(at_junction, roads.link, 0)
    leads &= at_junction
    count = np.bincount(junction[leads], minlength=max(len(drive.junctions.id), 1))
    return np.asarray(np.where(at_junction, count[junction] - leads, 0), np.int64)


def _used_lanes(count: int, steps: Transitions, which: BoolArray) -> BoolArray:
    """Return which lanes some steps link, and at which ends of their roads, (lanes, 2)."""
    used = np.zeros((count, 2), bool)
    used[steps.lane_a[which], steps.end_a[which]] = True
    used[steps.lane_b[which], steps.end_b[which]] = True
    return used


def _widths(drive: OpenDrive, lane: IntArray, s: FloatArray, *, before: bool) -> FloatArray:
    """Return the widths of lanes at s, (n,), m."""
    inner, outer = lane_borders(drive, lane, s, before=before)
    return np.asarray(np.abs(outer - inner))


def _add_ends(
    rule: str,
    drive: OpenDrive,
    lanes: LaneIndex,
    lane: IntArray,
    s: FloatArray,
    value: FloatArray | None,
    findings: Findings,
) -> None:
    """Add findings about ends of lanes."""
    at = zip(lanes.road[lane].tolist(), (s > 0).tolist(), strict=True)
    ids = [drive.roads.link_id[road][end] for road, end in at]
    findings.add(rule, value=value, other=ids, **lane_place(drive, lanes, lane, s))


def _check_lane_ends(
    drive: OpenDrive,
    lanes: LaneIndex,
    row: IntArray,
    goes_on: BoolArray,
    used: BoolArray,
    width: FloatArray,
    s: FloatArray,
    findings: Findings,
) -> None:
    """Check for groups of lanes of one section and direction of which none goes on although the road does."""
    group = drive.lanes.section[row] * 2 + lanes.forward[row]
    alive = sorted_unique(group[used])
    bad = np.flatnonzero(goes_on & ~used & above("lane-ends", width) & ~np.isin(group, alive))
    _add_ends("lane-ends", drive, lanes, row[bad], s[bad], width[bad], findings)


def _check_inner_ends(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Check for such groups where one lane section follows another."""
    table, sections = drive.lanes, drive.sections
    for end, ids in ((End.START, table.predecessor), (End.END, table.successor)):
        leaves = lanes.forward == (end == End.END)
        inner = ~lanes.is_outermost(table.section, end)
        row = np.flatnonzero(inner & leaves & lanes.driving & ~lanes.both_ways)
        s = (sections.end if end == End.END else sections.s)[table.section[row]]
        width = _widths(drive, row, s, before=end == End.END)
        goes_on = np.ones(len(row), bool)
        _check_lane_ends(drive, lanes, row, goes_on, ids[row] != ABSENT, width, s, findings)


@record
class Transitions(Table):
    """Steps across ends of roads: from a lane (a) at an end of its road to another (b) at an end of its own."""

    # (n,) Rows of lanes
    lane_a: IntArray
    lane_b: IntArray
    # (n,) `End` of their roads
    end_a: IntArray
    end_b: IntArray
    incoming: BoolArray  # (n,) Whether a connection of a junction states the step, and not the road itself
    line: IntArray  # (n,) Of the file


def transitions(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> Transitions:
    """Return all steps, and add findings about links and connections that lead nowhere."""
    links = ((End.START, drive.lanes.predecessor), (End.END, drive.lanes.successor))
    for end, ids in links:
        _check_section_links(drive, lanes, end, ids, findings)
    backwards, forwards = (_road_steps(drive, lanes, end, ids, findings) for end, ids in links)
    return backwards.joined(forwards, _connection_steps(drive, lanes, findings))


def _check_section_links(drive: OpenDrive, lanes: LaneIndex, end: End, ids: IntArray, findings: Findings) -> None:
    """Check links from section to section of a road."""
    table, sections = drive.lanes, drive.sections
    several = np.diff(sections.start)[lanes.road] > 1
    row = np.flatnonzero(several & ~lanes.is_outermost(table.section, end) & (ids != ABSENT))
    lost = row[lanes.find(table.section[row] + (1 if end else -1), ids[row]) < 0]
    findings.add(
        "lane-link",
        other=lambda k: f"{ENDS[end]} is lane {ids[lost[k]]} of the neighbouring section",
        **lane_place(drive, lanes, lost, (sections.end if end else sections.s)[table.section[lost]]),
    )


def _road_steps(drive: OpenDrive, lanes: LaneIndex, end: End, ids: IntArray, findings: Findings) -> Transitions:
    """Return the steps that lanes themselves name at an end of their roads."""
    roads, table = drive.roads, drive.lanes
    linked = (roads.link_kind[:, end] == LinkKind.ROAD) & (roads.link[:, end] != ABSENT)
    row = np.flatnonzero(lanes.is_outermost(table.section, end) & linked[lanes.road] & (ids != ABSENT))
    road = lanes.road[row]
    other = roads.link[road, end]
    contact = np.maximum(roads.contact[road, end], 0)
    section = lanes.end_section(other, contact)
    to = lanes.find(section, ids[row])
    lost = np.flatnonzero((to < 0) & (section >= 0))
    findings.add(
        "lane-link",
        other=lambda k: f"{ENDS[end]} is lane {ids[row[lost[k]]]} of road {roads.id[int(other[lost[k]])]}",
        **lane_place(drive, lanes, row[lost], end_station(drive, road[lost], end)),
    )
    good = to >= 0
    n = int(good.sum())
    return Transitions(row[good], to[good], np.full(n, end), contact[good], np.zeros(n, bool), table.line[row[good]])


def _connection_steps(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> Transitions:
    """Return steps from incoming roads into junctions."""
    table = drive.connections
    _check_connections(drive, findings)
    row = np.flatnonzero((table.incoming != ABSENT) & (table.connecting != ABSENT))
    contact = np.maximum(table.contact, 0)
    end = np.full(len(table.junction), -1, np.int64)
    end[row] = _incoming_end(drive, row, contact[row])
    # Roads go on through virtual junctions instead of ending there.
    away = row[(end[row] < 0) & ~_is_virtual(drive)[row]]
    findings.add(
        "incoming-elsewhere",
        road=table.incoming[away],
        line=table.line[away],
        other=lambda k: connection_name(drive, int(away[k])),
    )
    owner = owners(table.link_start)
    link = np.flatnonzero(end[owner] >= 0)
    owner = owner[link]
    section_a = lanes.end_section(table.incoming[owner], end[owner])
    section_b = lanes.end_section(table.connecting[owner], contact[owner])
    lane_a = lanes.find(section_a, table.link_from[link])
    lane_b = lanes.find(section_b, table.link_to[link])
    lost = np.flatnonzero(((lane_a < 0) | (lane_b < 0)) & (section_a >= 0) & (section_b >= 0))
    findings.add(
        "connection-lane",
        road=table.incoming[owner[lost]],
        s=end_station(drive, table.incoming[owner[lost]], end[owner[lost]]),
        line=table.line[owner[lost]],
        other=lambda k: _lost_lane(
            drive, int(owner[lost[k]]), int(link[lost[k]]), at_start=bool(lane_a[lost[k]] < 0)
        ),
    )
    good = (lane_a >= 0) & (lane_b >= 0)
    kept = owner[good]
    incoming = np.ones(len(kept), bool)
    return Transitions(lane_a[good], lane_b[good], end[kept], contact[kept], incoming, table.line[kept])


def _lost_lane(drive: OpenDrive, connection: int, link: int, *, at_start: bool) -> str:
    """Name the lane, of the incoming or the connecting road, that a laneLink names and that does not exist."""
    table = drive.connections
    if at_start:
        lane, road = table.link_from[link], table.incoming_id[connection]
    else:
        lane, road = table.link_to[link], table.connecting_id[connection]
    word = "an unreadable lane" if lane == ABSENT else f"lane {lane}"
    return f"{connection_name(drive, connection)} names {word} of road {road}"


def _check_connections(drive: OpenDrive, findings: Findings) -> None:
    """Check the attributes of connections."""
    table, roads = drive.connections, drive.roads
    for word, index, ids in (
        ("incoming", table.incoming, table.incoming_id),
        ("connecting", table.connecting, table.connecting_id),
    ):
        nameless = np.array([not name for name in ids], bool)
        lost = np.flatnonzero((index == ABSENT) & ~(_is_virtual(drive) & nameless))
        texts = [
            f"{connection_name(drive, k)} "
            + (f"names the {word} road {ids[k]}, which is not in the file" if ids[k] else f"names no {word} road")
            for k in lost.tolist()
        ]
        findings.add(f"{word}-road", line=table.line[lost], other=texts)

    def add(rule: str, rows: IntArray) -> None:
        road = table.connecting[rows]
        findings.add(
            rule,
            road=np.where(road == ABSENT, -1, road),
            line=table.line[rows],
            other=lambda k: connection_name(drive, int(rows[k])),
        )

    add("connection-without-id", np.array([k for k, name in enumerate(table.id) if not name], np.int64))
    add("connection-without-lanes", np.flatnonzero(np.diff(table.link_start) == 0))
    add("no-contact-point", np.flatnonzero((table.contact == End.UNSAID) & (table.connecting != ABSENT)))
    ordinary = np.array([drive.junctions.type[j] in ("", "default") for j in table.junction.tolist()], bool)
    known = np.flatnonzero((table.incoming != ABSENT) & (table.connecting != ABSENT) & ordinary)
    elsewhere = roads.junction[table.connecting[known]] != table.junction[known]
    add("connecting-elsewhere", known[elsewhere])
    contact = np.maximum(table.contact[known], 0)
    kind = roads.link_kind[table.connecting[known], contact]
    named = roads.link[table.connecting[known], contact]
    add("connection-without-link", known[~elsewhere & ((kind != LinkKind.ROAD) | (named != table.incoming[known]))])


def _is_virtual(drive: OpenDrive) -> BoolArray:
    """Whether connections belong to virtual junctions, (connections,)."""
    kinds = np.array([kind == "virtual" for kind in drive.junctions.type], bool)
    return np.asarray(kinds[drive.connections.junction], bool)


def _incoming_end(drive: OpenDrive, row: IntArray, contact: IntArray) -> IntArray:
    """Return the end at which each connection's incoming road meets the junction; -1 where it does not."""
    roads, table = drive.roads, drive.connections
    road = table.incoming[row]
    meets = (roads.link_kind[road] == LinkKind.JUNCTION) & (roads.link[road] == table.junction[row][:, None])
    # Roads between the connecting roads of one junction name each other.
    named = (roads.link_kind[road] == LinkKind.ROAD) & (roads.link[road] == table.connecting[row][:, None])
    meets = np.where(meets.any(1)[:, None], meets, named)
    out = np.where(meets[:, 0], 0, np.where(meets[:, 1], 1, -1))
    both = np.flatnonzero(meets.all(1))
    if len(both):
        # A loop: the end that is nearer to the connecting road.
        other = table.connecting[row[both]]
        x, y, _ = pose(drive, other, end_station(drive, other, contact[both]))
        apart = []
        for end in (End.START, End.END):
            at_x, at_y, _ = pose(drive, road[both], end_station(drive, road[both], end))
            apart.append(np.hypot(at_x - x, at_y - y))
        out[both] = np.where(apart[1] < apart[0], 1, 0)
    return np.asarray(out, np.int64)

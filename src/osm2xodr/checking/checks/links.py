"""Lanes where roads meet: gaps, steps and kinks over links, wrong ends and directions, lanes without a way on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from osm2xodr.checking import defaults
from osm2xodr.checking.checks.index import LaneIndex
from osm2xodr.checking.checks.lane_transitions import Transitions
from osm2xodr.checking.checks.places import degrees
from osm2xodr.checking.checks.plan_views import above
from osm2xodr.checking.findings import Findings
from osm2xodr.model import BoolArray, FloatArray, IntArray
from osm2xodr.opendrive import ABSENT, End, LinkKind, OpenDrive, grade, lane_borders, pose, surface_points

_PERCENT = 100.0


@dataclass(frozen=True)
class LaneEnds:
    """Lanes at ends of their roads."""

    # (n, 3) Points of the borders, m
    inner: FloatArray
    outer: FloatArray
    hdg: FloatArray  # (n,) Heading of traffic, rad
    grade: FloatArray  # (n,) Of traffic, m/m


def end_station(drive: OpenDrive, road: IntArray, end: IntArray) -> FloatArray:
    """Return s of ends of roads."""
    return np.where(end == End.END, drive.roads.length[road], 0.0)


def lane_ends(drive: OpenDrive, lanes: LaneIndex, lane: IntArray, end: IntArray) -> LaneEnds:
    """Return where lanes end, (n,)."""
    out = LaneEnds(np.empty((len(lane), 3)), np.empty((len(lane), 3)), np.empty(len(lane)), np.empty(len(lane)))
    for side in (End.START, End.END):
        at = np.flatnonzero(end == side)
        row, road = lane[at], lanes.road[lane[at]]
        s = end_station(drive, road, end[at])
        before = side == End.END
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
    """Look at every link from lane to lane."""
    one = lane_ends(drive, lanes, steps.lane_a, steps.end_a)
    other = lane_ends(drive, lanes, steps.lane_b, steps.end_b)
    inner, outer = one.inner - other.inner, one.outer - other.outer
    edge = np.maximum(np.hypot(inner[:, 0], inner[:, 1]), np.hypot(outer[:, 0], outer[:, 1]))
    height = np.maximum(np.abs(inner[:, 2]), np.abs(outer[:, 2]))
    middle = np.hypot(*((inner + outer) / 2)[:, :2].T)
    driving = lanes.driving[steps.lane_a]
    wanted = np.flatnonzero(driving)
    measured = (
        ("lane-gap", middle),
        ("lane-edge-gap", edge),
        ("lane-height-step", height),
        ("link-kink", degrees(one.hdg - other.hdg)),
        ("link-grade-step", _PERCENT * np.abs(one.grade - _along(drive, lanes, steps, other.grade))),
    )
    for rule, value in measured:
        _add(rule, drive, lanes, steps, wanted, value, findings)
    # Centre lanes are lines.
    aside = np.flatnonzero(~driving & (drive.lanes.id[steps.lane_a] != 0))
    _add("side-lane-gap", drive, lanes, steps, aside, np.maximum(edge, height), findings)
    _check_direction(drive, lanes, steps, findings)
    _check_contacts(drive, findings)


def _along(drive: OpenDrive, lanes: LaneIndex, steps: Transitions, value: FloatArray) -> FloatArray:
    """Return grades of lanes b as seen in the direction of traffic on lanes a.

    Grades change their sign with the direction of travel; where links lead against traffic, so does the comparison.
    """
    leaves = lanes.forward[steps.lane_a] == (steps.end_a == End.END)
    enters = lanes.forward[steps.lane_b] == (steps.end_b == End.START)
    return np.where(leaves == enters, value, -value)


def _add(
    rule: str,
    drive: OpenDrive,
    lanes: LaneIndex,
    steps: Transitions,
    row: IntArray,
    value: FloatArray,
    findings: Findings,
) -> None:
    """Take in findings about steps whose values are above the limit."""
    row = row[above(rule, value[row])]
    lane = steps.lane_a[row]
    road = lanes.road[lane]
    findings.add(
        rule,
        road=road,
        lane=drive.lanes.id[lane],
        s=end_station(drive, road, steps.end_a[row]),
        value=value[row],
        line=steps.line[row],
        other=lambda k: _lane_name(drive, lanes, int(steps.lane_b[row[k]])),
    )


def _lane_name(drive: OpenDrive, lanes: LaneIndex, lane: int) -> str:
    """Name a lane for people."""
    return f"lane {drive.lanes.id[lane]} of road {drive.roads.id[int(lanes.road[lane])]}"


def _check_direction(drive: OpenDrive, lanes: LaneIndex, steps: Transitions, findings: Findings) -> None:
    """Look for links between lanes of opposite traffic."""
    a, b = steps.lane_a, steps.lane_b
    leaves = lanes.forward[a] == (steps.end_a == End.END)
    enters = lanes.forward[b] == (steps.end_b == End.START)
    known = lanes.driving[a] & lanes.driving[b] & ~lanes.both_ways[a] & ~lanes.both_ways[b]
    row = np.flatnonzero((leaves != enters) & known)
    road = lanes.road[a[row]]
    findings.add(
        "lane-link-other-way",
        road=road,
        lane=drive.lanes.id[a[row]],
        s=end_station(drive, road, steps.end_a[row]),
        line=steps.line[row],
        other=lambda k: _lane_name(drive, lanes, int(b[row[k]])),
    )


def _check_contacts(drive: OpenDrive, findings: Findings) -> None:
    """Look for links that name the wrong end of the other road: the other one touches, and the named one does not."""
    roads = drive.roads
    said = (roads.link_kind == LinkKind.ROAD) & (roads.link != ABSENT) & (roads.contact != End.UNSAID)
    road, end = np.nonzero(said)
    other, contact = roads.link[road, end], roads.contact[road, end]
    bad, apart = _wrong_end(drive, (road, end), (other, contact))
    findings.add(
        "wrong-contact-point",
        road=road[bad],
        s=end_station(drive, road[bad], end[bad]),
        value=apart,
        line=roads.line[road[bad]],
        other=lambda k: f"the road's link to road {roads.id[int(other[bad[k]])]}",
    )
    # A connection's contact point is that of the connecting road, which names the incoming road there.
    table = drive.connections
    row = np.flatnonzero((table.incoming != ABSENT) & (table.connecting != ABSENT) & (table.contact != End.UNSAID))
    links = roads.link[table.connecting[row]] == table.incoming[row][:, None]
    links &= roads.link_kind[table.connecting[row]] == LinkKind.ROAD
    one_end = links.sum(1) == 1
    named = np.where(links[:, 0], 0, 1)
    lost = row[one_end & (named != table.contact[row])]
    road = table.connecting[lost]
    far = end_station(drive, road, table.contact[lost])
    near = end_station(drive, road, 1 - table.contact[lost])
    apart = np.hypot(*(pose(drive, road, far)[k] - pose(drive, road, near)[k] for k in (0, 1)))
    findings.add(
        "wrong-contact-point",
        road=road,
        s=far,
        value=apart,
        line=table.line[lost],
        other=lambda k: f"the connection from road {roads.id[int(table.incoming[lost[k]])]}",
    )


def _wrong_end(
    drive: OpenDrive, here: tuple[IntArray, IntArray], there: tuple[IntArray, IntArray]
) -> tuple[IntArray, FloatArray]:
    """Return the links whose other end would fit and the named one does not, and how far away that is, m."""
    roads = drive.roads
    road, end = here
    other, contact = there
    x, y, _ = pose(drive, road, end_station(drive, road, end))
    apart = []
    for side in (contact, 1 - contact):
        at_x, at_y, _ = pose(drive, other, end_station(drive, other, side))
        apart.append(np.hypot(at_x - x, at_y - y))
    # Reference lines may lie on either side of a carriageway: near is nearer by far, and not only touching.
    reach = np.minimum(0.1 * roads.length[other], defaults.CHECK_GAP_GRAVE)
    bad = np.flatnonzero((apart[1] <= reach) & above("wrong-contact-point", apart[0]))
    return bad, apart[0][bad]


def check_ways_on(drive: OpenDrive, lanes: LaneIndex, steps: Transitions, findings: Findings) -> None:
    """Look for lanes that lead nowhere although their road goes on."""
    if not findings.wants("dead-lane", "dead-end-junction", "unfed-lane", "lane-ends"):
        return
    exits = _exits(drive, lanes)
    linked = _lanes_used(len(drive.lanes.id), steps, ~steps.incoming)
    connected = _lanes_used(len(drive.lanes.id), steps, steps.incoming)
    table, roads = drive.lanes, drive.roads
    for end in (End.START, End.END):
        outermost = lanes.end_section(lanes.road, np.full(len(lanes.road), int(end))) == table.section
        row = np.flatnonzero(outermost & lanes.driving & ~lanes.both_ways)
        road = lanes.road[row]
        s = end_station(drive, road, np.full(len(row), int(end)))
        width = _width_at(drive, row, s, before=end == End.END)
        wide = width > defaults.CHECK_TAPERED
        leaves = lanes.forward[row] == (end == End.END)
        kind = roads.link_kind[road, int(end)]
        known = roads.link[road, int(end)] != ABSENT
        at_junction = wide & (kind == LinkKind.JUNCTION) & known
        # Into a junction lead its connections, out of it the links of connecting roads.
        stuck = at_junction & leaves & ~connected[row, int(end)]
        unfed = at_junction & ~leaves & ~linked[row, int(end)]
        # Turning round into the road one comes from is no way on.
        others = exits[road, int(end)] > 0
        for rule, which in (
            ("dead-lane", stuck & others),
            ("dead-end-junction", stuck & ~others),
            ("unfed-lane", unfed),
        ):
            bad = np.flatnonzero(which)
            _add_ends(rule, drive, lanes, row[bad], s[bad], None, findings)
        at_road = leaves & (kind == LinkKind.ROAD) & known
        _check_lane_ends(drive, lanes, row, at_road, (linked | connected)[row, int(end)], width, s, findings)
    _check_inner_ends(drive, lanes, findings)


def _exits(drive: OpenDrive, lanes: LaneIndex) -> IntArray:
    """Return how many other ends of roads lead out of the junction at each end of a road, (roads, 2)."""
    roads, table = drive.roads, drive.lanes
    leads = np.zeros((len(roads.id), 2), bool)
    for end in (End.START, End.END):
        outermost = lanes.end_section(lanes.road, np.full(len(lanes.road), int(end))) == table.section
        enters = outermost & lanes.driving & (lanes.both_ways | (lanes.forward == (end == End.START)))
        leads[lanes.road[enters], int(end)] = True
    at_junction = (roads.link_kind == LinkKind.JUNCTION) & (roads.link != ABSENT)
    junction = np.where(at_junction, roads.link, 0)
    leads &= at_junction
    count = np.bincount(junction[leads], minlength=max(len(drive.junctions.id), 1))
    return np.asarray(np.where(at_junction, count[junction] - leads, 0), np.int64)


def _lanes_used(count: int, steps: Transitions, which: BoolArray) -> BoolArray:
    """Return which lanes are linked at which ends of their roads by some steps, (lanes, 2)."""
    used = np.zeros((count, 2), bool)
    used[steps.lane_a[which], steps.end_a[which]] = True
    used[steps.lane_b[which], steps.end_b[which]] = True
    return used


def _width_at(drive: OpenDrive, lane: IntArray, s: FloatArray, *, before: bool) -> FloatArray:
    """Return the widths of lanes at s, m."""
    inner, outer = lane_borders(drive, lane, s, before=before)
    width: FloatArray = np.abs(outer - inner)
    return width


def _add_ends(
    rule: str,
    drive: OpenDrive,
    lanes: LaneIndex,
    lane: IntArray,
    s: FloatArray,
    value: FloatArray | None,
    findings: Findings,
) -> None:
    """Take in findings about ends of lanes."""
    roads = drive.roads
    road = lanes.road[lane]
    at_end = (s > 0).astype(np.int64)
    findings.add(
        rule,
        road=road,
        lane=drive.lanes.id[lane],
        s=s,
        value=value,
        line=drive.lanes.line[lane],
        other=lambda k: roads.link_id[int(road[k])][int(at_end[k])],
    )


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
    """Look for groups of lanes of one section and direction none of which goes on although the road does."""
    group = drive.lanes.section[row] * 2 + lanes.forward[row]
    alive = np.unique(group[used])
    bad = np.flatnonzero(goes_on & ~used & above("lane-ends", width) & ~np.isin(group, alive))
    _add_ends("lane-ends", drive, lanes, row[bad], s[bad], width[bad], findings)


def _check_inner_ends(drive: OpenDrive, lanes: LaneIndex, findings: Findings) -> None:
    """Look for the same where one lane section follows another."""
    table, sections = drive.lanes, drive.sections
    for end, ids in ((End.START, table.predecessor), (End.END, table.successor)):
        outermost = lanes.end_section(lanes.road, np.full(len(lanes.road), int(end))) == table.section
        leaves = lanes.forward == (end == End.END)
        row = np.flatnonzero(~outermost & leaves & lanes.driving & ~lanes.both_ways)
        s = (sections.end if end == End.END else sections.s)[table.section[row]]
        width = _width_at(drive, row, s, before=end == End.END)
        goes_on = np.ones(len(row), bool)
        _check_lane_ends(drive, lanes, row, goes_on, ids[row] != ABSENT, width, s, findings)

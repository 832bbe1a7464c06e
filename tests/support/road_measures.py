"""What a road map's lanes measure, worked out record by record from its tables."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

from clothoids import clothoid

from osm2xodr.model import Cubic, CubicProfile, Lane, LaneSection, LaneType, PlanView, Road, RoadLink, RoadMap, Rule

CLOSE = 1e-6
# Connecting roads write an arc of less than 5e-5 rad as its chord: headings at its ends are off by half of it, rad,
# and by as much again where they are drawn anew.
TURN = 5e-5
# Spirals within 1e-6 rad of an arc are written as one; beside a bend whose line moves aside by some metres, places
# are off by as many micrometres.
MOVED_GAP = 1e-5
_FOR_CARS = (LaneType.DRIVING, LaneType.BUS, LaneType.TAXI)


@dataclass(frozen=True)
class Pose:
    """A place and a heading."""

    x: float
    y: float
    hdg: float

    def beside(self, t: float) -> Pose:
        """Return the pose t to the left."""
        return Pose(self.x - t * math.sin(self.hdg), self.y + t * math.cos(self.hdg), self.hdg)

    def moved(self, ds: float, curvature: float, rate: float = 0.0) -> Pose:
        """Return the pose after ds along a line, an arc or a spiral, whose curvature grows by rate."""
        if rate != 0.0:
            along, turn = clothoid(curvature, rate, ds)
            place = complex(along) * cmath.exp(1j * self.hdg)
            return Pose(self.x + place.real, self.y + place.imag, self.hdg + float(turn))
        if curvature == 0.0:
            return Pose(self.x + ds * math.cos(self.hdg), self.y + ds * math.sin(self.hdg), self.hdg)
        end = self.hdg + ds * curvature
        return Pose(
            self.x + (math.sin(end) - math.sin(self.hdg)) / curvature,
            self.y - (math.cos(end) - math.cos(self.hdg)) / curvature,
            end,
        )

    def turned(self) -> Pose:
        """Return the same place looked at the other way."""
        return Pose(self.x, self.y, self.hdg + math.pi)

    def gap(self, other: Pose) -> float:
        """Return the distance to another pose, m."""
        return math.hypot(self.x - other.x, self.y - other.y)

    def turn(self, other: Pose) -> float:
        """Return the angle between the headings, rad, 0 to pi."""
        return abs(math.remainder(self.hdg - other.hdg, 2 * math.pi))


def records(plan: PlanView, curve: int) -> list[tuple[float, Pose, float, float]]:
    """Return (s, start pose, length, curvature) of a curve's records."""
    part = slice(int(plan.start[curve]), int(plan.start[curve + 1]))
    columns = (plan.s, plan.x, plan.y, plan.hdg, plan.length, plan.curvature)
    rows = zip(*(column[part].tolist() for column in columns), strict=True)
    return [(s, Pose(x, y, hdg), length, curvature) for s, x, y, hdg, length, curvature in rows]


def rates(plan: PlanView, curve: int) -> list[float]:
    """Return how the curvature of a curve's records grows, 1/m²."""
    return list(plan.rate[plan.start[curve] : plan.start[curve + 1]].tolist())


def curve_length(plan: PlanView, curve: int) -> float:
    """Return a curve's length, m."""
    return sum(length for _, _, length, _ in records(plan, curve))


def pose_at(plan: PlanView, curve: int, s: float) -> Pose:
    """Return the pose at s of a curve."""
    found = [item for item in records(plan, curve) if item[0] <= s + 1e-9]
    begin, pose, _, curvature = found[-1]
    return pose.moved(s - begin, curvature, rates(plan, curve)[len(found) - 1])


def assert_smooth(plan: PlanView, curve: int, close: float = 1e-9, turn: float = 1e-9) -> None:
    """Check that a curve's records follow on each other in s, place and heading."""
    rows = records(plan, curve)
    assert abs(rows[0][0]) < 1e-9, f"starts at s = {rows[0][0]}"
    follow = zip(pairwise(rows), rates(plan, curve), strict=False)
    for ((s, pose, length, curvature), (next_s, next_pose, _, _)), rate in follow:
        assert length > 0
        assert abs(s + length - next_s) < 1e-6, f"s = {next_s} after {s} and {length}"
        end = pose.moved(length, curvature, rate)
        assert end.gap(next_pose) < close, f"gap of {end.gap(next_pose)} m at s = {next_s}"
        assert end.turn(next_pose) < turn, f"kink of {end.turn(next_pose)} rad at s = {next_s}"
    assert rows[-1][2] > 0


def smallest_radius_of(plan: PlanView, curve: int) -> float:
    """Return a curve's smallest radius, m."""
    rows = zip(records(plan, curve), rates(plan, curve), strict=True)
    bends = [abs(k) for (_, _, length, first), rate in rows for k in (first, first + rate * length)]
    return min((1 / k for k in bends if k), default=math.inf)


def _value(cubics: Iterable[tuple[float, float, float, float, float]], s: float) -> float:
    held = [item for item in cubics if item[0] <= s + 1e-9]
    if not held:
        return 0.0
    begin, a, b, c, d = held[-1]
    ds = s - begin
    return a + ds * (b + ds * (c + ds * d))


def profile_value(profile: CubicProfile, curve: int, s: float) -> float:
    """Return the value at s of a profile's curve; 0 where it has no records."""
    part = slice(int(profile.start[curve]), int(profile.start[curve + 1]))
    columns = (profile.s, profile.a, profile.b, profile.c, profile.d)
    return _value(zip(*(column[part].tolist() for column in columns), strict=True), s)


def width_at(widths: Iterable[Cubic], ds: float) -> float:
    """Return a lane's width at ds from its section's start, m."""
    return _value([(c.s, c.a, c.b, c.c, c.d) for c in widths], ds)


def lane_edges(section: LaneSection, ds: float, offset: float) -> dict[int, tuple[float, float]]:
    """Return (inner t, outer t) of every lane but the centre at ds from the section's start, m."""
    lanes = {lane.id: lane for lane in section.lanes}
    found: dict[int, tuple[float, float]] = {}
    for side in (1, -1):
        t = offset
        for k in range(1, len(lanes)):
            if side * k not in lanes:
                break
            outer = t + side * width_at(lanes[side * k].widths, ds)
            found[side * k] = (t, outer)
            t = outer
    return found


class RoadMeasures:
    """Lanes of a road map by road id."""

    def __init__(self, roads: RoadMap) -> None:
        self.map = roads
        self.index = {road.id: k for k, road in enumerate(roads.roads)}

    def length(self, road: Road) -> float:
        """Return a road's length, m."""
        return curve_length(self.map.plan_view, self.index[road.id])

    def pose(self, road: Road, s: float) -> Pose:
        """Return the pose of a road's reference line."""
        return pose_at(self.map.plan_view, self.index[road.id], s)

    def edges(self, road: Road, section: int, s: float) -> dict[int, tuple[float, float]]:
        """Return the lanes' edges at s, as the given lane section has them."""
        offset = profile_value(self.map.lane_offset, self.index[road.id], s)
        item = road.lane_sections[section]
        return lane_edges(item, s - item.s, offset)

    def at_end(self, road: Road, at_start: bool) -> tuple[Pose, dict[int, tuple[float, float]]]:
        """Return the pose (along s) and the lanes' edges at a road's start or end."""
        s = 0.0 if at_start else self.length(road)
        return self.pose(road, s), self.edges(road, 0 if at_start else -1, s)

    def outlets(self, road: Road) -> list[tuple[bool, RoadLink]]:
        """Return (at start, link) of the road's ends that lead on."""
        both = ((True, road.predecessor), (False, road.successor))
        return [(at_start, link) for at_start, link in both if link is not None]


def assert_sound(roads: RoadMap) -> None:
    """Check all that holds for every road map: smooth curves, no gaps between lanes, no lane forgotten."""
    measures = RoadMeasures(roads)
    for k, road in enumerate(roads.roads):
        assert_smooth(roads.plan_view, k, MOVED_GAP, CLOSE if road.junction is None else 2 * TURN)
        _assert_lanes(measures, road)
    assert_lanes_meet(roads)
    _assert_every_lane_leads_on(measures)


def assert_lanes_meet(roads: RoadMap) -> None:
    """Check that lanes through junctions begin and end where, and as, those do that they are linked to."""
    measures = RoadMeasures(roads)
    for road in roads.roads:
        if road.junction is not None:
            _assert_contact(measures, road)


def _assert_lanes(measures: RoadMeasures, road: Road) -> None:
    length = measures.length(road)
    assert road.lane_sections[0].s == 0.0
    for k, section in enumerate(road.lane_sections):
        ids = [lane.id for lane in section.lanes]
        assert ids == list(range(ids[0], ids[-1] - 1, -1)), f"lane ids {ids}"
        assert 0 in ids
        end = road.lane_sections[k + 1].s if k + 1 < len(road.lane_sections) else length
        assert end - section.s > 0
        for lane in section.lanes:
            for share in range(21):
                assert width_at(lane.widths, share / 20 * (end - section.s)) > -1e-9
        if k + 1 < len(road.lane_sections):
            _assert_border(measures, road, k, end)


def _assert_border(measures: RoadMeasures, road: Road, k: int, s: float) -> None:
    """Check that linked lanes have the same edges on both sides of a border, and others no width there."""
    before, after = road.lane_sections[k], road.lane_sections[k + 1]
    # The offset must be continuous too: look from just before the border.
    left = _edges_before(measures, road, k, s)
    right = measures.edges(road, k + 1, s)
    going_on = {lane.id: lane.successor for lane in before.lanes if lane.successor is not None}
    coming = {lane.id: lane.predecessor for lane in after.lanes if lane.predecessor is not None}
    assert {(one, other) for one, other in going_on.items()} == {(one, other) for other, one in coming.items()}
    for lane, edges in left.items():
        if lane in going_on:
            assert max(abs(a - b) for a, b in zip(edges, right[going_on[lane]], strict=True)) < CLOSE
        else:
            assert abs(edges[0] - edges[1]) < CLOSE
    for lane, edges in right.items():
        if lane not in coming:
            assert abs(edges[0] - edges[1]) < CLOSE


def _edges_before(measures: RoadMeasures, road: Road, k: int, s: float) -> dict[int, tuple[float, float]]:
    item = road.lane_sections[k]
    profile, curve = measures.map.lane_offset, measures.index[road.id]
    part = slice(int(profile.start[curve]), int(profile.start[curve + 1]))
    held = [
        row
        for row in zip(
            *(c[part].tolist() for c in (profile.s, profile.a, profile.b, profile.c, profile.d)), strict=True
        )
        if row[0] < s - 1e-9
    ]
    return lane_edges(item, s - item.s, _value(held, s))


def _whole_lanes(path: Road) -> list[Lane]:
    """Return the lanes of a connecting road, all sections of which have the same ones, from its start to its end."""
    last = {lane.id: lane.successor for lane in path.lane_sections[-1].lanes}
    return [replace(lane, successor=last[lane.id]) for lane in path.lane_sections[0].lanes if lane.id]


def _assert_contact(measures: RoadMeasures, path: Road) -> None:
    """Check that a connecting road starts and ends in the lanes that it joins.

    Borders may fill corners and gaps, and sidewalks may end beside it.
    """
    by_id = {road.id: road for road in measures.map.roads}
    lanes = _whole_lanes(path)
    floor = (LaneType.BORDER, LaneType.SHOULDER)
    linked = [lane for lane in lanes if (lane.predecessor, lane.successor) != (None, None)]
    # Cycle tracks may have a verge beside them, which is paved where cars cross it.
    types = {lane.type for lane in linked}
    corner = LaneType.SIDEWALK in types or (len(types) == 2 and types < {LaneType.BIKING, *floor})
    assert corner or len(linked) == 1
    assert all(lane.type in {*floor, LaneType.SIDEWALK} for lane in lanes if lane not in linked)
    for own in linked:
        for_both = corner or own.type is LaneType.BIDIRECTIONAL
        assert for_both or (own.id < 0) == (measures.map.rule is Rule.RIGHT_HAND)
        _assert_joined(measures, path, own, by_id)


def _assert_joined(measures: RoadMeasures, path: Road, own: Lane, by_id: Mapping[int, Road]) -> None:
    for at_start, link, lane_id in (
        (True, path.predecessor, own.predecessor),
        (False, path.successor, own.successor),
    ):
        assert link is not None
        assert lane_id is not None
        road = by_id[link.id]
        other = road.predecessor if link.at_start else road.successor
        assert other == RoadLink(True, path.junction or 0), f"road {road.id} does not end at junction {path.junction}"
        assert link.at_start is not None
        pose, edges = measures.at_end(path, at_start)
        pose_beyond, edges_beyond = measures.at_end(road, link.at_start)
        inner, outer = edges[own.id]
        inner_beyond, outer_beyond = edges_beyond[lane_id]
        # Traffic runs off the road at its end, onto it at its start, or the other way round.
        flips = link.at_start == at_start
        aligned = pose_beyond.turned() if flips else pose_beyond
        assert pose.turn(aligned) < TURN, f"kink of {pose.turn(aligned)} rad between {path.id} and {road.id}"
        # Lanes for cars lie around the reference line; what lies beside it is turned with it.
        close = CLOSE + TURN * max(abs(inner + outer) / 2 - 1e-3, 0.0)
        assert pose.beside((inner + outer) / 2).gap(pose_beyond.beside((inner_beyond + outer_beyond) / 2)) < close
        assert abs(abs(inner - outer) - abs(inner_beyond - outer_beyond)) < CLOSE
        # Traffic keeps to its side: the lane's inner edge is the inner edge on both roads.
        for t, t_beyond in ((inner, inner_beyond), (outer, outer_beyond)):
            edge_beyond = pose_beyond.beside(t_beyond)
            assert pose.beside(t).gap(edge_beyond) < close + TURN * abs(inner - outer)


def _assert_every_lane_leads_on(measures: RoadMeasures) -> None:
    """Check that lanes for cars that end at a junction go on, and that those that begin there are fed.

    An arm that nothing at all leads onto (or off) is left out: what else there is may not be allowed to.
    """
    used: set[tuple[int, bool, int]] = set()
    for path in measures.map.roads:
        if path.junction is None:
            continue
        for own in _whole_lanes(path):
            for link, lane_id in ((path.predecessor, own.predecessor), (path.successor, own.successor)):
                assert link is not None
                # Sidewalks lead on where cars may not.
                if lane_id is not None and own.type in _FOR_CARS:
                    used.add((link.id, bool(link.at_start), lane_id))
    sides = {(road, at_start, lane > 0) for road, at_start, lane in used}
    missing = []
    for road in measures.map.roads:
        if road.junction is not None:
            continue
        for at_start, link in measures.outlets(road):
            if link.to_junction:
                missing += [
                    (road.osm_way_ids, at_start, lane.id)
                    for lane in road.lane_sections[0 if at_start else -1].lanes
                    if lane.type in _FOR_CARS
                    and (road.id, at_start, lane.id > 0) in sides
                    and (road.id, at_start, lane.id) not in used
                ]
    assert missing == []

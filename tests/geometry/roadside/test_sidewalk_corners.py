"""Sidewalks go round the corners of junctions: which are joined, where they run, what they are linked to."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest
from junction_cases import CASES
from margin_cases import BOTH, PARKING, TRACK, VERGE, WALK, Strips, built, is_led_on
from road_measures import RoadMeasures, assert_sound, curve_length, pose_at, width_at
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.roadside import defaults
from osm2xodr.model import BoolArray, Direction, FloatArray, Lane, LaneType, MarginSpec, Road, RoadMap, Rule
from osm2xodr.surface import FlatSurface
from osm2xodr.system import record

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
X = CASES["x"].case
T = CASES["t"].case


def wide(case: Case, width: float = 6.0) -> Case:
    """Return the case with carriageways of a width."""
    return Case(
        case.nodes, {way: (nodes, f"lanes=2 width={width:g} {tags}") for way, (nodes, tags) in case.ways.items()}
    )


def everywhere(case: Case, strips: tuple[Strips, Strips] = BOTH) -> dict[int, tuple[Strips, Strips]]:
    return dict.fromkeys(case.ways, strips)


def corners(roads: RoadMap) -> list[Road]:
    return [
        road
        for road in roads.roads
        if road.junction is not None and any(is_led_on(lane) for lane in road.lane_sections[0].lanes)
    ]


def types_of(road: Road) -> list[LaneType]:
    return [lane.type for lane in road.lane_sections[0].lanes]


def driven(road: Road) -> list[Lane]:
    return [lane for lane in road.lane_sections[0].lanes if lane.type is LaneType.DRIVING]


def sidewalk_of(road: Road) -> Lane:
    (lane,) = filter(is_led_on, road.lane_sections[0].lanes)
    return lane


def ways_joined(roads: RoadMap) -> set[frozenset[tuple[int, bool]]]:
    """Return, for each corner, the ways that it joins and whether at a lane left of their centre."""
    by_id = {road.id: road for road in roads.roads}
    out = set()
    for road in corners(roads):
        lane = sidewalk_of(road)
        ends = []
        for link, number in ((road.predecessor, lane.predecessor), (road.successor, lane.successor)):
            assert link is not None
            assert number is not None
            ends.append((by_id[link.id].osm_way_ids[0], number > 0))
        out.add(frozenset(ends))
    return out


def middle_of(
    roads: RoadMap, road: Road, shares: Iterable[float] = (0.0, 0.25, 0.5, 0.75, 1.0)
) -> list[tuple[float, float]]:
    """Return places along the middle of a corner's sidewalk."""
    measures = RoadMeasures(roads)
    out = []
    for share in shares:
        s = share * measures.length(road)
        edges = measures.edges(road, 0, s)[sidewalk_of(road).id]
        place = measures.pose(road, s).beside(sum(edges) / 2)
        out.append((place.x, place.y))
    return out


@EITHER
def test_all_corners_of_a_crossing(rule: Rule) -> None:
    case = wide(X)
    roads = built(case, everywhere(case), rule)
    assert_sound(roads)
    # Ways 1 and 3 come in from west and south, 2 and 4 lead out to east and north.
    wanted = {
        frozenset({(1, False), (3, True)}),
        frozenset({(3, False), (2, False)}),
        frozenset({(2, True), (4, False)}),
        frozenset({(4, True), (1, True)}),
    }
    if rule is Rule.LEFT_HAND:
        wanted = {frozenset((way, not left) for way, left in pair) for pair in wanted}
    assert ways_joined(roads) == wanted
    (junction,) = roads.junctions
    assert [road.junction for road in corners(roads)] == [junction.id] * 4
    assert [road.id for road in corners(roads)] == [item.connecting_road for item in junction.connections[-4:]]


@EITHER
def test_a_sidewalk_leads_round_a_turning_circle(rule: Rule) -> None:
    """Cars go round at 6 m, in lanes of 3 m; the sidewalk of 2 m lies beyond, 7.5 to 9.5 m off."""
    nodes, ways = {"w": (-80.0, 0.0), "o": (0.0, 0.0)}, {1: ("w o", "width=6 lanes=2")}
    told = Diagnostics()
    case = Case(nodes, ways, node_tags={"o": "highway=turning_circle"})
    roads = built(case, everywhere(case), rule, diagnostics=told)
    assert_sound(roads)
    (walk,) = corners(roads)
    assert ways_joined(roads) == {frozenset({(1, False), (1, True)})}
    measures = RoadMeasures(roads)
    (loop,) = (road for road in roads.roads if road.junction is not None and road is not walk)
    half = measures.pose(loop, measures.length(loop) / 2)
    places = middle_of(roads, walk, np.linspace(0.25, 0.75, 7).tolist())
    assert [math.hypot(x - (half.x - 6.0), y - half.y) for x, y in places] == pytest.approx([8.5] * 7, abs=0.01)
    assert "sidewalk-corner" not in [item.code for item in told]


@EITHER
def test_a_corner_runs_along_the_edge_of_the_turn(rule: Rule) -> None:
    """Lanes are 3 m, sidewalks 2 m wide: the strip lies 1.5 to 3.5 m from the middle of the lane that turns."""
    case = wide(X)
    roads = built(case, everywhere(case), rule)
    measures = RoadMeasures(roads)
    for road in corners(roads):
        (turn,) = (
            other
            for other in roads.roads
            if other.junction is not None
            and other is not road
            and (other.predecessor, other.successor) == (road.predecessor, road.successor)
        )
        k, other = measures.index[road.id], measures.index[turn.id]
        assert curve_length(roads.plan_view, k) == curve_length(roads.plan_view, other)
        for share in (0.0, 0.3, 0.5, 1.0):
            s = share * measures.length(road)
            assert pose_at(roads.plan_view, k, s) == pose_at(roads.plan_view, other, s)
            (edges,) = (edges for lane, edges in measures.edges(road, 0, s).items() if lane)
            assert sorted(abs(t) for t in edges) == pytest.approx([1.5, 3.5])
        lane = next(lane for lane in road.lane_sections[0].lanes if lane.id)
        assert (lane.height, abs(lane.id)) == (0.12, 1)


@EITHER
def test_the_closed_side_of_a_t_goes_straight_on(rule: Rule) -> None:
    case = wide(T)
    roads = built(case, everywhere(case), rule)
    assert_sound(roads)
    assert len(corners(roads)) == 3
    side = 1 if rule is Rule.RIGHT_HAND else -1
    street = pose_at(roads.plan_view, 0, 0.0).y
    (straight,) = (road for road in corners(roads) if side * (middle_of(roads, road)[2][1] - street) > 0)
    assert [y - street for _, y in middle_of(roads, straight)] == pytest.approx([side * 4.0] * 5, abs=0.01)


@EITHER
@pytest.mark.parametrize("highway", ["service", "residential"])
def test_sidewalks_run_on_past_driveways_without_any(rule: Rule, highway: str) -> None:
    """They lie as low as the carriageway there, straight beside the street's lane, and nowhere else."""
    ways = {way: (nodes, f"lanes=2 width=6 {tags}") for way, (nodes, tags) in T.ways.items()}
    ways[3] = ways[3][0], f"lanes=2 width=6 highway={highway}"
    found = Diagnostics()
    roads = built(Case(T.nodes, ways), {1: BOTH, 2: BOTH}, rule, diagnostics=found)
    assert_sound(roads)
    assert all(code != "sidewalk-corner" for _, code in found.counts())
    walks = corners(roads)
    if highway == "residential":
        assert [sidewalk_of(road).height for road in walks] == [0.12]
        return
    assert sorted(sidewalk_of(road).height for road in walks) == [0.0, 0.12]
    street = pose_at(roads.plan_view, 0, 0.0).y
    places = {sidewalk_of(road).height: middle_of(roads, road) for road in walks}
    (driveway,) = (k for k, road in enumerate(roads.roads) if road.osm_way_ids == (3,) and road.junction is None)
    side = np.sign(pose_at(roads.plan_view, driveway, 0.0).y - street)
    assert [y - street for _, y in places[0.0]] == pytest.approx([4.0 * side] * 5, abs=0.01)
    assert [y - street for _, y in places[0.12]] == pytest.approx([-4.0 * side] * 5, abs=0.01)


@EITHER
def test_driveways_are_paved_where_they_cross_a_verge(rule: Rule) -> None:
    ways = {way: (nodes, f"lanes=2 width=6 {tags}") for way, (nodes, tags) in T.ways.items()}
    ways[3] = ways[3][0], "lanes=2 width=6 highway=service"
    verges = ((VERGE, WALK), (VERGE, WALK))
    roads = built(Case(T.nodes, ways), {1: verges, 2: verges}, rule)
    assert_sound(roads)
    # Beside the sidewalk that runs past the driveway, and beside that on the other side of the street.
    between = {
        sidewalk_of(road).height: [(lane.type, lane.height, width_at(lane.widths, 0.0)) for lane in inner]
        for road in corners(roads)
        if (inner := [lane for lane in road.lane_sections[0].lanes if abs(lane.id) == 1])
    }
    assert between == {0.0: [(LaneType.SHOULDER, 0.0, 1.0)], 0.12: [(LaneType.BORDER, 0.12, 1.0)]}


def _backwards(strips: Strips) -> Strips:
    return tuple(
        replace(strip, direction=Direction.BACKWARD) if strip.type is LaneType.BIKING else strip for strip in strips
    )


@EITHER
@pytest.mark.parametrize("side_street", [(), (WALK,)], ids=["bare", "with sidewalks"])
@pytest.mark.parametrize(
    ("one", "other"),
    [((VERGE, TRACK), (VERGE, TRACK)), ((VERGE, TRACK, WALK), (VERGE, TRACK, WALK)), ((TRACK, WALK), (WALK, TRACK))],
    ids=["alone", "beside sidewalks", "across the sidewalk"],
)
def test_cycle_tracks_lead_straight_on_past_other_streets(
    rule: Rule, one: Strips, other: Strips, side_street: Strips
) -> None:
    """Ways 1 and 2 run from west to east, 3 and 4 cross them."""
    ways = {1: (_backwards(one), one), 2: (_backwards(other), other)}
    roads = built(wide(X), {**ways, 3: (side_street, side_street), 4: (side_street, side_street)}, rule)
    assert_sound(roads)
    led = [road for road in roads.roads if road.junction is not None and LaneType.BIKING in types_of(road)]
    assert len(led) == 2
    by_id = {road.id: road for road in roads.roads}
    for road in led:
        (lane,) = (lane for lane in road.lane_sections[0].lanes if lane.type is LaneType.BIKING)
        assert lane.height == 0.0
        for link, number in ((road.predecessor, lane.predecessor), (road.successor, lane.successor)):
            assert link is not None
            arm = by_id[link.id].lane_sections[0].lanes
            assert [item.type for item in arm if item.id == number] == [LaneType.BIKING]


@EITHER
def test_cycle_tracks_of_one_way_streets_that_cross_lead_straight_on_at_both_sides(rule: Rule) -> None:
    """Also against the cars; strips between track and carriageway begin and end there."""
    one_way = {way: (nodes, f"lanes=1 width=4 oneway=yes {tags}") for way, (nodes, tags) in X.ways.items()}
    near, far = (TRACK,), (VERGE, TRACK)
    roads = built(Case(X.nodes, one_way), {1: (far, far), 2: (near, near), 3: (far, near), 4: (near, far)}, rule)
    assert_sound(roads)
    by_id = {road.id: road for road in roads.roads}
    pairs = []
    for road in roads.roads:
        if road.junction is not None and LaneType.BIKING in types_of(road):
            assert road.predecessor is not None
            assert road.successor is not None
            pairs.append(sorted(by_id[link.id].osm_way_ids[0] for link in (road.predecessor, road.successor)))
    assert [pairs.count(pair) for pair in ([1, 2], [3, 4])] == [2, 2]


@EITHER
def test_cycle_tracks_widen_over_all_of_their_way_past_other_streets(rule: Rule) -> None:
    """Only bicycle lanes that join cars widen at their end: `ConnectingRoads.change_start`."""
    wider, back = replace(TRACK, width=TRACK.width + 0.6), Direction.BACKWARD
    first, second = ((VERGE, replace(track, direction=back)) for track in (TRACK, wider))
    roads = built(wide(X), {1: (first, (VERGE, TRACK)), 2: (second, (VERGE, wider)), 3: ((), ()), 4: ((), ())}, rule)
    assert_sound(roads)
    lanes = [
        lane
        for road in roads.roads
        if road.junction is not None
        for lane in road.lane_sections[0].lanes
        if lane.type is LaneType.BIKING
    ]
    assert len(lanes) == 2
    assert [len(lane.widths) for lane in lanes] == [1, 1]
    assert sorted(lane.widths[0].a for lane in lanes) == pytest.approx([TRACK.width, wider.width])


@EITHER
def test_cycle_tracks_do_not_turn_across_the_junction(rule: Rule) -> None:
    """From the west only to the south: its far side has none to lead to."""
    case = wide(X)
    tracks = ((TRACK,), (TRACK,))
    roads = built(case, {1: tracks, 3: tracks}, rule)
    assert_sound(roads)
    led = [road for road in roads.roads if road.junction is not None and LaneType.BIKING in types_of(road)]
    assert len(led) == 1


@EITHER
def test_sidewalks_of_driveways_are_joined(rule: Rule) -> None:
    ways = {way: (nodes, f"lanes=2 width=6 {tags}") for way, (nodes, tags) in T.ways.items()}
    ways[3] = ways[3][0], "lanes=2 width=6 highway=service"
    roads = built(Case(T.nodes, ways), dict.fromkeys(ways, BOTH), rule)
    assert [sidewalk_of(road).height for road in corners(roads)] == [0.12] * 3


def test_left_hand_traffic_is_the_mirror_image() -> None:
    for name in ("t", "x", "offset_t", "roundabout", "dual_cross", "star", "y_split"):
        case = CASES[name].case
        right = built(case, everywhere(case))
        left = built(case, everywhere(case), Rule.LEFT_HAND)
        assert len(corners(right)) == len(corners(left)), name
        for one, other in zip(corners(right), corners(left), strict=True):
            mirrored = [(x, -y) for x, y in middle_of(left, other)]
            # Coordinates are rounded otherwise, and what is rounded decides where spirals begin.
            assert np.allclose(middle_of(right, one), mirrored, atol=2e-2), name


@EITHER
def test_only_sidewalks_that_face_each_other_are_joined(rule: Rule) -> None:
    case = wide(X)
    margins: dict[int, tuple[Strips, Strips]] = {1: ((), (WALK,)), 2: ((WALK,), (WALK,)), 3: ((WALK,), ())}
    roads = built(case, margins, rule)
    assert_sound(roads)
    left = rule is Rule.RIGHT_HAND
    assert ways_joined(roads) == {frozenset({(1, not left), (3, left)})}


@EITHER
def test_dual_carriageways_have_no_corners_in_the_median(rule: Rule) -> None:
    """Sidewalks lie at the outer sides only: right of traffic that keeps to the right."""
    case = CASES["dual_cross"].case
    roads = built(case, everywhere(case, ((), (WALK,))), rule)
    assert_sound(roads)
    assert len(corners(roads)) == 4
    for road in corners(roads):
        assert curve_length(roads.plan_view, RoadMeasures(roads).index[road.id]) < 20.0


@EITHER
def test_round_a_roundabout(rule: Rule) -> None:
    """Both corners at each arm; the sidewalk stays outside of the ring."""
    case = CASES["roundabout"].case
    ring = {way for way, (_, tags) in case.ways.items() if "roundabout" in tags}
    margins = {way: ((), (WALK,)) if way in ring else BOTH for way in case.ways}
    roads = built(case, margins, rule)
    assert_sound(roads)
    assert len(corners(roads)) == 8
    for road in corners(roads):
        assert min(math.hypot(x, y) for x, y in middle_of(roads, road)) > 18.0


@EITHER
def test_a_corner_between_sidewalks_of_different_width_and_place(rule: Rule) -> None:
    """From 2 m at the edge to 3 m beyond a parking lane: edges and headings fit at both ends."""
    case = wide(T)
    margins = {1: ((WALK,), (WALK,)), 2: ((WALK,), (WALK,)), 3: ((PARKING, replace(WALK, width=3.0)), (WALK,))}
    roads = built(case, margins, rule)
    assert_sound(roads)
    widths = []
    for road in corners(roads):
        lane = sidewalk_of(road)
        length = curve_length(roads.plan_view, RoadMeasures(roads).index[road.id])
        widths.append(sorted(width_at(lane.widths, s) for s in (0.0, length)))
    assert np.sort(widths, axis=0) == pytest.approx(np.array([[2.0, 2.0], [2.0, 2.0], [2.0, 3.0]]))


def test_corners_without_room_are_left_out_and_told() -> None:
    """Streets that part at 5 degrees: cars that turn back swing out over both outer corners."""
    nodes = {"w": (-120.0, 0.0), "o": (0.0, 0.0), "e": (120.0, 0.0), "s": (-119.5, -10.5)}
    street = "lanes=2 width=6"
    case = Case(nodes, {1: ("w o", street), 2: ("o e", street), 3: ("s o", street)})
    diagnostics = Diagnostics()
    roads = built(case, everywhere(case), diagnostics=diagnostics)
    assert ways_joined(roads) == {frozenset({(1, False), (3, True)})}
    assert [(item.code, item.osm_id) for item in diagnostics if item.code == "sidewalk-corner"] == [
        ("sidewalk-corner", "node/1002")
    ]


@EITHER
def test_broad_sidewalks_meet_in_a_wedge(rule: Rule) -> None:
    """Sidewalks 14 m wide lie across each other long before the junction; they become narrow in time."""
    case = wide(X)
    broad = replace(WALK, width=14.0)
    diagnostics = Diagnostics()
    roads = built(case, everywhere(case, ((broad,), (broad,))), rule, diagnostics=diagnostics)
    assert_sound(roads)
    assert len(corners(roads)) == 4
    assert not [item for item in diagnostics if item.code == "sidewalk-corner"]


@EITHER
def test_sidewalks_come_to_the_kerb_where_strips_inside_of_them_are_in_the_way(rule: Rule) -> None:
    """Ten metres of verge end before the junction: the sidewalks, then at the kerb, go round the corners."""
    case = wide(X)
    verge = MarginSpec(LaneType.BORDER, 10.0)
    margins = everywhere(case, ((verge, WALK), (verge, WALK)))
    diagnostics = Diagnostics()
    roads = built(case, margins, rule, diagnostics=diagnostics)
    assert_sound(roads)
    assert len(corners(roads)) == 4
    assert not [item for item in diagnostics if item.code == "sidewalk-corner"]
    west = roads.roads[0]
    length = curve_length(roads.plan_view, 0)
    (section,) = west.lane_sections
    lanes = {lane.id: lane for lane in section.lanes}
    ends = length - defaults.CORNER_KERBSIDE
    for side in (1, -1):
        assert (lanes[2 * side].type, lanes[3 * side].type) == (LaneType.BORDER, LaneType.SIDEWALK)
        places = (0.0, ends - defaults.MARGIN_TAPER_LENGTH, ends - 3.0, ends, length)
        at = [width_at(lanes[2 * side].widths, s) for s in places]
        assert at == pytest.approx([10.0, 10.0, 5.0, 0.0, 0.0], abs=1e-6)
        assert [width_at(lanes[3 * side].widths, s) for s in places] == pytest.approx([WALK.width] * 5)


@EITHER
def test_strips_stay_where_sidewalks_get_round_with_them(rule: Rule) -> None:
    case = wide(X)
    roads = built(case, everywhere(case, ((VERGE, WALK), (VERGE, WALK))), rule)
    assert len(corners(roads)) == 4
    assert [len(road.lane_sections) for road in roads.roads if road.junction is None] == [1] * 4


def test_verges_and_parking_lanes_alone_are_not_joined() -> None:
    case = wide(X)
    assert corners(built(case, everywhere(case, ((PARKING, VERGE), (VERGE,))))) == []


@EITHER
def test_no_sidewalk_lies_on_a_lane_for_cars(rule: Rule) -> None:
    """At the corners of all kinds of junctions the middle of the sidewalk keeps off lanes."""
    for name in ("t", "x", "offset_t", "dual_cross", "roundabout", "slip_lane", "star", "y_merge", "y_split"):
        case = CASES[name].case
        roads = built(case, everywhere(case), rule)
        assert_sound(roads)
        measures = RoadMeasures(roads)
        lanes = [road for road in roads.roads if road.junction is not None and road not in corners(roads)]
        for walk in corners(roads):
            places = middle_of(roads, walk, (0.2, 0.4, 0.6, 0.8))
            for road in lanes:
                if road.junction != walk.junction:
                    continue
                length = measures.length(road)
                for s in np.linspace(0.0, length, 25).tolist():
                    (edges,) = (measures.edges(road, 0, s)[lane.id] for lane in driven(road))
                    here = measures.pose(road, s).beside(sum(edges) / 2)
                    nearest = min(math.hypot(x - here.x, y - here.y) for x, y in places)
                    assert nearest > abs(edges[0] - edges[1]) / 2 - 0.01, (name, walk.id, road.id)


def lanes_across(roads: RoadMap, road: Road, share: float) -> list[tuple[LaneType, float, float]]:
    """Return type, and distances of both edges from the reference line, of a corner's lanes from the inside out."""
    measures = RoadMeasures(roads)
    edges = measures.edges(road, 0, share * measures.length(road))
    types = {lane.id: lane.type for lane in road.lane_sections[0].lanes if lane.id}
    out = []
    for lane in sorted(types, key=abs):
        inner, outer = sorted(abs(t) for t in edges[lane])
        out.append((types[lane], inner, outer))
    return out


@EITHER
def test_verges_and_bicycle_tracks_go_on_beside_the_sidewalk(rule: Rule) -> None:
    """Lanes are 3 m wide: beside that of the turn lie 1 m of verge, 1.6 m of track and 2 m of sidewalk."""
    case = wide(X)
    strips = (VERGE, TRACK, WALK)
    roads = built(case, everywhere(case, (strips, strips)), rule)
    assert_sound(roads)
    assert len(corners(roads)) == 4
    (junction,) = roads.junctions
    links = {item.connecting_road: item.lane_links for item in junction.connections}
    for road in corners(roads):
        for share in (0.0, 0.4, 1.0):
            kinds, inner, outer = zip(*lanes_across(roads, road, share), strict=True)
            assert kinds == (LaneType.BORDER, LaneType.BIKING, LaneType.SIDEWALK)
            assert inner == pytest.approx([1.5, 2.5, 4.1])
            assert outer == pytest.approx([2.5, 4.1, 6.1])
        lanes = sorted((lane for lane in road.lane_sections[0].lanes if lane.id), key=lambda lane: abs(lane.id))
        assert [lane.height for lane in lanes] == [0.12, 0.06, 0.12]
        for lane in lanes:
            assert (abs(lane.predecessor or 0), abs(lane.successor or 0)) == (abs(lane.id) + 1, abs(lane.id) + 1)
        assert sorted(links[road.id]) == sorted((lane.predecessor, lane.id) for lane in lanes)


@pytest.mark.parametrize(
    ("strips", "kind", "height"),
    [
        # The kerb runs on where cars park on the carriageway.
        ((PARKING,), LaneType.SHOULDER, 0.0),
        ((replace(PARKING, type=LaneType.RESTRICTED),), LaneType.SHOULDER, 0.0),
        # Cars that park on the sidewalk, or beside a verge, stand above it.
        ((replace(PARKING, height=0.12),), LaneType.BORDER, 0.12),
        ((replace(PARKING, width=1.2), VERGE), LaneType.BORDER, 0.12),
    ],
)
@EITHER
def test_what_the_arms_have_not_both_is_filled(rule: Rule, strips: Strips, kind: LaneType, height: float) -> None:
    """From a sidewalk beyond 2.2 m of other strips to one at the kerb: the filling runs out, linked to nothing."""
    case = wide(X)
    parked = ((*strips, WALK), (*strips, WALK))
    roads = built(case, {1: parked, 2: parked, 3: BOTH, 4: BOTH}, rule)
    assert_sound(roads)
    assert len(corners(roads)) == 4
    for road in corners(roads):
        filling, walk = sorted(
            (lane for lane in road.lane_sections[0].lanes if lane.id), key=lambda lane: abs(lane.id)
        )
        assert (filling.type, filling.height, filling.predecessor, filling.successor) == (kind, height, None, None)
        assert walk.type is LaneType.SIDEWALK
        at = [lanes_across(roads, road, share) for share in (0.0, 0.5, 1.0)]
        assert [across[0][1] for across in at] == pytest.approx([1.5] * 3)
        assert sorted(across[0][2] for across in at) == pytest.approx([1.5, 2.6, 3.7])
        assert all(across[1][2] - across[1][1] == pytest.approx(2.0) for across in at)
    (junction,) = roads.junctions
    walks = {road.id for road in corners(roads)}
    assert all(len(item.lane_links) == 1 for item in junction.connections if item.connecting_road in walks)


@EITHER
def test_the_closed_side_of_a_t_is_filled(rule: Rule) -> None:
    """Parking lanes end at the junction, and the sidewalk beyond goes straight on: all between is paved."""
    case = wide(T)
    parked = ((PARKING, WALK), (PARKING, WALK))
    roads = built(case, everywhere(case, parked), rule)
    assert_sound(roads)
    side = 1 if rule is Rule.RIGHT_HAND else -1
    street = pose_at(roads.plan_view, 0, 0.0).y
    (straight,) = (road for road in corners(roads) if side * (middle_of(roads, road)[2][1] - street) > 0)
    for share in (0.0, 0.5, 1.0):
        kinds, inner, outer = zip(*lanes_across(roads, straight, share), strict=True)
        assert kinds == (LaneType.SHOULDER, LaneType.SIDEWALK)
        assert inner == pytest.approx([1.5, 3.7], abs=0.01)
        assert outer == pytest.approx([3.7, 5.7], abs=0.01)


@record
class _Slope(FlatSurface):
    """Exact ground that rises to the north."""

    grade: float = 0.0

    def heights(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, BoolArray]:
        return self.grade * y, np.ones(len(x), bool)


def widths_of_corners(roads: RoadMap) -> dict[frozenset[int], float]:
    """Return, by the ways that a corner joins, the width at the start of its sidewalk."""
    out = {}
    for road in corners(roads):
        links = (link for link in (road.predecessor, road.successor) if link is not None)
        ways = frozenset(roads.roads[link.id - 1].osm_way_ids[0] for link in links)
        out[ways] = sidewalk_of(road).widths[0].a
    return out


OUTER = {frozenset(pair): 2.0 for pair in ((1, 12), (3, 7), (4, 9), (6, 10))}
MEDIANS = {frozenset(pair): 1.46 for pair in ((3, 4), (1, 6), (7, 12), (9, 10))}


@EITHER
def test_sidewalks_grow_narrow_where_they_get_round_so_only(rule: Rule) -> None:
    """Carriageways with 3 m between them: sidewalks of 2 m cannot turn back into each other, but half of these can.

    Less the radius of the inner edge they keep 1.46 m, as arms end up to a centimetre nearer.
    """
    roads = built(CASES["dual_cross"].case, everywhere(CASES["dual_cross"].case), rule)
    assert_sound(roads)
    assert widths_of_corners(roads) == OUTER | MEDIANS
    (section,) = roads.roads[0].lane_sections
    length = curve_length(roads.plan_view, 0)
    walks = sorted(
        [width_at(lane.widths, s) for s in (0.0, length - 12.0, length - 6.0, length)]
        for lane in section.lanes
        if lane.type is LaneType.SIDEWALK
    )
    assert walks == [pytest.approx([2.0, 2.0, 1.76, 1.46]), pytest.approx([2.0] * 4)]


@pytest.mark.parametrize("grade", [0.04, 0.18])
@EITHER
def test_short_corners_on_slopes_are_kept(rule: Rule, grade: float) -> None:
    """Both carriageways are 10 m apart: between them the sidewalk is as steep as the ground."""
    case = CASES["dual_cross"].case
    diagnostics = Diagnostics()
    roads = built(case, everywhere(case), rule, _Slope(grade=grade), diagnostics)
    assert_sound(roads)
    assert widths_of_corners(roads).keys() == (OUTER | MEDIANS).keys()
    assert not [item for item in diagnostics if item.code == "sidewalk-corner"]


@EITHER
@pytest.mark.parametrize("apart", [16.0, 20.0, 24.0, 28.0, 34.0])
@pytest.mark.parametrize("verge", [4.0, 10.0])
def test_a_short_road_changes_for_the_corners_at_both_ends(rule: Rule, apart: float, verge: float) -> None:
    """Where a short road loses its verge for one corner, corners at its other end find its lanes all the same."""
    nodes = {"w": (-120.0, 0.0), "a": (0.0, 0.0), "b": (apart, 0.0), "e": (apart + 120.0, 0.0)}
    nodes |= {"n": (0.0, 100.0), "s": (apart, -100.0)}
    street = "highway=residential lanes=2 width=6"
    ways = {1: ("w a", street), 2: ("a b", street), 3: ("b e", street), 4: ("a n", street), 5: ("b s", street)}
    case = Case(nodes, ways)
    strips: Strips = (MarginSpec(LaneType.BORDER, verge), WALK)
    for margins in (everywhere(case, (strips, strips)), everywhere(case, ((WALK,), (WALK,))) | {2: (strips, strips)}):
        assert_sound(built(case, margins, rule))


@EITHER
def test_corners_lead_where_the_ids_of_their_lanes_do(rule: Rule) -> None:
    # Cars turn from 1 to 4 only, so that the sidewalks between those two lie left of them.
    case = Case(X.nodes, {1: ("w o", "oneway=yes"), 4: ("o n", "oneway=yes"), 3: ("s o", "")})
    roads = built(case, everywhere(case), rule)
    by_id = {road.id: road for road in roads.roads}
    along = -1 if rule is Rule.RIGHT_HAND else 1
    links = {
        connection.connecting_road: (by_id[connection.incoming_road], connection.lane_links)
        for junction in roads.junctions
        for connection in junction.connections
    }
    assert len(corners(roads)) == 3
    for road in corners(roads):
        walk = sidewalk_of(road)
        before, after = road.predecessor, road.successor
        assert before is not None
        assert after is not None
        assert walk.predecessor is not None
        assert walk.successor is not None
        assert walk.id * along > 0
        # Out of the end of its road, or against it out of its start; likewise into the next.
        assert (walk.predecessor * along > 0) == (not before.at_start)
        assert (walk.successor * along > 0) == bool(after.at_start)
        incoming, pairs = links[road.id]
        assert incoming.id == before.id
        assert (walk.predecessor, walk.id) in pairs


@EITHER
def test_a_sidewalk_goes_round_cars_that_turn_back(rule: Rule) -> None:
    """Cars swing out to turn back between streets that part at 30 degrees; the sidewalk opposite goes round them."""
    nodes = {"w": (-120.0, 0.0), "o": (0.0, 0.0), "e": (120.0, 0.0), "s": (-103.9, -60.0)}
    street = "lanes=2 width=6"
    case = Case(nodes, {1: ("w o", street), 2: ("o e", street), 3: ("s o", street)})
    diagnostics = Diagnostics()
    roads = built(case, everywhere(case), rule, diagnostics=diagnostics)
    assert_sound(roads)
    assert len(corners(roads)) == 3
    assert not [item for item in diagnostics if item.code == "sidewalk-corner"]
    measures = RoadMeasures(roads)
    for walk in corners(roads):
        places = middle_of(roads, walk, np.linspace(0.1, 0.9, 9).tolist())
        for road in roads.roads:
            if road.junction != walk.junction or road in corners(roads):
                continue
            for s in np.linspace(0.0, measures.length(road), 40).tolist():
                (edges,) = (measures.edges(road, 0, s)[lane.id] for lane in driven(road))
                here = measures.pose(road, s).beside(sum(edges) / 2)
                nearest = min(math.hypot(x - here.x, y - here.y) for x, y in places)
                assert nearest > abs(edges[0] - edges[1]) / 2

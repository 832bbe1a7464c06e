"""Areas made by hand become streets and intersections."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from osm_builder import Area, about, nodes_of, ways_of, write_osm

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import Direction, Rule, StreetNetwork, Structure
from osm2xodr.osmParsing import ParseOptions, parse_osm, parse_ways_option

ROAD = "highway=unclassified lanes=2 width=6"
ONEWAY = "highway=residential oneway=yes lanes=1 width=3"
# Nodes 1 to 9 in a row from west to east, every 100 m, and nodes 11 to 19 100 m north of them.
ROW = {k: (100.0 * k, 0.0) for k in range(1, 10)} | {10 + k: (100.0 * k, 100.0) for k in range(1, 10)}


def ends_of(network: StreetNetwork) -> list[tuple[int, int]]:
    """OSM ids of the nodes that each street starts and ends at; -1 for rings."""
    ids = {item.id: item.osm_node_id for item in network.intersections} | {-1: -1}
    return [(ids[street.start], ids[street.end]) for street in network.streets]


# ---------------------------------------------------------------- streets and intersections


def test_ways_in_a_row_are_one_street(tmp_path: Path) -> None:
    area = Area(ROW, {20: ([3, 2, 1], ROAD), 21: ([3, 4], ROAD + " name=B"), 22: ([4, 5, 6], ROAD)})
    network, diagnostics = area.parse(tmp_path)
    assert nodes_of(network) == [[6, 5, 4, 3, 2, 1]]
    assert ways_of(network) == [[(22, True), (21, True), (20, False)]]
    assert [index for index, _ in network.streets[0].pieces] == [0, 2, 3]
    assert network.streets[0].pieces[1][1].name == "B"
    assert ends_of(network) == [(6, 1)]
    assert [item.arms for item in network.intersections] == [((0, False),), ((0, True),)]
    assert list(diagnostics) == []


def test_points_are_metres_from_the_middle(tmp_path: Path) -> None:
    network, _ = Area(ROW, {20: ([1, 2, 3, 12], ROAD)}).parse(tmp_path)
    (street,) = network.streets
    assert street.points - street.points[1] == pytest.approx(
        np.array([[-100, 0], [0, 0], [100, 0], [0, 100]]), abs=0.05
    )
    # The origin is rounded to 1e-5 degrees.
    assert street.points.min(axis=0) == pytest.approx([-100.0, -50.0], abs=0.6)
    assert not street.points.flags.writeable
    assert (network.frame.lat_0_deg, network.frame.lon_0_deg) == (50.00045, 10.00279)
    assert [(item.x, item.y) for item in network.intersections] == [tuple(street.points[0]), tuple(street.points[3])]
    assert network.bounds_deg == pytest.approx((10.0013948, 50.0, 10.0041843, 50.0008991), abs=1e-6)


def test_where_three_meet_there_is_an_intersection(tmp_path: Path) -> None:
    network, _ = Area(ROW, {20: ([1, 2, 3, 4, 5], ROAD), 21: ([13, 3], ROAD), 22: ([14, 13], ROAD)}).parse(tmp_path)
    assert nodes_of(network) == [[1, 2, 3], [3, 4, 5], [14, 13, 3]]
    assert ways_of(network) == [[(20, False)], [(20, False)], [(22, False), (21, False)]]
    assert [(item.osm_node_id, item.arms) for item in network.intersections] == [
        (1, ((0, True),)),
        (3, ((0, False), (1, True), (2, False))),
        (5, ((1, False),)),
        (14, ((2, True),)),
    ]


def test_streets_run_along_one_way_pieces(tmp_path: Path) -> None:
    area = Area(ROW, {20: ([1, 2], ROAD), 21: ([3, 2], ONEWAY), 22: ([3, 4], "highway=primary oneway=-1 lanes=2")})
    network, _ = area.parse(tmp_path)
    assert nodes_of(network) == [[4, 3, 2, 1]]
    assert ways_of(network) == [[(22, True), (21, False), (20, True)]]
    runs = [[lane.direction for lane in piece.lanes_ltr] for _, piece in network.streets[0].pieces]
    assert runs == [[Direction.FORWARD] * 2, [Direction.FORWARD], [Direction.BACKWARD, Direction.FORWARD]]


def test_head_on_one_ways_meet_at_an_intersection(tmp_path: Path) -> None:
    network, _ = Area(ROW, {20: ([1, 2], ONEWAY), 21: ([3, 2], ONEWAY)}).parse(tmp_path)
    assert nodes_of(network) == [[1, 2], [3, 2]]
    assert [item.arms for item in network.intersections if item.osm_node_id == 2] == [((0, False), (1, False))]


def test_one_ways_against_each_other_break_a_street(tmp_path: Path) -> None:
    network, _ = Area(ROW, {20: ([1, 2], ONEWAY), 21: ([2, 3], ROAD), 22: ([4, 3], ONEWAY)}).parse(tmp_path)
    assert nodes_of(network) == [[1, 2, 3], [4, 3]]


@pytest.mark.parametrize(
    ("way", "node", "streets", "ends"),
    [
        # A ring by itself has no intersection.
        ([1, 2, 12, 11, 1], ROAD, [[1, 2, 12, 11, 1]], [(-1, -1)]),
        ([1, 2, 12, 11, 1], "highway=residential oneway=-1", [[1, 11, 12, 2, 1]], [(-1, -1)]),
        # A loop at the end of a street, an eight, and a way that crosses itself.
        ([5, 1, 2, 12, 11, 1], ROAD, [[5, 1], [1, 2, 12, 11, 1]], [(5, 1), (1, 1)]),
        ([1, 2, 12, 1, 3, 13, 1], ROAD, [[1, 2, 12, 1], [1, 3, 13, 1]], [(1, 1), (1, 1)]),
        ([1, 2, 3, 13, 12, 2, 4], ROAD, [[1, 2], [2, 3, 13, 12, 2], [2, 4]], [(1, 2), (2, 2), (2, 4)]),
        # Out and back over the same nodes.
        ([1, 2, 1], ROAD, [[1, 2]], [(1, 2)]),
        ([1, 2, 3, 2], ROAD, [[1, 2, 3]], [(1, 3)]),
        ([1, 2, 3, 2, 1], ROAD, [[1, 2, 3]], [(1, 3)]),
        # Nodes that follow themselves.
        ([1, 1, 2, 2, 2, 3], ROAD, [[1, 2, 3]], [(1, 3)]),
    ],
)
def test_ways_that_visit_nodes_twice(
    tmp_path: Path, way: list[int], node: str, streets: list[list[int]], ends: list[tuple[int, int]]
) -> None:
    network, _ = Area(ROW, {20: (way, node)}).parse(tmp_path)
    assert nodes_of(network) == streets
    assert ends_of(network) == ends


def test_a_roundabout_is_cut_at_its_arms(tmp_path: Path) -> None:
    ring = ([2, 3, 13, 12, 2], "highway=tertiary junction=roundabout lanes=1")
    network, _ = Area(ROW, {20: ring, 21: ([1, 2], ROAD), 22: ([13, 14], ROAD)}).parse(tmp_path)
    assert nodes_of(network) == [[2, 3, 13], [13, 12, 2], [1, 2], [13, 14]]
    assert [street.pieces[0][1].roundabout for street in network.streets] == [True, True, False, False]


def test_ways_on_top_of_others_are_left_out(tmp_path: Path) -> None:
    area = Area(ROW, {20: ([1, 2, 3, 4], ROAD), 21: ([3, 2], ROAD), 22: ([4, 5], ROAD)})
    network, diagnostics = area.parse(tmp_path)
    assert nodes_of(network) == [[1, 2, 3, 4, 5]]
    assert ways_of(network) == [[(20, False), (22, False)]]
    assert [(item.kind, item.code, item.osm_id) for item in diagnostics] == [
        (Kind.DROPPED, "duplicate-way", "way/21")
    ]


def test_nodes_at_one_place_are_one_node(tmp_path: Path) -> None:
    nodes = ROW | {30: (200.0004, 0.0), 31: (200.0004, 0.0)}
    area = Area(
        nodes,
        {20: ([1, 2, 31, 30], ROAD), 21: ([30, 3], ROAD), 22: ([31, 12], ROAD)},
        node_tags={30: "highway=stop a=b"},
    )
    network, diagnostics = area.parse(tmp_path)
    assert nodes_of(network) == [[1, 2], [2, 3], [2, 12]]
    assert [(item.osm_id, item.kind) for item in about(diagnostics, "same-place")] == [
        ("node/30", Kind.REPAIRED),
        ("node/31", Kind.REPAIRED),
    ]
    assert network.node_tags == {2: {"highway": "stop"}}


def test_absent_nodes(tmp_path: Path) -> None:
    # 99 and 98 are absent: 100 m are bridged, 300 m are not.
    area = Area(
        ROW,
        {
            20: ([1, 99, 2], ROAD),
            21: ([3, 4, 98, 99, 7, 8], ROAD),
            22: ([13, 98, 16], ROAD),
            23: ([97, 98], ROAD),
            24: ([99, 11, 98], ROAD),
            25: ([], ROAD),
        },
    )
    network, diagnostics = area.parse(tmp_path)
    assert nodes_of(network) == [[1, 2], [3, 4], [7, 8]]
    said = [(item.osm_id, item.kind.value) for item in about(diagnostics, "absent-node")]
    assert said == [(f"way/{k}", "dropped") for k in (20, 21, 22, 23, 24)] + [
        ("way/21", "repaired"),
        ("way/22", "repaired"),
    ]
    assert [item.osm_id for item in about(diagnostics, "short-way")] == ["way/23", "way/24", "way/25"]


def test_repeated_elements_count_once(tmp_path: Path) -> None:
    elements = Area(ROW, {20: ([1, 2], ROAD), 21: ([2, 3], ROAD)}).elements()
    diagnostics = Diagnostics()
    network = parse_osm(write_osm(tmp_path, elements + elements), ParseOptions(), diagnostics)
    assert nodes_of(network) == [[1, 2, 3]]
    assert list(diagnostics) == []


def test_large_and_negative_ids(tmp_path: Path) -> None:
    big = 2**62
    area = Area(
        {big: (0.0, 0.0), -1: (50.0, 0.0), -big: (100.0, 0.0)}, {big: ([big, -1], ROAD), -big: ([-1, -big], ROAD)}
    )
    network, _ = area.parse(tmp_path)
    assert nodes_of(network) == [[big, -1, -big]]
    assert ways_of(network) == [[(big, False), (-big, False)]]


# ---------------------------------------------------------------- tags


def test_attributes_of_a_way(tmp_path: Path) -> None:
    tags = (
        "highway=secondary name=Main ref=B3 lanes=3 lanes:backward=2 width:lanes:forward=4 width:lanes:backward=2|3 "
        "placement:forward=left_of:1 maxspeed=50 maxspeed:backward=30 bridge=yes incline=8% "
        "turn:lanes:backward=left|right"
    )
    network, diagnostics = Area(ROW, {20: ([1, 2], tags)}).parse(tmp_path)
    ((_, piece),) = network.streets[0].pieces
    assert (piece.osm_way_id, piece.reversed, piece.highway, piece.name, piece.ref) == (
        20,
        False,
        "secondary",
        "Main",
        "B3",
    )
    assert [(int(lane.direction), lane.width, sorted(lane.turns)) for lane in piece.lanes_ltr] == [
        (-1, 3.0, ["right"]),
        (-1, 2.0, ["left"]),
        (1, 4.0, []),
    ]
    assert piece.middle_offset == pytest.approx(5.0 - 4.5)
    assert [piece.speed_forward, piece.speed_backward] == pytest.approx([50 / 3.6, 30 / 3.6])
    assert (piece.structure, piece.layer, piece.roundabout) == (Structure.BRIDGE, 1, False)
    assert piece.grade == pytest.approx(0.08)
    assert list(diagnostics) == []


def test_attributes_turn_with_the_street(tmp_path: Path) -> None:
    tags = (
        "highway=secondary oneway=-1 lanes=2 width:lanes=3|4 placement=left_of:1 maxspeed:forward=30 "
        "maxspeed:backward=60 tunnel=yes incline=-8% turn:lanes=left|right"
    )
    network, _ = Area(ROW, {20: ([1, 2], tags)}).parse(tmp_path)
    ((_, piece),) = network.streets[0].pieces
    assert nodes_of(network) == [[2, 1]]
    assert piece.reversed
    # As drivers see them, and as they stand along the street.
    assert [(int(lane.direction), lane.width, sorted(lane.turns)) for lane in piece.lanes_ltr] == [
        (1, 3.0, ["left"]),
        (1, 4.0, ["right"]),
    ]
    assert piece.middle_offset == pytest.approx(-3.5)
    assert [piece.speed_forward, piece.speed_backward] == pytest.approx([60 / 3.6, 30 / 3.6])
    assert (piece.structure, piece.layer) == (Structure.TUNNEL, -1)
    assert piece.grade == pytest.approx(0.08)


@pytest.mark.parametrize(
    ("tags", "structure", "layer"),
    [
        ("", Structure.GROUND, 0),
        ("bridge=yes", Structure.BRIDGE, 1),
        ("bridge=viaduct layer=2", Structure.BRIDGE, 2),
        ("bridge=no", Structure.GROUND, 0),
        ("tunnel=yes", Structure.TUNNEL, -1),
        ("tunnel=yes layer=-3", Structure.TUNNEL, -3),
        ("tunnel=no", Structure.GROUND, 0),
        ("tunnel=building_passage", Structure.GROUND, 0),
        ("tunnel=avalanche_protector", Structure.GROUND, 0),
        ("covered=yes layer=-1", Structure.GROUND, -1),
        ("bridge=yes layer=0", Structure.BRIDGE, 0),
        ("tunnel=yes layer=-1;0", Structure.TUNNEL, -1),
        ("bridge=yes layer=high", Structure.BRIDGE, 1),
    ],
)
def test_structures(tmp_path: Path, tags: str, structure: Structure, layer: int) -> None:
    network, _ = Area(ROW, {20: ([1, 2], f"{ROAD} {tags}")}).parse(tmp_path)
    ((_, piece),) = network.streets[0].pieces
    assert (piece.structure, piece.layer) == (structure, layer)


@pytest.mark.parametrize(
    ("tags", "code", "kind"),
    [
        ("maxspeed=signals", "speed", Kind.DROPPED),
        ("maxspeed=fast", "speed", Kind.DROPPED),
        ("layer=high", "layer", Kind.DROPPED),
        ("layer=-1;0", "layer", Kind.GUESSED),
        ("incline=steep", "incline", Kind.DROPPED),
        ("oneway=alternating", "oneway", Kind.GUESSED),
        ("oneway=perhaps", "oneway", Kind.DROPPED),
        ("motor_vehicle:backward=no", "oneway", Kind.NOTE),
    ],
)
def test_what_tags_leave_open_is_said(tmp_path: Path, tags: str, code: str, kind: Kind) -> None:
    _, diagnostics = Area(ROW, {20: ([1, 2], f"{ROAD} {tags}")}).parse(tmp_path)
    assert [(item.kind, item.code, item.osm_id) for item in diagnostics] == [(kind, code, "way/20")]


@pytest.mark.parametrize("tags", ["incline=up", "incline=down", "maxspeed=none", "oneway=no"])
def test_what_needs_no_word(tmp_path: Path, tags: str) -> None:
    network, diagnostics = Area(ROW, {20: ([1, 2], f"{ROAD} {tags}")}).parse(tmp_path)
    assert list(diagnostics) == []
    ((_, piece),) = network.streets[0].pieces
    assert piece.grade is None
    assert piece.speed_forward == (math.inf if "none" in tags else None)


def test_tags_of_nodes_on_streets(tmp_path: Path) -> None:
    area = Area(ROW, {20: ([1, 2, 3], ROAD)}, node_tags={2: "highway=stop direction=forward", 5: "highway=stop"})
    network, _ = area.parse(tmp_path)
    assert network.node_tags == {2: {"highway": "stop", "direction": "forward"}}


def test_restrictions_of_carried_ways(tmp_path: Path) -> None:
    members = [("way", 20, "from"), ("node", 2, "via"), ("way", 21, "to")]
    area = Area(
        ROW,
        {20: ([1, 2], ROAD), 21: ([2, 3], ROAD), 22: ([2, 12], ROAD), 23: ([2, 11], "highway=footway")},
        {
            9: (members, "type=restriction restriction=no_left_turn"),
            8: ([*members[:2], ("way", 22, "to")], "type=restriction restriction=only_right_turn"),
            7: ([*members[:2], ("way", 23, "to")], "type=restriction restriction=no_right_turn"),
        },
    )
    network, diagnostics = area.parse(tmp_path)
    assert [(item.osm_relation_id, item.only, item.to_ways) for item in network.restrictions] == [
        (8, True, (22,)),
        (9, False, (21,)),
    ]
    assert [item.osm_id for item in about(diagnostics, "restriction")] == ["relation/7"]


# ---------------------------------------------------------------- which ways


def test_which_ways_are_carried(tmp_path: Path) -> None:
    area = Area(
        ROW,
        {
            20: ([1, 2], ROAD),
            21: ([2, 3], "highway=service service=driveway"),
            22: ([3, 4], ROAD + " access=private"),
            23: ([4, 5], "highway=footway"),
            24: ([5, 6], "highway=construction construction=primary"),
            25: ([6, 7, 17, 6], "highway=service area=yes"),
            26: ([7, 8], "highway=track"),
            27: ([8, 9], "building=yes"),
            28: ([8, 9], "highway=track"),
            29: ([8, 10], "highway=pedestrian"),
            30: ([9, 10], "highway=Primary"),
            31: ([9, 11], "highway=bus_guideway barrier=fence"),
            32: ([9, 12], "highway=track area=yes"),
            33: ([9, 12], "highway=steps"),
        },
    )

    def carried(options: ParseOptions) -> tuple[list[int], list[tuple[str, str, str]]]:
        network, diagnostics = area.parse(tmp_path, options)
        ways = sorted({way for street in ways_of(network) for way, _ in street})
        return ways, [(item.kind.value, item.code, item.osm_id) for item in diagnostics if "lane" not in item.code]

    told = [
        ("dropped", "closed", "way/22"),
        ("dropped", "not-built", "way/24"),
        ("dropped", "area", "way/25"),
        ("note", "way-selection", ""),
        ("dropped", "highway-class", "way/30"),
        ("dropped", "highway-class", "way/31"),
        ("note", "way-selection", ""),
        ("note", "way-selection", ""),
    ]
    assert carried(ParseOptions()) == ([20], told)
    assert carried(ParseOptions(furniture=False)) == ([20], told)
    assert carried(ParseOptions(include_private=True))[0] == [20, 22]
    assert carried(ParseOptions(parse_ways_option("all")))[0] == [20, 21, 26, 28]
    assert carried(ParseOptions(parse_ways_option("track,unclassified"), include_private=True))[0] == [20, 22, 26, 28]


def test_ways_that_are_left_out_are_told_by_kind(tmp_path: Path) -> None:
    ways = {20: ([1, 2], ROAD), 21: ([2, 3], "highway=track"), 22: ([3, 4], "highway=track access=no")}
    ways |= {23: ([4, 5], "highway=service service=driveway"), 24: ([5, 6], "highway=" + "x" * 99)}
    _, diagnostics = Area(ROW, ways).parse(tmp_path)
    assert [item.message for item in about(diagnostics, "way-selection")] == [
        "1 way left out: service=driveway is not among the ways asked for",
        "2 ways left out: highway=track is not among the ways asked for",
    ]
    assert [(item.osm_id, item.message) for item in about(diagnostics, "highway-class")] == [
        ("way/24", f"highway={'x' * 37}... is not a class of roads that can be carried, it is left out")
    ]


def test_what_stands_on_the_road_and_is_not_carried_is_told(tmp_path: Path) -> None:
    tags = {
        2: "barrier=lift_gate access=no",
        3: "railway=level_crossing",
        4: "highway=mini_roundabout",
        5: "barrier=entrance",
        6: "highway=crossing",
        8: "barrier=gate",
    }
    area = Area(ROW, {20: ([1, 2, 3, 4, 5, 6], ROAD), 21: ([7, 8, 9], "highway=footway")}, node_tags=tags)
    _, diagnostics = area.parse(tmp_path)
    told = [(item.kind.value, item.osm_id, item.message) for item in about(diagnostics, "street-node")]
    assert told == [
        ("dropped", "node/2", "barrier=lift_gate on the road is not carried, the street is open there"),
        ("dropped", "node/3", "railway=level_crossing is not carried, the street is open there"),
        ("dropped", "node/4", "highway=mini_roundabout is taken as a plain junction"),
    ]


def test_roads_of_unknown_class_are_carried_as_unclassified(tmp_path: Path) -> None:
    found = {}
    for highway in ("road", "unclassified"):
        network, diagnostics = Area(ROW, {20: ([1, 2], f"highway={highway}")}).parse(tmp_path)
        ((_, piece),) = network.streets[0].pieces
        assert piece.highway == highway
        found[highway] = replace(piece, highway="")
        told = [(item.kind.value, item.osm_id, item.message) for item in about(diagnostics, "highway-class")]
        words = "highway=road has no known class, taken as unclassified"
        assert told == ([("guessed", "way/20", words)] if highway == "road" else [])
    assert found["road"] == found["unclassified"]


# ---------------------------------------------------------------- order


def same(one: StreetNetwork, other: StreetNetwork) -> bool:
    """Whether two networks are equal in all that they hold."""
    return (
        (one.frame, one.rule, one.country, one.intersections, one.restrictions, one.node_tags, one.bounds_deg)
        == (
            other.frame,
            other.rule,
            other.country,
            other.intersections,
            other.restrictions,
            other.node_tags,
            other.bounds_deg,
        )
        and list(one.node_tags) == list(other.node_tags)
        and len(one.streets) == len(other.streets)
        and all(
            (a.id, a.start, a.end, a.pieces) == (b.id, b.start, b.end, b.pieces)
            and a.points.tobytes() == b.points.tobytes()
            and a.node_ids.tobytes() == b.node_ids.tobytes()
            for a, b in zip(one.streets, other.streets, strict=True)
        )
    )


@st.composite
def areas(draw: st.DrawFn) -> Area:
    place = st.integers(0, 5)
    nodes = {
        number: (40.0 * draw(place), 40.0 * draw(place))
        for number in draw(st.lists(st.integers(1, 12), min_size=3, unique=True))
    }
    refs = st.lists(st.integers(1, 12), min_size=1, max_size=6)
    tags = st.sampled_from([ROAD, ONEWAY, "highway=primary oneway=-1", "highway=service", "highway=tertiary lanes=3"])
    ways = {
        number: (draw(refs), draw(tags))
        for number in draw(st.lists(st.integers(1, 99), min_size=1, max_size=8, unique=True))
    }
    marked = {number: "highway=stop" for number in list(nodes)[::2]}
    return Area(nodes, ways, node_tags=marked)


def parsed_or_error(path: Path) -> tuple[StreetNetwork | None, str, list[object]]:
    diagnostics = Diagnostics()
    try:
        return parse_osm(path, ParseOptions(), diagnostics), "", list(diagnostics)
    except Exception as error:  # whatever it is, it must be the same
        return None, f"{type(error).__name__} {error}", []


@given(areas(), st.randoms(use_true_random=False))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_the_order_of_elements_does_not_matter(tmp_path: Path, area: Area, rng: random.Random) -> None:
    elements = area.elements()
    one, error, said = parsed_or_error(write_osm(tmp_path, elements))
    shuffled = elements.copy()
    rng.shuffle(shuffled)
    other, other_error, other_said = parsed_or_error(write_osm(tmp_path, shuffled))
    assert (error, said) == (other_error, other_said)
    assert error == "" or error.startswith("InputError ")
    if one is not None and other is not None:
        assert same(one, other)


@given(areas())
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_what_holds_of_every_network(tmp_path: Path, area: Area) -> None:
    network, error, _ = parsed_or_error(area.write(tmp_path))
    if network is None:
        assert error.startswith("InputError ")
        return
    for number, street in enumerate(network.streets):
        assert street.id == number
        assert len(street.points) == len(street.node_ids) >= 2
        assert (np.hypot(*np.diff(street.points, axis=0).T) >= 1e-3).all()
        assert (street.start < 0) == (street.end < 0)
        assert street.start >= 0 or street.node_ids[0] == street.node_ids[-1]
        indices = [index for index, _ in street.pieces]
        assert indices == sorted(set(indices))
        assert indices[0] == 0
        assert indices[-1] < len(street.points) - 1
        for _, piece in street.pieces:
            assert Direction.FORWARD in {lane.direction for lane in piece.lanes_ltr}
    arms = sorted((street, at_start) for item in network.intersections for street, at_start in item.arms)
    assert arms == sorted((s.id, at_start) for s in network.streets if s.start >= 0 for at_start in (True, False))
    for item in network.intersections:
        for number, at_start in item.arms:
            street = network.streets[number]
            assert (street.start if at_start else street.end) == item.id
            assert street.node_ids[0 if at_start else -1] == item.osm_node_id
            assert tuple(street.points[0 if at_start else -1]) == (item.x, item.y)
    assert [item.osm_node_id for item in network.intersections] == sorted(
        i.osm_node_id for i in network.intersections
    )


# ---------------------------------------------------------------- the side of the road


@pytest.mark.parametrize(
    ("lat", "lon", "tags", "asked", "country", "rule", "codes"),
    [
        (50.0, 10.0, "", None, "DE", Rule.RIGHT_HAND, []),
        (51.5, -0.1, "", None, "GB", Rule.LEFT_HAND, []),
        (51.5, -0.1, "", Rule.RIGHT_HAND, "GB", Rule.RIGHT_HAND, []),
        (50.0, 10.0, "", Rule.LEFT_HAND, "DE", Rule.LEFT_HAND, []),
        # Most streets are tagged, or one of many.
        (50.0, 10.0, "driving_side=left", None, "DE", Rule.LEFT_HAND, []),
        (50.0, 10.0, "driving_side=left", Rule.RIGHT_HAND, "DE", Rule.RIGHT_HAND, ["driving-side"] * 2),
        (50.45, -1.0, "", None, "GB", Rule.LEFT_HAND, []),
        (50.2, -1.0, "", None, "", Rule.RIGHT_HAND, ["driving-side"]),
        (30.0, -40.0, "", None, "", Rule.RIGHT_HAND, ["driving-side"]),
    ],
)
def test_driving_side(
    tmp_path: Path, lat: float, lon: float, tags: str, asked: Rule | None, country: str, rule: Rule, codes: list[str]
) -> None:
    ways = {20: ([1, 2], f"{ROAD} {tags}"), 21: ([2, 3], f"{ROAD} {tags}"), 22: ([3, 4], ROAD)}
    network, diagnostics = Area(ROW, ways, lat_0=lat, lon_0=lon).parse(tmp_path, ParseOptions(rule=asked))
    assert (network.country, network.rule) == (country, rule)
    assert [item.code for item in diagnostics] == codes
    runs = [int(lane.direction) for lane in network.streets[0].pieces[0][1].lanes_ltr]
    assert runs == ([-1, 1] if rule is Rule.RIGHT_HAND else [1, -1])


def test_a_single_exception_does_not_turn_the_city_round(tmp_path: Path) -> None:
    ways = {20: ([1, 2], ROAD), 21: ([2, 3], ROAD), 22: ([3, 4], ROAD + " driving_side=left")}
    network, diagnostics = Area(ROW, ways).parse(tmp_path)
    assert network.rule is Rule.RIGHT_HAND
    assert [(item.kind, item.code, item.osm_id) for item in diagnostics] == [(Kind.DROPPED, "driving-side", "way/22")]


# ---------------------------------------------------------------- where on Earth


def test_across_the_180th_meridian(tmp_path: Path) -> None:
    network, _ = Area(ROW, {20: ([1, 2, 3], ROAD)}, lat_0=-16.8, lon_0=179.998).parse(tmp_path)
    assert network.country == "FJ"
    assert network.frame.lon_0_deg == pytest.approx(-179.99921, abs=1e-5)
    west, _, east, _ = network.bounds_deg
    assert 179.999 < west < 180.0 < east < 180.01
    # Longitudes are shorter in metres at 50 than at 16.8 degrees.
    length = np.hypot(*np.diff(network.streets[0].points, axis=0).T)
    assert length == pytest.approx(
        np.full(2, 100.0 * math.cos(math.radians(16.8)) / math.cos(math.radians(50.0))), rel=2e-3
    )


def test_a_large_area_is_said(tmp_path: Path) -> None:
    _, diagnostics = Area({1: (0.0, 0.0), 2: (210e3, 0.0)}, {20: ([1, 2], ROAD)}).parse(tmp_path)
    (item,) = diagnostics
    assert (item.kind, item.code) == (Kind.NOTE, "extent")
    assert "105 km" in item.message


def test_the_line_moves_among_the_lanes(tmp_path: Path) -> None:
    """Three lanes of 3 m: the line is 3 m right of the left edge at first (offset -1.5 m), 9 m at last (4.5 m)."""
    road = "highway=primary oneway=yes lanes=3 width=9 placement={}"
    ways = {
        20: ([1, 2], road.format("right_of:1")),
        21: ([2, 3], road.format("transition")),
        22: ([3, 4], road.format("transition")),
        23: ([4, 5], road.format("right_of:3")),
        24: ([5, 6], road.format("transition")),
    }
    network, diagnostics = Area(ROW, ways).parse(tmp_path)
    (street,) = network.streets
    offsets = [piece.middle_offset for _, piece in street.pieces]
    assert offsets == pytest.approx([-1.5, 0.5, 2.5, 4.5, 0.0])
    assert [item.osm_id for item in about(diagnostics, "placement")] == ["way/21", "way/22", "way/24"]

"""From which street to which one may drive: one-ways, restrictions at nodes and over ways, inside one junction.

Lanes for buses and bicycles against one-way streets lead straight on through junctions; no car gets onto them.
"""

from __future__ import annotations

import pytest
from street_cases import Case, Stages

from osm2xodr.geometry.junctions import Movement, with_movements_against_cars
from osm2xodr.model import LaneType, Rule

_NODES = {"w": (-80.0, 0.0), "o": (0.0, 0.0), "e": (80.0, 0.0), "s": (0.0, -80.0), "n": (0.0, 80.0)}
_WAYS = {1: ("w o", ""), 2: ("o e", ""), 3: ("s o", ""), 4: ("o n", "")}
_ALL = {(one, other) for one in (1, 2, 3, 4) for other in (1, 2, 3, 4) if one != other}
# Two Ts, 8 m apart; way 5 between them lies inside the junction.
_OFFSET = Case(
    {**_NODES, "a": (-4.0, 0.0), "b": (4.0, 0.0), "s": (-4.0, -80.0), "n": (4.0, 80.0)},
    {1: ("w a", ""), 2: ("b e", ""), 3: ("s a", ""), 4: ("b n", ""), 5: ("a b", "")},
)

Rules = tuple[tuple[str, int, str, int], ...]

_AGAINST = "oneway=yes lanes=2 busway:left=opposite_lane"
_CYCLES = "oneway=yes cycleway:left=lane cycleway:left:oneway=-1 oneway:bicycle=no"
_CROSSED = {3: ("s o", ""), 4: ("o n", "")}


def pairs(stages: Stages) -> list[tuple[int, int]]:
    """Return (from way, to way) of all movements, sorted."""
    return sorted((stages.way(item.entry), stages.way(item.exit)) for item in stages.movements)


@pytest.mark.parametrize(
    ("rules", "missing"),
    [
        ((), set()),
        ((("no_left_turn", 1, "o", 4),), {(1, 4)}),
        ((("no_left_turn", 1, "o", 4), ("no_right_turn", 1, "o", 3)), {(1, 4), (1, 3)}),
        ((("only_straight_on", 1, "o", 2),), {(1, 3), (1, 4)}),
        ((("only_left_turn", 1, "o", 4), ("only_straight_on", 1, "o", 2)), {(1, 3)}),
        ((("only_straight_on", 3, "o", 4), ("no_straight_on", 4, "o", 3)), {(3, 1), (3, 2), (4, 3)}),
        ((("no_left_turn", 1, "n", 4),), set()),
        ((("no_u_turn", 1, "o", 1),), set()),
    ],
)
def test_restrictions_at_a_node(rules: Rules, missing: set[tuple[int, int]]) -> None:
    assert pairs(Case(_NODES, _WAYS, rules).stages()) == sorted(_ALL - missing)


@pytest.mark.parametrize(
    ("rules", "found"),
    [
        ((("no_straight_on", 1, "o", 2),), [(2, 1)]),
        # The only way on is none for cars, or outside of the area.
        ((("only_left_turn", 1, "o", 9),), [(2, 1)]),
        ((("no_straight_on", 1, "o", 2), ("no_straight_on", 2, "o", 1)), []),
        # One street, without any junction.
        ((("no_u_turn", 1, "o", 1),), None),
        ((("only_straight_on", 1, "o", 2),), None),
    ],
)
def test_restrictions_where_two_streets_meet(rules: Rules, found: list[tuple[int, int]] | None) -> None:
    for side in (Rule.RIGHT_HAND, Rule.LEFT_HAND):
        case = Case(_NODES, {1: ("w o", ""), 2: ("o e", "")}, rules)
        case = case if side is Rule.RIGHT_HAND else case.mirrored()
        stages = case.stages(side)
        assert len(stages.network.streets) == (1 if found is None else 2)
        assert pairs(stages) == (found or [])
        plain = [road for road in case.build(side).roads if road.junction is None]
        through = [road for road in case.build(side).roads if road.junction is not None]
        assert [road.osm_way_ids for road in plain] == ([(1, 2)] if found is None else [(1,), (2,)])
        assert len(through) == len(found or [])


def test_one_ways_are_entered_and_left_only_along() -> None:
    ways = {**_WAYS, 2: ("o e", "oneway=yes"), 3: ("s o", "oneway=yes")}
    found = pairs(Case(_NODES, ways).stages())
    assert found == sorted((one, other) for one, other in _ALL if one != 2 and other != 3)
    ways[2] = ("o e", "oneway=-1")
    found = pairs(Case(_NODES, ways).stages())
    assert found == sorted((one, other) for one, other in _ALL if other not in (2, 3))


@pytest.mark.parametrize("drawn", ["m o", "o m"])
def test_restrictions_name_the_way_that_a_street_has_at_the_junction(drawn: str) -> None:
    """The street from the west is way 1 at first, and way 6 at the junction."""
    nodes = {**_NODES, "m": (-40.0, 0.0)}
    ways = {**_WAYS, 1: ("w m" if drawn == "m o" else "m w", "name=A"), 6: (drawn, "name=B")}
    every = {(6 if one == 1 else one, 6 if other == 1 else other) for one, other in _ALL}
    named = Case(nodes, ways, (("no_left_turn", 6, "o", 4), ("no_straight_on", 2, "o", 6)))
    assert pairs(named.stages()) == sorted(every - {(6, 4), (2, 6)})
    other = Case(nodes, ways, (("no_left_turn", 1, "o", 4), ("no_straight_on", 2, "o", 1)))
    assert pairs(other.stages()) == sorted(every)


@pytest.mark.parametrize("first", [1, 2, 3, 4])
def test_restrictions_name_the_way_at_the_start_of_a_street(first: int) -> None:
    """All streets lead away, and are other ways from half of their length on: 11 to 14."""
    ends = dict(enumerate("wesn", start=1))
    nodes = {**_NODES, **{f"m{way}": (_NODES[end][0] / 2, _NODES[end][1] / 2) for way, end in ends.items()}}
    ways = {way: (f"o m{way}", "name=A") for way in ends} | {
        10 + w: (f"m{w} {end}", "name=B") for w, end in ends.items()
    }
    other = next(way for way in ends if way != first)
    found = pairs(Case(nodes, ways, (("no_left_turn", first, "o", other),)).stages())
    assert found == sorted(_ALL - {(first, other)})


@pytest.mark.parametrize(
    ("rules", "missing"),
    [
        ((), set()),
        ((("no_left_turn", 5, "b", 4),), {(1, 4), (3, 4)}),
        ((("no_left_turn", 3, "5", 4),), {(3, 4)}),
        ((("only_straight_on", 3, "5", 2),), {(3, 4)}),
        ((("only_right_turn", 3, "a", 5),), {(3, 1)}),
        ((("no_straight_on", 1, "a", 5),), {(1, 2), (1, 4)}),
    ],
)
def test_restrictions_inside_a_junction(rules: Rules, missing: set[tuple[int, int]]) -> None:
    stages = Case(_OFFSET.nodes, _OFFSET.ways, rules).stages()
    assert len(stages.layout.arms) == 1
    assert pairs(stages) == sorted(_ALL - missing)
    codes = {item.code for item in stages.diagnostics}
    assert codes.isdisjoint({"restriction-over-roads", "no-way-on"})


def test_a_movement_names_its_inner_streets() -> None:
    stages = _OFFSET.stages()
    inner = {(stages.way(item.entry), stages.way(item.exit)): item.inner for item in stages.movements}
    (between,) = (street.id for street in stages.network.streets if stages.layout.inner[street.id])
    assert inner[(3, 1)] == inner[(1, 3)] == inner[(2, 4)] == ()
    assert inner[(1, 2)] == inner[(3, 4)] == inner[(1, 4)] == ((between, True),)
    assert inner[(2, 1)] == inner[(4, 3)] == inner[(2, 3)] == ((between, False),)


def test_inner_one_ways_are_driven_only_along() -> None:
    stages = Case(_OFFSET.nodes, {**_OFFSET.ways, 5: ("a b", "oneway=yes")}).stages()
    assert pairs(stages) == sorted(_ALL - {(one, other) for one in (2, 4) for other in (1, 3)})


def test_nobody_drives_into_a_street_that_only_leads_here() -> None:
    ways = {1: ("w o", "oneway=yes"), 2: ("e o", "oneway=yes"), 3: ("s o", "oneway=yes")}
    stages = Case(_NODES, ways).stages()
    assert stages.movements == []
    assert Case(_NODES, ways).build().junctions == ()


def test_a_restriction_over_a_street_that_stays_a_road_is_reported() -> None:
    nodes = {**_OFFSET.nodes, "a": (-60.0, 0.0), "s": (-60.0, -80.0), "w": (-140.0, 0.0)}
    stages = Case(nodes, _OFFSET.ways, (("no_left_turn", 3, "5", 4),)).stages()
    assert len(stages.layout.arms) == 2
    found = [item for item in stages.diagnostics if item.code == "restriction-over-roads"]
    assert [item.osm_id for item in found] == ["relation/9001"]
    assert (5, 4) in pairs(stages)


def test_a_way_that_restrictions_leave_without_a_way_on_is_reported() -> None:
    ways = {1: ("w o", ""), 2: ("e o", "oneway=yes"), 3: ("o s", "oneway=yes")}
    free, banned = Case(_NODES, ways), Case(_NODES, ways, (("no_right_turn", 1, "o", 3),))
    assert [item for item in free.stages().diagnostics if item.code == "no-way-on"] == []
    stages = banned.stages()
    assert (1, 3) not in pairs(stages)
    (found,) = [item for item in stages.diagnostics if item.code == "no-way-on"]
    assert found.osm_id == "way/1"
    assert found.message.startswith("restrictions or one-way streets leave no way on from it at node/")


def test_a_one_way_street_without_a_way_on_is_reported_and_one_without_other_streets_is_not() -> None:
    def reported(ways: dict[int, tuple[str, str]], rules: Rules = ()) -> list[str]:
        found = Case(_NODES, ways, rules).stages().diagnostics
        return [item.osm_id for item in found if item.code == "no-way-on"]

    leaving = {1: ("w o", "oneway=yes"), 3: ("o s", "oneway=yes"), 4: ("o n", "oneway=yes")}
    assert reported(leaving) == []
    assert reported(leaving, (("no_right_turn", 1, "o", 3),)) == []
    assert reported(leaving, (("no_right_turn", 1, "o", 3), ("no_left_turn", 1, "o", 4))) == ["way/1"]
    # All others lead here.
    assert reported({1: ("w o", ""), 3: ("s o", "oneway=yes"), 4: ("n o", "oneway=yes")}) == []


def test_movements_come_by_junction_and_each_once() -> None:
    stages = _OFFSET.stages()
    keys = [(item.junction, item.entry, item.exit) for item in stages.movements]
    assert keys == sorted(set(keys))


@pytest.mark.parametrize(("nodes", "through"), [(9, True), (10, False)])
def test_a_way_over_more_than_eight_inner_streets_is_a_detour(nodes: int, through: bool) -> None:
    places = {"w": (-80.0, 0.0), "e": (2.0 * nodes + 80.0, 0.0)}
    ways = {1: ("w p0", ""), 2: (f"p{nodes - 1} e", "")}
    for k in range(nodes):
        places |= {f"p{k}": (2.0 * k, 0.0), f"s{k}": (2.0 * k, -80.0 if k % 2 else 80.0)}
        ways[10 + k] = (f"p{k} s{k}", "")
        if k:
            ways[50 + k] = (f"p{k - 1} p{k}", "")
    stages = Case(places, ways).stages()
    assert len(stages.layout.arms) == 1
    assert ((1, 2) in pairs(stages)) == through


# ---------------------------------------------------------------- what relations say about lanes


def stated_by(case: Case) -> dict[tuple[int, int], tuple[int, ...]]:
    """Return the numbers of the relations (from 1) that speak of each movement, by (from way, to way)."""
    stages = case.stages()
    assert len(stages.layout.arms) == 1
    return {
        (stages.way(item.entry), stages.way(item.exit)): tuple(k - 9000 for k in item.stated.relations)
        for item in stages.movements
        if item.stated is not None
    }


@pytest.mark.parametrize("turned", [(), (1,), (2,), (5,), (6,), (5, 8, 6), (1, 2, 5, 8, 6)])
def test_relations_speak_of_paths_over_all_ways_inside_a_junction(turned: tuple[int, ...]) -> None:
    """Ways 5, 8 and 6 lead from one T to the other, whichever way streets are drawn."""
    nodes = {**_OFFSET.nodes, "q": (-1.0, 0.0), "r": (1.0, 0.0)}
    rows = {1: "w a", 2: "b e", 3: "s a", 4: "b n", 5: "a q", 8: "q r", 6: "r b"}
    ways = {way: (" ".join(row.split()[::-1]) if way in turned else row, "") for way, row in rows.items()}
    there = ((1, "a", 5), (5, "q", 8), (8, "r", 6), (6, "b", 2))
    back = ((2, "b", 6), (6, "r", 8), (8, "q", 5), (5, "a", 1))
    named = tuple((*item, "1:1", 1, 1) for item in (*there, *back, (3, "a", 1), (4, "a", 2)))
    found = stated_by(Case(nodes, ways, connectivity=named))
    # The last one names a node at which its ways do not meet.
    assert found == {(1, 2): (1, 2, 3, 4), (2, 1): (5, 6, 7, 8), (3, 1): (9,)}
    # All of a path must be spoken of.
    assert stated_by(Case(nodes, ways, connectivity=(*named[:2], *named[3:8]))) == {(2, 1): (4, 5, 6, 7)}


def test_relations_over_ways_speak_of_paths_over_these_ways() -> None:
    """Three Ts in a row: ways 5 and 6 lie between them."""
    nodes = {"w": (-80.0, 0.0), "a": (0.0, 0.0), "b": (8.0, 0.0), "c": (16.0, 0.0), "e": (96.0, 0.0)}
    nodes |= {"s": (0.0, -80.0), "n": (8.0, 80.0), "t": (16.0, -80.0)}
    ways = {1: ("w a", ""), 2: ("c e", ""), 3: ("s a", ""), 4: ("b n", ""), 7: ("c t", "")}
    ways |= {5: ("a b", ""), 6: ("c b", "")}
    named = ((1, "5 6", 2), (2, "6 5", 3), (4, "6", 7), (3, "6", 4), (1, "5", 4))
    found = stated_by(Case(nodes, ways, connectivity=tuple((*item, "1:1", 1, 1) for item in named)))
    assert found == {(1, 2): (1,), (2, 3): (2,), (4, 7): (3,), (1, 4): (5,)}


def test_a_way_that_runs_on_through_a_junction_is_one_way() -> None:
    """Way 1 leads through the first T, and way 6 through the second."""
    nodes = {**_OFFSET.nodes, "r": (0.0, 0.0)}
    ways = {1: ("w a r", ""), 3: ("s a", ""), 4: ("b n", ""), 6: ("r b e", "")}
    named = tuple((*item, "1:1", 1, 1) for item in ((1, "r", 6), (6, "r", 1)))
    assert stated_by(Case(nodes, ways, connectivity=named)) == {(1, 6): (1,), (6, 1): (2,)}


def against_cars(case: Case, rule: Rule = Rule.RIGHT_HAND) -> tuple[Stages, list[Movement]]:
    """Return the stages of a case, and the movements against cars."""
    stages = (case if rule is Rule.RIGHT_HAND else case.mirrored()).stages(rule)
    every = with_movements_against_cars(stages.network, stages.ends, stages.layout, stages.movements)
    found = [item for item in every if item.apart]
    assert [item for item in every if not item.apart] == stages.movements
    assert [item.junction for item in every] == sorted(item.junction for item in every)
    return stages, found


def ways(case: Case, rule: Rule = Rule.RIGHT_HAND) -> list[tuple[int, int]]:
    """Return (from way, to way) of the movements against cars."""
    stages, found = against_cars(case, rule)
    return [(stages.way(item.entry), stages.way(item.exit)) for item in found]


@pytest.mark.parametrize("rule", Rule)
def test_buses_go_on_against_a_one_way_street(rule: Rule) -> None:
    case = Case(_NODES, {1: ("w o", _AGAINST), 2: ("o e", _AGAINST), **_CROSSED})
    assert ways(case, rule) == [(2, 1)]


@pytest.mark.parametrize(
    ("first", "then", "expected"),
    [
        # To a street of both directions, and to one where they have a lane among others.
        ("", _AGAINST, [(2, 1)]),
        ("lanes=3 lanes:backward=2 lanes:bus:backward=1", _AGAINST, [(2, 1)]),
        # From a lane of their own alone: cars would follow them from others.
        (_AGAINST, "", []),
        (_AGAINST, "lanes=3 lanes:backward=2 lanes:bus:backward=1", [(2, 1)]),
        # Not where nobody may go on.
        ("oneway=yes", _AGAINST, []),
        ("oneway=yes", "oneway=yes", []),
    ],
)
def test_where_buses_go_on(first: str, then: str, expected: list[tuple[int, int]]) -> None:
    assert ways(Case(_NODES, {1: ("w o", first), 2: ("o e", then), **_CROSSED})) == expected


def test_buses_turn_into_no_other_street_against_cars() -> None:
    case = Case(_NODES, {1: ("w o", "oneway=yes"), 2: ("o e", _AGAINST), 3: ("s o", _AGAINST), 4: ("o n", "")})
    # Straight on is no way for them; the street from the south leads on to the north alone.
    assert ways(case) == []


def test_buses_go_over_one_way_streets_inside_a_junction() -> None:
    nodes = {**_NODES, "a": (-4.0, 0.0), "b": (4.0, 0.0), "s": (-4.0, -80.0), "n": (4.0, 80.0)}
    case = Case(
        nodes,
        {1: ("w a", _AGAINST), 2: ("b e", _AGAINST), 3: ("s a", ""), 4: ("b n", ""), 5: ("a b", _AGAINST)},
    )
    stages, (item,) = against_cars(case)
    assert (stages.way(item.entry), stages.way(item.exit)) == (2, 1)
    ((street, along),) = item.inner
    assert [piece.osm_way_id for _, piece in stages.network.streets[street].pieces] == [5]
    assert not along


@pytest.mark.parametrize(
    ("first", "then", "expected"),
    [
        (_CYCLES, _CYCLES, [(2, 1)]),
        ("", _CYCLES, [(2, 1)]),
        ("cycleway=lane", _CYCLES, [(2, 1)]),
        (_CYCLES, "cycleway=lane", [(2, 1)]),
        (_CYCLES, "", []),
        # A lane for buses is none for them.
        (_CYCLES, "lanes=3 lanes:backward=2 lanes:bus:backward=1", []),
    ],
)
def test_where_bicycles_go_on(first: str, then: str, expected: list[tuple[int, int]]) -> None:
    assert ways(Case(_NODES, {1: ("w o", first), 2: ("o e", then), **_CROSSED})) == expected


def test_bicycles_join_the_lane_for_cars_where_theirs_ends() -> None:
    road_map = Case(_NODES, {1: ("w o", ""), 2: ("o e", _CYCLES), **_CROSSED}).build()
    (through,) = (
        road
        for road in road_map.roads
        if road.junction is not None and any(lane.type is LaneType.BIKING for lane in road.lane_sections[0].lanes)
    )
    first, last = through.lane_sections
    assert [(lane.type, lane.predecessor) for lane in first.lanes if lane.id] == [(LaneType.BIKING, 1)]
    assert [(lane.type, lane.successor) for lane in last.lanes if lane.id] == [(LaneType.DRIVING, 1)]


def test_their_lane_through_the_junction_is_against_cars() -> None:
    road_map = Case(_NODES, {1: ("w o", _AGAINST), 2: ("o e", _AGAINST), **_CROSSED}).build()
    (through,) = (
        road
        for road in road_map.roads
        if road.junction is not None and any(lane.type is LaneType.BUS for lane in road.lane_sections[0].lanes)
    )
    lanes = [lane for lane in through.lane_sections[0].lanes if lane.type is LaneType.BUS]
    assert len(lanes) == 1
    assert (lanes[0].predecessor, lanes[0].successor) == (1, 1)

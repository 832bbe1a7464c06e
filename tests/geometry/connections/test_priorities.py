"""Who goes first at junctions made by hand, drawn for right-hand traffic; left-hand traffic must mirror them.

Pairs are written as ``12>31``: who comes from way 1 and goes to way 2 goes before who comes from 3 and goes to 1.
"""

from __future__ import annotations

import pytest
from junction_cases import CASES
from street_cases import Case

from osm2xodr.conventions.signs import read_signs
from osm2xodr.geometry.connections.priorities import Arm, goes_first
from osm2xodr.model import RoadMap, Rule, Sign

EITHER = pytest.mark.parametrize("rule", list(Rule), ids=lambda rule: rule.value)
NODES = {
    "w": (-90.0, 0.0),
    "wi": (-20.0, 0.0),
    "o": (0.0, 0.0),
    "ei": (20.0, 0.0),
    "e": (90.0, 0.0),
    "s": (0.0, -90.0),
    "sf": (0.0, -60.0),
    "si": (0.0, -20.0),
    "ni": (0.0, 20.0),
    "n": (0.0, 90.0),
}
# Ways 1 from the west, 2 to the east, 3 from the south, 4 to the north.
LINES = {1: "w wi o", 2: "o ei e", 3: "s sf si o", 4: "o ni n"}
T_FROM_SOUTH = {"12>31", "12>32", "21>31", "23>31"}
# All that comes from the north crosses or merges with what comes from the west and east.
X_FROM_SOUTH = T_FROM_SOUTH | {"12>34", "21>34", "14>34", "24>34", "14>31", "23>34"}
X_FROM_NORTH = {"21>42", "21>41", "12>42", "14>42", "21>43", "12>43", "23>43", "13>43", "23>42", "14>43"}


def case(tags: dict[int, str], signs: dict[str, str] | None = None) -> Case:
    used = {name for way in tags for name in LINES[way].split()}
    return Case(
        {name: place for name, place in NODES.items() if name in used},
        {way: (LINES[way], text) for way, text in tags.items()},
        node_tags=signs or {},
    )


def built(made: Case, rule: Rule) -> RoadMap:
    return (made if rule is Rule.RIGHT_HAND else made.mirrored()).build(rule)


def pairs(roads: RoadMap) -> set[str]:
    """Return all pairs; ways have one digit."""
    by_id = {road.id: road for road in roads.roads}

    def ways(number: int) -> str:
        path = by_id[number]
        assert path.predecessor is not None
        assert path.successor is not None
        one, other = by_id[path.predecessor.id], by_id[path.successor.id]
        return f"{one.osm_way_ids[0]}{other.osm_way_ids[0]}"

    found = [f"{ways(high)}>{ways(low)}" for junction in roads.junctions for high, low in junction.priorities]
    for junction in roads.junctions:
        members = {connection.connecting_road for connection in junction.connections}
        assert all({high, low} <= members for high, low in junction.priorities)
        assert len(set(junction.priorities)) == len(junction.priorities)
        assert not {(low, high) for high, low in junction.priorities} & set(junction.priorities)
    return set(found)


MAIN, SIDE = "highway=secondary", "highway=residential"
T = {1: MAIN, 2: MAIN, 3: SIDE}
X = {**T, 4: SIDE}
EQUAL = {1: SIDE, 2: SIDE, 3: SIDE}


@EITHER
@pytest.mark.parametrize(
    ("tags", "signs", "expected"),
    [
        # -- classes
        (T, {}, T_FROM_SOUTH),
        (X, {}, X_FROM_SOUTH | X_FROM_NORTH),
        (EQUAL, {}, set()),
        ({**EQUAL, 3: "highway=unclassified"}, {}, set()),
        ({**EQUAL, 3: "highway=service"}, {}, T_FROM_SOUTH),
        ({**EQUAL, 3: "highway=living_street"}, {}, T_FROM_SOUTH),
        # A road that ends at another does not go first by its class.
        ({1: SIDE, 2: SIDE, 3: MAIN}, {}, set()),
        # Ramps yield whatever they are called after.
        ({1: "highway=tertiary", 2: "highway=tertiary", 3: "highway=primary_link"}, {}, T_FROM_SOUTH),
        # ... but go before streets that end at them.
        ({1: "highway=trunk_link", 2: "highway=trunk_link", 3: SIDE}, {}, T_FROM_SOUTH),
        # -- signs
        (EQUAL, {"si": "highway=give_way direction=forward"}, T_FROM_SOUTH),
        (EQUAL, {"si": "highway=stop"}, T_FROM_SOUTH),
        (EQUAL, {"si": "highway=stop direction=180"}, T_FROM_SOUTH),
        (EQUAL, {"si": "highway=stop direction=both"}, T_FROM_SOUTH),
        # Meant for who leaves, for the other end, or too far away.
        (EQUAL, {"si": "highway=give_way direction=backward"}, set()),
        (EQUAL, {"sf": "highway=give_way"}, set()),
        (EQUAL, {"sf": "highway=give_way direction=forward"}, set()),
        ({**EQUAL, 3: f"{SIDE} oneway=yes"}, {"si": "highway=give_way"}, {"12>31", "12>32", "21>31"}),
        # Signs go before classes, and all alike cancel out.
        (
            {1: MAIN, 2: MAIN, 3: SIDE},
            {"wi": "highway=stop", "ei": "highway=stop"},
            {"31>12", "32>12", "31>21", "31>23"},
        ),
        (T, {"si": "highway=stop stop=all", "wi": "highway=stop", "ei": "highway=stop"}, set()),
        (T, {"si": "highway=stop", "wi": "highway=stop", "ei": "highway=stop"}, set()),
        (T, {"o": "highway=stop stop=all"}, set()),
        (T, {"o": "highway=stop stop=minor"}, T_FROM_SOUTH),
        # -- signals
        (T, {"o": "highway=traffic_signals"}, set()),
        (T, {"si": "highway=traffic_signals", "wi": "highway=traffic_signals"}, set()),
        (T, {"si": "highway=traffic_signals"}, T_FROM_SOUTH),
        (T, {"o": "highway=traffic_signals traffic_signals=pedestrian_crossing"}, T_FROM_SOUTH),
        # -- roads with priority
        ({1: f"{SIDE} priority_road=designated", 2: f"{SIDE} priority_road=designated", 3: SIDE}, {}, T_FROM_SOUTH),
        ({1: f"{SIDE} priority_road=end", 2: SIDE, 3: SIDE}, {}, set()),
        # ... that bend
        (
            {1: f"{SIDE} priority_road=designated", 2: SIDE, 3: f"{SIDE} priority_road=designated"},
            {},
            {"12>23", "13>23", "31>21", "31>23"},
        ),
    ],
)
def test_pairs(tags: dict[int, str], signs: dict[str, str], expected: set[str], rule: Rule) -> None:
    assert pairs(built(case(tags, signs), rule)) == expected


@EITHER
@pytest.mark.parametrize("name", ["roundabout", "roundabout_few_nodes"])
def test_entries_of_a_roundabout_yield_to_the_ring(name: str, rule: Rule) -> None:
    roads = built(CASES[name].case, rule)
    by_id = {road.id: road for road in roads.roads}
    assert len(roads.junctions) == 4
    arms = set()
    for junction in roads.junctions:
        ((high, low),) = junction.priorities
        first, second = by_id[high], by_id[low]
        assert first.predecessor is not None
        assert second.predecessor is not None
        assert by_id[first.predecessor.id].osm_way_ids[0] > 10
        arms.add(by_id[second.predecessor.id].osm_way_ids)
        assert first.successor == second.successor
    assert arms == {(1,), (2,), (3,), (4,)}
    assert roads.statistics["roundabout_entries"] == 4


@EITHER
def test_a_roundabout_goes_before_any_class(rule: Rule) -> None:
    made = CASES["roundabout"].case
    ways = {way: (nodes, f"highway=primary {tags}" if way < 10 else tags) for way, (nodes, tags) in made.ways.items()}
    roads = built(Case(made.nodes, ways), rule)
    assert [len(junction.priorities) for junction in roads.junctions] == [1, 1, 1, 1]
    assert roads.statistics["roundabout_entries"] == 4


@EITHER
def test_a_ramp_yields_where_it_merges_and_not_where_it_gets_a_lane(rule: Rule) -> None:
    roads = built(CASES["y_merge"].case, rule)
    assert pairs(roads) == {"13>23"}
    assert roads.statistics["priorities"] == 1
    assert pairs(built(CASES["y_merge_added_lane"].case, rule)) == set()
    assert pairs(built(CASES["y_split"].case, rule)) == set()


@EITHER
def test_numbers_are_counted(rule: Rule) -> None:
    def counted(signs: dict[str, str]) -> tuple[int, ...]:
        found = built(case(T, signs), rule).statistics
        names = ("junctions_with_signals", "all_way_stops", "junctions_with_priorities", "signs_followed")
        return tuple(int(found[name]) for name in names)

    assert counted({}) == (0, 0, 1, 0)
    assert counted({"si": "highway=give_way"}) == (0, 0, 1, 1)
    assert counted({"o": "highway=traffic_signals"}) == (1, 0, 0, 0)
    assert counted({"o": "highway=stop stop=all"}) == (0, 1, 0, 0)


def arm(rank: int, sign: Sign | None = None, ring: bool = False, priority_road: bool = False) -> Arm:
    return Arm(ring, sign, priority_road, rank)


@pytest.mark.parametrize(
    ("one", "other", "ranks", "expected"),
    [
        (arm(6), arm(4), [6, 6, 4], (True, False)),
        (arm(6), arm(4), [6, 4, 4], (False, False)),
        (arm(7), arm(4), [7, 6, 4], (True, False)),
        (arm(7), arm(6), [7, 6, 6, 4], (False, False)),
        (arm(4), arm(1), [4, 1, 1], (True, False)),
        (arm(4), arm(4), [4, 4, 4], (False, False)),
        (arm(6, Sign.STOP), arm(4), [6, 6, 4], (False, True)),
        (arm(4), arm(4, Sign.GIVE_WAY), [4, 4, 4], (True, False)),
        # Who leaves a property has no sign, and yields to who has one as well.
        (arm(4, Sign.STOP), arm(1), [4, 4, 1], (True, False)),
        (arm(4, Sign.STOP), arm(1, Sign.STOP), [4, 4, 1], (False, False)),
        (arm(4, ring=True), arm(7), [4, 4, 7], (True, False)),
        (arm(1, ring=True), arm(4), [1, 1, 4], (True, False)),
        (arm(4, ring=True), arm(7, Sign.GIVE_WAY), [4, 4, 7], (True, False)),
        (arm(4, Sign.GIVE_WAY, ring=True), arm(4), [4, 4, 4], (False, True)),
        (arm(4, priority_road=True), arm(6), [4, 6, 6], (True, False)),
    ],
)
def test_what_decides(one: Arm, other: Arm, ranks: list[int], expected: tuple[bool, bool]) -> None:
    assert (goes_first(one, other, ranks), goes_first(other, one, ranks)) == expected


def test_of_several_signs_the_nearest_counts() -> None:
    made = case(EQUAL, {"si": "highway=stop direction=forward", "sf": "highway=give_way direction=forward"})
    stages = made.stages()
    assert dict(read_signs(stages.network).before_end) == {stages.end(3, list(made.nodes).index("o")): Sign.STOP}


@EITHER
def test_a_sign_on_a_street_inside_the_junction_is_for_the_arm_before_it(rule: Rule) -> None:
    """The street from the south splits just before the crossing, and its halves are part of the junction."""
    nodes = {**{name: NODES[name] for name in "wesn"}, "a": (-1.5, 0.0), "b": (1.5, 0.0), "f": (0.0, -4.0)}
    nodes["g"] = (1.0, -2.0)
    ways = {1: ("w a", SIDE), 2: ("b e", SIDE), 3: ("s f", SIDE), 5: ("a b", SIDE)}
    ways |= {6: ("a f", f"{SIDE} oneway=yes"), 7: ("f g b", f"{SIDE} oneway=yes")}
    roads = built(Case(nodes, ways, node_tags={"g": "highway=give_way"}), rule)
    assert len(roads.junctions) == 1
    assert roads.statistics["signs_followed"] == 1
    assert {pair.split(">")[1][0] for pair in pairs(roads)} == {"3"}

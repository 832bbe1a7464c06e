"""Ways through junctions of real places, picked by hand and looked up in OSM: what is open, and what is forbidden."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from lane_graph import LaneGraph, LaneKey
from scene_files import Conversion, Conversions, scene_named

# How far from the node a street is looked at (the first place that lies on a road and not in a junction), and how
# long the way through the junction may be.
LOOKS = (25.0, 15.0, 10.0, 40.0, 60.0, 90.0, 120.0)
THROUGH = 150.0


class Place:
    """A converted scene in which streets are named by their OSM ways."""

    def __init__(self, conversion: Conversion) -> None:
        self.osm = conversion.osm
        self.graph = LaneGraph(conversion.network)

    def distance(self, from_way: int, from_node: int, to_way: int, to_node: int) -> float:
        """Return how far it is from a way into a node to a way out of a node, m; infinity if one cannot."""
        start, goal = self.lanes_into(from_way, from_node), self.lanes_out(to_way, to_node)
        reached = self.graph.distances(start, THROUGH)
        return min((reached[lane] for lane in goal if lane in reached), default=math.inf)

    def lanes_into(self, way: int, node: int) -> set[LaneKey]:
        """Return the lanes on a way towards a node at its end."""
        found = [self.graph.lanes_at(*self.osm.before(way, node, look)) for look in LOOKS]
        assert any(found), f"no lane on way {way} towards node {node}"
        return next(lanes for lanes in found if lanes)

    def lanes_out(self, way: int, node: int) -> set[LaneKey]:
        """Return the lanes on a way away from a node at its end."""
        found = [self.graph.lanes_at(*self.osm.after(way, node, look)) for look in LOOKS]
        assert any(found), f"no lane on way {way} from node {node}"
        return next(lanes for lanes in found if lanes)


@pytest.fixture(scope="module")
def montlake(conversions: Conversions) -> Place:
    return Place(conversions.of(scene_named("montlake_roundabout")))


@pytest.fixture(scope="module")
def fremantle(conversions: Conversions) -> Place:
    return Place(conversions.of(scene_named("fremantle_placement")))


@pytest.fixture(scope="module")
def i5(conversions: Conversions) -> Place:
    return Place(conversions.of(scene_named("i5_exit_ramp")))


# Streets at the roundabout, in the order in which one passes them: counter-clockwise.
ARMS = [
    (992268928, 9167886986),
    (36952952, 9167886985),
    (6348168, 9167886982),
    (6383154, 9167886983),
    (6460090, 9167886984),
]


@pytest.mark.parametrize("arm", range(5), ids=[f"way {way}" for way, _ in ARMS])
def test_one_leaves_a_roundabout_at_each_arm_in_turn(montlake: Place, arm: int) -> None:
    others = [*ARMS[arm + 1 :], *ARMS[:arm]]
    ways = [montlake.distance(*ARMS[arm], *other) for other in others]
    assert ways == sorted(ways)
    assert all(b - a > 2.0 for a, b in pairwise(ways))
    assert ways[-1] < 80.0


# Stirling Highway and Tydeman Road, two dual carriageways that cross: four nodes, left-hand traffic.
NORTH, EAST, SOUTH, WEST = 3022414623, 3022414624, 3022414631, 3022414627
FROM_SOUTH_EAST, FROM_WEST, FROM_NORTH_WEST = (671208480, SOUTH), (319289860, WEST), (319289839, NORTH)
TO_NORTH_WEST, TO_SOUTH_EAST = (292025662, WEST), (298328336, EAST)
TO_WEST, TO_NORTH_EAST = (298328362, SOUTH), (319289828, NORTH)

FREMANTLE_OPEN = {
    "straight on to the north-west": (FROM_SOUTH_EAST, TO_NORTH_WEST),
    "right across the other carriageway to the north-east": (FROM_SOUTH_EAST, TO_NORTH_EAST),
    "straight on to the north-east": (FROM_WEST, TO_NORTH_EAST),
    "right to the south-east": (FROM_WEST, TO_SOUTH_EAST),
    "straight on to the south-east": (FROM_NORTH_WEST, TO_SOUTH_EAST),
    "right to the west": (FROM_NORTH_WEST, TO_WEST),
    "left by the slip road": ((319289861, 25647198), (292025661, 25647198)),
}
# Relations of a node forbid the turn itself: a way of less than 50 m.
FREMANTLE_NO_LEFT_TURN = {
    "from the west": (FROM_WEST, TO_NORTH_WEST),
    "from the south-east": (FROM_SOUTH_EAST, TO_WEST),
    "from the north-west": (FROM_NORTH_WEST, TO_NORTH_EAST),
}
# Relations by way of a way forbid to drive round.
FREMANTLE_NO_U_TURN = {
    "back to the south-east": (FROM_SOUTH_EAST, TO_SOUTH_EAST),
    "back to the north-west": (FROM_NORTH_WEST, TO_NORTH_WEST),
    "back to the west": (FROM_WEST, TO_WEST),
}


@pytest.mark.parametrize("name", FREMANTLE_OPEN)
def test_open_at_crossing_dual_carriageways(fremantle: Place, name: str) -> None:
    a, b = FREMANTLE_OPEN[name]
    assert fremantle.distance(*a, *b) < THROUGH


@pytest.mark.parametrize("name", FREMANTLE_NO_LEFT_TURN)
def test_no_left_turn(fremantle: Place, name: str) -> None:
    a, b = FREMANTLE_NO_LEFT_TURN[name]
    assert fremantle.distance(*a, *b) > 50.0


@pytest.mark.parametrize("name", FREMANTLE_NO_U_TURN)
def test_no_u_turn_by_way_of_a_way(fremantle: Place, name: str) -> None:
    a, b = FREMANTLE_NO_U_TURN[name]
    assert fremantle.distance(*a, *b) == math.inf


FORTIETH_STREET, FORTY_SECOND_STREET = 1841897176, 29545412
EASTWARDS = (369623527, 1726056699)
DIVERGE, MERGE = 29484936, 1864943558
I5_OPEN = {
    "along the motorway past an exit": ((4644167, DIVERGE), (4869148, DIVERGE)),
    "off the motorway": ((4644167, DIVERGE), (4637378, DIVERGE)),
    "along the motorway past an entrance": ((622519703, MERGE), (4644156, MERGE)),
    "on to the motorway": ((175933057, MERGE), (4644156, MERGE)),
    "40th Street, from the west to the east": ((331907114, FORTIETH_STREET), EASTWARDS),
    "40th Street, from the west to the north": ((331907114, FORTIETH_STREET), (6432413, FORTIETH_STREET)),
    "40th Street, from the south-west, left-hand lane": ((50848121, FORTIETH_STREET), (331907114, FORTIETH_STREET)),
    "40th Street, from the south-west, right-hand lane": ((50848121, FORTIETH_STREET), EASTWARDS),
    "42nd Street, left": ((738331642, FORTY_SECOND_STREET), (6400787, FORTY_SECOND_STREET)),
    "42nd Street, straight on": ((738331642, FORTY_SECOND_STREET), (392696868, FORTY_SECOND_STREET)),
    "42nd Street, right": ((738331642, FORTY_SECOND_STREET), (19795373, FORTY_SECOND_STREET)),
}


@pytest.mark.parametrize("name", I5_OPEN)
def test_open_at_an_interchange(i5: Place, name: str) -> None:
    a, b = I5_OPEN[name]
    assert i5.distance(*a, *b) < THROUGH


def test_forbidden_at_an_interchange(i5: Place) -> None:
    assert i5.distance(4644164, FORTY_SECOND_STREET, 6400787, FORTY_SECOND_STREET) == math.inf


def test_streets_do_not_meet_the_motorway_above_them(i5: Place) -> None:
    street, motorway = i5.lanes_into(331907114, FORTIETH_STREET), i5.lanes_out(4869148, DIVERGE)
    assert not motorway & set(i5.graph.distances(street, 1000.0))

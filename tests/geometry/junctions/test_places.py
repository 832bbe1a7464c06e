"""Where streets and tagged nodes end up: on which road, how far along it, in which junction."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from street_cases import Case, Stages

from osm2xodr.curves import pose
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.junctions import RoadParts, cut_roads, street_places
from osm2xodr.geometry.plan_view.streets import fit_streets
from osm2xodr.model import StreetPlaces

_CROSSING = "highway=crossing crossing=marked"
# Two Ts at a and b, 8 m apart, make one junction; way 6 leaves node e and comes back to it, and becomes two roads.
_NODES = {
    "w": (-100.0, 0.0),
    "p": (-40.0, 0.0),
    "q": (-2.0, 0.0),
    "a": (0.0, 0.0),
    "r": (4.0, 0.0),
    "b": (8.0, 0.0),
    "u": (11.0, 0.0),
    "e": (128.0, 0.0),
    "c": (148.0, 20.0),
    "d": (168.0, 20.0),
    "f": (188.0, 0.0),
    "g": (168.0, -20.0),
    "h": (148.0, -20.0),
    "s": (0.0, -90.0),
    "n": (8.0, 90.0),
}
_WAYS = {
    1: ("w p q a", ""),
    2: ("b u e", ""),
    3: ("s a", ""),
    4: ("b n", ""),
    5: ("a r b", ""),
    6: ("e c d f g h e", ""),
}
_TAGGED = "pqarubcdgh"


class Found(NamedTuple):
    """What there is, and where it is."""

    stages: Stages
    parts: RoadParts
    places: StreetPlaces

    def way(self, street: int) -> int:
        return self.stages.way(2 * street)

    def rows(self, name: str, way: int) -> list[int]:
        """Return the rows of a node on a way."""
        node, streets = 1001 + list(_NODES).index(name), self.places.street.tolist()
        return [k for k, street in enumerate(streets) if self.places.node[k] == node and self.way(street) == way]


@pytest.fixture(name="found")
def _found() -> Found:
    """Road k has the id 100 + k; the junction of a and b is 70, that of e is not written."""
    stages = Case(_NODES, _WAYS, node_tags=dict.fromkeys(_TAGGED, _CROSSING)).stages()
    fitted = fit_streets(stages.network, Diagnostics())
    parts = cut_roads(stages.network, fitted, stages.layout)
    joined = int(stages.layout.junction[stages.end(1, 3)])
    ids = np.full(len(stages.layout.arms) + 1, -1)
    ids[joined] = 70
    return Found(stages, parts, street_places(stages.network, stages.layout, parts, lambda k: 100 + k, ids))


def test_every_street_end_knows_its_road_and_junction(found: Found) -> None:
    places, ways = found.places, [found.way(street) for street in found.parts.street.tolist()]
    assert places.road_street is found.parts.street
    assert sorted(ways) == [1, 2, 3, 4, 6, 6]
    road = {way: 100 + k for k, way in enumerate(ways) if way != 6}
    name = list(_NODES).index
    expected = {
        (1, "w"): (road[1], -1),
        (1, "a"): (road[1], 70),
        (2, "b"): (road[2], 70),
        (2, "e"): (road[2], -1),
        (3, "a"): (road[3], 70),
        (4, "b"): (road[4], 70),
        # Of a street inside a junction no road is left, but it is known where it lies.
        (5, "a"): (-1, 70),
        (5, "b"): (-1, 70),
    }
    for (way, node), wanted in expected.items():
        end = found.stages.end(way, name(node))
        assert (int(places.end_road[end]), int(places.end_junction[end])) == wanted
    (street,) = (street for street in range(6) if found.way(street) == 6)
    halves = [100 + k for k, way in enumerate(ways) if way == 6]
    assert places.end_road[2 * street : 2 * street + 2].tolist() == halves
    assert sorted(set(found.parts.road_end.tolist()) - set(range(12))) == [-1]
    assert [street for street in range(6) if places.inner[street]] == [
        street for street in range(6) if found.way(street) == 5
    ]


def test_the_ends_of_every_street_are_those_of_their_own_junctions(found: Found) -> None:
    """With two junctions that are written each end has the one of its node."""
    layout = found.stages.layout
    ids = np.array([*range(50, 50 + len(layout.arms)), -1])
    places = street_places(found.stages.network, layout, found.parts, lambda k: 100 + k, ids)
    of_node = {k: 50 + number for number, nodes in enumerate(layout.nodes) for k in nodes}
    named = {node.osm_node_id - 1001 for k, node in enumerate(found.stages.network.intersections) if k in of_node}
    assert {list(_NODES)[k] for k in named} == {"a", "b", "e"}
    for street in found.stages.network.streets:
        wanted = [of_node.get(street.start, -1), of_node.get(street.end, -1)]
        assert places.end_junction[2 * street.id : 2 * street.id + 2].tolist() == wanted


def test_tagged_nodes_are_listed_once_for_each_street_through_them(found: Found) -> None:
    counts = {(name, way): len(found.rows(name, way)) for name in _NODES for way in _WAYS}
    wanted = {("p", 1), ("q", 1), ("a", 1), ("a", 3), ("a", 5), ("r", 5), ("b", 2), ("b", 4), ("b", 5), ("u", 2)}
    wanted |= {(name, 6) for name in "cdgh"}
    assert counts == {key: int(key in wanted) for key in counts}


@pytest.mark.parametrize(
    ("name", "way", "s", "junction"),
    [
        ("p", 1, 60.0, -1),
        # The junction takes 9.8 m of each arm; what lies in it is before the road, or beyond its end.
        ("q", 1, 98.0, 70),
        ("a", 1, 100.0, 70),
        ("a", 3, 90.0, 70),
        ("u", 2, 3.0 - 9.8, 70),
        ("b", 2, -9.8, 70),
        ("b", 4, -9.8, 70),
    ],
)
def test_where_on_straight_roads_nodes_are(name: str, way: int, s: float, junction: int, found: Found) -> None:
    (row,) = found.rows(name, way)
    road = [found.way(street) for street in found.parts.street.tolist()].index(way)
    assert found.places.road[row] == 100 + road
    assert found.places.s[row] == pytest.approx(s, abs=0.05)
    assert found.places.t[row] == pytest.approx(0.0, abs=0.01)
    assert found.places.junction[row] == junction


@pytest.mark.parametrize("name", ["a", "r", "b"])
def test_nodes_of_a_street_inside_a_junction_are_on_no_road(name: str, found: Found) -> None:
    places = found.places
    (row,) = found.rows(name, 5)
    assert (places.road[row], places.junction[row]) == (-1, 70)
    assert math.isnan(places.s[row])
    assert math.isnan(places.t[row])


def test_nodes_of_a_street_cut_in_two_are_on_the_half_that_is_nearer(found: Found) -> None:
    places, parts = found.places, found.parts
    halves = [k for k, street in enumerate(parts.street.tolist()) if found.way(street) == 6]
    # The network has an origin of its own.
    origin = next(node for node in found.stages.network.intersections if node.osm_node_id == 1008)
    for name, half in zip("cdgh", (0, 0, 1, 1), strict=True):
        (row,) = found.rows(name, 6)
        road = halves[half]
        assert places.road[row] == 100 + road
        assert 0.0 < places.s[row] < parts.length[road]
        assert places.junction[row] == -1
        x, y, hdg = (float(v[0]) for v in pose(parts.plan_view, np.array([road]), places.s[[row]]))
        t = float(places.t[row])
        # Left of the road is positive; the ring turns right, and its corners lie outside of the rounded line.
        assert 0.1 < t < 5.0
        x, y = x - t * math.sin(hdg) - origin.x + 128.0, y + t * math.cos(hdg) - origin.y
        assert (x, y) == pytest.approx(_NODES[name], abs=0.02)


def test_a_map_without_tagged_nodes_has_no_places() -> None:
    stages = Case({"a": (0.0, 0.0), "b": (90.0, 0.0)}, {1: ("a b", "")}).stages()
    parts = cut_roads(stages.network, fit_streets(stages.network, Diagnostics()), stages.layout)
    places = street_places(stages.network, stages.layout, parts, lambda k: 100 + k, np.array([-1]))
    for name in ("node", "street", "road", "junction"):
        column = getattr(places, name)
        assert (len(column), column.dtype) == (0, np.int64)
    assert len(places.s) == len(places.t) == 0
    assert places.end_road.tolist() == [100, 100]
    assert places.end_junction.tolist() == [-1, -1]


def _ring(around: float) -> Found:
    """Return a ring by itself, with tagged nodes all along, of so many metres."""
    radius, angles = around / math.tau, [math.tau * k / 24 for k in range(24)]
    nodes = {f"r{k}": (radius * math.cos(a), radius * math.sin(a)) for k, a in enumerate(angles)}
    tags = {f"r{k}": _CROSSING for k in (4, 8, 16, 20)}
    stages = Case(nodes, {1: (f"{' '.join(nodes)} r0", "")}, node_tags=tags).stages()
    parts = cut_roads(stages.network, fit_streets(stages.network, Diagnostics()), stages.layout)
    return Found(
        stages, parts, street_places(stages.network, stages.layout, parts, lambda k: 100 + k, np.array([-1]))
    )


def test_nodes_of_a_ring_are_on_both_of_its_roads() -> None:
    found = _ring(240.0)
    places = found.places
    assert sorted(places.road.tolist()) == [100, 100, 101, 101]
    x, y, _ = pose(found.parts.plan_view, places.road - 100, places.s)
    # Corners at 60, 120, 240 and 300 degrees, which the line cuts a little.
    angle = np.deg2rad(np.array([60.0, 120.0, 240.0, 300.0]))
    middle = np.array([x.mean(), y.mean()])
    assert x - middle[0] == pytest.approx(240.0 / math.tau * np.cos(angle), abs=0.5)
    assert y - middle[1] == pytest.approx(240.0 / math.tau * np.sin(angle), abs=0.5)
    assert places.junction.tolist() == [-1] * 4
    assert places.end_road.tolist() == [100, 101]


def test_a_ring_too_short_for_a_road_lies_in_no_junction() -> None:
    places = _ring(17.0).places
    assert places.inner.tolist() == [True]
    assert (places.end_road.tolist(), places.end_junction.tolist()) == ([-1, -1], [-1, -1])
    assert (places.road.tolist(), places.junction.tolist()) == ([-1] * 4, [-1] * 4)
    assert np.isnan(places.s).all()

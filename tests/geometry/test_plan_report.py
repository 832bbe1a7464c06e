"""What is said about a plan: streets too short to be roads are left out and reported."""

from __future__ import annotations

import math

import pytest
from road_measures import assert_sound
from street_cases import Case

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.errors import InputError
from osm2xodr.geometry import build_roads
from osm2xodr.geometry.plan_report import report_corners
from osm2xodr.geometry.plan_view import fit_streets, smooth_streets
from osm2xodr.model import RoadMap
from osm2xodr.surface import FlatSurface


def built(case: Case) -> tuple[RoadMap, list[tuple[Kind, str, str]]]:
    """Return the roads of a case, and what was dropped."""
    found = Diagnostics()
    roads = build_roads(case.stages().network, FlatSurface(), found)
    assert_sound(roads)
    return roads, [(item.kind, item.code, item.osm_id) for item in found if item.kind is Kind.DROPPED]


def ring(radius: float, name: str = "r") -> dict[str, tuple[float, float]]:
    angles = [math.tau * k / 8 for k in range(8)]
    return {f"{name}{k}": (50 + radius * math.cos(a), 50 + radius * math.sin(a)) for k, a in enumerate(angles)}


def round_(nodes: dict[str, tuple[float, float]]) -> str:
    return " ".join([*nodes, next(iter(nodes))])


def test_an_area_of_a_metre_is_refused() -> None:
    """A triangle of streets of less than a metre, all between junctions."""
    case = Case(
        {"a": (0.0, 0.0), "b": (0.8, 0.1), "c": (0.3, 0.7)}, {1: ("a b", ""), 2: ("b c", ""), 3: ("c a b", "")}
    )
    with pytest.raises(InputError, match=r"within a few metres of each other.*choose a larger area"):
        built(case)


def test_stubs_at_a_dead_end_are_dropped() -> None:
    nodes = {"a": (0.0, 0.0), "b": (80.0, 0.0), "c": (80.3, 0.2), "d": (80.3, -0.2)}
    roads, dropped = built(Case(nodes, {1: ("a b", ""), 2: ("b c", ""), 3: ("b d", "")}))
    assert [road.osm_way_ids for road in roads.roads] == [(1,)]
    assert dropped == [(Kind.DROPPED, "within-junction", f"way/{way}") for way in (2, 3)]


@pytest.mark.parametrize(("length", "kept"), [(5.5, False), (8.0, True)])
def test_dead_ends_of_which_a_junction_leaves_less_than_a_road_are_dropped(length: float, kept: bool) -> None:
    nodes = {"w": (-80.0, 0.0), "m": (0.0, 0.0), "e": (80.0, 0.0), "s": (0.0, -length)}
    roads, dropped = built(Case(nodes, {1: ("w m e", ""), 2: ("m s", "")}))
    assert sorted({road.osm_way_ids for road in roads.roads if road.junction is None}) == [(1,), *[(2,)] * kept]
    assert dropped == ([] if kept else [(Kind.DROPPED, "within-junction", "way/2")])


@pytest.mark.parametrize(("radius", "kept"), [(0.01, False), (2.0, False), (8.0, True)])
def test_rings_too_small_to_drive_round_are_dropped(radius: float, kept: bool) -> None:
    nodes = ring(radius)
    roads, dropped = built(
        Case({"a": (0.0, 0.0), "b": (80.0, 0.0), **nodes}, {1: ("a b", ""), 2: (round_(nodes), "")})
    )
    assert [road.osm_way_ids for road in roads.roads] == [(1,), *[(2,)] * (2 * kept)]
    assert dropped == ([] if kept else [(Kind.DROPPED, "within-junction", "way/2")])


def test_streets_within_a_junction_that_is_driven_through_are_not_lost() -> None:
    nodes = {
        "w": (-80.0, 0.0),
        "a": (0.0, 0.0),
        "b": (0.4, 0.0),
        "e": (80.0, 0.0),
        "n": (0.0, 80.0),
        "s": (0.4, -80.0),
    }
    ways = {1: ("w a", ""), 2: ("a b", ""), 3: ("b e", ""), 4: ("a n", ""), 5: ("b s", "")}
    roads, dropped = built(Case(nodes, ways))
    assert dropped == []
    assert len(roads.junctions) == 1
    assert roads.places is not None
    assert roads.places.inner.sum() == 1


def test_changes_of_lanes_without_room_are_reported() -> None:
    """Between two crossings 30 m apart a lane has no room to open; nor has one against a one-way piece to end."""
    nodes = {"w": (-80.0, 0.0), "a": (0.0, 0.0), "m": (14.0, 0.0), "b": (30.0, 0.0), "e": (110.0, 0.0)}
    nodes |= {"an": (0.0, 60.0), "bn": (30.0, 60.0)}
    rest = {1: ("w a", ""), 4: ("b e", ""), 5: ("a an", ""), 6: ("b bn", "")}

    def reported(one: str, other: str) -> list[tuple[Kind, str, str]]:
        found = Diagnostics()
        case = Case(nodes, {**rest, 2: ("a m", one), 3: ("m b", other)})
        build_roads(case.stages().network, FlatSurface(), found)
        codes = ("lanes-taken-over", "short-taper")
        return [(item.kind, item.code, item.osm_id) for item in found if item.code in codes]

    assert reported("lanes=2", "lanes=2") == []
    assert reported("lanes=2", "lanes=3 lanes:forward=2") == [(Kind.REPAIRED, "lanes-taken-over", "way/2")]
    assert reported("lanes=2", "lanes=1 oneway=yes") == [(Kind.REPAIRED, "lanes-taken-over", "way/2")]
    # A one-way piece takes over no turn lanes.
    assert reported("lanes=1 oneway=yes", "lanes=3 lanes:forward=2") == [(Kind.NOTE, "short-taper", "way/3")]


def test_bends_that_stay_lines_and_arcs_are_counted_by_way() -> None:
    """A zigzag of 20 m between right angles: corners of a street, each with steps of curvature."""
    zigzag = {f"z{k}": (20.0 * ((k + 1) // 2), 20.0 * (k // 2)) for k in range(4)}
    case = Case(
        zigzag | {"y": (600.0, 3.0), "x": (300.0, 0.0), "w": (900.0, 0.0)},
        {1: (" ".join(zigzag), ""), 2: ("x y w", "")},
    )
    found = Diagnostics()
    network = case.stages().network
    fitted = fit_streets(network, Diagnostics())
    report_corners(fitted, found)
    assert {item.osm_id for item in found if item.code == "corner"} == {"way/1", "way/2"}
    smooth = Diagnostics()
    report_corners(smooth_streets(network, fitted), smooth)
    assert [item.osm_id for item in smooth] in ([], ["way/1"])

"""Islands that OSM maps as areas: what is raised of them, and what lanes and tram tracks take."""

from __future__ import annotations

import numpy as np
import pytest
from margin_cases import built
from object_cases import thing
from street_cases import Case

from osm2xodr.geometry.junction_floor import raised_islands
from osm2xodr.model import FloatArray, Island, RoadMap, RoadsideKind

# A street whose carriageway, 6 m wide, lies from y = -3 to 3.
STREET = Case({"a": (-50.0, 0.0), "b": (50.0, 0.0)}, {1: ("a b", "highway=residential lanes=2 width=6")})


@pytest.fixture(scope="module")
def street() -> RoadMap:
    return built(STREET, {})


def box(west: float, south: float, east: float, north: float) -> list[tuple[float, float]]:
    """Return a closed ring, clockwise."""
    return [(west, south), (west, north), (east, north), (east, south), (west, south)]


def size(corners: FloatArray) -> float:
    """Return the area of a ring, positive where it is counter-clockwise, m²."""
    x, y = corners.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def test_what_no_lane_touches_is_as_mapped(street: RoadMap) -> None:
    area = thing(RoadsideKind.ISLAND, box(0.0, 3.5, 8.0, 6.0))
    (found,), left_out = raised_islands([area], street, ())
    assert (found.osm_id, found.junction, found.road, left_out) == ("way/77", -1, 0, [])
    assert found.corners == pytest.approx(area.points[3::-1])
    assert size(found.corners) == pytest.approx(20.0)


def test_lanes_take_their_part_and_a_kerb_s_distance(street: RoadMap) -> None:
    (found,), _ = raised_islands([thing(RoadsideKind.ISLAND, box(0.0, 1.0, 8.0, 7.0))], street, ())
    assert found.corners.min(axis=0) == pytest.approx([0.0, 3.2], abs=0.3)
    assert found.corners[:, 1].min() > 3.1
    assert size(found.corners) == pytest.approx(8.0 * 3.8, rel=0.1)


def test_a_lane_may_part_it(street: RoadMap) -> None:
    found, _ = raised_islands([thing(RoadsideKind.ISLAND, box(0.0, -9.0, 8.0, 9.0))], street, ())
    assert sorted(np.sign(item.corners[:, 1].mean()) for item in found) == [-1.0, 1.0]
    assert all(np.abs(item.corners[:, 1]).min() > 3.1 for item in found)


@pytest.mark.parametrize(
    "ring",
    [box(0.0, -2.0, 8.0, 3.4), box(0.0, 4.0, 1.0, 5.0), box(0.0, 300.0, 8.0, 303.0), box(0.0, 4.0, 90.0, 60.0)],
)
def test_what_lies_on_lanes_or_is_tiny_or_far_away_or_large_is_left_out(
    street: RoadMap, ring: list[tuple[float, float]]
) -> None:
    assert raised_islands([thing(RoadsideKind.ISLAND, ring)], street, ()) == ((), ["way/77"])


def test_trams_run_through(street: RoadMap) -> None:
    track = thing(RoadsideKind.TRAM_TRACK, [(5.0, -20.0), (5.0, 20.0)])
    area = thing(RoadsideKind.ISLAND, box(0.0, 3.5, 10.0, 7.0))
    found, left_out = raised_islands([track, area], street, ())
    assert left_out == []
    assert sorted(item.corners[:, 0].mean() > 5.0 for item in found) == [False, True]
    assert all(np.abs(item.corners[:, 0] - 5.0).min() > 1.3 for item in found)


def test_areas_count_where_carriageways_go_round_the_same_place(street: RoadMap) -> None:
    """What carriageways go round is raised where nothing is mapped, and no tram runs."""
    ring = np.array(box(0.0, 3.2, 9.0, 7.0))[3::-1]
    here, there = Island(5, 0, ring), Island(5, 0, ring + np.array([20.0, 0.0]))
    area = thing(RoadsideKind.ISLAND, box(1.0, 3.5, 8.0, 6.0))
    found, _ = raised_islands([area], street, (here, there))
    assert [item.osm_id for item in found] == ["", "way/77"]
    assert found[0] is there
    track = thing(RoadsideKind.TRAM_TRACK, [(24.0, 0.0), (24.0, 20.0)])
    assert raised_islands([track], street, (here, there)) == ((here,), [])

"""Islands in junctions: which gaps between lanes get kerbs, and where these run.

Islands that OSM maps as areas: what is raised of them, and what lanes and tram tracks take.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from floor_cases import connecting
from margin_cases import built
from object_cases import thing
from scipy import ndimage
from street_cases import Case

from osm2xodr.geometry.connections import ConnectingRoads
from osm2xodr.geometry.junction_floor import Hole, is_island, lay_floor, raised_islands
from osm2xodr.geometry.junction_floor.islands import largest_part
from osm2xodr.model import FloatArray, Island, LaneType, RoadMap, RoadsideKind, Rule

# Lanes of 3 m around a gap, 6 m from west to east (0 to 6) and 4 m from south to north (0 to 4).
AROUND = ((-3.0, -1.5, 9.0, -1.5), (7.5, -3.0, 7.5, 7.0), (9.0, 5.5, -3.0, 5.5), (-1.5, 7.0, -1.5, -3.0))

# A street whose carriageway, 6 m wide, lies from y = -3 to 3.
STREET = Case({"a": (-50.0, 0.0), "b": (50.0, 0.0)}, {1: ("a b", "highway=residential lanes=2 width=6")})


def ring(half: float) -> tuple[FloatArray, FloatArray]:
    """Return the four lines of a square around the middle of the gap, from begin to end."""
    corners = np.array([(3 - half, 2 - half), (3 + half, 2 - half), (3 + half, 2 + half), (3 - half, 2 + half)])
    return corners, np.roll(corners, -1, axis=0)


def islands(roads: ConnectingRoads) -> tuple[Hole, ...]:
    """Return all places that may be islands: streets go round any of them."""
    return lay_floor(roads, Rule.RIGHT_HAND, is_island=lambda hole: True).islands


def hole() -> Hole:
    (found,) = islands(connecting(AROUND))
    return found


def test_kerbs_run_within_the_gap_counter_clockwise() -> None:
    found = hole()
    assert found.area == pytest.approx(24.0, rel=0.08)
    assert found.corners.min(axis=0) == pytest.approx([0.2, 0.2], abs=0.25)
    assert found.corners.max(axis=0) == pytest.approx([5.8, 3.8], abs=0.25)
    assert (found.corners > 0.0).all()
    assert (found.corners < (6.0, 4.0)).all()
    x, y = found.corners.T
    assert 15.0 < 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) < 24.0
    assert len(found.corners) <= 16


def test_the_floor_below_is_the_same() -> None:
    floor = lay_floor(connecting(AROUND), Rule.RIGHT_HAND)
    assert len(floor.left) + len(floor.right) >= 1


def test_beside_a_sidewalk_there_is_none() -> None:
    roads = connecting(AROUND)
    beside = replace(roads, lane_type=(LaneType.SIDEWALK, *roads.lane_type[1:]))
    assert islands(beside) == ()


def test_small_and_narrow_gaps_are_none() -> None:
    small = ((-3.0, -1.5, 5.0, -1.5), (3.9, -3.0, 3.9, 5.0), (5.0, 3.9, -3.0, 3.9), (-1.5, 5.0, -1.5, -3.0))
    narrow = ((-3.0, -1.5, 15.0, -1.5), (13.5, -3.0, 13.5, 5.0), (15.0, 2.3, -3.0, 2.3), (-1.5, 5.0, -1.5, -3.0))
    for lines in (small, narrow):
        assert islands(connecting(lines)) == ()


def test_streets_must_go_round_it() -> None:
    begin, end = ring(4.5)
    assert is_island(hole(), begin, end)
    assert not is_island(hole(), begin[:3], end[:3])
    assert not is_island(hole(), begin[:0], end[:0])


def test_a_gap_that_fills_little_of_what_streets_enclose_is_none() -> None:
    assert not is_island(hole(), *ring(8.0))


@pytest.mark.parametrize("seed", range(20))
def test_the_largest_part_is_the_first_of_that_size(seed: int) -> None:
    cells = np.random.default_rng(seed).random((17, 23)) < 0.2 + 0.03 * seed
    label, _ = ndimage.label(cells)
    expected = label == np.bincount(label.ravel())[1:].argmax() + 1
    assert largest_part(cells).tolist() == expected.tolist()


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

"""From places in the world back to roads, exactly.

Files that would take the square of their roads to compare.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from xodr_text import cubics, document, geometry, lane, read_text, road, section

from osm2xodr.errors import InputError
from osm2xodr.opendrive import refuse_crowds
from osm2xodr.opendrive.space import RoadFinder, finder as finding, lane_borders, surface_points
from osm2xodr.opendrive.tables import ABSENT, OpenDrive

LANES = cubics("laneOffset", (0, 0.4, 0.01)) + section(
    0.0, lane(1, (0, 3.0, 0.0, 0.002)), lane(-1, (0, 3.5)) + lane(-2, (0, 1.5), kind="sidewalk")
)
PARABOLA = '<paramPoly3 aU="0" bU="40" cU="0" dU="0" aV="0" bV="0" cV="6" dV="0" pRange="normalized"/>'
SHAPES = {
    "line": ("<line/>", 40.0),
    "arc": ('<arc curvature="-0.04"/>', 60.0),
    "spiral": ('<spiral curvStart="-0.02" curvEnd="0.06"/>', 60.0),
    "poly3": ('<poly3 a="0" b="0" c="0.005" d="-0.0001"/>', 40.0),
    # Its arc length: (r √(1 + r²) + asinh r) / (4 c) with v = c u², r = 2 c 40.
    "paramPoly3": (PARABOLA, (0.3 * math.sqrt(1.09) + math.asinh(0.3)) / 0.015),
}

LANE = section(0.0, right=lane(-1, (0, 3.5)))


@pytest.fixture(scope="module")
def network(tmp_path_factory: pytest.TempPathFactory) -> OpenDrive:
    """One road of each shape, far from each other, rolled and with lanes of changing width."""
    roads = [
        road(
            name,
            geometry(shape, length, x=200.0 * k, y=-50.0 * k, hdg=0.7 * k),
            length,
            lanes=LANES,
            elevation=cubics("elevation", (0, 10.0, 0.05)),
            lateral=cubics("superelevation", (0, 0.03, 0.001)),
        )
        for k, (name, (shape, length)) in enumerate(SHAPES.items())
    ]
    return read_text(tmp_path_factory.mktemp("network"), document(*roads))


@pytest.fixture(scope="module")
def finder(network: OpenDrive) -> RoadFinder:
    return RoadFinder(network)


@given(
    st.integers(0, len(SHAPES) - 1),
    st.floats(0, 1),
    st.sampled_from([0, 2, 3]),
    st.floats(0.001, 0.999),
)
def test_there_and_back(
    network: OpenDrive, finder: RoadFinder, index: int, along: float, k: int, across: float
) -> None:
    """Every place on a lane is found again, to a micrometre."""
    lanes = np.array([network.lanes.start[index] + k])
    roads = np.array([index])
    s = along * network.roads.length[roads]
    inner, outer = lane_borders(network, lanes, s)
    t = inner + across * (outer - inner)
    x, y, _ = surface_points(network, roads, s, t)
    places = finder.find(x, y)
    assert places.start.tolist() == [0, 1]
    assert places.road.tolist() == [index]
    assert places.lane.tolist() == lanes.tolist()
    assert places.inside.tolist() == [True]
    assert places.distance.tolist() == [0.0]
    assert places.s[0] == pytest.approx(s[0], abs=1e-6)
    assert places.t[0] == pytest.approx(t[0], abs=1e-6)


def test_many_at_once_as_one_by_one(network: OpenDrive, finder: RoadFinder) -> None:
    rng = np.random.default_rng(7)
    x, y = rng.uniform(-50, 900, 200), rng.uniform(-250, 50, 200)
    together = finder.find(x, y)
    for k in range(0, 200, 20):
        alone = finder.find(x[k : k + 1], y[k : k + 1])
        rows = slice(together.start[k], together.start[k + 1])
        assert together.road[rows].tolist() == alone.road.tolist()
        np.testing.assert_allclose(together.s[rows], alone.s, atol=1e-9)


def test_a_bridge_over_a_road(tmp_path: Path) -> None:
    below = road("below", geometry("<line/>", 100.0))
    above = road(
        "above", geometry("<line/>", 100.0, x=50.0, y=-50.0, hdg=math.pi / 2), elevation=cubics("elevation", (0, 6.0))
    )
    file = read_text(tmp_path, document(below, above))
    places = RoadFinder(file).find(np.array([51.0]), np.array([2.0]))
    assert sorted(file.roads.id[k] for k in places.road) == ["above", "below"]
    assert places.inside.all()
    # The middle of its lane is 0.25 m away, that of the lane above 0.75 m.
    assert file.roads.id[places.road[0]] == "below"
    np.testing.assert_allclose(places.s[0], 51.0)
    np.testing.assert_allclose(places.t[0], 2.0)


def test_beside_all_lanes_the_nearest_road_is_found(tmp_path: Path) -> None:
    file = read_text(
        tmp_path, document(road("1", geometry("<line/>", 100.0)), road("2", geometry("<line/>", 100.0, y=80.0)))
    )
    places = RoadFinder(file).find(np.array([30.0, 104.0]), np.array([33.5, 80.0]))
    assert [file.roads.id[k] for k in places.road] == ["1", "2"]
    assert places.inside.tolist() == [False, False]
    np.testing.assert_allclose(places.distance, [30.0, 4.0])
    np.testing.assert_allclose(places.s, [30.0, 100.0])
    np.testing.assert_allclose(places.t, [33.5, 0.0], atol=1e-9)
    assert file.lanes.id[places.lane[0]] == 1


def test_a_road_that_comes_by_twice(tmp_path: Path) -> None:
    """A loop of 270 degrees crosses itself: both places are found."""
    plan = geometry("<line/>", 50.0) + geometry('<arc curvature="0.05"/>', 30 * math.pi, 50.0, 50.0, 0.0, 0.0)
    plan += geometry("<line/>", 50.0, 50 + 30 * math.pi, 30.0, 20.0, 1.5 * math.pi)
    file = read_text(tmp_path, document(road("loop", plan, 100 + 30 * math.pi)))
    places = RoadFinder(file).find(np.array([30.0]), np.array([0.0]))
    np.testing.assert_allclose(np.sort(places.s), [30.0, 70 + 30 * math.pi])


def test_nothing_to_find(tmp_path: Path) -> None:
    file = read_text(tmp_path, document())
    assert RoadFinder(file).find(np.array([1.0]), np.array([2.0])).start.tolist() == [0, 0]
    other = RoadFinder(read_text(tmp_path, document(road(lanes=""))))
    places = other.find(np.array([1.0, np.nan]), np.array([2.0, 0.0]))
    assert places.start.tolist() == [0, 1, 1]
    assert places.lane.tolist() == [ABSENT]
    np.testing.assert_allclose(places.distance, [2.0])


def test_roads_on_each_other_by_the_hundred_are_refused(tmp_path: Path) -> None:
    copies = [road(str(k), lanes=LANE) for k in range(300)]
    near = [text.replace('x="0.0"', f'x="{k * 1e-3}"') for k, text in enumerate(copies)]
    file = read_text(tmp_path, document(*near))
    with pytest.raises(InputError, match=r"too many roads lie on each other .* at road '\d+', s = \d+ m; look"):
        refuse_crowds(file)
    # As many side by side are a large car park.
    apart = [text.replace('y="0.0"', f'y="{k * 3.5}"') for k, text in enumerate(copies)]
    refuse_crowds(read_text(tmp_path, document(*apart)))


def test_larger_areas_than_any_road_covers_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:

    monkeypatch.setattr(finding, "_CELLS", 10.0)
    monkeypatch.setattr(finding, "_CELLS_EACH", 1.0)
    with pytest.raises(InputError, match=r"roads cover too large an area to compare them, most at road '1'"):
        refuse_crowds(read_text(tmp_path, document(road(lanes=LANE))))

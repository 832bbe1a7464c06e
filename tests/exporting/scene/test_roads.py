"""The surface of roads without overlap, and its rim."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from scene_cases import STREET, crossing
from xodr_text import LINE, cubics, document, geometry, lane, read_text, road, section

from osm2xodr.exporting.scene.model import Level, RoadSurface
from osm2xodr.exporting.scene.roads import rim_of, road_surface


def areas(surface: RoadSurface) -> dict[str, float]:
    """Area of each kind in plan, m²; all but kerbs look up."""
    a, b, c = np.moveaxis(surface.vertices[surface.faces], 1, 0)
    size = 0.5 * np.cross(b - a, c - a)[:, 2]
    kerb = surface.kind == surface.kinds.index("kerb")
    assert (size[~kerb] > 0).all()
    np.testing.assert_allclose(size[kerb], 0.0, atol=1e-9)
    return {kind: float(size[surface.kind == k].sum()) for k, kind in enumerate(surface.kinds)}


def edges_alone(surface: RoadSurface) -> list[tuple[int, int]]:
    """Edges that one triangle has alone; none has more than two, which run against each other."""
    ways = Counter((int(row[k]), int(row[(k + 1) % 3])) for row in surface.faces for k in range(3))
    assert set(ways.values()) == {1}
    return [way for way in ways if way[::-1] not in ways]


def test_streets_that_cross_share_one_pavement(tmp_path: Path) -> None:
    surface = road_surface(crossing(tmp_path), 0.05, 10.0)
    found = areas(surface)
    # What is driven on covers the pavements: 700 m² each, 49 m² of them in common.
    assert found["driving"] == pytest.approx(2 * 700 - 49, abs=0.1)
    # Each arm has two pavements of 2 m from 5.5 m beside the middle to its end; their corners are shared.
    assert found["sidewalk"] == pytest.approx(8 * 2.0 * (50 - 5.5) + 4 * 4.0, abs=0.1)
    assert sorted(set(np.round(surface.vertices[:, 2], 6).tolist())) == [0.0, 0.12]


def test_bicycle_lanes_lead_on_over_what_cars_drive_on(tmp_path: Path) -> None:
    bikes = section(0.0, right=lane(-1, (0, 2.0), kind="biking"))
    text = document(
        road("1", geometry(LINE, 40.0, y=1.0), 40.0, junction="9", lanes=bikes),
        road("2", geometry(LINE, 40.0, x=20.0, y=-20.0, hdg=np.pi / 2), 40.0, junction="9", lanes=STREET),
        '<junction id="9" name=""/>',
    )
    found = areas(road_surface(read_text(tmp_path, text), 0.05, 10.0))
    assert found["biking"] == pytest.approx(40 * 2, abs=0.1)
    assert found["driving"] == pytest.approx(40 * 7 - 2 * 7, abs=0.1)


def test_surfaces_have_no_cracks(tmp_path: Path) -> None:
    surface = road_surface(crossing(tmp_path), 0.05, 10.0)
    rim = rim_of(surface)
    # Upright edges at the ends of kerbs apart, what is open is the rim.
    alone = [
        edge
        for edge in edges_alone(surface)
        if (surface.vertices[edge[0], :2] != surface.vertices[edge[1], :2]).any()
    ]
    assert sorted(alone) == sorted(map(tuple, rim.edges.tolist()))
    np.testing.assert_array_equal(np.sort(rim.edges[:, 0]), np.sort(rim.edges[:, 1]))
    assert set(rim.beyond.tolist()) == {int(Level.GROUND)}
    start, end = surface.vertices[rim.edges[:, 0]], surface.vertices[rim.edges[:, 1]]
    # The outline runs counter-clockwise around all of it.
    enclosed = 0.5 * (start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]).sum()
    assert enclosed == pytest.approx(2 * 1100 - 121, abs=0.1)


def test_roads_above_each_other_do_not_cut_each_other(tmp_path: Path) -> None:
    bridge = '<objects><bridge id="b" s="20" length="60" type="concrete"/></objects>'
    surface = road_surface(crossing(tmp_path, height=6.0, more=bridge), 0.05, 10.0)
    found = areas(surface)
    assert found["driving"] == pytest.approx(1400)
    assert found["sidewalk"] == pytest.approx(800)
    a, b, c = np.moveaxis(surface.vertices[surface.faces], 1, 0)
    size = 0.5 * np.cross(b - a, c - a)[:, 2]
    assert size[surface.level == int(Level.BRIDGE)].sum() == pytest.approx(60 * 11)
    beyond = rim_of(surface).beyond
    assert (beyond == int(Level.BRIDGE)).sum() > 0


def test_lone_roads_keep_their_stations(tmp_path: Path) -> None:
    surface = road_surface(read_text(tmp_path, document(road(lanes=STREET))), 0.05, 10.0)
    assert set(np.round(surface.vertices[:, 0], 9).tolist()) == {10.0 * k for k in range(11)}
    np.testing.assert_allclose(surface.uv[:, 0], surface.vertices[:, 0], atol=1e-9)
    np.testing.assert_allclose(surface.uv[:, 1], surface.vertices[:, 1], atol=1e-9)


LANES = section(0.0, lane(1, (0, 3.5)), lane(-1, (0, 3.5)))


def test_narrow_gaps_between_roads_are_closed(tmp_path: Path) -> None:
    # Two roads 0.1 m apart, and two across their ends.
    along = [road(str(y), geometry(LINE, 50.0, y=y), 50.0, lanes=LANES) for y in (0.0, 7.1)]
    across = [
        road(f"1{x}", geometry(LINE, 40.0, x=x, y=-15.0, hdg=np.pi / 2), 40.0, lanes=LANES) for x in (0.0, 50.0)
    ]
    surface = road_surface(read_text(tmp_path, document(*along, *across)), 0.05, 10.0)
    assert areas(surface)["driving"] == pytest.approx(2 * 40.0 * 7.0 + 43.0 * 14.1, abs=0.01)
    rim = rim_of(surface)
    assert not (np.abs(surface.vertices[rim.edges].mean(1)[:, :2] - [25.0, 3.55]) < [20.0, 1.0]).all(1).any()


def test_roads_that_miss_each_other_by_less_than_the_grid_are_joined(tmp_path: Path) -> None:
    roads = (
        road(str(x), geometry(LINE, 50.0, x=x), 50.0, lanes=LANES, elevation=cubics("elevation", (0, z)))
        for x, z in ((0.0, 0.0), (50.0002, 0.01), (100.0, 0.02))
    )
    surface = road_surface(read_text(tmp_path, document(*roads)), 0.05, 10.0)
    assert areas(surface)["driving"] == pytest.approx(7.0 * 150.0, abs=0.01)
    middle = surface.vertices[rim_of(surface).edges].mean(1)
    assert set(np.round(middle[np.abs(middle[:, 1]) < 3.4, 0]).tolist()) == {0.0, 150.0}


def test_edges_of_roads_above_each_other_share_places(tmp_path: Path) -> None:
    surface = road_surface(crossing(tmp_path, height=6.0), 0.05, 10.0)
    # The kerbs cross at both heights.
    assert {(x, y) for x, y in np.round(surface.vertices[surface.vertices[:, 2] < 1.0, :2], 6).tolist()} >= {
        (x, y) for x in (-3.5, 3.5) for y in (-3.5, 3.5)
    }
    faces = np.sort(np.unique(surface.vertices[:, :2], axis=0, return_inverse=True)[1].ravel()[surface.faces], axis=1)
    middle = surface.vertices[surface.faces].mean(1)
    lower, upper = ({tuple(row) for row in faces[rows].tolist()} for rows in (middle[:, 2] < 3.0, middle[:, 2] > 3.0))
    kerb = surface.kind == surface.kinds.index("kerb")
    over = (np.abs(middle[:, :2]) < 5.5).all(1) & (middle[:, 2] > 3.0) & ~kerb
    assert {tuple(row) for row in faces[over].tolist()} <= lower & upper

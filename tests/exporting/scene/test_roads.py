"""The surface of roads without overlap, and its rim."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import shapely
from scene_cases import STREET, crossing
from xodr_text import document, read_text, road

from osm2xodr.exporting.scene import overlaps
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


def test_common_slivers_thinner_than_the_grid_have_no_cells() -> None:
    one, other = (shapely.box(0.0, 0.0, width, 1.0) for width in (0.1 * overlaps.GRID, 1.0))
    assert list(overlaps._areas(np.array([one]), np.array([0]), [0])) == []
    ((cells, kind),) = overlaps._areas(np.array([other]), np.array([0]), [0])
    assert (float(shapely.area(cells).sum()), kind) == (1.0, 0)

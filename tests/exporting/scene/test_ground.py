"""The ground around roads: exact heights, no gaps, and what bridges and tunnels make of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import shapely
from ground_cases import areas, edges_of, rim_edges, straight, strips
from scene_cases import crossing
from scene_files import Conversions, scene_named

from osm2xodr.errors import InputError
from osm2xodr.exporting.scene.ground import Ground, build_ground
from osm2xodr.exporting.scene.levels import Height, settled
from osm2xodr.exporting.scene.model import Level, RoadSurface
from osm2xodr.exporting.scene.roads import rim_of, road_surface
from osm2xodr.model import FloatArray, IntArray
from osm2xodr.opendrive import read_xodr

LONG = [(float(x), 20.0) for x in range(-40, 241, 20)]


def plane(level: float, east: float = 0.0, north: float = 0.0) -> Height:
    return lambda x, y: level + east * x + north * y


def made(surface: RoadSurface, height: Height | None) -> Ground:
    return build_ground(surface, rim_of(surface), height, 500.0)


def triangles(ground: Ground, detail: int = 0) -> FloatArray:
    """Return the triangles of ground and walls, (n, 3, 3)."""
    found = [part for part in ground.parts if part.detail is None or (part.detail == detail).all()]
    return np.concatenate([part.vertices[part.faces] for part in found])


def terrain(ground: Ground, detail: int = 0) -> FloatArray:
    part = [part for part in ground.parts if part.name == "Terrain"][detail]
    return part.vertices[part.faces]


def assert_sound(surface: RoadSurface, ground: Ground, but: IntArray | Sequence[int] = ()) -> None:
    """Every rim but those given is met, no triangle is none or upside down, and roads and ground fill one area."""
    rim = rim_of(surface)
    kept = np.delete(np.arange(len(rim.edges)), but)
    for detail in range(3):
        corners = triangles(ground, detail)
        edges = edges_of(corners)
        assert max(edges.values()) == 1
        assert [edge for edge in rim_edges(surface.vertices, rim.edges[kept]) if edge not in edges] == []
        area, plan = areas(corners)
        assert area.min() > 1e-6
        assert plan.min() > -1e-9
        assert_fills_one_area(corners, surface.vertices[surface.faces[surface.level == Level.GROUND]])


def assert_fills_one_area(ground: FloatArray, road: FloatArray, shared: float = 0.0) -> None:
    """Seen from above, both together have neither gaps nor overlaps, but for what roads share, m²."""
    every = np.concatenate([ground, road])
    plan = areas(every)[1]
    whole = shapely.union_all(shapely.polygons(every[plan > 1e-9][:, :, :2]))
    assert plan.sum() - shared == pytest.approx(whole.area, rel=1e-9)
    assert [len(part.interiors) for part in shapely.get_parts(whole)] == [0]


@pytest.mark.parametrize(
    ("level", "wanted"),
    [
        # The edge of the road is at y = 4, 20 m high: 1:2 down to the ground, and up to it.
        (10.0, [17.0, 14.5, 12.0, 10.0, 10.0]),
        (30.0, [23.0, 25.5, 28.0, 30.0, 30.0]),
        (20.0, [20.0, 20.0, 20.0, 20.0, 20.0]),
    ],
)
def test_a_plane_is_cut_and_filled_by_one_to_two(level: float, wanted: list[float]) -> None:
    surface = strips(straight(LONG))
    ground = made(surface, plane(level))
    y = np.array([10.0, 15.0, 20.0, 25.0, 30.0])
    for side in (1.0, -1.0):
        assert ground.heights(np.full(5, 100.0), side * y) == pytest.approx(wanted, abs=1e-12)
    assert_sound(surface, ground)
    assert ground.unknown == 0.0


def test_a_hill_is_itself_away_from_roads() -> None:
    def hill(x: FloatArray, y: FloatArray) -> FloatArray:
        out: FloatArray = 20.0 + 30.0 * np.exp(-((x - 100.0) ** 2 + (y - 70.0) ** 2) / 800.0)
        return out

    surface = strips(straight(LONG))
    ground = made(surface, hill)
    corners = terrain(ground).reshape(-1, 3)
    nodes = corners[(np.rint(corners[:, :2] / 5.0) * 5.0 == corners[:, :2]).all(1)]
    # The hill is 0.07 m high at the road.
    far = nodes[np.abs(nodes[:, 1]) > 4.2]
    assert np.abs(far[:, 2] - hill(far[:, 0], far[:, 1])).max() < 0.1
    away = far[np.abs(far[:, 1]) >= 10.0]
    assert (away[:, 2] == hill(away[:, 0], away[:, 1])).all()
    assert away[:, 2].max() == 50.0
    assert_sound(surface, ground)


def test_slopes_count_from_the_slope_that_was_there() -> None:
    surface = strips(straight(LONG))
    ground = made(surface, plane(10.0, north=0.8))
    # The ground is at 13.2 m at the edge: 6.8 m of fill, which fades by 1:2, whatever there is at the other edge.
    found = ground.heights(np.array([100.0, 100.0, 100.0]), np.array([10.0, 15.0, 20.0]))
    assert found == pytest.approx([18.0 + 6.8 - 3.0, 22.0 + 6.8 - 5.5, 26.0], abs=1e-9)
    assert_sound(surface, ground)


def test_islands_in_a_loop_are_closed() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 37)[:-1]
    ring = [*range(36), 0]
    inner, outer = ([(r * np.cos(a), r * np.sin(a), 12.0) for a in angle[ring].tolist()] for r in (20.0, 28.0))
    surface = strips((inner, outer, [Level.GROUND] * 36))
    ground = made(surface, plane(11.0))
    assert_sound(surface, ground)
    assert ground.heights(np.array([0.0]), np.array([0.0])) == pytest.approx([11.0])


def test_carriageways_at_different_heights_have_a_wall_between_them() -> None:
    upper = straight([(x, 26.0) for x, _ in LONG], y=10.0)
    surface = strips(straight(LONG), upper)
    ground = made(surface, plane(20.0))
    assert_sound(surface, ground)
    (wall,) = (part for part in ground.parts if part.name == "Retaining_Wall")
    assert wall.material == "concrete"
    area, _ = areas(wall.vertices[wall.faces])
    # 280 m long, 2 m wide and 6 m high.
    assert area.sum() == pytest.approx(280.0 * np.hypot(2.0, 6.0), rel=0.02)
    between = terrain(ground).reshape(-1, 3)
    along = (between[:, 0] > -40.0) & (between[:, 0] < 240.0)
    assert not ((between[:, 1] > 4.0) & (between[:, 1] < 6.0) & along).any()


def test_roads_that_lie_over_each_other_are_met_where_they_can_be_seen(tmp_path: Path) -> None:
    # No bridge, but 3 m apart: a road along y over one along x.
    surface = road_surface(crossing(tmp_path, height=3.0), 0.05, 10.0)
    assert (surface.level == Level.GROUND).all()
    ground = made(surface, plane(0.0))
    corners = triangles(ground)
    area, _ = areas(corners)
    assert_fills_one_area(corners, surface.vertices[surface.faces], shared=11.0 * 11.0)
    assert area.min() > 1e-6
    # What lies over it is a bridge.
    found = settled(surface, None)[0].level
    middle = surface.vertices[surface.faces].mean(1)
    over = (np.abs(middle[:, :2]) < 5.5).all(1) & (middle[:, 2] > 2.0)
    assert (found[over] == Level.BRIDGE).all()
    assert (found[(middle[:, 2] < 1.0) | (np.abs(middle[:, 1]) > 10.0)] == Level.GROUND).all()
    # Where edges cross there is a corner at either height.
    there = {round(z, 9) for x, y, z in corners.reshape(-1, 3).tolist() if (x, y) == (5.5, 5.5)}
    assert there == {0.12, 3.12}


def test_kerbs_of_roads_over_others_are_on_the_bridge_too(tmp_path: Path) -> None:
    surface, _ = settled(road_surface(crossing(tmp_path, height=3.0), 0.05, 10.0), None)
    corners = surface.vertices[surface.faces]
    middle = corners.mean(1)
    kerb = (surface.kind == surface.kinds.index("kerb")) & (middle[:, 2] > 2.0)
    above = kerb & (np.abs(corners[:, :, 1]).max(1) <= 10.0)
    # At both sides of 20 m of the road.
    assert areas(corners[above])[0].sum() == pytest.approx(2 * 20.0 * 0.12)
    assert (surface.level[above] == Level.BRIDGE).all()
    assert (surface.level[kerb & (np.abs(middle[:, 1]) > 15.0)] == Level.GROUND).all()


def test_ground_runs_through_below_bridges() -> None:
    stations = [(-40.0, 6.0), (0.0, 6.0), (60.0, 6.0), (120.0, 6.0)]
    levels = [Level.GROUND, Level.BRIDGE, Level.GROUND]
    surface = strips(straight(stations, levels))
    # In the elevation model the bridge stands as a dam.
    ground = made(surface, lambda x, y: np.where(np.abs(y) < 20.0, 7.0, 0.0))
    assert_sound(surface, ground)
    found = ground.heights(np.array([20.0, 30.0, 40.0]), np.zeros(3))
    assert (found <= 6.0 - 1.2 + 1e-9).all()
    low = made(surface, plane(0.0))
    assert low.heights(np.array([30.0]), np.zeros(1)) == pytest.approx([0.0])
    # Beyond the abutment it falls by 1:2.
    assert low.heights(np.array([5.0]), np.zeros(1)) == pytest.approx([3.5])


def test_tunnels_leave_the_ground_alone_and_their_portals_open() -> None:
    stations = [(-60.0, 0.0), (0.0, 0.0), (80.0, 0.0), (140.0, 0.0)]
    levels = [Level.GROUND, Level.TUNNEL, Level.GROUND]
    surface = strips(straight(stations, levels))
    rim = rim_of(surface)
    portals = np.flatnonzero(rim.beyond == Level.TUNNEL)
    assert len(portals) == 2

    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        return np.where(np.abs(x - 40.0) < 65.0, 20.0, 1.0)

    assert settled(surface, height)[0].level.tolist() == surface.level.tolist()
    ground = made(surface, height)
    assert_sound(surface, ground, portals)
    assert (ground.heights(np.array([40.0, 40.0]), np.array([0.0, 15.0])) == 20.0).all()
    corners = triangles(ground)
    inside = corners[(np.abs(corners[:, :, 1]) < 4.0 - 1e-9).any(1) & (corners[:, :, 0] > 0.0).any(1)]
    inside = inside[(inside[:, :, 0] < 80.0).any(1)]
    # Nothing hangs into the opening, and the wall above it begins where it ends.
    assert inside[:, :, 2].min() >= 5.0
    opening = [row for row in corners.reshape(-1, 3).tolist() if row[0] == 0.0 and abs(row[1]) == 4.0]
    assert sorted({z for _, _, z in opening}) == [0.0, 5.0, 20.0]


def test_shallow_tunnels_are_covered() -> None:
    stations = [(-60.0, 0.0), (0.0, 0.0), (80.0, 0.0), (140.0, 0.0)]
    surface = strips(straight(stations, [Level.GROUND, Level.TUNNEL, Level.GROUND]))
    ground = made(surface, plane(4.0))
    assert ground.heights(np.array([40.0]), np.zeros(1)) == pytest.approx([5.5])
    assert ground.heights(np.array([40.0]), np.array([40.0])) == pytest.approx([4.0])


def test_passages_are_roads_on_the_ground() -> None:
    stations = [(-60.0, 0.0), (0.0, 0.0), (20.0, 0.0), (80.0, 0.0)]
    surface = strips(straight(stations, [Level.GROUND, Level.TUNNEL, Level.GROUND]))
    for unknown in (plane(np.nan), None):
        assert not settled(surface, unknown)[1].any()
    surface, passage = settled(surface, plane(0.5))
    assert passage.tolist() == [False, False, True, True, False, False]
    assert (surface.level == Level.GROUND).all()
    ground = made(surface, plane(0.5))
    assert_sound(surface, ground)
    # It is where the road is, and not above it.
    assert triangles(ground)[..., 2].max() == 0.5


def test_junctions_in_tunnels_are_in_them() -> None:
    stations = [(-60.0, 0.0), (0.0, 0.0), (20.0, 0.0), (60.0, 0.0)]
    surface = strips(straight(stations, [Level.TUNNEL, Level.GROUND, Level.TUNNEL]))
    found, passage = settled(surface, plane(30.0))
    assert (found.level == Level.TUNNEL).all()
    assert not passage.any()
    # Not where one corner is near the ground, as beside a portal.
    assert settled(surface, lambda x, y: np.where(x > 10.0, 30.0, 4.0))[0].level.tolist() == surface.level.tolist()
    # Nor roads in a cutting that lead into none, or into one and out of the file.
    for levels in ([Level.GROUND] * 3, [Level.GROUND, Level.GROUND, Level.TUNNEL]):
        alone = strips(straight(stations, levels))
        assert settled(alone, plane(14.0))[0].level.tolist() == alone.level.tolist()
    # No cutting is as deep.
    assert (settled(alone, plane(16.0))[0].level == Level.TUNNEL).all()


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.8])
def test_the_ground_ends_at_a_smooth_line_around_roads(angle: float) -> None:
    cos, sin = np.cos(angle), np.sin(angle)
    road = straight(LONG)
    turned = tuple([(cos * x - sin * y, sin * x + cos * y, z) for x, y, z in side] for side in road[:2])
    surface = strips((turned[0], turned[1], road[2]))
    ground = made(surface, lambda x, y: 20.0 + 0.1 * x + 0.0 * y)
    assert_sound(surface, ground)
    strip = shapely.MultiPoint(surface.vertices[:, :2]).convex_hull
    # The outline is straight across squares of up to 10 m, or 20 m, of which the diagonal is a chord.
    for detail, size in enumerate((10.0, 10.0, 20.0)):
        corners = triangles(ground, detail)
        whole = shapely.union_all(shapely.polygons(corners[areas(corners)[1] > 1e-9][:, :, :2])).union(
            strip.buffer(1e-6)
        )
        outer = shapely.get_coordinates(shapely.segmentize(shapely.get_exterior_ring(whole), 1.0))
        away = shapely.distance(strip, shapely.points(outer))
        assert away.max() <= 100.0 + 0.1
        assert away.min() >= 100.0 - 2.0 * size**2 / (8.0 * 100.0) - 0.1


def test_the_coarsest_ground_alone_is_the_same() -> None:
    surface = strips(straight(LONG))
    whole = build_ground(surface, rim_of(surface), plane(10.0), 500.0)
    alone = build_ground(surface, rim_of(surface), plane(10.0), 500.0, coarsest_alone=True)
    np.testing.assert_array_equal(triangles(alone, 2), triangles(whole, 2))
    assert [part.detail.max() for part in alone.parts if part.detail is not None] == [2]


def test_gaps_of_the_elevation_model_are_closed_smoothly() -> None:
    def damaged(x: FloatArray, y: FloatArray) -> FloatArray:
        gap = (np.abs(x - 120.0) < 30.0) & (np.abs(y - 50.0) < 30.0)
        return np.where(gap, np.nan, 18.0 + 0.02 * x + 0.05 * y)

    surface = strips(straight(LONG))
    ground, whole = made(surface, damaged), made(surface, plane(18.0, 0.02, 0.05))
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(60.0, 180.0, 7.0), np.arange(10.0, 95.0, 7.0)))
    assert ground.heights(x, y) == pytest.approx(whole.heights(x, y), abs=1e-9)
    assert_sound(surface, ground)
    assert (ground.unknown, ground.interpolated) == (0.0, 25.0 * 11 * 11)
    assert (whole.unknown, whole.interpolated) == (0.0, 0.0)


def test_without_heights_there_is_no_ground_but_beside_roads() -> None:
    def half(x: FloatArray, y: FloatArray) -> FloatArray:
        return np.where(x < 150.0, 18.0, np.nan)

    surface = strips(straight(LONG))
    ground = made(surface, half)
    corners = triangles(ground).reshape(-1, 3)
    beyond = corners[corners[:, 0] >= 150.0]
    assert np.abs(beyond[:, 1]).max() <= 4.0 + 10.0
    assert beyond[:, 2].min() == beyond[:, 2].max() == 20.0
    assert ground.unknown > 5000.0
    rim = rim_of(surface)
    edges = edges_of(triangles(ground))
    assert all(edge in edges for edge in rim_edges(surface.vertices, rim.edges))


def test_without_an_elevation_model_there_are_level_strips() -> None:
    surface = strips(straight([(x, 20.0 + 0.05 * x) for x, _ in LONG]))
    ground = made(surface, None)
    corners = triangles(ground).reshape(-1, 3)
    assert np.abs(corners[:, 1]).max() == pytest.approx(14.0)
    middle = corners[np.abs(corners[:, 0] - 100.0) < 90.0]
    assert np.abs(middle[:, 2] - 20.0 - 0.05 * middle[:, 0]).max() < 1e-9


def test_tiles_of_any_detail_meet() -> None:
    surface = strips(straight([(float(x), 5.0) for x in range(380, 621, 20)], y=440.0))
    ground = made(surface, lambda x, y: 5.0 + 3.0 * np.sin(x / 30.0) + 2.0 * np.cos(y / 20.0))
    assert_sound(surface, ground)
    counts, borders = [], []
    for detail in range(3):
        corners = terrain(ground, detail)
        counts.append(len(corners))
        for axis in (0, 1):
            column = corners[:, :, axis]
            away = (np.abs(corners[:, :, 1] - 440.0) > 20.0).all(1) | (np.abs(corners[:, :, 0] - 500.0) > 140.0).all(
                1
            )
            assert not ((column.min(1) < 500.0) & (column.max(1) > 500.0) & away).any(), "across a border"
        borders.append({edge for edge in edges_of(corners) if edge[0][0] == edge[1][0] == 500.0})
    assert counts[0] > 2 * counts[1] > 2 * counts[2]
    assert borders[0] == borders[1] == borders[2]
    assert len(borders[0]) > 20


def test_the_same_roads_have_the_same_ground() -> None:
    surface = strips(straight(LONG), straight([(x, 22.0) for x, _ in LONG], y=13.0))
    one, other = (made(surface, plane(18.0, 0.02, 0.3)) for _ in range(2))
    for a, b in zip(one.parts, other.parts, strict=True):
        assert a.vertices.tobytes() == b.vertices.tobytes()
        assert a.faces.tobytes() == b.faces.tobytes()


def test_bridges_alone_have_ground_below() -> None:
    surface = strips(straight(LONG, [Level.BRIDGE] * (len(LONG) - 1)))
    ground = made(surface, plane(3.0))
    assert (terrain(ground)[:, :, 2] == 3.0).all()
    area, _ = areas(terrain(ground))
    # All within 100 m of a strip of 280 m by 8 m.
    assert area.sum() == pytest.approx(280 * 8 + 2 * (280 + 8) * 100 + np.pi * 100**2, rel=2e-3)
    assert [part.name for part in ground.parts] == ["Terrain"] * 3
    assert made(surface, None).parts == ()


def test_coordinates_may_be_those_of_a_projection() -> None:
    road = straight([(500_000.0 + x, z) for x, z in LONG], y=5_400_000.0)
    surface = strips(road)
    ground = made(surface, plane(18.0))
    assert_sound(surface, ground)
    found = ground.heights(np.array([500_100.0]), np.array([5_400_005.0]))
    assert found == pytest.approx([19.5])


def test_areas_too_large_for_the_memory_are_refused() -> None:
    far = [(0.0, 0.0), (20.0, 0.0)]
    surface = strips(straight(far), straight([(x + 4e5, z) for x, z in far], y=4e5))
    with pytest.raises(InputError, match="crop"):
        made(surface, plane(0.0))


def above_ground(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Return how high points (n, 3) lie above the triangles (m, 3, 3) that they lie within as seen from above."""
    shapes = shapely.polygons(corners[:, :, :2])
    wide = shapely.area(shapes) > 1e-6
    tree = shapely.STRtree(shapely.buffer(shapes[wide], -1e-3))
    point, triangle = tree.query(shapely.points(points[:, :2]), predicate="intersects")
    a, b, c = np.moveaxis(corners[wide][triangle], 1, 0)
    normal = np.cross(b - a, c - a)
    out: FloatArray = ((points[point] - a) * normal).sum(1) / normal[:, 2]
    return out


@pytest.mark.parametrize("name", ["montlake_roundabout", "fremantle_placement"])
def test_real_roads_lie_on_the_ground_at_their_edges_and_nowhere_in_it(name: str, conversions: Conversions) -> None:
    def hills(x: FloatArray, y: FloatArray) -> FloatArray:
        out: FloatArray = 20.0 + 5.0 * np.sin(x / 40.0) * np.cos(y / 30.0)
        return out

    file = read_xodr(conversions.of(scene_named(name)).path)
    surface, _ = settled(road_surface(file, 0.05, 10.0), hills)
    ground, rim = made(surface, hills), rim_of(surface)
    corners = triangles(ground)
    known = edges_of(corners)
    own = rim.edges[rim.beyond == Level.GROUND]
    length = np.linalg.norm(np.diff(surface.vertices[own], axis=1)[:, 0], axis=1)
    unmet = np.array([edge not in known for edge in rim_edges(surface.vertices, own)])
    # Edges that lie on another road are not met.
    assert length[unmet].sum() < 0.0002 * length.sum()
    assert length.sum() > 2000.0
    on_it = surface.vertices[np.unique(surface.faces[surface.level == Level.GROUND])]
    assert len(above_ground(on_it, corners)) == 0
    # Points that do lie above or below it would be seen.
    middle = corners.mean(1)[:100]
    assert above_ground(middle + np.array([0.0, 0.0, 0.3]), corners) == pytest.approx(0.3)

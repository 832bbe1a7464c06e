"""Water in the ground: where it is, how high, and its shores."""

from __future__ import annotations

import numpy as np
import pytest
from ground_cases import areas, straight, strips

from osm2xodr.exporting.scene.ground import Ground, build_ground
from osm2xodr.exporting.scene.levels import Height
from osm2xodr.exporting.scene.model import RoadSurface
from osm2xodr.exporting.scene.roads import rim_of
from osm2xodr.exporting.scene.water import WaterShapes, levelled, water_shapes
from osm2xodr.model import FloatArray, OpenWater, Water, WaterArea
from osm2xodr.opendrive import Frame, Header, frame_of

LONG = [(float(x), 20.0) for x in range(-40, 241, 20)]
BOX = np.array([[0.0, -100.0], [200.0, 100.0]])
ON_LAND = np.array([[100.0, -90.0], [100.0, 100.0]])


def frame() -> Frame:
    found, why = frame_of(Header((1, 7), {}, "+proj=tmerc +lat_0=47 +lon_0=11 +datum=WGS84", None))
    assert found is not None, why
    return found


def places(*corners: tuple[float, float]) -> FloatArray:
    x, y = np.array(corners, float).T
    return np.column_stack(frame().to_geographic(x, y))


def rectangle(west: float, south: float, east: float, north: float) -> FloatArray:
    return places((west, south), (east, south), (east, north), (west, north))


def shapes(water: Water) -> WaterShapes:
    return water_shapes(water, frame(), BOX, ON_LAND if water.open_areas else ON_LAND[:0])


def found_at(water: Water, *at: tuple[float, float]) -> list[bool]:
    x, y = np.array(at, float).T
    return [row >= 0 for row in shapes(water).found_at(x, y).tolist()]


def test_the_sea_is_on_the_right_of_the_coast() -> None:
    # Drawn from north to south the sea is in the west; lines need not reach the sides, and may come in pieces.
    north, south = places((60.0, 90.0), (50.0, 0.0)), places((50.0, 0.0), (60.0, -80.0))
    at = ((20.0, 50.0), (20.0, -250.0), (20.0, 250.0), (90.0, 50.0), (90.0, -50.0))
    assert found_at(Water(coastlines=(south, north)), *at) == [True, True, True, False, False]
    assert found_at(Water(coastlines=(north[::-1].copy(), south[::-1].copy())), *at) == [False] * 3 + [True] * 2


def test_islands_are_on_the_left_of_their_coast() -> None:
    ring = rectangle(50.0, -20.0, 90.0, 20.0)
    closed = np.concatenate([ring, ring[:1]])
    assert found_at(Water(coastlines=(closed,)), (70.0, 0.0), (20.0, 0.0), (180.0, 90.0)) == [False, True, True]


def test_lakes_have_islands() -> None:
    lake = WaterArea("way/1", rectangle(0.0, -50.0, 100.0, 50.0), (rectangle(40.0, -10.0, 60.0, 10.0),))
    assert found_at(Water((lake,)), (20.0, 0.0), (50.0, 0.0), (120.0, 0.0)) == [True, False, False]


def test_lakes_beyond_the_roads_are_left_out() -> None:
    lake = WaterArea("way/1", rectangle(5000.0, 0.0, 5100.0, 50.0), ())
    found = shapes(Water((lake,)))
    assert found.areas == ()
    assert len(levelled(found, lambda x, y: np.zeros(len(x)), np.zeros((0, 3))).levels) == 0


def test_rivers_that_are_cut_are_closed_at_the_bounds_of_the_file() -> None:
    shores = places((-900.0, 40.0), (900.0, 40.0)), places((-900.0, 80.0), (900.0, 80.0))
    river = OpenWater("relation/1", shores, ())
    fork = OpenWater("relation/2", (places((100.0, 0.0), (100.0, 1.0)),), ())
    far = OpenWater("relation/3", (places((0.0, 5000.0), (100.0, 5000.0)),), ())
    west, south, east, north = places((20.0, -500.0), (180.0, 500.0)).ravel().tolist()
    at = ((100.0, 60.0), (0.0, 60.0), (100.0, 20.0), (100.0, 90.0))
    cut = Water(open_areas=(river, fork, far), bounds=(west, south, east, north))
    assert found_at(cut, *at) == [True, False, False, False]
    assert (shapes(cut).closed, shapes(cut).left_out) == (("relation/1",), ("relation/2",))
    # Without bounds, or with wide ones, up to where the ground ends.
    for bounds in (None, (-180.0, -90.0, 180.0, 90.0)):
        assert found_at(Water(open_areas=(river,), bounds=bounds), *at) == [True, True, False, False]
    elsewhere = Water(open_areas=(river,), bounds=(0.0, 0.0, 1.0, 1.0))
    assert (shapes(elsewhere).areas, shapes(elsewhere).left_out) == ((), ())


def test_lakes_and_the_sea_are_level_and_rivers_fall() -> None:
    lake = WaterArea("way/1", rectangle(0.0, 0.0, 100.0, 40.0), ())
    river = WaterArea("way/2", rectangle(0.0, -40.0, 200.0, -20.0), ())
    coast = places((-100.0, 80.0), (300.0, 80.0))

    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        return np.where(y > 80.0, 0.1 * x, np.where(y < 0.0, 10.0 + 0.1 * x, 5.0 + np.sin(x) * np.cos(y)))

    water = levelled(shapes(Water((lake, river), coastlines=(coast[::-1].copy(),))), height, np.zeros((0, 3)))
    assert water.seas == 1
    assert water.levels[1] == pytest.approx(5.0, abs=0.1)
    assert np.isnan(water.levels[2])
    x = np.array([20.0, 80.0, 50.0, 150.0, 20.0, 150.0])
    y = np.array([10.0, 30.0, -30.0, -30.0, 120.0, 150.0])
    none = [np.nan, np.nan]
    np.testing.assert_array_equal(water.level_at(x, y), [water.levels[1]] * 2 + none + [water.levels[0]] * 2)
    assert np.isnan(water.level_at(np.array([150.0]), np.array([20.0])))


@pytest.mark.parametrize(
    ("road", "level"),
    [
        ((50.0, -1.0, 8.0), 7.8),  # Lower than the lake, at its shore
        ((50.0, -3.0, 8.0), 10.0),  # Farther from it
        ((50.0, -1.0, 12.0), 10.0),  # Higher
        ((50.0, -1.0, 4.0), 10.0),  # In a cutting
    ],
)
def test_water_is_no_higher_than_roads_at_its_shore(road: tuple[float, float, float], level: float) -> None:
    lake = WaterArea("way/1", rectangle(0.0, 0.0, 100.0, 40.0), ())
    coast = places((300.0, 80.0), (-100.0, 80.0))
    water = shapes(Water((lake,), coastlines=(coast,)))
    found = levelled(water, lambda x, y: np.full(len(x), 10.0), np.array([road, (50.0, 81.0, 7.0)]))
    assert found.levels == pytest.approx([6.8, level])


def made(surface: RoadSurface, height: Height, water: WaterShapes | None) -> Ground:
    return build_ground(surface, rim_of(surface), height, 500.0, water)


def corners_of(ground: Ground, name: str, detail: int = 0) -> FloatArray:
    found = [
        part.vertices[part.faces]
        for part in ground.parts
        if part.name == name and (part.detail is None or (part.detail == detail).all())
    ]
    return np.concatenate(found)


@pytest.mark.parametrize("detail", [0, 1, 2])
def test_shores_are_exact_and_walls_close_them(detail: int) -> None:
    surface = strips(straight(LONG))
    shore = [(23.0, -61.0), (177.0, -63.5), (181.0, -8.0), (26.0, -7.0)]
    water = shapes(Water((WaterArea("way/1", places(*shore), ()),)))
    dry, wet = (made(surface, lambda x, y: np.full(len(x), 17.0), found) for found in (None, water))
    lake, walls = corners_of(wet, "Water", detail), corners_of(wet, "Retaining_Wall", detail)
    x, y = np.array(shore).T
    size = 0.5 * abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
    assert areas(lake)[1].sum() == pytest.approx(size, rel=1e-4)
    assert np.unique(lake[..., 2]) == pytest.approx(17.0)
    land = corners_of(wet, "Terrain", detail)
    assert areas(land)[1].sum() + areas(lake)[1].sum() == pytest.approx(
        areas(corners_of(dry, "Terrain", detail))[1].sum()
    )
    # The slope of the road ends at the shore, which is a wall there: 3 m less half of the way from the edge.
    assert np.abs(areas(walls)[1]).max() < 1e-9
    assert walls[..., 2].min() == pytest.approx(17.0)
    if detail == 0:
        highest = walls[np.abs(walls[..., 0].mean(1) - 30.0) < 10.0]
        assert highest[..., 2].max() == pytest.approx(20.0 - 0.5 * (7.0 - 4.0), abs=0.3)


@pytest.mark.parametrize(("land", "shore"), [(20.0, 20.0), (16.0, 17.0)])
@pytest.mark.parametrize("detail", [0, 1, 2])
def test_land_ends_at_shores_at_its_own_height_or_that_of_the_water(land: float, shore: float, detail: int) -> None:
    # 17 m in the middle of the lake; the model does not know where the shore is.
    surface = strips(straight(LONG))
    corners = [(0.0, -300.0), (203.0, -300.0), (197.0, -43.5), (11.0, -51.0)]
    water = shapes(Water((WaterArea("way/1", places(*corners), ()),)))
    ground = made(surface, lambda x, y: np.where(y > -100.0, land, 17.0), water)
    terrain = corners_of(ground, "Terrain", detail).reshape(-1, 3)
    (ax, ay), (bx, by) = corners[3], corners[2]
    off = terrain[:, 1] - (ay + (terrain[:, 0] - ax) * (by - ay) / (bx - ax))
    at_shore = terrain[(np.abs(off) < 1e-3) & (np.abs(terrain[:, 0] - 100.0) < 80.0)]
    assert len(at_shore) > 20
    assert at_shore[:, 2] == pytest.approx(shore, abs=1e-9)
    assert np.unique(corners_of(ground, "Water", detail)[..., 2]) == pytest.approx(17.0)
    # Of the ground below the lake nothing is seen, and piers go down to the water.
    assert ground.heights(np.array([100.0]), np.array([-60.0])) == pytest.approx(17.0)


def test_shores_of_water_that_the_model_does_not_know_have_no_teeth() -> None:
    surface = strips(straight(LONG))
    coast = places((400.0, -41.0), (-200.0, -49.0))
    water = shapes(Water(coastlines=(coast[::-1].copy(),)))
    north = made(surface, lambda x, y: np.where(y > -52.0, 30.0, np.where(y > -90.0, np.nan, 17.0)), water)
    terrain = corners_of(north, "Terrain").reshape(-1, 3)
    beside = terrain[(np.abs(terrain[:, 1] + 45.0) < 4.0) & (np.abs(terrain[:, 0] - 100.0) < 80.0)]
    assert len(beside) > 20
    # What the road, 20 m high, cuts goes up by 1:2 from 4 m beside its middle line.
    assert beside[:, 2].min() > 30.0 - 1e-9


def test_the_sea_goes_on_where_the_ground_ends_and_has_whole_moles() -> None:
    surface = strips(straight(LONG))
    # A mole of 240 m, a pond that is joined to nothing.
    coast = places((-900.0, -50.0), (90.0, -50.0), (90.0, -290.0), (98.0, -290.0), (98.0, -50.0), (1200.0, -50.0))
    pond = WaterArea("way/1", rectangle(100.0, 300.0, 140.0, 340.0), ())
    water = shapes(Water((pond,), coastlines=(coast,)))
    ground = made(surface, lambda x, y: np.where(y > -60.0, 18.0, 17.0), water)
    for detail in range(3):
        sea, land = corners_of(ground, "Water", detail), corners_of(ground, "Terrain", detail)
        # 500 m from the road, whose edge is at y = -4 m; the pond is farther than 100 m from it.
        assert sea[..., 1].min() == pytest.approx(-504.0, abs=0.5)
        assert sea[..., 1].max() == pytest.approx(-50.0)
        mole = land[land[..., 1].mean(1) < -60.0]
        assert areas(mole)[1].sum() == pytest.approx(8.0 * 230.0, rel=0.02)
        assert mole[..., 1].min() == pytest.approx(-290.0)


def test_rivers_that_fall_are_whole_from_bank_to_bank() -> None:
    surface = strips(straight(LONG))
    river = shapes(Water((WaterArea("way/1", rectangle(-600.0, -300.0, 800.0, -80.0), ()),)))
    ground = made(surface, lambda x, y: 17.0 + 0.01 * x, river)
    for detail in range(3):
        wet = corners_of(ground, "Water", detail)
        at = wet[(wet[..., 0] > 0.0).all(1) & (wet[..., 0] < 200.0).all(1)].reshape(-1, 3)
        assert (at[:, 1].min(), at[:, 1].max()) == pytest.approx((-300.0, -80.0), abs=0.05)
        assert wet[..., 2] == pytest.approx(17.0 + 0.01 * wet[..., 0], abs=1e-6)
        # 20 m are the largest squares, and there is no ground on the other side.
        assert areas(wet)[1].max() == pytest.approx(200.0)
        assert corners_of(ground, "Terrain", detail)[..., 1].min() > -110.0


def test_without_water_the_ground_is_the_same() -> None:
    surface = strips(straight(LONG))
    one, other = (made(surface, lambda x, y: np.full(len(x), 17.0), found) for found in (None, shapes(Water())))
    assert [part.name for part in one.parts] == [part.name for part in other.parts]
    for a, b in zip(one.parts, other.parts, strict=True):
        np.testing.assert_array_equal(a.vertices[a.faces], b.vertices[b.faces])

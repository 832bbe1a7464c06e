"""Buildings as blocks: their heights, roofs, and what roads leave of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from ground_cases import areas, edges_of, straight, strips

from osm2xodr.exporting.scene.buildings import Buildings, building_parts
from osm2xodr.exporting.scene.ground import build_ground
from osm2xodr.exporting.scene.model import Level, Part, RoadSurface
from osm2xodr.exporting.scene.roads import rim_of
from osm2xodr.model import BoolArray, Building, FloatArray
from osm2xodr.opendrive import Frame, Header, frame_of

ROOFS = ("roof", "roof_flat")
ROAD = straight([(float(x), 20.0) for x in range(-60, 61, 20)])


def frame() -> Frame:
    found, why = frame_of(Header((1, 7), {}, "+proj=tmerc +lat_0=47 +lon_0=11 +datum=WGS84", None))
    assert found is not None, why
    return found


def places(corners: Sequence[tuple[float, float]]) -> FloatArray:
    x, y = np.array(corners, float).T
    return np.column_stack(frame().to_geographic(x, y))


def box(west: float, south: float, east: float, north: float, **tags: Any) -> Building:
    outline = places([(west, south), (east, south), (east, north), (west, north)])
    known: dict[str, Any] = {"kind": "yes", "is_part": False}
    return Building("way/1", outline, (), **known | tags)


def built(
    *buildings: Building, surface: RoadSurface | None = None, passage: BoolArray | None = None, slope: float = 0.0
) -> Buildings:
    surface = surface or strips(ROAD)
    passage = np.zeros(len(surface.faces), np.bool_) if passage is None else passage
    surface = replace(surface, level=np.where(passage, int(Level.GROUND), surface.level))
    ground = build_ground(surface, rim_of(surface), lambda x, y: 20.0 + slope * x, 500.0)
    return building_parts(buildings, frame(), surface, passage, ground)


def corners(found: Buildings, *materials: str) -> FloatArray:
    """Return the triangles of some materials; those of all roofs are ``roof`` and ``roof_flat``."""
    parts = [part for part in found.parts if part.material in materials]
    assert [part.name for part in parts] == ["Building"] * len(materials)
    return np.concatenate([part.vertices[part.faces] for part in parts])


def volume(found: Buildings, floor: float) -> float:
    """Return what lies between the roof and a height, m³, as walls close it."""
    roof = corners(found, *ROOFS)
    _, plan = areas(roof)
    assert (plan > 0).all(), "roofs look up"
    return float((plan * (roof[:, :, 2].mean(1) - floor)).sum())


def assert_closed(found: Buildings) -> None:
    """Every upper edge of a wall is one of a roof, the other way round."""
    roof, walls = (edges_of(corners(found, *names).round(6)) for names in (ROOFS, ("wall",)))
    free = [edge for edge in roof if edge[::-1] not in roof]
    assert free
    assert [edge for edge in free if edge[::-1] not in walls] == []


@pytest.mark.parametrize(
    ("tags", "eaves", "ridge", "content"),
    [
        ({"height": 9.0}, 29.0, 29.0, 20 * 10 * 9.0),
        ({"levels": 3.0}, 29.0, 29.0, 20 * 10 * 9.0),
        ({"height": 9.0, "roof_shape": "gabled", "roof_height": 4.0}, 25.0, 29.0, 20 * 10 * 7.0),
        # Two storeys and a roof of 30 degrees.
        ({"levels": 2.0, "roof_shape": "gabled"}, 26.0, 26 + 0.577 * 5, 20 * 10 * (6 + 0.577 * 5 / 2)),
        # Less two pyramids' halves at the ends: a ridge of 10 m.
        (
            {"height": 9.0, "roof_shape": "hipped", "roof_height": 4.0},
            25.0,
            29.0,
            20 * 10 * 5 + 10 * 10 * 2 + 100 * 4 / 3,
        ),
        ({"height": 9.0, "roof_shape": "pyramidal", "roof_height": 3.0}, 26.0, 29.0, 20 * 10 * 6 + 20 * 10 * 3 / 3),
        ({"height": 9.0, "roof_shape": "gabled", "roof_height": 4.0, "ridge_across": True}, 25.0, 29.0, 200 * 7.0),
    ],
)
def test_heights_and_roofs(tags: dict[str, Any], eaves: float, ridge: float, content: float) -> None:
    found = built(box(0.0, 20.0, 20.0, 30.0, **tags))
    roof = corners(found, *ROOFS)[:, :, 2]
    assert roof.max() == pytest.approx(ridge)
    assert roof.min() == pytest.approx(eaves)
    assert volume(found, 20.0) == pytest.approx(content, rel=1e-6)
    walls = corners(found, "wall")
    # Half a metre in the ground.
    assert walls[:, :, 2].min() == 19.5
    assert_closed(found)
    assert found.ids == {"drawn": ("way/1",)}


def test_guesses_are_counted_and_not_buried() -> None:
    found = built(box(20.0, 20.0, 40.0, 30.0, kind="apartments"), slope=0.0)
    assert found.ids == {"drawn": ("way/1",), "guessed": ("way/1",)}
    assert corners(found, *ROOFS)[:, :, 2].max() == pytest.approx(20 + 4 * 3.0)
    road = strips(straight([(float(x), 20.0 + 0.5 * x) for x in range(-60, 61, 20)]))
    steep = built(box(20.0, 40.0, 40.0, 50.0, kind="garage"), surface=road, slope=0.5)
    # From 30 to 40 m: one storey above the upper side.
    assert corners(steep, *ROOFS)[:, :, 2].max() == pytest.approx(43.0)
    assert corners(steep, "wall")[:, :, 2].min() == pytest.approx(29.5)


def test_walls_look_outwards() -> None:
    found = built(box(0.0, 20.0, 20.0, 30.0, height=5.0))
    walls = corners(found, "wall")
    normal = np.cross(walls[:, 1] - walls[:, 0], walls[:, 2] - walls[:, 0])
    away = walls.mean(1) - (10.0, 25.0, 22.0)
    assert ((normal * away).sum(1) > 0).all()
    assert areas(walls)[0].sum() == pytest.approx(60 * 5.5)


def test_courtyards_stay_open() -> None:
    yard = places([(5.0, 23.0), (15.0, 23.0), (15.0, 27.0), (5.0, 27.0)])
    found = built(replace(box(0.0, 20.0, 20.0, 30.0, height=5.0), holes=(yard,)))
    assert areas(corners(found, *ROOFS))[1].sum() == pytest.approx(200 - 40)
    assert areas(corners(found, "wall"))[0].sum() == pytest.approx((60 + 28) * 5.5)
    assert_closed(found)


def test_roads_are_left_free() -> None:
    # The road reaches from -4 to 4.
    found = built(box(0.0, 1.0, 20.0, 11.0, height=5.0))
    roof = corners(found, *ROOFS)
    assert roof[:, :, 1].min() == pytest.approx(4.0)
    assert areas(roof)[1].sum() == pytest.approx(20 * 7)
    assert found.ids == {"clipped": ("way/1",), "drawn": ("way/1",)}
    gone = built(box(0.0, -5.0, 20.0, 5.0, height=5.0))
    assert gone.ids == {"on_roads": ("way/1",)}
    assert gone.parts == ()
    # Above a bridge's deck nothing is in the way, nor above a tunnel.
    for level in (Level.BRIDGE, Level.TUNNEL):
        over = strips(
            straight([(-60.0, 20.0), (-20.0, 20.0), (40.0, 20.0), (60.0, 20.0)], [Level.GROUND, level, Level.GROUND])
        )
        assert built(box(0.0, 1.0, 20.0, 11.0, height=5.0), surface=over).ids == {"drawn": ("way/1",)}


def test_buildings_go_on_above_passages() -> None:
    levels = [Level.GROUND, Level.TUNNEL, Level.GROUND]
    surface = strips(straight([(-60.0, 20.0), (0.0, 20.0), (20.0, 20.0), (60.0, 20.0)], levels))
    found = built(box(5.0, -10.0, 15.0, 10.0, height=12.0), surface=surface, passage=surface.level == Level.TUNNEL)
    assert found.ids == {"drawn": ("way/1",)}
    assert areas(corners(found, *ROOFS))[1].sum() == pytest.approx(10 * 20)
    walls = corners(found, "wall")
    area, plan = areas(walls)
    # The ceiling hangs 4.5 m above the road and looks down.
    ceiling = walls[plan < -1e-6]
    assert areas(ceiling)[1].sum() == pytest.approx(-10 * 8)
    assert (ceiling[:, :, 2] == 24.5).all()
    assert area.min() > 1e-6
    low = walls[(walls[:, :, 2] < 24.0).any(1)]
    assert (np.abs(low[:, :, 1]) >= 4.0 - 1e-9).all()


def test_parts_stand_for_their_outline() -> None:
    outline = box(0.0, 20.0, 20.0, 30.0, height=5.0)
    tower = box(0.0, 20.0, 10.0, 30.0, height=30.0, is_part=True)
    rest = box(10.0, 20.0, 20.0, 30.0, height=8.0, is_part=True, min_height=3.0)
    found = built(outline, replace(tower, osm_id="way/2"), replace(rest, osm_id="way/3"))
    assert found.ids["drawn"] == ("way/2", "way/3")
    assert volume(found, 20.0) == pytest.approx(100 * 30 + 100 * 8)
    # One can stand below the third.
    walls = corners(found, "wall")
    assert areas(walls)[1].sum() == pytest.approx(-100)
    one = built(outline, replace(tower, osm_id="way/2"))
    assert one.ids["drawn"] == ("way/1", "way/2")
    assert volume(one, 20.0) == pytest.approx(100 * 30 + 100 * 5)


def test_nothing_stands_off_the_ground() -> None:
    found = built(box(400.0, 400.0, 420.0, 410.0, height=5.0))
    assert found.ids == {"off_ground": ("way/1",)}
    assert found.parts == ()


def test_outlines_that_cross_themselves_are_repaired() -> None:
    bow = replace(box(0.0, 20.0, 20.0, 30.0, height=5.0), outline=places([(0, 20), (20, 30), (20, 20), (0, 30)]))
    found = built(bow)
    assert found.ids == {"drawn": ("way/1",), "repaired": ("way/1",)}
    assert areas(corners(found, *ROOFS))[1].sum() == pytest.approx(100)


def test_there_may_be_no_buildings() -> None:
    found = built()
    assert (found.parts, found.ids) == ((), {})


def test_parts_are_of_known_types() -> None:
    found = built(box(0.0, 20.0, 20.0, 30.0, roof_shape="helix", height=5.0))
    assert found.ids == {"drawn": ("way/1",), "flat": ("way/1",)}
    assert all(isinstance(part, Part) and part.uv.shape == (len(part.vertices), 2) for part in found.parts)

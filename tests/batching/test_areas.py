"""Areas cut out of one map: tiles, and outlines from files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from osm2xodr.batching.areas import (
    _IDS_PER_AREA,
    _number,
    check_name,
    frame_around,
    make_tiles,
    outlined,
    parse_length,
    read_areas,
    read_partition,
    shared_frame,
)
from osm2xodr.batching.model import Area
from osm2xodr.curves.polygons import inside_outline
from osm2xodr.errors import InputError
from osm2xodr.model import Outline
from osm2xodr.projection import make_frame, to_local

COMMON = Area("", Path("map.osm.pbf"), (Path("dem.tif"),), ("--ways", "major"))
# Andorra.
BOUNDS = (1.41, 42.43, 1.79, 42.66)


@pytest.mark.parametrize(("text", "length"), [("5km", 5000.0), ("0.5 KM", 500.0), ("800m", 800.0)])
def test_lengths_are_read(text: str, length: float) -> None:
    assert parse_length(text) == length


@pytest.mark.parametrize("text", ["5", "", "5 miles", "-5km", "nan km", "100m"])
def test_what_is_no_length_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"give one such as 5km or 800m|are too small; give at least 200m"):
        parse_length(text)


def test_tiles_cover_the_bounds_once() -> None:
    tiles = make_tiles(BOUNDS, 5000.0, COMMON)
    frame = tiles[0].frame
    assert frame == make_frame(42.5, 1.6)
    dice = np.random.default_rng(1)
    lon, lat = dice.uniform(BOUNDS[0], BOUNDS[2], 2000), dice.uniform(BOUNDS[1], BOUNDS[3], 2000)
    x, y = to_local(frame, lon, lat)
    covers = np.zeros(2000, np.int64)
    for tile in tiles:
        assert tile.frame == frame
        assert tile.outline is not None
        covers += inside_outline(tile.outline, x, y)
    assert (covers == 1).all()
    # 31.4 by 25.8 km.
    assert len(tiles) in range(7 * 6, 8 * 7 + 1)
    assert [tile.area.name for tile in tiles] == sorted(tile.area.name for tile in tiles)


def test_blocks_are_made_of_whole_tiles() -> None:
    tiles = make_tiles(BOUNDS, 5000.0, COMMON, in_blocks=True)
    inside: dict[str, float] = {}
    for tile in tiles:
        assert tile.block is not None
        assert tile.outline is not None
        (low, high), (west, south) = (tile.outline.rings[0][k] for k in (0, 2)), tile.block.outline.rings[0][0]
        east, north = tile.block.outline.rings[0][2]
        assert west <= low[0] < high[0] <= east
        assert south <= low[1] < high[1] <= north
        inside[tile.block.name] = inside.get(tile.block.name, 0.0) + 5000.0**2
        assert east - west <= 20_000.0
        # They stay where they are when the map grows.
        column, row = int(tile.area.name[1:4]), int(tile.area.name[6:9])
        assert tile.block.name == f"block_x{column // 4 * 4:03d}_y{row // 4 * 4:03d}"
    size = {
        tile.block.name: float(np.prod(np.ptp(tile.block.outline.rings[0], axis=0))) for tile in tiles if tile.block
    }
    assert inside == size


def test_a_tile_is_a_square_at_its_place_in_the_grid() -> None:
    tile = next(tile for tile in make_tiles(BOUNDS, 5000.0, COMMON) if tile.area.name == "x498_y501")
    assert isinstance(tile.outline, Outline)
    (ring,) = tile.outline.rings
    assert ring.tolist() == [[-10e3, 5e3], [-5e3, 5e3], [-5e3, 10e3], [-10e3, 10e3]]
    assert tile.frame is not None
    (corners,) = tile.area.outline_deg
    lon, lat = np.array(corners).T
    np.testing.assert_allclose(np.column_stack(to_local(tile.frame, lon, lat)), ring, atol=0.02)
    assert (tile.area.osm, tile.area.dems, tile.area.options) == (COMMON.osm, COMMON.dems, COMMON.options)


def test_tiles_stay_where_they_are_when_the_map_grows_a_little() -> None:
    before = {tile.area.name: tile for tile in make_tiles(BOUNDS, 5000.0, COMMON)}
    west, south, east, north = BOUNDS
    after = {tile.area.name: tile for tile in make_tiles((west - 0.08, south, east + 0.06, north), 5000.0, COMMON)}
    common = before.keys() & after.keys()
    assert common == before.keys()
    assert len(after) > len(before)
    for name in common:
        assert before[name].number == after[name].number
        assert before[name].area == after[name].area


def test_cells_of_the_grid_are_numbered_without_gaps() -> None:
    # Those of a square around the middle, whatever lies farther out.
    assert sorted(_number(c, r) for c in range(-9, 9) for r in range(-9, 9)) == list(range(18 * 18))
    assert _number(0, 0) == 0


@pytest.mark.parametrize(
    ("bounds", "side", "words"),
    [
        ((-60.0, -30.0, -40.0, -10.0), 1000.0, "is too large for tiles of 1000 m: there would be"),
        ((0.0, 0.0, 6.0, 0.1), 200.0, "is too large for tiles of 200 m"),
        ((-170.0, -60.0, 170.0, 60.0), 1e5, "reaches too far round the world for tiles; cut out a country first"),
    ],
)
def test_maps_that_are_too_large_for_tiles(
    bounds: tuple[float, float, float, float], side: float, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        make_tiles(bounds, side, COMMON)


def feature(name: object, kind: str, coordinates: object, key: str = "name") -> dict[str, object]:
    geometry = {"type": kind, "coordinates": coordinates}
    properties = None if name is None else {key: name}
    return {"type": "Feature", "properties": properties, "geometry": geometry}


SQUARE = [[1.0, 42.0], [1.1, 42.0], [1.1, 42.1], [1.0, 42.1], [1.0, 42.0]]
HOLE = [[1.04, 42.04], [1.06, 42.04], [1.05, 42.06], [1.04, 42.04]]
OTHER = [[1.2, 42.0, 7.0], [1.3, 42.0, 7.0], [1.2, 42.1, 7.0]]


def collection(*features: object) -> str:
    return json.dumps({"type": "FeatureCollection", "features": features})


def test_areas_from_geojson(tmp_path: Path) -> None:
    path = tmp_path / "areas.geojson"
    path.write_text(
        collection(
            feature("Sant Julià", "MultiPolygon", [[SQUARE, HOLE], [OTHER]]),
            feature(17, "Polygon", [SQUARE], "id"),
            feature(None, "Polygon", [OTHER]),
        ),
        encoding="utf-8",
    )
    areas = read_areas(path, COMMON)
    assert [item.area.name for item in areas] == ["Sant Julià", "17", "area_3"]
    assert [item.number for item in areas] == [0, 1, 2]
    assert [len(item.area.outline_deg) for item in areas] == [3, 1, 1]
    assert areas[0].area.outline_deg[2] == ((1.2, 42.0), (1.3, 42.0), (1.2, 42.1))
    assert {item.frame for item in areas} == {make_frame(42.05, 1.15)}
    frame = areas[0].frame
    assert frame is not None
    x, y = to_local(frame, [1.02, 1.05, 1.22], [42.05, 42.05, 42.02])
    assert areas[0].outline is not None
    assert inside_outline(areas[0].outline, x, y).tolist() == [True, False, True]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "is not GeoJSON"),
        ("[1]", "holds no GeoJSON features"),
        (collection(), "holds no GeoJSON features"),
        (collection(feature("a", "Point", [1, 2])), "feature 1: it is not a Polygon or MultiPolygon, but Point"),
        (collection(3), "feature 1: it is not a Polygon or MultiPolygon, but None"),
        (collection(feature("a", "Polygon", [])), "feature 1: it has no corners"),
        (collection(feature("a", "Polygon", [3])), "feature 1: a ring needs three corners or more"),
        (collection(feature("a", "MultiPolygon", [3])), "feature 1: a ring needs three corners or more"),
        (collection(feature("a", "Polygon", [[[1, 2], ["x", 2], [3, 4]]])), r"feature 1: \['x', 2\] is not a corner"),
        (collection(feature("a", "Polygon", [[[1, 2], [200, 2], [3, 4]]])), "feature 1: 200, 2 is not a place"),
        (collection(feature("a", "Polygon", [[[-170, 2], [170, 2], [3, 4]]])), "reaches round half of the world"),
        (collection(*[feature("a", "Polygon", [SQUARE])] * 2), "two areas are called 'a'"),
        (collection(feature("a/b", "Polygon", [SQUARE])), "'a/b' cannot be the name of an area"),
    ],
)
def test_geojson_that_holds_no_areas(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "areas.geojson"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words) as caught:
        read_areas(path, COMMON)
    assert str(path) in str(caught.value)


def test_an_area_by_itself_has_a_frame_of_its_own() -> None:
    corners = ((7.0, 50.0), (7.2, 50.0), (7.2, 50.1), (7.0, 50.1))
    planned = outlined(Area("a", Path("m.osm"), outline_deg=(corners,)))
    assert planned.frame == frame_around([corners]) == make_frame(50.05, 7.1)
    assert planned.outline is not None
    np.testing.assert_allclose(np.abs(planned.outline.rings[0]), [[7162.0, 5561.0]] * 4, rtol=2e-3)
    assert outlined(Area("b", Path("m.osm"))).outline is None


def test_the_frame_that_areas_share_is_what_conversions_read(tmp_path: Path) -> None:
    tiles = make_tiles(BOUNDS, 5000.0, COMMON)
    path = tmp_path / "frame.json"
    path.write_text(json.dumps(shared_frame(tiles[::-1])), encoding="utf-8")
    partition = read_partition(path, "x500_y500")
    assert partition.names == tuple(tile.area.name for tile in tiles)
    assert partition.names[partition.own] == "x500_y500"
    assert partition.first_ids[partition.own] == 1
    assert len(set(partition.first_ids)) == len(tiles)
    assert all((first - 1) % _IDS_PER_AREA == 0 for first in partition.first_ids)
    assert partition.frame == tiles[0].frame
    for tile, outline in zip(tiles, partition.outlines, strict=True):
        assert tile.outline is not None
        assert [ring.tolist() for ring in outline.rings] == [ring.tolist() for ring in tile.outline.rings]


def test_ids_run_out() -> None:
    area = Area("far", Path("m.osm"), outline_deg=(((7.0, 50.0), (7.2, 50.0), (7.2, 50.1)),))
    last = (2**31 - 1) // _IDS_PER_AREA - 1
    assert shared_frame([outlined(area, number=last)])["areas"][0]["first_id"] < 2**31
    with pytest.raises(InputError, match="there are too many areas for --shared-frame to give ids"):
        shared_frame([outlined(area, number=last + 1)])


def test_names_of_areas_are_names_of_files() -> None:
    for name in ("a", "Sant Julià de Lòria", "x500_y499", "1.5", "東京", "a" * 120):
        assert check_name(name) == ""
    for name in (
        "",
        "a" * 121,
        "..",
        ".a",
        "-a",
        "a.",
        " a",
        "a/b",
        "a\\b",
        "a\nb",
        "a\0",
        "summary",
        "INDEX",
        "frame",
    ):
        assert check_name(name) != ""

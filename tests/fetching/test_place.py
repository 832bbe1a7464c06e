"""Areas to fetch."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from osm2xodr.errors import InputError
from osm2xodr.fetching import place_of_box, place_of_file
from osm2xodr.fetching.elevation import with_margin


def write(path: Path, *geometries: dict[str, Any]) -> Path:
    """Write a GeoJSON file."""
    features = [{"type": "Feature", "properties": {}, "geometry": item} for item in geometries]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


def test_a_box() -> None:
    place = place_of_box(" -1.5, -42.5,1.25 ,42")
    assert place.box == (-1.5, -42.5, 1.25, 42.0)
    assert place.text == "bbox -1.5,-42.5,1.25,42"
    request = place.cut_request(Path("x"))
    assert len(request.outline.rings) == 1
    assert not request.context


def test_all_polygons_of_a_file_are_one_area(tmp_path: Path) -> None:
    ring = [[1.0, 42.0], [1.1, 42.0], [1.1, 42.2], [1.0, 42.0]]
    other = [[[3.0, 41.0], [3.1, 41.0], [3.1, 41.1], [3.0, 41.0]]]
    path = write(
        tmp_path / "a.geojson",
        {"type": "Polygon", "coordinates": [ring]},
        {"type": "MultiPolygon", "coordinates": [other]},
    )
    place = place_of_file(path)
    assert place.box == (1.0, 41.0, 3.1, 42.2)
    assert len(place.rings) == 2
    assert place.text == "the polygons of a.geojson"


def test_files_that_are_no_areas(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read: no such file or directory; check the path"):
        place_of_file(tmp_path / "none.geojson")
    point = write(tmp_path / "b.geojson", {"type": "Point", "coordinates": [1.0, 42.0]})
    with pytest.raises(InputError, match="it is not a Polygon or MultiPolygon, but Point; give areas as polygons"):
        place_of_file(point)


def test_the_margin_is_in_metres() -> None:
    west, south, east, north = with_margin((10.0, 60.0, 10.1, 60.1))
    assert (60.0 - south) * 111_195.0 == pytest.approx(150.0)
    assert north - 60.1 == pytest.approx(60.0 - south)
    # A degree of longitude is half as long there.
    assert 10.0 - west == pytest.approx(2.0 * (60.0 - south), rel=0.01)
    assert east - 10.1 == pytest.approx(10.0 - west)
    assert with_margin((-180.0, -89.9999, 180.0, 89.9999)) == (-180.0, -90.0, 180.0, 90.0)

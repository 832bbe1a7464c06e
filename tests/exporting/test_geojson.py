"""GeoJSON, read back."""

from __future__ import annotations

import io
import json
import math
from collections import Counter
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt
from exported_network import network
from pyproj import Transformer
from xodr_text import PROJECTION

from osm2xodr.exporting.geojson import LAYERS, write_geojson
from osm2xodr.opendrive.tables import OpenDrive


def features(file: OpenDrive, *layers: str) -> list[dict[str, Any]]:
    stream = io.BytesIO()
    write_geojson(file, stream, 0.05, 10.0, layers or LAYERS)
    parsed = json.loads(stream.getvalue())
    assert parsed["type"] == "FeatureCollection"
    found: list[dict[str, Any]] = parsed["features"]
    return found


def local(coordinates: list[list[float]]) -> npt.NDArray[np.float64]:
    """Return x, y, z of coordinates by pyproj."""
    lon, lat, height = np.array(coordinates).T
    # Lists, for pyproj takes an array of one element for a number.
    x, y = Transformer.from_crs("EPSG:4326", PROJECTION, always_xy=True).transform(lon.tolist(), lat.tolist())
    return np.column_stack([x, y, height])


def test_all_layers_are_there(tmp_path: Path) -> None:
    found = Counter(item["properties"]["layer"] for item in features(network(tmp_path)))
    assert found == {"roads": 2, "lanes": 8, "junctions": 1, "signals": 1, "objects": 2}
    assert {item["properties"]["layer"] for item in features(network(tmp_path), "signals")} == {"signals"}


def test_lanes_are_rings_where_they_are(tmp_path: Path) -> None:
    lanes = features(network(tmp_path), "lanes")
    first = lanes[0]
    assert first["properties"]["road"] == "1"
    assert first["properties"]["lane"] == 1
    assert first["properties"]["width"] == 3.0
    (ring,) = first["geometry"]["coordinates"]
    assert ring[0] == ring[-1]
    points = local(ring)
    # 1e-8 degrees are 1.1 mm.
    np.testing.assert_allclose(points[0], [0, 0, 100], atol=2e-3)
    np.testing.assert_allclose(points[:, 2], 100 + 0.02 * points[:, 0], atol=2e-3)
    assert set(np.round(points[:, 1]).tolist()) == {0, 3}
    for item in lanes:
        x, y, _ = local(item["geometry"]["coordinates"][0][:-1]).T
        assert np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) > 0, "rings run counter-clockwise"


def test_reference_lines_and_junctions(tmp_path: Path) -> None:
    roads = features(network(tmp_path), "roads", "junctions")
    points = local(roads[0]["geometry"]["coordinates"])
    end = (50 + 50 * math.sin(1), 50 * (1 - math.cos(1)), 102)
    np.testing.assert_allclose(points[-1], end, atol=2e-3)
    assert roads[1]["properties"]["junction"] == "9"
    junction = roads[2]
    assert junction["properties"] == {
        "layer": "junctions",
        "junction": "9",
        "name": "J",
        "type": "",
        "connections": 1,
    }
    corners = local(junction["geometry"]["coordinates"][0])
    np.testing.assert_allclose([corners[:, 0].min(), corners[:, 0].max()], [200, 220], atol=2e-3)
    np.testing.assert_allclose([corners[:, 1].min(), corners[:, 1].max()], [-3.5, 3.5], atol=2e-3)


def test_signals_and_objects(tmp_path: Path) -> None:
    signal, tree, crossing = features(network(tmp_path), "signals", "objects")
    np.testing.assert_allclose(local([signal["geometry"]["coordinates"]])[0], [30, -6, 103.6], atol=2e-3)
    assert signal["properties"]["type"] == "274"
    assert signal["properties"]["kind"] == "signal"
    assert (signal["properties"]["s"], signal["properties"]["t"]) == (30.0, -6.0)
    assert isinstance(signal["properties"]["zOffset"], float)
    np.testing.assert_allclose(local([tree["geometry"]["coordinates"]])[0], [20, 6, 100.9], atol=2e-3)
    corners = local(crossing["geometry"]["coordinates"][0][:-1])
    assert sorted(np.round(corners[:, :2]).tolist()) == [[9, -3], [9, 3], [11, -3], [11, 3]]


def test_roads_and_lanes_name_their_ways(tmp_path: Path) -> None:
    file = network(tmp_path)
    code = "osm_way_ids"
    named = replace(file, provenance=MappingProxyType({(0, code): "12 -3 x"}))
    assert features(named, "roads")[0]["properties"][code] == [12, -3]
    assert {tuple(item["properties"][code]) for item in features(named, "lanes")} <= {(12, -3), ()}
    assert features(file, "roads")[0]["properties"][code] == []

"""Tables with geometry and GeoPackages: what stands in the file, with units, at its place."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import geopandas
import numpy as np
import pytest
from exported_network import network
from xodr_text import PROJECTION

import osm2xodr
from osm2xodr.opendrive.tables import OpenDrive


@pytest.fixture
def file(tmp_path: Path) -> OpenDrive:
    return replace(network(tmp_path), provenance=MappingProxyType({(0, "osm_way_ids"): "12 -3"}))


def test_lanes(file: OpenDrive) -> None:
    frame = osm2xodr.RoadNetwork(file).to_geodataframe()
    assert frame.crs == PROJECTION
    assert len(frame) == 8
    first = frame.iloc[0]
    assert (first.road_id, first.lane_id, first.lane_type, first.direction) == ("1", 1, "driving", "backward")
    assert (first.s_start_m, first.s_end_m, first.t_m, first.width_m) == (0.0, 50.0, 1.5, 3.0)
    assert first.length_m == pytest.approx(50.0)
    assert first.osm_ways == (12, -3)
    assert first.geometry.area == pytest.approx(150.0)
    assert {round(z, 6) for *_, z in first.geometry.exterior.coords if z < 100.5} == {100.0, 100.2, 100.4}
    # A lane on the outside of an arc of 50 m to the left is longer than the reference line.
    bent = frame[(frame.road_id == "1") & (frame.s_start_m == 50.0) & (frame.lane_id == -1)].iloc[0]
    assert bent.length_m == pytest.approx(51.5, abs=0.02)
    assert set(frame[frame.road_id == "2"].junction_id) == {"9"}
    assert frame.geometry.is_valid.all()


def test_roads_and_signals(file: OpenDrive) -> None:
    whole = osm2xodr.RoadNetwork(file)
    roads = whole.to_geodataframe("roads")
    assert roads.road_id.tolist() == ["1", "2"]
    assert roads.length_m.tolist() == [100.0, 20.0]
    assert roads.geometry.length.tolist() == pytest.approx([100.0, 20.0], abs=0.1)
    assert roads.rule.tolist() == ["RHT", "RHT"]
    assert math.isnan(roads.speed_kmh[0])
    (signal,) = whole.to_geodataframe("signals").itertuples()
    assert (signal.signal_id, signal.signal_type, signal.value, signal.s_m, signal.t_m) == (
        "x",
        "274",
        50.0,
        30.0,
        -6.0,
    )
    assert signal.geometry.coords[0] == pytest.approx((30.0, -6.0, 103.6))
    with pytest.raises(osm2xodr.OptionError, match="layer: 'poles' is unknown; choose from lanes, roads, signals"):
        whole.to_geodataframe("poles")  # type: ignore[arg-type]


def test_a_file_that_does_not_say_where_it_is(file: OpenDrive) -> None:
    lost = replace(file, header=replace(file.header, geo_reference=None))
    frame = osm2xodr.RoadNetwork(lost).to_geodataframe()
    assert frame.crs is None
    assert frame.total_bounds[0] == 0.0


def test_the_offset_of_the_header_counts(file: OpenDrive) -> None:
    moved = replace(file, header=replace(file.header, offset=(1000.0, 200.0, 7.0, math.pi / 2)))
    line = osm2xodr.RoadNetwork(moved).to_geodataframe("roads").geometry[1]
    np.testing.assert_allclose(line.coords[0], (1000.0, 400.0, 7.0), atol=1e-9)


def test_a_network_without_anything(tmp_path: Path, file: OpenDrive) -> None:
    bare = osm2xodr.RoadNetwork(replace(file, furniture=()))
    assert len(bare.to_geodataframe("signals")) == 0
    assert geopandas.read_file(bare.to_geopackage(tmp_path / "a.gpkg"), layer="signals").empty


def test_a_geopackage_has_all_layers_and_the_same_bytes(tmp_path: Path, file: OpenDrive) -> None:
    whole = osm2xodr.RoadNetwork(file)
    one, other = whole.to_geopackage(tmp_path / "one.gpkg"), tmp_path / "other.gpkg"
    assert osm2xodr.export(whole, other) == (other,)
    assert one.read_bytes() == other.read_bytes()
    for layer in ("lanes", "roads", "signals"):
        read, made = geopandas.read_file(one, layer=layer), whole.to_geodataframe(layer)
        assert list(read.columns) == list(made.columns)
        assert read.crs == made.crs
        assert read.geometry.geom_equals_exact(made.geometry, 1e-9).all()
    lanes = geopandas.read_file(one, layer="lanes")
    assert lanes.osm_ways[0] == "12 -3"
    assert lanes.width_m[0] == 3.0

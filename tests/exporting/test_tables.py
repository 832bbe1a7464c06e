"""Tables with geometry and GeoPackages: what stands in the file, with units, at its place.

The graph of lanes: where cars go from lane to lane, and how far.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import geopandas
import networkx
import numpy as np
import pytest
from exported_network import network
from t_junction import ARC, sound_map
from xodr_text import PROJECTION, document, lane, read_text, road, section

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


def test_ways_through_a_junction(tmp_path: Path) -> None:
    path = tmp_path / "t.xodr"
    path.write_text(sound_map(), encoding="utf-8")
    graph = osm2xodr.read(path).to_networkx()
    # Two ways along each of roads 1 to 4, 2 with two sections, and six through the junction.
    assert len(graph) == 2 * 5 + 6
    assert set(graph.successors(("1", 0, -1))) == {("10", 0, -1), ("12", 0, -1)}
    assert set(graph.predecessors(("1", 0, 1))) == {("11", 0, -1), ("14", 0, -1)}
    assert list(graph.successors(("2", 0, -1))) == [("2", 1, -1)]
    assert list(graph.successors(("4", 0, 1))) == [("2", 1, 1)]
    route = networkx.shortest_path(graph, ("1", 0, -1), ("4", 0, -1), weight="length_m")
    assert route == [("1", 0, -1), ("10", 0, -1), ("2", 0, -1), ("2", 1, -1), ("4", 0, -1)]
    length = networkx.path_weight(graph, route, "length_m")
    assert length == pytest.approx(50.0 + 20.0 + 50.0)
    assert networkx.path_weight(graph, route, "time_s") == pytest.approx(length / (50.0 / 3.6))
    # The lane right of the reference line, to the right: 1.75 m nearer to the centre of a circle of 10 m.
    assert graph.nodes["12", 0, -1]["length_m"] == pytest.approx(ARC * 8.25 / 10.0, abs=0.05)
    assert graph.nodes["1", 0, -1] == {
        "road": "1", "road_name": "", "section": 0, "lane": -1, "lane_type": "driving", "direction": "forward",
        "s_start_m": 0.0, "s_end_m": 50.0, "length_m": pytest.approx(50.0), "speed_kmh": pytest.approx(50.0),
    }  # fmt: skip


def mark(kind: str, change: str = "") -> str:
    return f'<roadMark sOffset="0" type="{kind}"' + (f' laneChange="{change}"/>' if change else "/>")


@pytest.mark.parametrize(
    ("inner", "changes"),
    [
        (mark("broken"), {(-1, -2), (-2, -1)}),
        (mark("solid"), set()),
        (mark("solid", "both"), {(-1, -2), (-2, -1)}),
        (mark("broken", "increase"), {(-2, -1)}),
        (mark("broken", "decrease"), {(-1, -2)}),
        # For some of its length.
        (mark("solid") + mark("broken").replace('"0"', '"40"'), {(-1, -2), (-2, -1)}),
    ],
)
def test_lanes_are_changed_where_marks_let_one(inner: str, changes: set[tuple[int, int]], tmp_path: Path) -> None:
    right = lane(-1, (0, 3.0), more=inner) + lane(-2, (0, 3.0), more=mark("broken"))
    right += lane(-3, (0, 2.0), kind="biking")
    file = read_text(tmp_path, document(road("1", lanes=section(0.0, lane(1, (0, 3.0)), right))))
    graph = osm2xodr.RoadNetwork(file).to_networkx()
    # Never to lanes of the other way, nor to those that are for others.
    assert set(graph) == {("1", 0, 1), ("1", 0, -1), ("1", 0, -2)}
    found = {(one[2], other[2]): data for one, other, data in graph.edges(data=True)}
    assert found.keys() == changes
    for data in found.values():
        assert data == {"kind": "change", "length_m": 0.0, "time_s": 0.0}


def test_lanes_of_both_ways_stand_twice(tmp_path: Path) -> None:
    both = section(0.0, "", lane(-1, (0, 3.0), kind="bidirectional"))
    file = read_text(tmp_path, document(road("1", lanes=both)))
    graph = osm2xodr.RoadNetwork(file).to_networkx()
    assert set(graph) == {("1", 0, -1, "forward"), ("1", 0, -1, "backward")}
    assert math.isnan(graph.nodes["1", 0, -1, "forward"]["speed_kmh"])

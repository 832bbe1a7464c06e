"""Road networks as nouns: what they say is what stands in the file."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from exported_network import network as small_network
from small_area import write_area, write_dem
from t_junction import sound_map

import osm2xodr


@pytest.fixture(scope="module")
def network(tmp_path_factory: pytest.TempPathFactory) -> osm2xodr.RoadNetwork:
    path = tmp_path_factory.mktemp("nouns") / "t.xodr"
    path.write_text(sound_map(), encoding="utf-8")
    return osm2xodr.read(path)


def test_roads_are_a_sequence_and_a_mapping(network: osm2xodr.RoadNetwork) -> None:
    roads = network.roads
    assert len(roads) == 10
    assert [road.id for road in roads] == ["1", "2", "3", "4", "10", "11", "12", "13", "14", "15"]
    assert roads[0] == roads["1"] == roads[-10]
    assert roads[-1].id == "15"
    assert [road.id for road in roads[1:3]] == ["2", "3"]
    assert "15" in roads
    assert "16" not in roads
    assert roads["15"] in roads
    assert {key: road.length for key, road in dict(roads).items()} == {road.id: road.length for road in roads}
    assert [key for key, _ in roads.items()] == list(roads.keys())
    assert roads.get("16") is None
    assert roads.get("16", 7) == 7
    with pytest.raises(KeyError, match="there is no road '16'"):
        roads["16"]
    with pytest.raises(IndexError):
        roads[10]
    assert repr(roads) == "<10 roads>"
    assert isinstance(roads, Sequence)
    assert next(road.id for road in reversed(roads)) == "15"


def test_roads_lead_to_each_other(network: osm2xodr.RoadNetwork) -> None:
    road = network.roads["2"]
    assert road.predecessor == network.junctions["100"]
    assert road.successor == network.roads["4"]
    assert [(link.end, link.to, link.contact) for link in road.links] == [
        ("start", network.junctions["100"], None),
        ("end", network.roads["4"], "start"),
    ]
    assert road.junction is None
    assert network.roads["1"].predecessor is None
    through = network.roads["12"]
    assert through.junction == network.junctions[0]
    assert [link.to for link in through.links] == [network.roads["1"], network.roads["3"]]


def test_junctions(network: osm2xodr.RoadNetwork) -> None:
    (junction,) = network.junctions
    assert (junction.id, junction.type, repr(junction)) == ("100", "default", "<Junction '100', 6 connections>")
    assert [road.id for road in junction.roads] == ["10", "11", "12", "13", "14", "15"]
    first = junction.connections[0]
    assert (first.incoming, first.connecting) == (network.roads["1"], network.roads["10"])
    assert (first.contact, first.lanes) == ("start", ((-1, -1),))


def test_heights_and_places(network: osm2xodr.RoadNetwork) -> None:
    """Road 1 falls from 12 m to 10 m between -60 and -10."""
    road = network.roads["1"]
    assert road.length == 50.0
    assert road.height(25.0) == pytest.approx(11.0)
    assert road.grade(25.0) == pytest.approx(-0.08)
    assert road.point(25.0, 2.0) == pytest.approx((-35.0, 2.0, 11.0))
    s = np.array([[0.0, 25.0], [49.0, 50.0]])
    assert road.height(s).shape == (2, 2)
    x, y, z = road.point(s, -1.0)
    np.testing.assert_allclose(x, s - 60.0)
    np.testing.assert_allclose(y, -1.0)
    np.testing.assert_allclose(z, road.height(s))
    lon, lat = road.lonlat(50.0)
    # 10 m west of the origin.
    assert (lon, lat) == pytest.approx((11.0 - 10.0 / (111_320.0 * math.cos(math.radians(49.0))), 49.0), abs=1e-6)
    for wrong in (-0.1, 50.1, math.nan):
        with pytest.raises(osm2xodr.OptionError, match="is not on road 1, which is 50 m long"):
            road.height(wrong)


def test_lanes(network: osm2xodr.RoadNetwork) -> None:
    road = network.roads["2"]
    assert len(road.lanes()) == 4
    left, right = road.lanes(30.0)
    assert (left.id, left.direction, right.id, right.direction) == (1, "backward", -1, "forward")
    assert (right.start, right.end, right.type, right.road) == (25.0, 50.0, "driving", road)
    assert right.width(30.0) == 3.5
    assert right.t(30.0) == -1.75
    assert right.point(30.0, 0.25) == pytest.approx((40.0, -1.5, 10.0))
    assert right.speed == pytest.approx(50.0 / 3.6)
    assert repr(right) == "<Lane -1 of road '2' from 25.0 to 50.0 m: driving>"
    with pytest.raises(osm2xodr.OptionError, match="s: 20 is not on lane -1 of road 2, which is from 25 to 50 m"):
        right.width(20.0)


def test_signals(network: osm2xodr.RoadNetwork) -> None:
    signal = network.signals["900"]
    assert (signal.type, signal.country, signal.dynamic, signal.value) == ("1000001", "OpenDRIVE", True, -1.0)
    assert (signal.road, signal.s, signal.t) == (network.roads["1"], 45.0, -4.0)
    assert signal.point() == pytest.approx((-15.0, -4.0, network.roads["1"].height(45.0) + 3.0))
    assert network.roads["1"].signals == [signal]
    assert network.roads["2"].signals == []


def test_what_a_file_does_not_say_is_not_guessed(tmp_path: Path) -> None:
    road = osm2xodr.RoadNetwork(small_network(tmp_path)).roads["1"]
    assert (road.name, road.osm_ways, road.type, road.links) == ("", (), "", ())
    assert math.isnan(road.lanes(0.0)[0].speed)
    assert road.signals[0].value == 50.0


def test_a_conversion_has_the_nouns_of_its_file(tmp_path: Path) -> None:
    conversion = osm2xodr.convert(write_area(tmp_path), write_dem(tmp_path), name="a/b")
    assert isinstance(conversion, osm2xodr.RoadNetwork)
    written = osm2xodr.read(conversion.write(tmp_path / "out.xodr").path)
    assert [road.name for road in conversion.roads] == [road.name for road in written.roads]
    named = {road.name: road.osm_ways for road in conversion.roads if road.junction is None and road.name}
    assert named == {"Carrer Major": (10,)}
    longest = max(conversion.roads, key=lambda road: road.length)
    assert longest.height(5.0) == pytest.approx(written.roads[longest.id].height(5.0))
    # What takes files takes it in their place.
    assert osm2xodr.check(conversion).headline() == osm2xodr.check(written).headline().replace(
        str(written.tables.path), str(conversion.tables.path)
    )
    assert osm2xodr.export(conversion, tmp_path / "out.geojson")[0].stat().st_size > 1000
    assert osm2xodr.Locator(conversion).file is conversion.tables
    folder = conversion.tables.path.parent
    assert folder.is_dir()
    del conversion, longest
    assert not folder.exists()


def test_it_says_what_it_is(network: osm2xodr.RoadNetwork) -> None:
    assert repr(network) == "<RoadNetwork 'T': 4 roads of 0.2 km, 6 connecting roads, 1 junction, 1 signal>"
    assert "<caption>T</caption><tr><td>4 roads of 0.2 km</td></tr>" in network._repr_html_()


def test_a_locator_takes_a_path_and_numbers(network: osm2xodr.RoadNetwork) -> None:
    locator = osm2xodr.Locator(network.tables.path)
    (place,) = locator.describe(locator.at_inertial(-35.0, -1.0))
    assert (place["road"], place["lane"], place["s"]) == ("1", -1, 25.0)
    lon, lat = network.roads["1"].lonlat(25.0, -1.0)
    assert locator.describe(locator.at_geographic(lat, lon))[0]["s"] == pytest.approx(25.0, abs=1e-4)


@pytest.mark.parametrize(("library", "verb"), [("geopandas", "to_geodataframe"), ("networkx", "to_networkx")])
def test_libraries_that_are_missing_are_named(
    library: str, verb: str, network: osm2xodr.RoadNetwork, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in ("frames", "graphs"):
        monkeypatch.delitem(sys.modules, f"osm2xodr.exporting.{name}", raising=False)
    monkeypatch.setitem(sys.modules, library, None)
    words = rf"this needs {library}; install it: pip install 'osm2xodr\[geo\]'"
    with pytest.raises(osm2xodr.Osm2xodrError, match=words):
        getattr(network, verb)()
    if library == "geopandas":
        with pytest.raises(osm2xodr.Osm2xodrError, match=words):
            network.to_geopackage(tmp_path / "a.gpkg")
        assert not (tmp_path / "a.gpkg").exists()

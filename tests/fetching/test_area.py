"""What is written about an area, and what is refused before anything is done.

Maps as they are written: joined from parts, or cut out of extracts.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import osmium
import pytest
from map_service import ORDINO, OSM_BASE, SAMPLE, Overpass
from riverside import BOX as RIVERSIDE_BOX, RIVERSIDE, ROADS_ALONE, WITH_SURROUNDINGS
from web_server import PAGE, Reply, WebServer, part_of, web_server

from osm2xodr import convert
from osm2xodr.errors import InputError, OptionError, OutputError
from osm2xodr.fetching import (
    FetchOptions,
    Network,
    Place,
    ServerError,
    fetch_area,
    overpass,
    place_of_box,
    place_of_file,
)
from osm2xodr.fetching.area import FetchedMap, fetch_map, sources_text
from osm2xodr.fetching.connection import Connection
from osm2xodr.fetching.elevation import FetchedModel
from osm2xodr.fetching.models import read_models
from osm2xodr.osmParsing import read_surroundings

PLACE = place_of_box(",".join(map(str, ORDINO)))

API = "/api/interpreter"
BOX = place_of_box(",".join(map(str, ORDINO)))


def options(folder: Path, **how: Any) -> FetchOptions:
    given = {"extract": str(SAMPLE / "area.osm"), "dem": False, **how}
    return FetchOptions(folder / "out", folder / "cache", network=Network(retries=0), **given)


def test_a_map_alone(tmp_path: Path) -> None:
    area = fetch_area(PLACE, options(tmp_path))
    assert area.osm is not None
    assert area.dems == ()
    text = area.sources.read_text(encoding="utf-8")
    assert "date of the data not stated" in text
    assert "42.55000 to 42.56500 N,\n1.56000 to 1.59000 E" in text
    # Nothing is left of the work.
    assert sorted(path.name for path in (tmp_path / "cache").iterdir()) == ["lock"]


def test_the_same_bytes_each_time(tmp_path: Path) -> None:
    made = [fetch_area(PLACE, options(tmp_path / name)) for name in "ab"]
    assert made[0].osm is not None
    assert made[1].osm is not None
    assert made[0].osm.path.read_bytes() == made[1].osm.path.read_bytes()


def test_sources_name_every_model() -> None:
    for model in read_models(()).values():
        fetched = FetchedModel((Path("dem.tif"), Path("dem_2.tif")), model, ("https://a/1", "https://a/2"), 0, 0.0)
        text = sources_text(PLACE, None, [fetched])
        rows = [line for line in text.splitlines() if line.startswith("| `dem")]
        assert [row.split("`")[1] for row in rows] == ["dem.tif", "dem_2.tif"]
        for row in rows:
            assert row.count(" | ") == 3
            assert model.title in row
            assert row.endswith(f"| {model.licence} | {model.attribution} |")
        assert "- <https://a/2>" in text
        assert "OpenStreetMap" not in text


def test_signs_of_tables_do_not_break_them() -> None:
    model = replace(next(iter(read_models(()).values())), attribution="A | B")
    text = sources_text(PLACE, None, [FetchedModel((Path("dem.tif"),), model, (), 0, 0.0)])
    assert "| A \\| B |" in text


def test_outputs_are_checked_first(tmp_path: Path) -> None:
    fetch_area(PLACE, options(tmp_path))
    before = (tmp_path / "out" / "area.osm").read_bytes()
    with pytest.raises(OutputError, match=r"SOURCES.md exists; give another folder with -o, or --overwrite"):
        fetch_area(PLACE, options(tmp_path))
    fetch_area(PLACE, options(tmp_path, overwrite=True))
    assert (tmp_path / "out" / "area.osm").read_bytes() == before
    own = str(tmp_path / "out" / "area.osm")
    with pytest.raises(OptionError, match=r"extract .*area.osm would be replaced; choose another folder for output"):
        fetch_area(PLACE, options(tmp_path, overwrite=True, extract=own))
    assert (tmp_path / "out" / "area.osm").read_bytes() == before


def test_folders_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    for how in (
        {"out_dir": tmp_path / "file"},
        {"cache_dir": tmp_path / "file"},
        {"out_dir": tmp_path / "file" / "x"},
    ):
        given: dict[str, Any] = {"out_dir": tmp_path / "out", "cache_dir": tmp_path / "cache", **how}
        with pytest.raises(OutputError, match=r"where a folder should be|not a directory"):
            fetch_area(PLACE, FetchOptions(extract=str(SAMPLE / "area.osm"), dem=False, **given))


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"osm": False, "dem": False}, "no_osm and no_dem leave nothing to fetch; give one of them"),
        ({"osm": False, "dem": True}, "no_osm and extract exclude each other; give one of them"),
        (
            {"dem": True, "models": ("a", "b"), "model_url": "http://x"},
            "dem_url is for one elevation model; give one",
        ),
    ],
)
def test_options_that_contradict_each_other(tmp_path: Path, how: dict[str, Any], message: str) -> None:
    with pytest.raises(OptionError, match=message):
        options(tmp_path, **how)


@pytest.fixture
def server() -> Iterator[WebServer]:
    with web_server() as made:
        made.serve(API, Overpass())
        yield made


@pytest.fixture(scope="module")
def extract(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A map in pbf that says of when its data is."""
    path = tmp_path_factory.mktemp("extract") / "map.osm.pbf"
    header = osmium.io.Header()
    header.set("osmosis_replication_timestamp", OSM_BASE)
    with osmium.SimpleWriter(str(path), header=header) as writer:
        for item in osmium.FileProcessor(str(SAMPLE / "area.osm")):
            writer.add(item)
    return path.read_bytes()


def fetch(folder: Path, place: Place = BOX, target: str = "area.osm", **how: Any) -> FetchedMap:
    for name in ("cache", "work", "out"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    network = Network(retries=1, sleep=lambda _: None)
    options = FetchOptions(folder / "out", folder / "cache", network=network, **how)
    return fetch_map(Connection(network), place, options, folder / "out" / target, folder / "work")


def elements(path: Path) -> dict[tuple[str, str], ElementTree.Element]:
    """Return the elements of a file by kind and id, each there once, in their order."""
    found = [item for item in ElementTree.parse(path).getroot() if item.tag in ("node", "way", "relation")]
    keyed = {(item.tag, item.get("id", "")): item for item in found}
    assert len(keyed) == len(found)
    kinds = {"node": 0, "way": 1, "relation": 2}
    order = [(kinds[tag], int(number)) for tag, number in keyed]
    assert order == sorted(order)
    return keyed


def test_what_the_server_has_is_written(server: WebServer, tmp_path: Path) -> None:
    made = fetch(tmp_path, overpass=(server.url + API,))
    expected = Overpass().within(ORDINO)
    found = elements(made.path)
    assert set(found) == {(item.tag, item.get("id")) for item in expected}
    for item in expected:
        written = found[item.tag, item.get("id", "")]
        for tag, keys in (("tag", ("k", "v")), ("nd", ("ref",)), ("member", ("type", "ref", "role"))):
            rows = [[part.get(key) for key in keys] for part in item.iter(tag)]
            assert [[part.get(key) for key in keys] for part in written.iter(tag)] == rows
        if item.tag == "node":
            for key in ("lon", "lat"):
                assert float(written.get(key, "")) == float(item.get(key, ""))
    assert all(item.get("user") is None for item in found.values())
    assert (made.date, made.source) == (OSM_BASE, f"Overpass API, {server.url}{API}")
    bounds = ElementTree.parse(made.path).find("bounds")
    assert bounds is not None
    assert [float(bounds.get(key, "")) for key in ("minlon", "minlat", "maxlon", "maxlat")] == list(ORDINO)


def test_parts_make_the_same_map(server: WebServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = fetch(tmp_path / "a", overpass=(server.url + API,))
    monkeypatch.setattr(overpass, "_PART_MAX", 20)
    parts = fetch(tmp_path / "b", overpass=(server.url + API,))
    assert len(list((tmp_path / "b" / "cache" / "overpass").glob("*.osm"))) > 8
    assert parts.path.read_bytes() == whole.path.read_bytes()


def test_both_formats_hold_the_same(server: WebServer, tmp_path: Path) -> None:
    one = fetch(tmp_path, overpass=(server.url + API,))
    other = fetch(tmp_path, target="area.osm.pbf", overpass=(server.url + API,))
    assert other.path.read_bytes()[4:15].endswith(b"OSMHeader")
    names = [
        [(item.type_str(), item.id, dict(item.tags)) for item in osmium.FileProcessor(str(made.path))]
        for made in (one, other)
    ]
    assert names[0] == names[1]


def test_polygons_leave_out_what_lies_beside(server: WebServer, tmp_path: Path) -> None:
    west, south, east, north = ORDINO
    ring = [[west, south], [east, south], [west, north], [west, south]]
    place = {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
    (tmp_path / "place.geojson").write_text(json.dumps(place))
    half = place_of_file(tmp_path / "place.geojson")
    assert half.box == ORDINO
    found = set(elements(fetch(tmp_path / "a", half, overpass=(server.url + API,)).path))
    everything = set(elements(fetch(tmp_path / "b", overpass=(server.url + API,)).path))
    assert found < everything
    ways = {name for kind, name in everything - found if kind == "way"}
    assert len(ways) > 5
    # All of those lie beyond the diagonal.
    data = Overpass().data
    for way in ways:
        for key in data.members["way", int(way)]:
            lon, lat = data.places[key]
            assert (lon - west) / (east - west) + (lat - south) / (north - south) > 0.99
    # An extract gives the same.
    cut = set(elements(fetch(tmp_path / "c", half, extract=str(SAMPLE / "area.osm")).path))
    assert {item for item in cut if item[0] == "way"} >= {item for item in found if item[0] == "way"}


def test_an_extract_on_a_server(server: WebServer, tmp_path: Path, extract: bytes) -> None:
    url = server.serve_file("/andorra-latest.osm.pbf", extract)
    remote = fetch(tmp_path / "a", extract=url)
    (tmp_path / "map.osm.pbf").write_bytes(extract)
    local = fetch(tmp_path / "b", extract=str(tmp_path / "map.osm.pbf"))
    assert remote.path.read_bytes() == local.path.read_bytes()
    assert (remote.date, remote.source) == (OSM_BASE, url)
    assert remote.roads[0] <= ORDINO[0]
    # Another area of it needs no network.
    server.requests.clear()
    assert fetch(tmp_path / "a", place_of_box("1.56,42.55,1.57,42.56"), extract=url).source == url
    assert server.requests == []


def test_an_extract_that_was_cut_off_goes_on(server: WebServer, tmp_path: Path, extract: bytes) -> None:
    url = server.serve_file("/map.osm.pbf", extract, lambda request: part_of(extract, request, cut=10_000))
    assert len(elements(fetch(tmp_path, extract=url).path)) > 100
    assert server.requests[1].headers["Range"] == "bytes=10000-"


def test_a_damaged_extract_is_not_kept(server: WebServer, tmp_path: Path, extract: bytes) -> None:
    url = server.serve("/map.osm.pbf", Reply(extract[:20_000], headers={"Content-Length": ""}))
    with pytest.raises(InputError, match=r"cannot be read as OSM data .* damaged or incomplete"):
        fetch(tmp_path, extract=url)
    assert [path.name for path in (tmp_path / "cache" / "extracts").iterdir()] == []
    server.serve_file("/map.osm.pbf", extract)
    assert len(elements(fetch(tmp_path, extract=url).path)) > 100


def test_an_extract_of_another_place_is_kept(server: WebServer, tmp_path: Path, extract: bytes) -> None:
    url = server.serve_file("/map.osm.pbf", extract)
    with pytest.raises(
        InputError, match=r"map.osm.pbf has no way that cars can drive on in bbox 9,42,9.1,42.1; choose"
    ):
        fetch(tmp_path, place_of_box("9,42,9.1,42.1"), extract=url)
    assert len(list((tmp_path / "cache" / "extracts").iterdir())) == 1
    assert list((tmp_path / "out").iterdir()) == []


def test_extracts_that_are_none(server: WebServer, tmp_path: Path) -> None:
    url = server.serve("/map.osm.pbf", Reply(PAGE))
    with pytest.raises(ServerError, match=r"gives a web page \(.*\) instead of OSM data; .* with --extract"):
        fetch(tmp_path, extract=url)
    with pytest.raises(InputError, match="does not exist; check the path of the OSM file"):
        fetch(tmp_path, extract=str(tmp_path / "none.osm.pbf"))
    with pytest.raises(ServerError, match=r"answers with status 404: No such file."):
        fetch(tmp_path, extract=f"{server.url}/other.osm.pbf")


# ---------------------------------------------------------------- buildings and water

NEAR_RIVER = place_of_box(",".join(map(repr, RIVERSIDE_BOX)))


def contents(path: Path) -> tuple[list[int], ...]:
    """Return the ids of a map's elements, by kind."""
    found = [(item.type_str(), item.id) for item in osmium.FileProcessor(str(path))]
    return tuple([number for kind, number in found if kind == wanted] for wanted in "nwr")


@pytest.fixture(params=["overpass", "extract"])
def given(request: pytest.FixtureRequest, server: WebServer, tmp_path: Path) -> dict[str, Any]:
    """Where a map of the riverside is fetched from."""
    source = RIVERSIDE.write(tmp_path)
    server.serve("/river", Overpass(source))
    return {"overpass": (f"{server.url}/river",)} if request.param == "overpass" else {"extract": str(source)}


def test_buildings_and_water_are_there(given: dict[str, Any], tmp_path: Path) -> None:
    path = fetch(tmp_path, NEAR_RIVER, **given).path
    assert contents(path) == WITH_SURROUNDINGS
    tags = {(item.type_str(), item.id): dict(item.tags) for item in osmium.FileProcessor(str(path))}
    assert tags["n", 22] == {}
    assert "barrier" not in tags["w", 41]
    assert tags["w", 10] == {"building": "yes", "height": "9"}
    assert tags["n", 3] == {"highway": "turning_circle"}
    found = read_surroundings(path)
    assert [item.osm_id for item in found.buildings] == ["way/10", "way/20", "relation/1"]
    assert [item.osm_id for item in found.water.open_areas] == ["relation/2"]
    assert len(found.water.coastlines) == 1
    assert found.water.bounds == pytest.approx(RIVERSIDE_BOX, abs=1e-7)


def test_roads_are_the_same_with_and_without(given: dict[str, Any], tmp_path: Path) -> None:
    whole = fetch(tmp_path / "a", NEAR_RIVER, **given)
    alone = fetch(tmp_path / "b", NEAR_RIVER, surroundings=False, **given)
    assert contents(alone.path) == ROADS_ALONE
    assert (whole.roads, whole.date) == (alone.roads, alone.date)
    for made in (whole, alone):
        convert(made.path, output=made.path.with_suffix(".xodr"))
    written = [made.path.with_suffix(".xodr").read_bytes() for made in (whole, alone)]
    assert written[0] == written[1]
    # Both differ from a road network of all there is: what is bare has a meaning there.
    convert(RIVERSIDE.write(tmp_path / "a"), output=tmp_path / "all.xodr")
    assert (tmp_path / "all.xodr").read_bytes().count(b"<object ") > written[0].count(b"<object ")


def test_polygons_take_what_lies_in_the_rectangle_around(
    given: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    west, south, east, north = RIVERSIDE_BOX
    # A triangle with neither a building nor the river in it.
    middle = 0.5 * (west + east)
    ring = [[west, south], [middle, north], [west, north], [west, south]]
    place = {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
    (tmp_path / "place.geojson").write_text(json.dumps(place))
    found = contents(fetch(tmp_path, place_of_file(tmp_path / "place.geojson"), **given).path)
    # The western half: the street to its end, the river with all that is near, and the coast.
    assert found[1:] == ([1, 50, 51, 60, 80], [2])


def test_parts_know_what_others_say_of_their_nodes(
    server: WebServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What comes bare with one part has its tags with another one."""
    server.serve("/river", Overpass(RIVERSIDE.write(tmp_path)))
    west, south, east, north = RIVERSIDE_BOX
    place = place_of_box(f"{west!r},{south!r},{2.0 * east - west!r},{north!r}")
    monkeypatch.setattr(overpass, "_PART_MAX", 8)
    path = fetch(tmp_path, place, overpass=(f"{server.url}/river",)).path
    assert len(list((tmp_path / "cache" / "overpass").glob("*.osm"))) > 4
    tags = {(item.type_str(), item.id): dict(item.tags) for item in osmium.FileProcessor(str(path))}
    assert tags["n", 22] == {"traffic_sign": "DE:274-30", "direction": "90"}
    assert tags["w", 41] == {"barrier": "wall", "height": "2"}

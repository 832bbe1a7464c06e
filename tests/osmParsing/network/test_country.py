"""

Limits that are guessed: by country, by class, and by whether the area is built up.
"""

from __future__ import annotations

import gzip
import json
import math
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from osm_builder import ROW, Area, about, tags_of

import osm2xodr
from osm2xodr.conventions import find_country
from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import Direction, Rule, Street, StreetAttributes
from osm2xodr.osmParsing import ParseOptions
from osm2xodr.osmParsing.file.access import RawWay
from osm2xodr.osmParsing.network.country import Place, find_place, with_default_speeds
from osm2xodr.osmParsing.tags.ways import way_attributes


@pytest.mark.parametrize(
    ("lat", "lon", "place"),
    [
        (51.500, -0.095, Place("GB", True)),  # London
        (-31.982, 115.900, Place("AU", True)),  # Perth
        (52.474, 13.439, Place("DE", False)),  # Berlin
        (35.895, 14.500, Place("MT", True)),  # Valletta
        (35.681, 139.767, Place("JP", True)),  # Tokyo
        (47.640, -122.303, Place("US", False)),  # Seattle
        (42.560, 1.570, Place("AD", False)),  # Ordino
        (43.737, 7.422, Place("MC", False)),
        (41.902, 12.453, Place("VA", False)),  # within Italy
        (22.300, 114.170, Place("HK", True)),
        (22.600, 114.000, Place("CN", False)),  # Shenzhen, 30 km away
        (36.140, -5.350, Place("GI", False)),
        (18.340, -64.930, Place("VI", True)),  # the one part of the US that drives on the left
        (18.400, -66.100, Place("PR", False)),
        (35.190, 33.360, Place("CY", True)),
        (28.460, -16.250, Place("ES", False)),  # Tenerife: a code of its own is only reserved
        (-16.80, 179.990, Place("FJ", True)),
        (-16.80, -179.990, Place("FJ", True)),
        (78.220, 15.650, Place("SJ", False)),
    ],
)
def test_places(lat: float, lon: float, place: Place) -> None:
    assert find_place(lat, lon) == place


def test_at_sea_the_nearest_country_tells_the_side() -> None:
    assert find_place(50.2, -1.0) == Place("", False)  # in the Channel, nearer to France
    assert find_place(50.45, -1.0) == Place("GB", True)
    assert find_place(30.0, -40.0) == Place("", None)  # the middle of the Atlantic


def test_the_table_is_small_and_says_where_it_is_from() -> None:
    packed = resources.files("osm2xodr.osmParsing.network").joinpath("data/countries.json.gz").read_bytes()
    table = json.loads(gzip.decompress(packed))
    assert len(packed) < 300_000
    assert table["source"].startswith("country-coder ")
    assert "ISC License" in resources.files("osm2xodr.osmParsing.network").joinpath("data/LICENSE").read_text(
        encoding="utf-8"
    )
    codes = {place["code"] for place in table["places"]}
    assert len(codes) > 240
    assert all(len(code) in {0, 2} for code in codes)
    # Countries of the world that drive on the left, a sample, and whole countries that do not.
    left = {place["code"] for place in table["places"] if place["left"]}
    assert {
        "AU",
        "BW",
        "CY",
        "GB",
        "HK",
        "ID",
        "IE",
        "IN",
        "JM",
        "JP",
        "KE",
        "MT",
        "MY",
        "NZ",
        "SG",
        "TH",
        "ZA",
    } <= left
    assert not {"BR", "CN", "DE", "EG", "FR", "GI", "KR", "MM", "NG", "RU", "SE", "US"} & left


def guess(code: str, text: str, dense: bool = False) -> tuple[StreetAttributes, Diagnostics]:
    """Return what is found about a street of a single way, `dense`ly among dwellings or not."""
    tags, diagnostics = tags_of(text), Diagnostics()
    country = find_country(code)
    (attributes,), _ = way_attributes([RawWay(7, [1, 2], tags)], Rule.RIGHT_HAND, None, Diagnostics(), country)
    points = np.array([[0.0, 0.0], [100.0, 0.0]])
    street = Street(0, 0, 1, points, np.array([1, 2]), ((0, attributes),))
    (found,) = with_default_speeds([street], {7: tags}, {7} if dense else set(), country, diagnostics)
    return found.pieces[0][1], diagnostics


@pytest.mark.parametrize(
    ("code", "tags", "kmh"),
    [
        # Nothing but the class and the country.
        ("FR", "highway=secondary", 80.0),
        ("MT", "highway=unclassified", 80.0),
        ("XX", "highway=tertiary", 90.0),
        ("US", "highway=residential", 25 * 1.609344),
        ("US", "highway=living_street", 20.0),
        ("DE", "highway=service", 20.0),
        ("AE", "highway=service", 25.0),
        ("DE", "highway=track", 20.0),
        ("US", "highway=motorway", 70 * 1.609344),
        ("JP", "highway=motorway", 100.0),
        ("DE", "highway=pedestrian", 7.0),
        # Lamps and sidewalks show that the area is built up, tags say it for sure.
        ("US", "highway=secondary lit=yes", 30 * 1.609344),
        ("DE", "highway=trunk lit=yes", 50.0),
        ("DE", "highway=trunk lit=yes motorroad=yes", 100.0),
        ("DE", "highway=secondary maxspeed=signals zone:traffic=DE:urban", 50.0),
        ("US", "highway=secondary lit=yes zone:traffic=US:rural", 55 * 1.609344),
        ("US", "highway=secondary source:maxspeed=sign zone:traffic=US:urban", 30 * 1.609344),
        # Carriageways for one direction outside of built-up areas.
        ("GB", "highway=primary", 60 * 1.609344),
        ("GB", "highway=primary oneway=yes", 70 * 1.609344),
        ("GB", "highway=tertiary oneway=yes", 60 * 1.609344),
        ("GB", "highway=primary junction=roundabout", 60 * 1.609344),
        ("FR", "highway=trunk oneway=yes", 110.0),
        ("FR", "highway=trunk", 80.0),
        ("FR", "highway=primary motorroad=yes", 110.0),
        ("DE", "highway=trunk oneway=yes", 100.0),
        # Ramps.
        ("DE", "highway=motorway_link", 80.0),
        ("FR", "highway=trunk_link", 80.0),
        ("SE", "highway=primary_link", 70.0),
    ],
)
def test_limits_by_country_class_and_place(code: str, tags: str, kmh: float) -> None:
    found, diagnostics = guess(code, tags)
    speed = found.speed_along(Direction.FORWARD)
    assert speed == pytest.approx(kmh / 3.6)
    # The law's own guesses are found with the tags.
    assert found.default_speed == (speed if found.speed_forward is None else None)
    assert [item.osm_id for item in diagnostics] == ["way/7"] * (found.default_speed is not None)


@pytest.mark.parametrize(("dense", "kmh"), [(False, 80.0), (True, 50.0)])
def test_dwellings_show_a_built_up_area(dense: bool, kmh: float) -> None:
    found, diagnostics = guess("FR", "highway=tertiary", dense)
    assert found.default_speed == pytest.approx(kmh / 3.6)
    where = "in built-up areas" if kmh == 50.0 else "outside built-up areas"
    ((kind, code, message),) = [(item.kind, item.code, item.message) for item in diagnostics]
    assert (kind, code) == (Kind.GUESSED, "speed")
    assert message == f"no limit given, {kmh:.0f} km/h is usual {where} in FR"
    # They say nothing about a road for motor vehicles only, or where a tag says better.
    assert guess("FR", "highway=primary motorroad=yes", dense)[0].default_speed == pytest.approx(110.0 / 3.6)
    rural, _ = guess("US", "highway=primary source:maxspeed=US:rural", dense)
    assert rural.default_speed == pytest.approx(55 * 0.44704)


def test_known_limits_stay() -> None:
    found, diagnostics = guess("DE", "highway=primary maxspeed=70")
    assert found.speed_forward == pytest.approx(70.0 / 3.6)
    assert (found.default_speed, list(diagnostics)) == (None, [])
    found, diagnostics = guess("DE", "highway=motorway")
    assert (found.default_speed, found.speed_forward, list(diagnostics)) == (None, math.inf, [])
    # A direction without cars needs none.
    found, diagnostics = guess("DE", "highway=primary oneway=yes maxspeed:forward=70")
    assert (found.default_speed, list(diagnostics)) == (None, [])


def test_one_direction_has_the_limit_of_the_other() -> None:
    found, diagnostics = guess("DE", "highway=primary maxspeed:backward=70")
    assert found.default_speed == found.speed_backward == pytest.approx(70.0 / 3.6)
    assert found.speed_along(Direction.FORWARD) == found.speed_backward
    assert found.speed_signed is True
    (item,) = diagnostics
    assert item.message == "no limit given for one direction, taken from the other one: 70 km/h"


def test_guesses_are_left_out_on_request(tmp_path: Path) -> None:
    area = Area(ROW, {20: ([1, 2], "highway=residential"), 21: ([2, 3], "highway=tertiary maxspeed=30")})
    network, diagnostics = area.parse(tmp_path, ParseOptions(default_speeds=False))
    found = {
        piece.osm_way_id: piece.speed_along(Direction.BOTH) for item in network.streets for _, piece in item.pieces
    }
    assert found == {20: None, 21: pytest.approx(30.0 / 3.6)}
    assert about(diagnostics, "speed") == []
    network, diagnostics = area.parse(tmp_path, ParseOptions())
    found = {
        piece.osm_way_id: piece.speed_along(Direction.BOTH) for item in network.streets for _, piece in item.pieces
    }
    assert found == {20: pytest.approx(50.0 / 3.6), 21: pytest.approx(30.0 / 3.6)}
    assert [item.osm_id for item in about(diagnostics, "speed")] == ["way/20"]


def test_the_length_of_roads_with_a_guess_is_in_the_report(tmp_path: Path) -> None:
    # Ways of 100 m, one after the other.
    area = Area(ROW, {20: ([1, 2], "highway=tertiary name=a"), 21: ([4, 5], "highway=tertiary maxspeed=30")})
    further = osm2xodr.convert(area.write(tmp_path), no_furniture=True).statistics.further
    assert further["default_speed_km"] == pytest.approx(0.1, abs=0.001)
    further = osm2xodr.convert(area.write(tmp_path), no_default_speeds=True).statistics.further
    assert further["default_speed_km"] == 0.0

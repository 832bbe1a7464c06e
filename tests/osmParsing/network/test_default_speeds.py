"""Limits that are guessed: by country, by class, and by whether the area is built up."""

from __future__ import annotations

import math
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
from osm2xodr.osmParsing.network.default_speeds import with_default_speeds
from osm2xodr.osmParsing.tags.ways import way_attributes


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

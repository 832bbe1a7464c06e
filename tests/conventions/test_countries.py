"""The table of countries: what it says, and that all of it makes sense."""

from __future__ import annotations

import json
import math
from dataclasses import fields
from importlib import resources

import pytest

from osm2xodr.conventions.countries import (
    GENERIC,
    KMH,
    LANE_WIDTH,
    LANE_WIDTH_OTHER,
    MPH,
    MarkStyle,
    countries,
    find_country,
)
from osm2xodr.osmParsing.defaults import LANE_WIDTH_MAX, LANE_WIDTH_MIN
from osm2xodr.osmParsing.tags.values import _SPEED_PLAUSIBLE_MAX_KMH, parse_speed

TABLE = json.loads(resources.files("osm2xodr.conventions").joinpath("countries.json").read_text(encoding="utf-8"))
LEGAL = json.loads(resources.files("osm2xodr.conventions").joinpath("legal_speeds.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("code", "kind", "kmh"),
    [
        ("DE", "urban", 50.0),
        ("DE", "rural", 100.0),
        ("DE", "motorway", math.inf),
        ("DE", "living_street", 7.0),
        ("FR", "rural", 80.0),
        ("ES", "residential", 30.0),
        ("PL", "motorway", 140.0),
        ("BE", "urban", 50.0),
        ("BE-BRU", "urban", 30.0),
        ("GB", "urban", 30 * 1.609344),
        ("GB", "motorway", 70 * 1.609344),
        ("GB", "nsl_single", 60 * 1.609344),
        ("GB", "rural", None),
        ("US", "urban", None),
        ("XX", "urban", None),
    ],
)
def test_limits(code: str, kind: str, kmh: float | None) -> None:
    speed = find_country(code).speeds.get(kind)
    assert speed == (None if kmh is None else pytest.approx(kmh / 3.6))
    # Tags that name the country's law mean the same.
    assert parse_speed(f"{code}:{kind}") == speed


@pytest.mark.parametrize(
    ("code", "kind", "kmh"),
    [
        # What is known for sure goes before what is usual.
        ("ES", "urban", 50.0),
        ("ES", "residential", 30.0),
        ("NL", "motorway", 100.0),
        ("DE", "motorway", math.inf),
        ("GB", "rural", 60 * 1.609344),
        ("GB", "dual", 70 * 1.609344),
        ("FR", "motorroad", 110.0),
        ("PL", "dual", 100.0),
        # The law differs from state to state: the median.
        ("US", "residential", 25 * 1.609344),
        ("US", "urban", 30 * 1.609344),
        ("US", "rural", 55 * 1.609344),
        # In one of the tables only.
        ("MT", "rural", 80.0),
        ("AT", "living_street", 7.0),
        ("SN", "urban", 50.0),
        # Only the limit outside of built-up areas is known, and low.
        ("AS", "urban", 15 * 1.609344),
        ("GU", "urban", 50.0),
        ("JE", "urban", 50.0),
        ("", "urban", 50.0),
        ("XX", "rural", 90.0),
        ("XX", "dual", None),
    ],
)
def test_usual_limits(code: str, kind: str, kmh: float | None) -> None:
    speed = find_country(code).default_speeds.get(kind)
    assert speed == (None if kmh is None else pytest.approx(kmh / 3.6))


def test_every_country_has_all_that_is_asked_for() -> None:
    kinds = {"urban", "rural", "motorway", "living_street"}
    for code in {*TABLE["countries"], *LEGAL["countries"], ""}:
        speeds = find_country(code).default_speeds
        assert kinds <= speeds.keys(), code
        assert speeds.keys() <= kinds | {"residential", "service", "dual", "motorroad", "nsl_restricted"}, code
        assert all(6.9 < speed * 3.6 <= 140.1 or math.isinf(speed) for speed in speeds.values()), code
        assert speeds["living_street"] <= speeds["urban"] <= speeds["rural"] <= speeds["motorway"], code


def test_the_table_of_usual_limits_names_its_source_and_is_sorted() -> None:
    assert "OpenStreetMap wiki" in LEGAL["source"]
    assert list(LEGAL["countries"]) == sorted(LEGAL["countries"])
    assert len(LEGAL["countries"]) == 159


@pytest.mark.parametrize(
    ("code", "unit"), [("DE", KMH), ("GB", MPH), ("US", MPH), ("PR", MPH), ("IM", MPH), ("CA", KMH), ("", KMH)]
)
def test_units_of_signs(code: str, unit: str) -> None:
    assert find_country(code).speed_unit == unit


@pytest.mark.parametrize(
    ("code", "highway", "feet_or_m"),
    [
        ("US", "motorway", 12 * 0.3048),
        ("US", "secondary", 11 * 0.3048),
        ("US", "residential", 10 * 0.3048),
        ("US", "service", LANE_WIDTH["service"]),
        ("GB", "trunk", 3.65),
        ("GB", "residential", 2.75),
        ("IT", "secondary", 3.5),
        ("AU", "tertiary", 3.5),
        ("JP", "trunk", 3.25),
        ("DE", "motorway", 3.65),
        ("", "primary", LANE_WIDTH["primary"]),
        ("", "corridor", LANE_WIDTH_OTHER),
    ],
)
def test_lane_widths(code: str, highway: str, feet_or_m: float) -> None:
    assert find_country(code).lane_width(highway) == pytest.approx(feet_or_m, abs=0.005)


@pytest.mark.parametrize(("code", "width"), [("US", 3.35), ("CA", 3.3), ("JP", 3.25), ("DE", 3.0), ("GB", 3.0)])
def test_lanes_beside_others_in_towns(code: str, width: float) -> None:
    assert find_country(code).lane_width("primary", beside_in_town=True) == width
    assert find_country(code).lane_width("residential", beside_in_town=True) <= width


@pytest.mark.parametrize(
    ("code", "centre", "centre_solid", "outer_edge", "median_edge"),
    [
        ("", "standard", "standard", "standard", "standard"),
        ("DE", "standard", "standard", "standard", "standard"),
        ("US", "yellow", "yellow", "standard", "yellow"),
        ("CA", "yellow", "yellow", "standard", "yellow"),
        ("MX", "yellow", "yellow", "standard", "yellow"),
        ("BR", "yellow", "yellow", "standard", "standard"),
        ("NO", "yellow", "yellow", "standard", "yellow"),
        ("ZA", "standard", "standard", "yellow", "standard"),
    ],
)
def test_colours(code: str, centre: str, centre_solid: str, outer_edge: str, median_edge: str) -> None:
    marks = find_country(code).marks
    assert (marks.centre, marks.centre_solid, marks.outer_edge, marks.median_edge) == (
        centre,
        centre_solid,
        outer_edge,
        median_edge,
    )


def test_an_unknown_country_is_as_most_are() -> None:
    assert find_country("XX") is GENERIC
    assert find_country("") is GENERIC
    assert (GENERIC.code, GENERIC.speed_unit, dict(GENERIC.speeds), GENERIC.marks) == ("", KMH, {}, MarkStyle())


def test_every_entry_is_sound_and_names_its_sources() -> None:
    colors = {"standard", "yellow"}
    for code, country in countries().items():
        assert country.code == code
        assert country.sources, code
        for speed in country.speeds.values():
            assert 5.0 <= speed * 3.6 <= _SPEED_PLAUSIBLE_MAX_KMH or math.isinf(speed), code
        for highway, width in country.lane_widths.items():
            assert highway in LANE_WIDTH, code
            assert LANE_WIDTH_MIN < width < LANE_WIDTH_MAX, code
            assert abs(width - LANE_WIDTH[highway]) <= 0.5, code
        assert country.lane_width_beside is None or 3.0 < country.lane_width_beside < 3.5, code
        for item in fields(MarkStyle):
            value = getattr(country.marks, item.name)
            if item.type == "str":
                assert value in colors or (item.name == "no_overtaking" and value == ""), code
            elif item.type == "float":
                assert 0.1 <= value <= 0.3, code
        assert country.marks.double_from in (0, 3, 4), code


def test_the_table_has_no_source_in_vain_and_no_country_twice() -> None:
    used = {source for entry in TABLE["countries"].values() for source in entry["sources"]}
    assert used == set(TABLE["sources"])
    assert list(TABLE["countries"]) == sorted(TABLE["countries"])
    # Lists of an object's keys would swallow what stands there twice.
    pairs = json.loads(
        resources.files("osm2xodr.conventions").joinpath("countries.json").read_text(encoding="utf-8"),
        object_pairs_hook=lambda items: items,
    )
    codes = [code for code, _ in dict(pairs)["countries"]]
    assert len(codes) == len(set(codes)) == len(countries())

"""The document about lanes names every default of lanes and margins with the value that it has."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType

import pytest

from osm2xodr.conventions import defaults as of_conventions
from osm2xodr.conventions.defaults import DEFAULT_SPEED_KMH
from osm2xodr.geometry import defaults as shared
from osm2xodr.geometry.lanes import defaults as of_lanes
from osm2xodr.geometry.margins import defaults as of_margins
from osm2xodr.osmParsing import defaults as of_parsing

TEXT = (Path(__file__).parents[3] / "docs" / "method" / "lanes.md").read_text("utf-8")
ROWS = dict(re.findall(r"^\| `([A-Z_]+)` \| ([^|]+) \|", TEXT, re.MULTILINE))


def values(module: ModuleType) -> dict[str, object]:
    return {name: value for name, value in vars(module).items() if name.isupper()}


GUESSED_SPEEDS = (
    "BUILT_UP_DENSITY",
    "BUILT_UP_STREET_DENSITY",
    "BUILT_UP_CROSSING_SPACING",
    "SERVICE_SPEED_KMH",
    "LINK_SPEED_KMH",
)
OF_KERBS = (
    *("BESIDE_SPACING", "KERB_REACH", "KERBS_SCATTER", "MOUTH_LENGTH"),
    *("LANES_ABREAST", "LANE_WIDTH_ABREAST_MAX"),
)
OF_PARSING = (
    *("LANE_WIDTH_MIN", "LANE_WIDTH_MAX", "LANES_BESIDE_PARKING", "PARKING_PAUSE_MAX", "TOWN_SPEED_MAX_KMH"),
    "SHOULDER_WIDTH",
    *OF_KERBS,
)
DEFAULTS = values(shared) | values(of_lanes) | values(of_margins)
DEFAULTS |= {name: getattr(of_parsing, name) for name in (*GUESSED_SPEEDS, *OF_PARSING)}
DEFAULTS |= {
    name: getattr(of_conventions, name) for name in ("LANE_WIDTH", "ONE_LANE_WIDTH", "LANE_WIDTH_BESIDE_IN_TOWN")
}


def test_every_default_of_lanes_and_margins_is_in_the_table() -> None:
    expected = values(of_lanes).keys() | values(of_margins).keys()
    assert expected | set(GUESSED_SPEEDS) <= ROWS.keys()
    assert ROWS.keys() <= DEFAULTS.keys()


@pytest.mark.parametrize("name", ROWS)
def test_values_in_the_table_are_those_of_the_code(name: str) -> None:
    value = DEFAULTS[name]
    if isinstance(value, Mapping):
        # By class of road; the table has some of them.
        said = {name: float(number) for name, number in (item.split() for item in ROWS[name].split(", "))}
        assert said.items() <= value.items()
    elif isinstance(value, tuple):
        assert tuple(ROWS[name].split(", ")) == value
    else:
        assert float(ROWS[name]) == pytest.approx(value, rel=1e-5)


def test_the_text_names_no_constant_that_is_not_in_the_table() -> None:
    named = set(re.findall(r"`([A-Z][A-Z_]+[A-Z])`", TEXT))
    assert named == ROWS.keys()
    usual = "50 km/h in built-up areas, 90 outside, 120 on motorways and 20 in living streets"
    assert usual in " ".join(TEXT.split())
    assert [DEFAULT_SPEED_KMH[kind] for kind in ("urban", "rural", "motorway", "living_street")] == [50, 90, 120, 20]

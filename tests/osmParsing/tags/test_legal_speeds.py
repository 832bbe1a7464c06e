"""Limits that follow from the law where none is tagged, and lanes as wide as the country's guide wants them.

Which ways are built as streets in town are.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from osm_builder import Area, about, tags_of

from osm2xodr.conventions.countries import GENERIC, find_country
from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import Rule
from osm2xodr.osmParsing import ParseOptions
from osm2xodr.osmParsing.file.access import RawWay
from osm2xodr.osmParsing.tags.legal_speeds import is_town_street, legal_speed
from osm2xodr.osmParsing.tags.ways import way_attributes


@pytest.mark.parametrize(
    ("code", "tags", "kmh"),
    [
        ("DE", "highway=residential", 50.0),
        ("ES", "highway=residential", 30.0),
        ("DE", "highway=living_street", 7.0),
        ("DE", "highway=motorway", math.inf),
        ("FR", "highway=motorway", 130.0),
        ("DE", "highway=secondary lit=yes", 50.0),
        ("DE", "highway=secondary lit=24/7", 50.0),
        ("DE", "highway=unclassified sidewalk=right", 50.0),
        ("DE", "highway=tertiary sidewalk:left=separate", 50.0),
        ("GB", "highway=primary lit=yes", 30 * 1.609344),
        # Nothing shows where they are, or it shows something else.
        ("DE", "highway=secondary", None),
        ("DE", "highway=secondary lit=no sidewalk=no", None),
        ("DE", "highway=secondary sidewalk:both=none", None),
        ("DE", "highway=motorway_link lit=yes", None),
        ("DE", "highway=trunk lit=yes", None),
        ("DE", "highway=track lit=yes", None),
        ("DE", "highway=service sidewalk=both", None),
        # The law is another one in every state, or not known.
        ("US", "highway=residential", None),
        ("US", "highway=motorway", None),
        ("JP", "highway=residential", None),
        ("", "highway=residential", None),
        ("XX", "highway=motorway", None),
    ],
)
def test_limits_of_the_law(code: str, tags: str, kmh: float | None) -> None:
    assert legal_speed(tags_of(tags), find_country(code)) == (None if kmh is None else pytest.approx(kmh / 3.6))


@pytest.mark.parametrize(
    ("tags", "forward", "backward", "said"),
    [
        ("", 50.0, 50.0, ["no limit given, taken from the law of DE: 50 km/h"]),
        ("maxspeed=30", 30.0, 30.0, []),
        ("source:maxspeed=DE:rural", 100.0, 100.0, []),
        ("maxspeed:forward=30", 30.0, None, []),
    ],
)
def test_the_law_is_asked_last(tags: str, forward: float, backward: float | None, said: list[str]) -> None:
    diagnostics = Diagnostics()
    way = RawWay(1, [1, 2], tags_of(f"highway=residential lanes=2 width=6 {tags}"))
    ((attributes,), _) = way_attributes([way], Rule.RIGHT_HAND, None, diagnostics, find_country("DE"))
    assert attributes.speed_forward == pytest.approx(forward / 3.6)
    assert attributes.speed_backward == (None if backward is None else pytest.approx(backward / 3.6))
    assert attributes.speed_signed is (tags.startswith("maxspeed"))
    assert [item.message for item in diagnostics if item.kind is Kind.GUESSED] == said
    assert [item.code for item in diagnostics] == ["speed"] * len(said)


def test_no_limit_is_said_in_words() -> None:
    diagnostics = Diagnostics()
    ways = [RawWay(k, [1, 2], tags_of("highway=motorway lanes=2 width=7.3 oneway=yes")) for k in (1, 2)]
    attributes, _ = way_attributes(ways[:1], Rule.RIGHT_HAND, None, diagnostics, find_country("DE"))
    assert attributes[0].speed_forward == math.inf
    way_attributes(ways[1:], Rule.LEFT_HAND, None, diagnostics, find_country("GB"))
    assert [item.message.rpartition(": ")[2] for item in diagnostics] == ["none", "70 mph"]


@pytest.mark.parametrize(
    ("ways", "kmh", "told"),
    [
        # A lamp shows that all of the street is in a built-up area.
        (["", "lit=yes", ""], [50, 50, 50], [20, 21, 22]),
        (["", "", "sidewalk=both"], [50, 50, 50], [20, 21, 22]),
        (["", "", ""], [None, None, None], []),
        # A limit of its own ends it.
        (["lit=yes", "maxspeed=70", ""], [50, 70, None], [20]),
        # That one happens to be as high as in a built-up area, but is signed.
        (["", "maxspeed=50", ""], [None, 50, None], []),
        (["", "maxspeed=50 lit=yes", ""], [None, 50, None], []),
    ],
)
def test_a_street_is_in_a_built_up_area_as_a_whole(
    tmp_path: Path, ways: list[str], kmh: list[float | None], told: list[int]
) -> None:
    nodes = {k: (100.0 * k, 0.0) for k in range(1, 5)}
    tags = "highway=secondary lanes=2 width=7"
    area = Area(nodes, {20 + k: ([k + 1, k + 2], f"{tags} {more}") for k, more in enumerate(ways)})
    network, diagnostics = area.parse(tmp_path, ParseOptions())
    found = {piece.osm_way_id: piece for street in network.streets for _, piece in street.pieces}
    for k, speed in enumerate(kmh):
        expected = None if speed is None else pytest.approx(speed / 3.6)
        assert (found[20 + k].speed_forward, found[20 + k].speed_backward) == (expected, expected)
    guessed = [item for item in about(diagnostics, "speed") if "the law of DE" in item.message]
    assert sorted(item.osm_id for item in guessed) == [f"way/{way}" for way in told]
    assert {item.kind for item in guessed} <= {Kind.GUESSED}


@pytest.mark.parametrize(
    ("code", "chosen", "tags", "widths"),
    [
        ("US", None, "highway=secondary lanes=2", [3.35, 3.35]),
        ("US", None, "highway=motorway oneway=yes lanes=2", [3.66, 3.66]),
        ("GB", None, "highway=trunk lanes=2", [3.65, 3.65]),
        ("", None, "highway=secondary lanes=2", [3.25, 3.25]),
        ("US", 3.0, "highway=secondary lanes=2", [3.0, 3.0]),
        ("US", None, "highway=secondary lanes=2 width=7", [3.5, 3.5]),
    ],
)
def test_lanes_are_as_wide_as_the_country_has_them(
    code: str, chosen: float | None, tags: str, widths: list[float]
) -> None:
    way = RawWay(1, [1, 2], tags_of(tags))
    country = find_country(code) if code else GENERIC
    ((attributes,), _) = way_attributes([way], Rule.RIGHT_HAND, chosen, Diagnostics(), country)
    assert [lane.width for lane in attributes.lanes_ltr] == widths


@pytest.mark.parametrize(
    ("tags", "dense", "town"),
    [
        ("highway=primary", False, False),
        ("highway=primary", True, True),
        ("highway=primary lit=yes", False, True),
        # A limit says it best.
        ("highway=primary lit=yes maxspeed=70", True, False),
        ("highway=primary maxspeed=60", False, True),
        ("highway=primary maxspeed=35mph", False, True),
        ("highway=primary maxspeed=none", True, False),
        ("highway=primary maxspeed=signals zone:traffic=DE:urban", False, True),
        ("highway=primary zone:traffic=DE:rural", True, False),
        # Roads for motor vehicles alone are built for speed wherever they lie.
        ("highway=motorway maxspeed=50", True, False),
        ("highway=motorway_link", True, False),
        ("highway=trunk motorroad=yes maxspeed=60", True, False),
    ],
)
def test_town_streets(tags: str, dense: bool, town: bool) -> None:
    assert is_town_street(tags_of(tags), dense) is town

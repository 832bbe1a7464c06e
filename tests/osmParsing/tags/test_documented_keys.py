"""Every key about lanes, one-ways and speed limits that OSM's wiki documents is either read or reported."""

from __future__ import annotations

from typing import Final

import pytest
from osm_builder import tags_of

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.model import Rule
from osm2xodr.osmParsing.file import RawWay
from osm2xodr.osmParsing.tags import WAY_TAGS, way_attributes

# OSM wiki, Key:lanes, Key:lanes:*, Key:lanes:psv, Key:lanes:bus, Lanes: a value, and other tags of the way.
LANES: Final = {
    "lanes": ("3", ""),
    "lanes:forward": ("2", ""),
    "lanes:backward": ("2", ""),
    "lanes:both_ways": ("1", ""),
    "lanes:reversible": ("1", "lanes=3"),
    "lanes:psv": ("1", "lanes=3"),
    "lanes:psv:forward": ("1", "lanes=4"),
    "lanes:psv:backward": ("1", "lanes=4"),
    "lanes:psv:conditional": ("1 @ (Mo-Fr)", "lanes=4"),
    "lanes:psv:forward:conditional": ("1 @ (Mo-Fr)", "lanes=4"),
    "lanes:psv:times": ("Mo-Fr", "lanes=4"),
    "lanes:bus": ("1", "lanes=3"),
    "lanes:bus:forward": ("1", "lanes=4"),
    "lanes:bus:backward": ("1", "lanes=4"),
    "lanes:bus:conditional": ("1 @ (Mo-Fr)", "lanes=4"),
    "lanes:taxi": ("1", "lanes=3"),
    "lanes:taxi:forward": ("1", "lanes=4"),
    "lanes:hov": ("1", "lanes=3"),
    "lanes:hov:backward": ("1", "lanes=4"),
    "lanes:bicycle": ("1", ""),
    "lanes:bicycles": ("1", ""),
    "lanes:conditional": ("3 @ (Mo-Fr 06:00-09:00)", "lanes=2"),
    "lanes:forward:conditional": ("3 @ (Mo-Fr 06:00-09:00)", "lanes=4"),
    "lanes:variable": ("yes", "lanes=2"),
}
# OSM wiki, Key:oneway, the keys with pages of their own, and what Conditional restrictions allows.
ONEWAYS: Final = {
    "oneway": ("yes", ""),
    "oneway:bicycle": ("no", "oneway=yes cycleway:left=lane"),
    "oneway:bicycle:conditional": ("no @ (Mo-Fr)", "oneway=yes"),
    "oneway:bus": ("no", "oneway=yes lanes=2"),
    "oneway:psv": ("no", "oneway=yes lanes=2"),
    "oneway:taxi": ("no", "oneway=yes lanes=2"),
    "oneway:motorcar": ("yes", ""),
    "oneway:motor_vehicle": ("yes", ""),
    "oneway:vehicle": ("yes", ""),
    "oneway:motorcycle": ("no", "oneway=yes"),
    "oneway:moped": ("no", "oneway=yes"),
    "oneway:mofa": ("no", "oneway=yes"),
    "oneway:speed_pedelec": ("no", "oneway=yes"),
    "oneway:hgv": ("yes", ""),
    "oneway:foot": ("no", "oneway=yes"),
    "oneway:emergency": ("no", "oneway=yes"),
    "oneway:tram": ("no", "oneway=yes"),
    "oneway:conditional": ("yes @ (Mo-Fr)", ""),
}
# OSM wiki, Key:maxspeed, Speed limits, Key:maxspeed:type, Conditional restrictions.
SPEEDS: Final = {
    "maxspeed": ("30", ""),
    "maxspeed:forward": ("30", ""),
    "maxspeed:backward": ("30", ""),
    "maxspeed:lanes": ("50|30", "oneway=yes lanes=2"),
    "maxspeed:lanes:forward": ("50|30", "lanes=4"),
    "maxspeed:lanes:backward": ("50|30", "lanes=4"),
    "maxspeed:lanes:conditional": ("50|30 @ (Mo-Fr)", "oneway=yes lanes=2"),
    "maxspeed:type": ("DE:urban", ""),
    "source:maxspeed": ("DE:urban", ""),
    "zone:maxspeed": ("DE:30", ""),
    "zone:traffic": ("DE:urban", ""),
    "maxspeed:conditional": ("30 @ (22:00-06:00)", ""),
    "maxspeed:forward:conditional": ("30 @ (22:00-06:00)", ""),
    "maxspeed:hgv": ("60", ""),
    "maxspeed:hgv:conditional": ("60 @ (weight>7.5)", ""),
    "maxspeed:hgv:forward": ("60", ""),
    "maxspeed:bus": ("80", ""),
    "maxspeed:coach": ("80", ""),
    "maxspeed:trailer": ("80", ""),
    "maxspeed:caravan": ("80", ""),
    "maxspeed:goods": ("80", ""),
    "maxspeed:motorcycle": ("80", ""),
    "maxspeed:towing": ("80", ""),
    "maxspeed:variable": ("obstruction", ""),
    "maxspeed:advisory": ("130", ""),
    "maxspeed:advisory:forward": ("130", ""),
    "maxspeed:practical": ("40", ""),
    "maxspeed:wet": ("80", ""),
    "maxspeed:signed": ("no", ""),
}
EVERY: Final = {**LANES, **ONEWAYS, **SPEEDS}


@pytest.mark.parametrize("key", EVERY)
def test_a_documented_key_changes_the_road_or_is_reported(key: str) -> None:
    value, others = EVERY[key]
    assert key in WAY_TAGS
    tags = {"highway": "primary", **tags_of(others)}
    found = []
    said = Diagnostics()
    for every in (tags, {**tags, key: value}):
        attributes = way_attributes([RawWay(1, [1, 2], every)], Rule.RIGHT_HAND, None, said)
        found.append(attributes)
    named = any(f"{key}={value}" in item.message for item in said)
    assert named or found[0] != found[1]

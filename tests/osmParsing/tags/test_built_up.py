"""Which ways are built as streets in town are."""

from __future__ import annotations

import pytest
from osm_builder import tags_of

from osm2xodr.osmParsing.tags.built_up import is_town_street


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

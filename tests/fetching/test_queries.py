"""Queries for buildings and water, carried out on a map in memory."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from overpass_ql import MapData
from riverside import BOX, RIVERSIDE, ROADS_ALONE, WITH_SURROUNDINGS

from osm2xodr.fetching.place import Box
from osm2xodr.fetching.queries import area_query, count_query
from osm2xodr.osmParsing import SURROUNDINGS_KEYS, SURROUNDINGS_TAGS, in_surroundings


@pytest.fixture
def data(tmp_path: Path) -> MapData:
    return MapData(RIVERSIDE.write(tmp_path))


def numbers(text: str, kind: str) -> list[int]:
    """Return the ids of a kind in an answer, in their order; each is there once."""
    found = [int(number) for number in re.findall(rf'<{kind} id="(\d+)"', text)]
    assert len(found) == len(set(found))
    return sorted(found)


def test_roads_alone(data: MapData) -> None:
    text = data.run(area_query(BOX, surroundings=False))
    assert tuple(numbers(text, kind) for kind in ("node", "way", "relation")) == ROADS_ALONE


def test_buildings_and_water_come_as_far_as_is_reasonable(data: MapData) -> None:
    text = data.run(area_query(BOX, surroundings=True))
    assert tuple(numbers(text, kind) for kind in ("node", "way", "relation")) == WITH_SURROUNDINGS


def test_what_only_outlines_need_has_no_tags(data: MapData) -> None:
    text = data.run(area_query(BOX, surroundings=True))
    assert "traffic_sign" not in text
    # Of the two walls the one in the area.
    assert text.count('v="wall"') == 1
    assert re.search(r'<way id="41"( version="1")?><nd ref="44" ?/><nd ref="43" ?/></way>', text)
    # What is tagged as a part of a road stays.
    assert 'v="turning_circle"' in text


def test_the_count_is_of_what_comes(data: MapData) -> None:
    # Nodes that mean something by themselves are counted, those of ways are not.
    assert data.run(count_query(BOX, surroundings=False)) == '<count id="0"><tag k="total" v="3"/></count>'
    _, ways, relations = WITH_SURROUNDINGS
    total = len(ways) + len(relations)
    assert data.run(count_query(BOX, surroundings=True)) == f'<count id="0"><tag k="total" v="{total}"/></count>'


def test_all_that_scenes_read_is_asked_for() -> None:
    query = area_query(BOX, surroundings=True)
    for key in SURROUNDINGS_KEYS:
        assert in_surroundings({key: "yes"})
        assert f'rel["type"="multipolygon"]["{key}"](' in query
        assert f'way["{key}"](' in query
    for key, value in SURROUNDINGS_TAGS:
        assert in_surroundings({key: value})
        assert not in_surroundings({key: "other"})
        assert re.search(rf'way\["{key}"~"\^\((\w+\|)*{value}(\|\w+)*\)\$"\]', query)
    assert len(query) < 4000


@pytest.mark.parametrize(
    ("box", "near"),
    [
        ((7.0, 0.0, 7.1, 0.1), "way(r.areas)(-0.0089932,6.9910068,0.1089932,7.1089932);"),
        ((-179.999, 60.0, 0.0, 89.999), "way(r.areas)(59.9910068,-180,90,"),
        ((7.0, -60.1, 7.1, -60.0), "way(r.areas)(-60.1089932,6.981"),
    ],
)
def test_outlines_are_asked_for_a_kilometre_around(box: Box, near: str) -> None:
    assert near in area_query(box, surroundings=True)
    assert near in count_query(box, surroundings=True)

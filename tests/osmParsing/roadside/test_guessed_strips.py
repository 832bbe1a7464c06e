from __future__ import annotations

from pathlib import Path

import pytest
from osm_builder import Area, about

import osm2xodr
from osm2xodr.model import LaneType, MarginSpec
from osm2xodr.osmParsing import ParseOptions

WALK = MarginSpec(LaneType.SIDEWALK, 2.0, height=0.12)
STREET = {1: (0.0, 0.0), 2: (100.0, 0.0), 3: (200.0, 0.0)}
TOWN = "highway=tertiary maxspeed=50"


def sidewalks(folder: Path, area: Area, way: int = 20) -> list[tuple[bool, bool]]:
    """Return whether each piece of a way has a guessed sidewalk left and right, seen along the way."""
    network, diagnostics = area.parse(folder, ParseOptions(default_speeds=False))
    found = []
    for street in network.streets:
        for _, piece in street.pieces:
            if piece.osm_way_id == way:
                sides = [WALK in margin for margin in (piece.margin_left, piece.margin_right)]
                found.append((sides[piece.reversed], sides[not piece.reversed]))
    told = [item.osm_id for item in about(diagnostics, "sidewalk")]
    assert (f"way/{way}" in told) == any(map(any, found))
    return found


def beside(folder: Path, y: float, tags: str, own: str = TOWN) -> list[tuple[bool, bool]]:
    """Return the sidewalks of a straight street with another way beside it."""
    nodes = {**STREET, 4: (0.0, y), 5: (200.0, y)}
    return sidewalks(folder, Area(nodes, {20: ([1, 2, 3], own), 30: ([4, 5], tags)}))


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        (TOWN, (True, True)),
        ("highway=residential maxspeed=30", (True, True)),
        # 200 m of residential streets in 9 hectares are a town by themselves.
        ("highway=residential", (True, True)),
        ("highway=unclassified", (False, False)),
        ("highway=unclassified lit=yes", (True, True)),
        ("highway=primary maxspeed=100", (False, False)),
        ("highway=primary_link maxspeed=50", (False, False)),
        ("highway=service maxspeed=30", (False, False)),
        ("highway=living_street", (False, False)),
        (f"{TOWN} sidewalk=no", (False, False)),
        (f"{TOWN} sidewalk=separate", (False, False)),
        (f"{TOWN} sidewalk:left=no", (False, False)),
        (f"{TOWN} foot=no", (False, False)),
        (f"{TOWN} tunnel=yes", (False, False)),
        (f"{TOWN} bridge=yes layer=1", (True, True)),
        (f"{TOWN} shoulder=right", (True, False)),
    ],
)
def test_tags_decide(tmp_path: Path, tags: str, expected: tuple[bool, bool]) -> None:
    assert sidewalks(tmp_path, Area(STREET, {20: ([1, 2, 3], tags)})) == [expected]


def test_they_lie_outside_of_other_strips(tmp_path: Path) -> None:
    network, _ = Area(STREET, {20: ([1, 2, 3], f"{TOWN} parking:right=lane kerb:right=lowered")}).parse(
        tmp_path, ParseOptions(default_speeds=False)
    )
    (piece,) = [piece for street in network.streets for _, piece in street.pieces]
    assert [strip.type for strip in piece.margin_right] == [LaneType.PARKING, LaneType.SIDEWALK]
    assert piece.margin_right[-1].height == pytest.approx(0.03)
    assert piece.margin_left == (WALK,)


@pytest.mark.parametrize(
    ("y", "tags", "expected"),
    [
        # The carriageway's edge lies about 3 m from its middle. A footway mapped apart is that side's sidewalk.
        (14.0, "highway=footway", (False, True)),
        (-14.0, "highway=footway", (True, False)),
        (25.0, "highway=footway", (True, True)),
        # Another street: no room, little room, room for both.
        (6.5, "highway=service", (False, True)),
        (-6.5, "highway=service", (True, False)),
        (15.0, "highway=service", (True, True)),
    ],
)
def test_what_runs_beside_rules_them_out(tmp_path: Path, y: float, tags: str, expected: tuple[bool, bool]) -> None:
    assert beside(tmp_path, y, tags) == [expected]


@pytest.mark.parametrize(("name", "expected"), [("Ring", (False, True)), ("Park", (True, True))])
def test_none_lies_between_the_carriageways_of_one_street(
    tmp_path: Path, name: str, expected: tuple[bool, bool]
) -> None:
    other = f"{TOWN} oneway=-1 name={name}"
    assert beside(tmp_path, 20.0, other, f"{TOWN} oneway=yes name=Ring") == [expected]


def test_a_crossing_street_rules_nothing_out(tmp_path: Path) -> None:
    nodes = {**STREET, 4: (100.0, 60.0)}
    area = Area(nodes, {20: ([1, 2, 3], TOWN), 30: ([2, 4], TOWN)})
    assert sidewalks(tmp_path, area) == [(True, True), (True, True)]


def test_a_footway_along_a_part_speaks_for_the_rest(tmp_path: Path) -> None:
    nodes = {**STREET, 4: (0.0, 6.0), 5: (100.0, 6.0)}
    area = Area(nodes, {20: ([1, 2, 3], TOWN), 30: ([4, 5], "highway=footway footway=sidewalk")})
    network, diagnostics = area.parse(tmp_path, ParseOptions(default_speeds=False))
    right = [piece.margin_right for street in network.streets for _, piece in street.pieces]
    assert set(right) == {()}
    assert about(diagnostics, "sidewalk") == []


def test_they_are_left_out_on_request(tmp_path: Path) -> None:
    path = Area(STREET, {20: ([1, 2, 3], TOWN)}).write(tmp_path)
    counts = []
    for left_out in (False, True):
        output = tmp_path / f"{left_out}.xodr"
        osm2xodr.convert(path, output=output, no_guessed_sidewalks=left_out)
        counts.append(output.read_text().count('type="sidewalk"'))
    assert counts == [2, 0]

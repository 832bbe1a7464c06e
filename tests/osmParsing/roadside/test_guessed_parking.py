"""Parking along a straight street of 200 m from west to east whose tags say nothing of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest
from osm_builder import Area, about

import osm2xodr
from osm2xodr.model import LaneType, MarginSpec
from osm2xodr.osmParsing import ParseOptions

PARKED = MarginSpec(LaneType.PARKING, 2.0)
STREET = {1: (0.0, 0.0), 2: (100.0, 0.0), 3: (200.0, 0.0)}
OWN = "highway=residential name=A"

Ways = Mapping[int, tuple[Sequence[int], str]]
Nodes = dict[int, tuple[float, float]]


def houses(front: float, number: int = 10, apart: float = 0.0, first: int = 1000) -> tuple[Nodes, Ways]:
    """Return houses of 20 m along the street, so far apart, m; `front` is the t of their fronts, m."""
    back = front + (10.0 if front > 0.0 else -10.0)
    nodes: Nodes = {}
    ways = {}
    for k in range(number):
        start = 20.0 * k
        places = [(start, front), (start + 20.0 - apart, front), (start + 20.0 - apart, back), (start, back)]
        ids = []
        for place in places:
            found = next((node for node, other in nodes.items() if other == place), first + len(nodes))
            nodes[found] = place
            ids.append(found)
        ways[first + k] = [*ids, ids[0]], "building=apartments"
    return nodes, ways


def both_rows(north: float, south: float, number: int = 10, apart: float = 0.0) -> tuple[Nodes, Ways]:
    one, other = houses(north, number, apart), houses(-south, number, apart, first=2000)
    return {**one[0], **other[0]}, {**one[1], **other[1]}


def parks(folder: Path, around: tuple[Nodes, Ways]) -> bool:
    """Return whether cars are taken to park on both sides of the street, not on one."""
    nodes, ways = around
    area = Area({**STREET, **nodes}, {20: ([1, 2, 3], OWN), **ways})
    network, diagnostics = area.parse(folder, ParseOptions(default_speeds=False, guessed_sidewalks=False))
    pieces = {piece for street in network.streets for _, piece in street.pieces if piece.osm_way_id == 20}
    found = {(piece.margin_left, piece.margin_right) for piece in pieces}
    told = [item.osm_id for item in about(diagnostics, "parking")]
    assert found in ({((PARKED,), (PARKED,))}, {((), ())})
    assert ("way/20" in told) == (found == {((PARKED,), (PARKED,))})
    # Lanes are as without, in the middle.
    assert {sum(lane.width for lane in piece.lanes_ltr) for piece in pieces} == {6.0}
    assert {piece.middle_offset for piece in pieces} == {0.0}
    return found != {((), ())}


@pytest.mark.parametrize(
    ("north", "south", "expected"),
    [
        # Two lanes of 3 m, two rows of cars of 2 m and two sidewalks of 2 m need 14 m.
        (7.0, 7.0, True),
        (9.0, 5.2, True),
        (6.8, 6.8, False),
        (15.0, 15.0, True),
        # Behind gardens, or on one side alone.
        (17.0, 7.0, False),
    ],
)
def test_rows_of_houses_leave_room(tmp_path: Path, north: float, south: float, expected: bool) -> None:
    assert parks(tmp_path, both_rows(north, south)) is expected


@pytest.mark.parametrize(
    ("number", "apart", "expected"),
    [(10, 0.0, True), (10, 6.0, False), (4, 0.0, True), (3, 0.0, False)],
)
def test_houses_stand_wall_to_wall(tmp_path: Path, number: int, apart: float, expected: bool) -> None:
    assert parks(tmp_path, both_rows(8.0, 8.0, number, apart)) is expected


def test_one_side_is_not_enough(tmp_path: Path) -> None:
    assert not parks(tmp_path, houses(8.0))


@pytest.mark.parametrize(
    ("own", "expected"),
    [
        ("highway=residential oneway=yes", True),
        ("highway=tertiary maxspeed=50", True),
        ("highway=tertiary maxspeed=100", False),
        ("highway=living_street", False),
        ("highway=service", False),
        ("highway=residential lanes=4", False),
        ("highway=residential oneway=yes lanes=2", False),
        ("highway=residential parking:both=no", False),
        ("highway=residential parking:lane:both=no_parking", False),
        ("highway=residential width=6", False),
        ("highway=residential shoulder=no", False),
        ("highway=residential cycleway=no", True),
        ("highway=residential bridge=yes layer=1", False),
        ("highway=residential turn:lanes:forward=left|right lanes=3", False),
    ],
)
def test_tags_decide(tmp_path: Path, own: str, expected: bool) -> None:
    nodes, ways = both_rows(9.0, 9.0)
    area = Area({**STREET, **nodes}, {20: ([1, 2, 3], own), **ways})
    network, _ = area.parse(tmp_path, ParseOptions(default_speeds=False, guessed_sidewalks=False))
    pieces = [piece for street in network.streets for _, piece in street.pieces]
    assert {PARKED in piece.margin_left and PARKED in piece.margin_right for piece in pieces} == {expected}


def other(tags: str, own: str = "name=A", y: float = 0.0) -> tuple[Nodes, Ways]:
    """Return another street with tags: behind this one, or beside it at y, m."""
    nodes = {4: (400.0, 0.0)} if not y else {4: (0.0, y), 5: (250.0, y)}
    return nodes, {30: ([3, 4] if not y else [4, 5], f"highway=residential {own} {tags}")}


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        ("parking:both=lane", True),
        ("parking:lane:both=parallel", True),
        # Rather one row than two.
        ("parking:right=lane parking:left=no", False),
        ("parking:both=street_side", False),
        ("parking:both=no", False),
    ],
)
@pytest.mark.parametrize(("own", "y"), [("name=A", 0.0), ("name=B", 100.0)])
def test_the_same_street_and_those_around_tell_it(
    tmp_path: Path, own: str, y: float, tags: str, expected: bool
) -> None:
    assert parks(tmp_path, other(tags, own, y)) is expected


def test_tags_come_before_fronts_and_the_same_street_first(tmp_path: Path) -> None:
    nodes, ways = both_rows(9.0, 9.0)
    assert not parks(tmp_path, ({**nodes, **other("parking:both=no")[0]}, {**ways, **other("parking:both=no")[1]}))
    same, around = other("parking:both=lane"), other("parking:both=no", "name=B", 100.0)
    away = {6: (0.0, 100.0), 7: (250.0, 100.0)}
    assert parks(tmp_path, ({**same[0], **away}, {**same[1], 31: ([6, 7], around[1][30][1])}))


@pytest.mark.parametrize(("y", "expected"), [(15.0, False), (25.0, True)])
def test_nobody_parks_between_carriageways(tmp_path: Path, y: float, expected: bool) -> None:
    nodes, ways = other("parking:both=lane")
    opposite = {6: (200.0, y), 7: (0.0, y)}
    assert parks(tmp_path, ({**nodes, **opposite}, {**ways, 40: ([6, 7], "highway=tertiary oneway=yes")})) is expected


def test_streets_far_away_or_of_another_class_tell_nothing(tmp_path: Path) -> None:
    assert parks(tmp_path, other("parking:both=lane", "name=A", 900.0))
    # As in the next town.
    assert not parks(tmp_path, other("parking:both=lane", "name=A", 1100.0))
    assert not parks(tmp_path, other("parking:both=lane", "name=B", 320.0))
    assert parks(tmp_path, other("parking:both=lane", "", 100.0))
    nodes, ways = other("parking:both=lane", "name=B", 100.0)
    tertiary = {30: (ways[30][0], ways[30][1].replace("residential", "tertiary"))}
    assert not parks(tmp_path, (nodes, tertiary))


@pytest.mark.parametrize(("y", "expected"), [(5.5, False), (6.5, True)])
def test_sidewalks_mapped_apart_leave_room_or_not(tmp_path: Path, y: float, expected: bool) -> None:
    nodes, ways = other("parking:both=lane")
    walks = {6: (0.0, y), 7: (200.0, y), 8: (0.0, -y), 9: (200.0, -y)}
    footway = "highway=footway footway=sidewalk"
    area = Area(
        {**STREET, **nodes, **walks}, {20: ([1, 2, 3], OWN), **ways, 40: ([6, 7], footway), 41: ([8, 9], footway)}
    )
    network, _ = area.parse(tmp_path, ParseOptions(default_speeds=False, guessed_sidewalks=False))
    pieces = [piece for street in network.streets for _, piece in street.pieces if piece.osm_way_id == 20]
    assert {PARKED in piece.margin_left for piece in pieces} == {expected}


def test_it_is_left_out_on_request(tmp_path: Path) -> None:
    nodes, ways = both_rows(8.0, 8.0)
    path = Area({**STREET, **nodes}, {20: ([1, 2, 3], OWN), **ways}).write(tmp_path)
    counts = []
    for left_out in (False, True):
        output = tmp_path / f"{left_out}.xodr"
        osm2xodr.convert(path, output=output, no_guessed_parking=left_out)
        counts.append(output.read_text().count('type="parking"'))
    assert counts == [2, 0]

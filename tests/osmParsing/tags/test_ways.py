"""What single tags of a way become, beside its lanes."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from lane_notation import notation
from osm_builder import ROAD, ROW, Area, nodes_of, tags_of

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import Rule, StreetAttributes, Structure, WayCorrection
from osm2xodr.osmParsing.file.access import RawWay
from osm2xodr.osmParsing.tags.ways import way_attributes


def read(tags: str) -> tuple[StreetAttributes, int, list[tuple[Kind, str, str]]]:
    diagnostics = Diagnostics()
    values = tags_of(f"highway=residential lanes=2 width=6 {tags}")
    ((attributes,), (direction,)) = way_attributes([RawWay(1, [1, 2], values)], Rule.RIGHT_HAND, None, diagnostics)
    return attributes, direction, [(item.kind, item.code, item.message) for item in diagnostics]


@pytest.mark.parametrize(
    ("tags", "kmh"),
    [
        ("source:maxspeed=DE:urban", 50.0),
        ("maxspeed:type=RO:rural", 90.0),
        ("maxspeed:type=AT:zone:30", 30.0),
        ("zone:maxspeed=DE:30", 30.0),
        ("source:maxspeed=DE:zone30", 30.0),
        ("zone:traffic=DE:rural", 100.0),
        ("maxspeed:type=GB:nsl_single", 60 * 1.609344),
        # The number itself counts before the law, the kind of limit before the zone.
        ("maxspeed=70 source:maxspeed=DE:urban", 70.0),
        ("maxspeed:type=DE:rural source:maxspeed=DE:urban", 100.0),
        ("source:maxspeed=sign zone:traffic=DE:urban", 50.0),
        # Not what it is, only where it was read.
        ("source:maxspeed=sign", None),
        ("source:maxspeed=survey", None),
        ("source:maxspeed=https://example.org", None),
        ("maxspeed:type=sign", None),
        # A zone says nothing about streets with walking speed or motorways in it.
        ("highway=living_street zone:traffic=DE:urban", None),
        ("highway=motorway zone:traffic=DE:rural", None),
        ("highway=motorway source:maxspeed=DE:motorway", math.inf),
    ],
)
def test_limits_that_the_law_sets(tags: str, kmh: float | None) -> None:
    attributes, _, said = read(tags)
    for speed in (attributes.speed_forward, attributes.speed_backward):
        assert speed == (None if kmh is None else pytest.approx(kmh / 3.6))
    assert [item for item in said if item[1] == "speed"] == []


def test_a_limit_of_one_direction_goes_before_the_law() -> None:
    attributes, _, _ = read("source:maxspeed=DE:urban maxspeed:forward=30")
    assert [attributes.speed_forward, attributes.speed_backward] == pytest.approx([30 / 3.6, 50 / 3.6])


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        ("", False),
        ("priority_road=designated", True),
        ("priority_road=yes_unposted", True),
        ("priority_road=end", False),
        ("priority_road=no", False),
    ],
)
def test_priority_roads(tags: str, expected: bool) -> None:
    assert read(tags)[0].priority_road is expected


@pytest.mark.parametrize(
    "tag", ["maxspeed:conditional=30@(22:00-06:00)", "oneway:conditional=yes@(Mo)", "access:conditional=no@(Su)"]
)
def test_what_holds_at_times_only_is_told(tag: str) -> None:
    attributes, direction, said = read(tag)
    assert said == [(Kind.DROPPED, "conditional", f"{tag} holds at certain times only and is not carried")]
    assert (attributes.speed_forward, direction) == (None, 0)


@pytest.mark.parametrize(
    ("tags", "direction", "lanes"),
    [
        ("lanes=1 motor_vehicle:backward=no", 1, "^"),
        ("lanes=1 motor_vehicle:forward=no", -1, "v"),
        ("lanes=2 motorcar:backward=no", 1, "cv ^"),
        ("lanes=2 vehicle:backward=no bus:backward=yes", 1, "bv ^"),
        ("lanes=2 motor_vehicle:backward=destination", 0, "v ^"),
        # One-ways need no closing.
        ("lanes=2 oneway=yes motor_vehicle:backward=no", 1, "^ ^"),
    ],
)
def test_a_direction_that_is_closed_to_cars(tags: str, direction: int, lanes: str) -> None:
    attributes, runs, said = read(tags)
    assert runs == direction
    assert notation(attributes.lanes_ltr) == lanes
    told = [words for kind, code, words in said if (kind, code) == (Kind.NOTE, "oneway")]
    closed = direction and "oneway=yes" not in tags
    key = next(item for item in tags.split() if "ward=" in item and "bus" not in item)
    assert told == ([f"{key} closes one direction to cars, for them it is one-way"] if closed else [])


def test_attributes_of_a_way(tmp_path: Path) -> None:
    tags = (
        "highway=secondary name=Main ref=B3 lanes=3 lanes:backward=2 width:lanes:forward=4 width:lanes:backward=2|3 "
        "placement:forward=left_of:1 maxspeed=50 maxspeed:backward=30 bridge=yes incline=8% "
        "turn:lanes:backward=left|right"
    )
    network, diagnostics = Area(ROW, {20: ([1, 2], tags)}).parse(tmp_path)
    ((_, piece),) = network.streets[0].pieces
    assert (piece.osm_way_id, piece.reversed, piece.highway, piece.name, piece.ref) == (
        20,
        False,
        "secondary",
        "Main",
        "B3",
    )
    assert [(int(lane.direction), lane.width, sorted(lane.turns)) for lane in piece.lanes_ltr] == [
        (-1, 3.0, ["right"]),
        (-1, 2.0, ["left"]),
        (1, 4.0, []),
    ]
    assert piece.middle_offset == pytest.approx(5.0 - 4.5)
    assert [piece.speed_forward, piece.speed_backward] == pytest.approx([50 / 3.6, 30 / 3.6])
    assert (piece.structure, piece.layer, piece.roundabout) == (Structure.BRIDGE, 1, False)
    assert piece.grade == pytest.approx(0.08)
    assert list(diagnostics) == []


def test_attributes_turn_with_the_street(tmp_path: Path) -> None:
    tags = (
        "highway=secondary oneway=-1 lanes=2 width:lanes=3|4 placement=left_of:1 maxspeed:forward=30 "
        "maxspeed:backward=60 tunnel=yes incline=-8% turn:lanes=left|right"
    )
    network, _ = Area(ROW, {20: ([1, 2], tags)}).parse(tmp_path)
    ((_, piece),) = network.streets[0].pieces
    assert nodes_of(network) == [[2, 1]]
    assert piece.reversed
    # As drivers see them, and as they stand along the street.
    assert [(int(lane.direction), lane.width, sorted(lane.turns)) for lane in piece.lanes_ltr] == [
        (1, 3.0, ["left"]),
        (1, 4.0, ["right"]),
    ]
    assert piece.middle_offset == pytest.approx(-3.5)
    assert [piece.speed_forward, piece.speed_backward] == pytest.approx([60 / 3.6, 30 / 3.6])
    assert (piece.structure, piece.layer) == (Structure.TUNNEL, -1)
    assert piece.grade == pytest.approx(0.08)


@pytest.mark.parametrize(
    ("tags", "code", "kind"),
    [
        ("maxspeed=signals", "speed", Kind.DROPPED),
        ("maxspeed=fast", "speed", Kind.DROPPED),
        ("layer=high", "layer", Kind.DROPPED),
        ("layer=-1;0", "layer", Kind.GUESSED),
        ("incline=steep", "incline", Kind.DROPPED),
        ("oneway=alternating", "oneway", Kind.GUESSED),
        ("oneway=perhaps", "oneway", Kind.DROPPED),
        ("motor_vehicle:backward=no width=4", "oneway", Kind.NOTE),
    ],
)
def test_what_tags_leave_open_is_said(tmp_path: Path, tags: str, code: str, kind: Kind) -> None:
    _, diagnostics = Area(ROW, {20: ([1, 2], f"{ROAD} {tags}")}).parse(tmp_path)
    assert [(item.kind, item.code, item.osm_id) for item in diagnostics] == [(kind, code, "way/20")]


@pytest.mark.parametrize("tags", ["incline=up", "incline=down", "maxspeed=none", "oneway=no"])
def test_what_needs_no_word(tmp_path: Path, tags: str) -> None:
    network, diagnostics = Area(ROW, {20: ([1, 2], f"{ROAD} {tags}")}).parse(tmp_path)
    assert list(diagnostics) == []
    ((_, piece),) = network.streets[0].pieces
    assert piece.grade is None
    assert piece.speed_forward == (math.inf if "none" in tags else None)


def test_ways_with_the_same_tags_differ_in_id_name_number_and_corrections() -> None:
    tags = "highway=residential lanes=2 width=6 lane_markings=perhaps"
    names = ["name=A", "name=B ref=1", "name=A", ""]
    ways = [RawWay(number, [1, 2], tags_of(f"{tags} {name}")) for number, name in enumerate(names, 5)]
    corrections = {7: WayCorrection(lane_width={1: 4.0, 2: 3.5}, clearance=5.0)}
    diagnostics = Diagnostics()
    found, _ = way_attributes(ways, Rule.RIGHT_HAND, None, diagnostics, corrections=corrections)
    assert [(item.osm_way_id, item.name, item.ref) for item in found] == [
        (5, "A", ""),
        (6, "B", "1"),
        (7, "A", ""),
        (8, "", ""),
    ]
    widths = [[lane.width for lane in item.lanes_ltr] for item in found]
    assert widths == [[3.0, 3.0], [3.0, 3.0], [4.0, 3.5], [3.0, 3.0]]
    assert [item.clearance for item in found] == [None, None, 5.0, None]
    said = [item.osm_id for item in diagnostics if item.code == "lane-markings"]
    assert said == ["way/5", "way/6", "way/7", "way/8"]

"""Overtaking, changing lanes, marks, rails, signs: what tags of ways say about them."""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import quoteattr

import pytest
from lane_notation import section_of
from osm_builder import ROAD, ROW, Area, about, tags_of, write_osm

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import Direction, Rule, StreetAttributes, Structure
from osm2xodr.osmParsing import ParseOptions, parse_osm
from osm2xodr.osmParsing.file.access import RawWay
from osm2xodr.osmParsing.tags.ways import turned_round, way_attributes

FORWARD, BACKWARD = Direction.FORWARD, Direction.BACKWARD


def read(tags: str) -> tuple[StreetAttributes, list[tuple[Kind, str]]]:
    diagnostics = Diagnostics()
    values = tags_of(f"highway=secondary {tags}")
    ((attributes,), _) = way_attributes([RawWay(1, [1, 2], values)], Rule.RIGHT_HAND, None, diagnostics)
    return attributes, [
        (item.kind, item.code) for item in diagnostics if item.code not in ("lane-width", "lane-count")
    ]


@pytest.mark.parametrize(
    ("tags", "forbidden"),
    [
        ("", ()),
        ("overtaking=no", (FORWARD, BACKWARD)),
        ("overtaking=yes", ()),
        ("overtaking=both", ()),
        ("overtaking=caution", ()),
        ("overtaking=forward", (BACKWARD,)),
        ("overtaking=backward", (FORWARD,)),
        ("overtaking:forward=no", (FORWARD,)),
        ("overtaking:backward=no", (BACKWARD,)),
        ("overtaking:forward=no overtaking:backward=no", (FORWARD, BACKWARD)),
        ("overtaking=no overtaking:forward=yes", (BACKWARD,)),
        ("overtaking=yes overtaking:backward=no", (BACKWARD,)),
        ("overtaking=forward overtaking:forward=caution", (BACKWARD,)),
        ("oneway=yes overtaking=no", (FORWARD,)),
        ("oneway=-1 overtaking=no", (BACKWARD,)),
        ("oneway=yes overtaking:backward=no", ()),
        ("overtaking:hgv=no", ()),
    ],
)
def test_overtaking(tags: str, forbidden: tuple[Direction, ...]) -> None:
    attributes, said = read(tags)
    assert attributes.no_overtaking == frozenset(forbidden)
    assert said == []
    assert turned_round(attributes).no_overtaking == frozenset(Direction(-way) for way in forbidden)


@pytest.mark.parametrize("tags", ["overtaking=sometimes", "overtaking:forward=backward", "overtaking:backward=1"])
def test_overtaking_that_is_not_known(tags: str) -> None:
    attributes, said = read(tags)
    assert attributes.no_overtaking == frozenset()
    assert said == [(Kind.DROPPED, "overtaking")]


@pytest.mark.parametrize(
    ("tags", "right", "left"),
    [
        # From left to right along the way; each lane as its own drivers see it.
        ("lanes=2", ["", ""], ["", ""]),
        ("oneway=yes lanes=3 change:lanes=yes|not_right|no", ["yes", "not_right", "no"], ["yes", "not_right", "no"]),
        ("oneway=-1 lanes=3 change:lanes=yes|not_right|no", ["no", "not_right", "yes"], ["no", "not_right", "yes"]),
        ("oneway=yes change:lanes=only_left|only_right", ["only_left", "only_right"], ["only_left", "only_right"]),
        ("oneway=yes lanes=2 change:lanes:forward=no|yes", ["no", "yes"], ["no", "yes"]),
        ("oneway=yes lanes=2 change:lanes=|no", ["", "no"], ["", "no"]),
        ("oneway=yes lanes=2 change:lanes=none|no", ["", "no"], ["", "no"]),
        ("oneway=yes lanes=2 change:lanes=perhaps|no", ["", "no"], ["", "no"]),
        ("oneway=yes lanes=3 change:lanes=yes|no", ["", "", ""], ["", "", ""]),
        ("oneway=yes lanes=2 change=no", ["no", "no"], ["no", "no"]),
        ("oneway=yes lanes=2 change=no change:forward=yes", ["yes", "yes"], ["yes", "yes"]),
        ("oneway=yes lanes=2 change=no change:lanes=yes|not_left", ["yes", "not_left"], ["yes", "not_left"]),
        ("oneway=yes lanes=2 change=maybe", ["", ""], ["", ""]),
        # Two ways: v v ^ ^ with right-hand traffic, ^ ^ v v with left-hand traffic.
        (
            "lanes=4 change:lanes:forward=not_right|yes change:lanes:backward=no|not_left",
            ["not_left", "no", "not_right", "yes"],
            ["not_right", "yes", "not_left", "no"],
        ),
        ("lanes=4 change=no", ["no"] * 4, ["no"] * 4),
        ("lanes=4 change:forward=no", ["", "", "no", "no"], ["no", "no", "", ""]),
        ("lanes=4 change:backward=no change=yes", ["no", "no", "yes", "yes"], ["yes", "yes", "no", "no"]),
        ("lanes=4 change:lanes=yes|no|no|yes", [""] * 4, [""] * 4),
        (
            "lanes=3 lanes:forward=1 lanes:backward=1 lanes:both_ways=1 change:both_ways=no",
            ["", "no", ""],
            ["", "no", ""],
        ),
        # A list that leaves out the lane for bicycles is about those for cars.
        (
            "oneway=yes lanes=2 change:lanes=no|not_left access:lanes=yes|no|yes bicycle:lanes=yes|designated|yes",
            ["no", "", "not_left"],
            ["no", "", "not_left"],
        ),
    ],
)
def test_changing_lanes(tags: str, right: list[str], left: list[str]) -> None:
    assert [lane.change for lane in section_of(tags, Rule.RIGHT_HAND).lanes_ltr] == right
    assert [lane.change for lane in section_of(tags, Rule.LEFT_HAND).lanes_ltr] == left


@pytest.mark.parametrize(
    ("tags", "code"),
    [
        ("oneway=yes lanes=2 change:lanes=perhaps|no", "change"),
        ("oneway=yes lanes=2 change=maybe", "change"),
        ("oneway=yes lanes=3 change:lanes=yes|no", "lane-lists"),
        ("lanes=4 change:lanes=yes|no|no|yes", "lane-lists"),
    ],
)
def test_changes_that_are_not_known(tags: str, code: str) -> None:
    assert read(tags)[1] == [(Kind.DROPPED, code)]


def test_drivers_see_their_lanes_the_same_from_either_side() -> None:
    attributes, _ = read("oneway=yes lanes=2 change:lanes=not_right|not_left")
    turned = turned_round(attributes)
    assert [lane.change for lane in turned.lanes_ltr] == ["not_left", "not_right"]


@pytest.mark.parametrize(
    ("tags", "marked", "said"),
    [
        ("", None, []),
        ("lane_markings=yes", True, []),
        ("lane_markings=no", False, []),
        ("lane_markings=faded", None, [(Kind.DROPPED, "lane-markings")]),
    ],
)
def test_lane_markings(tags: str, marked: bool | None, said: list[tuple[Kind, str]]) -> None:
    attributes, found = read(tags)
    assert (attributes.marked, found) == (marked, said)
    assert turned_round(attributes).marked is marked


@pytest.mark.parametrize(
    ("tags", "tram"),
    [
        ("", False),
        ("embedded_rails=tram", True),
        ("embedded_rails=tram;subway", True),
        ("embedded_rails=yes", True),
        ("embedded_rails=no", False),
        ("embedded_rails=disused", False),
        ("railway=tram", True),
        ("railway=light_rail", True),
        ("railway=abandoned", False),
        ("railway=rail", False),
    ],
)
def test_tram_tracks_in_the_street(tags: str, tram: bool) -> None:
    attributes, _ = read(tags)
    assert attributes.tram is tram
    assert turned_round(attributes).tram is tram


@pytest.mark.parametrize(
    ("divider", "turned"),
    [
        ("", ""),
        ("solid_line", "solid_line"),
        ("dashed_line;solid_line", "solid_line;dashed_line"),
        ("solid_line_left", "solid_line_right"),
        ("forward", "backward"),
    ],
)
def test_dividers(divider: str, turned: str) -> None:
    attributes, _ = read(f"divider={divider}" if divider else "")
    assert attributes.divider == divider
    assert turned_round(attributes).divider == turned
    assert turned_round(turned_round(attributes)) == attributes


def test_values_that_are_kept_as_they_are() -> None:
    attributes, said = read("surface=sett traffic_sign=DE:274-30,1040")
    assert (attributes.surface, attributes.traffic_sign, said) == ("sett", "DE:274-30,1040", [])
    turned = turned_round(attributes)
    assert (turned.surface, turned.traffic_sign) == ("sett", "DE:274-30,1040")
    bare, _ = read("")
    assert (bare.surface, bare.traffic_sign, bare.divider) == ("", "", "")


@pytest.mark.parametrize(
    ("tags", "signed"),
    [
        ("", False),
        ("maxspeed=50", True),
        ("maxspeed=30_mph", False),
        ("maxspeed=none", True),
        ("maxspeed:forward=70", True),
        ("maxspeed=30 source:maxspeed=sign", True),
        ("maxspeed=30 source:maxspeed=DE:zone30", True),
        ("maxspeed=30 maxspeed:type=DE:zone:30", True),
        ("maxspeed=50 source:maxspeed=survey;guess", True),
        # The law says it.
        ("maxspeed=50 source:maxspeed=DE:urban", False),
        ("maxspeed=100 maxspeed:type=AT:rural", False),
        ("maxspeed=DE:urban", False),
        ("source:maxspeed=DE:urban", False),
        ("maxspeed=walk", False),
        ("maxspeed=fast", False),
    ],
)
def test_limits_that_stand_on_signs(tags: str, signed: bool) -> None:
    attributes, _ = read(tags)
    assert attributes.speed_signed is signed
    assert turned_round(attributes).speed_signed is signed


def test_what_ways_say_arrives_at_streets(tmp_path: Path) -> None:
    """One street of two ways that are drawn against each other."""
    nodes = {1: (0.0, 0.0), 2: (80.0, 0.0), 3: (160.0, 0.0)}
    tags = "highway=tertiary lanes=2 overtaking={} sidewalk={} surface=asphalt lane_markings=no"
    area = Area(nodes, {20: ([1, 2], tags.format("forward", "left")), 21: ([3, 2], tags.format("backward", "right"))})
    network, _ = area.parse(tmp_path)
    (street,) = network.streets
    (_, one), (_, other) = street.pieces
    assert (one.reversed, other.reversed) == (False, True)
    assert one.no_overtaking == other.no_overtaking == frozenset({BACKWARD})
    assert one.margin_left == other.margin_left != ()
    assert one.margin_right == other.margin_right == ()
    assert (one.surface, other.surface, one.marked, other.marked) == ("asphalt", "asphalt", False, False)


@pytest.mark.parametrize(
    ("text", "height"),
    [("4", 4.0), ("3.6 m", 3.6), ("12'6\"", 3.81), ("default", None), ("none", None), ("25", None), ("high", None)],
)
def test_max_height(tmp_path: Path, text: str, height: float | None) -> None:
    area = Area(ROW, {20: ([1, 2], ROAD)})
    path = write_osm(
        tmp_path,
        [line.replace("</way>", f"<tag k='maxheight' v={quoteattr(text)}/></way>") for line in area.elements()],
    )
    diagnostics = Diagnostics()
    network = parse_osm(path, ParseOptions(), diagnostics)
    ((_, attributes),) = network.streets[0].pieces
    assert attributes.max_height == (None if height is None else pytest.approx(height))
    assert len(about(diagnostics, "max-height")) == (text in ("25", "high"))


@pytest.mark.parametrize(
    ("tags", "structure", "layer"),
    [
        ("", Structure.GROUND, 0),
        ("bridge=yes", Structure.BRIDGE, 1),
        ("bridge=viaduct layer=2", Structure.BRIDGE, 2),
        ("bridge=no", Structure.GROUND, 0),
        ("tunnel=yes", Structure.TUNNEL, -1),
        ("tunnel=yes layer=-3", Structure.TUNNEL, -3),
        ("tunnel=no", Structure.GROUND, 0),
        ("tunnel=building_passage", Structure.GROUND, 0),
        ("tunnel=avalanche_protector", Structure.GROUND, 0),
        ("covered=yes layer=-1", Structure.GROUND, -1),
        ("bridge=yes layer=0", Structure.BRIDGE, 0),
        ("tunnel=yes layer=-1;0", Structure.TUNNEL, -1),
        ("bridge=yes layer=high", Structure.BRIDGE, 1),
    ],
)
def test_structures(tmp_path: Path, tags: str, structure: Structure, layer: int) -> None:
    network, _ = Area(ROW, {20: ([1, 2], f"{ROAD} {tags}")}).parse(tmp_path)
    ((_, piece),) = network.streets[0].pieces
    assert (piece.structure, piece.layer) == (structure, layer)

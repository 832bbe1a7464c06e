"""What tags of nodes on streets and of things beside them say."""

from __future__ import annotations

import pytest

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import BusStop, Facing, Light, NodeControl, RoadsideKind, Sign, ThingFacts
from osm2xodr.osmParsing.tags.node_facts import (
    node_heights,
    parse_ele,
    read_control,
    read_node_facts,
    read_thing_facts,
    turning_circles,
)


@pytest.mark.parametrize(
    ("tags", "sign"),
    [
        ({}, None),
        ({"highway": "crossing"}, None),
        ({"highway": "stop"}, Sign.STOP),
        ({"highway": "give_way"}, Sign.GIVE_WAY),
        ({"highway": "traffic_signals"}, Sign.SIGNALS),
        ({"highway": "traffic_signals", "traffic_signals": "signal"}, Sign.SIGNALS),
        ({"highway": "traffic_signals", "traffic_signals": "ramp_meter"}, None),
        ({"highway": "crossing", "crossing": "traffic_signals"}, Sign.SIGNALS),
        ({"highway": "stop", "crossing:signals": "yes"}, Sign.STOP),
    ],
)
def test_signs_of_nodes(tags: dict[str, str], sign: Sign | None) -> None:
    control = read_control(tags)
    assert (None if control is None else control.sign) is sign


def test_controls_of_nodes() -> None:
    assert read_control({"highway": "stop", "stop": "all", "direction": "backward"}) == NodeControl(
        Sign.STOP, None, Facing(along=False), all_way=True
    )
    tags = {"highway": "traffic_signals", "traffic_signals": "blinker", "traffic_signals:direction": "both"}
    assert read_control({**tags, "direction": "forward"}) == NodeControl(
        Sign.SIGNALS, Light.OTHER, Facing(both=True), light_value="blinker"
    )
    assert read_control({"crossing": "traffic_signals"}) == NodeControl(None, Light.CROSSING, crossing_lights=True)


def test_subjects_of_nodes() -> None:
    facts = read_node_facts(
        {
            1: {"traffic_calming": "humps"},
            2: {"traffic_calming": "no"},
            3: {"traffic_calming": "island", "crossing": "marked"},
            4: {"traffic_calming": "island"},
            5: {"highway": "bus_stop", "name": "Markt", "bay": "right", "direction": "forward"},
            6: {"railway": "tram_level_crossing"},
            7: {"railway": "switch"},
            8: {"traffic_sign:forward": "DE:274-30"},
        },
        (),
        "DE",
    )
    assert facts.calming == {1: "hump", 4: "island"}
    assert facts.bus_stops == {5: BusStop("Markt", bay=True, along=True)}
    assert facts.track_crossings == {6}
    assert list(facts.sign_posts) == [8]
    assert facts.controls == {}
    assert [item.node for item in facts.crossings] == [3]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *(("1.5", 1.5), ("1,5 m", 1.5), ("80 cm", 0.8), ("800 mm", 0.8), ("10'", 3.048)),
        *(("0", None), ("high", None), ("99", None)),
    ],
)
def test_heights(text: str, value: float | None) -> None:
    height = read_thing_facts(RoadsideKind.WALL, {"height": text}, "").height
    assert height == (None if value is None else pytest.approx(value))


@pytest.mark.parametrize(
    ("kind", "tags", "expected"),
    [
        (RoadsideKind.KERB, {"kerb": "flush", "height": "0.2"}, ThingFacts(height=0.0)),
        (RoadsideKind.KERB, {"height": "0.2", "width": "6"}, ThingFacts(height=0.2)),
        (RoadsideKind.TRAM_TRACK, {"gauge": "1000"}, ThingFacts(gauge=1.0)),
        (RoadsideKind.TRAM_TRACK, {"gauge": "1000;1435"}, ThingFacts()),
        (RoadsideKind.TRAM_TRACK, {"gauge": "99"}, ThingFacts()),
        (RoadsideKind.BUS_STOP, {"bus_bay": "yes"}, ThingFacts(bus_stop=BusStop(bay=True))),
        (RoadsideKind.TRAFFIC_SIGNALS, {"crossing": "marked"}, ThingFacts(at_crossing=True)),
    ],
    ids=str,
)
def test_things_beside_the_road(kind: RoadsideKind, tags: dict[str, str], expected: ThingFacts) -> None:
    assert read_thing_facts(kind, tags, "") == expected


@pytest.mark.parametrize("value", ["turning_circle", "turning_loop", "mini_roundabout"])
def test_these_nodes_are_circles(value: str) -> None:
    assert turning_circles({7: {"highway": value}}) == {7: None}


@pytest.mark.parametrize(
    ("text", "diameter"),
    [("18", 18.0), (" 18.5 m ", 18.5), ("60 ft", 18.288), ("60'", 18.288), ("wide", None), ("-3", None), ("", None)],
)
def test_diameters_are_metres_or_feet(text: str, diameter: float | None) -> None:
    (found,) = turning_circles({7: {"highway": "turning_circle", "diameter": text}}).values()
    assert found == pytest.approx(diameter)


def test_other_nodes_are_no_turning_circles_whatever_their_diameter() -> None:
    assert turning_circles({1: {"highway": "stop"}, 2: {"natural": "tree", "diameter": "0.9"}, 3: {}}) == {}


@pytest.mark.parametrize(
    ("text", "z"),
    [
        ("123", 123.0),
        (" 123.5 m", 123.5),
        ("-12", -12.0),
        ("100ft", 30.48),
        ("1000 feet", 304.8),
        ("123;125", None),
        ("ca. 120", None),
        ("12,5", None),
        ("9999", None),
        ("", None),
    ],
)
def test_values_of_ele(text: str, z: float | None) -> None:
    assert parse_ele(text) == (None if z is None else pytest.approx(z))


def test_heights_of_nodes_and_other_values_of_ele() -> None:
    diagnostics = Diagnostics()
    tags = {3: {"ele": "31"}, 2: {"ele": "20 m"}, 1: {"highway": "stop"}, 4: {"ele": "high"}}
    assert node_heights(tags, diagnostics) == {2: 20.0, 3: 31.0}
    assert [(item.kind, item.code, item.osm_id) for item in diagnostics] == [(Kind.DROPPED, "ele", "node/4")]

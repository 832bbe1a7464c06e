"""What tags of nodes on streets and of things beside them say.

What values of ``traffic_sign`` say.
"""

from __future__ import annotations

import pytest

from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.model import BusStop, Facing, Light, NodeControl, RoadsideKind, Sign, SignFace, ThingFacts
from osm2xodr.osmParsing.tags.node_facts import (
    directed_values,
    node_heights,
    parse_ele,
    read_control,
    read_faces,
    read_facing,
    read_node_facts,
    read_sign_post,
    read_thing_facts,
    turning_circles,
)

ONE = [
    # value, further tags, country, meaning, value, unit, text
    ("city_limit", "name=Krems", "AT", "city_limit", None, "", "Krems"),
    ("stop", "", "US", "stop", None, "", ""),
    ("yield", "", "US", "give_way", None, "", ""),
    ("maxspeed", "maxspeed=30", "DE", "maxspeed", 30.0, "km/h", ""),
    ("maxspeed", "maxspeed=30", "GB", "maxspeed", 30.0, "mph", ""),
    ("maxspeed", "maxspeed=20_mph", "DE", "maxspeed", 20.0, "mph", ""),
    ("maxspeed", "", "DE", "maxspeed", None, "", ""),
    ("overtaking", "", "DE", "no_overtaking", None, "", ""),
    ("hazard", "", "DE", "hazard", None, "", ""),
    ("hazard", "hazard=bump", "DE", "bumps", None, "", ""),
    ("maxheight", "maxheight=3.8", "DE", "max_height", 3.8, "m", ""),
    ("maxweight", "maxweight=7,5", "DE", "max_weight", 7.5, "t", ""),
    ("DE:274-30", "", "DE", "maxspeed", 30.0, "km/h", ""),
    ("DE:274[50]", "", "", "maxspeed", 50.0, "km/h", ""),
    ("DE:274.1[30]", "", "DE", "maxspeed_zone", 30.0, "km/h", ""),
    ("DE:310[Bad_Wildbad]", "", "DE", "city_limit", None, "", "Bad_Wildbad"),
    ("US:R2-1[45]", "", "US", "maxspeed", 45.0, "mph", ""),
    ("US:R1-1", "", "US", "stop", None, "", ""),
    ("FR:AB4", "", "FR", "stop", None, "", ""),
    ("GB:670[40]", "", "GB", "maxspeed", 40.0, "mph", ""),
    ("NL:A01-50", "", "NL", "maxspeed", 50.0, "km/h", ""),
    ("274.1", "", "DE", "maxspeed_zone", None, "", ""),
    ("XX:12", "", "DE", "", None, "", ""),
]


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


def tags_of(text: str) -> dict[str, str]:
    return {key: value.replace("_", " ") for key, _, value in (item.partition("=") for item in text.split())}


@pytest.mark.parametrize(("text", "more", "country", "meaning", "value", "unit", "words"), ONE, ids=str)
def test_one_sign(
    text: str, more: str, country: str, meaning: str, value: float | None, unit: str, words: str
) -> None:
    (face,) = read_faces(text, tags_of(more), country)
    assert (face.meaning, face.value, face.unit, face.text) == (meaning, value, unit, words)
    assert not face.supplementary


@pytest.mark.parametrize("text", ["yes", "no", "", "street_name_sign", "variable", ";", "YES; no"])
def test_what_names_no_sign(text: str) -> None:
    assert read_faces(text, {}, "DE") == ()


def test_supplementary_plates_follow_their_sign() -> None:
    faces = read_faces("DE:274[30],DE:1020;265[3.8]", {}, "DE")
    assert [(face.meaning, face.code, face.value, face.unit, face.supplementary) for face in faces] == [
        ("maxspeed", "274", 30.0, "km/h", False),
        ("", "1020", None, "", True),
        ("max_height", "265", 3.8, "m", False),
    ]


def test_the_country_holds_for_what_follows() -> None:
    assert [(face.country, face.code) for face in read_faces("FR:B14[50],M9z;B3", {}, "DE")] == [
        ("FR", "B14"),
        ("FR", "M9z"),
        ("FR", "B3"),
    ]


def test_words_in_quotes_are_a_plate() -> None:
    first, second = read_faces('DE:260,"Anlieger, Lieferverkehr frei"', {}, "DE")
    assert first == SignFace("no_motor_vehicles", "DE", "260")
    assert second == SignFace("", text="Anlieger, Lieferverkehr frei", supplementary=True)


def test_two_signs_on_one_pole() -> None:
    assert [face.meaning for face in read_faces("DE:205,DE:215", {}, "DE")] == ["give_way", "roundabout"]
    assert [face.meaning for face in read_faces("variable;DE:254", {}, "DE")] == ["no_bicycles"]


def test_the_limit_of_a_direction_goes_first() -> None:
    tags = {"maxspeed": "50", "maxspeed:forward": "30"}
    assert read_faces("maxspeed", tags, "DE", "forward")[0].value == 30.0
    assert read_faces("maxspeed", tags, "DE", "backward")[0].value == 50.0


def test_directions() -> None:
    assert list(directed_values({"traffic_sign": "stop", "direction": "forward"})) == [("forward", "stop")]
    tags = {"traffic_sign": "a", "direction": "90", "traffic_sign:direction": "backward", "traffic_sign:forward": "b"}
    assert list(directed_values(tags)) == [("backward", "a"), ("forward", "b")]
    assert list(directed_values({"highway": "stop"})) == []


@pytest.mark.parametrize(
    ("text", "compass_points", "expected"),
    [
        ("forward", False, Facing(along=True)),
        ("backward", True, Facing(along=False)),
        ("both", False, Facing(both=True)),
        ("90", False, Facing(azimuth_deg=90.0)),
        ("22.5", True, Facing(azimuth_deg=22.5)),
        ("sse", True, Facing(azimuth_deg=157.5)),
        ("sse", False, Facing()),
        (" NW ", True, Facing(azimuth_deg=315.0)),
        ("-90", True, Facing()),
        ("", True, Facing()),
    ],
)
def test_which_traffic_a_sign_is_for(text: str, compass_points: bool, expected: Facing) -> None:
    assert read_facing(text, compass_points=compass_points) == expected


def test_a_post_has_the_signs_of_all_directions() -> None:
    tags = {
        "highway": "give_way",
        "direction": "W",
        "traffic_sign": "DE:205",
        "traffic_sign:backward": "maxspeed",
        "maxspeed:backward": "30",
        "city_limit": "end",
    }
    post = read_sign_post(tags, "DE")
    assert post.facing == Facing(azimuth_deg=270.0)
    assert (post.control, post.city_limit) == (Sign.GIVE_WAY, "end")
    assert [signs.facing for signs in post.signs] == [post.facing, Facing(along=False)]
    assert [[(face.meaning, face.value) for face in signs.faces] for signs in post.signs] == [
        [("give_way", None)],
        [("maxspeed", 30.0)],
    ]
    assert read_sign_post({"highway": "stop"}, "DE").signs == ()

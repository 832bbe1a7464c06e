"""What values of ``traffic_sign`` say."""

from __future__ import annotations

import pytest

from osm2xodr.model import Facing, Sign, SignFace
from osm2xodr.osmParsing.tags.traffic_signs import directed_values, read_faces, read_facing, read_sign_post

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

import pytest
from osm_builder import tags_of

from osm2xodr.osmParsing.options import DRIVABLE, PRESETS
from osm2xodr.osmParsing.tags.access import closed_direction, closing_tag, oneway, reason_left_out


@pytest.mark.parametrize(
    ("tags", "closing"),
    [
        ("", None),
        ("access=yes", None),
        ("access=destination", None),
        ("access=customers", None),
        ("access=private", "access=private"),
        ("access=no", "access=no"),
        ("vehicle=forestry", "vehicle=forestry"),
        ("motor_vehicle=agricultural", "motor_vehicle=agricultural"),
        ("motorcar=permit", "motorcar=permit"),
        ("motor_vehicle=delivery", "motor_vehicle=delivery"),
        # The most specific key decides, whatever the others say.
        ("access=no motor_vehicle=yes", None),
        ("access=yes vehicle=no", "vehicle=no"),
        ("access=private motorcar=destination vehicle=no", None),
        ("motorcar=no motor_vehicle=yes", "motorcar=no"),
        # Several values: closed if none of them lets cars in.
        ("vehicle=agricultural;forestry", "vehicle=agricultural;forestry"),
        ("motor_vehicle=destination;agricultural", None),
        ("bicycle=no foot=no", None),
        # Kept for cars with several people in them.
        ("motor_vehicle=no hov=designated", None),
        ("access=no hov=only", None),
        ("access=private hov=yes", "access=private"),
    ],
)
def test_closed_to_cars(tags: str, closing: str | None) -> None:
    assert closing_tag(tags_of(tags)) == closing


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        ("highway=residential", (0, True)),
        ("highway=residential oneway=yes", (1, True)),
        ("highway=residential oneway=true", (1, True)),
        ("highway=residential oneway=1", (1, True)),
        ("highway=residential oneway=-1", (-1, True)),
        ("highway=residential oneway=reverse", (-1, True)),
        ("highway=residential oneway=no", (0, True)),
        ("highway=motorway", (1, True)),
        ("highway=motorway_link", (1, True)),
        ("highway=motorway oneway=no", (0, True)),
        ("highway=trunk", (0, True)),
        ("highway=primary junction=roundabout", (1, True)),
        ("highway=primary junction=circular", (1, True)),
        ("highway=primary junction=roundabout oneway=-1", (-1, True)),
        ("highway=primary junction=roundabout oneway=0", (0, True)),
        ("highway=primary junction=approach", (0, True)),
        ("highway=residential oneway=alternating", (0, False)),
        ("highway=tertiary oneway=reversible", (0, False)),
        ("highway=motorway oneway=reversible", (1, False)),
        ("highway=motorway_link oneway=reversible lanes:forward=2 lanes:backward=1", (0, False)),
        ("highway=residential oneway=maybe", (0, False)),
    ],
)
def test_oneway(tags: str, expected: tuple[int, bool]) -> None:
    assert oneway(tags_of(tags)) == expected


@pytest.mark.parametrize(
    ("tags", "closed"),
    [
        ("highway=residential", None),
        ("motor_vehicle:backward=no", (-1, "motor_vehicle:backward=no")),
        ("motor_vehicle:forward=no", (1, "motor_vehicle:forward=no")),
        ("vehicle:forward=destination", None),
        ("access:backward=private", (-1, "access:backward=private")),
        # The most specific key decides.
        ("vehicle:backward=no motorcar:backward=yes", None),
        ("vehicle:backward=yes motorcar:backward=no", (-1, "motorcar:backward=no")),
        # Both directions closed say nothing about one.
        ("vehicle:backward=no vehicle:forward=no", None),
        ("oneway:motor_vehicle=yes", (-1, "oneway:motor_vehicle=yes")),
        ("oneway:motorcar=-1", (1, "oneway:motorcar=-1")),
        ("oneway:motor_vehicle=no", None),
        ("oneway:bicycle=yes", None),
    ],
)
def test_one_direction_closed(tags: str, closed: tuple[int, str] | None) -> None:
    assert closed_direction(tags_of(tags)) == closed


@pytest.mark.parametrize(
    ("tags", "preset", "include_private", "code"),
    [
        ("highway=residential", "drivable", False, None),
        ("highway=service", "drivable", False, None),
        ("highway=service service=alley", "drivable", False, None),
        ("highway=service service=driveway", "drivable", False, "way-selection"),
        ("highway=service service=parking_aisle", "drivable", False, "way-selection"),
        ("highway=service service=emergency_access", "drivable", False, "way-selection"),
        ("highway=service service=driveway", "all", False, None),
        # ``service`` means something else on other ways.
        ("highway=residential service=driveway", "drivable", False, None),
        ("highway=service area=yes", "all", True, "area"),
        ("highway=residential area=no", "drivable", False, None),
        ("highway=residential access=private", "drivable", False, "closed"),
        ("highway=residential access=private", "drivable", True, None),
        ("highway=track vehicle=forestry", "all", False, "closed"),
        ("highway=service service=driveway access=private", "drivable", True, "way-selection"),
    ],
)
def test_left_out(tags: str, preset: str, include_private: bool, code: str | None) -> None:
    selection = PRESETS[preset]
    reason = reason_left_out(tags_of(tags), selection, include_private)
    assert (reason and reason[0]) == code


def test_left_out_says_why() -> None:
    tags = tags_of("highway=residential access=private")
    assert reason_left_out(tags, DRIVABLE, False) == ("closed", "access=private closes it to cars, it is left out")

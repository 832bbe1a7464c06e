import math

import pytest

from osm2xodr.osmParsing.tags.values import parse_count, parse_grade, parse_layer, parse_length, parse_speed


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("3.5", 3.5),
        ("3,5", 3.5),
        (" 3.5 m ", 3.5),
        ("3.5m", 3.5),
        (".5", 0.5),
        ("11 ft", 3.3528),
        ("11'", 3.3528),
        ("3'6\"", 1.0668),
        ("16'0\"", 4.8768),
        ("12ft 6in", 3.81),
        ("250 cm", 2.5),
        ("0.1 km", 100.0),
        ("1 mi", 1609.344),
        ("10 yd", 9.144),
        ("2 Meters", 2.0),
        ("", None),
        ("-3", None),
        ("3-4", None),
        ("~3", None),
        ("wide", None),
        ("3 parsecs", None),
        ("1e3", None),
        ("nan", None),
    ],
)
def test_length(text: str, metres: float | None) -> None:
    assert parse_length(text) == (None if metres is None else pytest.approx(metres))


@pytest.mark.parametrize(
    ("text", "count", "exact"),
    [
        ("2", 2, True),
        ("12", 12, True),
        ("2;3", 2, False),
        ("3|2", 2, False),
        ("1.5", 1, False),
        (" 2 ", 2, False),
        ("02", 2, False),
        ("0", None, False),
        ("-1", None, False),
        ("two", None, False),
        ("", None, False),
        ("99999999999999999999", None, False),
        ("9" * 400, None, False),  # too large for a floating-point number
        ("9" * 5000 + ";2", 2, False),
        ("٣", None, False),  # a digit, but none that int() should be given
    ],
)
def test_count(text: str, count: int | None, exact: bool) -> None:
    assert parse_count(text) == (count, exact)


@pytest.mark.parametrize(
    ("text", "kmh"),
    [
        ("50", 50.0),
        ("50 km/h", 50.0),
        ("50kmh", 50.0),
        ("30 mph", 48.28032),
        ("30mph", 48.28032),
        ("10 knots", 18.52),
        ("5.5", 5.5),
        ("none", math.inf),
        ("walk", 7.0),
        ("DE:urban", 50.0),
        ("DE:rural", 100.0),
        ("DE:motorway", math.inf),
        ("DE:living_street", 7.0),
        ("RO:urban", 50.0),
        ("RU:urban", 60.0),
        ("BE-VLG:rural", 70.0),
        ("GB:nsl_single", 96.56064),
        ("GB:nsl_dual", 112.65408),
        ("fr:zone:30", 30.0),
        ("DE:zone30", 30.0),
        ("DE:30", 30.0),
        ("GB:zone:20", 32.18688),
        ("AT:walk", 7.0),
        ("BE:rural", None),  # differs by region
        ("XX:urban", None),
        ("DE:zone:0", None),
        ("signals", None),
        ("variable", None),
        ("50;30", None),
        ("50 @ (22:00-06:00)", None),
        ("0", None),
        ("-50", None),
        ("5000", None),
        ("fast", None),
        ("", None),
    ],
)
def test_speed(text: str, kmh: float | None) -> None:
    assert parse_speed(text) == (None if kmh is None else pytest.approx(kmh / 3.6))


@pytest.mark.parametrize(
    ("text", "grade"),
    [
        ("8%", 0.08),
        ("-5.5 %", -0.055),
        ("+3%", 0.03),
        ("12", 0.12),
        ("0", 0.0),
        ("10°", math.tan(math.radians(10.0))),
        ("-10 °", -math.tan(math.radians(10.0))),
        ("up", None),
        ("steep", None),
        ("60%", None),
        ("45°", None),
        ("95°", None),
        ("", None),
    ],
)
def test_grade(text: str, grade: float | None) -> None:
    assert parse_grade(text) == (None if grade is None else pytest.approx(grade))


@pytest.mark.parametrize(
    ("text", "layer"),
    [
        *[("1", 1), ("-1", -1), ("+2", 2), ("0", 0), ("-1;0", -1), ("0;1", 1), ("1.0", 1), ("99", None)],
        *[("top", None), ("9" * 400, None), ("1;" + "9" * 400, 1)],
    ],
)
def test_layer(text: str, layer: int | None) -> None:
    assert parse_layer(text) == layer

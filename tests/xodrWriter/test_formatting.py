from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given, strategies as st
from lxml import etree

from osm2xodr.errors import OutputError
from osm2xodr.xodrWriter.formatting import (
    attribute,
    lane_speed_attributes,
    number,
    position,
    road_speed_attributes,
    rounded,
    start_of_last,
)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (3.25, "3.25"),
        (-1.0, "-1"),
        (12345.678901234, "12345.6789012"),
        (math.pi, "3.14159265359"),
        (2e-7, "2e-07"),
        (0.1 + 0.2, "0.3"),
    ],
)
def test_number(value: float, text: str) -> None:
    assert number(value) == text


@given(st.floats(min_value=-1e5, max_value=1e5))
def test_numbers_keep_twelve_digits(value: float) -> None:
    assert float(number(value)) == pytest.approx(value, rel=5.0001e-12, abs=0.0)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_refused(value: float) -> None:
    with pytest.raises(OutputError, match="not finite"):
        number(value)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("Königsallee", "Königsallee"),
        ('"Rue" <A&B>', "&quot;Rue&quot; &lt;A&amp;B&gt;"),
        ("a\x00\x08\x1f\ufffe\udc80b", "ab"),
        ("two\nlines\tand\r\ntabs", "two lines and tabs"),
        ("道路 \U0001f6e3", "道路 \U0001f6e3"),
    ],
)
def test_attribute(name: str, text: str) -> None:
    assert attribute(name) == text


@given(st.text())
def test_attributes_are_always_xml_and_keep_what_xml_allows(name: str) -> None:
    read = etree.fromstring(f'<road name="{attribute(name)}"/>'.encode()).get("name", "missing")
    allowed = [c for c in name if c >= " " and not "\ud800" <= c <= "\udfff" and c not in "\ufffe\uffff"]
    assert [c for c in read if c != " "] == [c for c in allowed if c != " "]


def test_rounded() -> None:
    values = rounded(np.array([1e-11, -1e-11, -0.0, 1.23456785001, -2.0]), 7)
    assert values.tolist() == [0.0, 0.0, 0.0, 1.2345679, -2.0]
    assert not np.signbit(values[:3]).any()
    assert rounded(np.array([0.123456, 0.123456]), np.array([2.0, 4.0])).tolist() == [0.12, 0.1235]


@pytest.mark.parametrize(
    ("value", "text"), [(12.3456789012, "12.3456789"), (-1e-9, "0"), (0.1 + 0.2, "0.3"), (1e5 / 3, "33333.3333333")]
)
def test_position(value: float, text: str) -> None:
    assert position(value) == text


@pytest.mark.parametrize(("s", "length"), [(225.857286096, 842.231625369), (0.0, 17.3), (5.0, 10.0)])
def test_the_last_lane_section_ends_on_the_road(s: float, length: float) -> None:
    start = float(start_of_last(s, length))
    assert start + (length - start) <= length
    assert abs(s - start) < 6e-8


@given(st.floats(1e-3, 1e5), st.floats(1e-3, 1.0))
def test_no_last_lane_section_ends_beyond_its_road(length: float, share: float) -> None:
    end = float(number(length))
    start = float(start_of_last(share * end, end))
    assert start + (end - start) <= end
    assert abs(start - share * end) < 1e-10 * end + 6e-8


# ---------------------------------------------------------------- speed limits

UNIT = {"km/h": 1.0 / 3.6, "mph": 0.44704}


@pytest.mark.parametrize("kmh", [5, 7, 20, 30, 50, 80, 120, 130])
def test_kilometres_per_hour(kmh: int) -> None:
    assert road_speed_attributes(kmh / 3.6) == f'max="{kmh}" unit="km/h"'


@pytest.mark.parametrize("mph", range(5, 86, 5))
def test_miles_per_hour(mph: int) -> None:
    assert road_speed_attributes(mph * 0.44704) == f'max="{mph}" unit="mph"'


def test_odd_speeds() -> None:
    assert road_speed_attributes(12.34) == 'max="44.424" unit="km/h"'


def test_no_limit() -> None:
    assert road_speed_attributes(math.inf) == 'max="no limit"'
    assert lane_speed_attributes(math.inf) == 'max="400" unit="km/h"'


@given(st.floats(min_value=0.5, max_value=90.0))
def test_speeds_stay_what_they_are(speed: float) -> None:
    found = re.fullmatch(r'max="([\d.]+)" unit="(.*)"', lane_speed_attributes(speed))
    assert found is not None
    assert float(found[1]) * UNIT[found[2]] == pytest.approx(speed, abs=0.003)

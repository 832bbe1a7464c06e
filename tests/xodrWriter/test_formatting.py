""" """

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given, strategies as st
from lxml import etree

from osm2xodr.conventions.targets import TARGETS
from osm2xodr.errors import OutputError
from osm2xodr.model import LaneType
from osm2xodr.xodrWriter.formatting import (
    Words,
    attribute,
    lane_speed_attributes,
    number,
    position,
    road_speed_attributes,
    rounded,
    start_of_last,
)
from osm2xodr.xodrWriter.options import DIALECTS, VERSIONS, WriteOptions


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


def test_versions() -> None:
    assert VERSIONS == ("1.4", "1.6", "1.7", "1.8")
    assert WriteOptions().version == "1.7"
    with pytest.raises(ValueError, match=r"1\.5 cannot be written; choose one of 1\.4, 1\.6, 1\.7, 1\.8"):
        WriteOptions("1.5")


def test_1_4_replaces_what_it_lacks() -> None:
    words = Words(DIALECTS["1.4"])
    written = {kind: words.lane_type(kind.value) for kind in LaneType}
    assert written.pop(LaneType.BUS) == "restricted"
    assert written.pop(LaneType.TAXI) == "restricted"
    assert written.pop(LaneType.CURB) == "border"
    assert written == {kind: kind.value for kind in written}
    assert words.road_type("townLocal") == "town"
    assert words.mark_type("edge") == "none"
    assert words.mark_color("violet") == "standard"
    assert sorted(words.replaced) == [
        ("bus", "restricted"),
        ("curb", "border"),
        ("edge", "none"),
        ("taxi", "restricted"),
        ("townLocal", "town"),
        ("violet", "standard"),
    ]


def test_1_7_replaces_nothing() -> None:
    words = Words(DIALECTS["1.7"])
    assert [words.lane_type(kind.value) for kind in LaneType] == [kind.value for kind in LaneType]
    assert words.road_type("townLocal") == "townLocal"
    assert words.mark_type("solid broken") == "solid broken"
    assert words.mark_color("violet") == "violet"
    assert words.lane_change("increase") == "increase"
    assert words.replaced == set()


@pytest.mark.parametrize(
    ("version", "users", "replaced"),
    [
        ("1.4", (), {("HOV", "driving")}),
        ("1.6", ("passengerCar", "bus", "motorcycle"), {("HOV", "passengerCar bus motorcycle")}),
        ("1.7", ("passengerCar", "bus", "motorcycle"), {("HOV", "passengerCar bus motorcycle")}),
        ("1.8", ("HOV",), set()),
    ],
)
def test_who_may_drive_on_a_lane(version: str, users: tuple[str, ...], replaced: set[tuple[str, str]]) -> None:
    words = Words(DIALECTS[version])
    assert words.access("") == ()
    assert words.replaced == set()
    assert words.access("HOV") == users
    assert words.replaced == replaced


def test_words_of_no_version_are_refused() -> None:
    words = Words(DIALECTS["1.8"])
    with pytest.raises(OutputError, match="no road type 'footway'"):
        words.road_type("footway")
    with pytest.raises(OutputError, match="no road mark 'dashed'"):
        words.mark_type("dashed")
    with pytest.raises(OutputError, match="no colour of road marks 'pink'"):
        words.mark_color("pink")
    with pytest.raises(OutputError, match="no lane change 'left'"):
        words.lane_change("left")


def test_words_that_a_reader_takes_for_something_else() -> None:
    words = Words(DIALECTS["1.7"], TARGETS["sumo"].lane_types)
    assert words.lane_type("parking") == "shoulder"
    assert words.lane_type("border") == "border"
    assert words.replaced == {("parking", "shoulder")}
    assert Words(DIALECTS["1.7"], TARGETS["generic"].lane_types).lane_type("parking") == "parking"


@pytest.mark.parametrize(
    ("target", "version", "written", "users"),
    [
        ("sumo", "1.7", "driving", True),
        # It has no words for who may drive there.
        ("sumo", "1.4", "restricted", False),
        ("esmini", "1.7", "restricted", False),
        ("generic", "1.7", None, False),
    ],
)
def test_lanes_for_buses_and_taxis(target: str, version: str, written: str | None, users: bool) -> None:
    words = Words(DIALECTS[version], TARGETS[target].lane_types)
    for kind in ("bus", "taxi"):
        assert words.lane_type(kind) == (written or kind)
        assert words.lane_users(kind) == ((kind,) if users else ())
    assert words.lane_users("driving") == words.lane_users("parking") == ()


def test_lane_changes_as_drivers_see_them() -> None:
    carla = TARGETS["carla"]
    words = Words(DIALECTS["1.7"], carla.lane_types, changes_as_driven=carla.changes_as_driven)
    said = {side: [words.lane_change(word, side) for word in ("increase", "decrease", "both")] for side in (1, 0, -1)}
    assert said == {
        1: ["increase", "decrease", "both"],
        0: ["none", "none", "both"],
        -1: ["decrease", "increase", "both"],
    }
    assert not any(item.changes_as_driven for name, item in TARGETS.items() if name != "carla")
    plain = Words(DIALECTS["1.7"])
    assert [plain.lane_change("increase", side) for side in (1, 0, -1)] == ["increase"] * 3


def test_negated_lane_ids() -> None:
    words = Words(DIALECTS["1.7"], negated=True)
    assert [words.lane_id(number) for number in (2, 0, -1)] == [-2, 0, 1]
    assert words.lane_range(-2, -1) == (1, 2)
    # Higher ids are where lower ones were.
    assert [words.lane_change(word) for word in ("increase", "decrease", "both", "none")] == [
        *("decrease", "increase", "both", "none")
    ]
    plain = Words(DIALECTS["1.7"])
    assert (plain.lane_id(2), plain.lane_range(-2, -1), plain.lane_change("increase")) == (2, (-2, -1), "increase")
    assert {name for name, item in TARGETS.items() if item.negated_left_hand} == {"sumo"}


def test_words_of_furniture() -> None:
    words = Words(DIALECTS["1.6"])
    assert (words.object_type("barrier"), words.object_type("roadSurface")) == ("barrier", "patch")
    assert (words.unit("mph"), words.unit("")) == ("mph", "")
    assert (words.country("DE"), words.country("OpenDRIVE"), words.country("")) == ("DE", "OpenDRIVE", "")
    assert words.orientation("none") == "none"
    with pytest.raises(OutputError, match="no country 'de'"):
        words.country("de")

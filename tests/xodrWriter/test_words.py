from __future__ import annotations

import pytest

from osm2xodr.conventions.targets import TARGETS
from osm2xodr.errors import OutputError
from osm2xodr.model import LaneType
from osm2xodr.xodrWriter.options import DIALECTS, VERSIONS, WriteOptions
from osm2xodr.xodrWriter.words import Words


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

"""The whole document, parsed back."""

from __future__ import annotations

import io
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from lxml import etree
from sample_road_maps import FRAME, crossing, furnished_crossing, plan_view, profile, straight_roads

from osm2xodr import __version__
from osm2xodr.conventions import TARGETS
from osm2xodr.curves import pose
from osm2xodr.diagnostics import Diagnostics, Kind
from osm2xodr.errors import OutputError
from osm2xodr.model import Access, Cubic, Furniture, RoadMap, RoadType, Rule, Signal, Stretches
from osm2xodr.xodrWriter import VERSIONS, WriteOptions, write_xodr
from osm2xodr.xodrWriter.document import plan_view_bounds


def written(road_map: RoadMap, options: WriteOptions | None = None, diagnostics: Diagnostics | None = None) -> bytes:
    stream = io.BytesIO()
    options = WriteOptions() if options is None else options
    write_xodr(road_map, stream, options, Diagnostics() if diagnostics is None else diagnostics)
    return stream.getvalue()


def parsed(document: bytes) -> Any:
    """Parse a document; typed as anything, for every element may be absent and a test is to fail then."""
    return etree.fromstring(document)


def test_same_input_gives_the_same_bytes() -> None:
    assert written(crossing()) == written(crossing())


def test_the_version_of_the_program_stands_in_the_header_unless_another_is_given() -> None:
    for options, version in ((WriteOptions(), __version__), (WriteOptions(tool_version="9.8.7"), "9.8.7")):
        data = parsed(written(crossing(), options)).find("header").findall("userData")
        assert [item.get("value") for item in data if item.get("code") == "osm2xodr"] == [version]


def test_header() -> None:
    document = written(crossing(), WriteOptions("1.7", "Ordino", tool_version="9.8.7"))
    header = parsed(document).find("header")
    assert header.get("revMajor") == "1"
    assert header.get("name") == "Ordino"
    assert header.get("date") is None
    assert header.get("vendor") == "osm2xodr"
    # Road 2 ends in a left arc of radius 20 m from (190, 0): east to 210, north to 20.
    bounds = {side: float(header.get(side)) for side in ("west", "south", "east", "north")}
    assert bounds == pytest.approx({"west": 0.0, "south": 0.0, "east": 210.0, "north": 20.0}, abs=1e-9)
    assert header.find("offset") is None
    assert header.findtext("geoReference") == FRAME.proj
    assert f"<geoReference><![CDATA[{FRAME.proj}]]></geoReference>\n".encode() in document
    data = {item.get("code"): item.get("value") for item in header.findall("userData")}
    assert data["osm2xodr"] == "9.8.7"
    assert data["attribution"] == "© OpenStreetMap contributors, Open Database License 1.0 (ODbL)"


def test_header_with_a_date_and_without_osm_data() -> None:
    header = parsed(written(crossing(), WriteOptions("1.8", date="2024-05-06", osm_data=False))).find("header")
    assert header.get("date") == "2024-05-06"
    assert [item.get("code") for item in header.findall("userData")] == ["osm2xodr"]
    assert header.find("license") is None


def test_the_licence_has_an_element_of_its_own_from_1_8_on() -> None:
    elements = {
        version: parsed(written(crossing(), WriteOptions(version))).find("header/license") for version in VERSIONS
    }
    assert [version for version, element in elements.items() if element is not None] == ["1.8"]
    assert elements["1.8"].get("spdxid") == "ODbL-1.0"


def test_roads() -> None:
    root = parsed(written(crossing()))
    roads = root.findall("road")
    assert [road.get("id") for road in roads] == ["1", "2", "3", "4"]
    assert [road.get("junction") for road in roads] == ["-1", "-1", "5", "5"]
    # Traffic drives on the right by default.
    assert {road.get("rule") for road in roads} == {None}
    assert roads[0].get("name") == 'Carrer d\'"A & B" <Ç>'
    assert float(roads[1].get("length")) == pytest.approx(80.0 + 10.0 * math.pi, abs=6e-8)
    order = [child.tag for child in roads[1]]
    assert order == ["link", "type", "planView", "elevationProfile", "lateralProfile", "lanes", "userData"]


def test_road_links() -> None:
    roads = parsed(written(crossing())).findall("road")
    assert roads[0].find("link/predecessor") is None
    assert dict(roads[0].find("link/successor").attrib) == {"elementType": "junction", "elementId": "5"}
    assert dict(roads[3].find("link/predecessor").attrib) == {
        "elementType": "road",
        "elementId": "2",
        "contactPoint": "start",
    }
    assert roads[3].find("link/successor").get("contactPoint") == "end"


def test_a_road_without_neighbours_has_an_empty_link() -> None:
    road_map = crossing()
    alone = replace(road_map.roads[1], predecessor=None, successor=None)
    root = parsed(written(replace(road_map, roads=(road_map.roads[0], alone, *road_map.roads[2:]))))
    assert len(root.findall("road")[1].find("link")) == 0


def test_types_and_speeds() -> None:
    first, second = parsed(written(crossing())).findall("road")[:2]
    assert [(t.get("s"), t.get("type")) for t in first.findall("type")] == [("0", "town"), ("60", "townExpressway")]
    speeds = [dict(t.find("speed").attrib) for t in first.findall("type")]
    assert speeds == [{"max": "50", "unit": "km/h"}, {"max": "no limit"}]
    assert second.find("type/speed") is None


def test_plan_view() -> None:
    road = parsed(written(crossing())).findall("road")[1]
    line, arc = road.findall("planView/geometry")
    assert {k: float(v) for k, v in line.attrib.items()} == {"s": 0, "x": 110, "y": 0, "hdg": 0, "length": 80}
    assert [child.tag for child in line] == ["line"]
    assert float(arc.get("s")) == 80.0
    assert float(arc.get("length")) == pytest.approx(10.0 * math.pi, abs=6e-8)
    assert [dict(child.attrib) for child in arc] == [{"curvature": "0.05"}]


def test_profiles() -> None:
    first, second, *_ = parsed(written(crossing())).findall("road")
    records = [dict(item.attrib) for item in second.findall("elevationProfile/elevation")]
    assert records[1] == {"s": "80", "a": "1003.8", "b": "0.02", "c": "-0.0001", "d": "2e-07"}
    assert [item.get("b") for item in second.findall("lateralProfile/superelevation")] == ["0", "0.001"]
    assert first.find("lateralProfile") is None
    assert [item.get("s") for item in first.findall("lanes/laneOffset")] == ["0", "40"]
    assert first.findall("lanes/laneOffset")[0].get("a") == "0.5"
    assert second.find("lanes/laneOffset") is None


def test_profiles_that_are_0_throughout_are_left_out() -> None:
    road_map = crossing()
    flat = profile([[(0.0, 0.0, 0.0, 0.0, 0.0)]] * 4)
    root = parsed(written(replace(road_map, superelevation=flat, lane_offset=flat, elevation=flat)))
    assert list(root.iter("elevationProfile", "lateralProfile", "laneOffset")) == []


def test_lanes() -> None:
    section = parsed(written(crossing())).find("road/lanes").findall("laneSection")[1]
    assert section.get("s") == "60"
    assert [child.tag for child in section] == ["left", "center", "right"]
    lanes = {int(item.get("id")): item for item in section.iter("lane")}
    assert list(lanes) == [1, 0, -1, -2]
    assert {item.get("level") for item in lanes.values()} == {None}  # false, and no reader asks
    assert [item.get("type") for item in lanes.values()] == ["driving", "none", "driving", "bus"]
    assert lanes[0].find("width") is None
    assert lanes[-1].find("link/predecessor").get("id") == "-1"
    assert lanes[-1].find("link/successor") is None
    assert dict(lanes[-1].find("speed").attrib) == {"sOffset": "0", "max": "30", "unit": "mph"}
    assert lanes[-2].find("link") is None
    widths = [dict(item.attrib) for item in lanes[-2].findall("width")]
    assert widths[0] == {"sOffset": "0", "a": "0", "b": "0", "c": "0.0075", "d": "-0.00025"}
    assert widths[1] == {"sOffset": "20", "a": "1", "b": "0", "c": "0", "d": "0"}
    assert dict(lanes[-1].find("roadMark").attrib) == {
        "sOffset": "0",
        "type": "broken",
        "weight": "standard",
        "color": "white",
        "width": "0.12",
        "laneChange": "both",
    }


def test_a_lane_for_cars_with_several_people() -> None:
    plain = crossing()
    road = plain.roads[1]
    (section,) = road.lane_sections
    kept = replace(section, lanes=(*section.lanes[:2], replace(section.lanes[2], access=Access.HOV, height=0.1)))
    roads = (plain.roads[0], replace(road, lane_sections=(kept,)), *plain.roads[2:])
    for version, users in (("1.4", []), ("1.7", ["passengerCar", "bus", "motorcycle"]), ("1.8", ["HOV"])):
        found = parsed(written(replace(plain, roads=roads), WriteOptions(version))).findall("road")[1].iter("lane")
        lanes = {item.get("id"): item for item in found}
        assert [item.tag for item in lanes["-1"]] == ["width", "roadMark", *["access"] * len(users), "height"]
        written_access = [dict(item.attrib) for item in lanes["-1"].findall("access")]
        assert written_access == [{"sOffset": "0", "rule": "allow", "restriction": user} for user in users]
        assert lanes["1"].find("access") is None


@pytest.mark.parametrize(
    ("target", "version", "kind", "users"),
    [("generic", "1.7", "bus", []), ("sumo", "1.7", "driving", ["bus"]), ("sumo", "1.4", "restricted", [])],
)
def test_a_lane_for_buses(target: str, version: str, kind: str, users: list[str]) -> None:
    root = parsed(written(crossing(), WriteOptions(version, target=TARGETS[target])))
    lanes = {item.get("id"): item for item in root.find("road/lanes").findall("laneSection")[1].iter("lane")}
    assert lanes["-2"].get("type") == kind
    assert [item.tag for item in lanes["-2"]] == ["width", "width", "roadMark", "speed", *["access"] * len(users)]
    assert [(item.get("rule"), item.get("restriction")) for item in root.iter("access")] == [
        ("allow", user) for user in users
    ]


def test_a_lane_without_mark_and_a_side_without_lanes_write_none() -> None:
    section = parsed(written(crossing())).findall("road")[2].find("lanes/laneSection")
    assert [child.tag for child in section] == ["center", "right"]
    assert section.find("right/lane/roadMark") is None
    assert section.find("center/lane").get("id") == "0"


def test_junctions() -> None:
    junction = parsed(written(crossing())).find("junction")
    assert junction.get("id") == "5"
    connections = junction.findall("connection")
    assert [dict(item.attrib) for item in connections] == [
        {"id": "0", "incomingRoad": "1", "connectingRoad": "3", "contactPoint": "start"},
        {"id": "1", "incomingRoad": "2", "connectingRoad": "4", "contactPoint": "start"},
    ]
    links = [dict(link.attrib) for item in connections for link in item.findall("laneLink")]
    assert links == [{"from": "-1", "to": "-1"}, {"from": "1", "to": "-1"}]
    assert dict(junction[-1].attrib) == {"high": "1", "low": "2"}
    assert junction[-1].tag == "priority"


def test_1_4_says_what_it_cannot_say() -> None:
    found = Diagnostics()
    document = written(replace(crossing(), rule=Rule.LEFT_HAND), WriteOptions("1.4"), found)
    root = parsed(document)
    assert [road.get("rule") for road in root.findall("road")] == [None] * 4
    assert [item.get("type") for item in root.iter("lane")].count("restricted") == 1
    assert [item.get("type") for item in root.iter("type")] == ["town", "town", "rural"]
    assert found.counts() == {(Kind.NOTE, "left-hand-lost"): 1, (Kind.NOTE, "word-lost"): 2}
    assert next(iter(found)).message.startswith("OpenDRIVE 1.4 cannot say that traffic drives on the left")


def test_later_versions_say_it_all() -> None:
    found = Diagnostics()
    for version in ("1.6", "1.7", "1.8"):
        root = parsed(written(replace(crossing(), rule=Rule.LEFT_HAND), WriteOptions(version), found))
        assert {road.get("rule") for road in root.findall("road")} == {"LHT"}
    assert len(found) == 0


def test_sumo_gets_negated_lane_ids_where_traffic_drives_on_the_left() -> None:
    options, found = WriteOptions(target=TARGETS["sumo"]), Diagnostics()
    road_map = replace(furnished_crossing(), rule=Rule.LEFT_HAND)
    usual, negated = (parsed(written(road_map, item, found)) for item in (WriteOptions(), options))
    for path in (".//lane", ".//lane/link/predecessor", ".//lane/link/successor"):
        before, after = (sorted(int(item.get("id")) for item in root.findall(path)) for root in (usual, negated))
        assert after == [-number for number in reversed(before)]
    for path, first, last in ((".//laneLink", "from", "to"), (".//validity", "fromLane", "toLane")):
        pairs = [
            [(int(item.get(first)), int(item.get(last))) for item in root.findall(path)] for root in (usual, negated)
        ]
        assert pairs[1] == [(-b, -a) if first == "fromLane" else (-a, -b) for a, b in pairs[0]]
        assert pairs[0]
    # Lanes stand where their ids say, from left to right, and carry what they carried.
    for section in negated.iter("laneSection"):
        sides = {side.tag: [int(item.get("id")) for item in side] for side in section}
        assert all(min(sides.get("left", [1])) > 0 > max(sides.get("right", [-1])) for _ in sides)
        ids = [number for side in ("left", "center", "right") for number in sides.get(side, [])]
        assert ids == sorted(ids, reverse=True)
    for one, other in zip(usual.iter("laneSection"), negated.iter("laneSection"), strict=True):
        widths = {int(item.get("id")): [width.items() for width in item.iter("width")] for item in one.iter("lane")}
        mirrored = {
            -int(item.get("id")): [width.items() for width in item.iter("width")] for item in other.iter("lane")
        }
        assert widths == mirrored
    # What does not follow lane ids stays.
    for path in ("road/planView", "road/lanes/laneOffset", "road/elevationProfile"):
        texts = [[etree.tostring(item) for item in root.findall(path)] for root in (usual, negated)]
        assert texts[0] == texts[1]
    assert {item.get("rule") for item in negated.iter("road")} == {"LHT"}
    assert found.counts()[Kind.NOTE, "left-hand-negated"] == 1
    data = {item.get("code"): item.get("value") for item in negated.findall("header/userData")}
    assert data["lanes"] == "negated"
    assert "lanes" not in {item.get("code") for item in usual.findall("header/userData")}


def test_right_hand_traffic_keeps_its_lane_ids_for_sumo() -> None:
    found = written(crossing(), WriteOptions(target=TARGETS["sumo"]))
    access = b'<access sOffset="0" rule="allow" restriction="bus"/>'
    assert found.replace(access, b"") == written(crossing()).replace(b'type="bus"', b'type="driving"')


def test_every_road_gets_its_own_records() -> None:
    count = 2300  # more than are formatted at a time
    roads = parsed(written(straight_roads(count))).findall("road")
    assert [road.get("name") for road in roads] == [str(index) for index in range(count)]
    assert [float(road.find("planView/geometry").get("x")) for road in roads] == [float(i) for i in range(count)]
    assert roads[0].find("elevationProfile") is None
    heights = [float(road.find("elevationProfile/elevation").get("a")) for road in roads[1:]]
    assert heights == [i / 8 for i in range(1, count)]
    assert [len(road.findall("lanes/laneOffset")) for road in roads] == [i % 3 for i in range(count)]


def test_what_is_not_finite_is_refused() -> None:
    road_map = straight_roads(3)
    heights = road_map.elevation.a.copy()
    heights[1] = math.nan
    stream = io.BytesIO()
    with pytest.raises(OutputError, match=r"road 2 \(way/102\) has a number that is not finite in its elevation"):
        write_xodr(
            replace(road_map, elevation=replace(road_map.elevation, a=heights)), stream, WriteOptions(), Diagnostics()
        )
    assert stream.getvalue() == b""


@pytest.mark.parametrize("version", ["1.4", "1.7"])
def test_several_processes_write_the_same_bytes(monkeypatch: pytest.MonkeyPatch, version: str) -> None:
    # Blocks of one road, so that a small map is dealt out to several processes in several rounds.
    monkeypatch.setattr("osm2xodr.xodrWriter.document._ROADS_PER_BLOCK", 1)
    monkeypatch.setattr("osm2xodr.xodrWriter.document._BLOCKS_PER_PROCESS", 2)
    road_map = straight_roads(21)
    # A word that the first version lacks, where another process than this one writes it.
    roads = [replace(road, types=(RoadType(0.0, "townPrivate", None),) * (road.id == 4)) for road in road_map.roads]
    road_map = replace(road_map, roads=tuple(roads))
    found = []
    for jobs in (1, 2, 3):
        stream, diagnostics = io.BytesIO(), Diagnostics()
        write_xodr(road_map, stream, WriteOptions(version), diagnostics, jobs)
        found.append((stream.getvalue(), list(diagnostics)))
    assert found[1] == found[2] == found[0]
    assert found[0][0].count(b"</road>") == 21
    assert [item.code for item in found[0][1]] == ["word-lost"] * (version == "1.4")


# ---------------------------------------------------------------- bounds


def test_bounds_of_a_line() -> None:
    plan = plan_view([[(0.0, 1.0, 2.0, math.pi / 6.0, 10.0, 0.0)]])
    assert plan_view_bounds(plan) == pytest.approx((1.0, 2.0, 1.0 + 10.0 * math.sqrt(0.75), 7.0), abs=1e-12)


@pytest.mark.parametrize(
    ("hdg", "turn", "bounds"),
    [
        # A half circle of radius 5 m from the origin: what it reaches, by its start heading and sense.
        (0.0, 1, (0.0, 0.0, 5.0, 10.0)),
        (0.0, -1, (0.0, -10.0, 5.0, 0.0)),
        (math.pi / 2.0, 1, (-10.0, 0.0, 0.0, 5.0)),
        (math.pi, 1, (-5.0, -10.0, 0.0, 0.0)),
        (-math.pi / 2.0, -1, (-10.0, -5.0, 0.0, 0.0)),
        (5.0 * math.pi / 2.0, 1, (-10.0, 0.0, 0.0, 5.0)),
    ],
)
def test_bounds_of_half_circles(hdg: float, turn: int, bounds: tuple[float, float, float, float]) -> None:
    plan = plan_view([[(0.0, 0.0, 0.0, hdg, 5.0 * math.pi, turn / 5.0)]])
    assert plan_view_bounds(plan) == pytest.approx(bounds, abs=1e-9)


def test_bounds_of_a_whole_circle() -> None:
    plan = plan_view([[(0.0, 3.0, 4.0, 1.0, 2.0 * math.pi * 7.0, -1.0 / 7.0)]])
    x, y = 3.0 + 7.0 * math.sin(1.0), 4.0 - 7.0 * math.cos(1.0)
    assert plan_view_bounds(plan) == pytest.approx((x - 7.0, y - 7.0, x + 7.0, y + 7.0), abs=1e-9)


@given(
    st.floats(min_value=-10.0, max_value=10.0),
    st.one_of(st.floats(min_value=-0.3, max_value=0.3), st.floats(min_value=-1e-9, max_value=1e-9)),
    st.floats(min_value=0.1, max_value=100.0),
)
def test_bounds_of_arcs_against_many_points_on_them(hdg: float, curvature: float, length: float) -> None:
    west, south, east, north = plan_view_bounds(plan_view([[(0.0, 10.0, -20.0, hdg, length, curvature)]]))
    ds = np.linspace(0.0, length, 20001)
    half = 0.5 * curvature * ds
    x = 10.0 + ds * np.sinc(half / np.pi) * np.cos(hdg + half)
    y = -20.0 + ds * np.sinc(half / np.pi) * np.sin(hdg + half)
    # Between two of the points an arc of these curvatures rises by less than this.
    rise = abs(curvature) * (length / 20000.0) ** 2 + 1e-9
    assert west == pytest.approx(x.min(), abs=rise)
    assert south == pytest.approx(y.min(), abs=rise)
    assert east == pytest.approx(x.max(), abs=rise)
    assert north == pytest.approx(y.max(), abs=rise)


def test_sumo_gets_signs_in_the_order_in_which_traffic_meets_them() -> None:
    def sign(number: int, s: float, orientation: str, *, derived: bool = False) -> Signal:
        words = ("", "205", "-1", "DE")
        return Signal(
            number, 1, s, 0.0, *words, dynamic=False, orientation=orientation, z_offset=2.0, height=0.6, width=0.6,
            derived=derived,
        )  # fmt: skip

    signs = (sign(1, 5.0, "-", derived=True), sign(2, 5.0, "+"), sign(3, 9.0, "-"), sign(4, 9.0, "+"))
    road_map = replace(crossing(), furniture=Furniture(signals=signs))
    for target, order in (("generic", ["1", "2", "3", "4"]), ("sumo", ["2", "4", "3", "1"])):
        signals = parsed(written(road_map, WriteOptions(target=TARGETS[target]))).findall("road/signals/signal")
        assert [item.get("id") for item in signals] == order
        data = {item.get("id"): item.find("userData") for item in signals}
        assert (data["1"].get("code"), data["1"].get("value")) == ("derived", "priority")
        assert [data[number] for number in ("2", "3", "4")] == [None] * 3


@pytest.mark.parametrize(
    ("widths", "heights"),
    [
        ((Cubic(0.0, 2.0),), [("0", "0.1")]),
        # Only what stays without width lies at the road's height.
        ((Cubic(0.0, 0.0), Cubic(5.0, 0.0, 0.2), Cubic(15.0, 2.0)), [("0", "0"), ("5", "0.1")]),
        ((Cubic(0.0, 2.0), Cubic(5.0, 2.0, -0.2), Cubic(15.0, 0.0)), [("0", "0.1"), ("15", "0")]),
    ],
)
def test_raised_lanes_are_level_where_they_have_no_width(
    widths: tuple[Cubic, ...], heights: list[tuple[str, str]]
) -> None:
    road_map = crossing()
    section = road_map.roads[0].lane_sections[0]
    lane = replace(section.lanes[-1], height=0.1, widths=widths)
    road = replace(road_map.roads[0], lane_sections=(replace(section, lanes=(*section.lanes[:-1], lane)),))
    root = parsed(written(replace(road_map, roads=(road, *road_map.roads[1:]))))
    found = root.find(f".//lane[@id='{lane.id}']").iterfind("height")
    assert [(item.get("sOffset"), item.get("outer")) for item in found] == heights


def test_stretches_without_measured_heights_are_marked() -> None:
    gaps = Stretches(np.array([0, 2, 2, 2, 3]), np.array([0.0, 50.25, 0.0]), np.array([10.0, 70.0, 10.0]))
    roads = parsed(written(replace(crossing(), unmeasured=gaps))).findall("road")
    found = [road.find("userData[@code='unmeasured_heights']") for road in roads]
    assert [None if item is None else item.get("value") for item in found] == ["0 10 50.25 70", None, None, "0 10"]
    assert [item.tag for item in roads[0]][-1] == "userData"


@given(st.floats(-10.0, 10.0), st.floats(-0.05, 0.05), st.floats(-0.05, 0.05))
def test_bounds_of_spirals_against_many_points_on_them(hdg: float, first: float, last: float) -> None:
    """One of 60 m from one curvature to another."""
    plan = plan_view([[(0.0, 10.0, -20.0, hdg, 60.0, first)]])
    plan = replace(plan, rate=np.array([(last - first) / 60.0]))
    s = np.linspace(0.0, 60.0, 20001)
    x, y, _ = pose(plan, np.zeros(len(s), np.int64), s)
    assert plan_view_bounds(plan) == pytest.approx((x.min(), y.min(), x.max(), y.max()), abs=1e-6)

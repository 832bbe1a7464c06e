"""Signals, objects and controllers as they are written, parsed back."""

from __future__ import annotations

import cmath
import io
import math
from dataclasses import replace
from typing import Any

import pytest
from lxml import etree
from sample_road_maps import crossing, furnished_crossing

from osm2xodr.conventions.targets import TARGETS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import OutputError
from osm2xodr.model import Controller, Furniture, LaneType, ObjectRepeat, RoadMap, RoadObject, RoadStructure, Signal
from osm2xodr.xodrWriter import VERSIONS, WriteOptions, write_xodr
from osm2xodr.xodrWriter.furniture_text import junction_controllers


def written(road_map: RoadMap, options: WriteOptions | None = None, diagnostics: Diagnostics | None = None) -> bytes:
    stream = io.BytesIO()
    options = WriteOptions() if options is None else options
    write_xodr(road_map, stream, options, Diagnostics() if diagnostics is None else diagnostics)
    return stream.getvalue()


def parsed(road_map: RoadMap, options: WriteOptions | None = None) -> Any:
    return etree.fromstring(written(road_map, options))


def with_object(item: RoadObject) -> RoadMap:
    return replace(furnished_crossing(), furniture=Furniture(objects=(item,)))


def with_signal(signal: Signal) -> RoadMap:
    return replace(furnished_crossing(), furniture=Furniture(signals=(signal,)))


def test_signals_stand_in_their_roads() -> None:
    roads = parsed(furnished_crossing()).findall("road")
    assert [[item.get("id") for item in road.iter("signal")] for road in roads] == [["1", "3"], ["2"], [], []]
    light, limit = roads[0].iter("signal")
    assert dict(light.attrib) == {
        "name": "light",
        "id": "1",
        "s": "98",
        "t": "-4.5",
        "dynamic": "yes",
        "orientation": "+",
        "zOffset": "2.2",
        "country": "OpenDRIVE",
        "type": "1000001",
        "subtype": "-1",
        "height": "1",
        "width": "0.3",
    }
    assert [dict(item.attrib) for item in light] == [
        {"fromLane": "-2", "toLane": "-1"},
        {"code": "osm_id", "value": "node/42"},
    ]
    assert (limit.get("value"), limit.get("unit"), limit.get("hOffset")) == ("70", "km/h", "0.1")
    assert limit.get("text") == '"70" & <mehr>'
    assert limit.get("dynamic") == "no"
    assert len(limit) == 0


@pytest.mark.parametrize(("target", "ranges"), [("generic", [("-4", "-3"), ("-1", "-1")]), ("sumo", [("-4", "-1")])])
def test_signals_have_one_range_of_lanes_for_sumo(target: str, ranges: list[tuple[str, str]]) -> None:
    light = replace(furnished_crossing().furniture.signals[0], validity=((-4, -3), (-1, -1)))
    found = parsed(with_signal(light), WriteOptions(target=TARGETS[target])).iter("validity")
    assert [(item.get("fromLane"), item.get("toLane")) for item in found] == ranges


def test_references_follow_the_signals_of_a_road() -> None:
    road = parsed(furnished_crossing()).findall("road")[2]
    (reference,) = road.find("signals")
    assert reference.tag == "signalReference"
    assert dict(reference.attrib) == {"id": "1", "s": "0", "t": "-4.5", "orientation": "+"}
    assert dict(reference.find("validity").attrib) == {"fromLane": "-1", "toLane": "-1"}


def test_all_junctions_of_a_controller_name_it() -> None:
    found = junction_controllers([Controller(1, "phase 1", (1, 2), 5, 0, further_junctions=(6, 8))])
    assert found == dict.fromkeys((5, 6, 8), '<controller id="1" type="traffic" sequence="0"/>\n')


def test_controllers_stand_between_roads_and_junctions() -> None:
    root = parsed(furnished_crossing())
    assert [item.tag for item in root] == ["header", *["road"] * 4, "controller", "controller", "junction"]
    first, second = root.findall("controller")
    assert dict(first.attrib) == {"id": "1", "name": "along", "sequence": "0"}
    assert [item.get("signalId") for item in first] == ["1", "2"]
    assert [dict(item.attrib) for item in second] == [{"signalId": "3", "type": "pedestrian"}]
    junction = root.find("junction")
    assert [dict(item.attrib) for item in junction.findall("controller")] == [
        {"id": "1", "type": "traffic", "sequence": "0"}
    ]
    assert junction[-1].tag == "controller"


def test_parts_of_roads_are_in_order() -> None:
    roads = parsed(furnished_crossing()).findall("road")
    assert [item.tag for item in roads[1]][-5:] == ["lanes", "objects", "signals", "userData", "userData"]
    provenance = [{item.get("code"): item.get("value") for item in road.findall("userData")} for road in roads]
    assert provenance == [
        {"osm_way_ids": "111 112"},
        {"osm_way_ids": "113", "guessed": "lanes-guessed width-guessed"},
        {},
        {},
    ]


def test_objects() -> None:
    first, second, *_ = parsed(furnished_crossing()).findall("road")
    assert [(item.get("type"), item.get("subtype")) for item in first.iter("object")] == [
        ("crosswalk", "zebra"),
        ("roadMark", "signalLines"),
        ("patch", "speedBump"),
    ]
    line = first.findall("objects/object")[1]
    assert (line.get("length"), line.get("width"), line.get("height"), line.get("hdg")) == ("0.5", "3", None, "0")
    lamp = second.find("objects/object")
    assert (lamp.get("radius"), lamp.get("length"), lamp.get("width")) == ("0.15", None, None)
    assert {key: float(value) for key, value in lamp.find("repeat").attrib.items()} == {
        "s": 0.0,
        "length": 60.0,
        "distance": 20.0,
        "tStart": -5.0,
        "tEnd": -5.0,
        "heightStart": 6.0,
        "heightEnd": 6.0,
        "zOffsetStart": 0.0,
        "zOffsetEnd": 0.0,
        "widthStart": 0.3,
        "widthEnd": 0.3,
    }


def test_speed_bumps_have_their_own_type_since_1_8() -> None:
    found = Diagnostics()
    kinds = {}
    for version in VERSIONS:
        root = etree.fromstring(written(furnished_crossing(), WriteOptions(version), found))
        kinds[version] = {item.get("type") for item in root.iter("object")} & {"patch", "roadSurface"}
    assert kinds == {"1.4": {"patch"}, "1.6": {"patch"}, "1.7": {"patch"}, "1.8": {"roadSurface"}}
    lost = [item.message for item in found if item.code == "word-lost"]
    assert "OpenDRIVE 1.7 has no 'roadSurface': written as 'patch'" in lost


def test_1_4_has_names_in_place_of_subtypes() -> None:
    root = parsed(furnished_crossing(), WriteOptions("1.4"))
    objects = {item.get("id"): item for item in root.iter("object")}
    assert {item.get("subtype") for item in objects.values()} == {None}
    assert (objects["4"].get("name"), objects["5"].get("name")) == ("zebra", "StopLine")
    assert list(root.iter("outlines")) == []


def corners(outline: Any) -> list[tuple[float, float]]:
    return [(float(item.get("u")), float(item.get("v"))) for item in outline]


def test_crosswalks_are_where_each_reader_looks() -> None:
    meant = [(-3.5, 2.0), (3.5, 2.0), (3.5, -2.0), (-3.5, -2.0)]
    # At s = 80 the lane offset of road 1 is 7/54 m; u is across the road.
    offset = 0.5 - 1.5 / 60.0**2 * 40.0**2 + 40.0**3 / 60.0**3
    # Its slope there is -1/90, by which CARLA turns what it reads.
    turned = [complex(u - offset, v) * cmath.rect(1.0, 1.0 / 90.0) for u, v in (*meant, meant[0])]
    moved = [(corner.real, corner.imag) for corner in turned]
    found = {}
    for name, target in TARGETS.items():
        (item,) = (
            item
            for item in parsed(furnished_crossing(), WriteOptions(target=target)).iter("object")
            if item.get("type") == "crosswalk"
        )
        old, new = item.find("outline"), item.find("outlines/outline")
        found[name] = (old is not None, new is not None)
        if old is not None:
            assert corners(old) == [pytest.approx(corner, abs=6e-4) for corner in moved]
            assert old.get("closed") == "true"
        if new is not None:
            assert corners(new) == meant
            assert (new.get("id"), new.get("closed")) == ("0", "true")
    assert found == {
        "generic": (True, True),
        "carla": (True, False),
        "esmini": (False, True),
        "sumo": (False, True),
        "roadrunner": (False, True),
    }


def test_objects_name_elements_of_osm_but_for_esmini() -> None:
    lamp = RoadObject(9, 1, "streetLamp", "", "", 80.0, 0.0, osm_id="node/5")
    named = {
        name: [
            item.get("value")
            for item in parsed(with_object(lamp), WriteOptions(target=target)).iterfind(
                "road/objects/object/userData[@code='osm_id']"
            )
        ]
        for name, target in TARGETS.items()
    }
    assert named == {name: [] if name == "esmini" else ["node/5"] for name in TARGETS}


@pytest.mark.parametrize(("target", "shift", "turn"), [("generic", 0.0, 0.0), ("carla", 7.0 / 54.0, 1.0 / 90.0)])
def test_1_4_has_one_outline(target: str, shift: float, turn: float) -> None:
    root = parsed(furnished_crossing(), WriteOptions("1.4", target=TARGETS[target]))
    (outline,) = root.iter("outline")
    first = complex(-3.5 - shift, 2.0) * cmath.rect(1.0, turn)
    assert corners(outline)[0] == pytest.approx((first.real, first.imag), abs=6e-4)
    assert corners(outline)[-1] == corners(outline)[0]
    assert outline.get("closed") is None


def test_outlines_of_other_things_are_the_standards() -> None:
    square = ((0.0, 0.0, 0.0, 0.2), (1.0, 0.0, 0.0, 0.2), (1.0, 1.0, 0.1, 0.2), (0.0, 0.0, 0.0, 0.2))
    island = RoadObject(9, 1, "trafficIsland", "", "", 80.0, 0.0, outline=square)
    (item,) = parsed(with_object(island)).iter("object")
    assert [child.tag for child in item] == ["outlines"]
    assert [dict(corner.attrib) for corner in item.iter("cornerLocal")] == [
        {"u": "0", "v": "0", "z": "0", "height": "0.2"},
        {"u": "1", "v": "0", "z": "0", "height": "0.2"},
        {"u": "1", "v": "1", "z": "0.1", "height": "0.2"},
    ]


def test_heights_of_lanes() -> None:
    lanes = {item.get("type"): item for item in parsed(furnished_crossing()).findall("road")[1].iter("lane")}
    sidewalk = lanes["sidewalk"]
    assert [item.tag for item in sidewalk] == ["width", "roadMark", "height"]
    assert dict(sidewalk.find("height").attrib) == {"sOffset": "0", "inner": "0.12", "outer": "0.12"}
    assert lanes["driving"].find("height") is None
    assert "curb" in lanes
    old = parsed(furnished_crossing(), WriteOptions("1.4")).findall("road")[1]
    assert {item.get("type") for item in old.iter("lane")} == {"driving", "none", "sidewalk", "border"}
    assert LaneType.SIDEWALK.value == "sidewalk"


def test_nothing_is_written_where_nothing_stands() -> None:
    root = parsed(crossing())
    assert list(root.iter("objects", "signals", "controller")) == []


def test_the_end_of_a_road_is_not_passed_by_rounding() -> None:
    light = furnished_crossing().furniture.signals[-1]
    end = 80.0 + 10.0 * math.pi
    (signal,) = parsed(with_signal(replace(light, s=end))).iter("signal")
    road = signal.getparent().getparent()
    assert float(signal.get("s")) <= float(road.get("length"))
    assert float(signal.get("s")) == pytest.approx(end, abs=1e-3)
    fence = ObjectRepeat(end - 20.0, 20.0 + 4e-4, 0.0, 5.0, 5.0, 0.1, 1.0)
    (repeat,) = parsed(with_object(RoadObject(1, 2, "barrier", "", "", end, 5.0, repeat=fence))).iter("repeat")
    assert float(repeat.get("s")) + float(repeat.get("length")) <= float(road.get("length")) + 1e-9


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"orientation": "both"}, "no orientation 'both'"),
        ({"value": 3.0, "unit": "kn"}, "no unit 'kn'"),
        ({"country": "Germany"}, "no country 'Germany'"),
    ],
)
def test_words_of_no_version_are_refused(change: dict[str, Any], message: str) -> None:
    signal = replace(furnished_crossing().furniture.signals[0], **change)
    with pytest.raises(OutputError, match=message):
        written(with_signal(signal))


def test_objects_of_no_type_are_refused() -> None:
    with pytest.raises(OutputError, match="no object type 'bench'"):
        written(with_object(RoadObject(1, 1, "bench", "", "", 5.0, 0.0)))


def test_sumo_gets_no_lanes_to_park_on() -> None:
    road_map = furnished_crossing()
    second = road_map.roads[1]
    (section,) = second.lane_sections
    lanes = tuple(replace(lane, type=LaneType.PARKING) if lane.id == -3 else lane for lane in section.lanes)
    second = replace(second, lane_sections=(replace(section, lanes=lanes),))
    parked = replace(road_map, roads=(road_map.roads[0], second, *road_map.roads[2:]))
    found = Diagnostics()
    kinds = {
        name: etree.fromstring(written(parked, WriteOptions(target=target), found)).findall("road")[1]
        for name, target in TARGETS.items()
    }
    types = {
        name: {lane.get("type") for lane in road.iter("lane")} & {"parking", "shoulder"}
        for name, road in kinds.items()
    }
    assert types == {name: {"shoulder"} if name == "sumo" else {"parking"} for name in TARGETS}
    assert [item.message for item in found if item.code == "word-for-reader"] == [
        "'bus' is written as 'restricted', as --target esmini wants",
        "'bus' is written as 'driving', as --target sumo wants",
        "'parking' is written as 'shoulder', as --target sumo wants",
    ]


@pytest.mark.parametrize("version", VERSIONS)
def test_bridges_and_tunnels_stand_behind_the_objects(version: str) -> None:
    bridge = RoadStructure(51, 1, 10.0, 20.0, "bridge", "steel", 'A & "B"', osm_way_ids=(5, 6))
    tunnel = RoadStructure(52, 1, 40.0, 60.0004, "tunnel", "underpass", lighting=1.0, daylight=0.5)
    whole = furnished_crossing()
    furniture = replace(whole.furniture, structures=(bridge, tunnel))
    objects = parsed(replace(whole, furniture=furniture), WriteOptions(version=version)).find("road/objects")
    assert [item.tag for item in objects][-3:] == ["object", "tunnel", "bridge"]
    *_, under, over = objects
    assert dict(over.attrib) == {"id": "51", "name": 'A & "B"', "s": "10", "length": "20", "type": "steel"}
    assert [dict(item.attrib) for item in over] == [{"code": "osm_way_ids", "value": "5 6"}]
    # It ends where the road does.
    assert dict(under.attrib) == {
        "id": "52",
        "s": "40",
        "length": "60",
        "type": "underpass",
        "lighting": "1",
        "daylight": "0.5",
    }
    assert len(under) == 0


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_furniture_with_a_number_that_is_not_finite_is_refused(value: float) -> None:
    square = ((0.0, 0.0, 0.0, 0.0), (1.0, 0.0, value, 0.0), (1.0, 1.0, 0.0, 0.0))
    for item in (
        RoadObject(1, 1, "tree", "", "", 10.0, value),
        RoadObject(1, 1, "tree", "", "", 10.0, 0.0, height=value),
        RoadObject(1, 1, "tree", "", "", 10.0, 0.0, hdg=value),
        RoadObject(1, 1, "patch", "", "", 10.0, 0.0, outline=square),
    ):
        with pytest.raises(OutputError, match=r"not finite.*this is a defect of osm2xodr"):
            written(with_object(item))

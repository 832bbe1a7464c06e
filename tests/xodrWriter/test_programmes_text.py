"""Signal programmes as SUMO reads them: names of edges and lanes, and where netconvert cuts roads."""

from __future__ import annotations

from dataclasses import replace

import pytest
from lxml import etree
from sample_road_maps import furnished_crossing

from osm2xodr.conventions import TARGETS
from osm2xodr.model import (
    Cubic,
    Furniture,
    Lane,
    LaneSection,
    LaneType,
    Road,
    RoadMap,
    Rule,
    SignalLink,
    SignalPhase,
    SignalProgramme,
)
from osm2xodr.xodrWriter import WriteOptions, signal_programmes

PHASES = (SignalPhase("Gg", 40.0, (5.0, 50.0)), SignalPhase("yy", 3.0), SignalPhase("rr", 1.0))


def sections(*widths: tuple[float, tuple[Cubic, ...]]) -> tuple[LaneSection, ...]:
    """Lane sections of two lanes along the road, the inner one of changing width, beside a sidewalk."""
    centre, full = Lane(0, LaneType.NONE, ()), (Cubic(0.0, 3.0),)
    return tuple(
        LaneSection(
            s,
            (
                centre,
                Lane(-1, LaneType.DRIVING, inner),
                Lane(-2, LaneType.DRIVING, full),
                Lane(-3, LaneType.SIDEWALK, full),
            ),
        )
        for s, inner in widths
    )


def crossing(*made: LaneSection, links: tuple[SignalLink, ...], rule: Rule = Rule.RIGHT_HAND) -> RoadMap:
    """A crossing whose first road has other lane sections, and a programme."""
    found = furnished_crossing()
    road: Road = replace(found.roads[0], lane_sections=made)
    furniture = Furniture(programmes=(SignalProgramme(7, links, PHASES, 50.0),))
    return replace(found, roads=(road, *found.roads[1:]), rule=rule, furniture=furniture)


def connections(road_map: RoadMap) -> list[str]:
    text = signal_programmes(road_map, WriteOptions(target=TARGETS["sumo"]))
    root = etree.fromstring(text)
    return [f"{item.get('from')}_{item.get('fromLane')}" for item in root.iterfind("connection")]


def link(connecting_road: int, lane: int, exit_lane: int = -1) -> SignalLink:
    return SignalLink(connecting_road, 1, True, lane, 1, True, exit_lane)


@pytest.mark.parametrize(
    ("widths", "edge"),
    [
        ([(0.0, (Cubic(0.0, 3.0),))], "-1"),
        ([(0.0, (Cubic(0.0, 3.0),)), (40.0, (Cubic(0.0, 3.0),))], "-1#1"),
        # Where the lane gets wider than 1.8 m, and narrower again.
        ([(0.0, (Cubic(0.0, 0.0, 0.1), Cubic(30.0, 3.0)))], "-1#1"),
        ([(0.0, (Cubic(0.0, 0.0, 0.1), Cubic(30.0, 3.0, -0.1), Cubic(60.0, 0.0)))], "-1#2"),
        # Not where that would leave less than 2 m, and sections at the same place are one.
        ([(0.0, (Cubic(0.0, 0.0, 1.0), Cubic(3.0, 3.0)))], "-1"),
        ([(0.0, (Cubic(0.0, 3.0),)), (0.05, (Cubic(0.0, 3.0),))], "-1"),
    ],
)
def test_edges_have_the_number_of_their_section(widths: list[tuple[float, tuple[Cubic, ...]]], edge: str) -> None:
    road_map = crossing(*sections(*widths), links=(link(3, -1, -1), link(4, -2, -2)))
    assert connections(road_map) == [f"{edge}_1", f"{edge}_0"]


def test_of_lanes_that_lead_to_one_netconvert_keeps_the_first_by_name() -> None:
    flat = sections((0.0, (Cubic(0.0, 3.0),)))
    assert connections(crossing(*flat, links=(link(9, -1), link(10, -2)))) == ["-1_0"]
    assert connections(crossing(*flat, links=(link(9, -1), link(90, -2)))) == ["-1_1"]


def test_lanes_for_buses_count_and_give_way_to_those_for_cars() -> None:
    (flat,) = sections((0.0, (Cubic(0.0, 3.0),)))
    buses = replace(flat, lanes=(*flat.lanes[:2], replace(flat.lanes[2], type=LaneType.BUS), *flat.lanes[3:]))
    # By its id, the way from the lane for buses would come first of those that lead to one lane.
    assert connections(crossing(buses, links=(link(3, -2), link(4, -1)))) == ["-1_1"]
    assert connections(crossing(flat, links=(link(3, -2), link(4, -1)))) == ["-1_0"]


def test_a_programme() -> None:
    flat = sections((0.0, (Cubic(0.0, 3.0),)))
    road_map = crossing(*flat, links=(link(3, -1, -1), link(4, -2, -2)))
    root = etree.fromstring(signal_programmes(road_map, WriteOptions(target=TARGETS["sumo"])))
    logic = next(root.iterfind("tlLogic"))
    assert {str(k): str(v) for k, v in logic.items()} == {
        "id": "7",
        "type": "delay_based",
        "programID": "0",
        "offset": "0",
    }
    assert [dict(item.attrib) for item in logic] == [
        {"key": "detectorRange", "value": "50"},
        {"duration": "40", "minDur": "5", "maxDur": "50", "state": "Gg"},
        {"duration": "3", "state": "yy"},
        {"duration": "1", "state": "rr"},
    ]
    first = next(root.iterfind("connection"))
    named = {"from": "-1", "to": "-1", "fromLane": "1", "toLane": "1"}
    assert {str(k): str(v) for k, v in first.items()} == {**named, "tl": "7", "linkIndex": "0"}


def test_without_lights_there_is_nothing_to_write() -> None:
    assert signal_programmes(furnished_crossing(), WriteOptions(target=TARGETS["sumo"])) == b""

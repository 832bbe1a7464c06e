"""Lights, signs, stop lines, crosswalks and priorities as regulatory elements."""

from __future__ import annotations

from pathlib import Path

import pytest
from lanelet_text import Written, written
from xodr_text import document, geometry, read_text, road

LIGHT = 'name="" dynamic="yes" country="OpenDRIVE" type="1000001" subtype="-1" zOffset="4" height="0.9" width="0.4"'
STOP = '<object id="3" type="roadMark" subtype="stopLine" s="90" t="-1.75" orientation="+" hdg="0" width="3.5"/>'


def one_road(folder: Path, signals: str = "", objects: str = "") -> Written:
    more = f"<objects>{objects}</objects><signals>{signals}</signals>"
    return written(read_text(folder, document(road(more=more))))


def light(orientation: str = "+", more: str = "") -> str:
    return f'<signal id="7" s="92" t="-4" orientation="{orientation}" {LIGHT}>{more}</signal>'


def test_a_light_has_its_stop_line(tmp_path: Path) -> None:
    found = one_road(tmp_path, light(), STOP)
    (rule,) = found.rules("traffic_light")
    assert found.members(found.lanelet("1", "-1"), "regulatory_element") == [rule]
    assert found.members(found.lanelet("1", "1"), "regulatory_element") == []
    (body,), (line,) = found.members(rule, "refers"), found.members(rule, "ref_line")
    # From left to right as drivers see it, the lower edge.
    assert found.points(body) == [(92, -3.8, 4), (92, -4.2, 4)]
    assert found.tags[body] == {"type": "traffic_light", "subtype": "red_yellow_green", "height": "0.9"}
    assert found.points(line) == [(90, 0, 0), (90, -3.5, 0)]
    assert found.tags[line] == {"type": "stop_line", "subtype": "solid"}


def test_a_light_without_a_stop_line_stops_where_it_stands(tmp_path: Path) -> None:
    # The stop line is for the other direction.
    found = one_road(tmp_path, light(), STOP.replace('orientation="+"', 'orientation="-"'))
    (rule,) = found.rules("traffic_light")
    assert found.points(found.members(rule, "ref_line")[0]) == [(92, 0, 0), (92, -3.5, 0)]


def test_lights_against_s_and_for_lanes(tmp_path: Path) -> None:
    found = one_road(tmp_path, light("-"))
    (rule,) = found.rules("traffic_light")
    assert found.members(found.lanelet("1", "1"), "regulatory_element") == [rule]
    assert found.points(found.members(rule, "refers")[0]) == [(92, -4.2, 4), (92, -3.8, 4)]
    # A light that holds for no lane of its direction.
    found = one_road(tmp_path, light("+", '<validity fromLane="1" toLane="1"/>'))
    assert found.rules("traffic_light") == []
    assert found.lost == ["left out because they hold for no lanelet or have no usable place: 1 lights"]


def test_references_hold_where_they_stand(tmp_path: Path) -> None:
    reference = '<signalReference id="7" s="5" t="-4" orientation="+"/>'
    roads = [
        road("1", more=f"<signals>{light()}</signals>"),
        road("2", geometry("<line/>", 20.0, x=100.0), 20.0, more=f"<signals>{reference}</signals>"),
    ]
    found = written(read_text(tmp_path, document(*roads)))
    (rule,) = found.rules("traffic_light")
    for name in ("1", "2"):
        assert found.members(found.lanelet(name, "-1"), "regulatory_element") == [rule]


def test_signs(tmp_path: Path) -> None:
    sign = '<signal id="1" s="40" t="-5" orientation="+" dynamic="no" country="DE" type="274" subtype="50"/>'
    found = one_road(tmp_path, sign)
    (rule,) = found.rules("traffic_sign")
    (body,) = found.members(rule, "refers")
    assert found.tags[body]["type"] == "traffic_sign"
    assert found.tags[body]["subtype"] == "de274-50"
    assert found.members(rule, "ref_line") == []


@pytest.mark.parametrize("turn", [False, True])
def test_crosswalks_are_lanelets_across_the_road(tmp_path: Path, turn: bool) -> None:
    corners = [(-2, -3.5), (2, -3.5), (2, 3.5), (-2, 3.5)]
    corners = corners[::-1] if turn else corners
    text = "".join(f'<cornerLocal u="{u}" v="{v}" z="0" height="0"/>' for u, v in corners)
    crosswalk = (
        f'<object id="5" type="crosswalk" subtype="zebra" s="50" t="0" hdg="0"><outline>{text}</outline></object>'
    )
    found = one_road(tmp_path, objects=crosswalk)
    (number,) = (one for one in found.relations if found.tags[one]["subtype"] == "crosswalk")
    left, right = (found.points(found.bound(number, side)) for side in ("left", "right"))
    # Who walks to the left across the road has the begin of the road on the left.
    assert left == [(48, -3.5, 0), (48, 3.5, 0)]
    assert right == [(52, -3.5, 0), (52, 3.5, 0)]
    assert found.tags[number]["participant:pedestrian"] == "yes"
    assert found.tags[number]["one_way"] == "no"
    assert found.tags[found.bound(number, "left")]["type"] == "zebra_marking"


def test_crosswalks_without_an_outline(tmp_path: Path) -> None:
    sized = '<object id="5" type="crosswalk" s="50" t="0" hdg="0" length="4" width="7"/>'
    found = one_road(tmp_path, objects=sized)
    (number,) = (one for one in found.relations if found.tags[one]["subtype"] == "crosswalk")
    assert found.points(found.bound(number, "right")) == [(52, -3.5, 0), (52, 3.5, 0)]
    found = one_road(tmp_path, objects='<object id="5" type="crosswalk" s="50" t="0" hdg="0"/>')
    assert found.lost == ["left out because they hold for no lanelet or have no usable place: 1 crosswalks"]


def test_right_of_way(tmp_path: Path) -> None:
    link = '<predecessor elementType="road" elementId="{}" contactPoint="end"/>'
    to = '<successor elementType="junction" elementId="9"/>'
    roads = [
        road("1", link=to, more=f"<objects>{STOP}</objects>"),
        road("2", geometry("<line/>", 20.0, x=100.0), 20.0, junction="9", link=link.format(1)),
        road("3", geometry("<line/>", 20.0, x=100.0, y=-20.0, hdg=1.5), 20.0, junction="9"),
    ]
    junction = (
        '<junction id="9" name=""><connection id="0" incomingRoad="1" connectingRoad="2" contactPoint="start">'
        '<laneLink from="-1" to="-1"/></connection><priority high="3" low="2"/>'
        '<priority high="8" low="2"/></junction>'
    )
    found = written(read_text(tmp_path, document(*roads, junction)))
    (rule,) = found.rules("right_of_way")
    both = [found.lanelet("3", "1"), found.lanelet("3", "-1")]
    assert sorted(found.members(rule, "right_of_way")) == sorted(both)
    assert sorted(found.members(rule, "yield")) == sorted([found.lanelet("2", "1"), found.lanelet("2", "-1")])
    assert found.points(found.members(rule, "ref_line")[0]) == [(90, 0, 0), (90, -3.5, 0)]
    assert all(rule in found.members(one, "regulatory_element") for one in both)

"""Lanes at links: gaps, steps and kinks between them, and their directions.

Connections of junctions: what the standard allows.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from checked import checked
from lxml import etree
from t_junction import Tree, one, road, sound_tree


@pytest.fixture
def tree() -> Tree:
    return sound_tree()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "map.xodr"


def test_lanes_at_links_are_measured(tree: Tree, path: Path) -> None:
    one(tree, "road[@id='4']/planView/geometry").set("y", "0.3")
    one(tree, "road[@id='4']/planView/geometry").set("hdg", str(math.radians(2)))
    one(tree, "road[@id='4']/elevationProfile/elevation").set("a", "10.04")
    one(tree, "road[@id='4']/elevationProfile/elevation").set("b", "0.03")
    found = {(item.rule, item.road, item.lane): item for item in checked(tree, path).findings}
    # Both roads name each other, and each has two lanes.
    places = {("2", 1), ("2", -1), ("4", 1), ("4", -1)}
    for rule in ("lane-gap", "lane-edge-gap", "lane-height-step", "link-kink", "link-grade-step"):
        assert {(road_id, lane) for name, road_id, lane in found if name == rule} == places
    gap = found["lane-gap", "2", -1]
    # The middle of the lane is 1.75 m to the right, and turns with the road: (x, y) = 1.75 (sin 2°, 1 - cos 2°).
    turned = math.hypot(1.75 * math.sin(math.radians(2)), 0.3 + 1.75 * (1 - math.cos(math.radians(2))))
    assert gap.value == pytest.approx(turned, abs=1e-9)
    assert (gap.s, gap.x, gap.y) == (50.0, 60.0, 0.0)
    assert found["lane-height-step", "2", -1].value == pytest.approx(0.04)
    assert found["link-kink", "2", -1].value == pytest.approx(2.0)
    assert found["link-grade-step", "2", -1].value == pytest.approx(3.0)


def test_lanes_turned_round_carry_traffic_the_other_way(tree: Tree, path: Path) -> None:
    assert "lane-link-other-way" not in checked(tree, path).by_rule()
    for lane in road(tree, 10).iter("lane"):
        if lane.get("id") != "0":
            lane.set("direction", "reversed")
    found = [item for item in checked(tree, path).findings if item.rule == "lane-link-other-way"]
    assert {item.road for item in found} == {"1", "10"}
    for lane in road(tree, 10).iter("lane"):
        if lane.get("id") != "0":
            lane.set("direction", "both")
    assert "lane-link-other-way" not in checked(tree, path).by_rule()


def test_what_the_standard_allows_is_no_finding(tree: Tree, path: Path) -> None:
    # A road that goes on through a virtual junction, a crossing without connections, lanes with traffic turned round.
    tree.append(
        etree.fromstring(
            '<junction id="200" name="" type="virtual" mainRoad="4" sStart="10" sEnd="20" orientation="none">'
            '<connection id="0" incomingRoad="4" connectingRoad="5" contactPoint="start">'
            '<laneLink from="-1" to="-1"/></connection></junction>'
        )
    )
    tree.append(etree.fromstring('<junction id="201" name="" type="crossing"/>'))
    aside = etree.fromstring(etree.tostring(road(tree, 4)))
    aside.set("id", "5")
    aside.set("junction", "200")
    aside.remove(one(aside, "link"))
    one(aside, "planView/geometry").set("y", "30")
    link = etree.fromstring('<link><predecessor elementType="road" elementId="4" contactPoint="start"/></link>')
    aside.insert(0, link)
    for lane in aside.iter("lane"):
        one(lane, "link").clear()
    tree.insert(5, aside)
    names = {"incoming-elsewhere", "incoming-road", "connecting-elsewhere", "junction-empty"}
    assert names.isdisjoint(checked(tree, path).by_rule())

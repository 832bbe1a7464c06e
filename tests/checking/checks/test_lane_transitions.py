"""Connections of junctions: what the standard allows."""

from __future__ import annotations

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

"""Boundaries of junctions in files of version 1.8: closed, round all lanes, and kept by crop and merge."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from junction_outlines import outlines
from lxml import etree
from scene_files import SMALL_SCENES, Conversions, Scene, scene_named

import osm2xodr

# Ends of segments meet, m.
MEET = 0.3
# What boundaries may cut off at places where roads bulge out a little, as a share of all places on lanes.
CUT_OFF = 0.002


@pytest.mark.parametrize("scene", SMALL_SCENES, ids=str)
def test_boundaries_are_closed_and_lanes_lie_within(scene: Scene, conversions: Conversions) -> None:
    network, found = outlines(conversions.of(scene, "1.8").path)
    known = {name: outline for name, outline in found.items() if outline is not None}
    assert len(known) >= 0.85 * len(found)
    assert [name for name, outline in known.items() if outline.gap > MEET or outline.area <= 0.0] == []
    inside = []
    for road in network.roads.values():
        outline = known.get(road.junction)
        s = road.length * np.array([0.1, 0.35, 0.5, 0.65, 0.9])
        for number, lane in road.sections[0].lanes.items() if outline is not None else ():
            places = road.lane_middle(0, number, s)[lane.width.value(s) > 0.2]
            inside += [outline is not None and outline.has_inside(x, y) for x, y, _ in places.tolist()]
    assert len(inside) > 50
    assert np.mean(inside) >= 1.0 - CUT_OFF


def test_every_arm_of_a_junction_is_crossed_once(conversions: Conversions) -> None:
    path = conversions.of(scene_named("fremantle_placement"), "1.8").path
    root = etree.parse(path).getroot()
    arms: dict[str, set[tuple[str, str]]] = {}
    for road in root.findall("road"):
        for link in road.findall("link/*") if road.get("junction") != "-1" else ():
            end = str(link.get("elementId")), str(link.get("contactPoint"))
            arms.setdefault(str(road.get("junction")), set()).add(end)
    for junction in root.findall("junction"):
        joints = junction.findall("boundary/segment[@type='joint']")
        crossed = [(str(item.get("roadId")), str(item.get("contactPoint"))) for item in joints]
        assert not crossed or sorted(crossed) == sorted(arms[str(junction.get("id"))])


def test_older_versions_have_none(conversions: Conversions) -> None:
    assert b"<boundary" not in conversions.of(scene_named("fremantle_placement")).path.read_bytes()


def test_parts_and_their_sum_have_those_of_the_whole(conversions: Conversions, tmp_path: Path) -> None:
    whole = conversions.of(scene_named("fremantle_placement"), "1.8").path
    middle = 115.75586
    parts = [
        osm2xodr.crop(whole, tmp_path / "west.xodr", bbox=(115.7, -32.1, middle, -32.0)),
        osm2xodr.crop(whole, tmp_path / "east.xodr", bbox=(middle, -32.1, 115.8, -32.0)),
    ]
    merged = osm2xodr.merge(parts, tmp_path / "merged.xodr")

    def areas(path: Path) -> list[float]:
        found = [item for item in outlines(path)[1].values() if item is not None]
        assert all(item.gap <= MEET for item in found)
        return sorted(item.area for item in found)

    expected = pytest.approx(areas(whole), abs=0.5)
    assert sorted(areas(parts[0]) + areas(parts[1])) == expected
    assert areas(merged) == expected

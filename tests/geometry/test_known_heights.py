"""Corrections of heights: of nodes on roads and in junctions, and of what passes over what."""

from __future__ import annotations

import numpy as np
import pytest
from corrected_cases import build_corrected, node_of, said
from elevation_helpers import Ground
from street_cases import Case

from osm2xodr.curves import cubic_value, lengths, pose
from osm2xodr.model import FloatArray, NodeCorrection, RoadMap, WayCorrection


def slope(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.asarray(100.0 + 0.02 * x + 0.01 * y)


GROUND = Ground(slope, cell_size=10.0, sigma=0.5)


def height_at(road_map: RoadMap, x: float, y: float) -> float:
    """Return the height of the nearest place of a reference line, m."""
    best = (np.inf, np.nan)
    for road, length in enumerate(lengths(road_map.plan_view).tolist()):
        s = np.linspace(0.0, length, 200)
        index = np.full(len(s), road)
        px, py, _ = pose(road_map.plan_view, index, s)
        distance = np.hypot(px - x, py - y)
        k = int(np.argmin(distance))
        best = min(
            best, (float(distance[k]), float(cubic_value(road_map.elevation, index[k : k + 1], s[k : k + 1])[0]))
        )
    return best[1]


CROSS = Case(
    {"w": (-200.0, 0.0), "m": (-100.0, 0.0), "o": (0.0, 0.0), "e": (200.0, 0.0), "n": (0.0, 200.0)},
    {1: ("w m o e", ""), 2: ("o n", "")},
)


def middle(case: Case) -> tuple[float, float]:
    """Return where the origin of the local frame lies in the case's own x and y, m."""
    xy = np.array(list(case.nodes.values()))
    x, y = (xy.min(axis=0) + xy.max(axis=0)) / 2
    return float(x), float(y)


@pytest.mark.parametrize("name", ["m", "o", "e"])
def test_a_road_is_at_the_height_that_is_known(name: str) -> None:
    """Along a road, in a junction, and at a free end."""
    x0, y0 = middle(CROSS)
    x, y = (a - b for a, b in zip(CROSS.nodes[name], (x0, y0), strict=True))
    usual = height_at(build_corrected(CROSS, surface=GROUND)[0], x, y)
    road_map, found = build_corrected(CROSS, nodes={name: NodeCorrection(z=usual + 1.5)}, surface=GROUND)
    assert height_at(road_map, x, y) == pytest.approx(usual + 1.5, abs=0.1)
    # Far from there nothing has changed.
    far = height_at(road_map, -195.0 - x0, -y0)
    assert far == pytest.approx(height_at(build_corrected(CROSS, surface=GROUND)[0], -195.0 - x0, -y0), abs=0.15)
    ((about, (applied, words)),) = said(found).items()
    assert about == (f"node/{node_of(CROSS, name)}", "z")
    assert applied
    assert float(words.removeprefix("the road is at ").removesuffix(" m there")) == pytest.approx(
        usual + 1.5, abs=0.03
    )


def test_a_height_that_no_road_can_have_is_not_reached() -> None:
    road_map, found = build_corrected(CROSS, nodes={"m": NodeCorrection(z=300.0)}, surface=GROUND)
    assert road_map.statistics["grade_max"] < 0.4
    applied, text = said(found)[f"node/{node_of(CROSS, 'm')}", "z"]
    assert not applied
    assert text.endswith("m there instead of 300.00 m, which would be too steep")


def test_heights_of_nodes_without_a_road_and_on_level_ground_match_nothing() -> None:
    known = {"m": NodeCorrection(z=5.0)}
    _, found = build_corrected(CROSS, nodes=known)
    assert said(found) == {("node/1002", "z"): (False, "all ground is at one height; give an elevation model")}
    apart = Case({**CROSS.nodes, "x": (400.0, 0.0)}, CROSS.ways)
    _, found = build_corrected(apart, nodes={"x": NodeCorrection(z=105.0)}, surface=GROUND)
    assert said(found) == {("node/1006", "z"): (False, "no road passes it")}


BRIDGE = Case(
    {
        "w": (-300.0, 0.0),
        "a": (-40.0, 0.0),
        "b": (40.0, 0.0),
        "e": (300.0, 0.0),
        "s": (0.0, -300.0),
        "n": (0.0, 300.0),
    },
    {1: ("w a", ""), 2: ("a b", "bridge=yes layer=1"), 3: ("b e", ""), 4: ("s n", "")},
)


def gap(road_map: RoadMap) -> float:
    """Return the height between the two roads that cross, m."""
    heights = {}
    for k, road in enumerate(road_map.roads):
        s = np.linspace(0.0, float(lengths(road_map.plan_view)[k]), 400)
        index = np.full(len(s), k)
        x, y, _ = pose(road_map.plan_view, index, s)
        at = int(np.argmin(np.hypot(x, y)))
        if np.hypot(x[at], y[at]) < 2.0:
            heights[2 in road.osm_way_ids] = float(
                cubic_value(road_map.elevation, index[at : at + 1], s[at : at + 1])[0]
            )
    return heights[True] - heights[False]


@pytest.mark.parametrize("way", [2, 4])
@pytest.mark.parametrize("wanted", [4.4, 7.0])
@pytest.mark.parametrize("surface", [None, GROUND])
def test_a_clearance_holds_over_and_under_the_way(way: int, wanted: float, surface: Ground | None) -> None:
    assert gap(build_corrected(BRIDGE, surface=surface)[0]) == pytest.approx(5.2, abs=0.3)
    road_map, found = build_corrected(BRIDGE, {way: WayCorrection(clearance=wanted)}, surface=surface)
    assert gap(road_map) == pytest.approx(wanted, abs=0.3)
    words = f"{wanted:g} m from road to road where others pass over or under it"
    assert said(found) == {(f"way/{way}", "clearance"): (True, words)}


def test_the_clearance_of_the_upper_way_counts() -> None:
    known = {2: WayCorrection(clearance=6.5), 4: WayCorrection(clearance=4.5)}
    road_map, found = build_corrected(BRIDGE, known, surface=GROUND)
    assert gap(road_map) == pytest.approx(6.5, abs=0.3)
    assert {element: applied for (element, _), (applied, _) in said(found).items()} == {"way/2": True, "way/4": False}


@pytest.mark.parametrize(("way", "why"), [(1, "no road passes over or under it"), (9, "no road is made of it")])
@pytest.mark.parametrize("surface", [None, GROUND])
def test_a_clearance_without_a_crossing_matches_nothing(way: int, why: str, surface: Ground | None) -> None:
    _, found = build_corrected(BRIDGE, {way: WayCorrection(clearance=6.0)}, surface=surface)
    applied, text = said(found)[f"way/{way}", "clearance"]
    assert not applied
    assert text.startswith(why)

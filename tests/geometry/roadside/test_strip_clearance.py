"""Strips give way to other carriageways and in bends."""

from __future__ import annotations

import pytest
from margin_cases import BOTH, VERGE, WALK, built, by_id, sections_of
from road_measures import assert_sound, lane_edges, width_at
from street_cases import Case

from osm2xodr.curves.plan_views import lengths
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.defaults import PARALLEL_SPACING
from osm2xodr.geometry.roadside import defaults


def test_strips_end_beside_a_carriageway_that_runs_along() -> None:
    """A service road runs 7 m off the middle of a street from x = 150 to 250 m: 0.25 m are left between them."""
    nodes = {"w": (0.0, 0.0), "e": (400.0, 0.0), "a": (150.0, -7.0), "b": (250.0, -7.0)}
    case = Case(nodes, {1: ("w e", "lanes=2 width=8"), 2: ("a b", "highway=service lanes=1 width=5")})
    diagnostics = Diagnostics()
    roads = built(case, {1: BOTH}, diagnostics=diagnostics)
    assert_sound(roads)
    (section,) = sections_of(roads)
    lanes = by_id(section)
    around = defaults.MARGIN_CLEARANCE + PARALLEL_SPACING
    taper = defaults.MARGIN_TAPER_LENGTH
    places = (100.0, 150.0 - around - taper, 150.0, 200.0, 250.0, 250.0 + around + taper, 300.0)
    assert [width_at(lanes[-2].widths, s) for s in places] == [2.0, 2.0, 0.0, 0.0, 0.0, 2.0, 2.0]
    assert [width_at(lanes[2].widths, s) for s in places] == [2.0] * len(places)
    assert [(item.code, item.osm_id) for item in diagnostics if item.code == "margin-no-room"] == [
        ("margin-no-room", "way/1")
    ]


def test_strips_become_narrower_where_half_of_them_has_room() -> None:
    """1.3 m are left between the carriageways, with the gap that stays between them."""
    nodes = {"w": (0.0, 0.0), "e": (400.0, 0.0), "a": (0.0, -8.0), "b": (400.0, -8.0)}
    case = Case(
        nodes,
        {
            1: ("w e", "lanes=2 width:lanes:forward=4 width:lanes:backward=4"),
            2: ("a b", "highway=service lanes=1 width=5"),
        },
    )
    (section,) = sections_of(built(case, {1: BOTH}))
    assert width_at(by_id(section)[-2].widths, 100.0) == pytest.approx(1.3, abs=0.011)
    assert width_at(by_id(section)[2].widths, 100.0) == 2.0


def test_a_street_on_another_level_leaves_room() -> None:
    nodes = {"w": (0.0, 0.0), "e": (400.0, 0.0), "a": (100.0, -7.0), "b": (300.0, -7.0)}
    case = Case(nodes, {1: ("w e", "lanes=2 width=8"), 2: ("a b", "bridge=yes layer=1 lanes=1 width=5")})
    (section,) = sections_of(built(case, {1: BOTH}))
    assert sorted(by_id(section)) == [-2, -1, 0, 1, 2]


def test_strips_inside_of_tight_bends_do_not_fold() -> None:
    """A bend of 90 degrees so tight that 2 m inside of the carriageway do not fit; outside they do."""
    nodes = {"w": (-100.0, 0.0), "o": (0.0, 0.0), "n": (0.0, 100.0)}
    roads = built(
        Case(nodes, {1: ("w o n", "highway=service lanes=2 width=6")}), {1: (((VERGE, WALK, VERGE, WALK)), (WALK,))}
    )
    assert_sound(roads)
    plan = roads.plan_view
    (road,) = roads.roads
    ends = [*[section.s for section in road.lane_sections[1:]], float(lengths(plan)[0])]
    for s, length, curvature in zip(plan.s.tolist(), plan.length.tolist(), plan.curvature.tolist(), strict=True):
        if curvature <= 0:
            continue
        for section, end in zip(road.lane_sections, ends, strict=True):
            if section.s < s + length and end > s:
                outer = max(edges[1] for edges in lane_edges(section, (end - section.s) / 2, 0.0).values())
                assert outer <= 1 / curvature

"""Strips inside tight bends go on to where those of both legs meet."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from margin_cases import VERGE, WALK, Strips, built, by_id, sections_of
from road_measures import assert_sound, width_at
from street_cases import Case

from osm2xodr.curves import pose
from osm2xodr.curves.plan_views import lengths
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.junctions import RoadParts
from osm2xodr.geometry.roadside import defaults
from osm2xodr.geometry.roadside.strips import MarginStretch
from osm2xodr.geometry.roadside.tight_bends import TightBend, notches_in
from osm2xodr.model import FloatArray, LaneType, MarginSpec, PlanView, RoadMap

# A street that turns left by 90 and by 120 degrees.
_CORNER = {"w": (-100.0, 0.0), "o": (0.0, 0.0), "n": (0.0, 100.0)}
_ACUTE = {"w": (-100.0, 0.0), "o": (0.0, 0.0), "n": (-50.0, 86.6)}


def _street(nodes: dict[str, tuple[float, float]], left: Strips) -> tuple[RoadMap, Diagnostics]:
    diagnostics = Diagnostics()
    case = Case(nodes, {1: ("w o n", "highway=service lanes=2 width=6")})
    roads = built(case, {1: (left, ())}, diagnostics=diagnostics)
    assert_sound(roads)
    return roads, diagnostics


def _inside(roads: RoadMap, count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return places along the first road, s, m, the left edge there (n, 2) and the widths of strips (n, count), m."""
    (section,) = sections_of(roads)
    lanes = by_id(section)
    s = np.linspace(0.0, float(lengths(roads.plan_view)[0]), 2001)
    x, y, hdg = pose(roads.plan_view, np.zeros(len(s), np.int64), s)
    offset = np.array([width_at(lanes[1].widths, place) for place in s])
    edge = np.column_stack([x - offset * np.sin(hdg), y + offset * np.cos(hdg)])
    widths = np.array([[width_at(lanes[2 + k].widths, place) for k in range(count)] for place in s])
    return s, edge, widths


@pytest.mark.parametrize("nodes", [_CORNER, _ACUTE])
def test_a_sidewalk_goes_on_round_a_corner(nodes: dict[str, tuple[float, float]]) -> None:
    """It becomes narrower only where that of the other leg is, and never lies on that."""
    roads, diagnostics = _street(nodes, (WALK,))
    s, edge, widths = _inside(roads, 1)
    narrow = s[widths[:, 0] < 2.0 - 1e-9]
    assert 0.5 < narrow[-1] - narrow[0] < 14.0
    assert widths.min() >= 0.0
    # No place of the carriageway's edge is closer to a place of the sidewalk's outer edge than the one beside it.
    _, _, hdg = pose(roads.plan_view, np.zeros(len(s), np.int64), s)
    outer = edge + widths * np.column_stack([-np.sin(hdg), np.cos(hdg)])
    nearest = np.sqrt(((outer[:, None, :] - edge[None, :, :]) ** 2).sum(2)).min(1)
    assert (nearest >= widths[:, 0] - 1e-3).all()
    assert [item.osm_id for item in diagnostics if item.code == "margin-no-room"] == ["way/1"]


def test_the_sidewalk_is_as_wide_in_the_bend_as_its_radius_allows() -> None:
    roads, _ = _street(_CORNER, (WALK,))
    _, _, widths = _inside(roads, 1)
    sharpest = float(roads.plan_view.curvature.max())
    room = 1.0 / sharpest - 3.0 - defaults.CORNER_EDGE_RADIUS
    assert 0.0 < room < 2.0
    assert widths.min() == pytest.approx(room, abs=0.05)


def test_the_outermost_strip_gives_way_first() -> None:
    """Verge and sidewalk: where the verge takes all the room, the sidewalk has no width."""
    roads, _ = _street(_ACUTE, (VERGE, WALK))
    _, _, alone = _inside(_street(_ACUTE, (WALK,))[0], 1)
    _, _, widths = _inside(roads, 2)
    assert alone.min() < 1.0
    assert widths[:, 0].min() == pytest.approx(alone.min(), abs=0.05)
    assert widths[:, 1].min() == 0.0
    assert (widths[[0, -1]] == [1.0, 2.0]).all()


def test_a_bend_of_less_than_a_metre_is_narrow_from_end_to_end() -> None:
    """Eight degrees of 4.25 m between straight lines: half of its places lie a quarter of a metre apart."""
    radius, turned = 4.25, 0.14
    bend_m = radius * turned
    begin = 10.1
    x, y = begin + radius * np.sin(turned), -radius * (1.0 - np.cos(turned))
    plan = PlanView(
        np.array([0, 3]),
        np.array([0.0, begin, begin + bend_m]),
        np.array([0.0, begin, x]),
        np.array([0.0, 0.0, y]),
        np.array([0.0, 0.0, -turned]),
        np.array([begin, bend_m, 10.0]),
        np.array([0.0, -1.0 / radius, 0.0]),
    )
    strips = (MarginSpec(LaneType.PARKING, 2.0), WALK)
    room = radius - 2.75 - defaults.CORNER_EDGE_RADIUS
    bend = TightBend(0, begin, begin + bend_m, -1, 2.75, room)
    parts = cast(RoadParts, SimpleNamespace(plan_view=plan, length=lengths(plan)))
    beside = (MarginStretch(0.0, float(lengths(plan)[0]), (), strips, 1),)
    notches, others = notches_in(parts, [bend], [beside])
    (notch,) = notches[0]
    assert others == []
    assert [notch.reach_at(s) for s in np.linspace(begin, begin + bend_m, 20).tolist()] == pytest.approx([room] * 20)
